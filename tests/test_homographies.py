"""The group of homographies against its definition, and against scipy's exponential."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm

from mkt import homographies
from mkt.colors import BinImage
from mkt.histograms import histograms, sample
from mkt.kernels import Kernels
from mkt.regions import corners, displaced
from tests import strategies

GENERATORS = homographies.GENERATORS
SIDES = np.array([1.25, 0.8])
STEPS = arrays(float, 8, elements=st.floats(-0.5, 0.5))
FACING = homographies.of_regions([160, 120, 0.4, 50, 32])


@settings(deadline=None)  # scipy's first call may take long
@given(STEPS)
def test_exponential_is_scipys(step):
    wanted = expm(np.tensordot(step, GENERATORS, 1))
    assert np.allclose(homographies.exponential(step), wanted, atol=1e-12)


@pytest.mark.parametrize("steps", [0.1, np.zeros(9), np.zeros((2, 9))])
def test_a_step_has_no_more_components_than_there_are_parameters(steps):
    with pytest.raises(ValueError, match=r"steps have the shape .*; give \(\.\.\., k"):
        homographies.exponential(steps)


@given(STEPS)
def test_a_step_and_its_opposite_lead_back(step):
    there = homographies.moved(FACING, step, SIDES)
    assert np.allclose(homographies.moved(there, -step, SIDES), FACING, atol=1e-9)


def test_generators_are_a_basis_without_trace():
    assert np.abs(np.trace(GENERATORS, axis1=1, axis2=2)).max() < 1e-15
    assert np.linalg.matrix_rank(GENERATORS.reshape(8, 9)) == 8


@pytest.mark.parametrize("k", range(8))
def test_flow_is_the_derivative_of_the_motion_and_divergence_that_of_the_flow(k):
    points = np.random.default_rng(k).uniform(-1, 1, (6, 2))
    h = 1e-5

    def at(x, p):
        return homographies.through(homographies.exponential(x * np.eye(8)[k]), p)

    v, divergence = homographies.flow(points, 8)
    assert np.allclose((at(h, points) - at(-h, points)) / (2 * h), v[k], atol=1e-8)
    trace = np.zeros(len(points))
    for i, d in enumerate(h * np.eye(2)):
        ahead, behind = (homographies.flow(points + s * d, 8)[0][k] for s in (1, -1))
        trace += (ahead - behind)[:, i] / (2 * h)
    assert np.allclose(trace, divergence[k], atol=1e-8)


@given(STEPS)
def test_shear_and_shifts_turn_what_is_seen_and_not_theta_alone(step):
    here = homographies.moved(FACING, step, SIDES)
    h = 1e-5
    by = h * np.eye(8)
    ahead, behind = (
        homographies.angles(homographies.moved(here, x, SIDES)) for x in (by, -by)
    )
    wanted = np.sin(ahead - behind) / (2 * h)  # across -pi, too
    found = homographies.turning(here, SIDES, 8)
    assert np.allclose(found, wanted, atol=1e-4 * max(1, np.abs(wanted).max()))
    similar = homographies.turning(FACING, SIDES, 4)
    assert np.allclose(similar, [0, 0, 1, 0], atol=1e-12)


@given(strategies.regions())
def test_a_region_and_its_homography_see_the_same(region):
    seen = homographies.of_regions(region)
    assert np.allclose(homographies.corners(seen), corners(region))
    back = homographies.as_region(seen, region[3] / region[4])
    turn = np.angle(np.exp(1j * (back[2] - region[2])))
    assert np.allclose(back[[0, 1, 3, 4]], region[[0, 1, 3, 4]]) and abs(turn) < 1e-9


@given(strategies.regions())
def test_a_mirror_image_is_as_large_as_the_object(region):
    """An optimiser may turn a plane over; what is reported of it stays finite."""
    mirrored = homographies.of_regions(region) @ np.diag([-1.0, 1, 1])
    back = homographies.as_region(mirrored, region[3] / region[4])
    assert np.isfinite(back).all() and np.allclose(
        back[[0, 1, 3, 4]], region[[0, 1, 3, 4]]
    )


@pytest.mark.parametrize("origin, pitch", [((0.0, 0.0), 1), ((11.0, 7.0), 2)])
def test_what_is_looked_up_is_under_the_samples(origin, pitch):
    labels = np.random.default_rng(0).integers(0, 9, (200, 300), dtype=np.uint8)
    image = BinImage(labels, 9, origin=origin, pitch=pitch)
    kernels = Kernels("3x3", aspect=1.5625)
    tilted = homographies.moved(FACING, np.array([0, 0, 0, 0, 0, 0, 0.3, -0.2]), SIDES)
    x, y = homographies.through(tilted, kernels.points).T
    columns, rows = (
        np.rint((z - o) / pitch).astype(int)
        for z, o in zip((x, y), origin, strict=True)
    )
    found = sample(image, kernels, tilted)
    assert np.mean(found == labels[rows, columns]) > 0.999  # but for halves of a pixel
    q = histograms(image, kernels, [tilted])[0]
    counted = [np.bincount(found, row, 9) for row in kernels.weights]
    assert np.allclose(q, counted, atol=1e-6)


def test_beyond_the_horizon_nothing_is_seen():
    image = BinImage(np.zeros((240, 320), np.uint8), 1)
    kernels = Kernels("one", aspect=1.0)
    steep = np.array(FACING)
    steep[2] = [3.0, 0.0, 1.0]
    seen = sample(image, kernels, steep) == 0
    depths = kernels.points @ [3.0, 0.0] + 1
    assert not seen[depths < 0].any() and seen[depths > 0.5].all()


def test_corner_error_of_a_shift_is_its_length():
    regions = displaced([160, 120, 0.4, 50, 32], [0, 3], [0, 4])
    truth, shifted = homographies.of_regions(regions)
    assert homographies.corner_error(shifted, truth) == pytest.approx(5)


def test_places_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"\(\.\.\., 5\)"):
        homographies.as_places(np.zeros((4, 3)))


@given(STEPS, st.floats(0.2, 5))
def test_slope_and_region_are_those_at_the_middle_whatever_the_scale(step, scale):
    """The slope by differences; a homography times a number is the same map."""
    h = homographies.moved(FACING, step, SIDES)
    tiny = 1e-5
    ends = homographies.through(h, [[tiny, 0], [-tiny, 0], [0, tiny], [0, -tiny]])
    columns = (ends[::2] - ends[1::2]) / (2 * tiny)
    assert np.allclose(homographies.slope_at_middle(h), columns.T, atol=1e-3)
    assert np.allclose(
        homographies.slope_at_middle(scale * h), homographies.slope_at_middle(h)
    )
    once, again = (homographies.as_region(each, 1.5) for each in (h, scale * h))
    assert np.allclose(once, again)
    both = homographies.as_region(np.array([[h, scale * h]]), 1.5)
    assert (both == [[once, again]]).all()
    assert np.allclose(once[:2], homographies.through(h, [[0.0, 0.0]])[0])


def test_the_corner_error_of_many_is_that_of_each():
    steps = np.random.default_rng(0).normal(0, 0.1, (3, 8))
    many = homographies.moved(FACING, steps, SIDES)
    errors = homographies.corner_error(many, FACING)
    for one, error in zip(many, errors, strict=True):
        off = homographies.corners(one) - homographies.corners(FACING)
        assert error == pytest.approx(np.sqrt(np.mean(np.sum(off**2, -1))))


@pytest.mark.parametrize(
    "tilt, far, near", [("tilt_x", [1, 2], [0, 3]), ("tilt_y", [2, 3], [0, 1])]
)
def test_a_tilt_takes_the_right_side_away_or_the_lower_one(tilt, far, near):
    step = 0.2 * np.eye(8)[homographies.PARAMETERS.index(tilt)]
    seen = homographies.corners(homographies.moved(np.eye(3), step, np.ones(2)))
    length = [np.linalg.norm(np.diff(seen[side], axis=0)) for side in (far, near)]
    assert length[0] < 0.9 * length[1]


def test_a_moved_homography_has_1_as_its_last_element():
    step = np.array([0.1, 0, 0, 0.5])
    assert homographies.moved(np.eye(3), step, np.array([1.25, 0.8]))[2, 2] == 1
