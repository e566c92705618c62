"""Runs of figures: one is kept for all that it depends on, and for nothing less."""

import numpy as np
import pytest

from mkt.papers import runs
from mkt.papers.lessons.loops import locus
from mkt.papers.lessons.planes import look
from mkt.papers.lessons.wishes import exchanged
from mkt.papers.nummiaro2003.costs import step_costs
from mkt.scenes.layers import Layer
from mkt.scenes.paths import standing
from mkt.scenes.rendering import Scene
from mkt.servoing.loop import Experiment
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.particle_filter import ParticleFilter

CAT = Scene(Layer("cat", 40.0, standing(50, 40)), length=3, size=(100, 80))
CAR = Scene(Layer("car", 40.0, standing(50, 40)), length=3, size=(100, 80))
STANDING = Experiment(frames=2)
FIVE, SIX = ParticleFilter(n=5), ParticleFilter(n=6)


@pytest.fixture(autouse=True)
def forgetful(tmp_path, monkeypatch):
    """Nothing is known, neither on disk nor in memory."""
    monkeypatch.setenv("MKT_CACHE", str(tmp_path))
    runs.run.cache_clear()


@pytest.mark.parametrize(
    "other", [(FIVE, CAT, 1), (SIX, CAT, 0), (FIVE, CAR, 0)], ids=["seed", "n", "scene"]
)
def test_another_tracker_source_or_seed_is_another_run(other):
    first, second = runs.run(FIVE, CAT, 0), runs.run(*other)
    assert not np.array_equal(first.regions, second.regions)


def test_a_run_is_read_as_it_was_made():
    made = runs.run(FIVE, CAT, 3, keep=("particles",))
    runs.run.cache_clear()
    read = runs.run(FIVE, CAT, 3, keep=("particles",))
    assert read is not made and read.info.keys() == made.info.keys()
    assert np.array_equal(read.regions, made.regions)
    assert np.array_equal(
        read.info["particles"], made.info["particles"], equal_nan=True
    )
    assert "particles" not in runs.run(FIVE, CAT, 3).info


@pytest.mark.parametrize(
    "shared",
    [
        lambda: [runs.clip(CAT).truth, runs.clip(CAT).visibility],
        lambda: [*runs.run(FIVE, CAT)[:3], *runs.run(FIVE, CAT).info.values()],
        lambda: runs.loop_run(STANDING),
        lambda: locus("off", 0, 5, 1.0),
        lambda: look("base", 1001),
        lambda: exchanged(0, True, 0.0).values(),
        lambda: [step_costs(Adaptive(n=5), "car", frames=1)],
    ],
    ids=["clip", "run", "loop", "locus", "look", "exchanged", "costs"],
)
def test_what_is_kept_for_all_is_changed_by_nobody(shared):
    arrays = list(shared())
    assert arrays and not any(array.flags.writeable for array in arrays)
    with pytest.raises(ValueError, match="read-only"):
        arrays[0][:] = 0


def test_regions_have_a_row_for_each_tracker_and_a_column_for_each_seed():
    found = runs.regions([FIVE, SIX], CAT, range(2))
    assert found.shape == (2, 2, 3, 5)
    assert np.array_equal(found[1, 1], runs.run(SIX, CAT, 1).regions)
