"""Files that are there as a whole or not at all, whatever stops the writing: Ctrl-C, a lost process, a full disk."""

import os
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4


@contextmanager
def whole(path):
    """A place beside `path` to write to, which takes its name when the ``with`` ends: nobody ever reads half of it, and an old file stays till then.

    Whoever else writes the same file at the same time does not matter: the last one to finish stands.  When the writing fails or is interrupted, nothing
    is left.  Raises OSError as `named` does.
    """
    path = Path(path)
    half = path.with_name(f"{path.stem}.{uuid4().hex}{path.suffix}")
    try:
        with named(path):
            yield half
            os.replace(half, path)
    finally:
        half.unlink(missing_ok=True)


@contextmanager
def named(path):
    """Make an OSError say which file could not be written, and what to do: Python's own "No space left on device" names none."""
    try:
        yield
    except OSError as error:
        raise OSError(f"{path} cannot be written: {error.strerror or error}; make room there, or choose another place") from error
