"""The book: the catalogue, the notebooks as stored and as run, and the site, which is built once."""

import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from urllib.parse import unquote

import nbformat
import pytest

from mkt import figures
from mkt.book import catalogue, checks, execute, judged, math_svg, pages
from mkt.book.docstrings import escaped, listed
from mkt.page import FILES
from tests import made_up

BOOK = catalogue.read()
chapters = pytest.mark.parametrize("chapter", BOOK.chapters, ids=lambda chapter: chapter.name)


def cells(*sources):
    return nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source, id=f"c{i}") for i, source in enumerate(sources)])


def chapter(tmp_path, notebook, timeout=60):
    nbformat.write(notebook, tmp_path / "trial.ipynb")
    return catalogue.Chapter(tmp_path / "trial.ipynb", "Trial", "", (), timeout)


# The catalogue

@pytest.mark.parametrize("old, new, said", [
    ("teuliere2009.fig3", "teuliere2009.fig99", "unknown figure teuliere2009.fig99"), ("01_color", "01_missing", "no notebook 01_missing"),
    ("title", "titel", "no key 'title'"), ("timeout = 300", "timeout = ", "Invalid value"), ("timeout", "limit", "no key 'timeout' in the chapter 01_color"),
    ('["teuliere2009.fig1", ', "[", "fig1 is in no chapter"),
])
def test_a_wrong_catalogue_says_what_is_wrong(tmp_path, old, new, said):
    path = tmp_path / "book.toml"
    path.write_text((catalogue.ROOT / "book.toml").read_text().replace(old, new))
    with pytest.raises(catalogue.BookError, match=said):
        catalogue.read(path)


def test_catalogue_registry_and_notebooks_name_the_same_figures():
    named = {c.name: set(c.figures) for c in BOOK.chapters}
    shown = {c.name: {id for _, ids in checks.figure_cells(nbformat.read(c.notebook, 4)) for id in ids} for c in BOOK.chapters}
    assert named == shown
    assert set().union(*named.values()) == set(figures.registry())


@chapters
def test_chapter_is_headed_by_its_number_and_title(chapter):
    assert nbformat.read(chapter.notebook, 4).cells[0].source.startswith(f"# {int(chapter.name[:2])}. {chapter.title}\n")


def test_chapters_stand_in_the_order_of_their_numbers():
    assert [c.name for c in BOOK.chapters] == sorted(c.name for c in BOOK.chapters)


def test_every_notebook_is_in_the_catalogue():
    assert {c.notebook for c in BOOK.chapters} == set(catalogue.NOTEBOOKS.glob("*.ipynb"))


# Notebooks as stored

@chapters
def test_notebook_is_stored_clean(chapter):
    notebook = nbformat.read(chapter.notebook, 4)
    assert checks.stored(notebook) == []
    assert checks.strip(notebook) == notebook


@pytest.mark.parametrize("source", ["def f(): pass", "f = lambda x: x", "class A: pass", "if 1:\n    async def f(): pass"])
def test_helper_functions_are_found(source):
    assert "belongs into the library" in checks.stored(cells("%matplotlib inline\n" + source))[0]


def test_outputs_are_found_and_stripped(tmp_path):
    notebook = cells("1")
    notebook.cells[0].update(execution_count=3, outputs=[nbformat.v4.new_output("stream", text="x")])
    notebook.cells[0].metadata = {"tags": ["kept"], "execution": {"iopub.status.busy": "now"}}
    path = chapter(tmp_path, notebook).notebook
    assert "stored outputs" in checks.stored(notebook)[0]
    assert checks.strip_file(path) and not checks.strip_file(path)
    clean = nbformat.read(path, 4)
    assert checks.stored(clean) == []
    assert clean.cells[0].metadata == {"tags": ["kept"]}


# Running

@chapters
def test_notebook_runs_and_every_figure_appears(chapter, notebooks):
    assert checks.executed(notebooks[chapter.name]) == []
    assert "application/vnd.jupyter.widget-state+json" not in nbformat.writes(notebooks[chapter.name])


def test_a_figure_without_picture_is_noticed():
    assert checks.executed(cells('show("toy.line");')) == ["cell c0 draws toy.line, but no picture came out"]


def test_a_failing_cell_is_named_with_its_traceback(tmp_path):
    trial = chapter(tmp_path, cells("x = 1", "x / 0"))
    with pytest.raises(catalogue.BookError, match=r"(?s)trial.ipynb, cell c1:.*x / 0.*ZeroDivisionError"):
        execute.execute_all([trial], tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["trial.ipynb"]


def test_a_chapter_that_takes_too_long_is_stopped(tmp_path):
    trial = chapter(tmp_path, cells("import time; time.sleep(60)"), timeout=5)
    with pytest.raises(catalogue.BookError, match="trial.ipynb, (?s:.*)not finished after 5 s"):
        execute.execute_all([trial], tmp_path)


def test_an_unchanged_chapter_is_not_run_again(tmp_path):
    trial, folder = chapter(tmp_path, cells("import time; print(time.time_ns())")), tmp_path / "executed"
    first, second = (execute.execute_all([trial], folder) for _ in range(2))
    assert first == second
    nbformat.write(cells("print(1)"), trial.notebook)
    assert execute.execute_all([trial], folder)["trial"].cells[0].outputs[0].text == "1\n"


def test_claims_are_judged_once_until_something_changes(tmp_path, monkeypatch):
    path, asked = tmp_path / "claims.json", []

    def judge(seeds):
        asked.append(seeds)
        return [replace(result, seeds=seeds) for result in made_up.results()]

    first, second = (judged.kept(path, judge) for _ in range(2))
    assert first == second == judge(judged.SEEDS) and len(asked) == 2
    path.write_text("{half a fi")
    assert judged.kept(path, judge) == first and len(asked) == 3
    monkeypatch.setattr(judged, "library_key", lambda: "another state")
    assert judged.kept(path, judge) == first and len(asked) == 4


def test_output_widgets_do_not_stall(tmp_path):
    source = "import ipywidgets\nout = ipywidgets.Output()\nwith out:\n    print('seen')\nout"
    notebook = execute.execute_all([chapter(tmp_path, cells(*[source] * 5))], tmp_path / "executed")["trial"]
    assert all(cell.execution_count for cell in notebook.cells)


# The site

class Page(HTMLParser):
    """What a page loads, where it links to, and the ids it has."""

    def __init__(self, path):
        super().__init__()
        self.loads, self.links, self.ids = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.ids |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        self.loads += [attributes[name] for name in ("src", "srcset", "poster", "data") if attributes.get(name)]
        self.loads += re.findall(r"url\(['\"]?([^)'\"]+)", attributes.get("style") or "")
        if attributes.get("href"):
            (self.loads if tag == "link" else self.links).append(attributes["href"])


@pytest.fixture(scope="session")
def pages_of(site):
    return {path: Page(path) for path in site.rglob("*.html")}


def test_no_request_leaves_the_site(site, pages_of):
    loads = [(path.name, url) for path, page in pages_of.items() for url in page.loads]
    loads += [(path.name, url) for path in site.rglob("*.css")
              for url in re.findall(r"(?:url\(|@import\s+)['\"]?([^)'\";]+)", path.read_text(encoding="utf-8"))]
    assert [load for load in loads if re.match(r"(\w+:)?//", load[1])] == []


def test_every_internal_link_and_file_is_there(pages_of):
    broken = []
    for path, page in pages_of.items():
        for url in page.links + page.loads:
            file, _, fragment = unquote(url).partition("#")
            target = (path.parent / file.partition("?")[0]).resolve() if file else path
            if re.match(r"\w+:", url) or path.name in ("genindex.html", "search.html") and url == "#":
                continue
            if not target.exists() or fragment and target in pages_of and fragment not in pages_of[target].ids:
                broken.append((path.name, url))
    assert broken == []


def test_the_site_is_light_and_so_is_every_pdf(site):
    sizes = {path.relative_to(site): path.stat().st_size for path in site.rglob("*") if path.is_file()}
    assert sum(sizes.values()) < 60e6
    assert {str(path): size for path, size in sizes.items() if path.suffix == ".pdf" and size > 1e6} == {}


def test_under_every_figure_are_its_pdf_and_its_table(site, pages_of):
    for chapter in BOOK.chapters:
        for id in chapter.figures:
            assert {f"{FILES}/{id}.pdf", f"{FILES}/{id}.csv"} <= set(pages_of[site / f"{chapter.name}.html"].links)


def test_gallery_leads_to_every_figure_its_chapter_and_its_source(site, pages_of):
    gallery = pages_of[site / "gallery.html"]
    for chapter in BOOK.chapters:
        for id in chapter.figures:
            assert f"{chapter.name}.html#{pages.anchor(id)}" in gallery.links
            assert pages._source(figures.get(id)) in gallery.links
            assert f"{FILES}/{id}.webp" in gallery.loads


def test_every_claim_is_on_its_page_with_sentence_and_verdict_in_words(site, pages_of):
    text = unescape((site / "claims.html").read_text(encoding="utf-8"))
    for result in made_up.results():
        assert result.claim.id in pages_of[site / "claims.html"].ids
        assert result.claim.sentence in text and result.claim.printed in text
    assert all(f"<td><{verdict}></td>" in text and f"{sign} {verdict}</span>" in text for verdict, (_, sign) in pages.BADGES.items())
    assert "claims.html" in pages_of[site / "index.html"].links


def test_the_leaderboard_says_who_which_data_and_how_many_runs(site, pages_of):
    text = unescape((site / "leaderboard.html").read_text(encoding="utf-8"))
    assert "Nowhere: 1 sequence, 2 runs" in text and "No data at all." in text
    assert text.index("(2) SSD, nine kernels") < text.index("MIL (OpenCV)") and ">0.62 / 88<" in text.replace("<p>", "").replace("</p>", "")
    assert "MIL (OpenCV) would not start on made up: too dark" in text
    assert "leaderboard.html" in pages_of[site / "index.html"].links


def test_every_module_has_its_page(site):
    assert all((site / "api" / f"{name}.html").is_file() for name in pages.modules()[1:])


def test_every_formula_is_drawn():
    formulas = [match for chapter in BOOK.chapters for cell in nbformat.read(chapter.notebook, 4).cells if cell.cell_type == "markdown"
                for match in re.findall(r"\$\$(.+?)\$\$", cell.source, re.S)]
    assert formulas
    assert all(math_svg.svg(tex).startswith("<svg") for tex in formulas)


def test_reprs_of_drawing_calls_are_not_on_the_page(site):
    assert not any("&lt;matplotlib." in (site / f"{chapter.name}.html").read_text(encoding="utf-8") for chapter in BOOK.chapters)


def test_aligned_parameters_become_a_list_and_prose_stays():
    assert listed("span:   how far\n        it reaches\nm: bins") == "* ``span``: how far\n  it reaches\n* ``m``: bins"
    assert listed("theta: (...) [rad].  Returns (...).") == "theta: (...) [rad].  Returns (...)."


@pytest.mark.parametrize("plain, safe", [
    ("|q - q*|^2", r"\|q - q\*\|^2"), ("s *= 2", r"s \*= 2"), ("* one\n* two", "* one\n* two"),
    ("q_ of *all* ``x_ |``", r"q\_ of *all* ``x_ |``"),
])
def test_signs_of_formulas_are_no_markup(plain, safe):
    assert escaped(plain) == safe
