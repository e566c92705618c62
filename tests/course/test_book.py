"""The book: its contents, its notebooks as stored and as run, and the site."""

import asyncio
import io
import re
import shutil
import time
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import unquote

import nbformat
import numpy as np
import pandas as pd
import pytest
from markdown_it import MarkdownIt
from PIL import Image, ImageSequence

import mkt
from mkt.course import slides
from mkt.course.book import (
    agreement,
    checks,
    contents,
    depends,
    execute,
    math_svg,
    pages,
    pictures,
    security,
)
from mkt.course.book.pictures import FILM
from mkt.course.book.site import prepare, rendered, write
from mkt.course.labs.notebooks import labs
from mkt.experiments import claims, leaderboard, shipped
from mkt.experiments.claims_as_text import measured
from mkt.experiments.leaderboard_as_text import extent
from mkt.figures import export
from mkt.figures.registry import FIGURES
from mkt.figures.static_panel import FILES
from mkt.files import DATA, PACKAGE, DataError
from mkt.trackers import by_name
from tests.course import worked

BOOK = contents.read()
chapters = pytest.mark.parametrize(
    "chapter", BOOK.chapters, ids=lambda chapter: chapter.name
)
CLOCK = "import time; print(time.time_ns())"


def cells(*sources):
    return nbformat.v4.new_notebook(
        cells=[
            nbformat.v4.new_code_cell(source, id=f"c{i}")
            for i, source in enumerate(sources)
        ]
    )


def chapter(tmp_path, notebook, timeout=60):
    nbformat.write(notebook, tmp_path / "trial.ipynb")
    return contents.Chapter(tmp_path / "trial.ipynb", "Trial", "", (), timeout)


def run(trial):
    """The one chapter of a book, executed if need be."""
    return execute.execute_all([trial])["trial"]


@pytest.fixture
def nothing_known(tmp_path, monkeypatch):
    """A cache of the test's own, empty at first; its folder."""
    monkeypatch.setenv("MKT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


# The catalogue


def test_a_chapter_without_figures_is_named(tmp_path):
    path = tmp_path / "book.toml"
    figures = re.compile(r"^figures = \[[^]]*\]", re.MULTILINE)
    path.write_text(figures.sub("figures = []", contents.CATALOGUE.read_text(), 1))
    with pytest.raises(contents.BookError, match="no figure in the chapter 01_color"):
        contents.read(path)


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            "teuliere2009.fig3",
            "teuliere2009.fig99",
            "unknown figure teuliere2009.fig99",
        ),
        ("01_color", "01_missing", "no notebook 01_missing"),
        ("title", "titel", "no key 'title'"),
        ("timeout = 300", "timeout = ", "Invalid value"),
        ("timeout", "limit", "no key 'timeout' in the chapter 01_color"),
        ('["teuliere2009.fig1", ', "[", "fig1 is in no chapter"),
    ],
)
def test_a_wrong_catalogue_says_what_is_wrong(tmp_path, old, new, said):
    path = tmp_path / "book.toml"
    path.write_text(contents.CATALOGUE.read_text().replace(old, new))
    with pytest.raises(contents.BookError, match=said):
        contents.read(path)


def test_catalogue_registry_and_notebooks_name_the_same_figures():
    named = {c.name: set(c.figures) for c in BOOK.chapters}
    shown = {
        c.name: {
            name
            for _, names in checks.figure_cells(nbformat.read(c.notebook, 4))
            for name in names
        }
        for c in BOOK.chapters
    }
    assert named == shown
    assert set().union(*named.values()) == set(FIGURES)


@chapters
def test_chapter_is_headed_by_its_number_and_title(chapter):
    assert (
        nbformat.read(chapter.notebook, 4)
        .cells[0]
        .source.startswith(f"# {int(chapter.name[:2])}. {chapter.title}\n")
    )


def test_chapters_stand_in_the_order_of_their_numbers():
    assert [c.name for c in BOOK.chapters] == sorted(c.name for c in BOOK.chapters)


def test_parts_hold_all_chapters_in_their_order():
    assert [c for part in BOOK.parts.values() for c in part] == list(BOOK.chapters)
    assert len(BOOK.parts) == 6 and len(BOOK.parts["Trackers"]) == 6


def test_imports_are_folded_on_the_page_and_other_code_is_not():
    sources = "import numpy\nimport mkt\n\nmkt.use_style()", "import mkt\na = 1\nb = 2"
    cells = [nbformat.v4.new_code_cell(source) for source in (*sources, "c = 3")]
    page = prepare(nbformat.v4.new_notebook(cells=cells))
    folded = ["hide-input" in cell.metadata.get("tags", ()) for cell in page.cells]
    assert folded == [True, False, False]


def test_a_picture_without_a_text_of_its_own_is_told_by_its_heading():
    cell = nbformat.v4.new_code_cell("1")
    cell.outputs = [nbformat.v4.new_output("display_data", {"image/png": "aa"})]
    words = nbformat.v4.new_markdown_cell("# One\n\n## *Two* of $x$\n\ntext")
    page = prepare(nbformat.v4.new_notebook(cells=[words, cell]))
    alt = page.cells[1].metadata["mystnb"]["image"]["alt"]
    assert alt == "What the cell above draws, under: Two of x"


def test_the_gallery_says_of_each_figure_whether_it_agrees_with_the_print():
    said = agreement.said(BOOK)
    assert set(said) == set(FIGURES) and set(said.values()) <= set(agreement.WORDS)
    assert said["teuliere2009.fig7"] == "agrees"
    assert said["nummiaro2003.fig1"] == "in part"  # "agrees, except for"
    for name in ("nummiaro2003.fig4", "nummiaro2003.fig7", "teuliere2009.fig10"):
        assert said[name] == "in part"  # though something in them is ours
    assert said["cordoba2014.ablation"] == said["teuliere2009.fig1"] == "ours"
    assert all(said[name] == "ours" for name in FIGURES if name.startswith("own."))
    page = pages.gallery(BOOK, {})
    assert page.count("mkt-agrees") == list(said.values()).count("agrees") > 0
    assert "data-moves" not in page


def test_a_card_of_the_gallery_plays_what_the_first_slider_shows(site):
    """Of pictures that the chapter has anyway, in the order of the positions."""
    page = (site / "gallery.html").read_text(encoding="utf-8")
    played = dict(
        re.findall(r'figures/([\w.]+)\.avif" alt="" data-moves="([^"]+)"', page)
    )
    drawn = {name for name, e in FIGURES.items() if e.sliders and not e.live}
    assert {"nummiaro2003.fig2", "teuliere2009.fig10"} <= set(played) <= drawn
    assert all(
        (site / one).is_file() for each in played.values() for one in each.split()
    )


def test_the_first_page_s_film_ends_within_five_seconds(site):
    """What moves by itself for longer must have a button that stops it (WCAG 2.2.2)."""
    path = site / FILES / FILM
    film = path.read_bytes()
    flags = film.index(b"elst") + 5
    assert film[flags : flags + 3] == b"\0\0\0"  # the last one: again and again
    lasting = 0
    with Image.open(path) as opened:
        for picture in ImageSequence.Iterator(opened):
            picture.load()
            lasting += picture.info["duration"]
    assert 0 < lasting < 5000


def test_every_notebook_is_in_the_catalogue():
    assert {c.notebook for c in BOOK.chapters} == set(
        contents.NOTEBOOKS.glob("*.ipynb")
    )


# Notebooks as stored


@chapters
def test_notebook_is_stored_clean(chapter):
    notebook = nbformat.read(chapter.notebook, 4)
    assert checks.stored(notebook) == []
    assert checks.strip(notebook) == notebook


@pytest.mark.parametrize(
    "source",
    [
        "def f(): pass",
        "f = lambda x: x",
        "class A: pass",
        "if 1:\n    async def f(): pass",
    ],
)
def test_helper_functions_are_found(source):
    assert (
        "belongs into the library"
        in checks.stored(cells("%matplotlib inline\n" + source))[0]
    )


def test_outputs_are_found_and_stripped(tmp_path):
    notebook = cells("1")
    notebook.cells[0].update(
        execution_count=3, outputs=[nbformat.v4.new_output("stream", text="x")]
    )
    notebook.cells[0].metadata = {
        "tags": ["kept"],
        "execution": {"iopub.status.busy": "now"},
        "scrolled": True,
        "collapsed": False,
    }
    path = chapter(tmp_path, notebook).notebook
    assert "stored outputs" in checks.stored(notebook)[0]
    assert checks.strip_file(path) and not checks.strip_file(path)
    clean = nbformat.read(path, 4)
    assert checks.stored(clean) == []
    assert clean.cells[0].metadata == {"tags": ["kept"]}


def test_what_the_book_leaves_out_is_folded_in_jupyterlab(tmp_path):
    notebook = cells("1")
    notebook.cells[0].metadata = {"tags": [checks.LEFT_OUT]}
    path = chapter(tmp_path, notebook).notebook
    assert checks.strip_file(path) and not checks.strip_file(path)
    folded = nbformat.read(path, 4).cells[0].metadata["jupyter"]
    assert folded == {"source_hidden": True, "outputs_hidden": True}


@pytest.mark.parametrize(
    "text",
    [
        "<<<<<<< HEAD",
        "{}",
        "[]",
        '{"cells": [7], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}',
        '{"cells": [{"cell_type": "code", "id": "a", "source": "", "outputs": [],'
        ' "execution_count": null}], "metadata": {}, "nbformat": 4,'
        ' "nbformat_minor": 5}',
    ],
)
def test_a_file_that_is_no_notebook_is_named_wherever_it_is_read(tmp_path, text):
    trial = chapter(tmp_path, cells("1"))
    trial.notebook.write_text(text)
    book = SimpleNamespace(chapters=[trial])
    for reading in (
        lambda: checks.strip_file(trial.notebook),
        lambda: run(trial),
        lambda: asyncio.run(execute.run(trial, lambda: None)),
        lambda: agreement.said(book),
        lambda: slides.slides(trial),
    ):
        with pytest.raises(DataError, match="trial.ipynb: is no notebook; mend it"):
            reading()


# Running


@chapters
def test_notebook_runs_and_every_figure_appears(chapter, notebooks):
    assert checks.executed(notebooks[chapter.name]) == []
    assert "application/vnd.jupyter.widget-state+json" not in nbformat.writes(
        notebooks[chapter.name]
    )


@pytest.mark.parametrize("call", ['show("toy.line");', 'mkt.explore("toy.line")'])
def test_a_figure_without_picture_is_noticed(call):
    assert checks.executed(cells(call)) == [
        "cell c0 draws toy.line, but no picture came out"
    ]


def test_a_failing_cell_is_named_with_its_traceback(tmp_path, nothing_known):
    trial = chapter(tmp_path, cells("x = 1", "x / 0"))
    with pytest.raises(
        contents.BookError,
        match=r"(?s)trial.ipynb, cell c1:.*x / 0.*ZeroDivisionError",
    ):
        run(trial)
    assert [path.name for path in tmp_path.iterdir()] == ["trial.ipynb"]


def test_a_cell_that_python_cannot_read_is_named_too(tmp_path, nothing_known):
    trial = chapter(tmp_path, cells("x = "))
    with pytest.raises(
        contents.BookError, match=r"(?s)trial.ipynb, cell c0:.*SyntaxError"
    ):
        run(trial)


@pytest.mark.slow
def test_a_chapter_that_takes_too_long_is_stopped(tmp_path, nothing_known):
    trial = chapter(tmp_path, cells("import time; time.sleep(60)"), timeout=5)
    with pytest.raises(
        contents.BookError, match="trial.ipynb, (?s:.*)not finished after 5 s"
    ):
        run(trial)


def test_an_unchanged_chapter_is_not_run_again(tmp_path, nothing_known):
    trial = chapter(tmp_path, cells(CLOCK))
    first = run(trial)
    assert run(trial) == first
    nbformat.write(cells("print(1)"), trial.notebook)
    assert run(trial).cells[0].outputs[0].text == "1\n"


def test_a_chapter_whose_text_alone_changed_shows_it_with_the_known_outputs(
    tmp_path, nothing_known
):
    notebook = cells(CLOCK)
    trial = chapter(tmp_path, notebook)
    before = run(trial)
    notebook.cells.insert(0, nbformat.v4.new_markdown_cell("# New", id="new"))
    nbformat.write(notebook, trial.notebook)
    after = run(trial)
    assert after.cells[0].source == "# New"
    assert after.cells[1] == before.cells[0]
    assert after.cells[1].outputs[0].text.strip().isdecimal()


def test_what_the_page_leaves_out_is_not_run_and_may_change(tmp_path, nothing_known):
    notebook = cells(CLOCK, "1 / 0", "print(2)")
    notebook.cells[1].metadata = {"tags": [checks.LEFT_OUT]}
    trial = chapter(tmp_path, notebook)
    first = run(trial)
    assert [len(cell.outputs) for cell in first.cells] == [1, 0, 1]
    notebook.cells[1].source = "2 / 0"
    nbformat.write(notebook, trial.notebook)
    assert run(trial).cells[0] == first.cells[0]
    notebook.cells[1].metadata = {}
    nbformat.write(notebook, trial.notebook)
    with pytest.raises(contents.BookError, match="ZeroDivisionError"):
        run(trial)


def test_the_tests_run_what_the_page_leaves_out(tmp_path, nothing_known):
    notebook = cells("1 / 0")
    notebook.cells[0].metadata = {"tags": [checks.LEFT_OUT]}
    trial = chapter(tmp_path, notebook)
    (tmp_path / "answers").mkdir()
    with pytest.raises(contents.BookError, match="ZeroDivisionError"):
        worked.executed([trial], tmp_path / "answers")


def test_lines_that_take_their_time_are_one_output(tmp_path, nothing_known):
    source = (
        "import time\nfor k in range(3):\n    print(k, flush=True)\n    time.sleep(0.5)"
    )
    [output] = run(chapter(tmp_path, cells(source))).cells[0].outputs
    assert output.text == "0\n1\n2\n"


def test_output_widgets_do_not_stall(tmp_path, nothing_known):
    source = (
        "import ipywidgets\n"
        "out = ipywidgets.Output()\n"
        "with out:\n"
        "    print('seen')\n"
        "out"
    )
    notebook = run(chapter(tmp_path, cells(*[source] * 5)))
    assert all(cell.execution_count for cell in notebook.cells)


# What has to be made again


def reached(*sources):
    """Files of the library that the code of a chapter reaches, below ``mkt``."""
    files = depends.reachable(depends.named_in(cells(*sources)))
    return {path.relative_to(PACKAGE).as_posix() for path in files}


@pytest.mark.parametrize(
    "source",
    [
        "from mkt.trackers.ssd import SSD",
        "import mkt.trackers.ssd",
        "from mkt.trackers import ssd",
        "import mkt\nmkt.SSD()",
        "import mkt\nmkt.track(mkt.SSD(iterations=3), clip).info",
        "import mkt\nmkt.trackers.ssd.SSD()",
        "from mkt import SSD",
    ],
)
def test_a_chapter_reaches_what_its_code_names_and_what_that_imports(source):
    found = reached(source)
    assert {"trackers/ssd.py", "histograms.py", "regions.py"} <= found
    assert not {"trackers/guided.py", "servoing/loop.py"} & found


def test_a_chapter_reaches_the_figures_that_it_shows_and_no_others():
    found = reached('from mkt.figures import show\nshow("teuliere2009.fig3");')
    assert {"papers/teuliere2009/histograms.py", "figures/static_panel.py"} <= found
    assert not any(name.startswith("papers/nummiaro2003/") for name in found)
    assert reached('mkt.FIGURES["teuliere2009.fig3"].draw()') <= found
    for whole in ("mkt.FIGURES", "mkt.FIGURES[name]"):
        everything = reached(f"import mkt\n{whole}")
        assert "papers/nummiaro2003/listing.py" in everything


@chapters
def test_a_change_in_the_course_runs_no_chapter_again(chapter):
    notebook = nbformat.read(chapter.notebook, 4)
    sources = [cell.source for cell in checks.code_cells(notebook)]
    assert not any(name.startswith("course/") for name in reached(*sources))


@pytest.fixture
def another_comment(tmp_path, monkeypatch):
    """A function that gives a file of the library one more comment, in a copy."""
    digest = depends._digest

    def change(file):
        copy = tmp_path / file.name
        copy.write_text(file.read_text() + "# another word\n")
        monkeypatch.setattr(
            depends,
            "_digest",
            lambda path, *how: digest(copy if path == file else path, *how),
        )

    return change


@pytest.mark.parametrize(
    "name", ["01_color_histograms", "04_multiple_kernel_ssd", "16_a_plane_in_space"]
)
def test_another_comment_runs_no_chapter_again_that_prints_no_code(
    name, another_comment
):
    [notebook] = [nbformat.read(c.notebook, 4) for c in BOOK.chapters if c.name == name]
    key = depends.of_chapter(notebook)
    another_comment(PACKAGE / "trackers" / "ssd.py")
    assert depends.of_chapter(notebook) == key


@pytest.mark.parametrize("paper", ["teuliere2009", "nummiaro2003", "cordoba2014"])
def test_a_change_in_one_papers_figures_draws_no_other_papers_again(paper):
    drawn_again = {
        name.partition(".")[0]
        for name, entry in FIGURES.items()
        for file in depends.reachable([depends.home(entry)])
        if file.parent == depends.PAPERS / paper
    }
    assert paper in drawn_again and drawn_again <= {paper, "own"}


def test_a_key_follows_code_packages_and_data_but_not_text(monkeypatch, tmp_path):
    (tmp_path / "environment.txt").write_text("numpy==1\n")
    notebook = cells("from mkt.figures import show")
    keys = [depends.of_chapter(notebook)]
    notebook.cells.append(nbformat.v4.new_markdown_cell("text"))
    assert depends.of_chapter(notebook) == keys[0]
    for place, name, other in [
        (depends, "reachable", lambda files: {PACKAGE / "regions.py"}),
        (depends, "beside", lambda files: [PACKAGE / "regions.py"]),
        (depends.dependencies, "versions", lambda: ["numpy 1"]),
        (depends, "PACKAGES", tmp_path / "environment.txt"),
    ]:
        with monkeypatch.context() as patch:
            patch.setattr(place, name, other)
            keys.append(depends.of_chapter(notebook))
    monkeypatch.setenv("MKT_DATA", "elsewhere")
    keys.append(depends.of_chapter(notebook))
    notebook.cells[0].source += "\n"
    keys.append(depends.of_chapter(notebook))
    assert len(set(keys)) == len(keys) == 7


def test_what_reads_the_tables_of_the_release_has_them_in_its_key(
    tmp_path, monkeypatch
):
    def of(name):
        return depends.of_picture(FIGURES[name])

    names = "own.survival", "cordoba2014.ablation", "own.newton"
    before = {name: of(name) for name in names}
    for table in (*DATA.glob("*.csv"), *DATA.glob("*.json")):
        shutil.copy(table, tmp_path)
    monkeypatch.setattr(depends, "DATA", tmp_path)
    assert {name: of(name) for name in names} == before
    for table in tmp_path.iterdir():
        text = table.read_text()
        table.write_text(text + "more\n")
        changed = {name for name in names if of(name) != before[name]}
        assert changed == {"own.survival", "cordoba2014.ablation"}, table.name
        table.write_text(text)


def test_a_benchmark_that_comes_or_changes_makes_another_key(tmp_path, monkeypatch):
    notebook = cells("from mkt.figures import show")
    keys = []
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    ball = tmp_path / "bobot" / "ball" / "truth.txt"
    for text in (None, "0 0 0 1 1\n", "0 0 0 1 .5\n"):
        if text:
            ball.parent.mkdir(parents=True, exist_ok=True)
            ball.write_text(text)
        depends._benchmarks.cache_clear()
        keys.append(depends.of_chapter(notebook))
    depends._benchmarks.cache_clear()
    assert len(set(keys)) == 3


def test_of_the_code_that_a_chapter_reaches_all_but_comments_is_in_its_key(
    tmp_path, monkeypatch
):
    texts = "x = 1\n", "x = 1  # one\n", "x = 2\n"
    keys = []
    for name, text in zip("abc", texts, strict=True):
        (tmp_path / f"{name}.py").write_text(text)
        reached = {tmp_path / f"{name}.py"}
        monkeypatch.setattr(depends, "reachable", lambda files, all=reached: all)
        keys.append(depends.of_chapter(cells("import mkt")))
    assert keys[0] == keys[1] != keys[2]


def test_a_template_beside_a_module_counts_as_its_code_does():
    files = depends.reachable(depends.named_in(cells("import mkt\nmkt.show")))
    assert PACKAGE / "figures" / "static_panel.html" in depends.beside(files)


def test_a_figure_is_drawn_once_and_alone_when_it_changes(nothing_known, monkeypatch):
    asked = []

    def draw_all(names):
        asked.extend(names)
        yield from ((name, dict.fromkeys(pictures.DRAWN, b"x")) for name in names)

    def key(entry, *how):
        return f"{entry.name} {entry.name == changed}"

    monkeypatch.setattr(pictures, "_draw_all", draw_all)
    monkeypatch.setattr(depends, "of_picture", key)
    changed = ""
    first = pictures.drawn()
    assert len(first) == 3 * len(FIGURES) and asked == list(FIGURES)
    assert pictures.drawn() == first and asked == list(FIGURES)
    changed = "own.run"
    assert pictures.drawn() == first and asked == [*FIGURES, "own.run"]


def test_the_film_of_the_first_page_keeps_its_colours(nothing_known, monkeypatch):
    drawn = [Image.new("RGB", (64, 48), (80 * k, 60, 20)) for k in range(3)]
    monkeypatch.setattr(export, "moving", lambda *_: iter(drawn))
    made = pictures.film()
    content = made[pictures.FILM]
    with Image.open(io.BytesIO(content)) as film:
        shown = [each.convert("RGB") for each in ImageSequence.Iterator(film)]
        assert film.info["duration"] == export.MOVING_MS
    assert len(shown) == 3
    for there, before in zip(shown, drawn, strict=True):
        assert np.abs(np.subtract(there, before, dtype=float)).mean() < 6
    monkeypatch.setattr(export, "moving", None)
    assert pictures.film() == made  # it is known


def test_who_wants_no_motion_sees_the_film_stand_still(nothing_known, monkeypatch):
    two = [Image.new("RGB", (64, 48), colour) for colour in ("black", "white")]
    monkeypatch.setattr(export, "moving", lambda *_: iter(two))
    made = pictures.film()
    with Image.open(io.BytesIO(made[pictures.STILL])) as still:
        assert still.n_frames == 1 and still.width > 64
    page = pages.first(contents.read(), [], [])
    assert f'reduce)" srcset="{pages.FILES}/{pictures.STILL}"' in page


# Pages


def board(words):
    """A board on which one of two trackers would not start, its words these."""
    numbers = {"overlap": 0.625, "hits": 0.875, "hits_of_all": 0.75, "area": 0.61}
    run = numbers | {"lost": 0.0, "cpu_ms": 4.2, "seed": 0, "source": words}
    rows = [run | {"tracker": "ssd"}, run | {"tracker": "mil"}]
    refused = pd.DataFrame(rows).assign(refused=["", "too dark"])
    return leaderboard.Board("Nowhere", words, refused, "source")


def test_a_verdict_of_each_kind_has_its_sign_its_words_and_its_picture():
    sentence = "<b>x</b> & y"
    values = np.linspace(-1, 1, 12)
    parts = [
        claims.Part(sentence, values + 9, 0),
        claims.Part("no", values - 9, 0),
        claims.Part("nobody knows", values, 0),
        claims.Part("equal", values, 0, margin=2),
        claims.Part("ours", values * np.nan, 0, ours=True),
    ]
    claim = next(iter(claims.CLAIMS.values()))
    seeds = range(1000, 1012)
    results = [claims.judge(claims.Measured(claim, seeds, (part,))) for part in parts]
    made = shipped.Made(
        "make it", "2026-01-02", "1000:1012", ["python 9"], {"claims": "other"}, ""
    )
    page = pages.claims(BOOK, results, results, made)
    for verdict, (name, sign) in pages.BADGES.items():
        assert f'mkt-{name}">{sign} {verdict}</span>' in page
    assert "&lt;b&gt;x&lt;/b&gt; &amp; y" in page and "<b>x" not in page
    assert page.count("<svg") == 4 and page.count("has changed since then") == 1
    assert "2026-01-02" in page and page.count("ours, or true whatever") == 1
    assert "They are of 12 pairs of\nobject and ground, 4 objects before 3 gr" in page


def test_the_page_says_which_verdicts_are_others_on_new_scenes():
    """Of three claims that are supported one is so again; and one becomes it."""
    right, wrong = (claims.Part("x", np.arange(12.0) + k, 6) for k in (7, -20))
    names = list(claims.CLAIMS)[:4]

    def results(*parts):
        pairs = zip(names, parts, strict=True)
        return [
            claims.judge(claims.Measured(claims.CLAIMS[name], range(12), (part,)))
            for name, part in pairs
        ]

    made = shipped.read_claims()[1]
    first = results(right, right, right, wrong)
    page = pages.claims(BOOK, first, results(right, wrong, wrong, right), made)
    assert "Of the 3 claims that\nare supported, 1 are so there again" in page
    for name, new, old in zip(
        names[1:],
        ("contradicted", "contradicted", "supported"),
        ("supported", "supported", "contradicted"),
        strict=True,
    ):
        assert f"{name} (*{new}*, above *{old}*)" in page
    assert f"{names[0]} (*" not in page
    assert "is another for" not in pages.claims(BOOK, first, first, made)
    index = pages.first(BOOK, first, results(right, wrong, wrong, right))
    assert "On new scenes 1 of the 3 are supported again." in index


def test_a_claim_that_says_it_came_late_is_named_below_the_claims():
    results = [claims.judge(one) for one in shipped.claimed()]
    page = pages.claims(BOOK, results, results, shipped.read_claims()[1])
    late = page.partition("six claims,")[2].partition("\n*")[0]
    after = re.compile(r"after (most of )?the(se)? runs")
    named = {name for name, one in claims.CLAIMS.items() if after.search(one.remark)}
    assert {"T09-d", "T09-j", "C14-a"} <= named
    assert {name for name in named if name not in late} == set()


def test_where_a_claim_is_printed_leads_to_our_figures():
    said = {name: pages.printed(one, BOOK) for name, one in claims.CLAIMS.items()}
    figure = '<a href="{}.html#fig-{}">{}</a>'
    eight, nine = (
        figure.format("12_learning_model", f"nummiaro2003-fig{n}", n) for n in (8, 9)
    )
    assert said["N03-d"] == f"figures {eight} and {nine}"
    assert said["C14-a"].count("<a ") == 1 and said["T09-g"].count("<a ") == 0
    assert "&#34;roughly 75 %&#34; fewer" in said["T09-f"]


def test_the_last_page_ranks_all_trackers_on_real_video():
    page = pages.after(leaderboard.shipped())
    rows, _ = shipped.read_runs(shipped.BOBOT)
    head, line, *ranked = [row for row in page.splitlines() if row.startswith("|")]
    assert "overlap" in head and len(ranked) == rows["tracker"].nunique() > 10


def test_names_of_folders_and_titles_are_shown_as_they_are():
    ugly = '<b>*a*</b> _b_ `c` | $d$ & "e" [f](g)'
    page = MarkdownIt().enable("table").render(pages.leaderboard([board(ugly)]))
    assert unescape(page).count(ugly) == 3  # the data, a column, a refusal
    assert "<b>" not in page and "<em>a</em>" not in page
    titled = replace(BOOK.chapters[0], title=ugly)
    first = pages.first(replace(BOOK, chapters=(titled, *BOOK.chapters[1:])), [], [])
    assert ugly in unescape(first) and "<b>" not in first


def test_every_old_name_of_a_module_leads_to_a_module_that_is_there():
    known = pages.modules()
    for path, text in pages.moved().items():
        new = re.search(r"is now <a href=\"[^\"]*\">([^<]+)</a>", text)[1]
        assert new in known
        if path.startswith("api/"):
            assert Path(path).stem not in known


def test_a_folder_is_made_to_hold_what_is_given_and_touched_no_more_than_that(tmp_path):
    write({"a/b.txt": b"1", "c.txt": b"2"}, tmp_path)
    then = (tmp_path / "c.txt").stat().st_mtime_ns
    write({"a/d.txt": b"3", "c.txt": b"2"}, tmp_path)
    files = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {"d.txt", "c.txt"}
    assert (tmp_path / "c.txt").stat().st_mtime_ns == then


# The site


def test_a_site_that_sphinx_cannot_write_is_an_error(tmp_path, capfd):
    (tmp_path / "conf.py").write_text("1 / 0")
    with pytest.raises(contents.BookError, match="see above"):
        with rendered(tmp_path, tmp_path / "build"):
            pass
    assert "ZeroDivisionError" in capfd.readouterr().err


def test_sphinx_ends_where_the_other_work_fails(tmp_path):
    begun, late = tmp_path / "begun", tmp_path / "late"
    (tmp_path / "conf.py").write_text(
        "import pathlib, time\n"
        f"pathlib.Path({str(begun)!r}).touch()\n"
        "time.sleep(10)\n"
        f"pathlib.Path({str(late)!r}).touch()\n"
    )
    with pytest.raises(ZeroDivisionError), rendered(tmp_path, tmp_path / "build"):
        while not begun.exists():
            time.sleep(0.1)
        raise ZeroDivisionError
    assert not late.exists()


def test_what_another_module_made_is_on_its_page_alone(site):
    page = (site / "api" / "mkt.trackers.newton.html").read_text(encoding="utf-8")
    assert 'id="mkt.trackers.newton.minimise"' in page
    assert 'id="mkt.trackers.newton.coefficient"' not in page
    aliases = (site / "api" / "mkt.types.html").read_text(encoding="utf-8")
    assert 'id="mkt.types.Rng"' in aliases


def test_pages_that_no_sidebar_lists_have_one_that_leads_on(site):
    for page in ("_modules/mkt/trackers/ssd", "_modules/mkt/colors", "api/mkt.colors"):
        path = site / f"{page}.html"
        text = path.read_text(encoding="utf-8")
        sidebar = text.partition('class="sidebar-tree"')[2].partition("</aside>")[0]
        [address] = re.findall(r'href="([^"]*02_cost_surfaces.html)"', sidebar)
        assert (path.parent / address).is_file()


class Page(HTMLParser):
    """What a page loads, where it links to, and the ids it has."""

    def __init__(self, path):
        super().__init__()
        self.loads, self.links, self.ids = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.ids |= {
            attributes[name] for name in ("id", "name") if attributes.get(name)
        }
        self.loads += [
            attributes[name]
            for name in ("src", "srcset", "poster", "data")
            if attributes.get(name)
        ]
        self.loads += re.findall(
            r"url\(['\"]?([^)'\"]+)", attributes.get("style") or ""
        )
        if attributes.get("href"):
            (self.loads if tag == "link" else self.links).append(attributes["href"])


@pytest.fixture(scope="session")
def pages_of(site):
    return {path: Page(path) for path in site.rglob("*.html")}


def test_no_request_leaves_the_site(site, pages_of):
    loads = [(path.name, url) for path, page in pages_of.items() for url in page.loads]
    loads += [
        (path.name, url)
        for path in site.rglob("*.css")
        for url in re.findall(
            r"(?:url\(|@import\s+)['\"]?([^)'\";]+)", path.read_text(encoding="utf-8")
        )
    ]
    assert [load for load in loads if re.match(r"(\w+:)?//", load[1])] == []


def test_every_internal_link_and_file_is_there(pages_of):
    broken = []
    for path, page in pages_of.items():
        for url in page.links + page.loads:
            file, _, fragment = unquote(url).partition("#")
            target = (path.parent / file.partition("?")[0]).resolve() if file else path
            if (
                re.match(r"\w+:", url)
                or path.name in ("genindex.html", "search.html")
                and url == "#"
            ):
                continue
            if (
                not target.exists()
                or fragment
                and target in pages_of
                and fragment not in pages_of[target].ids
            ):
                broken.append((path.name, url))
    assert broken == []


def test_the_site_is_light_and_so_is_every_pdf(site):
    sizes = {
        path.relative_to(site): path.stat().st_size
        for path in site.rglob("*")
        if path.is_file()
    }
    assert sum(sizes.values()) < 50e6
    assert {
        str(path): size
        for path, size in sizes.items()
        if path.suffix == ".pdf" and size > 1e6
    } == {}


# What a page names but does not load: its own data, films, and pages that follow.
OTHERS = re.compile(r"data:|.*\.(webm|html)$")


def test_a_chapter_is_light_without_its_films(site, pages_of):
    """All that it asks for by itself, before anything is moved."""
    weights = {}
    for chapter in BOOK.chapters:
        path = site / f"{chapter.name}.html"
        loads = {url.partition("?")[0] for url in pages_of[path].loads}
        files = [site / url for url in loads if not OTHERS.match(url)]
        weights[chapter.name] = sum(file.stat().st_size for file in [path, *files])
    assert {name: size for name, size in weights.items() if size > 1.5e6} == {}


def test_under_every_figure_are_its_pdf_and_its_table(site, pages_of):
    for chapter in BOOK.chapters:
        links = set(pages_of[site / f"{chapter.name}.html"].links)
        for name in chapter.figures:
            assert {f"{FILES}/{name}.pdf", f"{FILES}/{name}.csv"} <= links


def test_every_chapter_hands_out_its_notebook_without_outputs(site, pages_of):
    for chapter in BOOK.chapters:
        address = f"{pages.NOTEBOOKS}/{chapter.name}.ipynb"
        assert address in pages_of[site / f"{chapter.name}.html"].links
        notebook = nbformat.read(site / address, 4)
        assert notebook.cells == checks.strip(nbformat.read(chapter.notebook, 4)).cells


def test_gallery_leads_to_every_figure_its_chapter_and_its_source(site, pages_of):
    gallery = pages_of[site / "gallery.html"]
    for chapter in BOOK.chapters:
        for name in chapter.figures:
            assert f"{chapter.name}.html#{pages.anchor(name)}" in gallery.links
            assert pages.source_page(FIGURES[name].function) in gallery.links
            assert f"{FILES}/{name}.avif" in gallery.loads


def test_every_claim_is_on_its_page_with_sentence_and_verdict_in_words(site, pages_of):
    text = unescape((site / "claims.html").read_text(encoding="utf-8"))
    text = text.replace("\N{NO-BREAK SPACE}", " ")
    words = re.sub(r"</?a[^>]*>", "", text)
    again = map(claims.judge, shipped.claimed(table=shipped.AGAIN))
    for result, other in zip(map(claims.judge, shipped.claimed()), again, strict=True):
        assert result.claim.name in pages_of[site / "claims.html"].ids
        assert result.claim.sentence in words and result.claim.printed in words
        _, sign = pages.BADGES[result.verdict]
        assert f"{sign} {result.verdict}</span>" in text
        for line, new in zip(result.lines, other.lines, strict=True):
            assert f"<td>{line.part.text}</td>" in text
            below = f'<span class="mkt-again">{measured(new)}</span>'
            assert f"<td>{measured(line)}{below}</td>" in text
    assert "claims.html" in pages_of[site / "index.html"].links


def test_a_chapter_says_of_a_claim_what_its_page_says():
    """Verdicts in chapters are printed from the shipped numbers, not written."""
    for chapter in BOOK.chapters:
        cells = nbformat.read(chapter.notebook, 4).cells
        named = {
            name
            for cell in cells
            if cell.cell_type == "markdown"
            for name in re.findall(r"\b[TNC]\d\d-[a-z]\b", cell.source)
        }
        shown = " ".join(c.source for c in cells if "mkt.verdicts(" in c.source)
        assert {name for name in named if name not in shown} == set(), chapter.name


def test_the_leaderboard_says_who_which_data_and_how_many_runs(site, pages_of):
    text = unescape((site / "leaderboard.html").read_text(encoding="utf-8"))
    for each in leaderboard.shipped():
        first, *_, last = leaderboard.ranking(each)
        assert f"{each.title}: {extent(each)}" in text
        start = text.index(each.title)
        assert text.index(by_name.LABELS[first.name], start) < text.index(
            by_name.LABELS[last.name], start
        )
    assert "<p>E person partially occluded</p>" in text  # short, as the page is narrow
    dots = sum(leaderboard.cases_of(each).size for each in leaderboard.shipped())
    assert text.count("10h0") == dots
    assert "leaderboard.html" in pages_of[site / "index.html"].links


def test_every_lab_is_a_page_without_solutions_to_which_a_chapter_leads(site, pages_of):
    chapters = [pages_of[site / f"{chapter.name}.html"] for chapter in BOOK.chapters]
    for name in labs():
        page = site / "handout" / f"{name}.html"
        text = unescape(re.sub("<[^>]*>", "", page.read_text(encoding="utf-8")))
        assert "# YOUR CODE HERE" in text
        assert "HIDDEN TESTS" not in text and "teacher's version" not in text
        assert any(f"handout/{name}.html" in chapter.links for chapter in chapters)


def test_every_module_has_its_page(site):
    assert all(
        (site / "api" / f"{name}.html").is_file() for name in pages.modules()[1:]
    )


def test_every_public_name_is_in_the_reference(site):
    found = set()
    for name in {*mkt.NAMES.values()}:
        text = (site / "api" / f"{name}.html").read_text(encoding="utf-8")
        found |= {one.rpartition(".")[2] for one in re.findall(r'id="([\w.]+)"', text)}
    assert {*mkt.NAMES} - found == set()


def test_the_source_of_a_module_has_a_title_of_its_own(site):
    text = (site / "_modules" / "mkt" / "regions.html").read_text(encoding="utf-8")
    assert "<title>Source of mkt.regions" in text


def test_every_old_address_of_a_module_is_answered(site, pages_of):
    for path in pages.moved():
        assert len(pages_of[site / path].links) == 1


def test_every_page_has_the_script_of_the_panels(site, pages_of):
    for chapter in BOOK.chapters:
        loads = pages_of[site / f"{chapter.name}.html"].loads
        assert any(url.startswith("_static/static_panel.js") for url in loads)


@pytest.mark.slow
def test_every_formula_is_drawn():
    formulas = [
        match
        for chapter in BOOK.chapters
        for cell in nbformat.read(chapter.notebook, 4).cells
        if cell.cell_type == "markdown"
        for match in re.findall(r"\$\$(.+?)\$\$", cell.source, re.S)
    ]
    assert formulas
    assert all(math_svg.svg(tex).startswith("<svg") for tex in formulas)


def test_a_formula_that_was_drawn_is_known_to_the_next_program(
    nothing_known, monkeypatch
):
    math_svg._drawn.cache_clear()
    drawn = math_svg.svg(r"\rho_1")
    math_svg._drawn.cache_clear()
    monkeypatch.setattr(math_svg, "_draw", None)
    assert math_svg.svg(r"\rho_1") == drawn
    assert math_svg.svg(r"\rho_2").startswith("<code>")
    math_svg._drawn.cache_clear()


def test_a_path_is_told_in_fewer_letters_and_goes_the_same_way():
    path = "M 4.608 -12.69 L 5 -12 Q 0.5 1 -0.5 0.001 Z M 10 100 C 1 2 3 4 20 0.5 Z"
    shorter = "m4.61-12.69l.39 .69q-4.5 13-5.5 12zm5.39 112.69c-9-98-7-96 10-99.5z"
    assert math_svg.shorter(path) == shorter


def test_reprs_of_drawing_calls_are_not_on_the_page(site):
    assert not any(
        "&lt;matplotlib." in (site / f"{chapter.name}.html").read_text(encoding="utf-8")
        for chapter in BOOK.chapters
    )


def test_lines_that_cells_print_fit_in_their_box_on_a_wide_screen(site):
    long = []
    for chapter in BOOK.chapters:
        text = (site / f"{chapter.name}.html").read_text(encoding="utf-8")
        printed = re.findall(r'<div class="output[^"]*stream.*?</pre>', text, re.S)
        lines = unescape(re.sub(r"<[^>]*>", "", "\n".join(printed))).splitlines()
        long += [line for line in lines if len(line) > 98]
    assert long == []


def test_every_script_inside_a_page_is_moved_into_a_file(tmp_path):
    (tmp_path / "_static").mkdir()
    page = tmp_path / "a.html"
    page.write_text("<head></head><script>one</script><script>two</script>")
    security.seal(tmp_path)
    sealed = page.read_text()
    assert "<script>" not in sealed and sealed.count("<script src=") == 2
