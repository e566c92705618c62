"""What has its name is on the disk: a power cut leaves the old file or the new one."""

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from mkt.files import (
    BUILD,
    ROOT,
    DataError,
    alone,
    existing_file,
    existing_folder,
    in_one_piece,
    named,
    whole,
)

POSIX = os.name == "posix"


@pytest.fixture
def order(monkeypatch):
    """What the system is asked for, in its order."""
    done = []
    flush, move = os.fsync, os.replace

    def fsync(descriptor):
        is_folder = stat.S_ISDIR(os.fstat(descriptor).st_mode)
        done.append("folder" if is_folder else "content")
        flush(descriptor)

    def replace(*paths):
        done.append("name")
        move(*paths)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(os, "replace", replace)
    return done


def test_the_content_is_on_the_disk_before_the_name_and_the_folder_after_it(
    tmp_path, order
):
    with whole(tmp_path / "a.txt") as half:
        half.write_text("new")
    assert order == ["content", "name", *(["folder"] if POSIX else [])]
    assert (tmp_path / "a.txt").read_text() == "new"


def test_what_does_not_reach_the_disk_leaves_the_old_file(tmp_path, monkeypatch):
    def full(descriptor):
        raise OSError(28, "No space left on device")

    path = tmp_path / "a.txt"
    path.write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"a\.txt cannot be written: No space left"):
        with whole(path) as half:
            half.write_text("new")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(not POSIX, reason="folders are not flushed elsewhere")
def test_a_drive_that_cannot_flush_folders_is_good_enough(tmp_path, monkeypatch):
    flush = os.fsync

    def fsync(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(22, "Invalid argument")
        flush(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    with whole(tmp_path / "a.txt") as half:
        half.write_text("new")
    assert (tmp_path / "a.txt").read_text() == "new"


@pytest.mark.skipif(not POSIX, reason="Windows has no such names")
@pytest.mark.parametrize("name", [" lead.mkv", "trail.mkv ", "'q'", '"', "~tilde.mkv"])
def test_a_name_that_is_there_is_taken_as_it_is(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DataError, match="no such"):
        existing_file(name)
    Path(name).touch()
    assert existing_file(name) == Path(name)
    Path("plain.mkv").touch()
    assert existing_file(" 'plain.mkv' ") == Path("plain.mkv")


def test_existing_paths_may_begin_at_home(tmp_path, monkeypatch):
    (tmp_path / "a.txt").write_text("")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert existing_file("~/a.txt") == tmp_path / "a.txt"
    assert existing_folder("~") == tmp_path
    for check, path, said in (
        (existing_file, "~", "no such file; check the spelling, or give"),
        (existing_folder, "~/b", "no such folder; check the spelling, or give"),
        (existing_folder, "~/a.txt", "this is a file; give the folder that it is in"),
    ):
        with pytest.raises(DataError, match=said):
            check(path)


@pytest.mark.parametrize("path", [ROOT / ".cache/runs/x.json", BUILD / "html.fresh"])
def test_who_may_not_write_into_the_clone_learns_where_else(path):
    said = "Permission denied; let MKT_CACHE and MKT_BUILD name folders of your own"
    with pytest.raises(OSError, match=said), named(path):
        raise OSError(13, "Permission denied")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG])
def test_who_has_no_room_learns_to_make_some(number, tmp_path):
    with pytest.raises(OSError, match="; make room there, or choose another place$"):
        with named(tmp_path / "a.txt"):
            raise OSError(number, os.strerror(number))


# One at a time

HOLD = """
import sys, time
from pathlib import Path
from mkt.files import alone
with alone(Path(sys.argv[1]), "book"):
    print("mine", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def hold(tmp_path):
    """A way to start programs that hold one lock till their stdin is closed."""
    programs = []

    def start():
        pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        words = [sys.executable, "-c", HOLD, tmp_path / "new" / "lock"]
        programs.append(subprocess.Popen(words, cwd=ROOT, text=True, **pipes))
        return programs[-1]

    yield start
    for program in programs:
        program.kill()
        program.communicate()


def test_a_second_program_says_so_and_waits(hold, tmp_path):
    first = hold()
    assert first.stdout.readline() == "mine\n"
    second = hold()
    said = f"Another book is under way in {tmp_path / 'new'}; waiting for it.\n"
    assert second.stderr.readline() == said
    first.communicate("")
    assert second.stdout.readline() == "mine\n"


def test_a_killed_holder_blocks_nobody(hold, tmp_path, capsys):
    first = hold()
    assert first.stdout.readline() == "mine\n"
    first.kill()
    first.wait()
    with alone(tmp_path / "new" / "lock", "book"):
        assert capsys.readouterr().err == ""


def test_a_lock_that_cannot_be_opened_is_named(tmp_path):
    (tmp_path / "lock").mkdir()
    with pytest.raises(OSError, match=r"lock cannot be written: Is a directory"):
        with alone(tmp_path / "lock", "book"):
            pass


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
def test_ctrl_c_waits_until_what_belongs_together_is_done():
    done = []
    with pytest.raises(KeyboardInterrupt), in_one_piece():
        signal.raise_signal(signal.SIGINT)
        done.append("the row")
        done.append("the frame")
    assert done == ["the row", "the frame"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


# Most disks take 255 bytes; a letter with an accent has two.
@pytest.mark.parametrize("stem", [250 * "x", 125 * "\u00e9"])
def test_a_name_as_long_as_the_disk_takes_can_be_written(tmp_path, stem):
    path = tmp_path / f"{stem}.txt"
    with whole(path) as half:
        half.write_text("all")
    assert path.read_text() == "all"


def test_both_signals_act_again_afterwards():
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    with in_one_piece():
        pass
    after = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    signal.signal(signal.SIGTERM, before[1])
    assert after == before
