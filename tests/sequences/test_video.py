"""Frames are decoded on demand, and what is no frame is named and explained."""

import gc
import itertools
import pickle
import weakref
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import ExifTags, Image

from mkt.files import DataError
from mkt.sequences import video
from mkt.sequences.video import KEPT, ImageFolder, VideoFile
from tests.sequences.written import (
    HEIGHT,
    WIDTH,
    noise,
    picture,
    refused,
    write_images,
    write_rows,
    write_video,
)


@pytest.fixture(params=["file", "folder"])
def frames(request, tmp_path):
    n = 3 * KEPT
    if request.param == "file":
        return VideoFile(write_video(tmp_path / "a.mkv", n))
    return ImageFolder(write_images(tmp_path / "a", n))


def test_frames_are_rgb_in_order_and_counted(frames):
    assert len(frames) == 3 * KEPT
    for k, frame in enumerate(frames):
        assert frame.dtype == np.uint8
        np.testing.assert_array_equal(frame, picture(k))
    assert k == 3 * KEPT - 1


def test_random_access_equals_sequential_access(frames):
    for k in [5, 4, 90, 3, 3, 95, 0, -1, 50, np.int64(49), 17, 94, 60, 28]:
        np.testing.assert_array_equal(frames[k], picture(k % len(frames)))
    for k in (len(frames), -len(frames) - 1):
        with pytest.raises(IndexError):
            frames[k]


def test_several_threads_may_read(frames):
    def read(order):
        return [(k, frames[k]) for k in order]

    orders = [range(0, 96, 2), range(95, 0, -3), range(96), range(95, 0, -5)]
    with ThreadPoolExecutor(4) as threads:
        seen = list(threads.map(read, orders))
    for k, frame in itertools.chain.from_iterable(seen):
        np.testing.assert_array_equal(frame, picture(k))


def test_slices_are_views(frames):
    part = frames[10:40:3]
    assert (len(part), part.fps) == (10, frames.fps)
    reds = [frame[0, 0, 0] for frame in part]
    np.testing.assert_array_equal(reds, np.arange(10, 40, 3))
    assert part[1:][-1] is frames[37] and len(frames[:-1]) == len(frames) - 1
    with pytest.raises(IndexError):
        part[10]


def test_no_more_frames_are_kept_than_the_cache_holds(frames):
    alive = [weakref.ref(frame) for frame in frames]
    gc.collect()
    # The loop variable's frame is among the cached ones.
    assert sum(ref() is not None for ref in alive) <= KEPT + 1
    assert frames[95] is frames[95] and alive[0]() is None


def test_a_frame_in_use_stays_in_the_cache(frames):
    first = frames[0]
    for k in range(1, 2 * KEPT):
        frames[k]
        assert frames[0] is first


def test_stepping_back_decodes_a_block_not_a_frame(tmp_path, monkeypatch):
    frames = VideoFile(write_video(tmp_path / "a.mkv", 3 * KEPT))
    reopen = VideoFile._open
    opened = []

    def counted(self):
        opened.append(1)
        reopen(self)

    monkeypatch.setattr(VideoFile, "_open", counted)
    for k in reversed(range(3 * KEPT)):
        np.testing.assert_array_equal(frames[k], picture(k))
    assert 1 <= len(opened) <= 3


def test_of_large_frames_no_more_are_decoded_on_the_way_back(tmp_path, monkeypatch):
    frames = VideoFile(write_video(tmp_path / "a.mkv", 60))
    monkeypatch.setattr(video, "ROOM", 5 * frames[59].nbytes)
    decode, decoded = VideoFile._decoded, []

    def counted(self):
        decoded.append(self._next)
        return decode(self)

    monkeypatch.setattr(VideoFile, "_decoded", counted)
    for k in reversed(range(60)):
        np.testing.assert_array_equal(frames[k], picture(k))
    assert len(decoded) <= 60


def test_frames_cannot_be_drawn_into(frames):
    with pytest.raises(ValueError, match="read-only"):
        frames[0][:] = 0


def test_frames_and_errors_travel_to_worker_processes(frames):
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(frames))[7], picture(7))
    error = DataError("a.txt", "broken", "mend it", 3)
    travelled = str(pickle.loads(pickle.dumps(error)))
    assert travelled == str(error) == "a.txt, line 3: broken; mend it"


def test_file_says_its_rate_and_folder_uses_25(tmp_path):
    assert VideoFile(write_video(tmp_path / "a.mkv", 3)).fps == 30
    assert ImageFolder(write_images(tmp_path / "a", 3)).fps == 25


def test_names_are_ordered_as_people_do_and_other_files_ignored(tmp_path):
    write_images(tmp_path, 12, "img{}.png")
    write_rows(tmp_path / "groundtruth.txt", "1")
    (tmp_path / "._img1.png").write_bytes(b"what a Mac puts beside img1.png")
    assert [frame[0, 0, 0] for frame in ImageFolder(tmp_path)] == list(range(12))


@pytest.mark.parametrize("suffix", ["jpg", "JPEG", "bmp", "webp"])
def test_other_image_formats(tmp_path, suffix):
    frames = ImageFolder(write_images(tmp_path, 2, "{}." + suffix))
    np.testing.assert_allclose(frames[1].astype(int), picture(1), atol=12)


def test_length_is_counted_when_the_container_is_off_by_one(tmp_path, monkeypatch):
    path = write_video(tmp_path / "a.mkv", 40)
    monkeypatch.setattr(VideoFile, "_said", lambda self, what: 41)
    assert len(VideoFile(path)) == 40


def test_bad_videos(tmp_path):
    with refused("none.mp4", "no such file", "spelling"):
        VideoFile(tmp_path / "none.mp4")
    with refused("text.mp4", "not a video", "convert"):
        VideoFile(write_rows(tmp_path / "text.mp4", "hello"))
    with refused("text.txt", "a text, not a video", "give a video"):
        VideoFile(write_rows(tmp_path / "text.txt", "1 2 3 4"))
    black, white = (Image.new("RGB", (64, 48), color) for color in ("black", "white"))
    black.save(tmp_path / "a.webp", save_all=True, append_images=[white])
    with refused("a.webp", "no frame of this video", "convert it to mp4"):
        VideoFile(tmp_path / "a.webp")
    content = write_video(tmp_path / "a.mkv", 40, noise).read_bytes()
    cut = tmp_path / "cut (1).mkv"
    cut.write_bytes(content[: len(content) // 2])
    what = r"truncated: \d\d of 40 frames"
    with refused(cut.name, what, r"download it again.* -i 'cut \(1\).mkv' "):
        VideoFile(cut)
    with refused("grey.mkv", "grey", "ffmpeg"):
        VideoFile(write_video(tmp_path / "grey.mkv", 3, color=False))


def test_a_video_that_may_not_be_read_is_not_called_damaged(tmp_path, monkeypatch):
    """Root may read everything: the system is played."""
    path = write_rows(tmp_path / "mine.mp4", "what OpenCV may not read, either")

    def forbidden(self, *_):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "open", forbidden)
    with pytest.raises(PermissionError, match="Permission denied: .*mine.mp4"):
        VideoFile(path)


def test_bad_folders_and_images(tmp_path):
    with refused("none", "no such folder", "spelling"):
        ImageFolder(tmp_path / "none")
    with refused(tmp_path, "no images", "put its frames there"):
        ImageFolder(tmp_path)
    good = picture(0)
    for name, image, what in (
        ("grey", good[..., 0], "grey"),
        ("deep", good.astype(np.uint16) * 256, "16 bits"),
        ("alpha", np.dstack([good, good[..., :1]]), "alpha channel"),
    ):
        path = write_images(tmp_path / name, 1) / "0002.png"
        cv2.imwrite(str(path), image)
        with refused(path, what, "8-bit RGB.*ffmpeg"):
            ImageFolder(path.parent)[1]
    path = write_images(tmp_path / "sizes", 1) / "0002.png"
    cv2.imwrite(str(path), good[:, :32])
    with refused(path, "32x48 pixels.*64x48", "resize"):
        ImageFolder(path.parent)[1]
    huge = bytearray(path.read_bytes())
    huge[16:24] = (70_000).to_bytes(4, "big") * 2  # width and height in its head
    huge[29:33] = zlib.crc32(huge[12:29]).to_bytes(4, "big")
    for content in (b"", b"not an image", bytes(huge)):
        path.write_bytes(content)
        with refused(path, "not an image", "download"):
            ImageFolder(path.parent)[1]


# What a camera notes of how it was held, and what brings the picture back.
HELD = {
    1: lambda stored: stored,
    2: lambda stored: stored[:, ::-1],
    3: lambda stored: stored[::-1, ::-1],
    6: lambda stored: np.rot90(stored, -1),
    8: np.rot90,
}


@pytest.mark.parametrize("suffix", ["jpg", "png", "webp"])
@pytest.mark.parametrize("held", HELD)
def test_a_photograph_is_turned_as_its_camera_was_held(tmp_path, held, suffix):
    stored = np.full((HEIGHT, WIDTH, 3), 20, np.uint8)
    stored[: HEIGHT // 2, : WIDTH // 2] = 220, 120, 20  # one corner, and no grey
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = held
    Image.fromarray(stored).save(tmp_path / f"0.{suffix}", exif=exif)
    (frame,) = ImageFolder(tmp_path)
    upright = HELD[held](stored)
    assert frame.shape == upright.shape
    assert np.abs(frame.astype(int) - upright).mean() < 4


def test_a_photograph_that_is_turned_is_still_looked_at(tmp_path):
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = 6
    path = tmp_path / "0.jpg"
    Image.new("L", (WIDTH, HEIGHT)).save(path, exif=exif)
    with refused(path, "grey", "8-bit RGB"):
        ImageFolder(tmp_path)


@pytest.mark.parametrize("suffix", ["jpg", "png", "webp"])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.99])
def test_a_frame_that_is_cut_short_is_refused(tmp_path, suffix, share):
    path = tmp_path / f"0.{suffix}"
    cv2.imwrite(str(path), noise(0))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with refused(path, "cut short", "download"):
        ImageFolder(tmp_path)
    path.write_bytes(whole + b"what a camera writes behind it")
    assert len(ImageFolder(tmp_path)) == 1


def test_the_end_of_a_photograph_is_neither_its_thumbnail_s_nor_that_of_what_follows(
    tmp_path,
):
    small, large = (
        cv2.imencode(".jpg", frame)[1].tobytes()
        for frame in (noise(1)[:8, :8], noise(0))
    )
    thumbnail = b"\xff\xe1" + (2 + len(small)).to_bytes(2, "big") + small
    whole = large[:2] + thumbnail + b"\xff" + large[2:]  # a byte that fills, too
    film = b"\xff\xd9 and \xff\xda"
    path = tmp_path / "0.jpg"
    path.write_bytes(whole + film)
    assert len(ImageFolder(tmp_path)) == 1
    path.write_bytes(whole[:-40])
    with refused(path, "cut short", "download"):
        ImageFolder(tmp_path)


def test_of_large_frames_fewer_are_kept(tmp_path, monkeypatch):
    frames = VideoFile(write_video(tmp_path / "a.mkv", 20))
    monkeypatch.setattr(video, "ROOM", 5 * frames[0].nbytes)
    alive = [weakref.ref(frame) for frame in frames]
    gc.collect()
    assert sum(ref() is not None for ref in alive) <= 6
