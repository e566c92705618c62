"""A track as files: `record` writes the video with what was found drawn into it, and a table beside it, frame by frame; a `Recorder` does
so for whoever runs the loop.

Green is where the tracker says the target is, dashed red where it says that it lost it.  Only one frame at a time is in memory, and what
is written up to an interruption can be used.
"""

import csv
import os
from contextlib import ExitStack, contextmanager
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from tqdm import tqdm

from mkt.files import named, whole
from mkt.plotting import CURRENT, DESIRED, canvas
from mkt.regions import corners
from mkt.tracking import follow
from mkt.video import DataError, VideoFile

CODECS = {".webm": "VP80", ".mkv": "FFV1", ".avi": "MJPG"}
COLUMNS = ("frame", "cx [px]", "cy [px]", "theta [deg]", "hx [px]", "hy [px]", "score", "lost")
DASHES = 5  # a side
BLACK, WHITE = (0, 0, 0), (255, 255, 255)
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # px, of the grid


def checked_output(output, source):
    """The path of the video to write.  Raises ValueError when it cannot be written, or would replace the source."""
    output = Path(output).expanduser()
    if output.suffix.lower() not in CODECS:
        raise ValueError(f"-o {output}: cannot write {output.suffix or 'a file without an extension'}; choose one of {', '.join(CODECS)}")
    if not output.parent.is_dir():
        raise ValueError(f"-o {output}: no folder {output.parent}; create it, or choose another")
    if Path(source).expanduser().resolve() in (output.resolve(), output.parent.resolve()):
        raise ValueError(f"-o {output}: this is the video to be tracked, or in the folder of its images; choose another place")
    return output


class Recorder:
    """The video and the table beside it, which ends in .csv, while they are written; closed when its ``with`` ends.

    output: path that ends as one of `CODECS`; sequence: whose frames will be given; title: a word for the corner.  done: frames so far.
    Raises OSError when the files cannot be written.
    """

    def __init__(self, output, sequence, title=""):
        self.done, self._title, self._output, self._files = 0, title, Path(output), ExitStack()
        with self._files as opened:
            self._writer = opened.enter_context(video(output, sequence.frames[0].shape[1::-1], sequence.fps))
            with self._named():
                self._table = csv.writer(opened.enter_context(open(self._output.with_suffix(".csv"), "w", newline="")))
                self._table.writerow(COLUMNS)
            self._files = opened.pop_all()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        with self._named():
            self._files.close()
        if kind is None and self.done:
            _check_written(self._output, self.done)

    def _named(self):
        return named(self._output.with_suffix(".csv"))

    def add(self, frame, info):
        """Write the next frame (H, W, 3) uint8 with its info.  Returns the picture that went into the video, RGB."""
        picture = annotated(frame, info, f"{self.done} {self._title}")
        with self._named():
            self._table.writerow(row(self.done, info))
        self.done += 1
        self._writer.write(picture[..., ::-1])  # last, for an interruption shows after the call that took longest
        return picture


def _check_written(path, frames):
    """Raise OSError unless a video holds as many frames as were given to it: OpenCV does not say when the disk is full."""
    try:
        with quiet():
            found = len(VideoFile(path))
    except DataError:
        found = 0
    if found < frames:
        raise OSError(f"{path}: only {found} of {frames} frames could be written; make room there, or choose another place")


def begun(tracker, sequence, seed=0, start=None):
    """The infos of `mkt.tracking.follow` with the first one already there, so that a tracker's refusal is raised here and not later."""
    infos = follow(tracker, sequence, seed, start)
    return chain([next(infos)], infos)


def record(tracker, sequence, output, seed=0, start=None, title=""):
    """Follow the target and write output, and a table with the same name that ends in .csv, as it goes.

    tracker, sequence, seed, start: see `mkt.tracking.follow`; output, title: see `Recorder`.
    Ctrl-C ends it early.  Returns the number of frames written.  Raises OSError when the files cannot be written; nothing is when the
    tracker refuses the start.
    """
    infos = begun(tracker, sequence, seed, start)
    with Recorder(output, sequence, title) as recorder:
        try:
            for frame, info in zip(tqdm(sequence.frames, desc=title, unit="frame", disable=None), infos):
                recorder.add(frame, info)
        except KeyboardInterrupt:
            pass
    return recorder.done


def row(index, info):
    """The info of a frame as the numbers of `COLUMNS`."""
    cx, cy, theta, hx, hy = info["region"]
    return [index, *(f"{x:.3f}" for x in (cx, cy, np.degrees(theta), hx, hy)), f"{info['score']:.4g}", int(info["lost"])]


def annotated(frame, info, label):
    """A copy of a frame (H, W, 3) uint8 RGB with the region outlined and the label in a corner."""
    image, lost = frame.copy(), info["lost"]
    thick = max(1, round(frame.shape[0] / 240))
    _outline(image, info["region"], _rgb(DESIRED if lost else CURRENT), thick, dashed=lost)
    _write(image, label + " lost" * lost, (5 * thick, frame.shape[0] - 5 * thick), thick)
    return image


def _outline(image, region, color, thick, dashed):
    """Draw the four sides, and a tick from the centre to the middle of the right one, so that the angle shows."""
    c = corners(region)
    sides = np.stack([c, np.roll(c, -1, axis=0)], 1)
    if dashed:
        t = np.linspace(0, 1, 2 * DASHES)[:, None]
        sides = np.concatenate([(a + t * (b - a)).reshape(-1, 2, 2) for a, b in sides])
    tick = np.stack([region[:2], c[1:3].mean(0)])[None]
    lines = np.nan_to_num(16 * np.concatenate([sides, tick])).clip(-1e6, 1e6).round().astype(np.int32)  # in sixteenths of a pixel
    cv2.polylines(image, list(lines), False, color, thick, cv2.LINE_AA, shift=4)


def _write(image, text, place, thick):
    """White letters with a black rim: the same ones moved to four sides, for thicker ones would be wider."""
    x, y = place
    for dx, dy, color in (-1, 0, BLACK), (1, 0, BLACK), (0, -1, BLACK), (0, 1, BLACK), (0, 0, WHITE):
        cv2.putText(image, text, (x + dx * thick, y + dy * thick), cv2.FONT_HERSHEY_SIMPLEX, 0.4 * thick, color, thick, cv2.LINE_AA)


def _rgb(color):
    return tuple(bytes.fromhex(color[1:]))


@contextmanager
def video(path, size, fps):
    """A `cv2.VideoWriter` for pictures of a size (width, height), closed at the end.  An odd width or height loses its last pixel.

    Raises OSError when the file cannot be written.
    """
    codec = cv2.VideoWriter_fourcc(*CODECS[Path(path).suffix.lower()])
    with quiet():
        writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, codec, fps, size)
    if not writer.isOpened():
        raise OSError(f"{path}: cannot be written; is the folder writable, and is there room?")
    try:
        yield writer
    finally:
        writer.release()


@contextmanager
def quiet():
    """Nothing on stderr.  FFmpeg's C code remarks there that it does not know OpenCV's tag of VP8, and writes it all the same; OpenCV, that
    it has found no camera."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def ask_for_box(sequence, output):
    """Write the first frame under a grid of pixels next to the output.  Returns a text that says how to read a box off it."""
    path = Path(output).with_name(Path(output).stem + "-first-frame.png")
    with whole(path) as half:
        pixel_grid(sequence.frames[0]).savefig(half)
    return (f"no --box: where is the target?  Open {path}, the first frame with a grid in pixels.\n"
            "Read off x,y of the target's upper left corner, its width w and its height h, and run this again with --box x,y,w,h")


def pixel_grid(frame):
    """A matplotlib Figure of a frame (H, W, 3) under a labelled grid, in the coordinates of a box: the image's own corner is 0,0."""
    height, width = frame.shape[:2]
    step = next((s for s in STEPS if width / s <= 20 and height / s <= 20), STEPS[-1])
    fig = canvas((12, 12 * (height / width) + 0.6))
    ax = fig.add_axes((0.05, 0.04, 0.93, 0.9))
    ax.imshow(frame, extent=(0, width, height, 0))
    columns, rows = range(0, width + 1, step), range(0, height + 1, step)
    for color, line in ("black", 1.4), ("white", 0.6):  # seen on any ground
        ax.vlines(columns, 0, height, color, lw=line, alpha=0.6)
        ax.hlines(rows, 0, width, color, lw=line, alpha=0.6)
    ax.set(xticks=columns, yticks=rows, xlim=(0, width), ylim=(height, 0), aspect="equal")
    ax.tick_params(top=True, labeltop=True)
    return fig
