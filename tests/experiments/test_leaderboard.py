"""The leaderboard: one protocol for all, means that add up, nothing run twice."""

import csv
import re
from dataclasses import dataclass, replace
from html import unescape

import cv2
import numpy as np
import pandas as pd
import pytest
from markdown_it import MarkdownIt
from scipy.stats import t, ttest_rel

from mkt.course import cli
from mkt.course.book import pages
from mkt.experiments import leaderboard
from mkt.experiments import sweep as sweeps
from mkt.experiments.leaderboard import (
    Board,
    Place,
    draws,
    ranking,
    recorded,
    synthetic,
)
from mkt.experiments.leaderboard_as_text import (
    HEAD,
    as_markdown,
    by_sequence,
    legend,
    overall,
    refusals,
)
from mkt.experiments.sweep import Job
from mkt.regions import to_box
from mkt.scenes import SCENES
from mkt.scenes.cordoba2014 import KINDS
from mkt.scenes.drawn import Drawn
from mkt.sequences.benchmarks import sequences
from mkt.trackers import by_name
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD

LENGTH = 12
NAMES = ("ssd", "pf-75", "camshift")


def row(tracker, source, seed, overlap, **more):
    return {
        "tracker": tracker,
        "source": source,
        "seed": seed,
        "overlap": overlap,
        "hits": 1.0,
        "hits_of_all": 0.9,
        "area": overlap,
        "lost": 0.0,
        "cpu_ms": 2.0,
        "refused": "",
    } | more


def quick(job):
    """The row of a job on a drawn scene, which costs nothing."""
    pair = {"item": job.source.item, "ground": job.source.ground}
    return row(job.label, job.source.name, job.seed, 0.5) | pair


def table(*rows):
    return pd.DataFrame(rows)


@pytest.fixture
def benchmarks(tmp_path, monkeypatch):
    """A folder with two sequences in the format of BoBoT, one of them grey.

    MKT_DATA names it.
    """
    clip = Drawn("base").sequence()
    boxes = to_box(clip.truth[:LENGTH]) / [320, 240, 320, 240]
    lines = [f"{k} " + " ".join(f"{x:.6f}" for x in box) for k, box in enumerate(boxes)]
    for name in ("colored", "grey"):
        frames = tmp_path / "bobot" / name / "frames"
        frames.mkdir(parents=True)
        for k in range(LENGTH):
            image = clip.frames[k][..., ::-1]
            if name == "grey":
                image = np.repeat(image[..., :1], 3, -1)
            cv2.imwrite(str(frames / f"{k}.png"), image)
        (frames.parent / "truth.txt").write_text("\n".join(lines))
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    return tmp_path / "bobot"


def test_every_tracker_runs_on_every_sequence_once_a_seed_where_seeds_matter(
    benchmarks,
):
    (board,), troubles = recorded(NAMES, range(2), processes=1)
    runs = board.rows[["source", "tracker", "seed"]].itertuples(index=False, name=None)
    assert sorted(runs) == sorted(
        (f"BoBoT/{s}", n, k)
        for s in ("colored", "grey")
        for n in NAMES
        for k in range(2 if n == "pf-75" else 1)
    )
    assert troubles == [] and "12 frames of 320x240" in board.data
    cells = board.rows.set_index(["source", "tracker"])
    assert cells.loc[("BoBoT/colored", "ssd"), "overlap"] > 0.7
    assert "no colourful pixel" in cells.loc[("BoBoT/grey", "camshift"), "refused"]


def test_what_is_known_is_not_run_again_wherever_the_data_lie(benchmarks, monkeypatch):
    (first,), _ = recorded(NAMES, [0], processes=1)
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("not read"))
    moved = benchmarks.parent / "moved"
    moved.mkdir()
    benchmarks.rename(moved / "bobot")
    monkeypatch.setenv("MKT_DATA", str(moved))
    (again,), _ = recorded(NAMES, [0], processes=1)
    pd.testing.assert_frame_equal(again.rows, first.rows)
    with pytest.raises(pytest.fail.Exception, match="not read"):
        recorded(NAMES, [0, 1], processes=1)  # the second seed is not known


def test_another_truth_is_another_job(benchmarks, monkeypatch):
    recorded(("ssd",), [0], processes=1)
    path = benchmarks / "colored" / "truth.txt"
    path.write_text(path.read_text().replace("\n5 0.", "\n5 0.0", 1))
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("run again"))
    with pytest.raises(pytest.fail.Exception, match="run again"):
        recorded(("ssd",), [0], processes=1)


def test_one_benchmark_can_be_chosen(benchmarks):
    assert recorded(("ssd",), [0], archive="OTB") == ([], [])


def test_starts_in_other_frames_are_runs_of_the_same_case(benchmarks):
    (board,), _ = recorded(("ssd",), [0], processes=1, starts=2)
    places = {(0, 1), (LENGTH // 2 - 1, 1), (LENGTH - 1, -1), (LENGTH // 2, -1)}
    for name, rows in board.rows.groupby("source"):
        assert set(zip(rows["start"], rows["way"], strict=True)) == places, name
    assert set(board.rows["source"]) == {"BoBoT/colored", "BoBoT/grey"}
    assert "8 parts of them" in board.data
    (whole,), _ = recorded(("ssd",), [0], processes=1)
    first = board.rows[(board.rows["start"] == 0) & (board.rows["way"] == 1)]
    assert list(first["overlap"]) == list(whole.rows["overlap"])
    assert len(set(board.rows["overlap"])) > 2  # the others are other runs


def test_one_case_alone_has_no_interval():
    rows = table(row("ssd", "a", 0, 0.5), row("mil", "a", 0, 0.4))
    board = Board("One", "Data.", rows, "source")
    first, second = overall(ranking(board))
    assert first[3] == second[3] == "unknown" and second[4] == "0.10 (unknown)"
    assert "inf" not in as_markdown(board)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ssd", "--starts", "-1"], "give 1 or more"),
        (["ssd", "--starts", "2", "--tracks", "found"], "leave out --starts"),
        (["--release", "--starts", "2"], "takes no other word"),
    ],
)
def test_starts_that_cannot_be_are_refused(words, said, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["bench", "tracking", *words])
    assert said in capsys.readouterr().err


def test_what_is_broken_is_left_out_and_named(benchmarks):
    (benchmarks / "grey" / "truth.txt").write_text("0 .1 .1 .2 .2\n1 .1 .1 .2\n")
    (board,), troubles = recorded(("ssd",), [0], processes=1)
    assert set(board.rows["source"]) == {"BoBoT/colored"}
    assert len(troubles) == 1 and "truth.txt, line 2" in troubles[0]


@pytest.mark.parametrize("starts", [0, 2])
def test_a_broken_frame_leaves_its_sequence_out_with_all_parts(benchmarks, starts):
    (benchmarks / "grey" / "frames" / "6.png").write_bytes(b"not an image")
    (board,), troubles = recorded(("ssd",), [0], processes=1, starts=starts)
    assert set(board.rows["source"]) == {"BoBoT/colored"}
    assert len(board.jobs) == len(board.rows) == max(1, 2 * starts)
    assert "grey" not in board.data
    assert len(troubles) == 1 and "6.png: not an image" in troubles[0]


def test_nothing_is_left_out_of_a_release(benchmarks):
    (benchmarks / "grey" / "frames" / "6.png").write_bytes(b"not an image")
    with pytest.raises(ValueError, match="leaves no sequence out: .*6.png: not an im"):
        leaderboard.for_release(leaderboard.release.BOBOT, ["ssd"])


def test_where_all_is_broken_there_is_no_board(benchmarks):
    for name in ("colored", "grey"):
        (benchmarks / name / "frames" / "6.png").write_bytes(b"")
    boards, troubles = recorded(("ssd",), [0], processes=1)
    assert boards == [] and len(troubles) == 2


@pytest.mark.parametrize(
    "name",
    ["<img src=x onerror=alert(1)>", "a|b", "*a* `b` $c$", "<!--<script>", "a\n# b"],
)
def test_the_name_of_a_sequences_folder_is_text_on_the_page(benchmarks, name):
    """An archive from the network chooses it."""
    plain = shown_on_the_page()
    (benchmarks / "colored").rename(benchmarks / name)
    page = shown_on_the_page()
    assert re.findall("<[^>]*>", page) == re.findall("<[^>]*>", plain)
    assert " ".join(name.split()) in unescape(page)


def shown_on_the_page():
    boards, _ = recorded(("ssd",), [0], processes=1)
    return MarkdownIt().enable("table").render(pages.leaderboard(boards))


def test_a_recorded_run_is_scored_as_a_synthetic_one(benchmarks):
    """The same frames and nearly the same boxes give nearly the same overlap."""
    found = next(f for f in sequences() if f.folder.name == "colored")
    result = sweeps.run(Job("pf-75", ParticleFilter(n=75), found))
    assert result["source"] == "BoBoT/colored"
    assert result["hits"] == result["hits_of_all"] == 1
    assert result["area"] == pytest.approx(result["overlap"], abs=0.03)


def test_trackers_that_draw_are_told_from_those_that_do_not():
    for name in ("pf-75", "combined", "guided", "mil"):
        assert draws(by_name.TRACKERS[name]), name
    for name in ("ssd", "camshift", "meanshift"):
        assert not draws(by_name.TRACKERS[name]), name


def test_a_tracker_that_draws_only_when_it_searches_draws():
    class Guessing(SSD):
        def step(self, state, frame, rng):
            rng.random()
            return super().step(state, frame, rng)

    assert draws(Guessing()) and not draws(SSD())


def test_written_tracks_count_frames_in_the_whole_sequence(tmp_path):
    """As the truth of MOT does, from 1 on; so the sixth frame is number 6."""

    class FromTheSixth(Drawn):
        first = 5

        def sequence(self):
            return replace(self.scene(), length=3).sequence()

    some = replace(
        board(row("ssd", "base", 0, 0.5)),
        jobs=[Job("ssd", SSD(), FromTheSixth("base"))],
    )
    leaderboard.write_tracks(some, tmp_path, processes=1)
    rows = (tmp_path / "ssd-base-0.txt").read_text().splitlines()
    assert [line.split(",")[0] for line in rows] == ["6", "7", "8"]


def test_of_a_refused_target_no_track_is_written(tmp_path):
    class Short(Drawn):
        def sequence(self):
            return replace(self.scene(), length=2).sequence()

    some = replace(
        board(
            row("pf-75", "base", 0, np.nan, refused="too dark"),
            row("ssd", "base", 0, 0.5),
        ),
        jobs=[Job(name, SSD(), Short("base")) for name in ("pf-75", "ssd")],
    )
    leaderboard.write_tracks(some, tmp_path, processes=1)
    written = sorted(path.name for path in tmp_path.glob("*-0.*"))
    assert written == ["ssd-base-0.csv", "ssd-base-0.txt"]


def board(*rows, case="source"):
    return Board("Some", "Data.", pd.DataFrame(rows), case)


def test_ranking_is_by_the_mean_of_the_means_of_the_sequences():
    """A sequence with more runs does not count more."""
    first, second = ranking(
        board(
            row("ssd", "a", 0, 0.2),
            row("ssd", "b", 0, 0.8),
            row("pf-75", "a", 0, 0.9),
            row("pf-75", "a", 1, 0.7),
            row("pf-75", "b", 0, 0.4),
            row("pf-75", "b", 1, 0.4),
        )
    )
    assert (first.name, second.name) == ("pf-75", "ssd")
    assert first.overlap == pytest.approx(0.6) and second.overlap == pytest.approx(0.5)
    assert first.behind is None and second.behind[0] == pytest.approx(0.1)
    assert first.interval[0] <= first.overlap <= first.interval[1]
    assert first.places == second.places == (1, 2)  # two sequences say nothing
    assert first.cells["a"] == pytest.approx((0.8, 1.0))


def test_the_cpu_time_of_a_place_is_the_median_of_its_runs():
    """A machine that was busy during one of them does not count."""
    times = (2.0, 3.0, 40.0)
    (place,) = ranking(
        board(*(row("ssd", "a", seed, 0.5, cpu_ms=ms) for seed, ms in enumerate(times)))
    )
    assert place.cpu_ms == 3


def test_a_place_is_certain_where_the_paired_differences_are():
    """Scenes differ by far more than the trackers do, but always the same way."""
    scenes = enumerate(np.linspace(0.1, 0.9, 12))
    rows = [
        row(name, kind, seed, overlap + lead * (1 + 0.1 * (seed % 3)))
        for seed, overlap in scenes
        for kind in ("a", "b")
        for name, lead in (("ssd", 0.0), ("mil", 0.02), ("pf-75", 0.02))
    ]
    places = {place.name: place for place in ranking(board(*rows, case="seed"))}
    assert places["ssd"].places == (3, 3)
    assert places["mil"].places == places["pf-75"].places == (1, 2)
    _, low, high = places["ssd"].behind
    assert 0.01 < low < high < 0.03
    low, high = places["ssd"].interval
    assert high - low > 0.2


def test_whoever_refuses_scores_nothing():
    nothing = dict.fromkeys(sweeps.NUMBERS, np.nan)
    refusing = board(
        row("ssd", "a", 0, 0.6),
        row("ssd", "b", 0, np.nan) | nothing | {"refused": "too dark"},
    )
    (place,) = ranking(refusing)
    assert place.overlap == pytest.approx(0.3) and place.cpu_ms == 2
    assert place.hits == 0.5 and place.lost == 0.5
    said = "(2) SSD, nine kernels would not start on b: too dark"
    assert refusals(refusing.rows) == [said]
    assert "would not start on b: too dark" in as_markdown(refusing)


def test_a_board_of_a_table_that_is_read_back_is_the_same(tmp_path):
    nothing = dict.fromkeys(sweeps.NUMBERS, np.nan)
    rows = [row("ssd", "a", seed, 0.9 + seed / 100) for seed in range(3)]
    for more in ([], [row("mil", "a", 0, np.nan) | nothing | {"refused": "no"}]):
        before = board(*rows, *more)
        sweeps.write_table(before.rows, tmp_path / "rows.csv")
        after = replace(before, rows=pd.read_csv(tmp_path / "rows.csv"))
        assert ranking(after)[0].overlap == pytest.approx(0.91)
        assert as_markdown(after) == as_markdown(before)
        assert len(refusals(after.rows)) == len(more)


def test_the_tables_are_markdown_with_a_row_for_each_tracker():
    some = board(
        *(
            row(name, source, seed, 0.5)
            for name in ("ssd", "mil")
            for source in ("a", "b")
            for seed in range(2)
        )
    )
    places = ranking(some)
    assert [len(line) for line in overall(places)] == [len(HEAD)] * 2
    head, body = by_sequence(places)
    assert head == ["tracker", "a", "b"] and body[0][1:] == ["0.50 / 100"] * 2
    text = as_markdown(some)
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert len(lines) == 8
    bars = {line.count("|") for line in lines}
    assert bars == {4, len(HEAD) + 1}


def test_synthetic_sequences_are_for_whoever_has_no_benchmark(monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    monkeypatch.setattr(sweeps, "run", quick)
    assert recorded(NAMES, [0]) == ([], [])
    few = synthetic(NAMES, range(3), processes=1, kinds=KINDS)
    assert len(few.rows) == 3 * 3 * len(KINDS) and "3 pairs" in few.data
    assert few.rows["item"].nunique() == 3


@pytest.mark.parametrize(
    "n, said, head",
    [
        (1, "1 kind: .* kind 1 scene, of 1 pair ", "1 kind of scene, 1 of each, 1 run"),
        (2, "2 kinds: .* 2 scenes, of 2 pairs ", "2 kinds of scene, 2 of each, 4 runs"),
    ],
)
def test_one_scene_is_no_scenes(n, said, head, monkeypatch):
    monkeypatch.setattr(sweeps, "run", quick)
    board = synthetic(["ssd"], range(n), processes=1, kinds=list(KINDS)[:n])
    assert re.search(said, board.data)
    assert as_markdown(board).splitlines()[0].endswith(f": {head}")


def test_the_drawn_scenes_are_of_few_objects_and_say_for_what_their_intervals_speak():
    said = leaderboard.shipped()[0].data
    assert "32 scenes, of 16 pairs of object and ground: 4 objects before 4 gr" in said
    assert "for new paths of these objects, and not for new objects." in said


def test_each_board_of_the_release_says_which_time_was_not_measured():
    for board in leaderboard.shipped():
        assert "CPU time of guided is reckoned, not measured" in board.data, board.title


def test_the_day_of_a_release_is_that_of_its_newest_runs():
    """A tracker runs again when its code has changed, and the others stay."""
    for board in leaderboard.shipped():
        assert re.search(r"The newest runs are of 20\d\d-\d\d-\d\d,", board.data)


def test_one_start_is_no_starts(benchmarks):
    (board,), _ = recorded(("ssd",), [0], processes=1, starts=1)
    assert "from 1 frame forwards, and from 1 backwards." in board.data


def test_every_synthetic_sequence_can_be_tracked():
    assert set(KINDS) <= set(SCENES)
    for kind in KINDS:
        clip = Drawn(kind).sequence()
        assert np.isfinite(clip.truth[0]).all() and clip.visibility[0] > 0.7, kind


@pytest.mark.parametrize("ending", ["csv", "md"])
def test_the_command_prints_and_writes(
    ending, benchmarks, tmp_path, capsys, monkeypatch
):
    def made_up(names, seeds, on=(), starts=0):
        rows = table(*(row(n, "a", k, 0.5) for n in names for k in seeds))
        return [Board("BoBoT", "Data.", rows, "source")], ["x.txt: bad"]

    monkeypatch.setattr(leaderboard, "recorded", made_up)
    path = tmp_path / f"out.{ending}"
    words = ["bench", "tracking", "ssd", "mil", "--seeds", "0:2", "-o", str(path)]
    assert not cli.run(cli.parse(words))
    printed = capsys.readouterr()
    assert "## BoBoT: 1 sequence, 4 runs" in printed.out
    assert "left out: x.txt: bad" in printed.err
    if ending == "csv":
        assert [r["seed"] for r in csv.DictReader(path.open())] == ["0", "1", "0", "1"]
    else:
        assert path.read_text() == printed.out


@pytest.mark.parametrize(
    "words, seeds",
    [([], range(5)), (["--starts", "2"], range(1)), (["--seeds", "3:4"], range(3, 4))],
)
def test_many_starts_need_one_seed_each(words, seeds, capsys, monkeypatch):
    def asked(names, seeds, on=(), starts=0):
        runs.append((seeds, starts))
        return [Board("BoBoT", "Data.", table(row("ssd", "a", 0, 0.5)), "source")], []

    runs = []
    monkeypatch.setattr(leaderboard, "recorded", asked)
    assert not cli.run(cli.parse(["bench", "tracking", "ssd", *words]))
    assert runs == [(seeds, 2 if "--starts" in words else 0)]


@pytest.mark.parametrize(
    "words, said",
    [
        (["nope"], "no tracker 'nope'; there are pf-1"),
        (["ssd", "-o", "x.txt"], "ends in .csv or .md"),
        (["ssd", "--starts", "2"], "needs sequences"),
        (["ssd", "-o", "no/such/x.csv"], "no folder no/such for x.csv"),
    ],
)
def test_a_wrong_bench_is_answered_in_a_sentence(words, said, monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    with pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["bench", "tracking", *words]))
    assert said in stopped.value.code


def test_the_release_says_of_whom_the_first_is_ahead_where_nothing_was_chosen():
    board = leaderboard.shipped()[1]
    rows = board.rows[~board.rows["source"].str.contains("ball|juice|fully")]
    assert rows["source"].nunique() == 5 and "On the 5 others" in board.data
    assert "chosen on A, C, F and the pedestrian 9 of PETS09-S2L1, and" in board.data
    cases = rows.groupby(["source", "tracker"])["overlap"].mean().unstack()
    first, second, *_ = order = cases.mean().sort_values(ascending=False).index
    tested = ttest_rel(cases[[first]], cases[order[1:]], alternative="greater")
    alike = order[1:][tested.pvalue >= 0.025]
    assert 0 < len(alike) < len(order) - 2 and second not in alike
    all_said, _, not_told = board.data.partition(", but not from ")
    assert f"{by_name.LABELS[first]} is first, {cases[first].mean():.3f}" in all_said
    assert f"from {len(order) - 1 - len(alike)} of {len(order) - 1} rivals" in all_said
    for name in order[1:]:
        lead = (cases[first] - cases[name]).mean()
        label, mean = by_name.LABELS[name], cases[name].mean()
        said = f"{label}, {mean:.3f} (a lead of {lead:.3f}, "
        assert (said in not_told) == (name in alike), name
        assert (said in all_said) == (name == second), name
    assert f": its place is 1 to {1 + len(alike)}." in not_told


def test_whoever_is_ahead_of_all_on_the_others_has_the_first_place():
    leads = {"ssd": 0.2, "pf-75": 0.1, "mil": 0.0}
    rows = [
        row(name, f"BoBoT/Vid_{letter}_x", 0, 0.5 + lead * (1 + 0.1 * k))
        for k, letter in enumerate("BDEGI")
        for name, lead in leads.items()
    ]
    said = leaderboard._on_the_others(table(*rows))
    assert "tells the first from 2 of 2 rivals: its place is 1." in said


@pytest.mark.parametrize("p, places", [(0.0245, (1, 1)), (0.0255, (1, 2))])
def test_two_trackers_are_told_apart_at_two_and_a_half_per_cent(p, places):
    """As the legend says: leads whose t-test has this probability, on one side."""
    leads = np.array([-0.01, 0.01] * 3)
    leads += t.isf(p, 5) * leads.std(ddof=1) / np.sqrt(6)
    rows = [
        row(name, source, 0, 0.5 + mine)
        for source, lead in zip("abcdef", leads, strict=True)
        for name, mine in (("ssd", lead), ("mil", 0.0))
    ]
    first, second = ranked = ranking(board(*rows))
    assert (first.name, first.places) == ("ssd", places)
    assert second.places == (3 - places[1], 2)
    assert "(2.5 % on one side)" in legend(ranked).replace("\n", " ")


def test_the_legend_counts_the_pairs_that_so_many_tests_tell_apart():
    """Of three pairs two have a probability of .02, which is .06 after Holm."""
    leads = np.array([-0.01, 0.01] * 3)
    leads += t.isf(0.02, 5) * leads.std(ddof=1) / np.sqrt(6)
    rows = [
        row(name, source, 0, 0.5 + mine)
        for k, source in enumerate("abcdef")
        for name, mine in (("ssd", leads[k]), ("mil", 0.0), ("wm", 1e-4 * (-1) ** k))
    ]
    places = ranking(board(*rows))
    pairs, single, together = leaderboard.told_apart(places)
    assert (pairs, single, together) == (3, 2, 0)
    assert sum(place.places[0] - 1 for place in places) == single
    said = legend(places).replace("\n", " ")
    assert "2 of 3 pairs are told apart, and 0 after Holm's correction" in said


def test_of_one_tracker_alone_no_pairs_are_counted():
    rows = [row("ssd", source, 0, 0.5) for source in "ab"]
    assert "pairs" not in legend(ranking(board(*rows)))


def test_each_board_of_the_page_has_its_own_legend():
    page = pages.leaderboard(leaderboard.shipped()).replace("\n", " ")
    counted = re.findall(r"(\d+) of 78 pairs are told apart, and (\d+) after", page)
    assert len(counted) == len(set(counted)) == 2
    assert all(int(single) >= int(together) for single, together in counted)


def test_no_two_runs_are_written_into_one_file(tmp_path):
    names = "Good 1", "Good_1", "good 1", "Good/1", "Good 1-2"
    alike = [Job("ssd", SSD(), replace(Called(), name=name)) for name in names]
    found = leaderboard._file_names(alike)
    assert len({name.casefold() for name in found}) == len(names)
    assert found[0] == "ssd-Good_1-0"


@dataclass(frozen=True)
class Called:
    """A source that is nothing but a name."""

    name: str = ""


@dataclass(frozen=True)
class DrawsLater:
    """A tracker that needs no random number in its first step."""

    def init(self, frame, region, rng):
        return 0

    def step(self, k, frame, rng):
        if k:
            rng.random()
        return k + 1, {}


def test_a_tracker_that_draws_in_its_second_step_draws():
    assert draws(DrawsLater())


def test_a_place_has_each_mean_over_runs_first_and_then_over_sequences():
    """Sequence a has one run, and b three."""
    of_b = {"hits": 0.8, "hits_of_all": 0.6, "area": 0.4, "lost": 0.5, "cpu_ms": 6.0}
    rows = [row("ssd", "a", 0, 0.9), *(row("ssd", "b", k, 0.3, **of_b) for k in "012")]
    (place,) = ranking(board(*rows))
    assert place.overlap == pytest.approx((0.9 + 0.3) / 2)
    assert place.hits == pytest.approx((1.0 + 0.8) / 2)
    assert place.hits_of_all == pytest.approx((0.9 + 0.6) / 2)
    assert place.area == pytest.approx((0.9 + 0.4) / 2)
    assert place.lost == pytest.approx((0.0 + 0.5) / 2)
    assert place.cpu_ms == 6.0


def test_hits_of_all_frames_stand_under_their_own_head():
    place = Place("ssd", (1, 1), 0.5, (0.4, 0.6), None, 0.9, 0.7, 0.5, 0.0, 1.0, {}, [])
    row = dict(zip(HEAD, overall([place])[0], strict=True))
    assert row["of all frames [%]"] == "70.0" and row["true positives [%]"] == "90.0"


def test_a_refusal_for_two_seeds_is_one_sentence():
    refused = {"tracker": "ssd", "source": "b", "refused": "too dark"}
    assert len(refusals(pd.DataFrame([refused | {"seed": k} for k in range(2)]))) == 1
