"""What passes between a judge and the accused, as bytes.

The judge trusts nothing that the accused sends, so that this is no pickle: a line of
JSON that says how values are nested, and the plain bytes of arrays after it.  What is
neither a plain value nor an array stays where it is, and a number stands for it.
"""

import json
import math
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np

LARGEST = 64 * 2**20  # [bytes] of a message from the accused
KINDS = "biufcUS"  # of numpy: numbers and text, nothing that points elsewhere
ARRAYS = (np.ndarray, np.generic)
# What stands for an object that was kept, by its number, the name of its type, and, of
# a named tuple, its fields and what is in them.
Kept = Callable[[int, str, list[str], list[Any]], Any]


class TooLarge(ValueError):
    """More than a message may have."""


def lock(*arrays: np.ndarray) -> None:
    """Make arrays read-only, before a check gives them to a student's function.

    Whoever changes one is told so, in the notebook as by the judge, who keeps locked
    what is locked.
    """
    for array in arrays:
        array.flags.writeable = False


def pack(value: Any, keep: Callable[[Any], int]) -> bytes:
    """A value as bytes.

    Parameters
    ----------
    value : object
    keep : callable
        Keeps an object that cannot be sent, and returns its number.

    Raises
    ------
    TooLarge
        Before the arrays are copied.
    """
    arrays: list[np.ndarray] = []
    skeleton = _nested(value, arrays, keep)
    kinds = [[array.dtype.str, array.shape] for array in arrays]
    head = json.dumps([skeleton, kinds]).encode("ascii")
    size = len(head) + 1 + sum(array.nbytes for array in arrays)
    if size > LARGEST:
        raise TooLarge(
            f"your code gives {size / 1e6:.1f} MB, and a check takes at most "
            f"{LARGEST / 1e6:.1f}: is an array or a list longer than it should be?"
        )
    return b"\n".join([head, b"".join(array.tobytes() for array in arrays)])


def _nested(value: Any, arrays: list[np.ndarray], keep: Callable[[Any], int]) -> Any:
    """A value as JSON can have it: itself, or [the letter of its type, what is in it].

    Arrays are moved into a list; "s" is a number of numpy's, as an array without axes.
    """

    def inner(parts: Any) -> list:
        return [_nested(part, arrays, keep) for part in parts]

    if isinstance(value, complex) and not isinstance(value, np.generic):
        value = np.complex128(value)
    value = _as_array(value)
    if isinstance(value, ARRAYS) and value.dtype.kind in KINDS:
        arrays.append(np.asarray(value))
        return ["a" if isinstance(value, np.ndarray) else "s", len(arrays) - 1]
    if value is None or isinstance(value, bool):
        return value
    for plain in (int, float):  # of a subclass, what is plain in it
        if isinstance(value, plain):
            return plain(value)
    if isinstance(value, str):
        return str.__str__(value)  # str(value) of an Enum is its name
    if isinstance(value, dict):
        return ["d", inner(value.items())]
    fields = getattr(value, "_fields", ()) if isinstance(value, tuple) else ()
    if isinstance(value, (list, tuple, range)) and not fields:
        return ["t" if isinstance(value, tuple) else "l", inner(value)]
    inside = inner(value) if fields else []
    return ["k", [keep(value), type(value).__name__, fields, inside]]


def _as_array(value: Any) -> Any:
    """The array of numbers or text that a value, such as a series of pandas, is."""
    if isinstance(value, ARRAYS) or not hasattr(type(value), "__array__"):
        return value
    array = np.asarray(value)
    return array if array.dtype.kind in KINDS else value


def unpack(message: bytes, kept: Kept) -> Any:
    """The value that `pack` made a message of.

    Parameters
    ----------
    message : bytes
    kept : callable
        See `Kept`.

    Raises
    ------
    ValueError, TypeError, KeyError, IndexError, RecursionError
        For bytes that are none of `pack`.
    """
    head, _, bodies = message.partition(b"\n")
    skeleton, kinds = json.loads(head)
    arrays = []
    rest = memoryview(bodies)
    for name, shape in kinds:
        dtype = np.dtype(name)
        if dtype.kind not in KINDS:
            raise ValueError(f"an array of {dtype}")
        size = math.prod(shape) * dtype.itemsize
        arrays.append(np.frombuffer(rest[:size], dtype).reshape(shape).copy())
        rest = rest[size:]
    return _built(skeleton, arrays, kept)


def _built(nested: Any, arrays: list[Any], kept: Kept) -> Any:
    """The value that `_nested` took apart; each array is in one place of it."""

    def inner(parts: list) -> list:
        return [_built(part, arrays, kept) for part in parts]

    if not isinstance(nested, list):
        return nested
    letter, content = nested
    if letter in "as":
        array, arrays[content] = arrays[content], None
        return array[...] if letter == "a" else array[()]
    if letter == "k":
        number, kind, fields, inside = content
        return kept(int(number), str(kind), list(map(str, fields)), inner(inside))
    return {"l": list, "t": tuple, "d": dict}[letter](inner(content))


def send(pipe: BinaryIO, message: bytes) -> None:
    """Write a message, after its length, into a pipe."""
    pipe.write(len(message).to_bytes(8, "big") + message)
    pipe.flush()


def receive(pipe: BinaryIO, largest: int = LARGEST) -> bytes:
    """The next message of a pipe.

    Raises
    ------
    EOFError
        Where there is none, or none of an allowed length.
    """
    size = int.from_bytes(pipe.read(8), "big")
    message = pipe.read(size) if 0 < size <= largest else b""
    if not message or len(message) < size:
        raise EOFError
    return message
