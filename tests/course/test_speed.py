"""What ``python3 -m mkt bench`` prints; that it is fast is for a quiet machine."""

import re

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.course import speed
from mkt.histograms import histograms


@pytest.fixture
def tables(monkeypatch, capsys):
    """All that is printed, with each contender run once, and on little, and its name.

    The first contender of a table takes a millisecond, the next one two, and so on.
    """
    names = []

    def once(contenders, repeats=speed.ROUNDS):
        for name, work in contenders.items():
            work()
            names.append(str(name))
        taken = enumerate(contenders, 1)
        return {name: np.full(repeats, float(k)) for k, name in taken}

    monkeypatch.setattr(speed, "side_by_side", once)
    monkeypatch.setattr(speed, "_drawn", lambda name: speed.FIGURES[name])
    monkeypatch.setattr(speed, "cost_surfaces", lambda *_: None)
    for name, few in {
        "PARTICLES": 3,
        "COUNTS": (1, 2),
        "STEPS": 1,
        "FRAMES": 2,
    }.items():
        monkeypatch.setattr(speed, name, few)
    speed.main()
    return capsys.readouterr().out.strip().split("\n\n"), names


def test_each_contender_works_and_has_a_line_in_its_table(tables):
    printed, names = tables
    assert len(printed) == 6
    lines = iter("\n".join(printed).splitlines())
    for name in names:  # in this order
        assert any(name in line for line in lines), name
    for table in printed[2:]:
        head, *rows = table.splitlines()
        assert "CPU ms" in head
        ratios = [float(re.search(r"([\d.]+) x$", row)[1]) for row in rows]
        assert ratios == [*range(1, len(rows) + 1)]


def test_the_rivals_of_the_core_count_the_same_as_it_does():
    """Or the ratios would compare unlike things."""
    frame, regions = speed._frame_and_particles(20)
    image = ColorBins()(frame)
    ours = histograms(image, speed.TILES, regions)
    assert np.abs(speed.one_shot_numpy(image, speed.TILES, regions) - ours).max() < 1e-6
    theirs = speed.warp_and_nine_histograms(image, regions)
    assert np.abs(theirs - ours).sum(-1).mean() < 0.1
