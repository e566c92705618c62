"""``test`` runs pytest on the checkout."""

import os

from mkt.course.commands import Commands, command
from mkt.files import BUILD, ROOT, alone, is_clone


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "test",
        run,
        "run the tests",
        "Runs pytest.  Everything after `test` is handed to it.",
        "test",
        'test -m "not slow"',
        "test -k histograms",
        "test tests/test_regions.py -x -n 0",
        clone=True,
    )
    parser.set_defaults(check=check)
    parser.usage = "python3 -m mkt test [-h] [PYTEST ARGUMENT ...]"


def check(args) -> str | None:
    """What is in the way of a test, None if nothing is: a handout has none."""
    if is_clone() and not (ROOT / "tests").is_dir():
        return f"{ROOT} has no tests, which only a clone of the repository has"
    return None


def run(args) -> int:
    """Run pytest on the checkout, one at a time: two would build the same site."""
    import pytest

    os.chdir(ROOT)
    with alone(BUILD / "test.lock", "test"):
        return pytest.main(args.rest)
