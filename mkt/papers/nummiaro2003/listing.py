"""Figure 1 of [N03]: the box of its filter, and the lines that do it.

It stands in a file of its own because it prints source code as it stands: what is drawn
again after another comment (`mkt.course.book.depends`) is what can reach this file.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mkt.figures.registry import Shown, figure, shown
from mkt.histograms import coefficient, mixed_histograms
from mkt.papers.nummiaro2003.steps import PLAIN
from mkt.particles import (
    EllipseMotion,
    independent_positions,
    multinomial,
    normalised,
    search,
)
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.ellipses import Disc

# The printed box, step by step, and what does it here.
STEPS: dict[str, tuple[list[str], tuple[Callable, ...]]] = {
    "1  select": (
        [
            "draw $N$ samples",
            "with replacement:",
            "$c^{(n)} = c^{(n-1)} + \\pi^{(n)}$,",
            "$c' = c\\,/\\,c^{(N)}$,",
            "$r$ uniform in [0, 1],",
            "smallest $j$ with $c'^{(j)} \\geq r$:",
            "binary search",
        ],
        (Adaptive.select, multinomial, independent_positions, search),
    ),
    "2  propagate": (
        ["$s_t^{(n)} = A\\, s'^{(n)}_{t-1} + w^{(n)}_{t-1}$,   (9)"],
        (Adaptive.propagate, EllipseMotion.predict),
    ),
    "3  observe, a and b": (
        [
            "$p^{(u)} = f\\, \\sum_i k(\\|s - x_i\\| / a)$",
            "$\\qquad \\cdot\\; \\delta[h(x_i) - u]$,   (3)",
            "$\\rho = \\sum_u \\sqrt{p^{(u)} q^{(u)}}$,   (6)",
        ],
        (Adaptive.observe, Disc.histograms, mixed_histograms, coefficient),
    ),
    "3  observe, c": (
        ["$\\pi^{(n)} \\propto \\exp(-(1 - \\rho)\\, /\\, 2 \\sigma^2)$,   (10)"],
        (Adaptive.weigh, normalised),
    ),
    "4  estimate": (
        ["$E[S_t] = \\sum_n \\pi^{(n)} s^{(n)}$,   (1)"],
        (Adaptive.estimate,),
    ),
    "then learn (not in the box)": (
        [
            "if $\\pi_{E[S]} > \\pi_T$,   (11):",
            "$q \\leftarrow (1 - \\alpha)\\, q + \\alpha\\, p_{E[S]}$,   (12)",
        ],
        (Adaptive.updated,),
    ),
}
LINE = 0.15  # [inch] from one line of the listing to the next
FORMULA = 0.3  # [inch] from one formula to the next
CODE = 0.25  # where the listing begins, as a share of the width


def listing(function: Callable) -> list[str]:
    """The lines of a function's source, without its docstring."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    definition = ast.parse("\n".join(lines)).body[0]
    first = definition.body[0]  # type: ignore[attr-defined]
    if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
        return lines[: first.lineno - 1] + lines[first.end_lineno :]
    return lines


@figure("nummiaro2003.fig1", size=(10, 17.0))
def fig1(fig: Figure) -> Shown:
    """One iteration of the colour particle filter, and the lines that do it.

    At the left the steps of the printed box, at the right our source, read from the
    installed files when the figure is drawn, without its docstrings; in grey the module
    of each function.  What differs from the box: the weights are made to sum to 1
    before the mean is taken, which the box does not say and (1) needs; the factor in
    front of (10) drops out.  And a draw that is exactly a cumulative weight takes the
    next sample, so that one of weight 0 is never drawn.
    """
    bottom = 1 - 0.35 / fig.get_figheight()
    fig.text(0.01, bottom, "the box of Figure 1", fontweight="bold")
    fig.text(CODE, bottom, "its lines in mkt", fontweight="bold")
    for step, (formulas, functions) in STEPS.items():
        height = _draw_step(fig, bottom, step, formulas, functions)
        bottom -= height
    table = _listed()
    return shown(table, lines=len(table), left=bottom)


def _draw_step(
    fig: Figure,
    top: float,
    step: str,
    formulas: list[str],
    functions: tuple[Callable, ...],
) -> float:
    """A step of the box beside its lines, below `top`; returns how high it is."""
    inch = 1 / fig.get_figheight()
    edge = top - 0.1 * inch
    fig.add_artist(Line2D((0.01, 0.99), (edge, edge), color="0.8", lw=0.8))
    y = edge - 0.2 * inch
    fig.text(0.01, y, step, fontsize=9.5, color=PLAIN, fontweight="bold")
    for k, formula in enumerate(formulas, 1):
        fig.text(0.025, edge - (0.2 + FORMULA * k) * inch, formula, fontsize=9.5)
    height = 0.08
    code = {"family": "monospace", "fontsize": 9.5, "va": "top"}
    for function in functions:
        lines = listing(function)
        y = edge - height * inch
        fig.text(CODE, y, f"# {function.__module__}", color="0.45", **code)
        fig.text(CODE, y - LINE * inch, "\n".join(lines), linespacing=1.15, **code)
        height += LINE * (len(lines) + 1) + 0.09
    return (0.1 + max(height, 0.3 + FORMULA * len(formulas))) * inch


def _listed() -> pd.DataFrame:
    """Every line of the listing, with its step and its function."""
    blocks = [
        {"step": step, "function": function.__qualname__, "line": listing(function)}
        for step, (_, functions) in STEPS.items()
        for function in functions
    ]
    return pd.DataFrame(blocks).explode("line", ignore_index=True)
