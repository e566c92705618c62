"""Remove what a session leaves in a notebook: outputs, counts, settings.

Run as a program this is a filter, which git calls for every notebook that it compares
(`mkt.course.commands.lab`).  It therefore needs the standard library alone: nbformat
takes seconds to be imported.
"""

import copy
import json
import sys
from typing import Any

# Of a cell's metadata; the rest is what a session left behind.
KEPT = ("tags", "nbgrader", "slideshow")
# What the book leaves out, JupyterLab folds: {tag: what a cell with it has}.
FOLDED = {
    "remove-input": {"source_hidden": True},
    "remove-cell": {"source_hidden": True, "outputs_hidden": True},
}
METADATA = {
    "kernelspec": {
        "display_name": "Python 3",
        "language": "python",
        "name": "python3",
    },
    "language_info": {"name": "python"},
}


def stripped(notebook: dict[str, Any]) -> dict[str, Any]:
    """A copy of a notebook, as read from JSON, without what a session leaves."""
    clean = copy.deepcopy(notebook)
    for cell in clean["cells"]:
        metadata = cell["metadata"]
        for key in set(metadata).difference(KEPT):
            del metadata[key]
        for tag, folded in FOLDED.items():
            if tag in metadata.get("tags", ()):
                metadata["jupyter"] = dict(folded)
        if cell["cell_type"] == "code":
            cell.update(outputs=[], execution_count=None)
    clean["metadata"].clear()
    clean["metadata"].update(copy.deepcopy(METADATA))
    return clean


def main() -> None:
    """From standard input to standard output, in nbformat's canonical form."""
    notebook = json.loads(sys.stdin.buffer.read().decode("utf-8"))
    text = json.dumps(stripped(notebook), indent=1, sort_keys=True, ensure_ascii=False)
    sys.stdout.buffer.write(f"{text}\n".encode())


if __name__ == "__main__":
    main()
