"""The page's loop of visual servoing says what Python's says."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mkt.figures.registry import FIGURES
from mkt.papers.lessons import servoing
from mkt.servoing.controller import Servo
from mkt.servoing.features import error, features
from mkt.servoing.loop import Experiment, close_loop
from mkt.servoing.robot import OutOfSight, Workspace
from mkt.servoing.self_motion import OFF
from tests.live.conftest import ENGINE, assert_found, fixture_of

FRAMES = 31
RUN = """
const { scene, law, start, frames } = data;
return live.approached(scene, law, start, frames);
"""
THROUGH = """
const { scene, pose, points } = data;
return live.through(live.homography(scene, pose), points);
"""
MOTIONS = "return live.motions(data.scene, data.region, data.push);"
few = settings(
    max_examples=40, deadline=None, phases=[Phase.generate], derandomize=True
)
laws = st.fixed_dictionaries(
    {
        "gain": st.floats(0.05, 10),
        "dt": st.floats(1 / 30, 1),
        "delay": st.integers(0, 6),
        "dof": st.sampled_from([6, 4]),
    }
)
turns = st.integers(-90, 90)
places = st.fixed_dictionaries(
    {
        name: st.floats(*FIGURES["own.interaction"].sliders[name][:2])
        for name in ("x", "y", "turn", "scale")
    }
)


loop = fixture_of(ENGINE)


def scene_of(work):
    return {
        "focal": work.camera.focal,
        "size": work.camera.size,
        "sides": work.sides.tolist(),
        "car": servoing.CAR,
    }


def agrees(engine, law, turn):
    start = (0.05, -0.06, -0.12, 0.0, 0.0, float(np.deg2rad(turn)))
    work = Workspace()
    tried = Experiment(
        Servo(filter=OFF, **law),
        work,
        path=servoing.STILL,
        start=start,
        frames=FRAMES,
    )
    wanted = close_loop(tried, until_lost=True)
    scene = scene_of(work) | {"desired": tried.servo.desired}
    found = engine(RUN, scene=scene, law=law, start=start, frames=FRAMES)
    # One that runs away doubles the last digit's doubt in every frame.
    truly = error(features(wanted.truths, tried.servo.camera), tried.servo.goal)
    calm = np.abs(truly).max(1) < 10
    count = len(calm) if calm.all() else int(np.argmin(calm))
    assert count <= len(found)
    assert not calm.all() or len(found) == len(wanted.times)
    for k in range(count):
        outline = work.outline(wanted.poses[k], wanted.cars[k])
        np.testing.assert_allclose(found[k]["pose"], wanted.poses[k], atol=1e-6)
        np.testing.assert_allclose(found[k]["error"], truly[k], atol=1e-6)
        np.testing.assert_allclose(found[k]["twist"], wanted.velocities[k], atol=1e-5)
        np.testing.assert_allclose(found[k]["outline"], outline, atol=1e-3, rtol=1e-6)


def everywhere(engine):
    few(given(laws, turns)(lambda law, turn: agrees(engine, law, turn)))()


def test_the_approach_frame_by_frame(loop):
    everywhere(loop)


@pytest.mark.parametrize("depth", [0.03, 1e-6, -1e-6, -0.2])
def test_the_table_is_seen_from_as_near_as_in_python(loop, depth):
    work, pose = Workspace(), np.eye(4)
    pose[2, 3] = -depth
    corners = work.sides / 2 * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    found = loop(
        THROUGH, scene=scene_of(work), pose=pose.tolist(), points=corners.tolist()
    )
    if depth < 0:
        assert found is None
        with pytest.raises(OutOfSight):
            work.outline(pose, np.zeros(3))
    else:
        wanted = work.outline(pose, np.zeros(3))
        np.testing.assert_allclose(found, wanted, rtol=1e-6)


def moves_alike(engine, place):
    """The six motions of a car in view, and L, are those of the figure in Python."""
    wanted = FIGURES["own.interaction"].draw(**place)[1]
    work, halves = Workspace(), place["scale"] * np.array(servoing.HALVES)
    middle = 159.5 + place["x"], 119.5 + place["y"], np.deg2rad(place["turn"])
    push, region = servoing.PUSH.tolist(), [*middle, *halves]
    found = engine(MOTIONS, scene=scene_of(work), region=region, push=push)
    np.testing.assert_allclose(found["L"], wanted["L"], atol=1e-9)
    np.testing.assert_allclose(found["ways"], wanted["outlines"], atol=1e-6)


def all_over_the_image(engine):
    few(given(places)(lambda place: moves_alike(engine, place)))()


@pytest.mark.slow
def test_the_six_motions(loop):
    all_over_the_image(loop)


@pytest.mark.parametrize(
    "right", ["-1.5 * a * y", "axis === k ? far : 0", "step / STEPS"]
)
def test_a_planted_fault_of_the_motions_is_found(loop, right):
    wrong = {"-": "1.5 * a * y", "a": "axis === k ? -far : 0", "s": "step / 9"}[
        right[0]
    ]
    assert_found(loop, ENGINE, right, wrong, all_over_the_image)


FAULTS = {
    "no delay": "seen.length - 1 - delay",
    "a turn the other way": "[w[2], 0, -w[0]]",
    "no shear": "const k = q / p",
    "five axes": "4: [0, 1, 2, 5]",
}
INSTEAD = {
    "no delay": "seen.length - 1",
    "a turn the other way": "[w[2], 0, w[0]]",
    "no shear": "const k = 0",
    "five axes": "4: [0, 1, 2, 3, 5]",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(loop, fault):
    assert_found(loop, ENGINE, FAULTS[fault], INSTEAD[fault], everywhere)
