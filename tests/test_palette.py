"""Colour-blind readers and grey print can tell curves that share an axes apart."""

import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from skimage.color import rgb2lab

from mkt.figures.registry import FIGURES
from mkt.files import PACKAGE
from mkt.papers.cordoba2014 import printed, resampling
from mkt.papers.lessons import benchmark, servoing
from mkt.papers.nummiaro2003 import sequences, steps
from mkt.plotting import CONTRAST, CURRENT, DESIRED, TRACKERS, TRUTH, TWELVE
from mkt.trackers import by_name

DIFFERENT = 20  # in CIE Lab: about nine just noticeable differences of colour
LIGHTER = 10  # a tenth of the way from black to white
# G. M. Machado, M. M. Oliveira, L. A. F. Fernandes: A physiologically-based model for
# simulation of color vision deficiency. IEEE TVCG 15 (6), 2009, at severity 1, on
# linear RGB.
BLINDNESS = {
    "none": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
SHARED = {  # colours that are drawn in one axes
    "trackers of T09": [TRUTH, *TRACKERS.values()],
    "robot": [TRUTH, DESIRED, CURRENT],
    "two or three curves": [TRUTH, *CONTRAST],
    "trackers of C14": [TRUTH, *printed.COLORS.values()],
    "person and car": [TRUTH, steps.PERSON, steps.CAR],
    "ways to count": [TRUTH, steps.PLAIN, steps.PALE],
    "readings of resampling": [color for _, color in resampling.STYLES.values()],
    "learning": [TRUTH, sequences.WITH, sequences.WITHOUT],
}
each = pytest.mark.parametrize("colors", SHARED.values(), ids=SHARED)


def linear(colors):
    """Colours as linear RGB (n, 3)."""
    rgb = np.array([to_rgb(color) for color in colors])
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def seen(colors, matrix):
    """Colours as CIE Lab (n, 3), as somebody sees them with such eyes.

    The matrix (3, 3) is what these do to linear RGB.
    """
    changed = np.clip(linear(colors) @ np.transpose(matrix), 0, 1)
    bright = 1.055 * changed ** (1 / 2.4) - 0.055
    return rgb2lab(np.where(changed <= 0.0031308, 12.92 * changed, bright)[None])[0]


@each
@pytest.mark.parametrize("matrix", BLINDNESS.values(), ids=BLINDNESS)
def test_colours_of_one_axes_differ_whoever_looks(colors, matrix):
    lab = seen(colors, matrix)
    assert min(np.linalg.norm(a - b) for a, b in combinations(lab, 2)) >= DIFFERENT


@each
def test_colours_of_one_axes_differ_in_grey_print(colors):
    lightness = np.sort(seen(colors, BLINDNESS["none"])[:, 0])
    assert np.diff(lightness).min() >= LIGHTER


@each
def test_a_thin_line_on_white_can_be_seen(colors):
    assert min(contrast(color, "white") for color in colors) >= 3


def test_black_letters_can_be_read_on_each_particle():
    assert min(contrast(color, "black") for color in TWELVE) >= 4.5


def contrast(color, other):
    """The ratio of two colours' luminances, as the guidelines of accessibility ask."""
    weights = 0.2126, 0.7152, 0.0722
    low, high = sorted(linear([color, other]) @ weights + 0.05)
    return high / low


def test_the_simulation_keeps_grey_and_confuses_red_with_green():
    apart = {}
    for name, matrix in BLINDNESS.items():
        assert np.abs(seen(["0.5"], matrix)[0, 1:]).max() < 2
        red, green = seen(["#d62728", "#2ca02c"], matrix)
        apart[name] = np.linalg.norm(red - green)
    confused = max(apart["protanopia"], apart["deuteranopia"])
    assert confused < apart["none"] / 2 < apart["tritanopia"]


def test_all_trackers_of_the_library_in_one_axes_differ_in_colour_or_dashes():
    styles = [
        tuple(style.values()) for style in benchmark.styles(list(by_name.TRACKERS))
    ]
    assert len(set(styles)) == len(styles) > len(TRACKERS)
    (adaptive,) = benchmark.styles(["adaptive"])
    assert adaptive["color"] == sequences.WITH  # as where the tracker is explained


def test_where_colours_return_the_dashes_differ():
    styles = [(style["color"], style["ls"]) for style in servoing.STYLES]
    assert len(set(styles)) == len(styles) == 6
    for ax in FIGURES["own.approach"].draw()[0].axes[1:]:
        drawn = [
            (line.get_color(), line.get_linestyle())
            for line in ax.lines
            if not line.get_label().startswith("_")
        ]
        assert len(set(drawn)) == len(drawn) > 2


def test_inside_a_chapter_a_colour_keeps_its_meaning():
    assert set(printed.COLORS.values()).isdisjoint(
        color for _, color in resampling.STYLES.values()
    )
    assert {steps.PLAIN, steps.PALE, steps.MISSED}.isdisjoint(steps.TARGETS.values())


def test_pages_draw_in_the_colours_of_python():
    """Or a curve would change its colour where somebody moves it."""
    pages, python = _colors_of("live/*.js"), _colors_of("**/*.py")
    assert pages and pages <= python


def _colors_of(files):
    text = "".join(path.read_text("utf-8") for path in PACKAGE.glob(files))
    return set(re.findall(r'"(#[0-9a-f]{6})"', text))
