"""Videos that are written can be read again; stderr is silent where it should be."""

import os
import threading
import time
from pathlib import Path
from unittest.mock import Mock

import cv2
import numpy as np
import pytest

from mkt.sequences.quiet import quiet
from mkt.sequences.video import VideoFile
from mkt.sequences.writing import CODECS, Writer, video_writer
from tests.sequences.written import HEIGHT, WIDTH, picture


@pytest.mark.parametrize("suffix", CODECS)
def test_what_is_written_is_read_again(tmp_path, suffix, capfd):
    path = tmp_path / f"a{suffix}"
    with video_writer(path, (WIDTH, HEIGHT), 12.5) as writer:
        for k in range(5):
            writer.write(picture(10 * k)[..., ::-1])
    frames = VideoFile(path)
    assert len(frames) == 5 and frames.fps == pytest.approx(12.5)
    assert np.abs(frames[3].astype(int) - picture(30)).mean() < 12
    assert capfd.readouterr().err == ""


def test_a_place_that_cannot_be_written_is_named(tmp_path, capfd):
    path = tmp_path / "none" / "a.webm"
    with pytest.raises(OSError, match=r"a\.webm: cannot be written; is the folder"):
        with video_writer(path, (WIDTH, HEIGHT), 25):
            pass


def test_a_disk_that_is_full_for_the_last_picture_is_told(tmp_path, monkeypatch):
    """A class of one's own below OpenCV's would end the program now and then."""
    full = Mock(wraps=cv2.VideoWriter, return_value=Mock())
    full.return_value.write.return_value = False
    monkeypatch.setattr(cv2, "VideoWriter", full)
    with pytest.raises(OSError, match=r"a\.avi: frame 0 could not be written; make"):
        with video_writer(tmp_path / "a.avi", (WIDTH, HEIGHT), 25) as writer:
            writer.write(picture(0))


def test_another_ending_is_answered_with_those_there_are(tmp_path):
    with pytest.raises(OSError, match=r"a\.mov: cannot be written; choose .*\.webm"):
        with video_writer(tmp_path / "a.mov", (WIDTH, HEIGHT), 25):
            pass


@pytest.mark.parametrize(
    "suffix, longest", [(".webm", 16_383), (".mp4", 8_191), (".avi", 0), (".mkv", 0)]
)
def test_pictures_too_large_for_a_format_are_told_those_that_take_them(
    suffix, longest, tmp_path
):
    path, most = tmp_path / f"a{suffix}", longest or 32_766
    with video_writer(path, (most, 8), 25) as writer:
        writer.write(np.zeros((8, most, 3), np.uint8))
    assert VideoFile(path)[0].shape == (8, most - most % 2, 3)
    if longest:
        said = rf"b{suffix}: .* {longest} px .* 4x{longest + 1} px; choose .avi or .mkv"
        with pytest.raises(OSError, match=said):
            with video_writer(tmp_path / f"b{suffix}", (4, longest + 1), 25):
                pass
        assert not (tmp_path / f"b{suffix}").exists()


@pytest.mark.parametrize(
    "suffix, shortest", [(".webm", 4), (".avi", 8), (".mp4", 2), (".mkv", 2)]
)
def test_pictures_too_small_for_a_format_are_told_those_that_take_them(
    suffix, shortest, tmp_path
):
    path = tmp_path / f"a{suffix}"
    with video_writer(path, (shortest, shortest), 25) as writer:
        writer.write(np.zeros((shortest, shortest, 3), np.uint8))
    assert VideoFile(path)[0].shape == (shortest, shortest, 3)
    other = "; choose .mp4 or .mkv" if shortest > 2 else ""
    said = f"b{suffix}: .* 9x{shortest - 1} px, and {suffix} needs {shortest} px a side"
    with pytest.raises(OSError, match=f"{said}{other}$"):
        with video_writer(tmp_path / f"b{suffix}", (9, shortest - 1), 25):
            pass


@pytest.mark.parametrize(
    "suffix, slowest, fastest",
    [(".webm", 0.06, 30_000), (".avi", 0.01, 1_000), (".mp4", 0.01, 30_000)],
)
def test_rates_that_a_format_cannot_say_are_told_those_it_can(
    suffix, slowest, fastest, tmp_path
):
    path = tmp_path / f"a{suffix}"
    for fps in (slowest, fastest):
        with video_writer(path, (80, 60), fps) as writer:
            for k in range(3):
                writer.write(np.full((60, 80, 3), 50 * k, np.uint8))
        assert VideoFile(path).fps == pytest.approx(fps)
    for fps in (0, -25, 0.9 * slowest, 1.1 * fastest, np.nan, "25"):
        said = rf"with {fps} pictures a second; for {suffix} choose from {slowest} to"
        with pytest.raises(OSError, match=f"{said} {fastest}$"):
            with video_writer(path, (80, 60), fps):
                pass


@pytest.mark.parametrize(
    "wrong, shape",
    [
        (np.zeros((60, 81, 3), np.uint8), r"\(60, 81, 3\) uint8"),
        (np.zeros((60, 80), np.uint8), r"\(60, 80\) uint8"),
        (np.zeros((60, 80, 3), np.float32), r"\(60, 80, 3\) float32"),
    ],
)
def test_a_picture_of_another_form_is_refused_and_the_film_goes_on(
    wrong, shape, tmp_path
):
    path = tmp_path / "a.avi"
    said = rf"a\.avi: a picture is {shape}, and the film takes \(60, 80, 3\) uint8; con"
    with video_writer(path, (80, 60), 25) as writer:
        with pytest.raises(ValueError, match=said):
            writer.write(wrong)
        writer.write(np.zeros((60, 80, 3), np.uint8))
    assert len(VideoFile(path)) == 1


def test_stderr_is_silent_for_a_while(capfd):
    with quiet():
        os.write(2, b"not heard")
    os.write(2, b"heard")
    assert capfd.readouterr().err == "heard"


def test_stderr_comes_back_after_two_threads_at_once(capfd):
    inside = threading.Event()

    def first():
        with quiet():
            inside.set()
            time.sleep(0.05)

    thread = threading.Thread(target=first)
    thread.start()
    inside.wait()
    with quiet(), quiet():
        thread.join()
    os.write(2, b"heard")
    assert capfd.readouterr().err == "heard"


def test_a_picture_that_was_lost_is_told_although_the_next_one_is_written(tmp_path):
    opened = Mock(**{"write.side_effect": [False, True, True]})
    film = Writer(tmp_path / "a.avi", (4, 4), opened)
    with pytest.raises(OSError, match="frame 0"):
        for _ in range(3):
            film.write(np.zeros((4, 4, 3), np.uint8))
        film.settle()
    film.close()


@pytest.mark.skipif(os.name == "nt", reason="there it is opened under its own name")
def test_an_interrupt_while_a_film_is_opened_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(name, *more):
        Path(name).touch()
        raise KeyboardInterrupt

    opened = Mock(side_effect=interrupted, fourcc=cv2.VideoWriter.fourcc)
    monkeypatch.setattr(cv2, "VideoWriter", opened)
    with pytest.raises(KeyboardInterrupt):
        video_writer(tmp_path / "a.mp4", (64, 64), 25).__enter__()
    assert list(tmp_path.iterdir()) == []


def test_silence_leaves_nothing_open():
    def free():
        two = [os.open(os.devnull, os.O_RDONLY) for _ in range(2)]
        for number in two:
            os.close(number)
        return two

    before = free()
    with quiet():
        pass
    assert free() == before
