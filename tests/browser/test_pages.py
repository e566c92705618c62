"""The book as it lies on the disk, in a real browser: its pages load, fit, move, play, and can be read by everybody."""

import pytest
from axe_playwright_python.sync_playwright import Axe

from mkt.book import catalogue
from tests.browser.jupyterlab import PLAYED

CHAPTERS = [chapter.name for chapter in catalogue.read().chapters]
REFERENCE = ["index", "gallery", "claims", "leaderboard", "symbols", "genindex", "search", "api/index", "api/mkt.histograms", "_modules/mkt/histograms"]
NARROW, WIDE = {"width": 380, "height": 800}, {"width": 1400, "height": 1000}
SCHEMES = "light", "dark"
LOCAL = "file:", "data:", "blob:"
AXE = Axe()


class Opened:
    """A page of the site in the browser, and all that went wrong since."""

    def __init__(self, browser, path):
        self.page, self.troubles = browser.new_page(viewport=WIDE, has_touch=True), []
        self.page.on("console", lambda message: message.type == "error" and self.troubles.append(message.text))
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("requestfailed", lambda request: self.troubles.append(f"not found: {request.url[:200]}"))
        self.page.on("request", lambda request: request.url.startswith(LOCAL) or self.troubles.append(f"asked for {request.url}"))
        self.page.goto(path.as_uri())

    def too_wide(self, size):
        """Whether the page is to be scrolled sideways."""
        self.page.set_viewport_size(size)
        return self.page.evaluate("document.documentElement.scrollWidth > innerWidth")


@pytest.fixture(scope="module", params=[*REFERENCE, *CHAPTERS])
def opened(request, site, browser):
    opened = Opened(browser, site / f"{request.param}.html")
    yield opened
    opened.page.close()


@pytest.fixture(scope="module", params=CHAPTERS)
def chapter(request, site, browser):
    opened = Opened(browser, site / f"{request.param}.html")
    yield opened
    opened.page.close()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_everybody_can_read_the_page(opened, scheme):
    opened.page.emulate_media(color_scheme=scheme)
    found = AXE.run(opened.page, options={"resultTypes": ["violations"], "preload": False}).response["violations"]
    assert [(rule["id"], node["html"][:200]) for rule in found for node in rule["nodes"] if rule["impact"] in ("serious", "critical")] == []


def test_the_page_fits_a_telephone_and_a_wide_screen_by_day_and_by_night(opened, pictures, request):
    name = request.node.callspec.params["opened"].replace("/", "-")
    for size in (NARROW, WIDE):
        assert not opened.too_wide(size)
        for scheme in SCHEMES:
            opened.page.emulate_media(color_scheme=scheme)
            opened.page.screenshot(path=pictures / f"page-{name}-{size['width']}-{scheme}.png")


def test_the_page_lacks_nothing_and_asks_nothing_of_a_network(opened):
    assert opened.troubles == []


def test_every_slider_moves_the_picture_by_key_mouse_and_finger(chapter):
    still = []
    for panel, slider in controls(chapter, "input[type=range]"):
        last = slider.evaluate("slider => slider.value === slider.max")
        ways = (lambda: slider.press("ArrowLeft" if last else "ArrowRight"), lambda: slider.click(position=_end(slider, last)),
                lambda: slider.tap(position=_end(slider, last)))
        still += [slider.get_attribute("id")] * (not all(there_and_back(panel, way) for way in ways))
    assert still == []


def test_every_choice_changes_the_picture_and_reset_brings_it_back(chapter):
    still = []
    for panel, choice in controls(chapter, "select"):
        other = choice.evaluate("choice => (choice.selectedIndex + 1) % choice.length")
        still += [choice.get_attribute("id")] * (not there_and_back(panel, lambda: choice.select_option(index=other)))
    assert still == []


def controls(opened, kind):
    """Every control of a kind with the figure that it belongs to."""
    return [(panel, control) for panel in opened.page.locator(".mkt-panel").all() for control in panel.locator(kind).all()]


def there_and_back(panel, move):
    """Whether a move changes the picture, and the reset button brings it back."""
    image, seen = panel.locator("img").first, []
    for act in (lambda: None, move, panel.locator(".mkt-reset").click):
        act()
        seen.append(image.get_attribute("src"))
    return seen[0] == seen[2] != seen[1]


def _end(slider, left):
    """A place on a slider, at the end where it does not stand."""
    size = slider.bounding_box()
    return {"x": 3 if left else size["width"] - 3, "y": size["height"] / 2}


def test_every_film_plays(site, browser):
    with_films = [path for path in site.glob("*.html") if "<video" in path.read_text(encoding="utf-8")]
    assert with_films
    for path in with_films:
        page = Opened(browser, path).page
        films = [film.evaluate(PLAYED) for film in page.locator("video").all()]
        page.close()
        assert all(after > before for before, after in films)


def test_no_page_of_the_library_fails_or_is_too_wide(site, browser):
    troubles = {}
    for path in [*site.glob("api/*.html"), *site.glob("_modules/**/*.html")]:
        opened = Opened(browser, path)
        if opened.troubles or opened.too_wide(NARROW):
            troubles[path.name] = opened.troubles or "too wide"
        opened.page.close()
    assert troubles == {}
