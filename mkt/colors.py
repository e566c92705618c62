"""From colours to bins: a frame becomes one image of bin numbers, once for each frame.

``bins(frame)`` gives a `BinImage`; all histograms are counted in it
(`mkt.histograms`), whatever its numbers stand for: colours here, the directions of
edges in `mkt.edges`.  `Joined` bins give several images of a frame as one.

Explained in notebook 01.
"""

from collections.abc import Sequence as Series
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any, Protocol

import cv2
import numpy as np

from mkt import checks
from mkt.checks import (
    LONGEST,
    checked_frame,
    in_a_tuple,
    of_kind,
    one_of,
    shares,
)
from mkt.types import Frame, NDArray

SPACES = {"hsv": (10, 10, 10), "rgb": (8, 8, 8), "hs": (10, 10)}
MOST_BINS = 65_535  # and one number more for what lies outside the image: 16 bits
HUES = 180  # of OpenCV, in two degrees


@dataclass(frozen=True, eq=False)
class BinImage:
    """The bin of every pixel of a frame, or one bin of each of several kinds.

    Parameters
    ----------
    labels : (H, W) uint8 or uint16 array
        Bin numbers in 0 ... m - 1.
    m : int
        Number of bins.
    others : tuple of arrays like labels
        Further bins of the same pixels, with numbers of their own in 0 ... m - 1.
    shares : (m,) float32 array, optional
        The weight of a pixel in each bin; 1 by default.
    compasses : tuple of (int, int)
        For each group of bins that are directions in the image, its first bin and the
        number of its bins.  They cover the full circle, clockwise from the x axis.  A
        region counts them from its own x axis, so that they turn with the object.
    origin : (x, y) [px]
        Where in the frame the first pixel lies, for an image of a part of it.
    pitch : int [px]
        From one pixel to the next, for an image on a smaller scale.

    Raises
    ------
    ValueError
        For another shape or type, layers that differ in these, and a bin number that is
        too large: each would be counted in memory that belongs to something else.  Also
        for shares, compasses, an m and a pitch that do not fit.

    Examples
    --------
    >>> BinImage(np.array([[0, 2]], np.uint8), m=3).shape
    (1, 2)
    """

    labels: NDArray
    m: int
    others: tuple[NDArray, ...] = ()
    shares: NDArray | None = None
    compasses: tuple[tuple[int, int], ...] = ()
    origin: tuple[float, float] = (0.0, 0.0)
    pitch: int = 1

    def __post_init__(self):
        of_kind(self.others, Series, "others", "give a tuple of arrays like labels")
        of_kind(
            self.compasses, Series, "compasses", "give a tuple of (first bin, bins)"
        )
        checks.numbers(self, "m")
        for labels in self.layers:
            self._check(labels)
        checks.counts(self, "m")
        if not checks.is_whole(self.pitch, 1):
            raise ValueError(f"pitch is {self.pitch}; it must be whole, at least 1 px")
        if self.shares is not None and np.shape(self.shares) != (self.m,):
            raise ValueError(
                f"shares has the shape {np.shape(self.shares)}; "
                f"give one number for each of the {self.m} bins"
            )
        if self.shares is not None and not (
            np.asarray(self.shares).dtype.kind in "iuf"
            and np.min(self.shares) >= 0
            and 0 < np.sum(self.shares) < np.inf
        ):
            raise ValueError(
                "shares must be finite, not negative, and not all 0; give how much a "
                "pixel counts in each bin"
            )
        if not checks.are_finite(self.origin, 2):
            raise ValueError(
                f"origin is {self.origin}; give two finite numbers, x and y"
            )
        for group in self.compasses:
            first, n = group if np.shape(group) == (2,) else (-1, 0)
            whole = checks.is_whole(first, 0) and checks.is_whole(n, 1)
            if not (whole and first + n <= self.m):
                raise ValueError(
                    f"compasses has {group}, but bins are numbered from 0 to "
                    f"{self.m - 1}; give the first one and how many there are"
                )

    def _check(self, labels: NDArray) -> None:
        if not (
            isinstance(labels, np.ndarray)
            and labels.ndim == 2
            and labels.size
            and max(labels.shape) <= LONGEST
            and labels.dtype in (np.uint8, np.uint16)
        ):
            raise ValueError(
                "labels must be (H, W) bin numbers, uint8 or uint16, "
                f"from 1 to {LONGEST} px a side; make them from a frame with ColorBins"
            )
        if (labels.shape, labels.dtype) != (self.shape, self.labels.dtype):
            raise ValueError(
                f"others has an array {labels.shape} {labels.dtype}, but labels are "
                f"{self.shape} {self.labels.dtype}; all must be alike"
            )
        if self.m > np.iinfo(labels.dtype).max:
            raise ValueError(
                f"m is {self.m}, and {labels.dtype} has no number left for what lies "
                "outside the image; give the labels as uint16, or have fewer bins"
            )
        if not labels.max() < self.m:
            raise ValueError(
                f"m is {self.m}, but the labels go up to {labels.max()}, "
                f"as {labels.dtype}; give the m of the bins that made them"
            )

    @property
    def layers(self) -> tuple[NDArray, ...]:
        """All of its arrays of labels."""
        return (self.labels, *self.others)

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
        return self.labels.shape


class Bins(Protocol):
    """Whatever makes a bin image of a frame: `ColorBins`, `JointHSV`, or one's own."""

    @property
    def m(self) -> int:
        """Number of bins."""
        ...

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame."""
        ...


def binned(bins: Bins, frame: Frame) -> BinImage:
    """The bins of a frame, which lie in it as their image says.

    Parameters
    ----------
    bins : Bins
    frame : (H, W, 3) uint8 array, RGB

    Raises
    ------
    ValueError
        For bins that make no `BinImage`, one on a smaller scale whose pitch does not
        say so, or one whose rows are the frame's columns; and what the bins refuse.
    """
    image = bins(frame)
    if not isinstance(image, BinImage):  # the words cost more than a frame may
        of_kind(image, BinImage, f"what {bins} makes", "return a BinImage")
    sides = np.shape(frame)[:2]
    if (image.shape, image.pitch) != (sides, 1) and not any(image.origin):
        _check_scale(image, sides, bins)
    return image


def _check_scale(image: BinImage, sides: tuple[int, ...], bins: Bins) -> None:
    (h, w), (height, width) = image.shape, sides
    scale = round(height / h)
    whole = abs(scale * h - height) < scale and abs(scale * w - width) < scale
    if (whole and scale != image.pitch) or (h, w) == (width, height):
        raise ValueError(
            f"{bins} makes an image of {w}x{h} px of a frame of {width}x{height} px, "
            f"with the pitch {image.pitch}; return it rows first, with the pitch "
            "at which its pixels lie in the frame"
        )


def of_bins(value: Any) -> None:
    """Refuse bins that make no bin image, such as the name of a colour space."""
    if not callable(value) or isinstance(value, type):
        raise ValueError(f'bins is {value!r}; give bins, such as ColorBins("hsv")')


def label_type(m: int) -> type:
    """Of the labels of m bins, and of one more number for what lies outside."""
    return np.uint8 if m < 256 else np.uint16


def _check_counts(counts: Any, needed: int, who: str) -> None:
    """Refuse what does not say how many bins each channel has."""
    whole = isinstance(counts, tuple) and all(
        checks.is_whole(count, 1) and count <= 64 for count in counts
    )
    if not whole or len(counts) != needed:
        raise ValueError(
            f"counts is {counts}; {who} a tuple of {needed} whole numbers from 1 to 64"
        )


def _check_m(m: int, counts: tuple[int, ...] | None) -> None:
    if m > MOST_BINS:
        raise ValueError(
            f"counts is {counts}, which makes {m} bins; "
            f"take fewer, at most {MOST_BINS} in all"
        )


@dataclass(frozen=True)
class ColorBins:
    """The bin map b(l) of a colour.

    Parameters
    ----------
    space : {"hsv", "rgb", "hs"}
        "hsv": N_h N_s + N_v bins, colourful pixels by hue and saturation, grey or dark
        ones (S <= s_min or V <= v_min) by value; "rgb": all three channels jointly;
        "hs": hue and saturation jointly.
    counts : tuple of int, optional
        Bins of each channel; without it 10, 10, 10 for hsv, 8, 8, 8 for rgb [N03],
        10, 10 for hs [C14].
    s_min, v_min : float
        In [0, 1].
    shift : tuple of float
        How far the borders of each channel's bins are moved down, in bins; round the
        circle in hue, and to the border elsewhere.

    Raises
    ------
    ValueError
        Naming the field.

    Examples
    --------
    Two reds of one hue and saturation, and a grey; notebook 01.

    >>> red, dark, grey = [255, 0, 0], [200, 0, 0], [128, 128, 128]
    >>> ColorBins()(np.array([[red, dark, grey]], np.uint8)).labels.tolist()
    [[9, 9, 105]]
    """

    space: str = "hsv"
    counts: tuple[int, ...] | None = None
    s_min: float = 0.1
    v_min: float = 0.2
    shift: tuple[float, ...] = (0.0, 0.0, 0.0)

    def __post_init__(self):
        one_of(self, space=SPACES)
        if self.counts is not None:
            _check_counts(self.counts, len(SPACES[self.space]), f"{self.space} takes")
        if not in_a_tuple(self.shift, 3):
            raise ValueError(
                f"shift is {self.shift}; give a tuple of three finite numbers, in bins"
            )
        _check_m(self.m, self.counts)
        shares(self, "s_min", "v_min")

    @property
    def per_channel(self) -> tuple[int, ...]:
        """Bins of each channel, whether given or not."""
        return SPACES[self.space] if self.counts is None else self.counts

    @property
    def m(self) -> int:
        """Number of bins."""
        if self.space == "hsv":
            hues, saturations, values = self.per_channel
            return hues * saturations + values
        return prod(self.per_channel)

    @cached_property
    def _tables(self) -> list[NDArray]:
        """A look-up table (256,) for each channel: their entries add up to the bin."""
        counts = self.per_channel
        ranges = (256, 256, 256) if self.space == "rgb" else (HUES, 256, 256)
        steps = [
            np.floor(np.arange(256) * count / top + by).astype(int)
            for count, top, by in zip(counts, ranges, self.shift, strict=False)
        ]
        if self.space != "rgb":
            steps[0] %= counts[0]
        steps = [np.clip(s, 0, c - 1) for s, c in zip(steps, counts, strict=True)]
        if self.space == "hsv":
            hue, saturation, value = steps
            grey = value + self.m - counts[2]
            tables = [hue * counts[1], saturation, grey]
        else:
            strides = np.cumprod([1, *counts[:0:-1]])[::-1]
            tables = [s * stride for s, stride in zip(steps, strides, strict=True)]
        return [table.astype(label_type(self.m)) for table in tables]

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame.

        Parameters
        ----------
        frame : (H, W, 3) uint8 array, RGB

        Raises
        ------
        ValueError
            For any other shape or type.
        """
        frame = checked_frame(frame)
        if self.space != "rgb":
            frame = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV)
        channels = cv2.split(frame)
        parts = [
            cv2.LUT(channel, table)
            for channel, table in zip(channels, self._tables, strict=False)
        ]
        if self.space == "hsv":
            _, saturation, value = channels
            # Whole thresholds: beside a float, numpy makes floats of all pixels first.
            pale, dark = np.uint8(255 * self.s_min), np.uint8(255 * self.v_min)
            grey = (saturation <= pale) | (value <= dark)
            # copyTo is several times as fast as numpy's where.
            labels = cv2.copyTo(parts[2], grey.view(np.uint8), parts[0] + parts[1])
        else:
            labels = sum(parts[1:], parts[0])
        return BinImage(labels, self.m)


@dataclass(frozen=True)
class JointHSV:
    """Hue, saturation and value jointly, 8 x 8 x 4 bins, as in Section 3 of [N03].

    Parameters
    ----------
    counts : tuple of int
        Bins of hue, saturation and value.

    Raises
    ------
    ValueError
        Naming the field.
    """

    counts: tuple[int, int, int] = (8, 8, 4)

    def __post_init__(self):
        _check_counts(self.counts, 3, "hue, saturation and value take")
        _check_m(self.m, self.counts)

    @cached_property
    def _bins(self) -> ColorBins:
        return ColorBins("rgb", self.counts)

    @property
    def m(self) -> int:
        """Number of bins."""
        return prod(self.counts)

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame (H, W, 3) uint8 RGB; ValueError for anything else."""
        return self._bins(cv2.cvtColor(checked_frame(frame), cv2.COLOR_RGB2HSV_FULL))


@dataclass(frozen=True)
class Joined:
    """Several kinds of bins side by side: each pixel has a share of its vote in each.

    The whole histogram consists of the histograms of the parts, one behind the other,
    each multiplied by its share w_b.  So the Bhattacharyya coefficient is sum_b w_b
    rho_b, and O(x) of (6) in [T09] is sum_b w_b O_b(x): the sum over the bin images;
    likewise the normal equations of its step (9) are the sums of those of the parts.

    Parameters
    ----------
    parts : tuple of Bins
    shares : tuple of float
        The share of each part, not negative and not all 0; only their ratios count.

    Raises
    ------
    ValueError
        Naming the field.
    """

    parts: tuple[Bins, ...]
    shares: tuple[float, ...]

    def __post_init__(self):
        if not (isinstance(self.parts, tuple) and in_a_tuple(self.shares, None)):
            raise ValueError(
                f"parts is {self.parts} and shares is {self.shares}; give a tuple of "
                "at least one part and a tuple of as many finite numbers"
            )
        for part in self.parts:
            of_bins(part)
        if len(self.parts) != len(self.shares):
            raise ValueError(
                f"shares has {len(self.shares)} numbers for {len(self.parts)} parts; "
                "give one share for each"
            )
        if not (min(self.shares) >= 0 and 0 < sum(self.shares) < np.inf):
            raise ValueError(
                f"shares is {self.shares}; they must be finite, not negative, "
                "and not all 0"
            )
        if self.m > MOST_BINS:
            raise ValueError(
                f"the parts have {self.m} bins in all; take at most {MOST_BINS}"
            )

    @property
    def m(self) -> int:
        """Number of bins."""
        return sum(part.m for part in self.parts)

    @cached_property
    def _votes(self) -> NDArray:
        """The weight of a pixel in each bin, (m,)."""
        shares = np.array(self.shares) / sum(self.shares)
        return np.repeat(shares, [part.m for part in self.parts]).astype(np.float32)

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame (H, W, 3) uint8 RGB.

        Raises
        ------
        ValueError
            For any other frame, and for a part that cannot be joined with the others.
        """
        dtype = label_type(self.m)
        images = [part(frame) for part in self.parts]
        layers, compasses, first = [], [], 0
        for part, image in zip(self.parts, images, strict=True):
            _check_part(part, image, images[0])
            labels = image.labels.astype(dtype, copy=False)
            layers.append(labels + dtype(first) if first else labels)
            compasses += [(first + start, n) for start, n in image.compasses]
            first += part.m
        return BinImage(
            layers[0],
            self.m,
            tuple(layers[1:]),
            self._votes,
            tuple(compasses),
            images[0].origin,
            images[0].pitch,
        )


def _check_part(part: Bins, image: BinImage, one: BinImage) -> None:
    """Refuse what a part makes where it cannot be joined with what the first makes."""
    of_kind(image, BinImage, f"what {part} makes", "return a BinImage")
    if image.m != part.m:
        raise ValueError(f"{part} says that m is {part.m}, but makes {image.m} bins")
    if image.others or image.shares is not None:
        raise ValueError(
            f"{part} has several bins for a pixel, which cannot be joined; "
            "take parts of one bin for each"
        )
    if (image.origin, image.pitch) != (one.origin, one.pitch):
        raise ValueError(
            f"{part} makes an image with the origin {image.origin} and the pitch "
            f"{image.pitch}, and the first part one with {one.origin} and {one.pitch}; "
            "all must lie alike in the frame"
        )
