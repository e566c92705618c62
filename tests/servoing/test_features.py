"""Image features and their interaction matrices, against independent numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from mkt.regions import corners
from mkt.servoing.features import (
    Camera,
    error,
    features,
    interaction_matrix,
    moments,
)
from tests.servoing.tilted import interaction_matrix_tilted

MATRICES = Path(__file__).parent / "interaction_matrices.json"
CASES = json.loads(MATRICES.read_text())["cases"]
PARALLEL = [case for case in CASES if case["parallel"]]
CLOSE = {"rtol": 1e-7, "atol": 1e-9}
UNIT = Camera(1.0, (1, 1))  # its pixels are normalised coordinates
GOLDEN = np.array([0.15 / 0.8, 0.1 / 0.8, -0.7, 0.1 / 0.8, 0.06 / 0.8])


def name(case):
    return str(case["id"])


def region_of(case):
    x, y, z = case["centre"]
    turn, half = np.radians(case["turn_deg"]), 2 * z
    return np.array([x / z, y / z, turn, case["length"] / half, case["width"] / half])


@pytest.mark.parametrize("case", CASES, ids=name)
def test_the_tilted_oracle_s_matrices_equal_those_of_visp(case):
    corners, L = np.reshape(case["corners"], (4, 2)), np.reshape(case["matrix"], (4, 6))
    np.testing.assert_allclose(moments(corners), case["features"], **CLOSE)
    found = interaction_matrix_tilted(corners, case["plane"])
    np.testing.assert_allclose(found, L, **CLOSE)


@pytest.mark.parametrize("case", PARALLEL, ids=name)
def test_the_short_formula_holds_where_the_plane_is_parallel(case):
    region, surface = region_of(case), case["length"] * case["width"]
    L = interaction_matrix(region, UNIT, surface, "alpha")
    np.testing.assert_allclose(L, np.reshape(case["matrix"], (4, 6)), **CLOSE)
    s = features(region, UNIT, "alpha")
    np.testing.assert_allclose(s, case["features"], **CLOSE)


def test_the_golden_matrix():
    s, L = features(GOLDEN, UNIT), interaction_matrix(GOLDEN, UNIT, 0.2 * 0.12, "alpha")
    np.testing.assert_allclose(s, [0.9682, 0.6455, 5.1640, -0.7], atol=5e-5)
    expected = [
        [-6.455, 0, 0, -0.0944, -5.1522, 0.6455],
        [0, -6.455, 0, 5.1909, 0.0944, -0.9682],
        [0, 0, -6.455, -0.9682, 1.4524, 0],
        [0, 0, 0, -0.1908, -0.2814, -1],
    ]
    np.testing.assert_allclose(L, expected, atol=5e-5)


def rectangle(rng, tilt):
    """Corners (4, 3) [m] of a rectangle before the camera, and its plane (A, B, C)."""
    half = np.array([rng.uniform(0.1, 0.3), rng.uniform(0.04, 0.09), 0]) / 2
    flat = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * half
    turn = expm(np.cross(np.eye(3), [0, 0, rng.uniform(-1.2, 1.2)]))
    tilted = expm(np.cross(np.eye(3), tilt * np.append(rng.standard_normal(2), 0)))
    corners = flat @ turn.T @ tilted.T + rng.uniform([-0.2, -0.2, 0.6], [0.2, 0.2, 1.2])
    if not tilt:
        return corners, np.array([0, 0, 1 / corners[0, 2]])
    return corners, np.linalg.solve(corners[:3], np.ones(3))


def seen(corners, twist, t):
    """The image (4, 2) of corners (4, 3) after the camera moved by a twist for t."""
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = np.cross(np.eye(3), twist[3:]), twist[:3]
    world = np.column_stack([corners, np.ones(4)])
    x, y, z, _ = np.linalg.inv(expm(generator * t)) @ world.T
    return np.column_stack([x / z, y / z])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_the_tilted_oracle_s_matrices_are_derivatives(seed, tilt):
    corners, plane = rectangle(np.random.default_rng(seed), tilt)
    step = 1e-5

    def slope(v):
        after, before = seen(corners, v, step), seen(corners, v, -step)
        return (moments(after) - moments(before)) / (2 * step)

    L = interaction_matrix_tilted(seen(corners, np.zeros(6), 0), plane)
    slopes = np.transpose([slope(v) for v in np.eye(6)])
    np.testing.assert_allclose(L, slopes, rtol=1e-6, atol=1e-6)


def test_errors_are_wrapped():
    close = error([[1, 2, 3, np.pi - 0.1]], [1, 2, 3, -np.pi + 0.1])
    np.testing.assert_allclose(close, [[0, 0, 0, -0.2]], atol=1e-12)
    s, desired = [0, 0, 0, np.pi / 2 - 0.1], [0, 0, 0, -np.pi / 2 + 0.1]
    close = error(s, desired, "alpha")
    np.testing.assert_allclose(close, [0, 0, 0, -0.2], atol=1e-12)


def test_alpha_is_the_longer_axis():
    camera, region = Camera(), np.array([100.0, 80.0, 0.3, 20.0, 40.0])
    same = np.array([100.0, 80.0, 0.3 - np.pi / 2, 40.0, 20.0])
    s, t = (features(each, camera, "alpha") for each in (region, same))
    np.testing.assert_allclose(s, t)
    L, M = (interaction_matrix(each, camera, 0.01, "alpha") for each in (region, same))
    np.testing.assert_allclose(L, M, atol=1e-12)
    assert s[3] == pytest.approx(0.3 - np.pi / 2)
    assert features(np.array([region, same]), camera).shape == (2, 4)


def test_a_corner_may_lie_on_a_side():
    """Without it this is a triangle of area 2."""
    corners = [[0, 0], [2, 0], [4, 0], [0, 1]]
    for ordered in (corners, corners[::-1]):
        assert moments(ordered)[2] == pytest.approx(1 / np.sqrt(2))


def test_the_alpha_of_a_square_is_the_direction_of_its_hx():
    assert features([100, 80, 0.3, 20, 20], Camera(), "alpha")[3] == pytest.approx(0.3)


@pytest.mark.parametrize(
    "problem, call",
    [
        ("no area", lambda: features([0, 0, 0, 1, 0], UNIT)),
        ("no area", lambda: interaction_matrix([0, 0, 0, 1, 0], UNIT, 0.01)),
        (r"shape \(2, 5\)", lambda: interaction_matrix(np.ones((2, 5)), UNIT, 1.0)),
        ("no area", lambda: features([0, 0, 0, -1, -1], UNIT)),
        ("no area", lambda: moments(np.zeros((4, 2)))),
        ("corners have the shape", lambda: moments([[0, 0], [1, 0], [1, 1]])),
        ("crosses itself", lambda: moments([[0, 0], [1, 1], [1, 0], [0, 1]])),
        ("has a dent", lambda: moments([[0, 0], [2, 0], [0.5, 0.5], [0, 2]])),
        ("square", lambda: moments([[0, 0], [1, 0], [1, 1], [0, 1]])),
        ("square", lambda: moments([[0.1, 0.1], [1.1, 0.1], [1.1, 1.1], [0.1, 1.1]])),
        ("surface", lambda: interaction_matrix(GOLDEN, UNIT, 0.0)),
        ("surface", lambda: interaction_matrix(GOLDEN, UNIT, np.inf)),
        ("must have the shape", lambda: features(3.0, UNIT)),
        ("must have the shape", lambda: features([[100.0], [50.0]], UNIT)),
        ("square", lambda: interaction_matrix([0, 0, 0, 1, 1], UNIT, 0.01, "alpha")),
        ("focal", lambda: Camera(0.0)),
        ("focal", lambda: Camera("long")),
        ("angle is 'beta'", lambda: features(GOLDEN, UNIT, "beta")),
        (r"angle is \['theta'\]", lambda: features(GOLDEN, UNIT, ["theta"])),
        ("angle is 'beta'", lambda: interaction_matrix(GOLDEN, UNIT, 0.01, "beta")),
        ("angle is 'beta'", lambda: error([0, 0, 1, 0], [0, 0, 1, 0], "beta")),
    ],
)
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()


@pytest.mark.parametrize(
    "field, value",
    [("focal", np.inf), ("focal", 0.0), ("size", 320), ("size", (320, -240))],
)
def test_what_is_no_camera_is_refused_with_its_field(field, value):
    with pytest.raises(ValueError, match=rf"^{field} is"):
        Camera(**{field: value})


def test_a_rectangle_turned_by_an_eighth_has_an_axis():
    outline = corners([0, 0, np.pi / 4, 0.2, 0.1])
    assert moments(outline)[3] == pytest.approx(np.pi / 4)
