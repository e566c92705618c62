"""What computes in the pages: live figures, the camera, and what pages may not do."""

import base64
import gzip
import re
import threading
from dataclasses import dataclass
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from itertools import pairwise

import cv2
import matplotlib
import numpy as np
import pytest
from playwright.sync_api import expect

from mkt.colors import ColorBins
from mkt.course.book import live, security
from mkt.evaluation import errors, overlap
from mkt.figures.live import maker, needed
from mkt.figures.registry import FIGURES
from mkt.histograms import histograms, learn
from mkt.kernels import Kernels
from mkt.papers.lessons import beats
from mkt.papers.teuliere2009.histograms import WIDEST, still
from mkt.regions import displaced
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.combined import Combined
from mkt.trackers.newton import newton_path
from mkt.tracking import Sequence, track
from tests.browser.conftest import launched
from tests.browser.test_pages import AXE, BY_TURNS, WIDE, Opened

pytestmark = pytest.mark.slow

HISTOGRAMS, SURFACES = "01_color_histograms", "02_cost_surfaces"
MOTIONS = "07_interaction_matrix"
NEWTON, BEATS = "04_multiple_kernel_ssd", "05_particle_filter"
COMBINED = "06_combining_both"
LOOP, SUCCESS, TRACK = "08_closing_the_loop", "14_fair_benchmark", "track"
WAITING, SEARCHES = "10_color_particle_filter", "13_hybrid_resampling"
FINDING = "11_losing_and_finding"
TELEPHONE = {"width": 390, "height": 844}
LIVE = {name: entry for name, entry in FIGURES.items() if entry.live}
BOX = (0xCF, 0x82, 0x00)  # of mkt/live/camera.js
PATIENCE = 300  # times 200 ms for sixty frames of the camera
CLOSE = 6e-4  # pages say three places
NUMBERS = re.compile(r"distance ([\d.]+) for one kernel, ([\d.]+) for")


@pytest.fixture(scope="module")
def served(site):
    """The address of the site on a plain file server of this machine."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    handler = partial(Quiet, directory=str(site))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture
def opened(site, browser):
    """Opens a page of the site on the disk; nothing may have gone wrong in the end."""
    pages = []

    def go(name, address="", size=WIDE, ratio=1):
        pages.append(Opened(browser, size, ratio))
        pages[-1].page.goto((site / f"{name}.html").as_uri() + address)
        return pages[-1].page

    yield go
    for each in pages:
        troubles = each.troubles
        each.page.close()
        assert troubles == []


def ready(page, words=r"distance \d", place=0):
    """A live panel of a page, once it says where it stands."""
    panel = page.locator(".mkt-soon").nth(place)
    panel.scroll_into_view_if_needed()
    panel.locator("canvas").first.wait_for()
    panel.locator("p[role=status]", has_text=re.compile(words)).first.wait_for()
    return panel


def number(panel, words):
    """The number that a panel states behind some words."""
    return float(re.search(rf"{words} (\d+(\.\d+)?)", panel.inner_text())[1])


def drag(page, canvas, *places):
    """Draw a mouse over a canvas, from place to place, as shares of its sides."""
    canvas.hover()  # waits until it has come to rest
    box = canvas.bounding_box()
    points = [
        (box["x"] + u * box["width"], box["y"] + v * box["height"]) for u, v in places
    ]
    page.mouse.move(*points[0])
    page.mouse.down()
    for point in points[1:]:
        page.mouse.move(*point, steps=4)
    page.mouse.up()


def slide(panel, name):
    return panel.get_by_label(name, exact=True)


def said(panel):
    """The two distances that figure 3 states."""
    return [float(number) for number in NUMBERS.search(panel.inner_text()).groups()]


def wanted(layout="3x3", span=1.0, bins="hsv", item="car", x=0.0, rotation=0.0):
    clip = still(item)
    learnt, seen = (ColorBins(bins)(frame) for frame in clip.frames)
    place = displaced(clip.truth[0], x, 0, np.deg2rad(rotation))
    specs = [
        Kernels("one", span=min(span, 1), samples=2400),
        Kernels(layout, span=span, samples=2400),
    ]
    targets = [learn(learnt, clip.truth[0], each) for each in specs]
    return [float(target.distances(seen, place)) for target in targets]


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"layout": "4x4", "span": 0.9, "x": 5, "rotation": 12},
        {"bins": "rgb", "item": "cat", "x": -11.5, "rotation": -33},
        {"bins": "hs", "item": "hopper", "layout": "2x2", "span": 1.3, "x": 3},
    ],
)
def test_figure_3_says_what_python_says_for_any_settings(opened, settings):
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    panel = ready(opened(SURFACES, f"#fig3?{words}"))
    assert np.abs(np.subtract(said(panel), wanted(**settings))).max() < CLOSE


def test_hands_and_keys_move_figure_3_and_the_link_follows(opened):
    page = opened(SURFACES, "#fig3")
    panel = ready(page)
    at_rest = said(panel)
    frame, several = panel.locator("canvas").first, panel.locator("canvas").nth(2)
    expect(frame).to_have_role("application")  # a picture has no keys
    frame.press("ArrowRight")
    frame.press("ArrowDown")
    assert "x = 1 px, rotation = 2 degrees" in panel.inner_text()
    assert page.url.endswith("#fig3?x=1.0&rotation=2")
    box = several.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.45 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.3 * box["height"])
    dragged = said(panel)
    page.mouse.up()
    assert dragged[1] > at_rest[1] + 0.1
    slide(panel, "span").press("ArrowLeft")
    assert "span=0.99" in page.url
    page.go_back()
    assert slide(panel, "span").input_value() == "1"
    several.tap(position={"x": box["width"] / 2, "y": box["height"] / 2})
    assert said(panel)[1] < dragged[1]
    panel.locator(".mkt-reset").click()
    assert said(panel) == at_rest


def test_a_wheel_over_a_number_scrolls_the_page_and_changes_nothing(opened):
    page = opened(SURFACES, "#fig3")
    panel = ready(page)
    typed = panel.get_by_label("span, as a number")
    typed.click()
    before = at_rest(typed)
    page.mouse.wheel(0, 200)
    assert at_rest(typed)["y"] < before["y"] - 50
    assert typed.input_value() == "1.00"


def test_a_command_that_was_shown_goes_when_its_figure_is_moved(opened):
    panel = ready(opened(SURFACES, "#fig3"))
    panel.get_by_role("button", name="command for a PDF of it").click()
    panel.get_by_text("python3 -m mkt figure").wait_for()
    slide(panel, "span").press("ArrowLeft")
    assert "python3 -m mkt figure" not in panel.inner_text()


PIXEL = """(canvas, [x, turn]) => {
  const [w, h] = [canvas.clientWidth - 44, canvas.clientHeight - 82];
  const [u, v] = [38 + (w * (x + 20)) / 40, 42 + (h * (60 - turn)) / 120];
  const sharp = canvas.width / canvas.clientWidth;
  const at = [u, v].map((each) => Math.round(each * sharp));
  return [...canvas.getContext("2d").getImageData(...at, 1, 1).data];
}"""


def test_the_maps_of_figure_3_show_the_distance_where_it_is(opened):
    """Their colours: neither mirrored nor turned over."""
    panel = ready(opened(SURFACES, "#fig3?item=hopper&x=0&rotation=0"))
    places = [(x, turn) for x in (-18, 18) for turn in (-32, 32)]
    expected = np.array(
        [wanted(item="hopper", x=x, rotation=turn) for x, turn in places]
    ).T
    # Or a map that is mirrored or turned over would look the same.
    assert np.abs(expected[1] - expected[1, [1, 0, 3, 2]]).max() > 0.05
    assert np.abs(expected[1] - expected[1, [2, 3, 0, 1]]).max() > 0.05
    colors = matplotlib.colormaps["viridis"](np.arange(256))[:, :3] * 255

    def shown(k):
        pixels = [
            panel.locator("canvas").nth(1 + k).evaluate(PIXEL, at) for at in places
        ]
        off = np.abs(np.array(pixels)[:, None, :3] - colors).sum(-1)
        return 0.9 * off.argmin(-1) / 255

    for _ in range(PATIENCE):  # until every cell is computed
        off = np.abs([shown(k) for k in (0, 1)] - expected).max()
        if off < 0.02:
            break
        panel.page.wait_for_timeout(200)
    assert off < 0.02


# The colours of the scale above a map, from end to end.
SCALE = """(canvas) => {
  const sharp = canvas.width / canvas.clientWidth;
  const line = canvas.getContext("2d").getImageData(0, 7 * sharp, canvas.width, 1);
  return [...line.data];
}"""


def test_a_scale_above_the_maps_has_their_colours(opened):
    panel = ready(opened(SURFACES, "#fig3"))
    line = np.reshape(panel.locator("canvas").nth(1).evaluate(SCALE), (-1, 4))
    ends = matplotlib.colormaps["viridis"]([0, 255])[:, :3] * 255
    off = np.abs(line[:, None, :3] - ends).sum(-1)
    low, high = np.where(line[:, 3:] == 255, off, np.inf).argmin(0)
    assert (off[[low, high], [0, 1]] < 12).all() and high - low == pytest.approx(90, 3)


# Where the canvases of a panel stand [px], and their pictures.
CANVASES = """panel => [...panel.querySelectorAll("canvas")].map((canvas) => {
  const { left, top } = canvas.getBoundingClientRect();
  return [left, top, canvas.toDataURL().split(",")[1]];
})"""


def saved(page, panel, folder):
    """What the button of a panel saves (H, W, 3)."""
    with page.expect_download() as download:
        panel.locator(".mkt-save").click()
    download.value.save_as(folder / "saved.png")
    return cv2.imread(str(folder / "saved.png"))


@pytest.mark.parametrize("ratio", [0.8, 1, 2])  # below 1 where a page is made smaller
def test_what_is_saved_is_what_is_shown(opened, tmp_path, ratio):
    page = opened(HISTOGRAMS, "#fig1?item=cat", ratio=ratio)
    panel = ready(page)
    found = saved(page, panel, tmp_path)
    assert len(np.unique(found.reshape(-1, 3), axis=0)) > 1000
    canvases = panel.evaluate(CANVASES)
    assert len(canvases) == 3
    corner, ends = np.min([place for *place, _ in canvases], axis=0), []
    for *place, picture in canvases:
        data = np.frombuffer(base64.b64decode(picture), np.uint8)
        own = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        x, y = np.floor(max(ratio, 1) * (place - corner) + 0.5).astype(int)
        part = found[y : y + own.shape[0], x : x + own.shape[1]]
        opaque = own[..., 3] == 255
        assert opaque.any()
        assert cv2.absdiff(part, own[..., :3])[opaque].max() == 0
        ends.append((y + own.shape[0], x + own.shape[1]))
    assert found.shape[:2] == tuple(np.max(ends, axis=0))  # and nothing round them


@pytest.mark.parametrize(
    "words, complaint",
    [
        ("layout=<img src=x onerror=alert(1)>", "must be one of one, 2x2"),
        ("span=9", "must be a number from 0.4 to 1.4"),
        ("span=", "must be a number"),
        ("extent=12.5", "must be a whole number from 10 to 40"),
        ("__proto__=1&constructor=2", "there is no __proto__"),
        ("%3Cscript%3Ealert(1)%3C/script%3E=1", "there is no <script>"),
    ],
)
def test_a_wrong_link_is_said_and_does_nothing(opened, words, complaint):
    page = opened(SURFACES, f"#fig3?{words}&x=2")
    panel = ready(page)
    assert complaint in panel.inner_text()
    assert "x = 2 px" in panel.inner_text()
    assert panel.locator("img, script:not(.mkt-data)").count() == 0


def test_newtons_steps_are_pythons(opened):
    page = opened(NEWTON, "#newton?dx=-20&turn=15&scale=1.2&derivative_of_c=no")
    panel = ready(page)
    clip = still("car")
    learnt, seen = (ColorBins()(frame) for frame in clip.frames)
    target = learn(learnt, clip.truth[1], Kernels("3x3", samples=2400))
    start = displaced(clip.truth[1], -20, 0, np.deg2rad(15), 1.2)
    path = newton_path(target, seen, start, 4, derivative_of_c=False)
    distances = target.distances(seen, path)
    for taken, distance in enumerate(distances):
        words = f"Step {taken} of 10.*distance ([\\d.]+)"
        found = re.search(words, panel.inner_text())
        assert found and abs(float(found[1]) - distance) < 5e-3
        about = panel.locator("canvas[aria-label^='O along']").get_attribute(
            "aria-label"
        )
        told = float(re.search(r"next step, ([\d.]+) at", about)[1])
        assert told == pytest.approx(2 * len(target.q) * distance**2, rel=0.03)
        off = errors(path[taken], clip.truth[1])
        words = r"off by ([\d.]+) px, ([\d.]+) degrees and ([\d.]+) % in size"
        told = [float(each) for each in re.search(words, panel.inner_text()).groups()]
        size = 100 * abs(np.expm1(off.scale))
        expected = [off.position, np.rad2deg(off.orientation), size]
        assert np.allclose(told, expected, atol=0.6)
        panel.get_by_role("button", name="step", exact=True).click()


# The film of four beats


def test_the_film_goes_beat_by_beat_and_back(opened):
    page = opened(BEATS, "#beats?frame=7&beat=3%20estimate")
    panel = ready(page, "Frame 7 of 59, 3 estimate", place=1)
    assert number(panel, "overlap with the truth") > 0.7
    step = panel.get_by_role("button", name="next beat")
    step.click()
    step.click()
    assert "Frame 8 of 59, 1 predict" in panel.inner_text()
    panel.get_by_role("button", name="one beat back").press("Enter")
    assert "Frame 7 of 59, 4 draw" in panel.inner_text()
    panel.get_by_role("button", name="play").click()
    panel.locator(".mkt-reset").click()
    panel.get_by_role("button", name="play").wait_for()  # it rests
    said = panel.locator("p[role=status]", has_text="Frame")
    assert said.get_attribute("aria-live") is None  # it is read out again
    slide(panel, "frame").fill("8")
    slide(panel, "beats per second").fill("20")
    panel.get_by_role("button", name="play").click()
    panel.get_by_text(re.compile(r"Frame (9|[1-5]\d) of 59")).wait_for()
    panel.get_by_role("button", name="pause").click()
    slide(panel, "frame").press("Home")
    assert "Frame 1 of 59" in panel.inner_text()


def test_lambda_particles_and_scheme_are_free_while_it_runs(opened):
    panel = ready(opened(BEATS, "#beats?frame=12&lam=0&n=40"), "Frame 12", place=1)
    assert "N_eff 40.0 of 40" in panel.inner_text()
    slide(panel, "scheme").select_option("systematic")
    assert "40 of 40 live on" in panel.inner_text()
    slide(panel, "lambda").fill("60")
    assert number(panel, "N_eff") < 20
    slide(panel, "particles").fill("200")
    assert re.search(r"N_eff [\d.]+ of 200", panel.inner_text())


@pytest.mark.parametrize(
    "chapter, address, place, near, last, anew",
    [
        (
            COMBINED,
            "#fig6?frame=76",
            0,
            "Frame 76 of 79",
            "Frame 79 of 79",
            "[1-6]?\\d",
        ),
        (
            BEATS,
            "#beats?frame=59&beat=3%20estimate&pace=20",
            1,
            "Frame 59",
            "Frame 59 of 59, 4 draw",
            "[1-6]",
        ),
    ],
)
def test_a_film_is_played_to_its_end_and_anew(
    opened, chapter, address, place, near, last, anew
):
    panel = ready(opened(chapter, address), near, place=place)
    play = panel.get_by_role("button", name="play")
    play.click()
    panel.get_by_text(last).wait_for()
    play.click()
    panel.get_by_text(re.compile(rf"Frame {anew} of \d\d")).wait_for()
    panel.get_by_role("button", name="pause").click()


def test_a_wall_is_moved_in_by_mouse_and_by_keys_and_the_past_stays(opened):
    page = opened(BEATS, "#beats?frame=18")
    panel = ready(page, "Frame 18", place=1)
    seen = number(panel, "distance")
    frame = panel.locator("canvas").first
    drag(page, frame, (0.95, 0.5), (0.8, 0.5), (0.65, 0.5))
    assert number(panel, "distance") > seen + 0.2  # the car is behind it
    slide(panel, "frame").press("ArrowLeft")
    assert number(panel, "distance") < seen + 0.1  # before, it was not
    slide(panel, "frame").press("ArrowRight")
    wall = int(slide(panel, "wall [px]").input_value())
    frame.press("ArrowRight")
    assert slide(panel, "wall [px]").input_value() == str(wall + 5)
    assert f"wall={wall + 5}" in page.url


def test_the_film_of_beats_shows_the_part_round_the_crowd(opened):
    page = opened(BEATS, "#beats?frame=20")
    panel = ready(page, "Frame 20", place=1)
    drag(page, panel.locator("canvas").first, (0.9, 0.5), (0.5, 0.5))
    wall = int(slide(panel, "wall [px]").input_value())
    assert wall == pytest.approx(beats.film().sequence().truth[20, 0], abs=10)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"scheme": "systematic", "seed": 4, "lam": 60},
        {"scheme": "residual", "n": 9, "lam": 7, "seed": 2},
        {"scheme": "stratified", "n": 12, "lam": 35},
    ],
)
def test_a_draw_has_pythons_offspring(opened, settings):
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    panel = ready(opened(BEATS, f"#resampling?{words}"), "live on")
    shown = FIGURES["own.resampling"].draw(**settings)[1]
    offspring = " ".join(map(str, shown["counts"]))
    assert f"offspring {offspring}." in panel.inner_text()
    assert abs(number(panel, "N_eff") - shown["n_eff"]) < 0.051
    about = panel.locator("canvas").nth(3).get_attribute("aria-label")
    spreads = [float(each) for each in re.findall(r" ([\d.]+)", about)]
    np.testing.assert_allclose(spreads, shown["scatter"], atol=0.06)


# Figure 6


def errors_before(panel):
    """The medians before the wall [px], a number for each tracker."""
    rows = panel.locator("tbody tr")
    cells = [row.locator("td").first for row in rows.all()]
    return np.array([float(cell.inner_text()) for cell in cells])


# What a panel says while it runs may be gone before one looks.
COUNT = """panel => {
  window.counted = [];
  const look = () => {
    const found = panel.textContent.match(/\\d+(?= of 20 runs done)/);
    if (found) window.counted.push(Number(found[0]));
  };
  new MutationObserver(look).observe(panel, { subtree: true, childList: true });
}"""


PARTS = "stage", "table"
# What rows (4) and (5) say at once when they have other particles.
OTHERS = """panel => {
  const label = "particles of (4) and (5), as a number";
  const typed = panel.querySelector(`[aria-label="${label}"]`);
  typed.value = "30";
  typed.dispatchEvent(new Event("change"));
  const rows = [...panel.querySelectorAll("tbody tr")].slice(3);
  return rows.map((row) => row.cells[1].textContent);
}"""


def test_the_runs_behind_the_wall_err_as_pythons_do_and_only_what_is_new_runs_anew(
    opened, tmp_path
):
    page = opened(COMBINED, "#fig6")
    panel = ready(page, "runs done")
    done = panel.get_by_text("All runs done")
    expect(panel.locator(".mkt-save")).to_be_disabled()  # half a picture
    done.wait_for(timeout=120_000)
    # The table below them is no part of the picture.
    tops = [panel.locator(f".mkt-{name}").bounding_box()["y"] for name in PARTS]
    assert saved(page, panel, tmp_path).shape[0] < np.ptp(tops)
    shown, many = FIGURES["teuliere2009.fig6"].draw()[1], errors_before(panel)
    wanted = np.median(shown["position"][0], -1)
    np.testing.assert_allclose(many, wanted, rtol=0.3)
    assert "the wall hides 0 %" in panel.inner_text()
    slide(panel, "frame").fill("48")
    assert "the wall hides 100 %" in panel.inner_text()
    assert panel.evaluate(OTHERS) == 2 * ["..."]
    done.wait_for(timeout=120_000)
    panel.evaluate(COUNT)
    typed = panel.get_by_label("particles of (4) and (5), as a number")
    typed.fill("20")
    typed.press("Enter")
    panel.page.wait_for_function("window.counted.length", timeout=120_000)
    done.wait_for(timeout=120_000)
    assert min(panel.page.evaluate("window.counted")) >= 15
    few = errors_before(panel)
    assert (few[:3] == many[:3]).all() and few[3] > many[3]
    typed.fill("9999")
    typed.press("Enter")
    assert typed.input_value() == "300"


# Figures 1, 2 and 4


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"span": 0.5, "x": 12, "y": -7, "item": "cat"},
        {"profile": "uniform", "bins": "rgb", "x": 30},
    ],
)
def test_figure_1_counts_as_python_does_wherever_the_kernel_is(opened, settings):
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    panel = ready(opened(HISTOGRAMS, f"#fig1?{words}"))
    clip = still(settings.get("item", "car"))
    image = ColorBins(settings.get("bins", "hsv"))(clip.frames[0])
    profile, span = settings.get("profile", "epanechnikov"), settings.get("span", 1.0)
    target = learn(image, clip.truth[0], Kernels("one", profile, span))
    place = displaced(clip.truth[0], settings.get("x", 0), settings.get("y", 0))
    q = histograms(image, target.kernels, place)[0, 0]
    assert f"{np.count_nonzero(q)} of {len(q)} bins filled" in panel.inner_text()
    wanted = float(target.distances(image, place))
    assert abs(number(panel, "distance") - wanted) < CLOSE


LIT = re.compile(r"bin \d+ has q")


def test_a_bar_lights_its_pixels_and_a_pixel_its_bar(opened):
    page = opened(HISTOGRAMS, "#fig1")
    panel = ready(page)
    frame, _, bars = panel.locator("canvas").all()[:3]
    bars.press("ArrowRight")
    first = number(panel, "bin")
    bars.press("ArrowRight")
    assert number(panel, "bin") > first
    box = frame.bounding_box()
    place = {"x": 100.5 / 200 * box["width"], "y": 90.5 / 180 * box["height"]}
    frame.hover(position=place)
    lit = number(panel, "bin")
    clip = still("car")
    column, row = 60 + 100, 30 + 90  # what the canvas shows, and its middle
    assert lit == ColorBins()(clip.frames[0]).labels[row, column]
    before = number(panel, "distance")
    drag(page, frame, (0.5, 0.5), (0.7, 0.6))
    assert number(panel, "distance") > before + 0.3
    assert not LIT.search(panel.inner_text())  # or all but one bin would be dark
    page.wait_for_url("**#fig1?x=*")


def test_what_weighs_nothing_is_black(opened):
    panel = ready(opened(HISTOGRAMS, "#fig1"))
    samples = panel.locator("canvas").nth(1)
    left = """canvas => {
      const middle = canvas.height / 2;
      return [...canvas.getContext("2d").getImageData(9, middle, 1, 1).data];
    }"""
    assert samples.evaluate(left) == [0, 0, 0, 255]


@pytest.mark.parametrize(
    "layout, span", [("one", 1.3), ("2x2", 1.4), ("3x3", 1.2), ("tiles", 1.0)]
)
def test_figure_2_weighs_as_python_does(opened, layout, span):
    page = opened(HISTOGRAMS, f"#fig2?layout={layout}&span={span}&kernel=4")
    panel = ready(page, "samples, worth", 1)
    profile = "uniform" if layout == "tiles" else "epanechnikov"
    inside = min(span, WIDEST.get(layout, span))
    kernels = Kernels(layout, profile, inside).fitted(still("car").truth[0])
    k = min(4, len(kernels.weights)) - 1
    weights = np.asarray(kernels.weights)[k]
    stays = f"Its span stays {inside:g}." in panel.inner_text()
    assert stays == (inside < span)
    assert number(panel, "it sees") == np.count_nonzero(weights)
    assert slide(panel, "kernel").input_value() == str(k + 1)
    assert slide(panel, "profile").is_disabled() == (layout == "tiles")
    assert number(panel, "worth") == round(1 / np.sum(weights**2))
    if layout == "3x3":
        panel.locator("canvas").first.press("ArrowDown")
        assert "Kernel 7 of 9" in panel.inner_text()


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"exposure": 0.0, "speed": 0},
        {"exposure": 0.5, "speed": 20, "item": "cat", "layout": "one"},
    ],
)
def test_figure_4_blurs_as_python_does(opened, settings):
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    panel = ready(opened(SURFACES, f"#fig4?{words}"), r"for the blurred one", 1)
    shown = FIGURES["teuliere2009.fig4"].draw(**settings)[1]
    assert abs(number(panel, "distance") - shown["sharp"][20, 20]) < CLOSE
    # The blurred frame has noise of its own, and its photographs are compressed.
    blurred = number(panel, "for the sharp frame,")
    assert abs(blurred - shown["blurred"][20, 20]) < 0.05


# The loop, and the benchmark


@pytest.mark.parametrize(
    "settings",
    [
        {"gain": 1.0},
        {"gain": 2.35, "delay": 2, "mismatch": 1.3},
        {"gain": 3.0, "delay": 1, "compensation": "Kalman", "fps": 12.5},
    ],
)
def test_the_largest_pole_is_pythons(opened, settings):
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    panel = ready(opened(LOOP, f"#root_locus?{words}"), "Largest pole", 1)
    shown = FIGURES["own.root_locus"].draw(**settings)[1]
    assert abs(number(panel, "Largest pole") - shown["radius"]) < CLOSE
    if shown["radius"] < 1:
        worst = np.abs(shown["error"]).max()
        assert abs(number(panel, "greatest distance") - worst) < 0.051


def test_an_error_that_is_gone_at_once_has_a_pole_at_0_and_the_limit_is_said(opened):
    panel = ready(opened(LOOP, "#root_locus?gain=5"), "Largest pole", 1)
    assert "Largest pole 0.000: stable." in panel.inner_text()
    assert "1 pole beside values" in panel.inner_text()
    slide(panel, "gain [1/s]").fill("10")
    assert "Largest pole 1.000: at the limit." in panel.inner_text()
    slide(panel, "mismatch").fill("4")
    assert "Gain x frame period / mismatch = 0.5" in panel.inner_text()


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"gain": 4.45, "delay": 3, "fps": 10}, "0.99998: stable"),
        ({"gain": 3.8, "delay": 2, "mismatch": 1.5}, "1.0004: runs away"),
        ({"gain": 10}, "1.000: at the limit"),
        ({"gain": 1}, "0.800: stable"),
    ],
)
def test_a_pole_near_the_limit_has_more_places_as_pythons_has(opened, settings, words):
    raw = {"compensation": "raw", **settings}
    link = "&".join(f"{name}={value}" for name, value in raw.items())
    panel = ready(opened(LOOP, f"#root_locus?{link}"), "Largest pole", 1)
    assert f"Largest pole {words}." in panel.inner_text()
    title = FIGURES["own.root_locus"].draw(**raw)[0].axes[0].get_title()
    assert title == f"largest pole {words}"


# How far to the right a canvas has strokes in the green of what is now [share].
GREEN_UP_TO = """(canvas) => {
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  let last = 0;
  for (let i = 0; i < data.length; i += 4)
    if (data[i] < 60 && data[i + 1] > 130 && data[i + 2] < 110 && data[i + 3] > 200)
      last = Math.max(last, (i / 4) % width);
  return last / width;
}"""


def test_an_error_that_runs_away_ends_where_it_leaves_the_picture(opened):
    page = opened(LOOP, "#root_locus?gain=8&delay=3")
    panel = ready(page, "runs away", 1)
    answer = panel.locator("canvas").nth(1)
    assert 0.1 < answer.evaluate(GREEN_UP_TO) < 0.4
    panel.get_by_role("button", name="reset").click()
    panel.get_by_text("stable").wait_for()
    assert answer.evaluate(GREEN_UP_TO) > 0.9


def test_a_pole_is_dragged_along_its_way(opened):
    page = opened(LOOP, "#root_locus?delay=1&gain=2")
    panel = ready(page, "Largest pole", 1)
    plane = panel.locator("canvas").first
    drag(page, plane, (0.6, 0.3), (0.75, 0.1))
    assert number(panel, "Largest pole") > 1 and "runs away" in panel.inner_text()
    gain = float(slide(panel, "gain [1/s]").input_value())
    plane.press("ArrowLeft")
    assert float(slide(panel, "gain [1/s]").input_value()) < gain


def test_the_six_motions_say_pythons_columns_and_the_car_is_dragged(opened):
    page = opened(MOTIONS, "#interaction?x=-30&y=20&turn=15&scale=0.75")
    L = FIGURES["own.interaction"].draw(x=-30, y=20, turn=15, scale=0.75)[1]["L"]
    panel = ready(page, "107 cm above the table")
    for title, k in ("looks up", 3), ("rolls clockwise", 5), ("moves forward", 2):
        label = panel.locator(f"canvas[aria-label*='{title}']").get_attribute(
            "aria-label"
        )
        shown = re.findall(r"(?:n|\u03b8) (\S+?)(?:,|$)", label.replace("\u2212", "-"))
        assert [float(each) for each in shown] == pytest.approx(L[:, k], abs=0.0051)
    first = panel.locator("canvas").first
    drag(page, first, (0.4, 0.5), (0.6, 0.5))
    assert -30 < float(slide(panel, "x [px]").input_value())
    first.press("ArrowDown")
    page.wait_for_url("**y=21*")


def test_the_approach_ends_as_pythons_does_and_its_start_is_dragged(opened):
    settings = {"gain": 1.0, "fps": 5, "delay": 3, "turn": -60}
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    page = opened(LOOP, f"#approach?{words}")
    panel = ready(page, "Gain x frame period = 0.2: after 6 s")
    errors = np.abs(FIGURES["own.approach"].draw(**settings)[1]["errors"]).max(1)
    share = 100 * errors[-1] / errors[0]
    assert abs(number(panel, "largest error is") / share - 1) < 0.06
    drag(page, panel.locator("canvas").first, (0.5, 0.5), (0.7, 0.6))
    page.wait_for_url("**right=*down=*")
    panel.get_by_role("button", name="command for a PDF of it").click()
    panel.get_by_text("which has no start: right [m], start: down [m]").wait_for()
    slide(panel, "gain [1/s]").fill("6")
    panel.get_by_text("runs away").first.wait_for()
    panel.get_by_role("button", name="reset").click()
    slide(panel, "gain [1/s]").fill("3")
    panel.get_by_text("is less than 0.01 % of the first one").first.wait_for()


def test_samples_wait_as_pythons_do_and_doors_are_dragged(opened):
    settings = {"placement": "doors", "particles": 400, "frame": 131}
    words = "&".join(f"{name}={value}" for name, value in settings.items())
    page = opened(WAITING, f"#fig3?{words}")
    panel = ready(page, "the tracking starts")
    door = FIGURES["nummiaro2003.fig3"]
    drawn = [door.draw(**settings, seed=seed)[1] for seed in range(3)]
    wanted = [shown["positives"] for shown in drawn]
    assert 150 < min(wanted) and abs(appearing(panel) - np.mean(wanted)) < 40
    assert "it takes more than 40," in panel.inner_text()
    plot = panel.locator("canvas").nth(1).get_attribute("aria-label")
    limit, student = (f"{drawn[0][name]:.2f}" for name in ("limit", "student"))
    assert f"limit at {limit}" in plot and f"student at {student}" in plot
    # The right door, which the student has come out of, goes to the top.
    drag(page, panel.locator("canvas").first, (0.68, 0.5), (0.9, 0.1))
    page.wait_for_url("**x2=*y2=*")
    assert appearing(panel) == 0 and "does not start" in panel.inner_text()
    slide(panel, "spreads above the mean").fill("0")
    assert appearing(panel) > 100  # as the background does: half of it
    panel.get_by_role("button", name="command for a PDF of it").click()
    panel.get_by_text("spreads above the mean").last.wait_for()
    # A sample that is pointed at may be gone with the next ones.
    slide(panel, "placement").select_option("anywhere")
    page.wait_for_url("**placement=anywhere*")
    address = page.url
    panel.locator("canvas").first.press("ArrowLeft")  # there is no door to be moved
    assert page.url == address
    panel.locator("canvas").first.hover()
    slide(panel, "particles").fill("25")
    assert " of 25 appear" in panel.inner_text()


def test_a_search_is_counted_draw_by_draw(opened):
    page = opened(SEARCHES, "#complexity?particles=10&left=10")
    panel = ready(page, "0 of 10 draws: 0 comparisons")
    assert slide(panel, "draws to come").get_attribute("max") == "10"
    panel.get_by_role("button", name="play").click()
    panel.get_by_text("10 of 10 draws").wait_for()
    panel.get_by_role("button", name="play").wait_for()
    anew, swept = number(panel, "draws:"), number(panel, "begins anew,")
    assert 10 <= swept <= 19 < anew <= 100
    exponents = panel.locator("canvas").nth(1).get_attribute("aria-label")
    slopes = [float(words) for words in re.findall(r"\d\.\d\d", exponents)]
    assert np.allclose(slopes, [2, 1], atol=0.1)
    panel.locator("canvas").first.press("ArrowUp")
    panel.get_by_text("9 of 10 draws").wait_for()
    page.wait_for_url("**left=1*")


def test_the_line_of_chance_is_dragged_to_where_no_start_is_false(opened):
    page = opened(FINDING, "#chance?particles=400&epsilon=2.5&b=0.26")
    panel = ready(page, "no false start in 100 frames")
    assert number(panel, "more than") == 104  # of 400, not rounded to 100
    assert "tracking: less than one frame in a million." in panel.inner_text()
    chance = FIGURES["own.chance"]
    none = chance.draw(particles=400, epsilon=2.5, b=0.26)[1]["none"]
    assert number(panel, "With a probability of") == pytest.approx(100 * none, abs=0.05)
    waits = panel.locator("canvas").nth(1)
    drag(page, waits, (0.5, 0.5), (0.265, 0.5))
    page.wait_for_url("**b=0.0*")
    b = float(re.search(r"b=([\d.]+)", page.url)[1])
    waits.press("ArrowLeft")
    page.wait_for_url(f"**b={b - 0.01:.2f}*")
    none = chance.draw(particles=400, epsilon=2.5, b=round(b - 0.01, 2))[1]["none"]
    assert number(panel, "With a probability of") == pytest.approx(100 * none, abs=0.05)


def appearing(panel):
    """How many samples appear, as the panel of figure 3 of [N03] says."""
    return int(re.search(r"(\d+) of \d+ appear", panel.inner_text())[1])


def test_the_ranking_follows_a_limit_that_moves_freely(opened):
    page = opened(SUCCESS, "#success?limit=0.37&scene=look-alike&seed=1")
    panel = ready(page, "first (is|are)")
    settings = {"limit": 0.37, "scene": "look-alike", "seed": 1}
    shown = FIGURES["own.success"].draw(**settings)[1]
    best = float(re.search(r"with ([\d.]+) %", panel.inner_text())[1])
    assert abs(best - 100 * shown["seen"].max()) < 0.051
    curves = panel.locator("canvas").first
    drag(page, curves, (0.4, 0.5), (0.93, 0.5))
    high = float(re.search(r"with ([\d.]+) %", panel.inner_text())[1])
    assert high < best
    curves.press("ArrowLeft")
    assert "T<sub>lim</sub>" in panel.inner_html() and "limit=0.9" in page.url
    before = curves.evaluate("canvas => canvas.toDataURL()")
    panel.locator("canvas").nth(1).press("ArrowDown")  # to one row of the ranking
    assert curves.evaluate("canvas => canvas.toDataURL()") != before


# A key that is held: its moves are one step back.
HELD = """canvas => {
  for (let k = 0; k < 5; k++)
    canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
}"""


def test_back_to_the_page_as_it_came_shows_its_figures_so(opened):
    page = opened(SUCCESS)
    panel = ready(page, "first (is|are)")
    panel.locator("canvas").first.evaluate(HELD)
    page.wait_for_url("**#success?limit=0.25")
    page.go_back()
    limit = panel.locator("input[type=range][min='0']").first
    page.wait_for_function("input => input.value === '0.2'", arg=limit.element_handle())


def test_loaded_anew_all_figures_of_a_page_are_as_they_were(opened):
    page = opened(HISTOGRAMS)
    moved = []
    for place in (0, 1):
        slider = ready(page, ".", place).locator("input[type=range]").first
        begun, address = slider.input_value(), page.url
        slider.press("ArrowLeft")
        page.wait_for_url(lambda now, before=address: now != before)
        moved.append(slider.input_value())
        assert moved[-1] != begun
        # A link within the page has no state of its own.
        page.locator(".toc-tree ul ul a").nth(place).click()
        page.wait_for_function("() => !location.hash.includes('?') && history.state")
    page.reload()
    for place, value in enumerate(moved):
        slider = ready(page, ".", place).locator("input[type=range]").first
        assert slider.input_value() == value


@pytest.mark.parametrize(
    "name, address, place",
    [(BEATS, "#beats?frame=18", 1), (HISTOGRAMS, "#fig2?bins=rgb", 1)],
)
def test_a_link_leads_a_telephone_to_its_figure(opened, name, address, place):
    page = opened(name, address, TELEPHONE)
    panel = page.locator(".mkt-soon").nth(place)
    panel.locator("canvas").first.wait_for()
    page.wait_for_timeout(1500)
    assert 40 <= panel.bounding_box()["y"] <= 100


def test_back_shows_the_other_figures_of_a_page_as_they_were(opened):
    page = opened(HISTOGRAMS)
    panels = [ready(page, ".", place) for place in (0, 1)]
    sliders = [panel.locator("input[type=range]").first for panel in panels]
    begun = [slider.input_value() for slider in sliders]
    moved = []
    for slider in sliders:
        address = page.url
        slider.press("ArrowLeft")
        page.wait_for_url(lambda now, before=address: now != before)
        moved.append(slider.input_value())
    assert moved[0] != begun[0] and moved[1] != begun[1]
    for expected in ([moved[0], begun[1]], begun):
        page.go_back()
        for slider, value in zip(sliders, expected, strict=True):
            found = "([input, value]) => input.value === value"
            page.wait_for_function(found, arg=[slider.element_handle(), value])


def test_a_figure_that_was_reset_is_so_too_when_its_reader_comes_back(opened):
    page = opened(HISTOGRAMS)
    panels = [ready(page, ".", place) for place in (0, 1)]
    first, other = (panel.locator("input[type=range]").first for panel in panels)
    begun = first.input_value()
    steps = (
        lambda: first.press("ArrowLeft"),
        lambda: other.press("ArrowLeft"),
        lambda: panels[0].locator(".mkt-reset").click(),
        lambda: other.press("ArrowLeft"),
    )
    for step in steps:
        before = page.evaluate("JSON.stringify([location.href, history.state])")
        step()
        page.wait_for_function(
            "before => JSON.stringify([location.href, history.state]) !== before",
            arg=before,
        )
        page.wait_for_timeout(700)  # moves that follow at once are one step back
    page.go_back()
    page.go_forward()
    page.wait_for_timeout(300)
    assert first.input_value() == begun


def test_the_script_has_every_figure_that_is_registered_as_live():
    names = re.findall(r'^"([\w.]+)": \w+,$', live.script(), re.MULTILINE)
    assert sorted(names) == sorted(LIVE)


def test_without_javascript_the_pictures_stay(site, browser):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((site / f"{SURFACES}.html").as_uri())
    assert page.locator(".mkt-panel .mkt-shown img").first.is_visible()
    page.goto((site / f"{TRACK}.html").as_uri())
    assert "chapter 3" in page.locator("[data-live=track]").inner_text()
    context.close()


def test_where_its_data_are_missing_a_figure_says_so_and_the_picture_stays(
    site, browser
):
    page = browser.new_page(viewport=WIDE)
    page.route("**/live/success-*.js", lambda route: route.abort())
    page.route("**/live/own.success.js", lambda route: route.abort())
    page.goto((site / f"{SUCCESS}.html").as_uri())
    panel = page.locator(".mkt-soon").first
    panel.scroll_into_view_if_needed()
    panel.get_by_role("alert").wait_for()
    assert "is missing: build the book anew" in panel.inner_text()
    assert panel.locator(".mkt-shown img").is_visible()
    page.close()


def test_from_a_file_server_it_asks_for_nothing_else(served, browser):
    page = browser.new_page(viewport=WIDE)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"{served}/{SURFACES}.html")
    ready(page)
    page.close()
    assert all(url.startswith((served, "data:", "blob:")) for url in asked)


# Fingers


@dataclass(frozen=True)
class Dragged:
    """A canvas in which a thing is dragged, and two places [shares of its sides]."""

    page: str
    address: str
    panel: int
    canvas: int
    thing: tuple[float, float]
    beside: tuple[float, float]
    sets: bool = True  # whether a tap beside the thing sets something


DRAGGED = {
    "circle": Dragged(HISTOGRAMS, "#fig1", 0, 0, (0.5, 0.5), (0.1, 0.9)),
    "box": Dragged(SURFACES, "#fig3", 0, 0, (0.4, 0.5), (0.1, 0.9), sets=False),
    "knob": Dragged(SURFACES, "#fig3", 0, 0, (0.79, 0.5), (0.9, 0.2), sets=False),
    "cross": Dragged(SURFACES, "#fig3", 0, 1, (0.55, 0.47), (0.8, 0.7)),
    "blurred": Dragged(SURFACES, "#fig4", 1, 0, (0.4, 0.5), (0.1, 0.9), sets=False),
    "crossing": Dragged(SURFACES, "#fig4", 1, 2, (0.55, 0.47), (0.3, 0.7)),
    "start": Dragged(NEWTON, "#newton", 0, 0, (0.48, 0.5), (0.1, 0.9), sets=False),
    "basin": Dragged(NEWTON, "#newton", 0, 1, (0.71, 0.37), (0.3, 0.7)),
    "bricks": Dragged(BEATS, "#beats?frame=18&wall=200", 1, 0, (0.8, 0.6), (0.2, 0.8)),
    "film": Dragged(BEATS, "#beats?frame=18", 1, 2, (0.37, 0.6), (0.8, 0.7)),
    "runs": Dragged(COMBINED, "#fig6", 0, 1, (0.71, 0.6), (0.3, 0.7)),
    "car": Dragged(MOTIONS, "#interaction", 0, 0, (0.6, 0.4), (0.2, 0.5), sets=False),
    "view": Dragged(LOOP, "#approach", 0, 0, (0.46, 0.65), (0.1, 0.9), sets=False),
    "pole": Dragged(LOOP, "#root_locus?gain=2&delay=1", 1, 0, (0.6, 0.37), (0.3, 0.7)),
    "door": Dragged(WAITING, "#fig3?placement=doors", 0, 0, (0.64, 0.49), (0.15, 0.85)),
    "share": Dragged(FINDING, "#chance", 0, 0, (0.3, 0.6), (0.7, 0.6)),
    "waits": Dragged(FINDING, "#chance", 0, 1, (0.3, 0.6), (0.7, 0.6)),
    "limit": Dragged(SUCCESS, "#success", 0, 0, (0.3, 0.5), (0.7, 0.6)),
}
STANDS = """panel => [
  location.href,
  [...panel.querySelectorAll("input, select")].map(({ value }) => value),
  [...panel.querySelectorAll("p[role=status]")].map(
    ({ textContent }) => textContent.split(". ")[0],
  ),
]"""


def touch(page, *places):
    """A finger that goes from place to place [px], as a screen tells of it."""
    screen = page.context.new_cdp_session(page)

    def tell(kind, *points):
        points = [{"x": float(x), "y": float(y)} for x, y in points]
        screen.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    tell("touchStart", places[0])
    for begin, end in pairwise(places):
        for point in np.linspace(begin, end, 9)[1:]:
            tell("touchMove", point)
            page.wait_for_timeout(20)
    page.wait_for_timeout(200)  # it rests, or the page would go on by itself
    tell("touchEnd")
    page.wait_for_timeout(200)


def at_rest(canvas):
    """Where a canvas is, once the page, which glides on behind a finger, rests."""
    before = None
    for _ in range(PATIENCE):
        canvas.page.wait_for_timeout(200)
        box = canvas.bounding_box()
        if box == before:
            break
        before = box
    return box


def touched(canvas, share, *moves):
    """How far [px] a page scrolls when a finger in a canvas goes on by some moves."""
    page = canvas.page
    canvas.evaluate("node => node.scrollIntoView({ block: 'center' })")
    box = at_rest(canvas)
    corner, sides = (box["x"], box["y"]), (box["width"], box["height"])
    first = np.add(corner, np.multiply(share, sides))
    touch(page, first, *(first + move for move in moves))
    return round(box["y"] - canvas.bounding_box()["y"])


@pytest.mark.parametrize("name", DRAGGED)
def test_a_finger_drags_the_thing_and_scrolls_the_page_beside_it(opened, name):
    each = DRAGGED[name]
    page = opened(each.page, each.address, TELEPHONE)
    panel = ready(page, r"\d", each.panel)
    page.keyboard.press("Shift")  # the address leads nobody any more
    page.wait_for_timeout(500)
    canvas = panel.locator("canvas").nth(each.canvas)
    begun = panel.evaluate(STANDS)
    for way in (1, -1):
        assert way * touched(canvas, each.beside, (8, -way * 160)) > 100
        assert panel.evaluate(STANDS) == begun
    assert abs(touched(canvas, each.thing, (0, -70), (50, -70))) < 5
    dragged = panel.evaluate(STANDS)
    assert dragged != begun
    touched(canvas, each.beside)
    assert (panel.evaluate(STANDS) != dragged) == each.sets


def test_a_finger_that_goes_aside_takes_a_limit_along(opened):
    page = opened(SUCCESS, size=TELEPHONE)
    panel = ready(page, "first (is|are)")
    curves = panel.locator("canvas").first
    assert abs(touched(curves, (0.5, 0.5), (100, 0), (100, -100))) < 5
    assert float(re.search(r"limit=([\d.]+)", page.url)[1]) > 0.7


def test_a_finger_lights_a_pixel_that_it_taps_and_all_when_it_taps_again(opened):
    page = opened(HISTOGRAMS, "#fig1", TELEPHONE)
    panel = ready(page)
    page.wait_for_timeout(500)
    for canvas, place in (0, (0.5, 0.5)), (0, (0.1, 0.9)), (1, (0.5, 0.5)):
        for lit in (True, False):
            touched(panel.locator("canvas").nth(canvas), place)
            assert bool(LIT.search(panel.inner_text())) == lit
    touched(panel.locator("canvas").first, (0.5, 0.5), (40, 0))
    page.wait_for_url("**#fig1?x=*")
    assert not LIT.search(panel.inner_text())


def test_a_finger_that_scrolls_points_at_nothing(opened):
    page = opened(HISTOGRAMS, "#fig2", TELEPHONE)
    panel = ready(page, "samples, worth", 1)
    page.wait_for_timeout(500)
    objects = panel.locator("canvas").first
    begun = panel.evaluate(STANDS)
    for way in (1, -1):
        assert way * touched(objects, (0.15, 0.5), (8, -way * 160)) > 100
        assert panel.evaluate(STANDS) == begun
    touched(objects, (0.15, 0.15))
    assert "Kernel 1 of 9" in panel.inner_text()


def test_a_finger_draws_a_box_upwards_from_anywhere(opened):
    page = opened(TRACK, size=TELEPHONE)
    page.get_by_role("button", name="Play the book's clip").click()
    page.get_by_text("A box is drawn already").wait_for()
    stage = page.locator("canvas").first
    moved = touched(stage, (0.7, 0.8), (0, -130), (-100, -130))
    assert abs(moved) < 60  # the words above it are fewer now
    page.get_by_text("frames per second").wait_for()


# What pages may not do


def test_every_page_has_the_policy_and_no_script_inside(site):
    pages = list(site.rglob("*.html"))
    texts = {page: page.read_text(encoding="utf-8") for page in pages}
    assert [p.name for p, text in texts.items() if text.count(security.META) != 1] == []
    running = re.compile(r"<script(?![^>]*(src=|type=\"application/))")
    assert [p.name for p, text in texts.items() if running.search(text)] == []
    handlers = re.compile(r"<[a-z][^<>]*\son[a-z]+=", re.IGNORECASE)
    assert [p.name for p, text in texts.items() if handlers.search(text)] == []


@pytest.mark.parametrize(
    "attempt, directive",
    [
        ("const s = document.createElement('script'); s.text = 'window.in = 1';"
         "document.body.append(s);", "script-src-elem"),
        ("fetch('https://example.org/').catch(() => 0);", "connect-src"),
        ("new Image().src = 'https://example.org/a.png';", "img-src"),
        ("document.body.insertAdjacentHTML('beforeend', '<p onclick=alert(1)>x</p>');"
         "document.body.lastElementChild.click();", "script-src-attr"),
    ],
)  # fmt: skip
def test_the_browser_refuses_what_the_policy_forbids(site, browser, attempt, directive):
    page = browser.new_page()
    page.goto((site / f"{TRACK}.html").as_uri())
    refused = page.evaluate(
        """attempt => new Promise((resolve) => {
          document.addEventListener("securitypolicyviolation",
            (event) => resolve(event.effectiveDirective));
          new Function(attempt)();
        })""".replace("new Function(attempt)()", attempt),
        attempt,
    )
    page.close()
    assert refused == directive


# The camera


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """What the camera sees, as Y4M: a car that goes to and fro, and where it starts."""
    turn = 60  # frames there, and as many back
    way = ((0.0, 145.0, 119.5, 0.0, 1.0), (turn, 175.0, 119.5, 0.2, 1.0))
    clip = Scene(Layer("car", 96.0, way), length=turn, seed=0).sequence()
    shown = list(clip.frames)
    path = tmp_path_factory.mktemp("camera") / "film.y4m"
    height, width = shown[0].shape[:2]
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{width} H{height} F25:1 Ip A1:1 C420jpeg\n".encode())
        for frame in [*shown, *shown[::-1]]:
            yuv = cv2.cvtColor(frame, cv2.COLOR_RGB2YUV_I420)
            file.write(b"FRAME\n" + yuv.tobytes())
    return path, clip.truth[0]


# Keeps what goes to the worker, pictures as text, and what comes back.
LISTEN = """
window.asked = []; window.told = [];
const post = Worker.prototype.postMessage;
const text = (data) => { let s = ""; for (let i = 0; i < data.length; i += 8192)
  s += String.fromCharCode(...data.subarray(i, i + 8192)); return btoa(s); };
Worker.prototype.postMessage = function (message, ...rest) {
  if (!window.heard) { window.heard = true;
    this.addEventListener("message", ({ data }) =>
      window.told.push({ kind: data.kind, region: data.region, cost: data.cost })); }
  const { picture, kind, region } = message;
  const { width, height } = picture;
  window.asked.push({ kind, region, width, height, data: text(picture.data) });
  return post.call(this, message, ...rest);
};
"""


def test_the_camera_is_followed_as_python_follows_it(site, film, driver, pictures):
    path, start = film
    camera = [
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-video-capture={path}",
    ]
    with launched(driver, *camera) as browser:
        opened = Opened(browser)
        page = opened.page
        page.add_init_script(LISTEN)
        page.goto((site / f"{TRACK}.html").as_uri())
        page.get_by_role("button", name="Use the camera").click()
        # The text above the figure says "draw a box", too, before there is a picture.
        page.get_by_text("Draw a box round something, then track it.").wait_for()
        stage = page.locator("canvas").first
        stage.scroll_into_view_if_needed()
        box = stage.bounding_box()
        scale = box["width"] / 320
        cx, cy, _, hx, hy = start
        places = [(cx - hx, cy - hy), (cx + hx, cy + hy)]
        (x0, y0), (x1, y1) = [
            (box["x"] + (x + 0.5) * scale, box["y"] + (y + 0.5) * scale)
            for x, y in places
        ]
        page.mouse.move(x0, y0)
        page.mouse.down()
        page.mouse.move(x1, y1, steps=5)
        page.mouse.up()
        # The policy forbids to wait for a function: its text would be evaluated.
        for _ in range(PATIENCE):
            page.wait_for_timeout(200)
            if page.evaluate("window.told.length") >= 60:
                break
        page.screenshot(path=pictures / "live-camera.png")
        asked, told = page.evaluate("[window.asked, window.told]")
        assert opened.troubles == [] and len(told) >= 60
    tracked = np.array([each["region"] for each in told])
    frames = [_picture(each) for each in asked[: len(told)]]
    begun = np.array(asked[0]["region"])
    nothing = np.full(len(frames), 1.0)
    clip = Sequence("camera", frames, np.tile(begun, (len(frames), 1)), nothing)
    runs = [track(Combined(), clip, seed=seed).regions for seed in range(3)]
    agree = [np.median(overlap(run, tracked)) for run in runs]
    assert overlap(runs[0], runs[1]).min() > 0.5  # it is no matter of luck
    assert min(agree) > 0.85
    assert np.ptp(tracked[:, 0]) > 8  # and the car did move


def _picture(message):
    """The frame (H, W, 3) of a message to the worker."""
    flat = np.frombuffer(base64.b64decode(message["data"]), np.uint8)
    return np.ascontiguousarray(
        flat.reshape(message["height"], message["width"], 4)[..., :3]
    )


@pytest.mark.parametrize(
    "error, reason",
    [
        ("NotAllowedError", "The camera was refused"),
        ("NotFoundError", "No camera was found"),
        ("NotReadableError", "The camera is busy with another program"),
    ],
)
def test_without_a_camera_the_clip_plays(opened, site, error, reason):
    page = opened("index")
    page.add_init_script(
        "navigator.mediaDevices.getUserMedia = async () => "
        f"{{ throw new DOMException('', '{error}'); }};"
    )
    page.get_by_role("link", name="Track something now").first.click()
    page.get_by_role("button", name="Use the camera").click()
    page.get_by_text(f"{reason}; here is the book's clip").wait_for()
    page.get_by_role("button", name="Track what is in the box").click()
    page.get_by_text("frames per second").wait_for()
    assert "found" in page.locator("[data-live=track]").inner_text()


# A video of which each picture comes late.
LATE = """
const ask = HTMLVideoElement.prototype.requestVideoFrameCallback;
HTMLVideoElement.prototype.requestVideoFrameCallback = function (then) {
  setTimeout(() => ask.call(this, then), 400);
};
"""


def test_who_tracks_at_once_learns_from_a_picture(opened):
    page = opened("index")
    page.add_init_script(LATE)
    page.get_by_role("link", name="Track something now").first.click()
    page.get_by_role("button", name="Play the book's clip").click()
    page.get_by_text("A box is drawn already").wait_for()
    page.get_by_role("button", name="Track what is in the box").click()
    page.get_by_text("frames per second").wait_for()
    distance = number(page.locator("[data-live=track]"), "distance")
    assert distance < 0.6  # of one that has learnt nothing it is .8 and more


# Whether there is a line in the colour of what was found.
LINE = """canvas => {
  const size = [canvas.width, canvas.height];
  const found = canvas.getContext("2d").getImageData(0, 0, ...size).data;
  for (let i = 0; i < found.length; i += 4)
    if (found[i] === %d && found[i + 1] === %d && found[i + 2] === %d && found[i + 3])
      return true;
  return false;
}"""


def test_both_curves_of_the_clip_are_drawn(opened):
    page = opened(TRACK)
    page.get_by_role("button", name="Play the book's clip").click()
    page.get_by_text("A box is drawn already").wait_for()
    page.get_by_role("button", name="Track what is in the box").click()
    page.get_by_text("frames per second").wait_for()
    page.wait_for_timeout(500)
    for name, color in (("N_eff", (30, 125, 193)), ("likeness", (0, 167, 81))):
        assert page.locator(f"canvas[aria-label^='{name}']").evaluate(LINE % color)


# A file that is none, and before that is known, the book's clip.
TWO_SOURCES = """() => {
  const kept = new DataTransfer();
  kept.items.add(new File(["no film"], "none.webm", { type: "video/webm" }));
  const picker = document.querySelector("[data-live=track] input[type=file]");
  picker.files = kept.files;
  picker.dispatchEvent(new Event("change"));
  for (const button of document.querySelectorAll("[data-live=track] button"))
    if (button.textContent === "Play the book's clip") button.click();
}"""


def test_of_two_sources_the_last_one_counts(opened):
    page = opened(TRACK)
    page.get_by_role("button", name="Play the book's clip").wait_for()
    page.evaluate(TWO_SOURCES)
    page.get_by_text(re.compile("The clip: ")).wait_for()
    page.wait_for_timeout(500)
    assert "cannot play" not in page.locator("[data-live=track]").inner_text()


def test_a_box_is_drawn_with_keys_alone(opened):
    page = opened(TRACK)
    page.get_by_role("button", name="Play the book's clip").press("Enter")
    page.get_by_text("A box is drawn already").wait_for()
    stage = page.locator("canvas").first
    for key, side, sign in [
        ("ArrowLeft", "left", -1),
        ("ArrowUp", "top", -1),
        ("Shift+ArrowRight", "right", 1),
    ]:
        before = box_on(stage)
        for _ in range(9):
            stage.press(key)
        page.wait_for_timeout(200)
        assert sign * (box_on(stage)[side] - before[side]) > 5
    stage.press("Enter")
    page.get_by_text("frames per second").wait_for()


def test_the_picture_is_not_higher_than_a_telephone_held_sideways(opened):
    page = opened(TRACK, size={"width": 844, "height": 390})
    page.get_by_role("button", name="Play the book's clip").click()
    page.get_by_text("A box is drawn already").wait_for()
    stage = page.locator("canvas").first.bounding_box()
    assert stage["height"] <= 0.8 * 390 + 1
    assert stage["width"] / stage["height"] == pytest.approx(176 / 144, abs=0.02)


def box_on(canvas):
    """The sides [px] of the orange box on a canvas, below which the clip plays."""
    return canvas.evaluate(
        """(canvas, [r, g, b]) => {
      const { width, height } = canvas;
      const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
      const box = { left: width, top: height, right: 0 };
      for (let p = 0; p < data.length; p += 4) {
        if (data[p] !== r || data[p + 1] !== g || data[p + 2] !== b) continue;
        const column = (p / 4) % width;
        box.left = Math.min(box.left, column);
        box.right = Math.max(box.right, column);
        box.top = Math.min(box.top, Math.floor(p / 4 / width));
      }
      return box;
    }""",
        BOX,
    )


CHAPTERS = [HISTOGRAMS, SURFACES, NEWTON, BEATS, LOOP, SUCCESS]


@pytest.mark.parametrize("name", CHAPTERS)
def test_live_figures_fit_and_everybody_can_use_them(opened, pictures, name):
    page = opened(name)
    panels = page.locator(".mkt-soon")
    assert panels.count()
    for size, scheme in BY_TURNS:
        page.set_viewport_size(size)
        page.emulate_media(color_scheme=scheme)
        for k in range(panels.count()):
            panel = ready(page, r"\d", k)
            page.wait_for_timeout(300)
            assert not page.evaluate(
                "document.documentElement.scrollWidth > innerWidth"
            )
            words = f"live-{name}-{k}-{size['width']}-{scheme}.png"
            panel.screenshot(path=pictures / words)
    found = AXE.run(
        page,
        context=".mkt-live",
        options={"resultTypes": ["violations"], "preload": False},
    ).response["violations"]
    assert [rule["id"] for rule in found] == []


def test_on_paper_a_canvas_of_the_night_has_the_ink_of_the_day(opened):
    page = opened(SURFACES)
    page.emulate_media(color_scheme="dark")
    curves = ready(page).locator("canvas").last
    page.wait_for_timeout(300)
    assert not curves.evaluate(LINE % (0, 0, 0))
    page.emulate_media(media="print", color_scheme="dark")
    page.wait_for_timeout(300)
    assert curves.evaluate(LINE % (0, 0, 0))


ENDS = """panel => Math.max(
  ...[...panel.querySelectorAll("input, select, button")].map(
    (each) => each.getBoundingClientRect().right,
  ),
)"""


@pytest.mark.parametrize("letters", [16, 32], ids=["plain", "large"])  # [px]
def test_controls_end_inside_their_panel_on_a_small_telephone(opened, letters):
    page = opened(SURFACES, size={"width": 320, "height": 800})
    page.add_style_tag(content=f"html {{ font-size: {letters}px }}")
    panel = ready(page)
    page.wait_for_timeout(300)
    place = panel.bounding_box()
    assert panel.evaluate(ENDS) < place["x"] + place["width"]


def test_the_script_is_light():
    text = live.script().encode()
    assert len(text) < 206_000 and len(gzip.compress(text)) < 59_500
    method = "".join(map(maker, filter(lambda name: "/" in name, needed("start"))))
    assert len(gzip.compress(method.encode())) < 12_500
