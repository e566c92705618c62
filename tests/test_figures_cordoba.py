"""What the figures of [C14] must show; on the twins, whatever data there are."""

import shutil

import cv2
import numpy as np
import pytest

from mkt import figures
from mkt.figures.cordoba2014 import found_again, moments
from mkt.figures.cordoba2014_material import NAMES, TABLE, material, said, source
from mkt.figures.cordoba2014_resampling import ancestors
from mkt.figures.cordoba2014_table import _percent
from mkt.particles import systematic
from mkt.regions import to_box
from mkt.scenes import Scene, sequence
from mkt.trackers.catalogue import TRACKERS
from mkt.tracking import Sequence
from mkt.twins import TWINS


@pytest.fixture(autouse=True)
def twins_only(monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)


def drawn(name, **parameters):
    return figures.get(f"cordoba2014.{name}").draw(50, **parameters)


def texts(canvas):
    return " ".join(text.get_text() for text in [*canvas.texts, *(text for ax in canvas.axes for text in [*ax.texts, ax.title])])


@pytest.mark.parametrize("kind", TABLE)
def test_without_the_benchmark_a_twin_stands_in(kind):
    assert isinstance(source(kind), Scene)
    assert "synthetic twin" in said(kind, source(kind))


@pytest.fixture
def bobot(tmp_path, monkeypatch):
    """A small BoBoT whose six sequences are one: a twin's first frames, the object hidden in the last of them; MKT_DATA names it."""
    clip = sequence(TWINS["pillars"](0))
    first = tmp_path / "bobot" / f"{TABLE['clutter'].bobot}_x"
    (first / "frames").mkdir(parents=True)
    for k in range(16):
        cv2.imwrite(str(first / "frames" / f"{k:04d}.png"), clip.frames[k][..., ::-1])
    boxes = np.where(np.arange(16)[:, None] < 12, to_box(clip.truth[:16]) / [320, 240, 320, 240], 0)
    (first / "truth.txt").write_text("\n".join(f"{k} " + " ".join(f"{x:.6f}" for x in box) for k, box in enumerate(boxes)))
    for row in list(TABLE.values())[1:]:
        shutil.copytree(first, first.parent / f"{row.bobot}_x")
    monkeypatch.setenv("MKT_DATA", str(tmp_path))


@pytest.mark.parametrize("name", ["fig1", "fig2", "ablation"])
def test_with_the_benchmark_its_sequence_is_used_and_the_picture_says_so(name, bobot):
    canvas, _ = drawn(name, **({"runs": 1} if name == "ablation" else {}))
    assert "BoBoT/Vid_" in texts(canvas) and "CC BY-SA" in texts(canvas) and "synthetic" not in texts(canvas)


def test_the_whole_table_has_a_column_for_each_tracker(bobot):
    canvas, shown = drawn("table1", runs=1, also="all")
    assert set(shown["names"]) == set(TRACKERS) and shown["means"].shape == (6, len(TRACKERS))
    assert (shown["means"] <= 100 * 11 / 15 + 1e-9).all() and shown["means"][:, 0].min() > 50  # hidden in four of 15 frames
    assert all(name in texts(canvas) for name in TRACKERS if name not in NAMES) and texts(canvas).count("BoBoT/Vid_") == 6


def test_pillars_pfhr_finds_its_target_again_where_window_matching_does_not():
    canvas, shown = drawn("fig6")
    assert "synthetic twin" in texts(canvas)
    assert shown["occlusions"] == 3
    assert shown["pfhr"]["found again"].mean() > 2 > shown["wm"]["found again"].mean()
    assert shown["pfhr"]["true positives"].mean() > shown["wm"]["true positives"].mean() + 10


def test_film_and_curves_show_the_same_run():
    _, film = drawn("fig5")
    _, curves = drawn("fig6")
    for name in ("wm", "sir", "pfhr"):
        assert 100 * film["true positives"][name] == pytest.approx(curves[name]["true positives"][0])
    assert len(film["frames"]) == 8 == len(set(film["frames"]))


def test_table_is_printed_beside_ours_and_falls_with_the_limit():
    canvas, loose = drawn("table1", runs=1, t_lim=0.2)
    _, strict = drawn("table1", runs=1, t_lim=0.8)
    assert (strict["means"] <= loose["means"]).all() and (strict["means"] < loose["means"]).any()
    assert loose["means"].shape == (6, 3) and (loose["means"] <= 100).all()
    assert all(value in texts(canvas) for row in TABLE.values() for value in row.printed)
    np.testing.assert_allclose(loose["overall"], loose["means"].mean(0))


def test_hidden_frames_count_in_the_table():
    """No tracker can reach 100 % where the target is hidden."""
    origin = source("pillars")
    hidden = np.mean(material(origin).visibility[1:] <= 0.5)
    assert _percent(TRACKERS["pfhr"], origin, 0.0, 1)[0] <= 100 * (1 - hidden) + 1e-9


def test_ablation_names_each_part_and_the_printed_sign_of_an_occlusion_is_the_worst():
    _, shown = drawn("ablation", runs=2)
    means = dict(zip(shown["names"], shown["shares"].mean(1)))
    assert means["PFHR"] > means["occlusion by N_eff, as printed"]
    assert means["PFHR"] > means["no occlusion mode"]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_both_searches_draw_what_systematic_resampling_draws(seed):
    weights = np.random.default_rng(seed).dirichlet(np.ones(60))
    u = (np.arange(60) + np.random.default_rng(seed).random()) / 60
    (anew, many), (swept, few) = (ancestors(np.cumsum(weights), u, anew) for anew in (True, False))
    np.testing.assert_array_equal(anew, swept)
    np.testing.assert_array_equal(swept, systematic(weights, np.random.default_rng(seed)))
    assert few <= 2 * 60 - 1 < many == np.sum(anew + 1)


def test_exponents_one_and_two():
    for seed in range(3):
        _, shown = drawn("complexity", largest=400, seed=seed)
        assert shown["sweep"]["exponent"] == pytest.approx(1, abs=0.05)
        assert shown["anew"]["exponent"] == pytest.approx(2, abs=0.15)


def occluded(visible):
    visible = np.array(visible, float)
    return Sequence("x", [None] * len(visible), np.tile([1.0, 1, 0, 1, 1], (len(visible), 1)), visible)


def test_found_again_is_counted_for_each_occlusion():
    clip = occluded([1] * 5 + [0] * 4 + [1] * 20 + [0] * 4 + [1] * 20)
    seen = clip.visibility > 0.5
    iou = np.where(seen, 0.6, np.nan)[1:]
    assert found_again(iou, clip) == (2, 2)
    once = iou.copy()
    once[8:28] = 0
    assert found_again(np.array([iou, once, np.minimum(iou, 0)]), clip)[0].tolist() == [2, 1, 0]
    assert found_again(np.full(9, 0.5), occluded([1] * 10)) == (0, 0)


def test_moments_show_each_occlusion_and_what_comes_after_it():
    clip = occluded([1] * 40 + [0] * 6 + [1] * 60 + [0] * 6 + [1] * 38)
    frames = moments(clip)
    assert len(frames) == 8 and frames == sorted(set(frames))
    assert {43, 56, 109, 122} <= set(frames)
