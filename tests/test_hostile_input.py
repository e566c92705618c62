"""Whatever a file or the command line holds, it is used or refused in one line.

The targets are settings, ground truth and the words of a command.
"""

import json
import tempfile
from contextlib import contextmanager, suppress
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from mkt.checks import LONGEST
from mkt.course import cli
from mkt.own_video.settings import Settings, load, numbers_of, settled
from mkt.regions import HX, HY
from mkt.sequences.mot import mot_main
from mkt.sequences.truth_formats import bobot, otb, vot
from mkt.trackers import by_name
from tests.own_video import films
from tests.sequences.written import WIDTH, numbers, write_images

FIGURE = "teuliere2009.fig2"
BOX = (55.0, 48.0, 50.0, 24.0, 0.0)
# The folder of a test is the same for all of its examples, each of which writes anew.
SAME_FOLDER = settings(
    deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

ANY_NUMBER = st.one_of(
    st.integers(),
    st.floats(),
    st.sampled_from([10**400, 1e300, -1e300, 1e18, 10**18, 5e-324]),
)
ANY_NAME = st.one_of(
    st.text(max_size=9),
    st.sampled_from(["~nosuch/x.mkv", "caf\udce9.mkv", "a\0b", "/proc/self/mem", "."]),
)
ANY_JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), ANY_NUMBER, ANY_NAME),
    lambda inner: st.one_of(
        st.lists(inner, max_size=5), st.dictionaries(st.text(max_size=9), inner)
    ),
    max_leaves=9,
)


@contextmanager
def used_or_refused():
    """Check that an error is one of those for users, on one line."""
    try:
        yield
    except (ValueError, OSError) as error:
        assert len(str(error).splitlines()) == 1


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    """A video of three frames."""
    path = tmp_path_factory.mktemp("video") / "car.mkv"
    return films.write(path, films.driving(3).frames)


# Settings


def changes():
    """Entries of a settings file that differ from those of a good one."""
    names = st.sampled_from([*Settings.__dataclass_fields__, "more"])
    return st.dictionaries(names, ANY_JSON, max_size=3)


def used(path):
    """Do with a settings file what `track --settings` does before it writes."""
    with used_or_refused():
        chosen = load(path)
        chosen.configured()
        chosen.sequence()


@pytest.mark.slow
@SAME_FOLDER
@given(changes=changes())
@example(changes={"every": 10**400})
def test_settings_with_any_entries(car, tmp_path, changes):
    path = tmp_path / "x.json"
    values = asdict(settled(car, BOX, "ssd")) | changes
    path.write_text(json.dumps(values))
    used(path)


@SAME_FOLDER
@given(
    name=st.sampled_from([*by_name.TRACKERS]),
    values=st.lists(ANY_NUMBER, min_size=15, max_size=15),
)
def test_settings_with_any_numbers(car, tmp_path, name, values):
    path = tmp_path / "x.json"
    known = numbers_of(by_name.TRACKERS[name])
    changed = dict(zip(known, values, strict=False))
    good = asdict(settled(car, BOX, name))
    path.write_text(json.dumps(good | {"numbers": changed}))
    used(path)


@SAME_FOLDER
@given(content=st.one_of(st.binary(), st.text(st.sampled_from('[]{}",:0e9 \n'))))
def test_settings_of_any_content(tmp_path, content):
    path = tmp_path / "x.json"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    used(path)


# Ground truth

FOLDERS = {
    otb: ("groundtruth_rect.txt", "img"),
    vot: ("groundtruth.txt", "color"),
    bobot: ("truth.txt", "frames"),
    mot_main: ("gt/gt.txt", "img1"),
}
COORDINATES = st.one_of(
    st.integers(-5, WIDTH), st.floats(), st.sampled_from([1e9, 1e300, -1e300])
)


@st.composite
def rows(draw):
    """Lines of as many numbers as some format has, and now and then of something."""
    width = draw(st.sampled_from([4, 5, 8, 9, 10]))
    separator = draw(st.sampled_from([",", " ", "\t", ";", ", "]))
    row = st.lists(COORDINATES, min_size=width, max_size=width)
    line = st.one_of(row.map(lambda row: numbers(row, separator)), st.text(max_size=9))
    return "\n".join(draw(st.lists(line, max_size=4))).encode("utf-8", "replace")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A folder with three frames for each format, without its truth."""
    places = {read: tmp_path_factory.mktemp(read.__name__) for read in FOLDERS}
    for read, place in places.items():
        truth, images = FOLDERS[read]
        (place / truth).parent.mkdir(exist_ok=True)
        write_images(place / images, 3)
    return places


@pytest.mark.parametrize("read", FOLDERS)
@given(content=st.one_of(st.binary(), rows()))
def test_ground_truth_of_any_content(folders, read, content):
    (folders[read] / FOLDERS[read][0]).write_bytes(content)
    with used_or_refused():
        half_axes = read(folders[read]).truth[:, [HX, HY]]
        shown = half_axes[~np.isnan(half_axes)]
        assert ((shown > 0) & (shown <= LONGEST)).all()


# The command line

GOOD = {
    "--box": ["9,9,20,20", "9,9,20,20,30", "0,0,1e-9,1e-9"],
    "--tracker": ["ssd", "camshift", "mil"],
    "--particles": ["1", "100000", "100001"],
    "--seed": ["1"],
    "-o": ["x.avi", "x.webm", "no/x.mkv"],
    "--settings": ["x.json"],
    "--scale": ["0.5", "1e-9"],
}
LIST = st.lists(ANY_NUMBER, max_size=6).map(lambda row: ",".join(map(str, row)))
# A line break that somebody typed stays one in the message.
ON_ONE_LINE = ANY_NAME.map(lambda name: " ".join(name.splitlines()))
ANY_WORD = st.one_of(ON_ONE_LINE, LIST, ANY_NUMBER.map(str))


def pairs():
    """Options with their words, {option: word}, good ones and others."""
    known = {
        name: st.one_of(st.sampled_from(good), ANY_WORD) for name, good in GOOD.items()
    }
    return st.fixed_dictionaries({}, optional=known)


@contextmanager
def said_in_one_line(folder):
    """Check that a command ends, if not well, in one line that is no fault of ours."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(tempfile, "tempdir", str(folder))
        try:
            yield
        except SystemExit as stopped:
            said = str(stopped.code)
            assert len(said.splitlines()) == 1 and "fault of mkt" not in said


@SAME_FOLDER
@given(video=st.one_of(st.just("CAR"), ANY_WORD), options=pairs())
@example(video="1" * 400, options={})  # longer than a file's name can be
def test_track_with_any_words(car, tmp_path, video, options):
    video = str(car) if video == "CAR" else video
    words = [f"{name}={word}" for name, word in options.items() if name != "-o"]
    words += [f"-o{word}" for name, word in options.items() if name == "-o"]
    with said_in_one_line(tmp_path):
        cli.run(cli.parse(["track", *words, "--", video]))


@SAME_FOLDER
@given(id=st.one_of(st.just(FIGURE), ANY_WORD), name=ANY_WORD, value=ANY_WORD)
def test_figure_with_any_words(tmp_path, id, name, value):
    words = ["-ox.csv", "--set", f"{name}={value}", "--", id]
    with said_in_one_line(tmp_path):
        cli.run(cli.parse(["figure", *words]))


@pytest.mark.slow
@settings(SAME_FOLDER, max_examples=25)  # each draws a figure
@given(value=ANY_WORD)
def test_a_figure_with_any_value(tmp_path, value):
    words = ["figure", FIGURE, "-ox.csv", "--set", f"span={value}"]
    with said_in_one_line(tmp_path):
        cli.run(cli.parse(words))


@given(words=st.lists(st.one_of(ANY_WORD, st.sampled_from([*GOOD])), max_size=6))
def test_any_words_are_parsed_or_refused(words):
    with suppress(SystemExit):  # after argparse's usage and a line
        cli.parse(words)
