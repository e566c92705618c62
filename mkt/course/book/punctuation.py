"""Formulas keep the signs that stand beside them: no line begins with a full stop."""

import re

BESIDE = re.compile(
    r"([(\[]?)(<svg\b[^>]*mkt-math[^>]*>.*?</svg>)([.,;:?!)\]’]*)", re.DOTALL
)


def with_signs(page: str) -> str:
    """A page (HTML) in which no line parts a formula from the signs right beside it."""
    return BESIDE.sub(_in_one_piece, page)


def _in_one_piece(found: re.Match[str]) -> str:
    before, formula, after = found.groups()
    whole = f'<span class="mkt-whole">{found[0]}</span>'
    return whole if before or after else formula
