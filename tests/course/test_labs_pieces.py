"""The right pieces of labs are right."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mkt.course.labs import pieces
from mkt.homographies import GENERATORS, flow


@given(st.lists(st.integers(0, 4), min_size=1, max_size=30))
def test_the_histogram_counts_what_is_inside(labels):
    labels = np.array([*labels, 0])
    weights = np.arange(1.0, len(labels) + 1)
    inside = labels < 4
    wanted = [weights[labels == u].sum() / weights[inside].sum() for u in range(4)]
    assert np.allclose(pieces.histogram(labels, weights, 4), wanted)


def test_the_velocities_are_those_of_the_library_and_may_be_complex():
    points = np.random.default_rng(0).uniform(-1, 1, (20, 2))
    for generator, v in zip(GENERATORS, flow(points, 8)[0], strict=True):
        assert np.allclose(pieces.velocity(generator, points), v, atol=1e-5)
    assert np.iscomplexobj(pieces.velocity(GENERATORS[0], points + 1e-9j))


def test_what_moves_on_with_the_target_are_the_runners():
    centres, walk = np.random.default_rng(0).normal(size=(2, 4, 2))
    runs = np.array([True, False, True, False])
    there = pieces.moved(centres, np.array([3.0, -1.0]), runs, walk)
    assert np.allclose(there[~runs], (centres + walk)[~runs])
    assert np.allclose(there[runs], (centres + walk + [3, -1])[runs])


@given(st.floats(0, np.pi), st.floats(-3, 3))
def test_the_tilt_is_how_far_a_plane_is_turned_out_of_the_image(angle, about):
    """About any axis in the image, seen from the front or from behind."""
    c, s = np.cos(about), np.sin(about)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(angle), np.sin(angle)
    lean = turn @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ turn.T
    C = np.array([[500.0, 0, 160], [0, 500, 120], [0, 0, 1]])
    H = C @ np.column_stack([lean[:, :2], [0.1, -0.2, 3.0]])
    tilt = pieces.tilt(H / H[2, 2], C)
    assert np.isclose(tilt, min(angle, np.pi - angle), atol=1e-6)
