"""Slides for a meeting on a chapter, made of the chapter itself.

The question, the goals, the equations, "predict before you move" with its figure and
its answer, and the takeaways: there is no second copy of a sentence.  There is one HTML
file for each chapter, which needs neither network nor JavaScript to be printed.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import jinja2
from markdown_it import MarkdownIt
from markupsafe import Markup
from mdit_py_plugins.dollarmath import dollarmath_plugin
from nbformat import NotebookNode
from tqdm import tqdm

from mkt.course.book.checks import read
from mkt.course.book.contents import Book, Chapter
from mkt.course.book.math_svg import svg
from mkt.figures.pictures import data_uri
from mkt.figures.registry import FIGURES
from mkt.figures.static_panel import encoded
from mkt.files import whole

DPI = 150
SMALL = cv2.IMWRITE_PNG_COMPRESSION, 9  # a tenth less than matplotlib's own PNG
SHOWN = re.compile(r'mkt\.(?:show|explore)\("([\w.]+)"')
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
QUESTION = re.compile(r"^\*\*The question:\*\* (.+(?:\n.+)*)", re.MULTILINE)
ANSWER = re.compile(r"<details>.*?</details>", re.DOTALL)
SUMMARY = re.compile(r"</?details>|<summary>.*?</summary>")
EQUATION = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
BULLETS = re.compile(r"^\* .+(?:\n(?!\n).+)*", re.MULTILINE)
TO_NOTEBOOK = re.compile(r"\[([^\]]+)\]\([^)\s]*\.ipynb[^)]*\)")
_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
)


class Slide(NamedTuple):
    """One slide.

    Attributes
    ----------
    kind : str
        "title", "text", "equation" or "figure".
    title : str
        In Markdown, in one line.
    text : str
        In Markdown.
    figure : str
        The name of a registered figure, "" without one.
    """

    kind: str
    title: str
    text: str
    figure: str = ""


def slides(chapter: Chapter) -> list[Slide]:
    """The slides of a chapter, in the order of its cells."""
    cells = read(chapter.notebook).cells
    opening = next(cell.source for cell in cells if cell.id == "opening")
    question = QUESTION.findall(opening)
    return [
        Slide("title", _heading(cells[0]), chapter.summary),
        Slide("text", "The question", question[0][:1].upper() + question[0][1:]),
        Slide("text", "Afterwards you can", _bullets(opening)),
        *_body(cells[1:]),
        Slide("text", "Takeaways", _bullets(_section(cells, "Takeaways"))),
    ]


def _heading(cell: NotebookNode) -> str:
    return HEADING.findall(cell.source)[0]


def _bullets(text: str) -> str:
    return "\n".join(BULLETS.findall(text))


def _section(cells: Sequence[NotebookNode], heading: str) -> str:
    """What stands below a heading, up to the end of its cell."""
    found = (cell.source for cell in cells if f"# {heading}" in cell.source)
    return next(found, "").partition(f"# {heading}")[2]


def _body(cells: Sequence[NotebookNode]) -> Iterator[Slide]:
    """Equations, predictions, figures and answers, as they come."""
    above = ""
    answers = ""
    drawn = set()
    for cell in cells:
        if cell.cell_type == "markdown":
            yield from _equations(cell.source, above)
            headings = HEADING.findall(cell.source)
            above = [above, *headings][-1]
            if headings and above.startswith("Predict"):
                below = cell.source.partition(f"# {above}")[2]
                yield Slide("text", above, ANSWER.sub("", below).strip())
                answers = _answers(cell.source)
            continue
        for name in dict.fromkeys(SHOWN.findall(cell.source)):
            if name not in drawn:
                drawn.add(name)
                yield Slide("figure", FIGURES[name].title, "", name)
                if answers:
                    yield Slide("text", "What you should have seen", answers)
                    answers = ""


def _answers(text: str) -> str:
    """The folded answers of a cell, one bullet each."""
    plain = [SUMMARY.sub("", found).strip() for found in ANSWER.findall(text)]
    return "\n".join("* " + one.replace("\n", "\n  ") for one in plain)


def _equations(text: str, above: str) -> Iterator[Slide]:
    """The formulas of a cell that have a line of their own, on one slide."""
    text = ANSWER.sub("", text)
    found = [formula[0] for formula in EQUATION.finditer(text)]
    if found and "# Exercises" not in text:
        before = text.partition(found[0])[0]
        heading = [above, *HEADING.findall(before)][-1]
        yield Slide("equation", heading, "\n\n".join(found))


def page(book: Book, chapter: Chapter) -> str:
    """The slides of a chapter as HTML that needs no other file."""
    return _TEMPLATES.get_template("slides.html").render(
        book=book,
        chapter=chapter,
        slides=[
            {
                "kind": slide.kind,
                "title": _html(slide.title, inline=True),
                "text": _html(slide.text),
                "picture": _picture(slide.figure),
                "alt": slide.title,
            }
            for slide in slides(chapter)
        ],
    )


def _html(text: str, *, inline: bool = False) -> Markup:
    """Markdown of a chapter as HTML; links between notebooks lead nowhere here."""
    markdown = MarkdownIt("commonmark", {"html": False})
    markdown.use(dollarmath_plugin, renderer=_formula)
    text = TO_NOTEBOOK.sub(r"\1", text)
    render = markdown.renderInline if inline else markdown.render
    return Markup(render(text))


def _formula(tex: str, options: dict[str, Any]) -> str:
    return svg(tex.strip(), inline=not options.get("display_mode"))


def _picture(name: str) -> str:
    """A figure with its defaults, as the address of a picture; "" for no name."""
    if not name:
        return ""
    fig, _ = FIGURES[name].draw(DPI)
    return data_uri("image/png", encoded(fig, ".png", *SMALL))


def chosen(book: Book, numbers: Sequence[int]) -> list[Chapter]:
    """The chapters with these numbers, or those that open a part.

    Raises
    ------
    ValueError
        For a number that no chapter has.
    """
    chapters = {int(chapter.name[:2]): chapter for chapter in book.chapters}
    unknown = [str(number) for number in numbers if number not in chapters]
    if unknown:
        raise ValueError(
            f"there is no chapter {unknown[0]}; give numbers from 1 to {max(chapters)}"
        )
    opening = [part[0] for part in book.parts.values()]
    return [chapters[number] for number in numbers] or opening


def write(book: Book, chapters: Sequence[Chapter], folder: Path) -> list[Path]:
    """Write the slides of chapters into a folder, NAME.html for each.

    Raises
    ------
    ValueError
        Where a file is in the way.
    OSError
    """
    paths = [folder / f"{chapter.name}.html" for chapter in chapters]
    for path in paths:
        if path.exists():
            raise ValueError(f"{path} is there already; choose another folder")
    folder.mkdir(parents=True, exist_ok=True)
    pairs = list(zip(chapters, paths, strict=True))
    for chapter, path in tqdm(pairs, desc="chapters", disable=None):
        with whole(path) as half:
            half.write_text(page(book, chapter), encoding="utf-8")
    return paths
