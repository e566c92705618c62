"""What computes in the pages: live figures, the camera, and what pages may not do."""

import base64
import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.course.book import live, security
from mkt.evaluation import overlap
from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.papers.teuliere2009.histograms import still
from mkt.regions import displaced
from mkt.scenes.rendering import Layer, Scene
from mkt.trackers.combined import Combined
from mkt.trackers.ssd import newton_path
from mkt.tracking import Sequence, track
from tests.browser.conftest import launched
from tests.browser.test_pages import NARROW, SCHEMES, WIDE, Opened

pytestmark = pytest.mark.slow

SURFACES, NEWTON, TRACK = "02_cost_surfaces", "04_multiple_kernel_ssd", "track"
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

    def go(name, address="", size=WIDE):
        pages.append(Opened(browser, size))
        pages[-1].page.goto((site / f"{name}.html").as_uri() + address)
        return pages[-1].page

    yield go
    for each in pages:
        troubles = each.troubles
        each.page.close()
        assert troubles == []


def ready(page):
    """The live panel of a figure, once it says where it stands."""
    panel = page.locator(".mkt-soon").first
    panel.scroll_into_view_if_needed()
    panel.locator("canvas").first.wait_for()
    panel.get_by_text(re.compile(r"distance \d")).first.wait_for()
    return panel


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


def test_what_is_saved_is_what_is_shown(opened, tmp_path):
    page = opened(SURFACES, "#fig3?item=cat")
    panel = ready(page)
    with page.expect_download() as download:
        panel.locator(".mkt-save").click()
    download.value.save_as(tmp_path / "saved.png")
    saved = cv2.imread(str(tmp_path / "saved.png"))
    shown = panel.locator(".mkt-stage").bounding_box()
    assert abs(saved.shape[1] - shown["width"]) < 2
    assert len(np.unique(saved.reshape(-1, 3), axis=0)) > 1000


@pytest.mark.parametrize(
    "words, complaint",
    [
        ("layout=<img src=x onerror=alert(1)>", "must be one of one, 2x2"),
        ("span=9", "must be a number from 0.4 to 1.4"),
        ("span=", "must be a number"),
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
    page = opened(NEWTON, "#newton?dx=-20&turn=15&scale=1.2&derivative_of_c=False")
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
        panel.get_by_role("button", name="step", exact=True).click()


def test_without_javascript_the_pictures_stay(site, browser):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((site / f"{SURFACES}.html").as_uri())
    assert page.locator(".mkt-panel .mkt-shown img").first.is_visible()
    page.goto((site / f"{TRACK}.html").as_uri())
    assert "mkt webcam" in page.locator("[data-live=track]").inner_text()
    context.close()


def test_from_a_file_server_it_asks_for_nothing_else(served, browser):
    page = browser.new_page(viewport=WIDE)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"{served}/{SURFACES}.html")
    ready(page)
    page.close()
    assert all(url.startswith((served, "data:", "blob:")) for url in asked)


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
        page.get_by_text("Draw a box").first.wait_for()
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
        page.mouse.move(x1, y1)
        page.mouse.up()
        # The policy forbids to wait for a function: its text would be evaluated.
        while page.evaluate("window.told.length") < 60:
            page.wait_for_timeout(200)
        page.screenshot(path=pictures / "live-camera.png")
        asked, told = page.evaluate("[window.asked, window.told]")
        assert opened.troubles == []
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
        ("NotReadableError", "The camera is busy"),
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
    page.get_by_text(reason).wait_for()
    page.get_by_role("button", name="Track what is in the box").click()
    page.get_by_text("frames a second").wait_for()
    assert "found" in page.locator("[data-live=track]").inner_text()


def test_a_box_is_drawn_with_keys_alone(opened):
    page = opened(TRACK)
    page.get_by_role("button", name="Play the book's clip").press("Enter")
    page.get_by_text("A box is drawn already").wait_for()
    stage = page.locator("canvas").first
    for key in ("ArrowLeft", "ArrowUp", "Shift+ArrowRight", "Enter"):
        stage.press(key)
    page.get_by_text("frames a second").wait_for()


@pytest.mark.parametrize("name", [SURFACES, NEWTON])
def test_live_figures_fit_by_day_and_by_night(opened, pictures, name):
    page = opened(name)
    panel = ready(page)
    for size in (NARROW, WIDE):
        page.set_viewport_size(size)
        assert not page.evaluate("document.documentElement.scrollWidth > innerWidth")
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(300)
            panel.screenshot(
                path=pictures / f"live-{name}-{size['width']}-{scheme}.png"
            )


def test_the_script_is_light():
    assert len(live.bundle().encode()) < 120_000
