"""The pages around the chapters, and Sphinx's configuration.

They are the first page, the gallery, the claims, the leaderboard, the reference of the
library, and what leads on from the old names of its modules.  Their words are in the
folder templates; here is what is filled in.  Each public function returns the text of
one file.

In the templates everything is escaped for HTML; ``md`` escapes names and sentences for
Markdown, so that a folder called ``*a*`` is shown as it is.
"""

import ast
import pkgutil
import re
import string
import tomllib
from collections.abc import Callable, Iterable, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup, escape

import mkt
from mkt.course.book import agreement, live, pictures
from mkt.course.book.contents import Book, Chapter
from mkt.experiments import leaderboard as ranks
from mkt.experiments import leaderboard_as_text as tables
from mkt.experiments import shipped
from mkt.experiments.claims import (
    CONTRADICTED,
    INCONCLUSIVE,
    RULE,
    SUPPORTED,
    TIE,
    UNTESTED,
    Claim,
    Line,
    Result,
)
from mkt.experiments.claims_as_text import measured
from mkt.figures.captions import marked
from mkt.figures.registry import FIGURES, Entry
from mkt.figures.static_panel import FILES, SCRIPT, STYLE
from mkt.files import ROOT
from mkt.scenes.drawn import drawn
from mkt.trackers.by_name import LABELS

HERE = Path(__file__).parent
TEXT = HERE / "text.js"
PLAYS = HERE / "gallery.js"
SCORER = HERE / "scorer.js"
STYLES = HERE / "mkt.css", STYLE
NOTEBOOKS = "_static/notebooks"  # of the site: NAME.ipynb of each chapter
ACCENT = {"light": "#0b6e99", "dark": "#5cc0ea"}
# Class and sign of each verdict, beside the words.
BADGES = {
    SUPPORTED: ("supported", "✓"),
    TIE: ("tie", "="),
    INCONCLUSIVE: ("inconclusive", "?"),
    CONTRADICTED: ("contradicted", "✗"),
    UNTESTED: ("untested", "·"),
}
EXTENSIONS = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "mkt.course.book.math_svg",
    "mkt.course.book.reference",
    "mkt.course.book.accessibility",
]
# What a dot of the leaderboard stands for, by the column of its cases.
CASES = {"seed": "seed, the mean over all kinds of scene", "source": "sequence"}
SETTINGS = {
    "extensions": EXTENSIONS,
    # The reference
    "default_role": "py:obj",
    "autodoc_default_options": {"members": True, "member-order": "bysource"},
    "autodoc_preserve_defaults": True,
    "autodoc_typehints": "none",  # the sections of the docstrings say more
    "python_maximum_signature_line_length": 88,
    "viewcode_follow_imported_members": False,  # numpy shows its own sources
    "napoleon_google_docstring": False,
    # As lists: what stands for a type, "(J, m) array", is no name to be looked up.
    "napoleon_use_param": False,
    "napoleon_use_rtype": False,
    "napoleon_custom_sections": [("Attributes", "params_style")],
    # The chapters
    "nb_execution_mode": "off",
    "nb_ipywidgets_js": {},
    "nb_render_markdown_format": "myst",
    "nb_code_prompt_show": "What is imported",
    "nb_code_prompt_hide": "What is imported",
    "myst_enable_extensions": ["dollarmath", "amsmath", "deflist"],
    "myst_heading_anchors": 3,
    # Their looks
    "html_math_renderer": "svg",
    "html_theme": "furo",
    "html_static_path": ["_static"],
    "html_extra_path": ["moved"],
    "html_css_files": [path.name for path in STYLES],
    "html_js_files": [SCRIPT.name, TEXT.name, live.SCRIPT],
    "html_show_copyright": False,
    "html_copy_source": False,
    "html_show_search_summary": False,
    "html_search_scorer": str(SCORER),
    "html_show_sourcelink": False,
    "pygments_style": "a11y-light",
    "pygments_dark_style": "github-dark",
    "html_theme_options": {
        f"{mode}_css_variables": {
            "color-brand-primary": color,
            "color-brand-content": color,
        }
        for mode, color in ACCENT.items()
    },
}


def _markdown(text: str) -> Markup:
    """A text in one line that Markdown shows as it is."""
    signs = {sign: f"\\{sign}" for sign in string.punctuation}
    return Markup(" ".join(text.split()).translate(str.maketrans(signs)))


_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(HERE / "templates"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    undefined=jinja2.StrictUndefined,
)


def _filled(template: str, **values: Any) -> str:
    return _TEMPLATES.get_template(f"{template}.j2").render(values)


def configuration(book: Book) -> str:
    """conf.py."""
    settings = {"project": book.title, "html_title": book.title} | SETTINGS
    return "".join(f"{name} = {value!r}\n" for name, value in settings.items())


def first(book: Book, results: list[Result], again: list[Result]) -> str:
    """index.md: what the book is, how the claims came out, its chapters."""
    return _filled(
        "index.md",
        book=book,
        counts=_counts(results),
        stood=_stood(results, again),
        files=FILES,
        film=f"{FILES}/{pictures.FILM}",
        still=f"{FILES}/{pictures.STILL}",
        version=mkt.__version__,
    )


def gallery(book: Book, moves: Mapping[str, list[str]]) -> str:
    """gallery.md: every figure by its chapter, with links to it and to its source.

    Under the mouse, a card plays those pictures {figure: addresses} that there are.
    """
    said = agreement.said(book)
    chapters = [
        (chapter, [_card(FIGURES[name], chapter) for name in chapter.figures])
        for chapter in book.chapters
        if chapter.figures
    ]
    script = f"_static/{PLAYS.name}"
    return _filled(
        "gallery.md", chapters=chapters, said=said, moves=moves, script=script
    )


def _card(entry: Entry, chapter: Chapter) -> dict[str, str]:
    """What a page needs to know of a figure."""
    titles = entry.number, entry.title
    return {
        "name": entry.name,
        "title": Markup(marked(": ".join(filter(None, titles)).rstrip("."))),
        "page": f"{chapter.name}.html",
        "anchor": anchor(entry.name),
        "picture": f"{FILES}/{entry.name}.avif",
        "source": source_page(entry.function),
    }


def anchor(name: str) -> str:
    """The HTML id under which a figure is found on its chapter's page."""
    return "fig-" + name.replace(".", "-")


def source_page(function: Callable) -> str:
    """Where the source of a function stands in the site."""
    page = function.__module__.replace(".", "/")
    return f"_modules/{page}.html#{function.__name__}"


def claims(
    book: Book, results: list[Result], again: list[Result], made: shipped.Made
) -> str:
    """claims.md: every judged claim with its numbers and its verdict.

    And the same ``again`` on other scenes, in the same order.
    """
    twice = list(zip(results, again, strict=True))
    scenes = [drawn("", seed) for seed in results[0].seeds]
    modules = dict.fromkeys(result.claim.function.__module__ for result in results)
    return _filled(
        "claims.md",
        results=results,
        twice=[(one, new, _paired(one, new)) for one, new in twice],
        again_seeds=again[0].seeds,
        stood=_stood(results, again),
        moved=[(one, new) for one, new in twice if one.verdict != new.verdict],
        counts=_counts(results),
        badges=BADGES,
        pairs=len({(scene.item, scene.ground) for scene in scenes}),
        items=len({scene.item for scene in scenes}),
        grounds=len({scene.ground for scene in scenes}),
        rule=RULE,
        made=made,
        changed=bool(shipped.changed(shipped.CLAIMED, made)),
        modules=list(modules),
        printed={one.claim.name: printed(one.claim, book) for one in results},
    )


def _counts(results: list[Result]) -> dict[str, int]:
    """How many claims have each verdict."""
    verdicts = [result.verdict for result in results]
    return {verdict: verdicts.count(verdict) for verdict in BADGES}


def _stood(results: list[Result], again: list[Result]) -> int:
    """How many of the supported claims are supported on other scenes, too."""
    pairs = zip(results, again, strict=True)
    return sum(one.verdict == new.verdict == SUPPORTED for one, new in pairs)


def _paired(result: Result, again: Result) -> list[tuple[Line, Line]]:
    """Each line of a claim, and the same on other scenes."""
    return list(zip(result.lines, again.lines, strict=True))


def printed(claim: Claim, book: Book) -> Markup:
    """Where the paper says it; the numbers of figures and tables lead to ours."""
    places = {
        FIGURES[name].number: f"{chapter.name}.html#{anchor(name)}"
        for chapter in book.chapters
        for name in chapter.figures
    }

    paper = claim.name.partition("-")[0]

    def linked(phrase: re.Match) -> str:
        kind, *numbers = re.split(r"(\d+)", phrase[0])
        title = kind.strip(" s").capitalize()
        named = (places.get(f"{title} {each} of [{paper}]") for each in numbers)
        pairs = zip(numbers, named, strict=True)
        return kind + "".join(_link(words, place) for words, place in pairs)

    words = str(escape(claim.printed))
    return Markup(re.sub(r"(?:figures?|Table) \d+(?: (?:and|to) \d+)*", linked, words))


def _link(words: str, place: str | None) -> str:
    return f'<a href="{place}">{words}</a>' if place else words


def forest(line: Line) -> dict[str, float] | None:
    """Where the bound, the dot and the ends of the interval of a line are drawn.

    From 0 to 1 across, the bound in the middle; None where nothing could be measured.
    """
    bound, numbers = line.part.bound, (line.low, line.value, line.high)
    if not np.isfinite(numbers).all():
        return None
    reach = max(*(abs(number - bound) for number in numbers), line.part.margin, 1e-12)
    low, value, high = (0.5 + 0.45 * (number - bound) / reach for number in numbers)
    return {"low": low, "value": value, "high": high}


_TEMPLATES.filters |= {"md": _markdown, "measured": measured, "forest": forest}


def leaderboard(boards: Iterable[ranks.Board]) -> str:
    """leaderboard.md: how well each tracker follows, and how sure that is."""
    return _filled(
        "leaderboard.md",
        boards=[_ranked(board) for board in boards],
        head=tables.HEAD,
    )


def after(boards: Iterable[ranks.Board]) -> str:
    """after.md: what came after these trackers, beside what real sequences say."""
    real = [_ranked(board) for board in boards if board.case == "source"]
    return _filled("after.md", boards=real, head=tables.HEAD)


def _ranked(board: ranks.Board) -> dict[str, Any]:
    """What the page needs to know of a board."""
    places = ranks.ranking(board)
    names, rows = tables.by_sequence(places)
    return {
        "title": board.title,
        "data": board.data,
        "extent": tables.extent(board),
        "overall": tables.overall(places),
        "legend": tables.legend(places),
        "dots": [(LABELS.get(place.name, place.name), place) for place in places],
        "case": CASES[board.case],
        "by_sequence": (list(map(_short, names)), rows),
        "refusals": tables.refusals(board.rows),
    }


def _short(name: str) -> str:
    """The name of a sequence, of BoBoT without what the title says already."""
    found = re.fullmatch(r"BoBoT/Vid_(\w+)", name)
    return found[1].replace("_", " ") if found else name


def tasks() -> str:
    """tasks.md: what one wants to do with the library, each in a few lines."""
    return (HERE / "templates" / "tasks.md").read_text(encoding="utf-8")


def track() -> str:
    """track.md: the page that follows what a camera or a video shows."""
    return (HERE / "templates" / "track.md").read_text(encoding="utf-8")


def modules() -> list[str]:
    """The names of all modules of the library, except that of the command line."""
    found = pkgutil.walk_packages(mkt.__path__, "mkt.")
    return ["mkt", *(info.name for info in found if info.name != "mkt.__main__")]


def library(names: Iterable[str]) -> str:
    """api/index.rst, the map of the library, and a line on each of these modules."""
    lines = [
        (name, ast.get_docstring(_tree(name)).partition("\n")[0]) for name in names
    ]
    groups = groupby(sorted(lines, key=_wing_of), key=_wing_of)
    wings = [(wing, list(group)) for wing, group in groups]
    return _filled("api/index.rst", wings=wings)


def _tree(module: str) -> ast.Module:
    """The parsed source of a module."""
    place = ROOT.joinpath(*module.split("."))
    files = place.with_suffix(".py"), place / "__init__.py"
    path = next(file for file in files if file.is_file())
    return ast.parse(path.read_text(encoding="utf-8"))


def _wing_of(line: tuple[str, str]) -> str:
    """The wing of a module, `mkt` itself for those of the method."""
    place = ROOT.joinpath(*line[0].split(".")[:2])
    return ".".join(place.relative_to(ROOT).parts) if place.is_dir() else "mkt"


def module(name: str) -> str:
    """api/NAME.rst, the reference of a module."""
    return _filled("api/module.rst", module=name)


def moved() -> dict[str, str]:
    """Pages under the old names of modules, {path in the site: text}.

    Both the reference and the source of a module lead on to the reference of the new
    one.
    """
    table = tomllib.loads((HERE / "moved.toml").read_text(encoding="utf-8"))
    pages = {}
    for old, new in table["modules"].items():
        target = f"{new}.html"
        pages[f"api/{old}.html"] = _filled("moved.html", old=old, new=new, to=target)
    for old, new in (table["modules"] | table["sources"]).items():
        up = "../" * (old.count(".") + 1)
        path = f"_modules/{old.replace('.', '/')}.html"
        pages[path] = _filled("moved.html", old=old, new=new, to=f"{up}api/{new}.html")
    return pages
