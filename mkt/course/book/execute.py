"""Run the chapters: two kernels at a time, with a time limit for each.

The outputs of a chapter are kept under all that its code depends on, so a chapter whose
text alone has changed is not run again: its outputs are put under the new text, cell by
cell.  Cells that the page leaves out are not run here.

Reading order: `execute_all`, `run`.
"""

import asyncio
import re
import sys
import time
from collections.abc import Callable, Iterable
from typing import Any

import nbformat
from nbclient.exceptions import CellExecutionError, DeadKernelError
from nbformat import NotebookNode
from tqdm import tqdm

from mkt.course.book import client, depends
from mkt.course.book.checks import LEFT_OUT, code_cells, on_page, read, strip
from mkt.course.book.contents import BookError, Chapter
from mkt.experiments.cache import Shelf


def _as_bytes(notebook: NotebookNode) -> bytes:
    return nbformat.writes(notebook).encode()


def _from_bytes(data: bytes) -> NotebookNode:
    return nbformat.reads(data.decode(), 4)


# For the kernel: pictures as sharp as a present-day screen shows them.
ARGUMENTS = ["--InlineBackend.figure_formats={'retina'}"]
CHAPTERS = Shelf("chapters", ".ipynb", _as_bytes, _from_bytes)


def execute_all(chapters: Iterable[Chapter]) -> dict[str, NotebookNode]:
    """Execute every chapter whose outputs are not known, and say how long each took.

    Returns
    -------
    dict
        Name of the chapter -> its executed notebook.

    Raises
    ------
    BookError
        With the troubles of all chapters that failed; the others' outputs are kept.
    """
    chapters = list(chapters)
    stored = {c.name: strip(read(c.notebook)) for c in chapters}
    keys = {name: depends.of_chapter(n, ARGUMENTS) for name, n in stored.items()}
    outputs = {name: CHAPTERS.get(key) for name, key in keys.items()}
    missing = [chapter for chapter in chapters if outputs[chapter.name] is None]
    if missing:
        outputs |= asyncio.run(_run_all(missing, stored, keys))
    return {name: with_outputs(stored[name], outputs[name]) for name in stored}


def with_outputs(notebook: NotebookNode, executed: NotebookNode) -> NotebookNode:
    """A stripped notebook with the outputs of another one that has the same code."""
    filled = strip(notebook)
    outputs = {cell.id: cell for cell in code_cells(executed)}
    for cell in on_page(filled):
        cell.outputs = outputs[cell.id].outputs
        cell.execution_count = outputs[cell.id].execution_count
    filled.metadata = executed.metadata
    return filled


async def _run_all(
    chapters: list[Chapter], stored: dict[str, NotebookNode], keys: dict[str, str]
) -> dict[str, NotebookNode]:
    """The executed notebooks of some chapters; raises BookError with all troubles."""
    gate = asyncio.Semaphore(client.KERNELS)
    cells = sum(len(on_page(stored[chapter.name])) for chapter in chapters)
    with tqdm(total=cells, desc="notebooks", unit="cell", disable=None) as bar:

        async def one(chapter):
            async with gate:
                start = time.monotonic()
                notebook = await run(chapter, bar.update)
            seconds = time.monotonic() - start
            tqdm.write(f"{chapter.name}: {seconds:.1f} s", file=sys.stderr)
            CHAPTERS.put(keys[chapter.name], notebook)
            return notebook

        results = await asyncio.gather(*map(one, chapters), return_exceptions=True)
    names = [chapter.name for chapter in chapters]
    return dict(zip(names, _sound(results), strict=True))


def _sound(results: list[NotebookNode | BaseException]) -> list[NotebookNode]:
    """The results, if there are no errors.

    Raises an error that nobody expected, or else all troubles of the book in one.
    """
    errors = [result for result in results if isinstance(result, BaseException)]
    for error in errors:
        if not isinstance(error, BookError):
            raise error
    if errors:
        raise BookError("\n\n".join(map(str, errors)))
    return [result for result in results if isinstance(result, NotebookNode)]


async def run(
    chapter: Chapter, on_cell: Callable[[], Any] = lambda: None
) -> NotebookNode:
    """Execute one chapter as the book's readers see it.

    Parameters
    ----------
    chapter : Chapter
    on_cell : callable
        Called after each code cell.

    Raises
    ------
    BookError
        Naming notebook, cell and traceback.
    """
    notebook = strip(read(chapter.notebook))
    begun: list[NotebookNode] = []
    limit = asyncio.timeout(chapter.timeout)
    running = client.Client(
        notebook,
        config=client.config(),
        timeout=None,
        record_timing=False,
        skip_cells_with_tag=LEFT_OUT,
        coalesce_streams=True,  # lines printed one after the other are one output
        shutdown_kernel="immediate",
        resources={"metadata": {"path": str(chapter.notebook.parent)}},
        extra_arguments=ARGUMENTS,
        on_cell_start=lambda cell, cell_index: begun.append(cell),
        on_cell_executed=lambda **_: on_cell(),
    )
    try:
        async with limit:
            await running.async_execute(env=client.environment())
    except (RuntimeError, CellExecutionError, DeadKernelError, TimeoutError) as error:
        reason = _reason(error, chapter, limit)
        raise BookError(f"{chapter.notebook.name}, {_place(begun)}{reason}") from None
    # nbclient needs the state of widgets while it runs; a page without a kernel has no
    # use for it.
    notebook.metadata.pop("widgets", None)
    return notebook


def _place(begun: list[NotebookNode]) -> str:
    """The cell that was begun last, with its source."""
    if not begun:
        return ""
    return f"cell {begun[-1].id}:\n\n{begun[-1].source}\n\n"


def _reason(error: Exception, chapter: Chapter, limit: asyncio.Timeout) -> str:
    if limit.expired():
        # nbclient takes the cancelled wait for a dead kernel, so the error does not
        # tell.
        return (
            f"not finished after {chapter.timeout:g} s, "
            "the timeout of the chapter in book.toml"
        )
    if isinstance(error, DeadKernelError):
        return "the kernel died, perhaps for want of memory"
    return re.sub(r"\x1b\[[0-9;]*m", "", getattr(error, "traceback", str(error)))
