"""The book as it lies on the disk, in a real browser.

Its pages load, fit, move, play, and can be read by everybody.
"""

import base64
import io
import random
import re
from functools import partial

import pytest
from axe_playwright_python.sync_playwright import Axe
from PIL import Image
from playwright.sync_api import expect

from mkt.course.book import contents, pages
from mkt.course.book.pictures import FILM
from mkt.figures import export
from mkt.figures.film import BAR
from tests.browser.jupyterlab import PLAYED
from tests.lot import DAY

pytestmark = pytest.mark.slow

CHAPTERS = [chapter.name for chapter in contents.read().chapters]
REFERENCE = [
    "index",
    "gallery",
    "claims",
    "leaderboard",
    "symbols",
    "tasks",
    "track",
    "after",
    "handout/lab_3_particle_filter",
    "genindex",
    "search",
    "api/index",
    "api/mkt.histograms",
    "_modules/mkt/histograms",
]
PAGES = [*REFERENCE, *CHAPTERS]
ALIKE = [".genindex-section[id] ~ .genindex-section"]  # all letters but the first
# Code has the same colours on every page of a kind, and hundreds of words a page.
WITH_CODE = (
    "api/mkt.histograms",
    "_modules/mkt/histograms",
    "handout/lab_3_particle_filter",
    CHAPTERS[DAY % len(CHAPTERS)],
)
MOVED = "09_moving_target"  # a page with many choices
NARROW = {"width": 380, "height": 800}
WIDE = {"width": 1400, "height": 1000}
SCHEMES = "light", "dark"
# Narrow by day and wide by night, and tomorrow the other way round.
BY_TURNS = list(zip((NARROW, WIDE), (SCHEMES * 2)[DAY % 2 :], strict=False))
LETTERS = 0.9  # of a drawing's own size: those of 9 pt are then 9 px
LOCAL = "file:", "data:", "blob:"
FITS = "({ parentNode }) => parentNode.scrollWidth <= innerWidth"
# How often a moving picture begins again.
BEGINS_AGAIN = """async (content) => {
  const data = Uint8Array.from(atob(content), (one) => one.charCodeAt(0));
  const decoder = new ImageDecoder({ data, type: "image/avif" });
  await decoder.tracks.ready;
  const { animated, repetitionCount } = decoder.tracks.selectedTrack;
  return [animated, repetitionCount];
}"""
# Where a film ends at the right [px], and what of it is below its pictures.
ROUND_A_FILM = """async (film) => {
  await film.play();
  const { right, width, height } = film.getBoundingClientRect();
  return [right, height - width * film.videoHeight / film.videoWidth];
}"""
AXE = Axe()


class Opened:
    """A page in the browser, and all that went wrong since it was opened."""

    def __init__(self, browser, size=WIDE, ratio=1):
        self.page = browser.new_page(
            viewport=size, has_touch=True, device_scale_factor=ratio
        )
        self.troubles = []
        self.page.on("console", self._hear)
        self.page.on("request", self._see)
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("requestfailed", self._miss)

    def _hear(self, message):
        if message.type == "error":
            self.troubles.append(message.text)

    def _see(self, request):
        if not request.url.startswith(LOCAL):
            self.troubles.append(f"asked for {request.url}")

    def _miss(self, request):
        # Of a film that is not played yet, the browser stops reading by itself.
        if request.failure != "net::ERR_ABORTED":
            self.troubles.append(f"not found: {request.url[:200]}")

    def go(self, path):
        """Load a page of the site."""
        self.page.goto(path.as_uri())
        return self

    def too_wide(self):
        """Whether the page is to be scrolled sideways."""
        return self.page.evaluate("document.documentElement.scrollWidth > innerWidth")


@pytest.fixture(scope="module", params=PAGES)
def opened(request, site, browser):
    opened = Opened(browser).go(site / f"{request.param}.html")
    yield opened
    opened.page.close()


@pytest.fixture(scope="module", params=CHAPTERS)
def chapter(request, site, browser):
    opened = Opened(browser).go(site / f"{request.param}.html")
    yield opened
    opened.page.close()


def test_everybody_can_read_the_page(opened, request):
    """By day or by night, tomorrow the other way round: only the colours are others."""
    name = request.node.callspec.params["opened"]
    opened.page.emulate_media(color_scheme=SCHEMES[(PAGES.index(name) + DAY) % 2])
    found = AXE.run(
        opened.page,
        context={"exclude": [ALIKE, *[[".highlight"]] * (name not in WITH_CODE)]},
        options={"resultTypes": ["violations"], "preload": False},
    ).response["violations"]
    assert [
        (rule["id"], node["html"][:200])
        for rule in found
        for node in rule["nodes"]
        if rule["impact"] in ("serious", "critical")
    ] == []


def test_the_page_fits_a_telephone_and_a_wide_screen_by_day_and_by_night(
    opened, pictures, request
):
    name = request.node.callspec.params["opened"].replace("/", "-")
    for size, scheme in BY_TURNS:
        opened.page.set_viewport_size(size)
        opened.page.emulate_media(color_scheme=scheme)
        assert not opened.too_wide()
        opened.page.screenshot(
            path=pictures / f"page-{name}-{size['width']}-{scheme}.png"
        )


@pytest.mark.parametrize("size", [NARROW, WIDE], ids=["narrow", "wide"])
def test_a_picture_is_there_before_one_scrolls(chapter, size):
    chapter.page.set_viewport_size(size)
    first = chapter.page.locator("article :is(img, canvas, video)").first
    box = first.bounding_box()
    top = chapter.page.evaluate("scrollY")
    assert box["height"] > 60 and top + box["y"] + box["height"] <= 800


def test_letters_of_a_drawing_are_no_smaller_on_a_telephone(chapter):
    chapter.page.set_viewport_size(NARROW)
    drawing = chapter.page.locator(".mkt-scroll > img").first
    assert drawing.bounding_box()["width"] >= LETTERS * 720


SHOWN = """() => [...document.querySelectorAll(
  ".mkt-shown img, .cell_output > a > img"
)].map((image) => [image.clientWidth, Number(image.getAttribute("width"))])"""


def test_letters_of_a_figure_are_no_smaller_on_a_telephone(chapter):
    chapter.page.set_viewport_size(NARROW)
    assert all(width == drawn for width, drawn in chapter.page.evaluate(SHOWN))
    assert not chapter.too_wide()


MEASURED = """() => [...document.querySelectorAll(".cell_output table tr")]
  .map((row) => [row.clientWidth, row.querySelector("td:nth-last-child(4)[id^=T_]")])
  .filter(([, cell]) => cell).map(([width, cell]) => cell.clientWidth / width)"""


def test_what_a_verdict_is_on_has_the_whole_width_of_a_telephone(chapter):
    chapter.page.set_viewport_size(NARROW)
    assert min(chapter.page.evaluate(MEASURED), default=1) > 0.9
    chapter.page.set_viewport_size(WIDE)
    assert max(chapter.page.evaluate(MEASURED), default=0) < 0.9


def test_the_contents_beside_a_page_show_its_own_line(site, browser):
    size = {"width": WIDE["width"], "height": 600}
    opened = Opened(browser, size).go(site / f"{CHAPTERS[-1]}.html")
    line = opened.page.locator(".sidebar-tree .current-page")
    expect(line).to_be_in_viewport(ratio=1)
    opened.page.close()


def test_the_search_finds_a_greek_letter(site, browser):
    opened = Opened(browser)
    opened.page.goto(f"{(site / 'search.html').as_uri()}?q=λ")
    found = opened.page.locator("#search-results")
    expect(found.get_by_role("link", name="Symbols", exact=True)).to_be_visible()
    opened.page.close()


def test_a_button_copies_the_code_of_a_cell(chapter):
    chapter.page.set_viewport_size(WIDE)
    chapter.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    block = chapter.page.locator(".cell_input .highlight:visible").first
    block.hover()
    button = block.get_by_role("button")
    button.click()
    expect(button).to_have_accessible_name("copied")  # not only to be seen
    copied = chapter.page.evaluate("navigator.clipboard.readText()")
    assert copied == block.locator("pre").inner_text() and copied.strip()
    expect(button).to_have_accessible_name("copy")


def test_on_paper_nothing_lies_over_the_text(site, browser):
    opened = Opened(browser).go(site / f"{CHAPTERS[0]}.html")
    skip = opened.page.locator(".skip-to-content")
    expect(skip).to_be_visible()
    opened.page.emulate_media(media="print")
    expect(skip).to_be_hidden()
    opened.page.close()


PAPER = {"width": 718, "height": 1000}  # [px] of A4 between its margins
# What ends right of the paper [px], and what nobody can press there.
CUT = """() => [...document.querySelectorAll("article :is(img, table, pre)")]
  .filter((each) => each.checkVisibility())
  .map((each) => each.getBoundingClientRect().left + each.scrollWidth)
  .filter((right) => right > innerWidth)"""
PRESSED = ".mkt-more, .mkt-swipe, .mkt-copy, .mkt-panel button"


@pytest.mark.parametrize("name", ["leaderboard", "claims", *CHAPTERS])
def test_on_paper_nothing_is_cut(site, browser, name):
    opened = Opened(browser, PAPER).go(site / f"{name}.html")
    opened.page.emulate_media(media="print")
    assert opened.page.evaluate(CUT) == []
    assert opened.page.locator(PRESSED).filter(visible=True).count() == 0
    opened.page.close()


def test_the_page_lacks_nothing_and_asks_nothing_of_a_network(opened):
    assert opened.troubles == []


def test_every_slider_moves_the_picture_by_key_mouse_or_finger(chapter):
    """In three days each in all three ways."""
    still = []
    for k, (panel, slider) in enumerate(controls(chapter, "input[type=range]")):
        last = slider.evaluate("slider => slider.value === slider.max")
        end = _end(slider, last)
        ways = (
            partial(slider.press, "ArrowLeft" if last else "ArrowRight"),
            partial(slider.click, position=end),
            partial(slider.tap, position=end),
        )
        if not there_and_back(panel, ways[(DAY + k) % len(ways)]):
            still.append(slider.get_attribute("id"))
    assert still == []


def test_every_choice_changes_the_picture_and_reset_brings_it_back(chapter):
    still = []
    for panel, choice in controls(chapter, "select"):
        other = choice.evaluate("choice => (choice.selectedIndex + 1) % choice.length")
        if not there_and_back(panel, partial(choice.select_option, index=other)):
            still.append(choice.get_attribute("id"))
    assert still == []


def test_back_on_a_page_its_pictures_are_those_of_their_controls(site, browser):
    opened = Opened(browser)
    opened.go(site / f"{MOVED}.html")
    for _, choice in controls(opened, "select"):
        choice.select_option(index=choice.evaluate("choice => choice.length - 1"))
    opened.go(site / "claims.html")
    opened.page.go_back()
    opened.page.wait_for_timeout(300)
    shown = [
        (choice.evaluate("choice => choice.selectedOptions[0].text"), panel)
        for panel, choice in controls(opened, "select")
    ]
    assert shown
    for words, panel in shown:
        assert f"= {words}" in panel.locator("img").first.get_attribute("alt")
    opened.page.close()


def controls(opened, kind):
    """Every control of a kind with the drawn figure that it belongs to."""
    return [
        (panel, control)
        for panel in opened.page.locator(".mkt-panel:not(.mkt-soon)").all()
        for control in panel.locator(kind).all()
    ]


def there_and_back(panel, move):
    """Whether a move changes the picture, and the reset button brings it back."""
    image = panel.locator("img").first
    before = image.get_attribute("src")
    move()
    moved = image.get_attribute("src")
    panel.locator(".mkt-reset").click()
    return before == image.get_attribute("src") != moved


def _end(slider, left):
    """A place on a slider, at the end where it does not stand."""
    size = slider.bounding_box()
    return {"x": 3 if left else size["width"] - 3, "y": size["height"] / 2}


def test_every_film_plays(site, browser):
    with_films = [
        path
        for path in site.glob("*.html")
        if "<video" in path.read_text(encoding="utf-8")
    ]
    assert with_films
    for path in with_films:
        page = Opened(browser).go(path).page
        films = [film.evaluate(PLAYED) for film in page.locator("video").all()]
        page.close()
        assert all(after > before for before, after in films)


def test_the_first_page_moves_for_less_than_five_seconds_by_itself(site, browser):
    """What begins by itself and goes on needs a way to stop it (WCAG 2.2.2)."""
    content = (site / pages.FILES / FILM).read_bytes()
    page = Opened(browser).go(site / "index.html").page
    assert page.evaluate(BEGINS_AGAIN, base64.b64encode(content).decode()) == [True, 0]
    page.close()
    with Image.open(io.BytesIO(content)) as film:
        assert film.n_frames * export.MOVING_MS < 5000


def test_a_film_is_whole_on_a_phone_and_its_bar_lies_below_the_pictures(site, browser):
    page = Opened(browser, NARROW).go(site / "09_moving_target.html").page
    right, below = page.locator("video").evaluate(ROUND_A_FILM)
    page.close()
    assert right <= NARROW["width"] and below >= BAR


@pytest.mark.parametrize("name", ["13_hybrid_resampling", "symbols"])
def test_a_table_with_code_is_no_wider_than_a_phone(site, browser, name):
    page = Opened(browser, NARROW).go(site / f"{name}.html").page
    tables = page.locator("table.docutils:has(code)").all()
    assert tables and all(table.evaluate(FITS) for table in tables)
    page.close()


def test_no_page_of_the_library_fails_or_is_too_wide(site, browser):
    """One page goes to all of them: a new one for each takes four times as long.

    They are of two kinds, and a quarter of them is drawn by lot, others each day.
    """
    found = {*site.glob("api/*.html"), *site.glob("_modules/**/*.html")}
    there = sorted(found - {site / old for old in pages.moved()})
    paths = random.Random(DAY).sample(there, len(there) // 4)
    opened = Opened(browser, NARROW)
    troubles = {}
    for path in paths:
        opened.troubles.clear()
        opened.go(path)
        if opened.too_wide() or opened.troubles:
            troubles[path.name] = list(opened.troubles) or "too wide"
    opened.page.close()
    assert paths and troubles == {}


def test_a_search_finds_chapters_before_the_pages_of_the_library(site, browser):
    opened = Opened(browser)
    for words in ("resampling", "histogram"):
        opened.page.goto((site / "search.html").as_uri() + f"?q={words}")
        found = opened.page.locator("ul.search li a")
        found.nth(5).wait_for()
        pages = [found.nth(k).get_attribute("href") for k in range(5)]
        assert pages[0][:2].isdigit(), pages
        assert not any(page.startswith(("api/", "_modules/")) for page in pages)
    opened.page.close()


@pytest.mark.parametrize(
    "words, page",
    [
        ("mkt.track", "api/mkt.tracking.html"),
        ("mkt.Kernels", "api/mkt.kernels.html"),
        ("mkt.learn", "api/mkt.histograms.html"),
        ("SSD.step", "api/mkt.trackers.ssd.html"),
        ("T09-b", "claims.html"),
        ("lab 3", "handout/lab_3"),
        ("chapter 5", "05_"),
    ],
)
def test_who_searches_by_the_full_name_finds_that_first(site, browser, words, page):
    opened = Opened(browser)
    opened.page.goto((site / "search.html").as_uri() + f"?q={words}")
    found = opened.page.locator("ul.search li a").first
    expect(found).to_have_attribute("href", re.compile(rf"^{page}"))
    opened.page.close()


def test_on_a_narrow_screen_keys_open_and_close_the_lists(site, browser):
    opened = Opened(browser, NARROW).go(site / f"{CHAPTERS[0]}.html")
    for drawn, label in (
        (".sidebar-drawer", ".nav-overlay-icon"),
        (".toc-drawer", ".toc-header-icon"),
    ):
        drawer = opened.page.locator(drawn)
        expect(drawer).to_be_hidden()  # or the tab key went through its links
        opened.page.locator(label).focus()
        for key, seen in (("Enter", True), ("Escape", False), (" ", True)):
            opened.page.keyboard.press(key)
            expect(drawer).to_be_visible(visible=seen)
        expect(drawer.get_by_role("link").first).to_be_in_viewport()
        opened.page.keyboard.press("Escape")
    assert opened.troubles == []
    opened.page.close()


def test_an_old_address_of_a_module_leads_to_the_new_one(site, browser):
    for path in ("api/mkt.widgets.html", "_modules/mkt/book/judged.html"):
        opened = Opened(browser).go(site / path)
        opened.page.get_by_role("heading", name="mkt.").first.wait_for()
        opened.page.wait_for_url("**/api/mkt.*.*.html")
        assert opened.troubles == []
        opened.page.close()
