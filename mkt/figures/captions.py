"""What stands below a figure and beside its sliders, in the words of a page."""

import html
import re
from typing import Any

from mkt.figures.registry import Entry


def caption(entry: Entry, live: bool = False) -> str:
    """Title and caption as HTML; of the figure that computes in the page if it does."""
    words = entry.live_caption if live else entry.caption
    number = f"{entry.number}: " if entry.number else ""
    return f"<b>{marked(number + entry.title)}</b> {marked(words)}"


def marked(words: str) -> str:
    """Words as HTML, with what stands behind a letter and "_" or "^" below or above."""
    below = re.sub(r"\b([A-Za-z])_(\w+?)\b", r"\1<sub>\2</sub>", html.escape(words))
    return re.sub(r"\^(\d)", r"<sup>\1</sup>", below)


def label(value: Any) -> str:
    """A value as a slider shows it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
