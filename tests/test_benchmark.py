"""The leaderboard: one protocol for all, the same numbers from the cache, and means that add up."""

import csv
import json
from fractions import Fraction

import cv2
import numpy as np
import pytest

from mkt import cli, figures, leaderboard, sweeps
from mkt.figures.cordoba2014_material import OVERALL, TABLE
from mkt.figures.lessons_benchmark import counts
from mkt.leaderboard import Board, as_markdown, by_sequence, draws, overall, ranking, recorded, refusals, synthetic
from mkt.regions import to_box
from mkt.scenarios import base
from mkt.scenes import sequence
from mkt.sweeps import Clocked, Recorded
from mkt.trackers import catalogue
from mkt.trackers.baselines import CamShift
from mkt.trackers.particle_filter import ParticleFilter

LENGTH = 12


def row(name, scenario, seed, overlap, **more):
    return {"name": name, "scenario": scenario, "seed": seed, "overlap": overlap, "hits": 1.0, "hits_of_all": 0.9, "area": overlap, "lost": 0.0,
            "cpu_ms": 2.0, "refused": ""} | more


@pytest.fixture
def benchmarks(tmp_path, monkeypatch):
    """A folder with two sequences in the format of BoBoT, one of them grey; MKT_DATA names it."""
    clip = sequence(base(0))
    for name in ("colored", "grey"):
        frames = tmp_path / "bobot" / name / "frames"
        frames.mkdir(parents=True)
        for k in range(LENGTH):
            image = clip.frames[k][..., ::-1]
            cv2.imwrite(str(frames / f"{k}.png"), image if name == "colored" else np.repeat(image[..., :1], 3, -1))
        boxes = to_box(clip.truth[:LENGTH]) / [320, 240, 320, 240]
        (frames.parent / "truth.txt").write_text("\n".join([f"{k} " + " ".join(f"{x:.6f}" for x in box) for k, box in enumerate(boxes)]))
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    return tmp_path / "bobot"


NAMES = ("ssd", "pf-75", "camshift")


@pytest.fixture
def cache(tmp_path):
    return tmp_path / "cache"


def test_every_tracker_runs_on_every_sequence_once_a_seed_where_seeds_matter(benchmarks, cache):
    (board,), troubles = recorded(NAMES, 2, processes=1, cache=cache)
    runs = sorted((r["scenario"], r["name"], r["seed"]) for r in board.rows)
    assert runs == sorted((f"BoBoT/{s}", n, k) for s in ("colored", "grey") for n in NAMES for k in range(2 if n == "pf-75" else 1))
    assert troubles == [] and "12 frames of 320x240" in board.data
    cells = {(r["scenario"], r["name"]): r for r in board.rows}
    assert cells["BoBoT/colored", "ssd"]["overlap"] > 0.7
    assert "no colourful pixel" in cells["BoBoT/grey", "camshift"]["refused"]


def test_what_is_known_is_not_run_again_wherever_the_data_lie(benchmarks, cache, monkeypatch):
    (first,), _ = recorded(NAMES, 1, processes=1, cache=cache)
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("the cache was not read"))
    moved = benchmarks.parent / "moved"
    moved.mkdir()
    benchmarks.rename(moved / "bobot")
    monkeypatch.setenv("MKT_DATA", str(moved))
    (again,), _ = recorded(NAMES, 1, processes=1, cache=cache, only_known=True)
    assert json.dumps(again.rows) == json.dumps(first.rows)
    assert recorded(NAMES, 2, cache=cache, only_known=True)[0] == []  # the second seed is not known


def test_another_truth_is_another_job(benchmarks, cache, monkeypatch):
    recorded(("ssd",), 1, processes=1, cache=cache)
    path = benchmarks / "colored" / "truth.txt"
    path.write_text(path.read_text().replace("\n5 0.", "\n5 0.0", 1))
    assert recorded(("ssd",), 1, cache=cache, only_known=True)[0] == []


def test_what_is_broken_is_left_out_and_named(benchmarks, cache):
    (benchmarks / "grey" / "truth.txt").write_text("0 .1 .1 .2 .2\n1 .1 .1 .2\n")
    (board,), troubles = recorded(("ssd",), 1, processes=1, cache=cache)
    assert {r["scenario"] for r in board.rows} == {"BoBoT/colored"}
    assert len(troubles) == 1 and "truth.txt, line 2" in troubles[0]


def test_a_recorded_run_is_scored_as_a_synthetic_one(benchmarks):
    """The same frames and nearly the same boxes give nearly the same overlap, by way of files."""
    from mkt.archives import sequences

    found = next(f for f in sequences() if f.folder.name == "colored")
    result = sweeps.run(Recorded("pf-75", ParticleFilter(n=75), found, found.name, found.fingerprint()))
    assert result["scenario"] == "BoBoT/colored" and result["hits"] == result["hits_of_all"] == 1
    assert result["area"] == pytest.approx(result["overlap"], abs=0.03)


def test_reading_frames_is_not_on_the_trackers_clock():
    class Busy:
        def __len__(self):
            return 2

        def __getitem__(self, k):
            return [3.0, 4.0][k]

    frames = Clocked(Busy())
    assert list(frames) == [3.0, 4.0] and len(frames) == 2 and frames.seconds > 0


def test_trackers_that_draw_are_told_from_those_that_do_not():
    assert [draws(catalogue.get(name)) for name in ("pf-75", "combined", "guided", "mil")] == [True] * 4
    assert [draws(catalogue.get(name)) for name in ("ssd", "camshift", "meanshift")] == [False] * 3


def test_ranking_is_by_the_mean_of_the_means_of_the_sequences():
    """A sequence with more runs does not count more."""
    rows = [row("ssd", "a", 0, 0.2), row("ssd", "b", 0, 0.8), row("pf-75", "a", 0, 0.9), row("pf-75", "a", 1, 0.7), row("pf-75", "b", 0, 0.4),
            row("pf-75", "b", 1, 0.4)]
    first, second = ranking(rows)
    assert (first.name, second.name) == ("pf-75", "ssd")
    assert first.overlap == pytest.approx(0.6) and second.overlap == pytest.approx(0.5)
    assert first.seeds == pytest.approx((0.55, 0.65)) and second.seeds is None
    assert first.interval[0] <= first.overlap <= first.interval[1]
    assert first.cells["a"] == pytest.approx((0.8, 1.0))


def test_whoever_refuses_scores_nothing():
    rows = [row("ssd", "a", 0, 0.6), row("ssd", "b", 0, np.nan) | dict.fromkeys(sweeps.NUMBERS, np.nan) | {"refused": "too dark"}]
    place, = ranking(rows)
    assert place.overlap == pytest.approx(0.3) and place.hits == 0.5 and place.lost == 0.5 and place.cpu_ms == 2
    assert refusals(rows) == ["(2) SSD, nine kernels would not start on b: too dark"]
    assert "would not start on b: too dark" in as_markdown(Board("x", "y", rows))


def test_the_tables_are_markdown_with_a_row_for_each_tracker():
    rows = [row(name, scenario, seed, 0.5) for name in ("ssd", "mil") for scenario in ("a", "b") for seed in range(2)]
    places = ranking(rows)
    assert [len(line) for line in overall(places)] == [len(leaderboard.HEAD)] * 2
    head, body = by_sequence(places)
    assert head == ["tracker", "a", "b"] and body[0][1:] == ["0.50 / 100"] * 2
    lines = [line for line in as_markdown(Board("Some", "Data.", rows)).splitlines() if line.startswith("|")]
    assert len(lines) == 8 and all(line.count("|") in (4, len(leaderboard.HEAD) + 1) for line in lines)


def test_synthetic_sequences_are_for_whoever_has_no_benchmark(cache, monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    monkeypatch.setattr(sweeps, "run", lambda job: row(job.name, job.scenario, job.seed, 0.5))
    assert recorded(NAMES, 1, cache=cache) == ([], [])
    board = synthetic(NAMES, 3, processes=1, cache=cache)
    assert len(board.rows) == 3 * 3 * len(leaderboard.SYNTHETIC) and "Synthetic" in board.data
    names = [r["name"] for r in leaderboard.for_the_book(processes=1, cache=cache)[0].rows]
    assert set(names) == set(catalogue.TRACKERS)
    assert names.count("mil") == len(leaderboard.SYNTHETIC) == names.count("guided") / 2


def test_every_synthetic_sequence_can_be_tracked():
    assert set(leaderboard.SYNTHETIC) <= set(sweeps.SCENES)
    for name in leaderboard.SYNTHETIC:
        clip = sweeps.Job("camshift", CamShift(), name).clip()
        assert np.isfinite(clip.truth[0]).all() and clip.visibility[0] > 0.7, name


@pytest.mark.parametrize("ending", ["csv", "md"])
def test_the_command_prints_and_writes(ending, benchmarks, tmp_path, capsys, monkeypatch):
    def made_up(names, seeds):
        return [Board("BoBoT", "Data.", [row(n, "a", k, 0.5) for n in names for k in range(seeds)])], ["x.txt: bad"]

    monkeypatch.setattr(leaderboard, "recorded", made_up)
    path = tmp_path / f"out.{ending}"
    assert not cli.run(cli.parse(["bench", "tracking", "ssd", "mil", "--seeds", "2", "-o", str(path)]))
    printed = capsys.readouterr()
    assert "## BoBoT: 1 sequence, 4 runs" in printed.out and "left out: x.txt: bad" in printed.err
    if ending == "csv":
        assert [r["seed"] for r in csv.DictReader(path.open())] == ["0", "1", "0", "1"]
    else:
        assert path.read_text() == printed.out


@pytest.mark.parametrize("words, said", [
    (["nope"], "no tracker 'nope'; there are pf-1"), (["ssd", "--seeds", "0"], "0 seeds; there must be at least 1"),
    (["ssd", "-o", "x.txt"], "ends in .csv or .md"), (["ssd", "-o", "no/such/x.csv"], "in a folder that exists"),
])
def test_a_wrong_bench_is_answered_in_a_sentence(words, said):
    with pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["bench", "tracking", *words]))
    assert said in stopped.value.code


def test_table_1_as_printed_gives_away_its_lengths():
    """Truncated, not rounded; three rows fit a BoBoT sequence without its first row or two, and one mean is wrong."""
    drawn = {row: figures.get("own.table_forensics").draw(row=row)[1] for row in TABLE}
    assert 627 in drawn["clutter"]["n"] and drawn["trajectory"]["n"] == [601] and 452 in drawn["pillars"]["n"]
    possible = drawn["clutter"]["possible"]
    assert [name for name in possible if not all(possible[name])] == ["passers", "scale"]
    rounded = figures.get("own.table_forensics").draw(rounding="rounded")[1]["possible"]
    assert not any(all(row) for row in rounded.values())
    means, printed = drawn["scale"]["means"], [float(p) for p in OVERALL]
    assert [int(100 * mean + 1e-6) == round(100 * p) for mean, p in zip(means, printed)] == [False, True, True]


@pytest.mark.parametrize("n", [1, 7, 452, 627, 1016])
def test_every_fraction_is_found_and_no_other(n):
    for k in range(n + 1):
        hundredths = Fraction(10000 * k, n)
        assert k in counts(f"{int(hundredths) / 100:.2f}", n)
        assert k in counts(f"{int(hundredths + Fraction(1, 2)) / 100:.2f}", n, "rounded")
    impossible = set(range(10001)) - {10000 * k // n for k in range(n + 1)}
    assert not any(counts(f"{p / 100:.2f}", n) for p in sorted(impossible)[::37])


def test_the_success_figure_shows_what_the_runs_give():
    seen = {}
    for limit in (0.2, 0.7):
        _, seen[limit] = figures.get("own.success").draw(scene="look-alike", limit=limit)
    low, high = seen[0.2], seen[0.7]
    assert low["names"] == [name for name in catalogue.TRACKERS if name not in catalogue.SLOW]
    assert (low["seen"] >= high["seen"]).all() and (low["all"] <= low["seen"]).all()
    assert low["area"] == pytest.approx(low["curves"].mean(1)) and (np.diff(low["curves"]) <= 0).all()
    assert low["curves"][:, 4] == pytest.approx(low["seen"])  # 4 / 20 is the limit
