"""The command `track`: a file in, an annotated video and a table out.

Mistakes are answered in a sentence, and one frame at a time is in memory.
"""

import csv
import gc
import json
import subprocess
import sys
import weakref
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from mkt.course import cli
from mkt.evaluation import overlap
from mkt.files import ROOT
from mkt.own_video import overlay, recording
from mkt.own_video.settings import Settings, settled
from mkt.plotting import CURRENT, DESIRED
from mkt.regions import corners, from_box, to_box, warp
from mkt.sequences.truth_formats import video
from mkt.sequences.video import VideoFile
from mkt.sequences.writing import Writer
from mkt.trackers import by_name
from mkt.tracking import Sequence, report
from tests.own_video import films

LENGTH = 8
GREEN, RED = (tuple(bytes.fromhex(color[1:])) for color in (CURRENT, DESIRED))


@pytest.fixture(scope="module")
def clip():
    """The car driving over gravel, turned by 30 degrees."""
    return films.driving(LENGTH, last=10.0, degrees=30)


@pytest.fixture(scope="module")
def box(clip):
    """The truth of the first frame as the command takes it."""
    region = clip.truth[0]
    x, y, w, h = to_box([*region[:2], 0.0, *region[3:]])
    return f"{x:g},{y:g},{w:g},{h:g},30"


@pytest.fixture(scope="module")
def file(clip, tmp_path_factory):
    """The clip as a video."""
    return films.write(tmp_path_factory.mktemp("video") / "car.mkv", clip.frames)


def run(*words):
    """Run the command; returns its exit code, 0 for None."""
    return cli.run(cli.parse(["track", *map(str, words)])) or 0


def table(path):
    with path.open(newline="") as lines:
        return list(csv.DictReader(lines))


def regions_in(rows):
    names = recording.COLUMNS[1:6]
    numbers = np.array([[float(row[name]) for name in names] for row in rows])
    numbers[:, 2] = np.radians(numbers[:, 2])
    return numbers


def near(image, points, color, tolerance=40):
    """Share of the points (n, 2) [px] with a pixel of the colour within a pixel."""
    found = np.abs(image.astype(int) - color).max(-1) < tolerance
    found = cv2.dilate(found.astype(np.uint8), np.ones((3, 3)))
    x, y = np.rint(points).astype(int).T
    return found[y, x].mean()


def outline(region, n=40):
    """Points (4 n, 2) on the four sides of a region."""
    c = corners(region)
    t = np.linspace(0, 1, n)[:, None]
    sides = zip(c, np.roll(c, -1, 0), strict=True)
    return np.concatenate([a + t * (b - a) for a, b in sides])


@pytest.mark.parametrize("ending", [".mkv", ".avi", ".webm"])
def test_a_file_becomes_an_annotated_video_and_a_table(
    ending, file, clip, box, tmp_path, capfd
):
    output = tmp_path / f"found{ending}"
    assert run(file, "--box", box, "--tracker", "ssd", "-o", output) == 0
    said = capfd.readouterr()
    files = [str(output.with_suffix(kind)) for kind in (ending, ".csv", ".json")]
    assert said.out.split() == files
    assert "FFMPEG" not in said.err
    written = VideoFile(output)
    rows = table(output.with_suffix(".csv"))
    assert len(written) == len(rows) == LENGTH
    assert written[0].shape == (120, 160, 3)
    assert written.fps == pytest.approx(30, rel=0.01)
    assert [int(row["frame"]) for row in rows] == list(range(LENGTH))
    assert {row["lost"] for row in rows} == {"0"}
    regions = regions_in(rows)
    assert overlap(regions, clip.truth).min() > 0.8
    if ending == ".mkv":  # lossless
        for frame, plain, region in zip(written, clip.frames, regions, strict=True):
            assert near(frame, outline(region), GREEN) > 0.95
            assert near(plain, outline(region), GREEN) < 0.2


def test_a_folder_of_images_the_default_names_and_particles(
    clip, box, tmp_path, monkeypatch
):
    asked = []

    def with_particles(name, n):
        asked.append((name, n))
        return by_name.TRACKERS[name]

    monkeypatch.setattr(by_name, "with_particles", with_particles)
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "images"
    folder.mkdir()
    for k in range(3):
        cv2.imwrite(str(folder / f"{k}.png"), clip.frames[k][..., ::-1])
    assert run(folder, "--box", box, "--tracker", "pf-75", "--particles", 30) == 0
    assert set(asked) == {("pf-75", 30)}
    assert sorted(path.name for path in tmp_path.glob("images-pf-75.*")) == [
        "images-pf-75.csv",
        "images-pf-75.json",
        "images-pf-75.webm",
    ]


def test_nothing_is_written_among_the_images(tmp_path):
    said = "the folder of the images to be tracked; choose another place"
    with pytest.raises(ValueError, match=said):
        recording.checked_output(tmp_path / "found.webm", tmp_path)


def test_the_same_seed_gives_the_same_table(file, box, tmp_path):
    command = file, "--box", box, "--tracker", "pf-75"
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        run(*command, "--seed", seed, "-o", tmp_path / f"{name}.avi")
    a, b, c = ((tmp_path / f"{name}.csv").read_text() for name in "abc")
    assert a == b != c


def test_lost_looks_different():
    frame = np.full((120, 160, 3), 200, np.uint8)
    region = np.array([80.0, 60, 0.4, 40, 20])
    seen, lost = (
        overlay.annotated(frame, {"region": region, "lost": lost}, "7 ssd")
        for lost in (False, True)
    )
    points = outline(region)
    assert near(seen, points, GREEN) > 0.98 and near(seen, points, RED) == 0
    assert 0.4 < near(lost, points, RED) < 0.95 and near(lost, points, GREEN) == 0
    assert (frame == 200).all()
    assert (seen[105:, :60] != 200).any()
    assert (seen[105:, :60] != lost[105:, :60]).any()


def test_a_tick_shows_which_side_is_the_right_one():
    frame = np.full((120, 160, 3), 200, np.uint8)
    region = np.array([80.0, 60, 0.4, 40, 20])
    image = overlay.annotated(frame, {"region": region, "lost": False}, "")
    away = np.linspace(0.3, 0.7, 20)[:, None]
    right, *others = (
        near(image, warp(region, away * side), GREEN)
        for side in ([(1, 0)], [(0, 1)], [(-1, 0)], [(0, -1)])
    )
    assert right > 0.98 and max(others) == 0


@pytest.mark.parametrize(
    "region",
    [(-500.0, 60, 0.4, 40, 20), (80.0, 60, 0.4, 1e9, 20), (np.nan, 60, 0, 4, 2)],
)
def test_regions_far_off_can_be_drawn(region):
    frame = np.zeros((120, 160, 3), np.uint8)
    drawn = overlay.annotated(frame, {"region": np.array(region), "lost": True}, "")
    assert drawn.shape == frame.shape and drawn.dtype == np.uint8


WITH_BOX = ("FILE", "--box", "9,9,20,20")
MISTAKES = [
    (("none.mp4",), "none.mp4: no such file; check the spelling"),
    (
        ("FILE", "--tracker", "best"),
        f"no tracker 'best'; there are {', '.join(by_name.TRACKERS)}",
    ),
    (
        ("FILE", "--tracker", "ssd", "--particles", "9"),
        "the tracker 'ssd' has no particles; leave their number out, "
        "or choose one of pf-1",
    ),
    (("FILE", "--particles", "0"), "particles is 0; there must be at least 1"),
    (("FILE", "--particles", "2000000"), "n is 2000000; it must be a whole number"),
    (("FILE", "--particles", "9" * 20), "at least 1 and at most 100000"),
    (
        ("FILE", "--box", "1,2,3"),
        "--box 1,2,3: give four or five numbers x,y,w,h[,angle]",
    ),
    (("FILE", "--box", "a,b,c,d"), "--box a,b,c,d: give four or five numbers"),
    (("FILE", "--box", "nan,2,3,4"), "--box nan,2,3,4: give four or five numbers"),
    (
        ("FILE", "--box", "9,9,0,5"),
        "the box 9,9,0,5,0: its width or height is zero or negative; "
        "give x,y,w,h, not two corners",
    ),
    (
        ("FILE", "--box", "0,0,1e-9,1e-9"),
        "the box 0,0,1e-09,1e-09,0: its width or height is less than a pixel",
    ),
    (
        ("FILE", "--box", "160,9,5,5"),
        "the box 160,9,5,5,0: it lies outside the image of 160x120 px",
    ),
    (
        ("FILE", "--box", "150,9,40,20", "--tracker", "ssd"),
        "the box 150,9,40,20,0: part of the region (169.5, 18.5, 0, 20, 10) lies "
        "outside the image; choose a box inside it",
    ),
    (
        (*WITH_BOX, "-o", "x.gif"),
        "-o x.gif: cannot write .gif; choose one of .webm, .mkv, .avi",
    ),
    ((*WITH_BOX, "-o", "x"), "cannot write a file without an extension"),
    (
        (*WITH_BOX, "-o", "no/x.avi"),
        "-o no/x.avi: no folder no; create it, or choose another",
    ),
    (
        (*WITH_BOX, "-o", "FILE"),
        "car.mkv is there already and stays as it is; move it away, or choose another",
    ),
    (("",), "'': an empty name; is a variable of the shell empty?"),
    (("~nosuch/x.mkv",), "~nosuch/x.mkv: no such home folder; check the spelling"),
    ((*WITH_BOX, "-o", "~nosuch/x.avi"), "~nosuch/x.avi: no such home folder; check"),
    (("--settings", "~nosuch/s.json"), "~nosuch/s.json: no such home folder; check"),
    (("caf\udce9.mkv",), r"caf\udce9.mkv: the name is not UTF-8; rename it"),
    (
        (*WITH_BOX, "-o", "caf\udce9.mkv"),
        r"caf\udce9.mkv: the name is not UTF-8; rename it",
    ),
]


@pytest.mark.parametrize("words, said", MISTAKES)
def test_a_mistake_is_answered_in_a_sentence_and_nothing_is_written(
    words, said, file, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    before = file.read_bytes()
    with pytest.raises(SystemExit) as stopped:
        run(*(file if word == "FILE" else word for word in words))
    assert stopped.value.code.startswith("mkt track: ")
    assert said in stopped.value.code
    assert not list(tmp_path.iterdir()) and file.read_bytes() == before


@pytest.mark.parametrize("box", [(), ("--box", "9,9,20,20")])
def test_a_loop_of_links_is_no_video(box, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.mkv").symlink_to("loop.mkv")
    with pytest.raises(SystemExit, match="loop.mkv: no such file; check the spelling"):
        run("loop.mkv", *box)


@pytest.mark.slow
@pytest.mark.parametrize("start", [b"\x1aE\xdf\xa3", b"RIFF", b"nonsense"])
def test_what_is_no_video_is_said_by_us_alone(start, tmp_path):
    (tmp_path / "x.mkv").write_bytes(start + bytes(500))
    done = subprocess.run(
        [sys.executable, "-m", "mkt", "track", tmp_path / "x.mkv"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )
    [line] = done.stderr.splitlines()
    assert "x.mkv: not a video, or cut short; download it again" in line


@pytest.mark.parametrize("ending", [".avi", ".csv", ".json"])
def test_files_that_are_there_stay_as_they_are(ending, file, box, tmp_path):
    (tmp_path / f"x{ending}").write_text("precious")
    with pytest.raises(SystemExit, match=f"x{ending} is there already and stays"):
        run(file, "--box", box, "-o", tmp_path / "x.avi")
    [only] = tmp_path.iterdir()
    assert only.read_text() == "precious"


@pytest.mark.parametrize("link", ["hardlink_to", "symlink_to"])
def test_the_source_is_known_under_another_name(link, file, box, tmp_path):
    before = file.read_bytes()
    getattr(tmp_path / "copy.mkv", link)(file)
    with pytest.raises(SystemExit, match="copy.mkv is there already"):
        run(file, "--box", box, "-o", tmp_path / "copy.mkv")
    assert file.read_bytes() == before


def test_a_link_to_nowhere_is_not_written_through(file, box, tmp_path):
    (tmp_path / "x.csv").symlink_to(tmp_path / "elsewhere.csv")
    with pytest.raises(SystemExit, match="x.csv is there already"):
        run(file, "--box", box, "-o", tmp_path / "x.avi")
    assert not (tmp_path / "elsewhere.csv").exists()


def test_a_link_to_the_folder_of_images_is_that_folder(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "images")
    with pytest.raises(ValueError, match="the folder of the images to be tracked"):
        recording.checked_output(tmp_path / "link" / "x.avi", tmp_path / "images")


def contents(folder):
    """The files in a folder, {path: bytes}."""
    return {path: path.read_bytes() for path in folder.iterdir()}


def test_of_two_runs_under_one_name_at_once_the_second_is_refused(
    tmp_path, monkeypatch
):
    record(Still(), 3, tmp_path / "x.avi")
    before = contents(tmp_path)
    # It looked before the first one had begun.
    monkeypatch.setattr(recording, "files_there", lambda output: [])
    with pytest.raises(OSError, match="x.csv cannot be written: File exists"):
        record(Still(), 3, tmp_path / "x.avi")
    assert contents(tmp_path) == before


def test_a_program_that_records_into_its_own_source_is_refused(clip, tmp_path):
    source = films.write(tmp_path / "car.avi", clip.frames)
    before = contents(tmp_path)
    with pytest.raises(FileExistsError, match="car.avi is there already and stays"):
        recording.record(Still(), video(source, [55, 48, 50, 24]), source)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("taken", ["x.webm", "x.csv", "x.json"])
def test_a_program_overwrites_nothing(taken, tmp_path):
    (tmp_path / taken).write_text("precious")
    with pytest.raises(FileExistsError, match=f"{taken} is there .* another name"):
        record(Still(), 3, tmp_path / "x.webm")
    assert contents(tmp_path) == {tmp_path / taken: b"precious"}


@pytest.mark.parametrize("ending", [".webm", ".mp4"])
def test_a_film_that_cannot_begin_leaves_nothing_in_the_way_of_the_next_try(
    ending, tmp_path
):
    wide = np.zeros((8, 17_000, 3), np.uint8)
    sequence = replace(still_clip(1), frames=[wide])
    with pytest.raises(OSError, match=f"x{ending}: .*17000x8 px; choose .avi or .mkv"):
        recording.record(Still(), sequence, tmp_path / f"x{ending}", settings=CHOSEN)
    assert not contents(tmp_path)
    recording.record(Still(), sequence, tmp_path / "x.avi", settings=CHOSEN)
    assert len(contents(tmp_path)) == 3


def test_a_second_run_takes_the_next_name(file, box, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("car-ssd.webm", "car-ssd-2.webm"):
        assert run(file, "--box", box, "--tracker", "ssd") == 0
        assert capsys.readouterr().out.split()[0] == name
    first, second = (json.loads(p.read_text()) for p in tmp_path.glob("*.json"))
    assert first == second


@pytest.mark.parametrize("name", ["~car.mkv", "~nobody.mkv", "~.mkv"])
def test_a_film_whose_name_looks_like_a_home_is_followed_here(
    name, file, box, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    Path(name).write_bytes(file.read_bytes())
    assert run(name) == 2
    assert run(name, "--box", box, "--tracker", "ssd") == 0
    written = capsys.readouterr().out.split()
    assert len(written) == 3 and all((tmp_path / one).is_file() for one in written)


def test_a_place_that_cannot_be_written_is_named(file, box, tmp_path, monkeypatch):
    def nowhere(*_):
        raise OSError("x.avi: cannot be written; is the folder writable?")

    monkeypatch.setattr(recording, "video_writer", nowhere)
    with pytest.raises(SystemExit) as stopped:
        run(file, "--box", box, "-o", tmp_path / "x.avi")
    assert "x.avi: cannot be written" in stopped.value.code


def test_without_a_box_the_first_frame_is_shown_under_a_grid(file, tmp_path, capsys):
    assert run(file, "-o", tmp_path / "found.webm") == 2
    path = tmp_path / "found-first-frame.png"
    said = capsys.readouterr().err
    assert str(path) in said and "--box x,y,w,h" in said
    assert list(tmp_path.iterdir()) == [path]
    assert cv2.imread(str(path)).shape[1] == 1200


def test_a_first_frame_takes_the_next_name_as_a_film_does(file, tmp_path):
    taken = tmp_path / "found-first-frame.png"
    taken.write_text("precious")
    said = recording.ask_for_box(video(file), tmp_path / "found.webm")
    assert str(tmp_path / "found-first-frame-2.png") in said
    assert taken.read_text() == "precious" and len(contents(tmp_path)) == 2


def test_a_video_may_lie_at_home(file, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(file.parent))
    monkeypatch.setenv("USERPROFILE", str(file.parent))
    assert run("~/car.mkv", "-o", tmp_path / "found.webm") == 2


def test_the_grid_is_labelled_in_the_coordinates_of_a_box(clip):
    ax = overlay.pixel_grid(clip.frames[0]).axes[0]
    labels = [tick.get_text() for tick in ax.get_xticklabels()]
    assert labels[:17] == [str(x) for x in range(0, 161, 10)]
    assert ax.images[0].get_extent() == [0, 160, 120, 0]


@pytest.mark.parametrize("size", [(64, 48), (1920, 1080), (1080, 1920)])
def test_the_grid_stays_readable_at_any_size(size):
    ax = overlay.pixel_grid(np.zeros((*size[::-1], 3), np.uint8)).axes[0]
    assert 4 <= max(len(ax.get_xticks()), len(ax.get_yticks())) <= 25


@dataclass(frozen=True)
class Still:
    """A tracker that answers where it was told, with heavy infos.

    At frame `length` there is trouble: it is interrupted, or breaks.
    """

    length: int | None = None
    trouble: type[BaseException] = KeyboardInterrupt
    made: list[Any] = field(default_factory=list)

    def init(self, frame, region, rng):
        return region, 1

    def step(self, state, frame, rng):
        region, k = state
        if k == self.length:
            raise self.trouble
        heavy = np.zeros(1000)
        self.made.append(weakref.ref(heavy))
        info = {"region": region, "score": 0.5, "lost": False, "heavy": heavy}
        return (region, k + 1), info


CHOSEN = Settings("still", "of no file", (10, 10, 20, 20, 0), "still")


def still_clip(length):
    frames = [np.full((48, 64, 3), k % 256, np.uint8) for k in range(length)]
    truth = np.tile(from_box([10, 10, 20, 20]), (length, 1))
    return Sequence("still", frames, truth, np.ones(length))


def record(tracker, length, output):
    """Track in a still clip and write the files; returns how many frames there are."""
    return recording.record(tracker, still_clip(length), output, settings=CHOSEN)


def test_a_program_may_write_film_and_table_at_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    record(Still(), 3, Path("~/x.avi"))
    assert {path.name for path in contents(tmp_path)} == {"x.avi", "x.csv", "x.json"}


def test_nothing_is_accumulated(tmp_path, monkeypatch):
    tracker = Still()
    alive = []
    rows_of = recording.rows_of

    def counting(*told):
        alive.append(sum(reference() is not None for reference in tracker.made))
        return rows_of(*told)

    monkeypatch.setattr(recording, "rows_of", counting)
    assert record(tracker, 60, tmp_path / "x.avi") == 60
    gc.collect()
    assert len(tracker.made) == 59
    assert len(alive) == 60 and max(alive) <= 2


@pytest.mark.parametrize("ending, where", [(".webm", "both"), (".csv", "the table")])
def test_an_interruption_keeps_what_was_done(
    ending, where, file, box, tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(by_name.TRACKERS._entries, "still", Still(5))
    output = tmp_path / f"x{ending}"
    assert run(file, "--box", box, "--tracker", "still", "-o", output) == 130
    said = capsys.readouterr().err
    assert f"stopped: 5 of 8 frames are in {where}, up to frame 4" in said
    assert len(table(tmp_path / "x.csv")) == 5
    assert ending == ".csv" or len(VideoFile(output)) == 5


def test_an_interruption_before_the_first_frame_leaves_nothing(
    file, box, tmp_path, monkeypatch, capsys
):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(recording.Recorder, "add", stopped)
    assert run(file, "--box", box, "-o", tmp_path / "x.csv") == 130
    assert "before the first frame: nothing was written" in capsys.readouterr().err
    assert not list(tmp_path.glob("x*"))


def test_files_are_closed_when_something_breaks(tmp_path):
    broken = Still(5, ZeroDivisionError)
    with pytest.raises(ZeroDivisionError):
        record(broken, 9, tmp_path / "x.avi")
    assert len(VideoFile(tmp_path / "x.avi")) == len(table(tmp_path / "x.csv")) == 5


def test_a_single_frame_that_was_lost_on_the_way_is_said(tmp_path, monkeypatch):
    write, numbers = Writer.write, count()

    def forgetful(self, picture):
        if next(numbers) != 4:
            write(self, picture)

    monkeypatch.setattr(Writer, "write", forgetful)
    with pytest.raises(OSError, match="only 8 of 9 frames could be written"):
        record(Still(), 9, tmp_path / "x.avi")


@pytest.mark.parametrize("ending", [".csv", ".txt"])
def test_a_table_alone_says_what_the_one_beside_a_film_says(
    ending, file, box, tmp_path
):
    words = (file, "--box", box, "--tracker", "ssd")
    run(*words, "-o", tmp_path / "film.mkv")
    run(*words, "-o", tmp_path / f"alone{ending}")
    names = {path.name for path in tmp_path.glob("alone*")}
    assert names == {f"alone{ending}", "alone.json"}
    rows = table(tmp_path / "film.csv")
    if ending == ".csv":
        assert table(tmp_path / "alone.csv") == rows
        return
    mot = np.loadtxt(tmp_path / "alone.txt", delimiter=",")
    assert mot.shape == (LENGTH, 10) and mot[:, 0].tolist() == [*range(1, LENGTH + 1)]
    boxes = to_box(regions_in(rows))
    assert np.allclose(mot[:, 2:6], boxes + [1, 1, 0, 0], atol=2e-3)


@dataclass
class Absent:
    """A tracker that finds its target nowhere in every second frame."""

    def init(self, frame, region, rng):
        return region, 1

    def step(self, state, frame, rng):
        region, k = state
        found = region if k % 2 else np.full(5, np.nan)
        return (region, k + 1), {"region": found, "score": 1.0, "lost": False}


@pytest.mark.parametrize("ending, rows", [(".csv", 6), (".txt", 4)])
def test_mot_s_rows_leave_out_a_target_that_is_nowhere(tmp_path, ending, rows):
    record(Absent(), 6, tmp_path / f"x{ending}")
    text = (tmp_path / f"x{ending}").read_text()
    assert len(text.splitlines()) == rows + (ending == ".csv")
    assert ("nan" in text) == (ending == ".csv")


def test_a_part_is_tracked_by_the_numbers_of_its_frames(file, clip, tmp_path):
    region = clip.truth[2]
    x, y, w, h = to_box([*region[:2], 0.0, *region[3:]])
    box = f"{x:g},{y:g},{w:g},{h:g},{np.degrees(region[2]):g}"
    part = ("--from", 2, "--to", 6, "--every", 2)
    run(file, "--box", box, *part, "--tracker", "ssd", "-o", tmp_path / "a.mkv")
    rows = table(tmp_path / "a.csv")
    assert [row["frame"] for row in rows] == ["2", "4", "6"]
    film = VideoFile(tmp_path / "a.mkv")
    assert len(film) == 3 and film.fps == VideoFile(file).fps / 2  # as fast as life
    assert overlap(regions_in(rows), clip.truth[[2, 4, 6]]).min() > 0.7
    again = ("--settings", tmp_path / "a.json", "-o", tmp_path / "b.csv")
    run(*again)
    assert table(tmp_path / "b.csv") == rows


@pytest.mark.parametrize(
    "words, said",
    [
        (("--from", 9), "frames from 9 on: car has 0 to 7"),
        (("--to", 8), "frames 0 to 8: car has 0 to 7"),
        (("--from", 3, "--to", 2), "frames 3 to 2: car has 0 to 7"),
        (("--every", 8), "every 8-th frame: of 0 to 7 that is one alone"),
        (("--seed", "1", "--scale", 0.001), "leaves nothing of a frame"),
    ],
)
def test_frames_that_are_not_there_are_refused(words, said, file, box, tmp_path):
    with pytest.raises(SystemExit, match=said):
        run(file, "--box", box, *words, "-o", tmp_path / "a.csv")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(
    "words, said",
    [(("--from", 9), "from 9 on"), (("--from", 3, "--to", 2), "3 to 2")],
)
def test_frames_are_refused_before_a_box_is_asked_for(words, said, file, tmp_path):
    with pytest.raises(SystemExit, match=f"frames {said}: car has 0 to 7"):
        run(file, *words, "-o", tmp_path / "a.csv")
    assert not [*tmp_path.iterdir()]


def test_a_box_may_begin_outside_and_a_seed_may_not(file, tmp_path, capsys):
    words = ("--tracker", "guided", "-o", tmp_path / "a.csv")
    run(file, "--box", "-5,48,80,24", *words)
    assert len(table(tmp_path / "a.csv")) == 8
    with pytest.raises(SystemExit):
        run(file, "--box", "5,48,80,24", "--seed", "-1", *words)
    assert "-1 is no whole number from 0 on" in capsys.readouterr().err
    with pytest.raises(ValueError, match="^seed is -1"):
        settled(file, (5, 48, 80, 24, 0), seed=-1)


def test_a_place_without_a_known_ending_is_refused_to_a_program(clip):
    with pytest.raises(ValueError, match="cannot write a file without an extension"):
        record(Still(5), 9, Path("x"))


def test_on_smaller_frames_the_table_stays_in_pixels_of_the_video(
    file, box, clip, tmp_path
):
    words = ("--tracker", "ssd", "--scale", 0.5, "-o", tmp_path / "a.csv")
    run(file, "--box", box, *words)
    rows = table(tmp_path / "a.csv")
    assert overlap(regions_in(rows), clip.truth).min() > 0.7
    run("--settings", tmp_path / "a.json", "-o", tmp_path / "b.csv")
    assert table(tmp_path / "b.csv") == rows
    run(file, "--box", box, "--tracker", "ssd", "-o", tmp_path / "c.csv")
    assert table(tmp_path / "c.csv") != rows


@pytest.mark.parametrize("scale", ["0", "1.5", "nan", "half"])
def test_no_other_scale_is_taken(scale, file, box, capsys):
    with pytest.raises(SystemExit):
        run(file, "--box", box, "--scale", scale)
    assert f"{scale} is no number above 0, up to 1" in capsys.readouterr().err


def test_settings_of_before_there_were_parts_are_of_the_whole(file, box, tmp_path):
    run(file, "--box", box, "--tracker", "ssd", "-o", tmp_path / "a.csv")
    path = tmp_path / "a.json"
    values = json.loads(path.read_text())
    for name in ("first", "last", "every", "scale"):
        del values[name]
    path.write_text(json.dumps(values))
    run("--settings", path, "-o", tmp_path / "b.csv")
    assert table(tmp_path / "b.csv") == table(tmp_path / "a.csv")


@pytest.mark.slow
def test_a_film_that_is_too_slow_is_told_in_words_of_what_was_typed(
    clip, box, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    films.write(tmp_path / "long.avi", [clip.frames[0]] * 560)
    words = ("long.avi", "--box", box, "--tracker", "ssd", "--every", 550)
    said = "every 550-th frame makes 0.055 pictures .*webm; choose a smaller number"
    with pytest.raises(SystemExit, match=rf"{said} \(--every\)"):
        run(*words)
    assert [path.name for path in tmp_path.iterdir()] == ["long.avi"]
    run(*words, "-o", "a.csv")
    assert len(table(tmp_path / "a.csv")) == 2


def test_a_second_box_is_told_where_several_objects_are(file, box, capsys):
    with pytest.raises(SystemExit):
        run(file, "--box", box, "--box", box)
    assert "RESEARCH.md has ten lines for several" in capsys.readouterr().err


@pytest.mark.parametrize("shape", [(60, 160), (120, 80)])
def test_a_frame_of_another_size_is_said_to_be_so(shape, clip, tmp_path):
    output, frame = tmp_path / "a.webm", clip.frames[0]
    info = report(clip.truth[0], 0.1, False, 1)
    said = rf"a.webm: frame 2 has the shape \({shape[0]}, {shape[1]}, "
    with pytest.raises(ValueError, match=said) as failed:
        with recording.Recorder(output, clip) as recorder:
            recorder.add(frame, info)
            recorder.add(frame, info)
            recorder.add(frame[: shape[0], : shape[1]], info)
    [note] = failed.value.__notes__  # without settings there is no a.json
    assert f"is in {output}, {output.with_suffix('.csv')}." in note
    assert len(VideoFile(output)) == len(table(output.with_suffix(".csv"))) == 2
