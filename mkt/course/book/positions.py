"""The pictures that a slider of a chapter's page chooses among, as files of the site.

The gallery plays those of a figure's first slider, so that nothing more has to be
drawn.
"""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from nbformat import NotebookNode

from mkt.course.book import checks, lighter

DATA = re.compile(r'class="mkt-data">(.*?)</script>', re.DOTALL)


def of_first_sliders(notebooks: Mapping[str, NotebookNode]) -> dict[str, list[str]]:
    """{figure: addresses from the top of the site} in the order of the positions.

    Those of executed chapters; figures without drawn positions are left out.
    """
    return {
        panel["file"]: _addresses(panel)
        for notebook in notebooks.values()
        for panel in _panels(notebook)
        if panel["groups"]
    }


def _panels(notebook: NotebookNode) -> Iterator[dict[str, Any]]:
    """The data of each panel that a chapter shows."""
    for cell in checks.code_cells(notebook):
        for output in cell.outputs:
            text = output.get("data", {}).get("text/html", "")
            yield from map(json.loads, DATA.findall(text))


def _addresses(panel: dict[str, Any]) -> list[str]:
    """The pictures of a panel's first slider, without the one that stands there."""
    frames = [panel["frames"][k] for k in panel["groups"][0]["frames"]]
    return [lighter.address(frame) for frame in frames if frame]
