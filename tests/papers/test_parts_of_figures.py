"""What figures are made of, on made-up runs whose numbers are known by hand.

No tracker runs here.
"""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mkt.experiments import shipped
from mkt.experiments.shipped import Made
from mkt.figures.registry import FIGURES
from mkt.papers import runs
from mkt.papers.cordoba2014 import film, resampling
from mkt.papers.cordoba2014 import table as table1
from mkt.papers.cordoba2014 import tracking as cordoba
from mkt.papers.cordoba2014.looks import LOOKS, RIVALS
from mkt.papers.lessons.survival import COUNTED
from mkt.papers.nummiaro2003 import losing, steps
from mkt.papers.teuliere2009 import histograms, servoing
from mkt.papers.teuliere2009 import tracking as teuliere
from mkt.plotting import new_figure
from mkt.regions import HX, HY
from mkt.scenes.teuliere2009 import fast
from mkt.tracking import Sequence, Track
from tests.papers.drawing import numbers

BOX = np.array([50.0, 40.0, 0.0, 20.0, 10.0])


def clip(visible):
    """A box that stands still, of which so much is visible in each frame."""
    truth = np.tile(BOX, (len(visible), 1))
    frames = [np.zeros((80, 100, 3), np.uint8)] * len(visible)
    return Sequence("toy", frames, truth, np.array(visible, float))


# [C14]


@pytest.mark.parametrize("pair", LOOKS.values(), ids=LOOKS)
def test_resampling_alone_tells_the_two_of_a_look_apart(pair):
    pfhr, sir = (RIVALS[name] for name in pair)
    assert type(pfhr) is not type(sir)
    assert (pfhr.n, pfhr.bins, pfhr.kernels) == (sir.n, sir.bins, sir.kernels)


@pytest.mark.parametrize("number", range(1, 7))
def test_the_sliders_of_c14_reach_its_filters(number, monkeypatch):
    def drawn(fig, kind, trackers):
        return trackers

    monkeypatch.setattr(cordoba, "film", drawn)
    monkeypatch.setattr(cordoba, "curves", drawn)
    draw = getattr(cordoba, f"fig{number}")
    trackers = draw(new_figure((1, 1)), particles=25, n_lim=0.1)
    assert trackers["pfhr"].n == trackers["sir"].n == 25
    assert trackers["pfhr"].n_lim == 0.1


def test_table_1_has_the_mean_of_the_runs_and_the_best_mean_bold(monkeypatch):
    """The first is best by its mean, the second by its median."""
    shares = dict.fromkeys(RIVALS.values(), np.array([10.0, 20, 30]))
    shares[RIVALS["pfhr plain"]] = np.array([60.0, 60, 90])
    shares[RIVALS["sir"]] = np.array([64.0, 65, 66])
    monkeypatch.delenv("MKT_DATA", raising=False)
    monkeypatch.setattr(table1, "share_seen", lambda origin: 1.0)
    monkeypatch.setattr(table1, "percent", lambda one, *more: shares[one])
    fig = new_figure((10, 5))
    shown = table1.table1(fig)
    assert shown["means"].tolist() == [[70, 65, 20, 20, 20]] * 6
    (ax,) = fig.axes
    bold = [text.get_text() for text in ax.texts if text.get_fontweight() == "bold"]
    assert [text for text in bold if text[0].isdigit()] == ["70.0 ± 14.1"] * 6 + [
        "70.0"
    ]


def test_a_target_that_is_hidden_at_first_counts_as_seen_in_frame_0():
    hidden = clip([0, 0, 1, 1, 0, 1, 1])
    assert cordoba.occlusions(hidden) == [(1, 2), (4, 5)]


@pytest.mark.parametrize(
    "first, hits, back", [(9, 4, 0), (9, 5, 0), (9, 6, 1), (8, 6, 0), (14, 6, 0)]
)
def test_who_hits_in_most_frames_after_an_occlusion_is_back(first, hits, back):
    """Of the ten frames that count, from frame 9 on, after the first five."""
    iou = np.zeros(24)
    iou[first : first + hits] = 0.9
    hidden = clip([1] * 2 + [0] * 2 + [1] * 20)
    assert cordoba.found_again(iou, hidden) == (back, 1)


def test_the_film_shades_hidden_frames_alone_up_to_its_own(monkeypatch):
    """Its curve ends there, too, and the box is that of the frame."""
    monkeypatch.setattr(film, "drawn", lambda fig, draw, moments: (fig, draw))
    hidden = clip([1, 1, 0.2, 0.2, 1, 0.1, 1])
    regions = np.tile(BOX, (7, 1))
    regions[:, 0] += np.arange(7)
    particles = np.zeros((7, 31, 5))
    particles[..., 0] = np.arange(1, 8)[:, None] * np.linspace(0, 10, 31)
    run = Track(regions, np.ones(7), np.zeros(7, bool), {"particles": particles})
    fig, draw = film.film(hidden, {"pfhr": run})
    draw(5)
    left, right = fig.axes
    spans = [each.get_extents().intervalx for each in right.collections[-1].get_paths()]
    assert np.array(spans).tolist() == [[1.5, 3.5], [4.5, 5.5]]
    times, widths = right.lines[-1].get_data()
    assert times.tolist() == list(range(6))
    assert widths == pytest.approx([8, 16, 24, 32, 40, 48])  # of the middle 80 %
    assert left.lines[-1].get_xydata()[:4].mean(0).tolist() == [55, 40]


# [T09]


@pytest.mark.parametrize("span", [0.4, 1.0])
def test_one_round_kernel_covers_the_share_of_its_circle(span):
    _, _, _, hx, hy = histograms.still("car").truth[0]
    circle = np.pi * (span * min(hx, hy)) ** 2
    shown = numbers("teuliere2009.fig2", layout="one", span=span)
    assert shown["covered"] == pytest.approx(circle / (4 * hx * hy), abs=0.005)


def test_the_nearest_pixels_make_the_picture_of_an_object():
    y, x = np.mgrid[:40, :50]
    frame = np.dstack([x, y, x]).astype(np.uint8)
    cells = np.array([[[0.15, -0.15], [-0.15, 0.15]]])
    picture = histograms._pulled_back(frame, np.array([20, 15, 0, 5, 5.0]), cells)
    assert picture[0, :, :2].tolist() == [[21, 14], [19, 16]]


def test_an_object_that_crosses_is_in_the_middle_when_the_frame_is_taken():
    crossing = histograms._crossing("car", 0.8, 24.0, 0).sequence()
    x, y = histograms.MIDDLE
    assert crossing.truth[:, :2] == pytest.approx(np.array([[x - 24, y], [x, y]]))


def test_every_seen_frame_counts_before_the_occlusion_or_after_it():
    """A track that is off by as many pixels as the frame has for its number."""
    regions = np.tile(BOX, (80, 1))
    regions[:, 0] += np.arange(80)
    position, _, _ = teuliere.before_and_after(regions, clip([1] * 80))
    assert position.tolist() == [np.mean([1, 45]), np.mean([46, 79])]


def test_hidden_frames_have_no_errors():
    """However many they are."""
    visible = np.zeros(80)
    visible[[0, 5, 25, 45, 60, 79]] = 1
    regions = np.tile(BOX, (80, 1))
    regions[:, 0] += np.where(visible, 3, 500)
    regions[:, 2] += np.where(visible, 0.1, 1)
    position, orientation, _ = teuliere.before_and_after(regions, clip(visible))
    assert position == pytest.approx(3)
    assert np.deg2rad(orientation) == pytest.approx(0.1)


def test_angles_are_drawn_on_the_turn_nearest_the_truth():
    """Of a target that turns round twice, however the turns are counted."""
    angle = np.linspace(0, 4 * np.pi, 30)
    truth, found = np.tile(BOX, (2, 30, 1))
    truth[:, 2] = np.angle(np.exp(1j * angle))
    found[:, 2] = angle + 0.1 + 2 * np.pi * (np.arange(30) % 5 - 2)
    drawn = teuliere._curves(found, truth)
    assert np.deg2rad(drawn[2]) == pytest.approx(angle + 0.1)


def test_figure_5_tells_the_last_size_and_the_median_of_the_turn(monkeypatch):
    truth = runs.clip(fast(0, exposure=0.0)).truth
    found = np.tile(truth, (4, 1, 1, 1))
    found[..., -1, [HX, HY]] *= 1.5
    found[..., 2] += np.deg2rad(10)
    found[..., 20:35, 2] += np.deg2rad(60)
    monkeypatch.setattr(runs, "regions", lambda *asked: found)
    shown = numbers("teuliere2009.fig5", exposure=0.0)
    assert shown["size"] == pytest.approx(1.5)
    assert shown["orientation"] == pytest.approx(10)


def test_the_car_s_velocity_is_seen_by_the_camera_of_the_frame_before():
    """It drives along X, which is the image's y in the first frame alone."""
    upright, turned = np.eye(4), np.eye(4)
    turned[:2, :2] = [[0, 1], [-1, 0]]
    run = SimpleNamespace(
        cars=np.array([[0, 0, 0], [0.3, 0, 0], [0.6, 0, 0]]),
        times=np.array([0, 0.2, 0.4]),
        poses=np.array([turned, upright, upright]),
    )
    assert servoing.self_motion(run, surface=0.25) == pytest.approx([3, 0])


def test_figure_11_looks_for_the_largest_error_in_the_second_after_the_reversal():
    errors = np.zeros((85, 4))
    errors[[36, 40, 43], 1] = 9, -2, 3  # 7.2, 8 and 8.6 s; the reversal is at 7.4
    run = SimpleNamespace(times=0.2 * np.arange(85), errors=errors)
    assert servoing.instants(run) == [20, 29, 40, 84]


def test_the_axis_at_the_right_of_figure_10_has_its_pixels():
    ax = new_figure((4, 3)).subplots()
    ax.set_ylim(-1, 2)
    servoing._add_pixels(ax, 50.0)
    (right,) = ax.child_axes
    ax.figure.canvas.draw()
    assert right.get_ylim() == pytest.approx((-50, 100))


# [N03]


def test_who_waits_is_found_again_in_the_first_frame_after_it():
    waiting = np.zeros(60, bool)
    waiting[10:20] = waiting[40:50] = True
    assert losing.found_again(waiting, 5) == 20
    assert losing.found_again(waiting, 12) == 20
    assert losing.found_again(waiting, 30) == 50
    assert losing.found_again(waiting[:30], 25) == 25 + 20  # it never waits


def test_points_keep_the_colour_of_the_mode_that_placed_them():
    modes = np.array(["", "tracking", "initialising", "initialising", "tracking"])
    samples = {"particles": np.tile(BOX, (5, 3, 1)), "positives": np.zeros(5)}
    info = {"mode": modes} | samples
    track = Track(np.tile(BOX, (5, 1)), np.ones(5), modes == "initialising", info)
    colors = []
    for ax, k in zip(new_figure((4, 1)).subplots(1, 4), range(1, 5), strict=True):
        losing.draw_mode(ax, clip([1] * 5), track, k)
        colors.append(ax.lines[0].get_color())
    assert colors == ["black", "black", "white", "white"]


def test_the_background_is_covered_by_the_share_below_the_limit():
    ax = new_figure((3, 2)).subplots()
    around = np.array([0.1, 0.2, 0.3, 0.9])
    assert steps._draw_condition(ax, around, limit=0.5, student=0.8) == 0.75
    assert "75.0%" in ax.get_title()


# The table of all trackers and scenes


@pytest.fixture
def two_runs(monkeypatch):
    """Puts a release of two runs of SSD on one kind of scene in place of ours."""

    def put(**columns):
        fixed = {"tracker": "ssd", "source": "base", "refused": ""}
        rows = pd.DataFrame(fixed | columns, [0, 1])
        made = Made("", "", "0:2", [], {}, "")
        monkeypatch.setattr(shipped, "read_runs", lambda table: (rows, made))

    return put


@pytest.mark.parametrize("counted", COUNTED)
def test_who_would_not_start_survives_nothing(counted, two_runs):
    half = [1, np.nan]
    two_runs(lost=[0, np.nan], overlap=half, hits=half, refused=["", "too dark"])
    cell = numbers("own.survival", counted=counted).table.iloc[0]
    assert (cell["tracker"], cell["scene"], cell["value [%]"]) == ("ssd", "base", 50)


@pytest.mark.parametrize("counted", ["overlap", "frames with a hit"])
def test_an_interval_of_a_share_ends_at_nothing_and_at_all(counted, two_runs):
    two_runs(lost=[0, 0], overlap=[0.1, 0.9], hits=[0.1, 0.9])
    cell = numbers("own.survival", counted=counted).table.iloc[0]
    assert (cell["low [%]"], cell["high [%]"]) == (0, 100)


def test_the_object_of_figure_3_is_looked_for_in_another_frame():
    *_, surfaces = histograms.cost_surfaces("3x3", 1.0, "hsv", "car", 20)
    assert all(surface[30, 30] > 0.01 for surface in surfaces)  # the noise differs


def test_figure_4_says_the_distance_in_the_middle_of_each_map():
    fig, shown = FIGURES["teuliere2009.fig4"].draw(30)
    said = [ax.get_title().split()[-1] for ax in fig.axes[2:4]]
    assert said == [f"{shown[name][20, 20]:.2f}" for name in ("sharp", "blurred")]


def test_a_row_of_figure_6_is_shaded_where_the_target_is_hidden():
    axes = new_figure((6, 2)).subplots(1, 3)
    course, runs_of_it = np.zeros((3, 80)), np.zeros((5, 3, 80))
    teuliere._draw_tracker(axes, course, runs_of_it, "k", 5, (0, 1))
    for ax in axes:
        (band,) = ax.patches
        assert (band.get_x(), band.get_width()) == (45.5, 5)


def test_a_spread_is_the_median_the_smallest_and_the_largest():
    assert teuliere._spread(np.array([3.0, 9.0, 1.0])) == "3.0  (1.0 to 9.0)"


def a_drive(frames=85):
    """A run whose tracker is 3 px and 0.1 rad off a car that stays where it should."""
    desired = servoing.Servo().desired
    truths = np.tile(desired, (frames, 1))
    return SimpleNamespace(
        times=0.2 * np.arange(frames),
        errors=np.zeros((frames, 4)),
        truths=truths,
        regions=truths + [3, 0, 0.1, 0, 0],
        lost=np.zeros(frames, bool),
    )


def test_figure_11_says_how_far_off_the_car_is_and_not_the_tracker(monkeypatch):
    monkeypatch.setattr(runs, "loop_run", lambda tried: a_drive())
    monkeypatch.setattr(servoing, "draw_view", lambda *drawn: None)
    shown = numbers("teuliere2009.fig11")
    assert not shown["off"].any() and not shown["turn"].any()


def test_the_table_of_figure_10_counts_in_seconds():
    table = servoing._error_table({"off": np.zeros((6, 2))}, servoing.experiment(fps=5))
    assert table["time [s]"].to_numpy() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1])


def test_the_line_of_figure_7_is_that_of_its_b(monkeypatch):
    ticks = np.zeros(222)
    info = {"positives": ticks, "particles": None, "mode": ticks}
    clip = SimpleNamespace(visibility=ticks, truth=np.ones((222, 5)))
    made = Track(np.ones((222, 5)), ticks, ticks > 0, info)
    monkeypatch.setattr(losing, "student_run", lambda *_: (clip, made, ticks > 0))
    fig, shown = FIGURES["nummiaro2003.fig7"].draw(30, b=0.5, particles=100)
    dashed = [line for line in fig.axes[0].lines if line.get_ls() == "--"]
    assert [line.get_ydata()[0] for line in dashed] == [shown["line"]] == [50]


def test_the_best_of_three_times_is_told(monkeypatch):
    monkeypatch.setattr(
        resampling,
        "side_by_side",
        lambda works, repeats: {n: np.array([3.0, 1, 2]) for n in works},
    )
    assert resampling.timed(True, [5, 9]) == [1, 1]


def test_the_overall_line_of_table_1_is_a_mean(monkeypatch):
    kinds = {table1.source(kind): k for k, kind in enumerate(table1.TABLE)}
    monkeypatch.setattr(table1, "share_seen", lambda origin: 1.0)
    monkeypatch.setattr(
        table1, "percent", lambda one, origin, *_: np.full(3, kinds[origin] ** 2.0)
    )
    fig = new_figure((10, 5))
    overall = table1.table1(fig)["overall"]
    last = [text.get_text() for text in fig.axes[0].texts[-len(RIVALS) :]]
    assert last == [f"{mean:.1f}" for mean in overall] == ["9.2"] * 5


def test_figure_10_compares_the_frames_that_both_drives_have(monkeypatch):
    """With compensation it runs away here; without it it goes on, and worse."""
    wrong = {"raw": np.full((10, 4), 2.0), "off": np.r_[np.ones((10, 4)), [[9.0] * 4]]}
    monkeypatch.setattr(
        runs,
        "loop_run",
        lambda tried, until_lost: SimpleNamespace(
            errors=wrong["off" if tried.servo == off else "raw"]
        ),
    )
    off = servoing.experiment(compensation="off").servo
    shown = numbers("teuliere2009.fig10", compensation="raw")
    assert shown["rms"] == pytest.approx((2.0, 1.0))
