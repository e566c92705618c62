"""What is refused, and in which words: fields of a specification, frames, regions.

Every refusal is a ValueError that names the field, its value and the remedy.
"""

import reprlib
import sys
from collections.abc import Callable, Collection
from numbers import Real
from typing import Any

import numpy as np

from mkt.regions import HX, HY, as_regions
from mkt.types import ArrayLike, Frame, NDArray, Region

WHITE = 255  # the highest grey level: a noise beyond it leaves nothing to be seen
HUGE = 1e9  # px: squares of half axes beyond it lose the digits that count
MOST = 100_000  # of anything counted, such as particles: a frame then takes seconds
LONGEST = 32_766  # px a side, and samples: cv2.remap counts with 16 bits and a sign


def of_kind(value: Any, kind: type, name: str, remedy: str) -> None:
    """Refuse an argument of another type."""
    if not isinstance(value, kind):
        raise ValueError(f"{name} is of the type {type(value).__name__}; {remedy}")


def of_frames(value: Any) -> None:
    """Refuse frames without a length or an index, such as those of a generator."""
    if not (hasattr(value, "__len__") and hasattr(value, "__getitem__")):
        raise ValueError(
            f"frames is of the type {type(value).__name__}; give a list, an array "
            "(T, H, W, 3), or whatever has a length and an index"
        )


def one_of(specification: Any, **known: Collection[str]) -> None:
    """Refuse a field whose value is not a known one.

    Parameters
    ----------
    specification : object
        The dataclass whose fields are looked at.
    **known : collections of str
        Field name -> its possible values.
    """
    for field, values in known.items():
        check_known(field, getattr(specification, field), values)


def check_known(name: str, value: Any, values: Collection[str]) -> None:
    """Refuse an argument, or a field, whose value is not a known one."""
    if not (isinstance(value, str) and value in values):
        raise ValueError(f"{name} is {value!r}; it must be one of {', '.join(values)}")


def numbers(
    specification: Any,
    *fields: str,
    fits: Callable[[Any], bool] = lambda value: value == value,
    need: str = "it must be a number",
) -> None:
    """Refuse a field that is no number, or NaN, or not such a one as is needed."""
    for field in fields:
        value = getattr(specification, field)
        if not _is_real(value):
            raise ValueError(f"{field} is {value!r}; it must be a number")
        if not fits(value):
            raise ValueError(f"{field} is {value}; {need}")


def _is_real(value: Any) -> bool:
    """True is no number, although Python counts it among them."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_truth(value: Any) -> bool:
    """Whether this is True or False, Python's or numpy's."""
    return isinstance(value, bool | np.bool_)


def flags(specification: Any, *fields: str) -> None:
    """Refuse a field that is neither True nor False: the text "no" would be a yes."""
    for field in fields:
        value = getattr(specification, field)
        if not is_truth(value):
            raise ValueError(
                f"{field} is {reprlib.repr(value)}; it must be True or False"
            )


def is_number(value: Any, least: float) -> bool:
    """Whether this is a finite number from `least` on."""
    try:
        return _is_real(value) and least <= float(value) < np.inf
    except OverflowError:  # of a whole number such as 10**400
        return False


def are_finite(numbers: Any, *shape: int | None) -> bool:
    """Whether numbers are finite and of a shape, None for any length but 0."""
    try:
        array = np.array(numbers, object)  # as floats, text and True pass for numbers
    except ValueError:
        return False
    fits = array.ndim == len(shape) and array.size > 0
    fits = fits and all(n in (None, m) for n, m in zip(shape, array.shape, strict=True))
    return bool(fits and all(is_number(one, -sys.float_info.max) for one in array.flat))


def in_a_tuple(numbers: Any, *shape: int | None) -> bool:
    """Whether numbers `are_finite` and in a tuple.

    What has them for a field can then be kept under its name: a list has no hash.
    """
    return isinstance(numbers, tuple) and are_finite(numbers, *shape)


def require(specification: Any, **fields: tuple[bool, str]) -> None:
    """Refuse a field that is not what it must be: field=(whether it is, what)."""
    for field, (holds, need) in fields.items():
        if not holds:
            found = reprlib.repr(getattr(specification, field))
            raise ValueError(f"{field} is {found}; it must be {need}")


def positive(specification: Any, *fields: str) -> None:
    """Refuse a field that is not a positive, finite number."""
    need = "it must be positive, and finite"
    numbers(
        specification,
        *fields,
        fits=lambda value: value > 0 and is_number(value, 0),
        need=need,
    )


def not_negative(specification: Any, *fields: str) -> None:
    """Refuse a field that is negative or not finite."""
    need = "it must be at least 0, and finite"
    numbers(specification, *fields, fits=lambda value: is_number(value, 0), need=need)


def grey_levels(specification: Any, *fields: str) -> None:
    """Refuse a field that is negative, or more than there are grey levels."""
    need = f"it must lie between 0 and {WHITE} grey levels"
    numbers(specification, *fields, fits=lambda value: 0 <= value <= WHITE, need=need)


def shares(specification: Any, *fields: str) -> None:
    """Refuse a field that does not lie between 0 and 1."""
    need = "a share lies between 0 and 1"
    numbers(specification, *fields, fits=lambda value: 0 <= value <= 1, need=need)


def is_whole(value: Any, least: int) -> bool:
    """Whether this is a whole number, Python's or numpy's, from `least` on."""
    whole = isinstance(value, int | np.integer) and _is_real(value)
    return whole and bool(value >= least)


def check_seed(seed: Any) -> None:
    """Refuse a seed that is not a whole number from 0 on."""
    if not is_whole(seed, 0):
        raise ValueError(f"seed is {seed!r}; it must be a whole number, at least 0")


def image_size(size: Any) -> None:
    """Refuse a `size` that is not (width, height) in whole pixels."""
    sides = size if isinstance(size, tuple) else ()
    if len(sides) != 2 or not all(is_whole(n, 1) for n in sides):
        raise ValueError(
            f"size is {size}; it must be two whole numbers, each at least 1"
        )


def counts(specification: Any, *fields: str, least: int = 1) -> None:
    """Refuse a field that is not a whole number from `least` to `MOST`."""
    for field in fields:
        value = getattr(specification, field)
        if not (is_whole(value, least) and value <= MOST):
            raise ValueError(
                f"{field} is {value!r}; it must be a whole number, at least {least} "
                f"and at most {MOST}"
            )


def locked(array: NDArray) -> NDArray:
    """The array, to which nobody may write from now on, for several share it."""
    array.setflags(write=False)
    return array


def in_words(region: ArrayLike) -> str:
    """A region, or a part of one, as it stands in a message: on one line, short."""
    return f"({', '.join(f'{number:.5g}' for number in np.ravel(region))})"


def checked_frame(frame: ArrayLike) -> Frame:
    """The frame as an array.

    Raises
    ------
    ValueError
        Unless it is (H, W, 3) uint8 with at least one pixel and no side too long for
        OpenCV.
    """
    frame = np.asarray(frame)
    colours = frame.ndim == 3 and frame.shape[2] == 3
    if not (colours and frame.dtype == np.uint8 and frame.size):
        raise ValueError(
            "a frame must be (H, W, 3) uint8 RGB with at least one pixel, "
            f"not {frame.shape} {frame.dtype}; convert it first"
        )
    if max(frame.shape) > LONGEST:
        raise ValueError(
            f"a frame of {frame.shape[1]}x{frame.shape[0]} px is too large; "
            f"scale it down to at most {LONGEST} px a side"
        )
    return frame


def checked_region(region: ArrayLike) -> Region:
    """The region (5,) that a tracker is to start on, as float64.

    Raises
    ------
    ValueError
        Where it is not one region, is not finite, has no area, or is absurdly large.
    """
    region = as_regions(region)
    if region.shape != (5,):
        raise ValueError(
            "one region (cx, cy, theta, hx, hy) is needed, "
            f"not an array of the shape {region.shape}"
        )
    if not np.isfinite(region).all():
        raise ValueError(
            f"the region {in_words(region)} is not finite; "
            "give five numbers (cx, cy, theta, hx, hy)"
        )
    if max(region[HX:]) > HUGE:
        raise ValueError(
            f"the region {in_words(region)} is larger than any image; "
            "give its size in pixels"
        )
    if max(abs(region[:2])) > HUGE:
        raise ValueError(
            f"the region {in_words(region)} lies outside any image; "
            "give its centre cx and cy in pixels"
        )
    # The product too: that of tiny axes may be rounded to 0.
    if min(*region[HX:], region[HX] * region[HY]) <= 0:
        raise ValueError(
            f"the region {in_words(region)} has no area; "
            "its half axes hx and hy must be positive"
        )
    return region.copy()  # what the caller does with his own changes nothing


def finite(region: Region) -> Region:
    """An estimate (5,), as it is.

    Raises
    ------
    ValueError
        Where it is not finite, which no later step could repair.
    """
    if not np.isfinite(region).all():
        raise ValueError(
            f"the estimate {in_words(region)} is not finite; "
            "check the state and the tracker's motion, and start it again with init"
        )
    return region
