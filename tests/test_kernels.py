"""Layouts and profiles: what the weights must satisfy whatever the configuration."""

import itertools
import operator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.kernels import LAYOUTS, PROFILES, Kernels
from mkt.trackers.newton import template

configurations = st.builds(
    lambda layout, span, **fields: Kernels(
        layout, span=1.0 if layout == "axes" else span, **fields
    ),
    layout=st.sampled_from(LAYOUTS),
    profile=st.sampled_from(PROFILES),
    span=st.floats(0.5, 1.5),
    elliptic=st.booleans(),
    aspect=st.floats(0.4, 2.5),
    samples=st.integers(400, 3000),
)


@given(configurations)
def test_rows_sum_to_one_and_every_sample_is_seen(kernels):
    assert np.allclose(kernels.weights.sum(1), 1)
    assert (kernels.weights >= 0).all()
    assert kernels.weights.any(0).all()
    assert np.abs(kernels.points).max() < 1
    assert len(kernels.points) <= 1.2 * kernels.samples


@given(configurations)
def test_centre_of_mass_is_the_kernel_centre(kernels):
    if kernels.span > 1 or kernels.layout == "cut":
        return  # cut by the border, so are larger tiles
    mass = kernels.weights @ (kernels.points * kernels.half_sides)
    cell = 2 / np.sqrt(kernels.samples)
    assert np.allclose(mass, kernels.centres, atol=cell)


@given(
    st.sampled_from(["one", "2x2", "3x3", "4x4"]),
    st.floats(0.4, 1.5),
    st.floats(0.4, 2.5),
    st.booleans(),
)
def test_supports_stay_inside_the_object(layout, span, aspect, elliptic):
    span = min(span, 1.0) if layout == "one" else span
    kernels = Kernels(layout, span=span, aspect=aspect, elliptic=elliptic)
    if (kernels.radii <= kernels.half_sides).all():
        reach = np.abs(kernels.centres) + kernels.radii
        assert (reach <= kernels.half_sides + 1e-9).all()


def test_cut_kernels_reach_beyond_the_border_and_lose_what_lies_there():
    cut, whole = Kernels("cut", aspect=1.5), Kernels("3x3", aspect=1.5)
    assert np.allclose(cut.radii, whole.radii)
    assert (np.abs(cut.centres[0]) + cut.radii > cut.half_sides).all()
    mass = cut.weights @ (cut.points * cut.half_sides)
    lost = np.abs(cut.centres) - np.abs(mass)
    assert (lost[0] > 0.01).all() and np.allclose(lost[4], 0, atol=0.01)


def test_nine_kernels_have_the_span_of_the_fourth_row():
    kernels = Kernels(aspect=4 / 3)  # W = 2 sqrt(4/3), H = 2 sqrt(3/4)
    half_width, half_height = (4 / 3) ** 0.5, 0.75**0.5
    radius = 2 * half_height / 3
    assert np.allclose(kernels.radii, radius)
    assert np.allclose(kernels.centres[0], [radius - half_width, radius - half_height])


@pytest.mark.parametrize("aspect", [0.25, 1.0, 4.0])
def test_the_samples_cells_are_squares_on_the_object(aspect):
    kernels = Kernels("tiles", "uniform", aspect=aspect, samples=3600)
    steps = [np.diff(np.unique(along.round(9)))[0] for along in kernels.points.T]
    wide, high = steps * kernels.half_sides
    assert wide == pytest.approx(high, rel=0.02)


@pytest.mark.parametrize("aspect, across", [(1e-3, 0), (1e3, 1)])
def test_the_narrowest_object_has_one_row_of_samples(aspect, across):
    points = Kernels("ellipse", aspect=aspect, samples=100).points
    assert (points[:, across] == 0).all() and len(points) > 50


def test_a_uniform_kernel_counts_its_samples():
    kernels = Kernels("3x3", "uniform", aspect=1.5)
    assert (kernels.sums == (kernels.weights > 0).sum(1)).all()


def test_the_two_kernels_of_the_axes_fall_along_one_axis_each():
    kernels = Kernels("axes", aspect=1.5)
    x, y = kernels.points.T
    inside = x**2 + y**2 <= 1
    for weights, along in zip(kernels.weights, (x, y), strict=True):
        expected = np.where(inside, 1 - along**2, 0)
        assert np.allclose(weights, expected / expected.sum())


@pytest.mark.parametrize("aspect", [0.5, 1.0, 4 / 3])
def test_tiles_are_a_partition_of_the_whole_rectangle(aspect):
    kernels = Kernels("tiles", "uniform", aspect=aspect, samples=4800)
    assert kernels.parts is not None
    x, y = np.clip(((kernels.points + 1) * 1.5).astype(int), 0, 2).T
    assert (kernels.parts == 3 * y + x).all()
    assert abs(len(kernels.parts) - 4800) < 100


@pytest.mark.parametrize(
    "elliptic, x_end, y_end", [(False, 0.8, 0.2), (True, 0.0, 0.0)]
)
def test_ellipse_radii(elliptic, x_end, y_end):
    """With the printed radius the weight at the ends of the axes is 1 - (H / a)^2.

    These are .8 and .2 for 10 x 20; with the elliptic radius it is 0.
    """
    kernels = Kernels("ellipse", elliptic=elliptic, aspect=0.5, samples=40_000)
    relative = kernels.weights[0] / kernels.weights.max()
    x, y = kernels.points.T
    on_x, on_y = (np.abs(y) < 0.02) & (x > 0.98), (np.abs(x) < 0.02) & (y > 0.98)
    assert relative[on_x].mean() == pytest.approx(x_end, abs=0.05)
    assert relative[on_y].mean() == pytest.approx(y_end, abs=0.05)


def test_samples_are_interleaved():
    parts = Kernels("tiles", "uniform", aspect=1.0).parts
    assert len(set(parts[:9])) == 9 and len(set(parts[9:18])) == 9


@pytest.mark.parametrize(
    "field, value",
    [
        ("layout", "9x9"),
        ("profile", "gauss"),
        ("span", 0.0),
        ("aspect", np.nan),
        ("samples", -1),
        ("samples", 0.4),
        ("elliptic", "no"),
        ("elliptic", None),
        ("elliptic", [True]),
    ],
)
def test_bad_fields_are_named(field, value):
    with pytest.raises(ValueError, match=field):
        Kernels(**{field: value})


def test_the_kernels_of_axes_have_no_span():
    with pytest.raises(ValueError, match="span is 3"):
        Kernels("axes", span=3.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("span", [0.01, 1e-320])
def test_a_kernel_without_samples_says_so(span):
    kernels = Kernels("4x4", span=span, aspect=1.0, samples=100)
    with pytest.raises(ValueError, match="span"):
        _ = kernels.weights


ARRAYS = ("points", "weights", "sums", "parts", "radii", "half_sides", "homogeneous")


@pytest.mark.parametrize(
    "layout, name", [("3x3", "slopes"), *itertools.product(LAYOUTS, ARRAYS)]
)
def test_kernels_without_an_object_have_no_arrays(layout, name):
    """A square would be assumed in silence, which is wrong for most objects."""
    kernels = Kernels(layout)
    with pytest.raises(ValueError, match=r"not fitted .* take kernels\.fitted\(region"):
        getattr(kernels, name)


def test_fitting_takes_the_aspect_and_shares_the_arrays():
    fitted = Kernels().fitted([50, 40, 0.3, 20, 10])
    assert fitted == Kernels(aspect=2.0)
    assert fitted.points is Kernels().fitted([9, 9, 0, 4, 2]).points


@pytest.mark.parametrize("span", [0.5, 1.0, 2.0])
def test_an_elliptic_kernel_falls_with_the_square_of_its_span(span):
    kernels = Kernels("ellipse", elliptic=True, span=span, aspect=1.0, samples=4000)
    r2 = np.sum((kernels.points * kernels.half_sides) ** 2, -1)
    expected = np.where(r2 <= 1, np.maximum(1 - r2 / span**2, 0), 0)
    assert np.allclose(kernels.weights[0], expected / expected.sum())


def test_the_aspect_of_an_object_is_taken_to_its_sixth_digit():
    assert Kernels().fitted([0, 0, 0, 20, 13]).aspect == 1.538462


def test_an_object_as_narrow_as_a_thread_has_an_aspect_all_the_same():
    """What is left of it in the sixth digit; nine kernels say what to do about it."""
    thread = [50, 40, 0, 1e-4, 1e4]
    assert Kernels("ellipse").fitted(thread).weights.sum() == pytest.approx(1)
    with pytest.raises(ValueError, match=r"samples \(1200\) of the 3x3 kernels, take"):
        _ = Kernels("3x3").fitted(thread).weights


def test_the_slope_of_a_kernel_is_its_derivative():
    kernels = Kernels("2x2", aspect=1.3)
    plane, step = kernels.points * kernels.half_sides, 1e-6
    for axis in range(2):
        off = np.eye(2)[axis] * step
        ahead, behind = kernels.weigh(plane + off), kernels.weigh(plane - off)
        numeric = (ahead - behind) / (2 * step) / kernels.sums[:, None]
        inside = kernels._squared_radii(plane) < 0.99
        assert np.allclose(kernels.slopes[axis][inside], numeric[inside], atol=1e-6)


@pytest.mark.parametrize("layout", ["2x2", "3x3", "cut"])
def test_beyond_its_support_a_kernel_has_no_slope(layout):
    kernels = Kernels(layout, span=0.8, aspect=1.3)
    unseen = kernels.weights == 0
    assert unseen.any() and not kernels.slopes[:, unseen].any()
    assert kernels.slopes[:, ~unseen].any()


def test_nobody_can_write_to_what_equal_kernels_share():
    names = "points", "weights", "sums", "homogeneous", "slopes", "radii", "centres"
    nine = Kernels("3x3").fitted([50, 40, 0, 20, 10])
    tiles = Kernels("tiles", "uniform").fitted([50, 40, 0, 20, 10])
    shared = [*operator.attrgetter(*names)(nine), tiles.parts]
    for array in (*shared, *template(nine)):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


@pytest.mark.parametrize("sides", [(20, 0), (-5, -1), (np.nan, 1)])
def test_kernels_are_fitted_to_what_has_an_area(sides):
    with pytest.raises(ValueError, match="has no area|is not finite"):
        Kernels().fitted([50, 40, 0, *sides])


def test_kernels_wider_than_the_object_stand_in_its_middle():
    wide = Kernels("3x3", span=4.0, aspect=1.0)  # of a radius of 4/3 of half a side
    assert (wide.centres == 0).all()


def test_a_point_on_the_border_of_a_support_belongs_to_it():
    flat, turn = Kernels("one", "uniform", aspect=1.0), np.linspace(0, 7, 500)
    assert flat.weigh(np.stack([np.cos(turn), np.sin(turn)], -1)).all()
