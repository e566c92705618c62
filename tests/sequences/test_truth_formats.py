"""Every ground-truth convention lands on the same region; bad truths are explained."""

import itertools

import numpy as np
import pytest

from mkt.regions import corners, to_box
from mkt.sequences.mot import mot
from mkt.sequences.truth_formats import bobot, otb, video, vot
from tests.sequences.written import (
    BOX,
    HEIGHT,
    ONE_BASED,
    REGION,
    WIDTH,
    bobot_folder,
    bobot_row,
    numbers,
    otb_folder,
    refused,
    vot_folder,
    write_images,
    write_rows,
    write_video,
)

GOOD = "9,9,9,9"


@pytest.mark.parametrize("separator", [",", "\t", " ", ", "])
def test_otb_counts_pixels_from_one(tmp_path, separator):
    rows = [numbers(ONE_BASED + [dx, 0, 0, 0], separator) for dx in (0, 2)]
    clip = otb(otb_folder(tmp_path, *rows))
    moved = REGION + [2, 0, 0, 0, 0]
    np.testing.assert_array_equal(clip.truth, [REGION, moved])
    assert clip.upright and len(clip) == 2 and clip.name == tmp_path.name
    np.testing.assert_array_equal(clip.visibility, 1)


def test_otb_first_pixel(tmp_path):
    truth = otb(otb_folder(tmp_path, "1,1,1,1")).truth
    # Pixel (0, 0), one pixel large.
    np.testing.assert_array_equal(truth, [[0, 0, 0, 0.5, 0.5]])


def test_otb_nan_row_is_hidden(tmp_path):
    clip = otb(otb_folder(tmp_path, GOOD, "NaN,NaN,NaN,NaN"))
    assert np.isnan(clip.truth[1]).all()
    np.testing.assert_array_equal(clip.visibility, [1, 0])


@pytest.mark.parametrize("first, turn", list(itertools.product(range(4), (1, -1))))
def test_vot_polygons_from_any_corner_either_way(tmp_path, first, turn):
    angles = np.radians([-20, 10, 40, 65])
    truth = np.array([[30, 20, theta, 12, 6] for theta in angles])
    polygons = np.roll(corners(truth) + 0.5, first, 1)[:, ::turn].round(4)
    rows = [numbers(polygon) for polygon in polygons]
    clip = vot(vot_folder(tmp_path, *rows))
    np.testing.assert_allclose(clip.truth, truth, atol=2e-3)
    assert not clip.upright


def test_vot_polygons_have_the_mean_of_opposite_sides(tmp_path):
    """A trapezium of 10 and 14 by 4."""
    clip = vot(vot_folder(tmp_path, "10,10,20,10,24,14,10,14"))
    assert clip.truth[0, 3] == 6


def test_vot_polygons_with_hidden_frame_and_color_folder(tmp_path):
    polygon, hidden = numbers(corners(REGION) + 0.5), numbers([np.nan] * 8)
    clip = vot(vot_folder(tmp_path, polygon, hidden, polygon, frames="color"))
    np.testing.assert_allclose(clip.truth[[0, 2]], [REGION, REGION], atol=1e-12)
    np.testing.assert_array_equal(clip.visibility, [1, 0, 1])


def test_vot_boxes_agree_with_polygons(tmp_path):
    clip = vot(vot_folder(tmp_path, numbers(BOX)))
    np.testing.assert_array_equal(clip.truth, [REGION])
    assert clip.upright


@pytest.mark.parametrize("header", [["./Vid_X.avi"], []])
@pytest.mark.parametrize("avi", [False, True])
def test_bobot_fractions_with_index(tmp_path, header, avi):
    rows = [bobot_row(0), "1 0 0 0 0", bobot_row(2)]
    clip = bobot(bobot_folder(tmp_path, *header, *rows, n=4 if avi else 3, avi=avi))
    assert len(clip) == len(clip.frames) == 3 and clip.upright
    np.testing.assert_allclose(clip.truth[[0, 2]], [REGION, REGION], atol=1e-3)
    np.testing.assert_array_equal(clip.visibility, [1, 0, 1])
    assert np.isnan(clip.truth[1]).all()
    assert clip.frames[2][0, 0, 0] == 2


def test_bobot_hides_rows_all_of_zeros_and_no_others(tmp_path):
    clip = bobot(bobot_folder(tmp_path, "0 0 0.1 0.2 0.2", "1 0 0 0 0"))
    np.testing.assert_array_equal(clip.visibility, [1, 0])


def test_bobot_four_columns_under_header(tmp_path):
    for row in (bobot_row(0)[2:], numbers(BOX, " ")):
        clip = bobot(bobot_folder(tmp_path, "# x y w h", row, n=1))
        np.testing.assert_allclose(clip.truth, [REGION], atol=1e-3)


def test_bobot_whole_image_under_header(tmp_path):
    clip = bobot(bobot_folder(tmp_path, "# x y w h", "0 0 1 1", n=1))
    np.testing.assert_allclose(to_box(clip.truth[0]), [0, 0, WIDTH, HEIGHT])


def test_bobot_corners_without_header(tmp_path):
    clip = bobot(bobot_folder(tmp_path, "NaN,NaN,NaN,NaN", "20,8,36,32"))
    np.testing.assert_array_equal(clip.truth[1], REGION)
    np.testing.assert_array_equal(clip.visibility, [0, 1])


def test_a_blank_first_line_of_bobot_is_no_header(tmp_path):
    clip = bobot(bobot_folder(tmp_path, "", "20,8,36,32", n=1))
    np.testing.assert_array_equal(clip.truth, [REGION])
    clip = bobot(bobot_folder(tmp_path, "", "# x y w h", numbers(BOX, " "), n=1))
    np.testing.assert_array_equal(clip.truth, [REGION])


def test_bobot_says_that_frames_are_reconstructed(tmp_path):
    folder = bobot_folder(tmp_path, bobot_row(0))
    assert "reconstructed" not in bobot(folder).source
    write_rows(folder / "SOURCE.txt", "FRAMES: RECONSTRUCTED, not original pixels")
    assert bobot(folder).source == "BoBoT (CC BY-SA 3.0 DE), reconstructed frames"


def test_paths_in_truth_files_are_ignored(tmp_path):
    folder = bobot_folder(tmp_path, "../../../etc/passwd", bobot_row(0), n=1)
    assert len(bobot(folder)) == 1


def test_byte_order_mark_blank_lines_and_windows_ends(tmp_path):
    folder = otb_folder(tmp_path, "1", n=2)
    content = b"\xef\xbb\xbf9,9,9,9\r\n\r\n9,9,9,9\r\n\r\n"
    (folder / "groundtruth_rect.txt").write_bytes(content)
    assert len(otb(folder)) == 2


@pytest.mark.parametrize(
    "rows, n, line, what, remedy",
    [
        ([GOOD, "9,x7,9,9"], 2, 2, "'x7' is not a finite number", "correct"),
        (
            ["left,top,width,height", GOOD],
            2,
            1,
            "'left' is not a finite number",
            "correct",
        ),
        ([GOOD, "inf,9,9,9"], 2, 2, "'inf' is not a finite number", "correct"),
        ([GOOD, "__import__('os'),9,9,9"], 2, 2, "not a finite number", "correct"),
        ([GOOD, "", "9,9,9"], 2, 3, "3 numbers, but 4 are needed", "correct"),
        ([GOOD, "9,NaN,9,9"], 2, 2, "NaN", "correct"),
        ([GOOD, "9,9,0,9"], 2, 2, "zero or negative", "correct"),
        ([GOOD, "9,9,9,-9"], 2, 2, "zero or negative", "correct"),
        ([GOOD, "9,9,1e6,9"], 2, 2, "larger than any image", "correct"),
        ([GOOD, "65,9,9,9"], 2, 2, "outside the image of 64x48", "correct"),
        ([GOOD, "9,49,9,9"], 2, 2, "outside the image of 64x48", "correct"),
        ([GOOD, "9,-8,9,9"], 2, 2, "outside the image of 64x48", "correct"),
        ([GOOD, "-8,9,9,9"], 2, 2, "outside the image of 64x48", "correct"),
        ([GOOD], 2, 1, "1 rows for 2 frames", "add or remove"),
        ([GOOD] * 3, 2, 3, "3 rows for 2 frames", "add or remove"),
        ([""], 2, None, "no rows", "download or annotate"),
    ],
)
def test_bad_rows(tmp_path, rows, n, line, what, remedy):
    folder = otb_folder(tmp_path, *rows, n=n)
    with refused("groundtruth_rect.txt", what, remedy, line):
        otb(folder)


def test_boxes_that_touch_the_image_are_fine(tmp_path):
    assert len(otb(otb_folder(tmp_path, "64,48,9,9", "-7,-7,9,9"))) == 2


def first_target(folder):
    return mot(folder, 1)


@pytest.mark.parametrize("reader", [otb, vot, bobot, first_target])
def test_missing_folders(tmp_path, reader):
    with refused("none", "no such folder", "spelling"):
        reader(tmp_path / "none")


def test_missing_parts(tmp_path):
    with refused("groundtruth_rect.txt", "no such file", "spelling"):
        otb(tmp_path)
    write_rows(tmp_path / "groundtruth_rect.txt", GOOD)
    with refused("img", "no such folder", "spelling"):
        otb(tmp_path)


@pytest.mark.parametrize(
    "rows, n, what, remedy, line",
    [
        (["./Vid_X.avi"], 1, "no rows", "header-only", None),
        (
            ["./Vid_X.avi", bobot_row(0), bobot_row(2)],
            2,
            "must count the rows",
            "put",
            3,
        ),
        ([bobot_row(0), "1 NaN 0 0 0"], 2, "NaN", "correct", 2),
        ([bobot_row(0), "1 20 8 16 24"], 2, "outside", "format", 2),
    ],
)
def test_bad_bobot(tmp_path, rows, n, what, remedy, line):
    folder = bobot_folder(tmp_path, *rows, n=n)
    with refused("Vid_X.txt", what, remedy, line):
        bobot(folder)


def test_bobot_with_two_truths(tmp_path):
    bobot_folder(tmp_path, bobot_row(0))
    write_rows(tmp_path / "other.txt", "1")
    what = "exactly one truth file .txt, found Vid_X.txt, other.txt"
    with refused(tmp_path, what, "move"):
        bobot(tmp_path)


def test_bobot_needs_frames_and_spares_only_one(tmp_path):
    folder = write_rows(tmp_path / "Vid_X.txt", bobot_row(0)).parent
    with refused(tmp_path, "exactly one .avi.*found none", "add"):
        bobot(folder)
    bobot_folder(tmp_path, bobot_row(0), n=3, avi=True)
    with refused("Vid_X.txt", "1 rows for 3 frames", "add", 1):
        bobot(folder)


# Videos without truth


def test_video_with_and_without_box(tmp_path):
    path = write_video(tmp_path / "mine.mkv", 3)
    without = video(path)
    assert np.isnan(without.truth).all() and np.isnan(without.visibility).all()
    clip = video(path, box=BOX)
    np.testing.assert_array_equal(clip.truth[0], REGION)
    assert np.isnan(clip.truth[1:]).all() and clip.visibility[0] == 1
    assert (clip.name, clip.fps) == ("mine", 30)
    assert len(video(write_images(tmp_path / "mine", 4))) == 4


def test_the_folder_where_one_stands_has_a_name(tmp_path, monkeypatch):
    folder = write_images(tmp_path / "mine", 2)
    monkeypatch.chdir(folder)
    assert video(".").name == "mine"
    (folder / "deeper").mkdir()
    monkeypatch.chdir(folder / "deeper")
    assert video("..").name == "mine"


@pytest.mark.parametrize(
    "box, what",
    [
        ((70, 5, 9, 9), "outside"),
        ((5, 5, 0, 9), "zero"),
        ((5, np.nan, 9, 9), "NaN"),
        ([np.nan] * 4, "NaN"),
    ],
)
def test_bad_boxes(tmp_path, box, what):
    path = write_video(tmp_path / "mine.mkv", 3)
    with refused("the box of the first frame", what, "give left, top, width, height"):
        video(path, box=box)


@pytest.mark.parametrize("box", [(5, 5, 9), "abcd", 2 * [[5, 5, 9, 9]]])
def test_what_is_no_box_is_told_what_one_is(tmp_path, box):
    path = write_video(tmp_path / "mine.mkv", 3)
    with pytest.raises(ValueError, match="^box is .*; give four numbers"):
        video(path, box=box)
