"""`python3 -m mkt data`: what is known, what is there, what is wrong with it."""

import shutil

import cv2
import numpy as np
import pytest

from mkt import archives, cli

ROWS = [f"{k} .25 .25 .5 .5" for k in range(3)]


def command(capsys, *words):
    """The exit code and what was printed."""
    code = cli.run(cli.parse(["data", *words]))
    return code, capsys.readouterr().out


def images(folder, n=3, size=(48, 64)):
    folder.mkdir(parents=True)
    for k in range(n):
        cv2.imwrite(str(folder / f"{k + 1:04d}.png"), np.full((*size, 3), 40 * k, np.uint8))


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A folder with one good sequence of each benchmark; MKT_DATA names it."""
    images(tmp_path / "bobot" / "Vid_X" / "frames")
    (tmp_path / "bobot" / "Vid_X" / "truth.txt").write_text("\n".join(ROWS))
    images(tmp_path / "otb" / "Thing" / "img")
    (tmp_path / "otb" / "Thing" / "groundtruth_rect.txt").write_text("10,10,20,20\n" * 3)
    images(tmp_path / "vot" / "item" / "color")
    (tmp_path / "vot" / "item" / "groundtruth.txt").write_text("10,10,20,20\n11,11,20,20\nNaN,NaN,NaN,NaN\n")
    images(tmp_path / "mot15" / "train" / "Street" / "img1")
    (tmp_path / "mot15" / "train" / "Street" / "gt").mkdir()
    (tmp_path / "mot15" / "train" / "Street" / "gt" / "gt.txt").write_text("".join(f"{k},3,5,5,20,20,1,-1,-1,-1\n" for k in (2, 3)))
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    return tmp_path


def test_without_data_everything_is_missing_and_how_to_get_it_is_said(capsys, monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    code, text = command(capsys)
    assert not code and "MKT_DATA is not set" in text
    for archive in archives.ARCHIVES:
        assert f"{archive.name}: missing" in text and archive.licence in text and archive.get in text
    code, text = command(capsys, "check")
    assert not code and "nothing is there" in text


def test_what_is_there_is_listed(root, capsys):
    shutil.rmtree(root / "otb")
    _, text = command(capsys)
    assert "BoBoT: 1 found" in text and "there     Vid_X" in text and "OTB: missing" in text
    assert str(root / "mot15" / "train" / "NAME") in text


def test_good_sequences_of_all_four_pass(root, capsys):
    code, text = command(capsys, "check")
    assert code == 0 and "4 sequences can be used, 0 cannot" in text
    assert "BoBoT/Vid_X: 3 frames of 64x48, hidden in 0" in text and "VOT/item: 3 frames of 64x48, hidden in 1" in text
    assert "MOT15/Street: 2 frames" in text  # from the target's first frame on


def broken_last(root):
    (root / "bobot" / "Vid_X" / "frames" / "0003.png").write_bytes(b"not an image")


def too_few(root):
    (root / "bobot" / "Vid_X" / "frames" / "0003.png").unlink()


def other_size(root):
    cv2.imwrite(str(root / "bobot" / "Vid_X" / "frames" / "0003.png"), np.zeros((24, 32, 3), np.uint8))


def hidden_first(root):
    (root / "bobot" / "Vid_X" / "truth.txt").write_text("\n".join(["0 0 0 0 0", *ROWS[1:]]))


def hidden_ever_after(root):
    (root / "bobot" / "Vid_X" / "truth.txt").write_text("\n".join([ROWS[0], "1 0 0 0 0", "2 0 0 0 0"]))


def no_truth(root):
    (root / "bobot" / "Vid_X" / "truth.txt").unlink()


def misnumbered(root):
    (root / "bobot" / "Vid_X" / "truth.txt").write_text("\n".join([ROWS[0], ROWS[2], ROWS[1]]))


@pytest.mark.parametrize("fault, file, what", [
    (broken_last, "0003.png", "not an image"), (too_few, "truth.txt", "3 rows for 2 frames"), (other_size, "0003.png", "32x24"),
    (hidden_first, "Vid_X", "not visible in the first frame"), (hidden_ever_after, "Vid_X", "visible in no further frame"),
    (no_truth, "Vid_X", "exactly one truth file"), (misnumbered, "truth.txt, line 2", "must count the rows"),
], ids=lambda value: value.__name__ if callable(value) else None)
def test_what_is_wrong_is_named_and_the_rest_still_checked(root, capsys, fault, file, what):
    fault(root)
    code, text = command(capsys, "check")
    wrong, = [line for line in text.splitlines() if line.startswith("wrong: ")]
    assert code == 1 and file in wrong and what in wrong and ";" in wrong
    assert "3 sequences can be used, 1 cannot" in text


def test_a_setting_that_names_nothing_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "gone"))
    for words in ((), ("check",)):
        with pytest.raises(SystemExit) as stopped:
            cli.run(cli.parse(["data", *words]))
        assert "MKT_DATA names a folder that does not exist" in stopped.value.code


def test_a_fingerprint_is_of_the_files_and_not_of_their_place(root):
    first, *_ = archives.sequences()
    before = first.fingerprint()
    shutil.move(root / "bobot", root / "elsewhere")
    assert archives.Found(first.archive, root / "elsewhere" / "Vid_X").fingerprint() == before
    (root / "elsewhere" / "Vid_X" / "truth.txt").write_text("\n".join([*ROWS[:2], "2 .25 .25 .5 .6"]))
    assert archives.Found(first.archive, root / "elsewhere" / "Vid_X").fingerprint() != before
