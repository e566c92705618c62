"""The simulated camera: its motion, what it sees, and that the picture and the truth agree."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.linalg import expm

from mkt.regions import corners, displaced
from mkt.robot import Workspace, circle, move, place, to_and_fro
from mkt.servo import Camera, features, interaction_matrix

DESIRED = np.array([159.5, 119.5, np.pi / 2, 50.0, 31.25])
STILL = ((0.0, 0.0, 0.0, np.pi / 2),)
CAR = np.array(STILL[0][1:])
AT_REST = np.zeros(6)
# A card fills its rectangle, so that its outline can be seen; no noise, no blur.
SHARP = Workspace(car="badge", exposure=0.0, noise=0.0)


def shot(workspace, pose, twist=AT_REST, path=STILL, seed=0):
    return workspace.frame(pose, twist, path, 0.0, np.random.default_rng(seed))


def above(workspace, twist=AT_REST):
    """A pose: straight above the car, then moved by a twist for a second."""
    return move(workspace.facing(DESIRED, CAR), twist, 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_pose_follows_the_exponential_map(seed):
    twist = np.random.default_rng(seed).standard_normal(6) * [1, 1, 1, *[10.0 ** -(2 * seed)] * 3]
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = np.cross(np.eye(3), twist[3:]), twist[:3]
    np.testing.assert_allclose(move(np.eye(4), twist, 0.7), expm(0.7 * generator), atol=1e-10)
    np.testing.assert_allclose(move(move(np.eye(4), twist, 0.7), twist, -0.7), np.eye(4), atol=1e-12)


@pytest.mark.parametrize("car", [(0.0, 0.0, 0.0), (0.3, -0.2, 2.0), (-0.1, 0.5, -3.0)])
def test_facing_the_car_shows_it_where_it_is_wanted(car):
    workspace, car = Workspace(), np.array(car)
    wanted = np.array([100.0, 150.0, -0.4, 40.0, 25.0])
    pose = workspace.facing(wanted, car)
    np.testing.assert_allclose(workspace.truth(pose, car), wanted, atol=1e-9)
    np.testing.assert_allclose(workspace.outline(pose, car), corners(wanted), atol=1e-9)


VIEWS = {"above": AT_REST, "turned": (0.05, 0.05, -0.2, 0, 0, 0.5), "tilted": (0, 0.2, 0, 0.3, 0, 0.2), "aslant": (0.3, 0, 0, 0, -0.4, 0)}


@pytest.mark.parametrize("twist", VIEWS.values(), ids=VIEWS)
def test_the_picture_shows_the_card_inside_its_outline(twist):
    """Pixels that change when the card is taken away are those inside the projected outline; the true region covers them too, but for perspective."""
    pose = above(SHARP, twist)
    gone = ((0.0, 0.0, -1.2, 0.0),)
    changed = np.abs(shot(SHARP, pose).astype(int) - shot(SHARP, pose, path=gone)).max(-1) > 0

    def overlap(polygon):
        inside = cv2.fillPoly(np.zeros(changed.shape, np.uint8), [np.round(polygon * 16).astype(np.int32)], 1, shift=4) > 0
        return (inside & changed).sum() / (inside | changed).sum()

    assert overlap(SHARP.outline(pose, CAR)) > 0.94
    assert overlap(corners(SHARP.truth(pose, CAR))) > 0.88


def test_the_row_of_theta_is_that_of_the_similarity_a_tracker_fits():
    workspace, camera, step = Workspace(), Camera(), 1e-6
    for region in (displaced(DESIRED, dx=-60, dy=40, dtheta=0.5), displaced(DESIRED, dx=50, dy=-30, dtheta=-1.9)):
        pose = workspace.facing(region, CAR)
        around = [[features(workspace.truth(move(pose, v, t), CAR), camera)[3] for t in (step, -step)] for v in np.eye(6)]
        row = interaction_matrix(region, camera, workspace.surface)[3]
        np.testing.assert_allclose(row, np.subtract(*np.transpose(around)) / (2 * step), atol=1e-6)


@pytest.mark.parametrize("twist", [(0, 0, -3.0, 0, 0, 0.3), (0, 0.3, -0.5, 0.5, 0, 0.2)], ids=["far", "tilted"])
@pytest.mark.parametrize("table", ["workshop", "gravel"])
def test_nothing_aliases(twist, table):
    """A frame is close to one of a camera with 36 times the pixels, reduced; from far, the finest texture looked up plainly is 7 to 9 levels off."""
    k, workspace = 6, replace(SHARP, table=table)
    large = replace(workspace, camera=Camera(k * 400.0, (k * 320, k * 240)))
    reference = cv2.resize(shot(large, above(workspace, twist)), (320, 240), interpolation=cv2.INTER_AREA)
    assert np.abs(shot(workspace, above(workspace, twist)).astype(int) - reference).mean() < 3


def test_the_exposure_averages_what_was_seen_before_the_instant():
    twist, open_shutter = np.array([0.4, 0.2, 0, 0, 0, 0.3]), replace(SHARP, exposure=0.05)
    pose = above(SHARP)
    lags = 0.05 * (np.arange(16) + 0.5) / 16
    mean = np.mean([shot(SHARP, move(pose, twist, -lag)).astype(float) for lag in lags], 0)
    blurred = shot(open_shutter, pose, twist)
    assert np.abs(blurred - mean).max() < 8 and np.abs(blurred - mean).mean() < 0.5
    assert np.abs(shot(SHARP, pose, twist) - mean).mean() > 5
    moving = ((-1.0, -0.4, 0.0, np.pi / 2), (1.0, 0.4, 0.0, np.pi / 2))
    assert np.abs(shot(open_shutter, pose, path=moving).astype(int) - shot(SHARP, pose)).mean() > 0.5


def test_the_noise_is_the_sensors_and_follows_from_its_seed():
    noisy, pose = replace(SHARP, noise=4.0, table="gravel"), above(SHARP)
    first, again, other = (shot(noisy, pose, seed=s) for s in (0, 0, 1))
    assert (first == again).all()
    middle = (shot(replace(noisy, noise=0.0), pose) > 40) & (shot(replace(noisy, noise=0.0), pose) < 215)
    assert np.std(first.astype(float)[middle] - other[middle]) == pytest.approx(4 * np.sqrt(2), rel=0.05)


def test_the_hand_reverses_at_the_printed_frames():
    path = to_and_fro(wobble=0.0)
    y = np.array([place(path, 0.2 * k)[1] for k in range(80)])
    np.testing.assert_allclose(np.diff(y), 0.01 * np.repeat([0, 1, -1, 1, 0], [5, 25, 7, 28, 14]), atol=1e-9)


def test_paths_follow_from_their_arguments():
    assert to_and_fro(1) == to_and_fro(1) != to_and_fro(2)
    steady, unsteady = (np.diff([place(to_and_fro(0, wobble=w), t) for t in np.arange(1, 6, 0.1)], axis=0) for w in (0.0, 0.1))
    assert 0.02 < np.std(unsteady[:, 1] - steady[:, 1]) / 0.005 < 0.3
    x, y, theta = np.array([place(circle(0.08), t) for t in np.linspace(0, 23, 40)]).T
    np.testing.assert_allclose(np.hypot(x + 0.08, y), 0.08, rtol=1e-2)
    assert (theta == np.pi / 2).all()


@pytest.mark.parametrize("problem, call", [
    ("behind the camera", lambda: Workspace().truth(above(SHARP, (0, 0, 1.0, 0, 0, 0)), CAR)),
    ("behind the camera", lambda: shot(SHARP, above(SHARP, (0, 0, 0, 1.5, 0, 0)))),
    ("width", lambda: Workspace(width=0.0)),
    ("table_width", lambda: Workspace(table_width=-1.0)),
    ("exposure", lambda: Workspace(exposure=-0.1)),
    ("noise", lambda: Workspace(noise=-1.0)),
])
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()
