"""From homographies to poses and back, and a law that leaves no tilt."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mkt.servoing import planes
from mkt.servoing.features import Camera
from mkt.servoing.planes import pose_of
from mkt.servoing.robot import Workspace, move, place

CAMERA, SIDES = Camera(), np.array([0.3, 0.2])


def pose_at(turn, way):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    pose[:3, 3] = way
    return pose


@pytest.mark.parametrize("seed", range(6))
def test_the_pose_comes_back_from_its_homography(seed):
    rng = np.random.default_rng(seed)
    pose = pose_at(rng.uniform(-0.7, 0.7, 3), [*rng.uniform(-0.1, 0.1, 2), 0.9])
    seen = planes.homography(pose, CAMERA, SIDES)
    assert seen[2, 2] == pytest.approx(1) != pose[2, 3]
    assert np.allclose(planes.pose_of(seen, CAMERA, SIDES), pose, atol=1e-6)


@pytest.mark.parametrize("factor", [-1, 7, -0.1])
def test_a_homography_has_one_pose_whatever_factor_it_comes_with(factor):
    """Where it was fitted, its last number may be any, and negative."""
    pose = pose_at([0.1, 0.2, 0.3], [0.05, 0, 0.9])
    seen = factor * planes.homography(pose, CAMERA, SIDES)
    assert np.allclose(planes.pose_of(seen, CAMERA, SIDES), pose, atol=1e-6)


def turned(degrees, about, tilt=0):
    """A pose 1 m away: turned about the view, then tilted about one axis [deg]."""
    turn = Rotation.from_rotvec([0, 0, np.deg2rad(degrees)])
    tilted = Rotation.from_rotvec(np.deg2rad(tilt) * np.eye(3)[about])
    return pose_at((tilted * turn).as_rotvec(), [0, 0, 1])


@pytest.mark.parametrize(
    "poses",
    [
        [turned(angle, 0) for angle in range(360)],
        [turned(180, 0, tilt) for tilt in range(1, 61)],
        [turned(180, 1, tilt) for tilt in range(1, 61)],
        [pose_at([0, 0, np.pi], [x / 10, -0.1, 0.7 + x / 5]) for x in range(-3, 4)],
    ],
)
def test_near_half_a_turn_too_the_pose_comes_back(poses):
    """There neither pose of IPPE need be one."""
    seen = [planes.homography(pose, CAMERA, SIDES) for pose in poses]
    found = [planes.pose_of(each, CAMERA, SIDES) for each in seen]
    assert np.allclose(found, poses, atol=1e-6)


@pytest.mark.parametrize(
    "seen",
    [
        np.full((3, 3), np.nan),
        np.ones((3, 3)),
        np.diag([1, 0, 1]),  # the plane seen from its edge
        np.eye(3)[::-1],
        np.eye(2),
    ],
)
def test_what_is_no_homography_has_no_pose(seen):
    with pytest.raises(ValueError, match="seen is .*; give a homography, 3 x 3 fin"):
        planes.pose_of(seen, CAMERA, SIDES)


@pytest.mark.parametrize("sides", [0.3, (0.3,), (0.3, -0.2), (0.3, np.nan)])
def test_a_rectangle_has_two_sides(sides):
    for call, given in (planes.homography, np.eye(4)), (planes.pose_of, np.eye(3)):
        with pytest.raises(ValueError, match="sides is .*; give the length and the wi"):
            call(given, CAMERA, sides)


@pytest.mark.parametrize(
    "pose",
    [
        pose_at([0, 0, 0], [0, 0, -0.8]),
        pose_at([0, 0, 0], [0, 0, 0]),
        pose_at([0, 1.5, 0], [0, 0, 0.9 * max(SIDES) / 2]),  # one edge is behind it
    ],
)
def test_what_is_not_in_front_of_the_camera_is_not_seen(pose):
    with pytest.raises(ValueError, match="pose puts the object at .* not in front of"):
        planes.homography(pose, CAMERA, SIDES)


@pytest.mark.parametrize("tilt, away", [(10, 0.8), (40, 2.0), (-40, 2.0)])
def test_of_two_tilts_that_look_alike_the_right_one_is_taken(tilt, away):
    pose = pose_at([np.deg2rad(tilt), 0, 0], [0, 0, away])
    found = planes.pose_of(planes.homography(pose, CAMERA, SIDES), CAMERA, SIDES)
    assert np.allclose(found, pose, atol=1e-5)


def test_near_a_right_angle_corners_a_little_off_say_a_little_tilt():
    """Their perspective tells it; how much the plane is shortened says 6 degrees."""
    rng = np.random.default_rng(0)
    seen = planes.homography(pose_at([0, 0, 0], [0, 0, 0.8]), CAMERA, SIDES)
    square = np.float32([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    tilts = []
    for _ in range(50):
        off = np.float32(planes.corners(seen) + rng.normal(0, 0.5, (4, 2)))
        given = cv2.getPerspectiveTransform(square, off)
        tilts.append(planes.tilt(planes.pose_of(given, CAMERA, SIDES)))
    assert np.rad2deg(np.median(tilts)) < 3


def test_the_homography_is_the_robots_outline():
    """The car's corners as the robot's own renderer has them."""
    work, car = Workspace(), np.array([0.03, -0.02, 0.4])
    camera = move(np.eye(4), [0.02, 0.1, -0.8, 0.2, -0.1, 0.3], 1.0)
    on_table = pose_at([0, 0, car[2]], [car[0], car[1], 0])
    seen = planes.homography(np.linalg.inv(camera) @ on_table, work.camera, work.sides)
    assert np.allclose(planes.corners(seen), work.outline(camera, car))
    assert (place(((0.0, *car),), 3.0) == car).all()


@pytest.mark.parametrize("gain", [0.5, 1.0])
def test_the_error_shrinks_exponentially_and_the_tilt_with_it(gain):
    desired = pose_at([0, 0, 0.3], [0, 0, 0.8])
    pose, dt = pose_at([0.4, -0.2, 0.9], [0.05, -0.03, 0.7]), 0.001
    v = planes.twist(pose, desired, gain)
    nearer = np.linalg.inv(move(np.eye(4), v, dt)) @ pose
    left = planes.twist(nearer, desired, gain)
    assert np.allclose(left[3:], v[3:] * np.exp(-gain * dt), atol=1e-6)
    for _ in range(round(8 / gain / 0.05)):
        v = planes.twist(pose, desired, gain)
        pose = np.linalg.inv(move(np.eye(4), v, 0.05)) @ pose
    assert np.allclose(pose, desired, atol=1e-3)


def test_tilt_is_the_angle_to_the_image():
    assert planes.tilt(pose_at([0.3, 0, 0], [0, 0, 1])) == pytest.approx(0.3)
    assert planes.tilt(pose_at([0, 0, 1.2], [0, 0, 1])) == 0
    rounded = np.diag([1, 1, np.nextafter(1, 2), 1])
    assert planes.tilt(rounded) == 0


def test_what_reaches_beyond_the_horizon_is_refused():
    """Its middle is in front of the camera, and a corner behind it."""
    seen = np.array([[50.0, 0, 160], [0, 50, 120], [2, 0, 1]])
    with pytest.raises(ValueError, match="a corner of the object lies at the horizon"):
        pose_of(seen, Camera(), [0.2, 0.1])
