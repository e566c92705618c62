"""The pages around the chapters: first page, gallery, claims, leaderboard, library reference, Sphinx's configuration.

Each public function returns the text of one file.
"""

import html
import importlib
import pkgutil

import mkt
from mkt import figures
from mkt.claims import BACKGROUNDS, FAILS, HOLDS, IN_PART, OBJECTS, RULE, SEEDS
from mkt.claims.listing import measured
from mkt.leaderboard import as_markdown
from mkt.page import FILES

EXTENSIONS = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "mkt.book.math_svg", "mkt.book.accessibility", "mkt.book.docstrings"]
ACCENT = {"light": "#0b6e99", "dark": "#5cc0ea"}
BADGES = {HOLDS: ("holds", "✓"), IN_PART: ("part", "◐"), FAILS: ("fails", "✗")}  # class and sign beside the words

PAPERS = mkt.__doc__.partition("----------\n")[2].strip()


def configuration(book):
    """conf.py."""
    settings = {
        "project": book.title, "html_title": book.title, "extensions": EXTENSIONS, "default_role": "py:obj",
        "nb_execution_mode": "off", "nb_ipywidgets_js": {}, "nb_render_markdown_format": "myst",
        "myst_enable_extensions": ["dollarmath", "amsmath", "deflist"], "myst_heading_anchors": 3, "html_math_renderer": "svg",
        "autodoc_default_options": {"members": True, "member-order": "bysource"}, "autodoc_preserve_defaults": True,
        "html_theme": "furo", "html_static_path": ["_static"], "html_css_files": ["mkt.css"], "html_show_copyright": False,
        "html_copy_source": False, "html_show_search_summary": False, "html_show_sourcelink": False,
        "pygments_style": "a11y-light", "pygments_dark_style": "github-dark",
        "html_theme_options": {f"{mode}_css_variables": {"color-brand-primary": color, "color-brand-content": color}
                               for mode, color in ACCENT.items()},
    }
    return "".join(f"{name} = {value!r}\n" for name, value in settings.items())


def first(book):
    """index.md: what the book is, its cover figure, its chapters."""
    where = next(chapter for chapter in book.chapters if book.cover in chapter.figures)
    entry = figures.get(book.cover)
    chapters = "\n".join(f'<li><a href="{c.name}.html">{html.escape(c.title)}</a><span>{html.escape(c.summary)}</span></li>'
                         for c in book.chapters)
    return f"""# {book.title}

{book.description}

```{{raw}} html
<a class="mkt-cover" href="{where.name}.html#{anchor(book.cover)}">
<img src="{FILES}/{book.cover}.webp" alt="{html.escape(entry.title)}"></a>
<p class="mkt-legend">Figure 3 of [T09]: one kernel cannot feel a rotation, nine can. <a href="{where.name}.html#{anchor(book.cover)}">Move its sliders.</a></p>
<h2>Chapters</h2>
<ol class="mkt-chapters">
{chapters}
</ol>
```

## The papers

{PAPERS}

## How to use it

Here, a slider moves one parameter at a time, or two where a frame is round them. To move all together, to change the code and to do the exercises,
run the chapters yourself:

```
python3 -m mkt lab
```

Every figure is one function of the library, and the [gallery](gallery.md) leads to all of them; under each are a PDF of it and a table of its curves. What the papers say in words is put to the
test on the page of their [claims](claims.md), and the [leaderboard](leaderboard.md) has all trackers on all sequences. Letters are explained on the
[symbols](symbols.md) page, functions in the [library](api/index.rst).

```{{toctree}}
:hidden:
:caption: Chapters

{chr(10).join(chapter.name for chapter in book.chapters)}
```

```{{toctree}}
:hidden:
:caption: Reference

gallery
claims
leaderboard
symbols
api/index
```
"""


def gallery(book):
    """gallery.md: every registered figure, by paper, with links to its chapter and to its source."""
    chapter_of = {id: chapter for chapter in book.chapters for id in chapter.figures}
    papers = {}
    for entry in figures.registry().values():
        papers.setdefault(entry.function.__module__, []).append(_card(entry, chapter_of[entry.id]))
    head = "# Gallery\n\nAll figures of the book. A picture leads to its sliders, *source* to the function that draws it.\n"
    sections = [f"## {_headline(module)}\n\n```{{raw}} html\n<div class=\"mkt-gallery\">\n{''.join(cards)}</div>\n```\n"
                for module, cards in papers.items()]
    return "\n".join([head, *sections])


def _card(entry, chapter):
    page, title = f"{chapter.name}.html", html.escape(entry.title.rstrip("."))
    return (f'<div class="mkt-card"><p><a href="{page}#{anchor(entry.id)}"><img loading="lazy" src="{FILES}/{entry.id}.webp" alt="">{title}</a></p>'
            f'<p><code>{entry.id}</code> · <a href="{page}">{html.escape(chapter.title)}</a> · '
            f'<a href="{_source(entry)}">source</a></p></div>\n')


def _source(entry):
    return f"_modules/{entry.function.__module__.replace('.', '/')}.html#{entry.function.__name__}"


def _headline(module):
    return importlib.import_module(module).__doc__.split("\n")[0].rstrip(".")


def claims(results):
    """claims.md: every judged claim with its numbers and its verdict.  results: list of `mkt.claims.Result`."""
    count = " · ".join(f"{_badge(verdict)} {sum(r.verdict == verdict for r in results)}" for verdict in BADGES)
    return f"""# Claims

What the papers say in words, put to the test here, in our words and on our scenes: every tracker on {results[0].seeds} sequences of each scenario, with the objects
{", ".join(OBJECTS)} before {", ".join(BACKGROUNDS)}. Two trackers are compared on the same sequences, run by run. A claim that does not hold here
may still hold on the papers' own sequences, which are not public; it is printed as it came out.

```{{note}}
The rule was laid down before the runs, and so were the bounds. {RULE} What equals its bound, or could not be measured, does not hold.
```

```{{raw}} html
<p>{count}</p>
<div class="mkt-scroll"><table class="mkt-claims">
<thead><tr><th>measured here</th><th>claimed</th><th>value [95 % interval]</th><th>verdict</th></tr></thead>
{"".join(map(_claim, results))}</table></div>
```

`python3 -m mkt claims` prints this table with more sequences ({SEEDS}, or as many as `--seeds` says), and `-o claims.csv` writes it into a file. The claims and their bounds
are the functions of {", ".join(f"[`{name}`](api/{name}.rst)" for name in dict.fromkeys(r.claim.function.__module__ for r in results))}.
"""


def _claim(result):
    claim = result.claim
    about = html.escape(f"In the paper: {claim.printed}. {claim.remark}".strip())
    lines = "".join(f"<tr><td>{html.escape(line.text)}</td><td>{html.escape(line.condition)}</td><td>{html.escape(measured(line))}</td>"
                    f"<td>{html.escape(line.verdict)}</td></tr>\n" for line in result.lines)
    return (f'<tbody id="{claim.id}"><tr class="mkt-claim"><th colspan="3" scope="rowgroup"><code>{claim.id}</code> {html.escape(claim.sentence)}'
            f"<span>{about}</span></th><td>{_badge(result.verdict)}</td></tr>\n{lines}</tbody>\n")


def _badge(verdict):
    name, sign = BADGES[verdict]
    return f'<span class="mkt-verdict mkt-{name}">{sign} {verdict}</span>'


def leaderboard(boards):
    """leaderboard.md: how well each tracker follows, and how sure that is.  boards: list of `mkt.leaderboard.Board`."""
    tables = "\n\n".join(map(as_markdown, boards))
    return f"""# Leaderboard

All trackers of the library under one protocol: told where the target is in the first frame, with one setting for all sequences. The table on
synthetic data was run when this book was built, with few seeds. A table on the real sequences of a benchmark follows where they were on the
disk, and `python3 -m mkt bench tracking` had been run; `python3 -m mkt data` says which benchmarks can be used and how to get them.

{tables}
"""


def anchor(id):
    """The HTML id under which a figure is found on its chapter's page."""
    return "fig-" + id.replace(".", "-")


def modules():
    """The names of all modules of the library, those under construction by Sphinx and the command line's door left out."""
    return ["mkt", *(info.name for info in pkgutil.walk_packages(mkt.__path__, "mkt.") if info.name != "mkt.__main__")]


def library(names):
    """api/index.rst, the map of the library."""
    entries = "\n".join(f"   {name}" for name in names[1:])
    return f"Library\n=======\n\n.. automodule:: mkt\n\n.. toctree::\n   :maxdepth: 1\n\n{entries}\n"


def module(name):
    """api/NAME.rst, one module's reference."""
    return f"{name}\n{'=' * len(name)}\n\n.. automodule:: {name}\n"
