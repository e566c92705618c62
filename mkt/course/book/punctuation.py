"""What no line may part: formulas and their signs, numbers and their units."""

import re

BESIDE = re.compile(
    r"([(\[]?)(<svg\b[^>]*mkt-math[^>]*>.*?</svg>)([.,;:?!)\]’]*)", re.DOTALL
)
# Code is copied as it stands, and what is in a tag is no text.
UNIT = re.compile(
    r"<(pre|code|script|style|svg|textarea)\b.*?</\1>|<[^>]*>"
    r"|(\d) (%|px|cm|mm|ms|kB|MB|[ms])(?!\w)",
    re.DOTALL,
)


def with_signs(page: str) -> str:
    """A page (HTML) in which no line parts a formula from the signs right beside it."""
    return BESIDE.sub(_in_one_piece, page)


def _in_one_piece(found: re.Match[str]) -> str:
    before, formula, after = found.groups()
    whole = f'<span class="mkt-whole">{found[0]}</span>'
    return whole if before or after else formula


def with_units(page: str) -> str:
    """A page (HTML) in which no line parts a number from its unit."""
    return UNIT.sub(_unparted, page)


def _unparted(found: re.Match[str]) -> str:
    number, unit = found.group(2, 3)
    return f"{number}\N{NO-BREAK SPACE}{unit}" if unit else found[0]
