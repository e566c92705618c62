"""Files of a broken download or another system are read rightly, or refused in words.

A refusal is one sentence with the file, the line and the remedy.
"""

import cv2
import numpy as np
import pytest

from mkt.files import DataError
from mkt.sequences.truth_formats import bobot, otb, video, vot
from mkt.sequences.video import ImageFolder, VideoFile, read_image
from tests.sequences.written import (
    HEIGHT,
    ONE_BASED,
    REGION,
    WIDTH,
    bobot_folder,
    bobot_row,
    noise,
    numbers,
    otb_folder,
    refused,
    vot_folder,
    write_images,
)

LENGTH = 40
CODECS = {".mkv": "FFV1", ".avi": "MJPG", ".webm": "VP80", ".mp4": "mp4v"}


@pytest.fixture(scope="module")
def videos(tmp_path_factory):
    """The bytes of one video in each kind of container, its frames hard to pack."""
    folder = tmp_path_factory.mktemp("whole")
    contents = {}
    for suffix, codec in CODECS.items():
        path = folder / f"a{suffix}"
        tag, size = cv2.VideoWriter.fourcc(*codec), (WIDTH, HEIGHT)
        writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, tag, 30, size)
        for k in range(LENGTH):
            writer.write(noise(k))
        writer.release()
        contents[suffix] = path.read_bytes()
    return contents


def opened(path, content):
    """How many frames of a file with this content can really be decoded.

    0 where it is refused in a sentence.
    """
    path.write_bytes(content)
    try:
        frames = VideoFile(path)
        assert all(frame.shape == (HEIGHT, WIDTH, 3) for frame in frames)
        return len(frames)
    except DataError as error:
        assert str(error).startswith(f"{path}: ") and "download it again" in str(error)
        return 0


@pytest.mark.parametrize("suffix", CODECS)
def test_a_video_cut_anywhere_is_refused_or_nearly_whole(
    suffix, videos, tmp_path, capfd
):
    content = videos[suffix]
    assert opened(tmp_path / f"whole{suffix}", content) == LENGTH
    path = tmp_path / f"cut{suffix}"
    for share in (0, 0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9):
        assert opened(path, content[: int(share * len(content))]) == 0
    for missing in (1, 10, 100, 1000):
        assert opened(path, content[:-missing]) in (0, LENGTH - 1, LENGTH)


@pytest.mark.parametrize("suffix", CODECS)
def test_a_video_with_a_hole_or_without_its_head_is_refused_or_nearly_whole(
    suffix, videos, tmp_path, capfd
):
    content = videos[suffix]
    middle = len(content) // 2
    hole = content[:middle] + bytes(4000) + content[middle + 4000 :]
    nearly = range(LENGTH - 3, LENGTH + 1)
    assert opened(tmp_path / f"hole{suffix}", hole) in (0, *nearly)
    headless = bytes(64) + content[64:]
    assert opened(tmp_path / f"head{suffix}", headless) in (0, LENGTH - 1, LENGTH)
    assert opened(tmp_path / f"zeros{suffix}", bytes(len(content))) == 0


def test_a_video_under_the_name_of_another_kind_is_read(videos, tmp_path):
    path = tmp_path / "other.avi"
    assert {opened(path, videos[suffix]) for suffix in CODECS} == {LENGTH}


def test_a_folder_for_a_file_and_a_file_for_a_folder(tmp_path):
    path = tmp_path / "folder.mp4"
    path.mkdir()
    with refused("folder.mp4", "no such file", "spelling"):
        VideoFile(path)
    with refused("folder.mp4", "no images in this folder", "put its frames there"):
        video(path)
    with refused("folder.mp4", "no such file", "spelling"):
        read_image(path)
    (tmp_path / "file").write_text("text")
    with refused("file", "this is a file", "give the folder"):
        ImageFolder(tmp_path / "file")


def test_a_folder_for_a_truth(tmp_path):
    folder = otb_folder(tmp_path, "9,9,9,9")
    (folder / "groundtruth_rect.txt").unlink()
    (folder / "groundtruth_rect.txt").mkdir()
    with refused("groundtruth_rect.txt", "no such file", "spelling"):
        otb(folder)


def test_a_folder_with_the_name_of_a_truth_file_is_no_truth_file(tmp_path):
    folder = bobot_folder(tmp_path, bobot_row(0))
    (folder / "other.txt").mkdir()
    assert len(bobot(folder)) == 1


def test_a_half_written_image(tmp_path):
    folder = write_images(tmp_path, 2)
    content = (folder / "0002.png").read_bytes()
    for share in (0.05, 0.5, 0.9):
        (folder / "0002.png").write_bytes(content[: int(share * len(content))])
        try:  # OpenCV fills what is missing with black
            assert ImageFolder(folder)[1].shape == (HEIGHT, WIDTH, 3)
        except DataError as error:
            says = "0002.png: not an image, or cut short; download it again"
            assert says in str(error)


def truth(folder, content, n=2):
    """An OTB sequence of n frames whose truth file holds these bytes."""
    otb_folder(folder, "9,9,9,9", n=n)
    (folder / "groundtruth_rect.txt").write_bytes(content)
    return folder


ROW = numbers(ONE_BASED).encode()
TWO = ROW + b"\n" + ROW


@pytest.mark.parametrize(
    "content",
    [
        TWO,
        ROW + b"\r\n" + ROW + b"\r\n",
        ROW + b"\r" + ROW,
        b"\xef\xbb\xbf" + TWO,
        b"\n \n" + ROW + b"\n\t\n\n" + ROW + b"\n\n",
        TWO.replace(b",", b"\t"),
        TWO.replace(b",", b" , "),
        (ROW + b";\n" + ROW).replace(b",", b";"),
        ROW + b",\n" + ROW + b",",
        TWO.replace(b",", "\u00a0".encode()),
    ],
    ids=[
        "no end of line",
        "Windows",
        "old Macintosh",
        "mark of UTF-8",
        "blank lines",
        "tabs",
        "spaces",
        "semicolons",
        "comma at the end",
        "hard spaces",
    ],
)
def test_a_truth_as_other_systems_write_it_is_read(content, tmp_path):
    np.testing.assert_array_equal(otb(truth(tmp_path, content)).truth, [REGION, REGION])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_a_truth_in_utf_16_is_said_to_be_so(encoding, tmp_path):
    folder = truth(tmp_path, TWO.decode().encode(encoding))
    what = "no plain text: .* as UTF-16 does"
    with refused("groundtruth_rect.txt", what, "save it as UTF-8"):
        otb(folder)


@pytest.mark.parametrize(
    "content, line, what, remedy",
    [
        (b"9,9,9,9\n9,9,", 2, "2 numbers, but 4 are needed", "correct"),
        (b"9,9,9,9\n9", 2, "1 numbers, but 4 are needed", "correct"),
        (b"9,9,9,9", 1, "1 rows for 2 frames", "add"),
        (b"9,5;9,5;9,5;9,5\n", 1, "both commas and semicolons", "write 9.5, not 9,5"),
        (
            b"9,9,9,9\n9,5\t9,5\t9,5\t9,5\n",
            2,
            "looks like a decimal comma",
            "write 9.5, not 9,5",
        ),
        (
            b"9,9,9,9\n9,5,9,5,9,5,9,5",
            2,
            "8 numbers, but 4 are needed",
            "write 9.5, not 9,5",
        ),
        (b"9,9,9,9\n9,,9,9", 2, "3 numbers", "correct"),
        (b"9,9,9,9\n9 nan 9 9", 2, "NaN", "correct"),
        (b"9,9,9,9\n\xff\xfe9,9,9,9", 2, "is not a finite number", "correct"),
        ("9,9,9,9\n\u22129,9,9,9".encode(), 2, "is not a finite number", "correct"),
        (b"9,9,9,9\n1_0,9,9,9", 2, "'1_0' is not a finite number", "correct"),
        (b"9,9,9,9\n1e999,9,9,9", 2, "is not a finite number", "correct"),
        (b"9,9,9,9\n1e300,9,9,9", 2, "outside the image", "correct"),
        (b"9,9,9,9\n(9,9,9,9)", 2, "is not a finite number", "correct"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", None, "no plain text", "download it again"),
        (b"", None, "no rows of numbers", "download"),
    ],
)
def test_a_damaged_truth_is_named_with_its_line(content, line, what, remedy, tmp_path):
    folder = truth(tmp_path, content)
    with refused("groundtruth_rect.txt", what, remedy, line):
        otb(folder)


@pytest.mark.parametrize(
    "row", ["9,5\t9,5\t9,5\t9,5", "-9,5 9,5 9,5 9,5", '"9,5","9,5","9,5","9,5"']
)
def test_decimal_commas_are_not_taken_for_corners(row, tmp_path):
    folder = vot_folder(tmp_path, row)
    with refused("groundtruth.txt", "a decimal comma", "write 9.5, not 9,5", 1):
        vot(folder)


@pytest.mark.parametrize("row", ["9, 9, 19, 19", "9 ,9 ,19 ,19", '"9,9,19,19"'])
def test_a_blank_beside_the_comma_is_no_second_sign(row, tmp_path):
    assert len(vot(vot_folder(tmp_path, row))) == 1


def test_half_a_polygon_is_not_a_hidden_target(tmp_path):
    folder = vot_folder(tmp_path, "9,9,19,9,19,19,9,19", "9,9,19,9,19,19,nan,nan")
    what = "some of its numbers are NaN"
    with refused("groundtruth.txt", what, "NaN in all", 2):
        vot(folder)


@pytest.mark.parametrize(
    "row",
    ["9,9,9,9,9,9,9,9", "10,10,20,20,20,10,10,20"],
    ids=["a point", "a bow tie"],
)
def test_a_polygon_without_an_area(row, tmp_path):
    folder = vot_folder(tmp_path, row)
    with refused("groundtruth.txt", "zero or negative", "format", 1):
        vot(folder)
