"""The simulated camera: its motion, what it sees, and that its truth is right."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import norm

from mkt.regions import corners, displaced
from mkt.servoing.features import Camera, features, interaction_matrix
from mkt.servoing.robot import (
    Workspace,
    _homography,
    circle,
    move,
    place,
    to_and_fro,
)

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
    twist = np.random.default_rng(seed).standard_normal(6)
    twist[3:] *= 10.0 ** -(2 * seed)
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = np.cross(np.eye(3), twist[3:]), twist[:3]
    there = move(np.eye(4), twist, 0.7)
    np.testing.assert_allclose(there, expm(0.7 * generator), atol=1e-10)
    np.testing.assert_allclose(move(there, twist, -0.7), np.eye(4), atol=1e-12)


@pytest.mark.parametrize("car", [(0.0, 0.0, 0.0), (0.3, -0.2, 2.0), (-0.1, 0.5, -3.0)])
def test_facing_the_car_shows_it_where_it_is_wanted(car):
    workspace, car = Workspace(), np.array(car)
    wanted = np.array([100.0, 150.0, -0.4, 40.0, 25.0])
    pose = workspace.facing(wanted, car)
    np.testing.assert_allclose(workspace.truth(pose, car), wanted, atol=1e-9)
    np.testing.assert_allclose(workspace.outline(pose, car), corners(wanted), atol=1e-9)


VIEWS = {
    "above": AT_REST,
    "turned": (0.05, 0.05, -0.2, 0, 0, 0.5),
    "tilted": (0, 0.2, 0, 0.3, 0, 0.2),
    "aslant": (0.3, 0, 0, 0, -0.4, 0),
}


@pytest.mark.parametrize("twist", VIEWS.values(), ids=VIEWS)
def test_the_picture_shows_the_card_inside_its_outline(twist):
    """Pixels that change when the card is taken away are those inside its outline.

    The true region covers them too, but for perspective.
    """
    pose = above(SHARP, twist)
    gone = shot(SHARP, pose, path=((0.0, 0.0, -1.2, 0.0),))
    changed = (np.abs(shot(SHARP, pose).astype(int) - gone) > 0).any(-1)

    def overlap(polygon):
        inside = np.zeros(changed.shape, np.uint8)
        sixteenths = np.round(polygon * 16).astype(np.int32)
        cv2.fillPoly(inside, [sixteenths], 1, shift=4)
        return (inside & changed).sum() / (inside | changed).sum()

    assert overlap(SHARP.outline(pose, CAR)) > 0.94
    assert overlap(corners(SHARP.truth(pose, CAR))) > 0.88


def formula_and_slopes(region):
    """L (4, 6) of a region, and how the features of the true one change instead."""
    workspace, camera, step = Workspace(), Camera(), 1e-6
    pose = workspace.facing(region, CAR)

    def seen(twist, t):
        return features(workspace.truth(move(pose, twist, t), CAR), camera)

    slopes = [(seen(v, step) - seen(v, -step)) / (2 * step) for v in np.eye(6)]
    return interaction_matrix(region, camera, workspace.surface), np.transpose(slopes)


@pytest.mark.parametrize("dx, dy, turn", [(-60, 40, 0.5), (50, -30, -1.9)])
def test_the_row_of_theta_is_that_of_the_similarity_a_tracker_fits(dx, dy, turn):
    L, slopes = formula_and_slopes(displaced(DESIRED, dx=dx, dy=dy, dtheta=turn))
    np.testing.assert_allclose(L[3], slopes[3], atol=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_the_rows_of_moments_are_so_far_off_what_a_tracker_fits(seed):
    """As the docstring of L says; by no more than rounding in the other columns."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.3, 1.2)
    place = rng.uniform([0, 0, -np.pi], [319, 239, np.pi])
    region = np.array([*place, *(size * DESIRED[3:])])
    L, slopes = formula_and_slopes(region)
    off, (w, h) = L - slopes, Workspace().sides
    np.testing.assert_allclose(off[:, [0, 1, 2, 5]], 0, atol=1e-6)
    share = (w * w - h * h) / (w * w + h * h) / 3
    lengths = np.linalg.norm([off[2, 3:5], L[2, 3:5]], axis=1)
    assert lengths[0] / lengths[1] == pytest.approx(share, rel=1e-4)
    assert share == pytest.approx(0.15, abs=0.005)
    a_n = features(region, Camera())[2]
    assert 0.001 * a_n < np.abs(off[:2, 3:5]).max() < 0.06 * a_n


@pytest.mark.parametrize(
    "twist",
    [(0, 0, -3.0, 0, 0, 0.3), (0, 0.3, -0.5, 0.5, 0, 0.2)],
    ids=["far", "tilted"],
)
@pytest.mark.parametrize("table", ["workshop", "gravel"])
def test_nothing_aliases(twist, table):
    """A frame is close to one of a camera with 36 times the pixels, reduced.

    From far, the finest texture looked up plainly is 7 to 9 levels off.
    """
    k, workspace = 6, replace(SHARP, table=table)
    large = replace(workspace, camera=Camera(k * 400.0, (k * 320, k * 240)))
    pose = above(workspace, twist)
    fine = shot(large, pose)
    reference = cv2.resize(fine, (320, 240), interpolation=cv2.INTER_AREA)
    assert np.abs(shot(workspace, pose).astype(int) - reference).mean() < 3


def test_levels_of_the_car_are_rounded_and_not_cut_off():
    pose = above(SHARP, (0, 0, 0, 0, 0, 0.5))
    (left, top), part = SHARP._car(_homography(SHARP.camera, pose), CAR)
    height, width = part.shape[:2]
    seen = shot(SHARP, pose)[top : top + height, left : left + width]
    opaque = part[..., 3] == 1
    off = (seen - part[..., :3])[opaque]
    assert opaque.sum() > 4000 and off.mean() == pytest.approx(0, abs=0.1)


def test_the_exposure_averages_what_was_seen_before_the_instant():
    twist, pose = np.array([0.4, 0.2, 0, 0, 0, 0.3]), above(SHARP)
    open_shutter = replace(SHARP, exposure=0.05)
    lags = 0.05 * (np.arange(16) + 0.5) / 16
    instants = [shot(SHARP, move(pose, twist, -lag)) for lag in lags]
    mean = np.mean(np.array(instants, float), 0)
    off = np.abs(shot(open_shutter, pose, twist) - mean)
    assert off.max() < 8 and off.mean() < 0.5
    assert np.abs(shot(SHARP, pose, twist) - mean).mean() > 5
    moving = ((-1.0, -0.4, 0.0, np.pi / 2), (1.0, 0.4, 0.0, np.pi / 2))
    blurred = shot(open_shutter, pose, path=moving)
    assert np.abs(blurred.astype(int) - shot(SHARP, pose)).mean() > 0.5


def test_the_noise_is_the_sensors_and_follows_from_its_seed():
    noisy, pose = replace(SHARP, noise=4.0, table="gravel"), above(SHARP)
    first, again, other = (shot(noisy, pose, seed=s) for s in (0, 0, 1))
    assert (first == again).all()
    exact = shot(replace(noisy, noise=0.0), pose)
    middle = (exact > 40) & (exact < 215)
    difference = first.astype(float)[middle] - other[middle]
    assert np.std(difference) == pytest.approx(4 * np.sqrt(2), rel=0.05)


def test_the_noise_of_what_is_black_is_cut_off_at_black(monkeypatch):
    """Half of it is below, and the half of a level above is rounded down."""
    black = np.zeros((240, 320, 3), np.uint8)
    monkeypatch.setattr(Workspace, "_instant", lambda *_: black)
    dark = shot(replace(SHARP, noise=4.0), above(SHARP))
    assert (dark == 0).mean() == pytest.approx(norm.cdf(0.5 / 4), abs=0.01)


def test_the_hand_reverses_at_the_printed_frames():
    path = to_and_fro(wobble=0.0)
    y = np.array([place(path, 0.2 * k)[1] for k in range(80)])
    steps = 0.01 * np.repeat([0, 1, -1, 1, 0], [5, 25, 7, 28, 14])
    np.testing.assert_allclose(np.diff(y), steps, atol=1e-9)


def test_paths_follow_from_their_arguments():
    assert to_and_fro(1) == to_and_fro(1) != to_and_fro(2)
    assert to_and_fro(1, times=[1.0, 6.0, 7.4, 13.0]) == to_and_fro(1)

    def steps(wobble):
        path = to_and_fro(0, wobble=wobble)
        return np.diff([place(path, t)[1] for t in np.arange(1, 6, 0.1)])

    assert 0.02 < np.std(steps(0.1) - steps(0.0)) / 0.005 < 0.3
    x, y, theta = np.array([place(circle(0.08), t) for t in np.linspace(0, 23, 40)]).T
    np.testing.assert_allclose(np.hypot(x + 0.08, y), 0.08, rtol=1e-2)
    assert (theta == np.pi / 2).all()


TOO_LOW = above(SHARP, (0, 0, 1.0, 0, 0, 0))
PAST_THE_HORIZON = above(SHARP, (0, 0, 0, 1.5, 0, 0))


@pytest.mark.parametrize(
    "problem, call",
    [
        ("behind the camera", lambda: Workspace().truth(TOO_LOW, CAR)),
        ("behind the camera", lambda: shot(SHARP, PAST_THE_HORIZON)),
        ("width", lambda: Workspace(width=0.0)),
        ("table_width", lambda: Workspace(table_width=-1.0)),
        ("exposure", lambda: Workspace(exposure=-0.1)),
        ("noise", lambda: Workspace(noise=-1.0)),
        ("noise is 256; .* 255 grey levels", lambda: Workspace(noise=256)),
        ("car is 'nope'; it must be one of", lambda: Workspace(car="nope")),
        ("table is 'nope'; it must be", lambda: Workspace(table="nope")),
        ("camera is of the type int", lambda: Workspace(camera=400)),
        ("times is .*; give the start", lambda: to_and_fro(times=())),
        ("period is 0; it must be pos", lambda: circle(period=0)),
        ("length is nan; it must be", lambda: circle(length=np.nan)),
        ("no area", lambda: Workspace().facing([160, 120, 0, -9, 5], CAR)),
        ("times is .*; give the start", lambda: to_and_fro(times=(1.0, 6.0, 6.0))),
    ],
)
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()


def test_a_steady_hand_turns_back_at_the_times_and_nowhere_else():
    """With no wobble: straight along Y at the speed, from the times of figure 9."""
    t, x, y, theta = np.array(to_and_fro(wobble=0.0, speed=0.05, heading=0.7)).T
    assert t[0] == 1.0 and t[-1] == pytest.approx(13.0) and np.allclose(np.diff(t), 0.1)
    assert (x == 0).all() and np.allclose(theta, 0.7)
    forward = np.diff(y) > 0
    assert np.allclose(np.abs(np.diff(y)), 0.005)
    turns = t[1:][np.flatnonzero(np.diff(forward))]
    assert np.allclose(turns, [6.0, 7.4], atol=0.06)


def test_an_unsteady_hand_is_so_by_its_share_of_the_speed():
    """Spread of the noise over many seeds: the share itself, in each of the three."""
    rates = []
    for seed in range(60):
        t, x, y, theta = np.array(to_and_fro(seed, wobble=0.2, speed=0.1)).T
        steady = np.array(to_and_fro(seed, wobble=0.0, speed=0.1))[:, 2]
        rates.append(np.diff([x, y - steady, theta]) / 0.1)
    spread = np.concatenate(rates, 1).std(1)
    assert np.allclose(spread, [0.02, 0.02, 0.2], rtol=0.1)


def test_the_unsteady_hand_changes_within_half_a_second():
    """Neighbours 0.1 s apart are alike, those a second and a half apart are not."""
    x = np.array([np.array(to_and_fro(seed))[:, 1] for seed in range(60)])
    rate = np.diff(x)
    near = np.corrcoef(rate[:, :-1].ravel(), rate[:, 1:].ravel())[0, 1]
    half = np.corrcoef(rate[:, :-10].ravel(), rate[:, 10:].ravel())[0, 1]
    assert near > 0.98
    # exp(-(10 / (2 * 5))^2), a Gaussian of 5 steps with itself.
    assert half == pytest.approx(np.exp(-1), abs=0.08)


def test_a_circle_goes_round_through_the_origin_once_a_period():
    t, x, y, theta = np.array(circle(0.1, period=8.0, length=16.0, heading=0.3)).T
    assert t[0] == 0 and t[-1] == pytest.approx(15.9) and (theta == 0.3).all()
    assert np.allclose(np.hypot(x + 0.1, y), 0.1) and x[0] == y[0] == 0
    quarter = 20
    assert np.allclose([x[quarter], y[quarter]], [-0.1, 0.1])
    assert np.allclose([x[80], y[80]], 0, atol=1e-12)


def test_sub_frames_look_back_in_time():
    """The camera comes nearer, so it was further away while the shutter was open."""
    workspace, place = Workspace(exposure=0.1), [0.0, 0.0, 0.0]
    pose = workspace.facing([159.5, 119.5, 0, 60, 37.5], place)
    path = (0.0, *place), (9.0, *place)
    depth, way = -pose[2, 3], 0.5 * 0.1
    zoom = depth / (depth + way)
    jump = (1 - zoom) * 159.5  # of a pixel in the corner
    nearer = [0.0, 0, 0.5, 0, 0, 0]
    assert workspace._subframes(pose, nearer, path, 1.0) == np.ceil(jump)
