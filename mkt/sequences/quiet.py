"""Silence on stderr, where the C code below OpenCV writes what nobody asked for."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

# stderr is that of the whole process: a second thread that came before the first one
# has left would take its silence for what is to come back.
_ALONE = threading.RLock()


@contextmanager
def quiet() -> Iterator[None]:
    """Let nothing appear on stderr.

    FFmpeg's C code complains there that it does not know OpenCV's tag of VP8, although
    it writes the file; OpenCV complains that it has found no camera.  Other threads
    wait here for their turn.
    """
    with _ALONE:
        kept = os.dup(2)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            os.close(nowhere)
