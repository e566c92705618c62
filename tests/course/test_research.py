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
    assert not any(lost for _, lost, _ in names["answers"])
    nothing = names["cv2"].VideoCapture("no such file")
    with pytest.raises(ValueError, match="no picture: is the camera there"):
        next(names["live"](nothing, names["tracker"], names["boxes"][0], None, 1))
    short = names["cv2"].VideoCapture("street.mkv")
    seen = names["live"](
        short, names["tracker"], names["boxes"][0], np.random.default_rng(0), 5
    )
    assert [lost for _, lost, _ in seen] == [False] * 3 + [True] * 2
    assert names["Brightness"](10)(np.full((1, 1, 3), 255, np.uint8)).labels.max() == 9
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
