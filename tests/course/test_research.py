"""The pieces of Python in RESEARCH.md run, one after the other."""

import re

import numpy as np
import pytest

from mkt.evaluation import overlap
from mkt.experiments import cache
from mkt.files import ROOT
from tests.own_video import films


@pytest.mark.slow
def test_every_piece_runs_and_finds_what_it_should(tmp_path, monkeypatch):
    text = (ROOT / "RESEARCH.md").read_text(encoding="utf-8")
    pieces = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    clip = films.driving(4)
    films.write(tmp_path / "street.mkv", clip.frames)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec("\n".join(pieces), names)
    car = [(k, region) for k, i, region, _ in names["found"] if i == 0]
    assert len(names["found"]) == 2 * 3 and [k for k, _ in car] == [1, 2, 3]
    assert overlap(car[-1][1], clip.truth[3]) > 0.6
    assert [latency > 0 for _, _, latency in names["answers"]] == [True, True]
    assert names["straight"].shape == clip.frames[0].shape
    assert (np.abs(names["twist"]) <= names["limits"] + 1e-12).all()
    assert (np.abs(names["within"](np.full(6, 9.0))) <= names["limits"] + 1e-12).all()
    assert sorted(names["rows"]["n"].unique()) == [10, 20]
    assert (names["ours"].info["distance"][1:] < 0.5).all()
    assert names["street"]["source"].tolist() == ["street"]
    before = cache.key(names["labelled"])
    boxes = tmp_path / "boxes.txt"
    boxes.write_text(boxes.read_text().replace("5.0", "5.1"))
    assert cache.key(names["labelled"]) != before
