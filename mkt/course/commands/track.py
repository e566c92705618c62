"""``track`` follows an object in a video of the user's own."""

import sys
from argparse import ArgumentTypeError
from collections.abc import Callable
from os.path import exists
from pathlib import Path
from typing import Any

from mkt.course.commands import Commands, command

TRACKER = "guided"
INTERRUPTED = 130  # what shells expect of a program stopped by Ctrl-C
ASKED = 2  # the box is still to be read off
PART = ("first", "last", "every", "scale")  # what of the video is looked at
CAMERA = (
    "{}: track reads files, not cameras; `live` in RESEARCH.md follows a camera while "
    "it runs, and the panel of chapter 3 records one"
)


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "track",
        run,
        "track an object in a video of your own",
        "Follows what is inside a box of the first frame, and writes the video with\n"
        "what was found drawn into it (green; dashed red where the tracker says that\n"
        "it lost it), a table beside it (.csv), and the settings that give the same\n"
        "track again (.json).  Files that are there already stay.  Without --box it\n"
        "shows the first frame under a grid, to read the box off.  Ctrl-C ends it and\n"
        "keeps what was done so far.",
        "track ball.mp4",
        "track ball.mp4 --box 120,80,60,40",
        "track holiday/ --box 120,80,60,40,-30 --tracker combined --particles 200 "
        "-o found.avi",
        "track --settings found.json",
    )
    parser.set_defaults(check=check)
    _add_words(parser.add_argument)
    _add_files(parser.add_argument)


def _add_words(add_argument: Callable) -> None:
    """Say which words the command takes."""
    add_argument(
        "video", nargs="?", metavar="VIDEO", help="a video file, or a folder of images"
    )
    add_argument(
        "--box",
        action="append",
        metavar="X,Y,W,H[,ANGLE]",
        help="where the target is in the first frame: upper left corner, width and "
        "height [px], and, if you like, a clockwise rotation about its centre "
        "[degrees]",
    )
    add_argument(
        "--tracker",
        metavar="NAME",
        help=f"{TRACKER} (the default), combined, ssd, mil, ...; a wrong name lists "
        "all; MODULE:CLASS for one of your own",
    )
    add_argument(
        "--particles",
        type=int,
        metavar="N",
        help="number of particles; the tracker's own by default",
    )
    add_argument(
        "--seed",
        type=_whole(0),
        default=0,
        metavar="S",
        help="of the tracker's chance (0); the same seed gives the same track",
    )


def _add_files(add_argument: Callable) -> None:
    """Say which part is taken, and what is read and written."""
    add_argument(
        "--from",
        dest="first",
        type=_whole(0),
        default=0,
        metavar="K",
        help="the frame to begin with, counted from 0, on which the box is",
    )
    add_argument(
        "--to", dest="last", type=_whole(0), metavar="K", help="the frame to end with"
    )
    add_argument(
        "--every",
        type=_whole(1),
        default=1,
        metavar="N",
        help="take every N-th frame alone",
    )
    add_argument(
        "--scale",
        type=_share,
        default=1.0,
        metavar="S",
        help="let the tracker see frames shrunk by S, above 0 up to 1 (1); boxes and "
        "table stay in pixels of the video",
    )
    add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help="track again as this .json file says, which an earlier run wrote; with "
        "VIDEO if that has moved",
    )
    add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="video to write: .webm, which browsers play, .mkv (lossless), or .avi "
        "and .mp4, which take a tenth of the time; all leave out the last pixel of an "
        "odd width or height; or a table alone, which takes none: .csv, or .txt with "
        "MOT's rows.  VIDEO-NAME.webm by default, with a number behind it where that "
        "is taken",
    )


def _share(text: str) -> float:
    """A number above 0, up to 1."""
    try:
        share = float(text)
    except ValueError:
        share = 0.0
    if not 0 < share <= 1:
        raise ArgumentTypeError(f"{text} is no number above 0, up to 1")
    return share


def _whole(least: int) -> Callable[[str], int]:
    """A way to read whole numbers from a least one on."""

    def number(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise ArgumentTypeError(f"{text} is no whole number from {least} on")
        return int(text)

    return number


def check(args) -> str | None:
    """What is wrong with the words after `track`, None if nothing is.

    They name a video, or settings that name one and leave nothing to say.
    """
    if args.settings is None and args.video is None:
        return "track needs a VIDEO, or --settings FILE"
    if args.video and _is_camera(str(args.video)):
        return CAMERA.format(args.video)
    if args.box and len(args.box) > 1:
        return "track follows one object; RESEARCH.md has ten lines for several"
    # A file is not trusted where code is to be run: the class must be named again.
    known = args.tracker is None or ":" in args.tracker
    said = args.box, args.particles, args.seed, *_part(args).values()
    if args.settings and not (known and said == (None, None, 0, 0, None, 1, 1.0)):
        return (
            "--settings says box, tracker, particles, seed, frames and scale; leave "
            "these out, or change them in a copy of the file"
        )
    return None


def _is_camera(video: str) -> bool:
    """Whether a camera is meant: a number, or an address, and no file of that name."""
    # Path.exists would raise for a name that no file can have.
    return (video.isdecimal() or "://" in video) and not exists(video)  # noqa: PTH110


def run(args) -> int | None:
    """Track in a video of the user's own, or show its first frame to read a box off."""
    from mkt.course import own_tracker

    own_tracker.enter(_tracker(args))
    if args.settings is None and args.box is None:
        return _ask(args)
    return _track(args)


def _ask(args) -> int:
    from mkt.own_video import recording, settings
    from mkt.sequences.truth_formats import video

    # What is wrong is reported now, not after the box was read off.
    settings.with_numbers(_tracker(args), _particles(args))
    clip = video(args.video)
    settings.chosen_frames(clip, args.first, args.last, args.every)
    words = recording.ask_for_box(clip, _output(args, args.video), args.first)
    print(words, file=sys.stderr)
    return ASKED


def _track(args) -> int | None:
    from mkt.own_video import recording, settings
    from mkt.own_video.typed_box import parse_box

    if args.settings:
        chosen = settings.load(args.settings, args.video)
        if args.tracker not in (None, chosen.tracker):
            raise ValueError(
                f"{args.settings} is of {chosen.tracker}; leave --tracker out"
            )
    else:
        box = parse_box(args.box[0])
        numbers = _particles(args)
        chosen = settings.settled(
            args.video, box, _tracker(args), numbers, args.seed, **_part(args)
        )
    output = _output(args, chosen.video)
    clip = chosen.sequence()
    tracker = chosen.configured()
    name = chosen.tracker
    done = recording.record(
        tracker, clip, output, chosen.seed, title=name, settings=chosen
    )
    if not done:
        print("stopped before the first frame: nothing was written", file=sys.stderr)
        return INTERRUPTED
    print(*recording.files_of(output), sep="\n")
    changed = settings.changed_versions(chosen) if args.settings else ""
    if changed:
        print(f"the track may differ in its last digits: {changed}", file=sys.stderr)
    if done == len(clip):
        return None
    where = "the table" if recording.is_table(output) else "both"
    print(
        f"stopped: {done} of {len(clip)} frames are in {where}, up to frame "
        f"{chosen.first + (done - 1) * chosen.every}",
        file=sys.stderr,
    )
    return INTERRUPTED


def _part(args) -> dict[str, Any]:
    """What of the video is tracked."""
    return {name: getattr(args, name) for name in PART}


def _tracker(args) -> str:
    """Its name; None as typed, so that --settings knows whether one was."""
    return TRACKER if args.tracker is None else args.tracker


def _particles(args) -> dict[str, float]:
    return {} if args.particles is None else {"n": args.particles}


def _output(args, source: str) -> Path:
    """Where the video goes: -o, or a free name made from what is tracked, here."""
    from mkt.own_video.recording import checked_output, free

    if args.settings:
        name = f"{args.settings.stem}-again"
    else:
        tracker = _tracker(args).replace(":", "_")  # no name of a file on Windows
        name = f"{Path(source).resolve().stem}-{tracker}"
    name = name.lstrip("~")  # which would be a home
    return checked_output(args.output or free(Path(f"{name}.webm")), source)
