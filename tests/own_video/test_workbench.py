"""The workbench of notebook 03, from drawing a box to tracking again from a file.

A run is started and stopped and leaves three files; mistakes are answered in words.
"""

import asyncio
import base64
import html
import re
import shlex
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from mkt.course import cli
from mkt.own_video import controls, webcam
from mkt.own_video.box_picker import BoxPicker
from mkt.own_video.settings import (
    load,
    numbers_of,
)
from mkt.own_video.typed_box import region_of
from mkt.own_video.workbench import BUSY, EMPTY, READY, Finished, Workbench, workbench
from mkt.regions import from_box
from mkt.sequences.carphone import carphone
from mkt.sequences.video import VideoFile
from mkt.trackers import by_name
from mkt.tracking import report
from tests.own_video import films

pytestmark = pytest.mark.usefixtures("place")


@pytest.fixture
def panel(car):
    """The panel with the car and a box round it, as the browser would have set them."""
    panel = Workbench()
    panel.source.listed.value = "car.mkv"
    panel.picker.set_state({"box": list(films.BOX)})
    panel.method.tracker.value = "pf-75"
    return panel


def press(button, panel, until=lambda: False):
    """Click a button as the browser does, inside the kernel's loop.

    Press stop as soon as `until` says so, or wait for the end.
    """

    async def scenario():
        button.click()
        while not panel.task.done():
            if until():
                panel.stop.click()
            await asyncio.sleep(0)

    asyncio.run(scenario())


def choose(panel, path):
    """Type a path, as into the field for another video."""
    panel.source.other.value = path


def note(panel):
    """What the panel says."""
    return panel.report.note.value


# Drawing and choosing


def test_the_panel_begins_with_the_head_in_the_clip_of_the_book():
    panel = Workbench()
    assert panel.state == READY and len(panel.clip) == 120
    region = region_of(panel.picker.box, panel.clip.frames[0])
    # Half a pixel for the corner in whole pixels, a quarter for the sides.
    assert np.abs(region[:2] - carphone().truth[0][:2]).max() <= 0.75


def test_a_video_in_the_folder_is_offered_and_shown(car):
    panel = Workbench()
    assert ("car.mkv", "car.mkv") in panel.source.listed.options
    panel.source.listed.value = "car.mkv"
    shown = cv2.imdecode(np.frombuffer(panel.picker.frame, np.uint8), 1)[..., ::-1]
    assert np.array_equal(shown, VideoFile(car)[0])
    assert "12 frames of 160x120 px" in note(panel)
    assert panel.picker.box == [0, 0, 0, 0, 0]  # none, before it is drawn


def test_of_a_folder_the_first_and_the_last_image_are_named(place):
    """So that who counts sees that some are missing."""
    panel = Workbench()
    for k in (2, 5, 10):
        cv2.imwrite(str(place / f"f{k}.png"), films.black())
    choose(panel, str(place))
    assert "3 frames of 64x48 px, f2.png to f10.png, 25 a second" in note(panel)


def test_a_video_that_came_later_is_found_by_the_round_arrow(place):
    panel = Workbench()
    before = panel.source.path
    films.write(place / "late.avi", [films.black()])
    panel.source.again.click()
    assert ("late.avi", "late.avi") in panel.source.listed.options
    assert panel.source.path == before


def test_the_last_choice_counts(car):
    panel = Workbench()
    choose(panel, "car.mkv")
    assert len(panel.clip) == films.LENGTH
    panel.source.listed.value = "car.mkv"
    assert panel.source.other.value == "" and len(panel.clip) == films.LENGTH
    choose(panel, "none.mp4")
    choose(panel, "")
    assert len(panel.clip) == films.LENGTH
    choose(panel, "none.mp4")
    panel.source.listed.value = panel.source.listed.options[0][1]
    assert panel.source.other.value == "" and len(panel.clip) == 120


def test_a_path_that_failed_is_tried_again_when_the_list_is(place):
    panel = workbench()
    path = place / "elsewhere.avi"
    choose(panel, str(path))
    assert panel.state == EMPTY
    films.write(path, [films.black()])
    panel.source.again.click()
    assert panel.clip.frames.path == path and panel.source.path == str(path)


def test_a_typed_path_that_is_a_video_is_chosen_in_the_list_and_stays_there(place):
    panel = Workbench()
    choose(panel, "none.mp4")
    assert "none.mp4" not in dict(panel.source.listed.options)
    (place / "elsewhere").mkdir()
    path = str(films.write(place / "elsewhere" / "ball.avi", [films.black()]))
    choose(panel, f" {path} ")
    assert panel.source.listed.value == panel.source.path == path
    assert panel.source.other.value == "" and len(panel.clip) == 1
    panel.source.again.click()
    assert panel.source.listed.value == path
    panel.source.listed.value = panel.source.listed.options[0][1]
    assert len(panel.clip) == 120 and path in dict(panel.source.listed.options)


def test_the_box_that_the_browser_sends_is_where_the_tracker_starts(panel):
    panel.picker.set_state({"box": [10, 20, 30, 40, 90]})
    start = region_of(panel.settings.box, panel.clip.frames[0])
    assert np.allclose(start, from_box([10, 20, 30, 40], np.pi / 2))


def test_a_box_of_four_numbers_is_no_box():
    with pytest.raises(Exception, match="length"):
        BoxPicker().box = [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize("name", by_name.TRACKERS)
def test_each_tracker_offers_its_numbers_and_takes_them(name, panel):
    panel.method.tracker.value = name
    assert panel.method.numbers == numbers_of(by_name.TRACKERS[name])
    assert panel.settings.configured() == by_name.TRACKERS[name]


# Running


class Plain:
    """A tracker as one writes it who knows no dataclasses: nothing moves."""

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        return state, report(state, distance=0.0, lost=False, evaluations=0)


def test_a_tracker_that_is_no_dataclass_runs_without_numbers(car, monkeypatch):
    monkeypatch.setitem(by_name.TRACKERS._entries, "plain", Plain())
    panel = Workbench()
    panel.source.listed.value = "car.mkv"
    panel.picker.set_state({"box": list(films.BOX)})
    panel.method.tracker.value = "plain"
    assert panel.method.numbers == {}
    press(panel.track, panel)
    assert "car-plain.webm" in note(panel)


@pytest.mark.parametrize("name", by_name.TRACKERS)
def test_each_number_says_in_words_what_it_is(name, panel):
    panel.method.tracker.value = name
    for field in panel.method._fields.children:
        own = f"{field.description} of "  # what is said where nothing is known
        assert " " in field.tooltip.removeprefix(own), (name, field.description)


def test_nothing_is_in_the_box_before_the_first_drag(panel):
    panel.picker.set_state({"box": [0, 0, 0, 0, 0]})
    press(panel.track, panel)
    assert "there is no box yet; draw one round the target" in note(panel)


@pytest.mark.parametrize("quoted", ['"{}"', "'{}' ", " {} "])
def test_a_path_may_come_in_quotes(quoted, car):
    panel = Workbench()
    panel.source.other.value = quoted.format(car)
    assert panel.clip.frames.path.resolve() == car.resolve()


def test_a_run_leaves_a_film_a_table_and_the_settings(panel, place):
    press(panel.track, panel)
    assert panel.state == READY
    assert sorted(path.name for path in place.glob("tracked/*")) == [
        "car-pf-75.csv",
        "car-pf-75.json",
        "car-pf-75.webm",
    ]
    rows = panel.output.with_suffix(".csv").read_text().splitlines()
    assert len(VideoFile(panel.output)) == films.LENGTH == len(rows) - 1
    assert panel.report.children[-1].value == panel.output.read_bytes()
    assert "Written" in note(panel)


def test_the_command_that_is_shown_can_be_copied_whatever_the_film_is_called(
    panel, place
):
    film = films.write(place / "a & b's <i>film.avi", [films.black()])
    panel.report.finish(film, "guided")
    *_, command = re.findall("<code.*?>(.*?)</code>", note(panel))
    assert "<" not in command
    words = shlex.split(html.unescape(command))
    assert words[-1] == str(film.with_suffix(".json").resolve())


def test_a_stopped_run_promises_the_whole_track_and_not_the_same_one(panel, place):
    film = films.write(place / "film.avi", [films.black()])
    panel.report.finish(film, "guided", "Stopped.  ")
    assert "The whole track: <code" in note(panel)
    panel.report.finish(film, "guided")
    assert "The same track again: <code" in note(panel)


def test_no_command_is_shown_that_does_not_know_the_tracker(panel, place):
    film = films.write(place / "film.avi", [films.black()])
    panel.report.finish(film, "mine")
    assert "mkt track" not in note(panel) and "own tracker" in note(panel)


def test_the_settings_of_a_run_give_the_same_table_again(panel, place, capsys):
    panel.method.seed.value = 3
    press(panel.track, panel)
    words = ["track", "--settings", "tracked/car-pf-75.json", "-o", "again.webm"]
    assert not cli.run(cli.parse(words))
    table = (place / "again.csv").read_bytes()
    assert table == (place / "tracked/car-pf-75.csv").read_bytes()
    frames = VideoFile("again.webm"), VideoFile("tracked/car-pf-75.webm")
    assert len(frames[0]) == len(frames[1])
    assert all(map(np.array_equal, *frames))
    assert "may differ" not in capsys.readouterr().err


def test_a_box_that_comes_just_after_the_click_still_counts(panel):
    drawn = [50.0, 44.0, 60.0, 32.0, 10.0]

    async def scenario():
        panel.track.click()
        await asyncio.sleep(0)
        panel.picker.set_state({"box": drawn})
        await panel.task

    asyncio.run(scenario())
    assert load(panel.output.with_suffix(".json")).box == tuple(drawn)


def test_no_run_replaces_an_earlier_one(panel, place):
    press(panel.track, panel)
    first = panel.output.read_bytes()
    panel.method.seed.value = 1
    press(panel.track, panel)
    assert panel.output.name == "car-pf-75-2.webm"
    assert (place / "tracked/car-pf-75.webm").read_bytes() == first


def test_stop_is_heard_between_two_frames_and_keeps_what_was_done(panel):
    def some_frames_are_done():
        return panel.output or (panel.state == BUSY and panel.report.bar.value >= 1)

    press(panel.track, panel, until=some_frames_are_done)
    rows = panel.output.with_suffix(".csv").read_text().splitlines()[1:]
    assert 0 < len(rows) == len(VideoFile(panel.output)) < films.LENGTH
    assert panel.state == READY
    assert f"Stopped: {len(rows)} of {films.LENGTH} frames" in note(panel)
    assert load(panel.output.with_suffix(".json")) == panel.settings


def test_a_stop_before_the_first_frame_is_said(panel, place):
    press(panel.track, panel, until=lambda: True)
    assert "Stopped before the first frame" in note(panel)
    assert panel.state == READY and not list(place.glob("tracked/*"))


def test_nothing_else_can_be_touched_during_a_run_and_a_second_click_does_nothing(
    panel, place
):
    def enabled():
        return {
            "track": not panel.track.disabled,
            "stop": not panel.stop.disabled,
            "picker": panel.picker.enabled,
            "source": not panel.source.listed.disabled,
            "seed": not panel.method.seed.disabled,
        }

    async def scenario():
        panel.track.click()
        task = panel.task
        panel.track.click()
        during.append(enabled())
        assert panel.task is task
        await task

    during = []
    asyncio.run(scenario())
    only_stop = dict.fromkeys(enabled(), False) | {"stop": True}
    assert during == [only_stop]
    assert len(list(place.glob("tracked/*.webm"))) == 1
    assert enabled() == dict.fromkeys(enabled(), True) | {"stop": False}


def test_a_click_that_no_loop_hears_leaves_the_panel_as_it_was(panel):
    with pytest.raises(RuntimeError, match="no running event loop"):
        panel._begin(panel._follow)
    assert not panel.track.disabled and panel.stop.disabled


# Mistakes


@pytest.mark.parametrize(
    "path, said",
    [
        ("none.mp4", "none.mp4: no such file; check the spelling"),
        ("text.mp4", "not a video, or cut short"),
        ("empty", "no images in this folder"),
    ],
)
def test_a_wrong_path_is_answered_in_a_sentence_and_can_be_mended(
    path, said, panel, place
):
    (place / "text.mp4").write_text("no video")
    (place / "empty").mkdir()
    choose(panel, path)
    assert panel.state == EMPTY and panel.track.disabled
    assert said in note(panel)
    with pytest.raises(ValueError, match="there is no video"):
        _ = panel.settings
    choose(panel, "car.mkv")
    assert panel.state == READY and said not in note(panel)


@pytest.mark.parametrize(
    "tracker, box, numbers, said",
    [
        ("pf-75", [500, 9, 5, 5, 0], {}, "it lies outside the image of 160x120 px"),
        ("ssd", [150, 9, 40, 20, 0], {}, "the box 150,9,40,20"),
        ("wm", [0, 0, 300, 300, 0], {}, "is larger than the frame"),
        ("pf-75", films.BOX, {"n": 0}, "particles is 0"),
    ],
)
def test_what_a_tracker_refuses_is_said_and_nothing_is_written(
    tracker, box, numbers, said, panel, place
):
    panel.method.tracker.value = tracker
    panel.picker.set_state({"box": list(box)})
    for field in panel.method._fields.children:
        field.value = numbers.get(field.description, field.value)
    press(panel.track, panel)
    assert said in note(panel) and "Traceback" not in note(panel)
    assert panel.state == READY and not list(place.glob("tracked/*"))


def test_a_folder_of_results_that_cannot_be_made_is_said_with_a_remedy(panel, place):
    (place / "tracked").write_text("mine")
    press(panel.track, panel)
    assert "no folder tracked can be made" in note(panel)
    assert "File exists; move away what has this name" in note(panel)
    assert panel.state == READY


def test_a_run_that_fails_half_way_says_which_files_are_left(panel, place):
    for k, width in enumerate([64, 64, 64, 32]):
        path = place / "images" / f"{k}.png"
        path.parent.mkdir(exist_ok=True)
        cv2.imwrite(str(path), np.full((48, width, 3), 90 + k, np.uint8))
    choose(panel, "images")
    panel.method.tracker.value = "pf-75"
    panel.picker.set_state({"box": [20, 10, 20, 20, 0]})
    press(panel.track, panel)
    left = sorted(path.name for path in (place / "tracked").iterdir())
    assert len(left) == 3 and all(name in note(panel) for name in left)
    assert "3.png" in note(panel) and "what could be written is in" in note(panel)


def test_our_own_mistakes_are_shown_with_their_traceback_and_the_panel_goes_on(
    panel, monkeypatch
):
    def broken(self, state, frame, rng):
        raise ZeroDivisionError("<here>")

    monkeypatch.setattr(type(by_name.TRACKERS["pf-75"]), "step", broken)
    press(panel.track, panel)
    assert "ZeroDivisionError: &lt;here&gt;" in note(panel)
    assert panel.state == READY


# The webcam

OPEN = cv2.VideoCapture


def plug_in(monkeypatch, camera):
    """Files are opened as ever; camera 0 is the made-up one."""

    def capture(*words):
        return camera if words == (0,) else OPEN(*words)

    monkeypatch.setattr(cv2, "VideoCapture", capture)


class Camera:
    """A camera that has so many pictures."""

    def __init__(self, pictures, fps=0.0):
        self.left = pictures
        self.fps = fps
        self.open = True

    def isOpened(self):
        return self.open

    def get(self, what):
        return self.fps

    def read(self):
        self.left -= 1
        if self.left < 0:
            return False, None
        return True, np.full((48, 64, 3), self.left % 256, np.uint8)

    def release(self):
        self.open = False


def test_the_webcam_is_recorded_into_a_file_which_is_then_the_video(
    panel, place, monkeypatch
):
    camera = Camera(1000, fps=10.0)
    plug_in(monkeypatch, camera)
    panel.source.seconds.value = 2
    press(panel.source.camera, panel)
    [file] = place.glob("tracked/webcam-*.avi")
    panel.picker.set_state({"box": [10, 10, 20, 20, 0]})
    assert panel.settings.video == str(file)
    assert len(panel.clip) == 20 and panel.clip.fps == 10.0
    assert not camera.open
    assert panel.clip.frames[0].shape == (48, 64, 3) and panel.state == READY


class Red(Camera):
    """A camera before a red wall."""

    def read(self):
        good, picture = super().read()
        return good, np.full_like(picture, (0, 0, 200)) if good else None  # BGR


def test_colours_of_a_camera_stay_what_they_are_also_while_it_is_watched(
    panel, monkeypatch
):
    plug_in(monkeypatch, Red(1000))
    pictures = webcam.record(Path("red.avi"), 0.2)
    assert (next(pictures) == (200, 0, 0)).all()
    panel.report._peek(next(pictures), 2, 5, "recording")
    pictures.close()
    seen = cv2.imdecode(np.frombuffer(panel.report.picture.value, np.uint8), 1)
    assert np.abs(seen.astype(int) - (0, 0, 200)).max() < 5


@pytest.mark.parametrize("said, believed", [(0.0, 25), (60.0, 60), (90000.0, 25)])
def test_only_a_rate_that_a_camera_can_have_is_believed(
    said, believed, panel, monkeypatch
):
    plug_in(monkeypatch, Camera(1000, fps=said))
    panel.source.seconds.value = 1
    press(panel.source.camera, panel)
    assert panel.clip.fps == believed


def test_two_recordings_in_one_second_are_two_files(panel, place, monkeypatch):
    monkeypatch.setattr(time, "strftime", lambda _: "webcam-now.avi")
    panel.source.seconds.value = 1
    for _ in range(2):
        plug_in(monkeypatch, Camera(1000, fps=10.0))
        press(panel.source.camera, panel)
    names = {path.name for path in place.glob("tracked/*.avi")}
    assert names == {"webcam-now.avi", "webcam-now-2.avi"}
    assert panel.source.path == "tracked/webcam-now-2.avi"


def test_a_stopped_recording_is_kept(panel, monkeypatch):
    plug_in(monkeypatch, Camera(1000))
    press(panel.source.camera, panel, until=lambda: panel.report.picture.value)
    assert panel.state == READY
    assert 0 < len(panel.clip) < 250 and panel.clip.fps == 25.0


def test_no_camera_is_said_plainly_and_the_clip_stays(panel, place, monkeypatch):
    plug_in(monkeypatch, Camera(0))
    press(panel.source.camera, panel)
    assert "it gives no picture; plug one in" in note(panel)
    assert panel.state == READY and panel.clip.name == "car"
    assert not list(place.glob("tracked/*"))


def test_what_a_camera_saw_before_it_stopped_is_named_and_chosen(
    panel, place, monkeypatch
):
    plug_in(monkeypatch, Camera(30))
    press(panel.source.camera, panel)
    [file] = place.glob("tracked/webcam-*.avi")
    name = file.relative_to(place)
    assert f"its pictures stopped; {name} has 30 of 250; plug one in" in note(panel)
    assert panel.source.path == str(name)
    assert len(panel.clip) == 30 and panel.state == READY


@pytest.mark.parametrize(
    "words, said",
    [
        ((), "track needs a VIDEO, or --settings FILE"),
        (("--settings", "x.json", "--box", "1,2,3,4"), "leave these out"),
        (("--settings", "x.json", "--seed", "1"), "leave these out"),
        (("--settings", "x.json", "--tracker", "guided"), "leave these out"),
    ],
)
def test_track_is_told_what_goes_together(words, said, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["track", *words])
    assert said in capsys.readouterr().err


# The page


@pytest.mark.slow
def test_the_book_shows_a_finished_run_with_the_same_settings_as_the_panel(
    monkeypatch, tmp_path
):
    live = Workbench().settings
    monkeypatch.setenv("MKT_STATIC", "1")
    page = workbench()
    assert isinstance(page, Finished) and page.settings == live
    text = page._repr_html_()
    assert "<video controls" in text and "JupyterLab" in text and "://" not in text
    (data,) = re.findall(r'src="data:video/webm;base64,([^"]+)"', text)
    (tmp_path / "x.webm").write_bytes(base64.b64decode(data))
    film = VideoFile(tmp_path / "x.webm")
    seconds = len(page.clip) / page.clip.fps
    assert len(film) / film.fps == pytest.approx(seconds, rel=0.02)  # as fast as life


def test_a_film_that_is_too_large_for_the_page_is_not_shown_in_it(panel, monkeypatch):
    monkeypatch.setattr(controls, "LARGEST", 0)
    press(panel.track, panel)
    assert panel.output.exists() and len(panel.report.children) == 3
