"""From the homography of a plane to its pose, and from there to the camera's velocity.

With the camera calibrated, the homography of an object of known size says where it is
in space and how it is turned: H ~ K [hx r_1, hy r_2, t].  Four features of a region
leave the camera's tilt in the null space of their interaction matrix; the pose does
not.

Explained in notebook 16.
"""

import reprlib

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from mkt.checks import are_finite, in_words
from mkt.homographies import corners
from mkt.regions import corners as outline
from mkt.servoing.features import Camera
from mkt.types import Array, ArrayLike


def homography(pose: Array, camera: Camera, sides: ArrayLike) -> Array:
    """How a rectangle in space is seen.

    Parameters
    ----------
    pose : (4, 4) array
        From the object's coordinates to the camera's [m].
    camera : Camera
    sides : (2,) array_like [m]
        Its length and width.

    Returns
    -------
    (3, 3) array
        From the canonical square to the image [px].

    Raises
    ------
    ValueError
        For sides that are not two positive numbers, and for a pose in which a corner is
        not in front of the camera.
    """
    h = camera.matrix @ pose[:3, [0, 1, 3]] * np.array([*_half(sides), 1.0])
    # The nearest corner; a camera's matrix leaves depths as they are.
    if not h[2, 2] - np.abs(h[2, :2]).sum() > 0:
        raise ValueError(
            f"pose puts the object at {in_words(pose[:3, 3])} m, a part of it not in "
            "front of the camera; give it a z beyond half its diagonal"
        )
    return h / h[2, 2]


def _half(sides: ArrayLike) -> Array:
    """The half sides (2,) of a rectangle."""
    if not (are_finite(sides, 2) and np.min(sides) > 0):
        raise ValueError(
            f"sides is {sides}; give the length and the width, two positive numbers"
        )
    return np.asarray(sides, float) / 2


def pose_of(seen: Array, camera: Camera, sides: ArrayLike) -> Array:
    """The pose (4, 4) that explains a homography best.

    A plane that is tilted to one side looks nearly as if tilted to the other where the
    perspective is weak; ``cv2.solvePnPGeneric`` with IPPE (Collins and Bartoli, 2014)
    gives both.  Each is then fitted to the four corners (``cv2.solvePnPRefineLM``), and
    the better one counts: by itself IPPE takes the size of a tilt from how much the
    plane is shortened, which near a right angle is next to nothing, and says 6 to 10
    degrees for 2.  Near half a turn IPPE may give neither, so the pose that the columns
    of the homography say themselves is fitted as well.

    Parameters
    ----------
    seen : (3, 3) array
        A homography.
    camera : Camera
    sides : (2,) array_like [m]
        Of the object.

    Raises
    ------
    ValueError
        For sides that are not two positive numbers, and for what is no homography, or
        one of which a corner lies beyond the horizon.
    """
    rectangle = outline([0, 0, 0, *_half(sides)])
    _check_homography(seen)
    seen = seen / seen[2, 2]  # what is seen lies in front of the camera
    in_space = np.column_stack([rectangle, np.zeros(4)])
    image = np.ascontiguousarray(corners(seen))
    given = in_space, image, camera.matrix, None
    found = cv2.solvePnPGeneric(*given, flags=cv2.SOLVEPNP_IPPE)
    starts = [*zip(found[1], found[2], strict=True), _by_columns(seen, camera, sides)]
    fitted = []
    for turn, way in starts:
        turn, way = (
            np.asarray(part, float) for part in cv2.solvePnPRefineLM(*given, turn, way)
        )
        again = cv2.projectPoints(in_space, turn, way, camera.matrix, None)[0][:, 0]
        off = np.sum((again - image) ** 2)
        if np.isfinite(off):  # a start that is NaN stays NaN
            fitted.append((off, _pose(turn, way)))
    return min(fitted, key=lambda each: each[0])[1]


def _check_homography(seen: Array) -> None:
    """Refuse what shows no plane, or one whose middle lies at the horizon."""
    given = are_finite(seen, 3, 3) and np.linalg.matrix_rank(seen) == 3
    if not (given and seen[2, 2]):
        raise ValueError(
            f"seen is {reprlib.repr(np.asarray(seen).tolist())}; give a homography, "
            "3 x 3 finite numbers that can be inverted, the last one not 0"
        )
    if np.abs(seen[2, :2]).sum() >= abs(seen[2, 2]):
        raise ValueError(
            f"the last row of seen is {in_words(seen[2])}: a corner of the object lies "
            "at the horizon or beyond it; give a homography of what a camera sees"
        )


def _by_columns(seen: Array, camera: Camera, sides: ArrayLike) -> tuple[Array, Array]:
    """The turn (3, 1) and the way (3, 1) next to the columns of a homography."""
    columns = np.linalg.solve(camera.matrix, seen) / [*_half(sides), 1.0]
    columns /= np.sqrt(np.prod(np.linalg.norm(columns[:, :2], axis=0)))
    x, y, way = columns.T
    left, _, right = np.linalg.svd(np.column_stack([x, y, np.cross(x, y)]))
    turn = Rotation.from_matrix(left @ right).as_rotvec()
    return turn[:, None], way[:, None]


def _pose(turn: Array, way: Array) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(turn.ravel()).as_matrix()
    pose[:3, 3] = way.ravel()
    return pose


def twist(pose: Array, desired: Array, gain: float) -> Array:
    """The camera's velocity that brings a pose of the object to the desired one.

    The object's pose relative to where it should be shrinks exponentially, its rotation
    vector and the camera's way alike.

    Parameters
    ----------
    pose, desired : (4, 4) array
        From the object's coordinates to the camera's.
    gain : float [1/s]

    Returns
    -------
    (6,) array [m/s, rad/s]
        In the camera's frame.
    """
    camera = pose @ np.linalg.inv(desired)  # the desired camera, seen from this one
    turn = Rotation.from_matrix(camera[:3, :3]).as_rotvec()
    return gain * np.concatenate([camera[:3, 3], turn])


def tilt(pose: Array) -> float:
    """The angle [rad] between a plane of a pose (4, 4) and the image."""
    return float(np.arccos(min(abs(pose[2, 2]), 1.0)))
