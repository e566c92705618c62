"""The teaching figures show what the chapters say about them."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from mkt.colors import ColorBins
from mkt.evaluation import errors
from mkt.figures.registry import FIGURES
from mkt.histograms import learn
from mkt.homographies import through
from mkt.kernels import Kernels
from mkt.papers import runs
from mkt.papers.lessons import chance
from mkt.papers.lessons import planes as lessons_on_planes
from mkt.papers.lessons import trackers as lessons
from mkt.papers.lessons.servoing import column
from mkt.particles import SCHEMES, effective_sample_size
from mkt.plotting import DESIRED, new_figure
from mkt.regions import displaced
from mkt.scenes.layers import Layer
from mkt.scenes.questions import base
from mkt.scenes.rendering import Scene
from mkt.sequences.carphone import carphone
from mkt.servoing import planes
from mkt.servoing.features import Camera
from mkt.trackers import by_name
from mkt.trackers.newton import differentiate, minimise, newton_step
from mkt.trackers.ssd import SSD
from mkt.tracking import track
from tests.papers.drawing import numbers


@pytest.mark.parametrize("seed", range(4))
def test_ten_steps_lead_to_the_truth(seed):
    shown = numbers("own.newton", seed=seed)
    assert shown["position"][0] == pytest.approx(24) and shown["position"][-1] < 1
    assert shown["orientation"][-1] < np.deg2rad(2) and abs(shown["scale"][-1]) < 0.02
    assert shown["distances"][-1] < shown["distances"][0] / 2


@pytest.mark.parametrize("seed", range(4))
def test_one_kernel_gets_no_turn(seed):
    shown = numbers("own.newton", layout="one", seed=seed)
    assert np.allclose(shown["orientation"], np.deg2rad(20), atol=np.deg2rad(0.5))
    assert shown["position"][-1] < 4


def test_wider_kernels_reach_further():
    """From two thirds of the object's length away, nine kernels reach it at 1.4.

    At a span of 1 they are lost, and the distance tells.
    """
    for seed in range(4):
        narrow, wide = (
            numbers("own.newton", dx=64, span=span, seed=seed) for span in (1.0, 1.4)
        )
        assert narrow["position"][-1] > 20 and narrow["distances"][-1] > 0.6
        assert wide["position"][-1] < 1 and wide["distances"][-1] < 0.3


def test_without_the_derivative_of_c_the_size_takes_longer():
    start = {"dx": 0, "turn": 0, "scale": 0.6}
    for seed in range(4):
        full, frozen = (
            abs(numbers("own.newton", **start, derivative_of_c=c, seed=seed)["scale"])
            for c in (True, False)
        )
        assert (frozen[2:6] > 1.5 * full[2:6]).all() and frozen[-1] < frozen[0] / 5


def crossing(speed, shutter, seed):
    """The bins of a frame in which the car crosses the middle of the image.

    Also its region there, and the reference of the car at rest.
    """
    bins = ColorBins()
    still, moving = (
        Scene(
            Layer(
                "car",
                96,
                ((0, 159.5 - v, 119.5, 0, 1.0), (2, 159.5 + v, 119.5, 0, 1.0)),
            ),
            length=2,
            shutter=shutter,
            seed=seed,
        ).sequence()
        for v in (0, speed)
    )
    kernels = Kernels("3x3", samples=2400)
    target = learn(bins(still.frames[0]), still.truth[0], kernels)
    return bins(moving.frames[1]), moving.truth[1], target


@pytest.mark.parametrize("seed", range(4))
def test_under_blur_the_region_shrinks_only_without_the_derivative_of_c(seed):
    """Chapter 4: any mismatch is read as "too large" when the derivative is left out.

    On sharp frames it does not show.
    """
    sizes = {}
    for shutter in (0.0, 0.9):
        image, truth, target = crossing(28, shutter, seed)
        start = displaced(truth, -28)
        for c in (True, False):
            found, _ = minimise(target, image, start, 10, derivative_of_c=c)
            sizes[shutter, c] = found[3] / truth[3]
    assert sizes[0.9, False] < 0.92 and sizes[0.9, True] > 0.97
    assert abs(sizes[0.0, False] - 1) < 0.04 and abs(sizes[0.0, True] - 1) < 0.04


def test_the_pull_towards_small_sizes_is_twice_the_squared_distance():
    image, truth, target = crossing(24, 0.9, 0)
    q, full = differentiate(target, image, truth)
    _, frozen = differentiate(target, image, truth, derivative_of_c=False)
    seen = q > 1e-6
    error, root = (np.sqrt(q) - np.sqrt(target.q))[seen], np.sqrt(q[seen])
    extra = np.sum((frozen - full)[..., 3][seen] / root * error)
    d2 = np.sum(1 - target.coefficients(image, truth))
    assert extra == pytest.approx(2 * d2, rel=0.03)
    assert newton_step(q, frozen, target.q)[3] < newton_step(q, full, target.q)[3]


@pytest.mark.parametrize("seed", range(3))
def test_kernels_cut_at_the_border_shrink_a_sharp_track_too(seed):
    """Chapter 4: the derivative of C left out, and kernels that are cut.

    Each costs some of the size, and together they cost more.
    """
    clip = replace(base(seed), length=40).sequence()
    size = {}
    for layout in ("3x3", "cut"):
        for c in (True, False):
            tracker = SSD(kernels=Kernels(layout), derivative_of_c=c)
            off = errors(track(tracker, clip).regions, clip.truth)
            size[layout, c] = np.exp(np.median(off.scale[1:]))
    assert size["3x3", True] > 0.97
    assert max(size["3x3", False], size["cut", True]) < size["3x3", True] - 0.015
    assert size["cut", False] < min(size["3x3", False], size["cut", True]) - 0.015


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("n", [4, 7, 12])
def test_the_ticks_fall_on_the_particles_that_are_drawn(scheme, n):
    for seed in range(9):
        shown = numbers("own.resampling", scheme=scheme, n=n, seed=seed)
        shares, positions = lessons.draws(
            scheme, shown["weights"], np.random.default_rng(seed)
        )
        fallen = np.searchsorted(np.cumsum(shares), positions, side="right")
        certain = np.floor(n * shown["weights"] + 1e-9) if scheme == "residual" else 0
        assert (np.bincount(fallen, minlength=n) + certain == shown["counts"]).all()


def test_equal_weights_need_no_luck():
    shown = numbers("own.resampling", lam=0)
    assert (
        shown["n_eff"] == pytest.approx(6)
        and shown["scatter"][0] > 0.5
        and np.allclose(shown["scatter"][1:], 0, atol=1e-9)
    )


def test_multinomial_draws_scatter_most_and_few_particles_live_on():
    for lam in (10, 20, 40):
        shown = numbers("own.resampling", lam=lam, n=12)
        assert shown["scatter"][0] > 1.4 * max(shown["scatter"][1:])
        assert shown["counts"].sum() == 12 and shown["n_eff"] == pytest.approx(
            effective_sample_size(shown["weights"])
        )


def test_a_run_is_made_once_and_read_frame_by_frame():
    runs.run.cache_clear()
    shown = [numbers("own.run", frame=k) for k in (1, 40, 47)]
    assert runs.run.cache_info().misses == 1
    # In frame 47 the target is hidden.
    assert shown[2]["parts"].mean() > shown[1]["parts"].mean() + 0.2
    assert all(1 <= s["n_eff"] <= 75 for s in shown)
    assert (shown[0]["overlap"] == shown[2]["overlap"]).all()


def test_sliders_of_a_run_reach_its_tracker():
    names = ("pf-75", "pf-500", "guided")
    particles = [lessons.configured(name, 25).n for name in names]
    assert particles == [25, 500, by_name.TRACKERS["guided"].n]
    assert lessons.configured("combined", 25).filter.n == 25
    assert numbers("own.run", tracker="ssd")["n_eff"] == 0
    # The last frame of a shorter sequence.
    assert len(numbers("own.run", scene="fast", frame=79)["overlap"]) == 60


@pytest.mark.parametrize("box", [(0.34, 0.1, 0.3, 0.58), (0.45, 0.0, 0.05, 1.0)])
def test_the_histogram_of_a_box_counts_its_pixels_alike(box):
    """Whatever shape the box has."""
    names = ("left", "top", "width", "height")
    shown = numbers("own.video", **dict(zip(names, box, strict=True)))
    image = ColorBins()(carphone().frames[0])
    height, width = image.shape
    x0, x1 = round(box[0] * width), round((box[0] + box[2]) * width)
    y0, y1 = round(box[1] * height), round((box[1] + box[3]) * height)
    pixels = image.labels[y0:y1, x0:x1].ravel()
    counted = np.bincount(pixels, minlength=image.m) / pixels.size
    assert np.abs(shown["histogram"] - counted).sum() < 0.1


def test_the_table_of_a_box_holds_its_distances():
    shown = numbers("own.video")
    x, y = np.meshgrid(shown["x"], shown["y"])
    assert (shown["x [px]"] == x.ravel()).all() and (shown["y [px]"] == y.ravel()).all()
    assert (shown["distance"] == shown["distances"].ravel()).all()


def test_where_one_bin_image_is_flat_the_other_is_a_pit():
    """Chapter 15: another light moves all colours, blur wipes out the edges."""
    light, blur = (numbers("own.bin_images", look=x) for x in ("another light", "blur"))
    assert light["off_colours"] > 20 and light["off_edges"] < 4
    assert blur["off_colours"] < 4 and blur["off_edges"] > 20


def test_both_bin_images_are_between_the_two():
    shares = (0.0, 1.0)
    ends = [numbers("own.bin_images", share=s, look="another light") for s in shares]
    assert ends[0]["off_both"] == ends[0]["off_colours"]
    assert ends[1]["off_both"] == ends[1]["off_edges"]


@pytest.mark.parametrize("covered", [0.7, 0.8])
def test_a_prior_holds_the_size_of_a_covered_car(covered):
    loose, held = (
        numbers("own.priors", covered=covered, size_prior=w) for w in (0.0, 20.0)
    )
    assert loose["size_sum"] == loose["size_O"] and abs(loose["size_O"]) > 0.1
    assert abs(held["size_sum"]) < 0.5 * abs(held["size_O"])


@pytest.mark.parametrize("turned", [20, 40])
def test_a_turn_is_believed_where_the_car_is_seen_and_not_where_it_is_covered(turned):
    seen, hidden = (numbers("own.priors", covered=c, turned=turned) for c in (0, 0.7))
    assert seen["believed"] and not hidden["believed"]
    assert not numbers("own.priors", covered=0, turned=0)["believed"]


def test_one_kernel_feels_no_turn_of_a_card_and_less_of_its_tilts_than_nine():
    """Chapter 16; its map over the tilts is the flattest."""
    colours, edges = (numbers("own.tilt", bins=bins) for bins in ("colours", "edges"))
    assert colours["one"][2] < 1e-6 < 0.05 < edges["one"][2]
    heights = {}
    for side in ("one", "3x3", "5x5"):
        heights[side] = np.ptp(colours[f"map_{side}"])
    assert heights["one"] < 0.6 * heights["3x3"] < 0.6 * heights["5x5"]
    assert (3 * colours["one"][6:] < colours["3x3"][6:]).all()
    assert (colours["3x3"] < colours["5x5"]).all()


@pytest.mark.slow
def test_kernels_find_a_card_from_further_than_pixels():
    """And pixels, where they find it, are several times as exact."""
    shown = numbers("own.basin")
    found = shown["converged_pixels"]
    assert shown["converged_kernels"].mean() > 0.95 and found.mean() < 0.85
    assert np.median(shown["kernels"]) < 1
    assert np.median(shown["pixels"][found]) < np.median(shown["kernels"]) / 5


def test_starts_are_as_far_off_as_they_say():
    look, start_from = lessons_on_planes.look, lessons_on_planes.start_from
    _, region, _, truth = look("base", 500)
    middle = through(truth, [[0, 0]])
    for shift in (0, 15):
        start = start_from("base", 500, shift, 25, 0.2, 30)
        assert np.isclose(np.hypot(*(through(start, [[0, 0]]) - middle)[0]), shift)
    assert np.allclose(start_from("base", 500, 0, 0, 0, 0), truth)
    tilted = start_from("base", 500, 0, 0, 0, 30)
    before, after = (
        planes.pose_of(h, Camera(), region[3:])[:3, 2] for h in (truth, tilted)
    )
    assert np.isclose(np.rad2deg(np.arccos(before @ after)), 30, atol=0.01)


def test_a_false_start_is_as_frequent_as_the_count_by_hand_says():
    """More than 2 of 4 coins: 5 of 16; and no number of samples helps b = epsilon."""
    assert chance.false_start(4, 0.5, 0.5) == pytest.approx(5 / 16)
    rng = np.random.default_rng(0)
    drawn = rng.random((20000, 50)) < 0.05
    often = np.mean(drawn.sum(axis=1) > 0.1 * 50)
    shown = numbers("own.chance", particles=50)
    assert shown["false"] == pytest.approx(often, abs=0.005)
    assert shown["none"] == pytest.approx((1 - shown["false"]) ** 100)
    for particles in (25, 100, 400):
        assert (
            0.4 < numbers("own.chance", epsilon=10, particles=particles)["false"] < 0.5
        )


@pytest.mark.parametrize("particles", [25, 400])
def test_the_names_of_lines_lie_on_no_line(particles):
    fig, _ = FIGURES["own.chance"].draw(particles=particles, epsilon=20, b=0.4)
    fig.canvas.draw()
    names = fig.axes[1].get_legend().get_window_extent()
    for line in fig.axes[1].lines:
        x, y = line.get_transform().transform(line.get_xydata()).T
        right = names.x0 < x
        assert not ((names.y0 < y) & (y < names.y1) & right & (x < names.x1)).any()
    assert len(fig.axes[1].get_legend().texts) == 4


def test_no_share_is_drawn_twice():
    fig, _ = FIGURES["own.chance"].draw(epsilon=5.0)
    names = [text.get_text() for text in fig.axes[1].get_legend().texts]
    assert names == ["2.3 %", "10 %", "5 %"]


def test_a_false_start_is_seen_at_the_end_of_the_slider_too():
    b = FIGURES["own.chance"].values("b")[-1]
    fig, shown = FIGURES["own.chance"].draw(epsilon=20, particles=25, b=b)
    assert shown["probability"].sum() == pytest.approx(1, abs=1e-5)
    bars = fig.axes[0].patches
    red = [bar for bar in bars if to_hex(bar.get_facecolor()) == to_hex(DESIRED)]
    assert sum(bar.get_height() for bar in red) == pytest.approx(
        shown["false"], rel=0.01
    )


def test_an_error_that_runs_away_ends_where_it_leaves_the_picture():
    fig, shown = FIGURES["own.root_locus"].draw(gain=8, delay=3)
    (_, line) = fig.axes[1].lines
    drawn, reach = np.abs(line.get_ydata()), fig.axes[1].get_ylim()[1]
    assert (drawn[:-1] <= reach).all() and drawn[-1] > reach
    assert len(drawn) < len(shown["error"])


def test_an_error_that_settles_is_drawn_to_its_end():
    fig, shown = FIGURES["own.root_locus"].draw()
    assert len(fig.axes[1].lines[1].get_ydata()) == len(shown["error"])


def test_many_frames_have_no_dots_that_fill_the_gaps_of_dashes():
    for fps, dotted in ((5, True), (25, False)):
        fig, _ = FIGURES["own.approach"].draw(fps=fps)
        markers = {line.get_marker() for line in fig.axes[1].lines[:-1:2]}
        assert markers == {"." if dotted else ""}


def test_all_of_a_crowd_and_the_whole_car_are_seen():
    fig, shown = FIGURES["own.beats"].draw(30)
    x, y = shown["x [px]"], shown["y [px]"]
    widths = []
    for ax in fig.axes:
        (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
        assert ((left < x) & (x < right) & (top < y) & (y < bottom)).all()
        widths.append(right - left)
    assert widths[0] == widths[1] == widths[3] < widths[2]


def test_bars_and_means_of_a_model_are_on_one_line():
    fig, _ = FIGURES["own.learnt_motion"].draw()
    _, bars, means = fig.axes
    heights = [bar.get_y() + bar.get_height() / 2 for bar in bars.patches]
    assert np.allclose(heights, [line.get_ydata()[0] for line in means.lines])
    assert bars.get_ylim() == means.get_ylim()


def test_a_run_that_is_over_says_which_frame_is_its_last():
    titles = [
        FIGURES["own.run"].draw(frame=frame, scene="fast")[0].axes[0].get_title()
        for frame in (59, 75)
    ]
    assert titles[0].startswith("frame 59:")
    assert titles[1].startswith("frame 59 (the last):")


def test_the_next_crowd_is_drawn_where_it_was_predicted():
    fig, shown = FIGURES["own.beats"].draw(30)
    (dots,) = fig.axes[3].collections
    there = np.column_stack([shown["x [px]"], shown["y [px]"]])
    assert np.array_equal(dots.get_offsets(), there[shown["offspring"] > 0])


def test_the_share_in_the_legend_is_of_what_has_converged():
    ax = new_figure((4, 3)).subplots()
    lessons_on_planes._draw_shares(
        ax, {"kernels": np.array([1, 1.9, 3, 5]), "pixels": np.ones(4)}
    )
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["kernels: 50%", "pixels: 100%"]


def test_below_each_view_stands_its_own_column():
    fig, shown = FIGURES["own.interaction"].draw(30)
    said = [ax.texts[-1].get_text() for ax in fig.axes]
    assert said == [column(values) for values in shown["L"].T]


def test_the_expected_offspring_are_drawn():
    fig, shown = FIGURES["own.resampling"].draw(30)
    (line,) = fig.axes[2].lines
    assert line.get_ydata() == pytest.approx(shown["expected offspring"])


def test_the_band_ends_at_its_share_of_the_first_orientation():
    fig, shown = FIGURES["own.priors"].draw(30, believed_below=0.5)
    (band,) = fig.axes[2].patches
    first = shown["O over turn"][shown["turn [deg]"] == 0]
    assert band.get_height() == pytest.approx(0.5 * first)
