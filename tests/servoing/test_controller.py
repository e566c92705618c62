"""The controller: what a step gives with and without a target, and what is refused."""

import numpy as np
import pytest

from mkt.servoing.controller import Servo
from mkt.servoing.features import error, features
from mkt.servoing.law import AdaptiveGain
from mkt.servoing.self_motion import OFF

BAD = {
    "dt": 0.0,
    "delay": -1,
    "patience": 0,
    "surface": -1.0,
    "gain": -1.0,
    "angle": "beta",
    "dof": [6],
    "camera": "webcam",
}


@pytest.mark.parametrize("field, value", BAD.items(), ids=BAD)
def test_bad_controllers_are_named(field, value):
    with pytest.raises(ValueError, match=field):
        Servo(**{field: value})


# The edges of what is allowed, and what a step leaves.
@pytest.mark.parametrize(
    "fields", [{"patience": 1}, {"gain": 0}, {"delay": 0}, {"dof": 4}]
)
def test_the_smallest_that_makes_sense_is_allowed(fields):
    assert Servo(**fields).init().missed == 0


@pytest.mark.parametrize(
    "field, value",
    [
        ("delay", 1.5),
        ("patience", 1.5),
        ("gain", np.inf),
        ("gain", AdaptiveGain),
        ("gain", np.ones(2)),
        ("dt", np.inf),
        ("desired", (1, 2, 3)),
        ("desired", list(Servo().desired)),
        ("desired", np.arange(1.0, 6)),
        ("desired", (np.nan,) * 5),
        ("desired", (1, 2, 0, 0, 3)),
        ("filter", None),
        ("dof", 5),
        ("dof", np.array([6, 4])),
        ("dof", "6"),
        ("angle", np.array(["theta", "alpha"])),
        ("angle", None),
    ],
)
def test_what_no_controller_can_do_is_refused_with_its_field(field, value):
    with pytest.raises(ValueError, match=rf"^{field} is .*; it must be"):
        Servo(**{field: value})


def test_a_square_is_no_goal_for_a_controller_of_alpha():
    square = (159.5, 119.5, 0.0, 40.0, 40.0)
    assert Servo(square).goal.shape == (4,)
    with pytest.raises(ValueError, match="desired is .* a square"):
        Servo(square, angle="alpha")


def test_a_tracker_that_is_lost_need_not_give_a_region():
    """The camera goes on as after any lost frame."""
    given, nothing = (lost_after(3, where=where) for where in (1, np.nan))
    for one, other in zip(given[1], nothing[1], strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.isnan(nothing[2].features).all() and np.isnan(nothing[2].error).all()
    known = features([170.0, 110.0, 1.4, 45.0, 28.0], Servo().camera)
    np.testing.assert_array_equal(given[2].features, known)
    np.testing.assert_array_equal(nothing[2].twist, given[2].twist)
    assert np.isnan(Servo().step(Servo().init(), None, lost=True)[1].features).all()


def test_a_target_without_area_is_refused():
    with pytest.raises(ValueError, match="surface is 0; it must be positive"):
        Servo(surface=0)


def lost_after(frames, where=1, **fields):
    """The state and command after some frames that see the target, and one that not.

    What is said in that one is the region times `where`.
    """
    servo = Servo(**fields)
    state, region = servo.init(), np.array([170.0, 110.0, 1.4, 45.0, 28.0])
    for k in range(frames):
        state, seen = servo.step(state, region + [2 * k, 0, 0, 0, 0])
    return seen, *servo.step(state, where * region, lost=True)


def test_a_lost_target_may_look_square_where_the_angle_is_alpha():
    given, square = (
        lost_after(3, where=np.array([1, 1, 1, 1, wide]), angle="alpha")
        for wide in (1, 45 / 28)
    )
    np.testing.assert_array_equal(square[2].twist, given[2].twist)


@pytest.mark.parametrize("delay", [0, 2])
def test_a_lost_frame_keeps_twist_and_filter_until_patience_ends(delay):
    seen, state, command = lost_after(3, patience=2, delay=delay)
    assert not seen.held and not command.held and state.missed == 1
    np.testing.assert_array_equal(command.twist, seen.twist)
    np.testing.assert_array_equal(command.estimated, seen.estimated)
    assert seen.estimated.any() and np.isnan(command.measured).all()
    assert state.error is None and state.filter.any()
    _, state, command = lost_after(3, patience=1, delay=delay)
    assert command.held and not command.twist.any()
    assert not command.estimated.any() and not state.filter.any()


def test_a_step_sees_the_target_unless_it_is_told_otherwise():
    servo = Servo()
    state, command = servo.step(servo.init(), np.array(servo.desired) + [9, 0, 0, 0, 0])
    assert state.missed == 0 and command.twist.any() and not command.held


@pytest.mark.parametrize("angle", ["theta", "alpha"])
def test_the_measured_motion_is_that_of_the_chosen_angle(angle):
    """The camera at rest: de/dt is the change of the error alone."""
    servo = Servo(angle=angle, gain=0, filter=OFF)
    first = np.array([159.5, 119.5, np.pi / 2 - 0.1, 50.0, 31.25])
    state, before = servo.step(servo.init(), first)
    _, after = servo.step(state, first + [5, 0, 0.1, 1, 1])
    expected = error(after.error, before.error, angle) / servo.dt
    np.testing.assert_allclose(after.measured, expected)
    assert not after.estimated.any()


@pytest.mark.parametrize("lost", [False, True])
def test_who_changes_a_command_does_not_change_the_state(lost):
    servo = Servo()
    region = np.array([150.0, 110.0, 0.1, 40.0, 25.0])
    state, _ = servo.step(servo.step(servo.init(), region, False)[0], region + 3, False)
    following, command = servo.step(state, region + 5, lost)
    before = [None if part is None else np.copy(part) for part in (*state, *following)]
    for part in (command.error, command.estimated, command.twist):
        part[:] = 99
    for part, was in zip((*state, *following), before, strict=True):
        if part is not None:
            np.testing.assert_array_equal(part, was)


@pytest.mark.parametrize("lost", [False, True])
def test_a_step_takes_one_region(lost):
    servo = Servo()
    with pytest.raises(ValueError, match=r"region has the shape \(2, 5\); give one"):
        servo.step(servo.init(), np.ones((2, 5)), lost)


def test_of_a_region_that_was_not_found_the_step_is_told():
    servo, nowhere = Servo(), np.full(5, np.nan)
    with pytest.raises(ValueError, match="nan.* is not finite; pass lost=True where"):
        servo.step(servo.init(), nowhere)
    assert servo.step(servo.init(), nowhere, lost=True)[0].missed == 1
