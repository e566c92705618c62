"""A track as files: a video with what was found drawn into it, a table, the settings.

`record` writes them as a target is followed; a `Recorder` does so for a program that
runs the loop itself.  Only one frame at a time is in memory.  No existing file is ever
overwritten, so that a video, its table and its settings are always of one run.  A row
is in the table before its frame is in the video: what is written up to an interruption
can be used.  A program that is killed leaves all of its rows; the last frames of the
video, which the encoder still held, are missing then.
"""

import csv
import os
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from itertools import chain, count
from pathlib import Path
from typing import Any

from tqdm import tqdm

from mkt.files import DataError, flush, in_one_piece, named, whole, written_path
from mkt.own_video.overlay import annotated, pixel_grid
from mkt.own_video.settings import Settings
from mkt.own_video.typed_box import in_words
from mkt.sequences.quiet import quiet
from mkt.sequences.tracks import COLUMNS, rows_of
from mkt.sequences.video import VideoFile
from mkt.sequences.writing import CODECS, rates, video_writer
from mkt.tracking import Info, Sequence, Tracker, follow
from mkt.types import ArrayLike, Frame

TABLES = (".csv", ".txt")  # without a film: our table, or MOT's rows


def checked_output(output: Path | str, source: Path | str) -> Path:
    """The path of the video to write, or of a table alone.

    Raises
    ------
    ValueError
        When it cannot be written, or lies among the images of the source.
    FileExistsError
        As `refuse_taken` does, even if it is the source under another name.
    """
    output = written_path(output)
    _refuse_ending(output)
    if not output.parent.is_dir():
        raise ValueError(
            f"-o {output}: no folder {output.parent}; create it, or choose another"
        )
    if output.parent.samefile(written_path(source)):
        raise ValueError(
            f"-o {output}: this is the folder of the images to be tracked; "
            "choose another place"
        )
    refuse_taken(output)
    return output


def _refuse_ending(output: Path) -> None:
    if output.suffix.lower() not in (*CODECS, *TABLES):
        ending = output.suffix or "a file without an extension"
        raise ValueError(
            f"-o {output}: cannot write {ending}; choose one of {', '.join(CODECS)} "
            "for a film, .csv or .txt for a table alone"
        )


def _refuse_slow(output: Path, fps: float, every: int) -> None:
    """Refuse a film of too few frames in words of what was asked for, not its rate."""
    if fps < rates(output)[0]:
        raise OSError(
            f"{output}: every {every}-th frame makes {fps:.2g} pictures a second, too "
            f"few for {output.suffix}; choose a smaller number (--every), or a table "
            "alone (-o FILE.csv)"
        )


def files_of(output: Path) -> list[Path]:
    """The video if there is one, its table and its settings."""
    beside = output.with_suffix(".json")
    if is_table(output):
        return [output, beside]
    return [output, output.with_suffix(".csv"), beside]


def is_table(output: Path) -> bool:
    """Whether there is to be a table alone, which takes much less time."""
    return output.suffix.lower() in TABLES


def files_there(output: Path) -> list[Path]:
    """Those of a run's files whose names are taken, even by a link to nowhere."""
    return [path for path in files_of(output) if os.path.lexists(path)]


def refuse_taken(output: Path) -> None:
    """Raise FileExistsError if there is such a video, table or settings already."""
    if taken := files_there(output):
        raise FileExistsError(
            f"{taken[0]} is there already and stays as it is; "
            "move it away, or choose another name"
        )


def free(output: Path) -> Path:
    """The path, with a number behind its stem where an earlier run has taken it."""
    stem, ending = output.stem, output.suffix
    further = (output.with_name(f"{stem}-{k}{ending}") for k in count(2))
    return next(path for path in chain([output], further) if not files_there(path))


class Recorder:
    """The video, and table and settings beside it, while they are written.

    All are closed when its ``with`` ends, and are on the disk then.  An error that ends
    it says, as a note, what is left: what was found, or nothing.

    Parameters
    ----------
    output : Path
        Ends as one of `mkt.sequences.writing.CODECS`, or of `TABLES`.
    clip : Sequence
        The sequence whose frames will be given.
    title : str
        A word for the corner.
    settings : Settings, optional
        Settings that give the same track again; they are written too.

    Attributes
    ----------
    done : int
        Frames so far.

    Raises
    ------
    OSError
        When the files cannot be written; `FileExistsError` as `refuse_taken` does.
    """

    def __init__(
        self,
        output: Path,
        clip: Sequence,
        title: str = "",
        settings: Settings | None = None,
    ):
        self.done = 0
        self._title = title
        self._output = written_path(output)
        _refuse_ending(self._output)
        refuse_taken(self._output)
        self._first, self._every = settings.part if settings else (0, 1)
        *film, table, chosen = files_of(self._output)
        if film and self._every > 1:
            _refuse_slow(self._output, clip.fps, self._every)
        self._written = [*film, table]
        self._mot = table.suffix.lower() == ".txt"
        self._film = None
        with ExitStack() as failed:
            self._open_table(table, failed)
            with self._files as opened:
                if settings:
                    settings.save(chosen)
                if film:
                    self._shape = clip.frames[0].shape
                    size = self._shape[1::-1]
                    writer = video_writer(self._output, size, clip.fps)
                    self._film = opened.enter_context(writer)
                self._files = opened.pop_all()
            failed.pop_all()

    def _open_table(self, path: Path, failed: ExitStack) -> None:
        with self._named(), ExitStack() as opened:
            # Each row is written at once, because a program that is killed cannot do it
            # later.
            file = path.open("x", buffering=1, newline="", encoding="utf-8")
            # All that is there from now on is ours, and nothing if this cannot begin.
            failed.callback(_remove, files_of(self._output))
            opened.enter_context(file)
            self._table = csv.writer(file)
            if not self._mot:
                self._table.writerow(COLUMNS)
            self._files = opened.pop_all()

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, _kind: Any, error: BaseException | None, *_: Any) -> None:
        try:
            self._close(error is None)
        except Exception as failed:
            failed.add_note(self._left())
            raise
        if isinstance(error, Exception):
            error.add_note(self._left())
        elif not self.done:  # stopped before the first frame
            _remove(files_of(self._output))

    def _close(self, whole: bool) -> None:
        with self._named():
            self._files.close()
            for path in self._written:
                flush(path)
        if whole and self.done and self._film:
            _check_written(self._output, self.done)

    def _left(self) -> str:
        """What is left of a run that failed: what it found, or nothing.

        The start alone, which was typed, is worth nothing.
        """
        if self.done < 2:
            _remove(files_of(self._output))
            return "Nothing has been written."
        names = ", ".join(map(str, files_there(self._output)))
        return f"Of {self.done} frames, what could be written is in {names}."

    def _named(self):
        return named(self._written[-1])

    def add(self, frame: Frame, info: Info) -> Frame:
        """Write the next frame with its info.

        Parameters
        ----------
        frame : (H, W, 3) uint8 array, RGB
        info : dict
            Of a step, see `mkt.tracking.Tracker`.

        Returns
        -------
        (H, W, 3) uint8 array, RGB
            The picture that went into the video; the frame where there is none.

        Raises
        ------
        ValueError
            For a frame of another size than the first one's, which no video can have.
        OSError
            When it cannot be written.
        """
        k = self._first + self.done * self._every
        if self._film and frame.shape != self._shape:
            raise ValueError(
                f"{self._output}: frame {k} has the shape {frame.shape}, and the first "
                f"one {self._shape}; give frames of one size"
            )
        picture = annotated(frame, info, f"{k} {self._title}") if self._film else frame
        with in_one_piece():
            with self._named():
                self._table.writerows(rows_of(k, info, self._mot))
            self.done += 1
            if self._film:
                self._film.write(picture[..., ::-1])
        return picture


def _remove(paths: list[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)


def _check_written(path: Path, frames: int) -> None:
    """Raise OSError unless a video holds as many frames as were given to it.

    OpenCV does not say when the disk is too full for those that it still held.
    """
    try:
        with quiet():
            found = len(VideoFile(path))
    except DataError:
        found = 0
    if found < frames:
        raise OSError(
            f"{path}: only {found} of {frames} frames could be written; "
            "make room there, or choose another place"
        )


def begun(
    tracker: Tracker,
    clip: Sequence,
    seed: int = 0,
    start: ArrayLike | None = None,
    settings: Settings | None = None,
) -> Iterator[Info]:
    """The infos of `mkt.tracking.follow`, the first of which is computed at once.

    So a tracker's refusal is raised here and not later.

    Parameters
    ----------
    tracker, clip, seed, start
        As for `mkt.tracking.follow`.
    settings : Settings, optional
        Those of the run.

    Raises
    ------
    ValueError
        When the tracker refuses the start, with the box of the settings: a tracker's
        message is about regions, which are not what was typed.
    """
    infos = follow(tracker, clip, seed, start)
    try:
        return chain([next(infos)], infos)
    except ValueError as error:
        if settings is None or isinstance(error, DataError):
            raise
        raise ValueError(f"the box {in_words(settings.box)}: {error}") from error


def record(
    tracker: Tracker,
    clip: Sequence,
    output: Path,
    seed: int = 0,
    title: str = "",
    settings: Settings | None = None,
) -> int:
    """Follow the target and write a video, and a table of the same name, as it goes.

    Ctrl-C ends it early.  Nothing is written when the tracker refuses the start.

    Parameters
    ----------
    tracker, clip, seed
        As for `mkt.tracking.follow`.
    output, title, settings
        As for `Recorder`.

    Returns
    -------
    int
        The number of frames written.

    Raises
    ------
    ValueError
        When the tracker refuses the start, with the box that was typed.
    OSError
        When the files cannot be written.
    """
    infos = begun(tracker, clip, seed, None, settings)
    recorder = Recorder(output, clip, title, settings)
    with recorder, suppress(KeyboardInterrupt):
        frames = tqdm(clip.frames, desc=title, unit="frame", disable=None)
        for frame, info in zip(frames, infos, strict=True):
            recorder.add(frame, info)
    return recorder.done


def ask_for_box(clip: Sequence, output: Path, first: int = 0) -> str:
    """Write the first frame to be tracked under a grid of pixels next to the output.

    Returns a text that says how to read a box off it.  Raises OSError where the picture
    cannot be written.
    """
    path = free(Path(output).with_name(f"{Path(output).stem}-first-frame.png"))
    with whole(path) as half:
        pixel_grid(clip.frames[first]).savefig(half)
    return (
        f"no --box: where is the target?  Open {path}, the first frame with a grid in "
        "pixels.\nRead off x,y of the target's upper left corner, its width w and its "
        "height h, and run this again with --box x,y,w,h"
    )
