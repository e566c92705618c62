"""``python3 -m mkt COMMAND``: see to the environment once, then run the command in it.

Only the standard library is used here, so that it starts on a bare Python.
"""

import io
import os
import signal
import sys

OLDEST = (3, 11)
TOO_OLD = """\
mkt needs Python 3.11 or later, and this is Python {}.{}.
Install a newer one (python.org, or your system's packages)
and call it by name, for example: python3.11 -m mkt book"""
STOPPED = """
Stopped.  No file is half made; a set-up is begun again by the next run."""


def prepare():
    """Set what the program should set, and not the library."""
    # What `timeout`, a batch system or a container sends is Ctrl-C to us.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # any name can be printed
    # Our own errors say in a sentence what OpenCV and FFmpeg would write to stderr.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")


def main():
    """Check Python and the command line, make the environment, run the command in it.

    Returns
    -------
    int or None
        The exit code.
    """
    if sys.version_info < OLDEST:
        sys.exit(TOO_OLD.format(*sys.version_info[:2]))
    # Not before the check: an old Python could not even read them.
    from mkt.course import cli, environment

    args = cli.parse(sys.argv[1:])  # --help and mistyped commands end here
    with cli.door(args.command):
        if environment.is_by_hand() or environment.is_current():
            return cli.run(args)
        if args.command == "doctor" and not environment.is_made():
            return cli.run(args)  # people need it where the set-up fails
        environment.ensure()
        return environment.become([str(environment.PYTHON), "-m", "mkt", *sys.argv[1:]])


if __name__ == "__main__":
    prepare()
    try:
        code = main()
        sys.stdout.flush()
        sys.exit(code)
    except KeyboardInterrupt:
        print(STOPPED, file=sys.stderr, flush=True)
        sys.exit(130)  # what shells expect of a program stopped by Ctrl-C
    except BrokenPipeError:  # `| head` has read enough
        # Or Python would complain again on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
