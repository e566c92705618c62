"""Run cells in a kernel whatever they do.

That may be errors, endless loops, endless output, the end of the kernel itself.  What
comes back is one sentence for each cell that failed; for a check it is the words of its
assertion.
"""

import asyncio
import copy
import re
import tempfile
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from typing import Any

import nbformat
from nbclient.exceptions import CellExecutionError, DeadKernelError
from nbformat import NotebookNode

from mkt.course.book.client import Client, config, environment
from mkt.course.labs.notebooks import name

UNWRITTEN = "not written yet"
NOT_RUN = "not run: "
DIED = "the kernel died, perhaps for want of memory, or a cell ended it (exit)"
# [s] for a cell that was interrupted to end; then its kernel is given up.
PATIENCE = 10


class _Deaf(Client):
    """A client that keeps no output, of which a loop can print a gigabyte."""

    def output(self, outs, msg, display_id, cell_index):
        """Nothing is kept."""


@asynccontextmanager
async def kernel(limit: float = 60) -> AsyncIterator[Client]:
    """A fresh kernel in an empty folder of its own, as a client for `run`.

    Parameters
    ----------
    limit : float [s]
        What a cell may take.
    """
    with tempfile.TemporaryDirectory(
        prefix="mkt-lab-", ignore_cleanup_errors=True
    ) as folder:
        client = _Deaf(
            nbformat.v4.new_notebook(),
            config=config(),
            timeout=limit,
            interrupt_on_timeout=True,
            record_timing=False,
            shutdown_kernel="immediate",
            on_cell_executed=_heed_exit,
            resources={"metadata": {"path": folder}},
        )
        async with client.async_setup_kernel(env=environment() | {"MKT_STATIC": "0"}):
            yield client


async def _heed_exit(execute_reply: dict[str, Any], **_: Any) -> None:
    """End the kernel here where the cell called `exit()`.

    By itself it ends a moment after its cell, in the midst of the next one.
    """
    payload = execute_reply["content"].get("payload", [])
    if any(item["source"] == "ask_exit" for item in payload):
        raise DeadKernelError("exit")


async def run(client: Client, cells: Iterable[NotebookNode]) -> dict[str, str]:
    """Execute the code cells one after the other, whatever becomes of them.

    Parameters
    ----------
    client : Client
        Of `kernel`; it keeps what earlier calls defined.
    cells : iterable of NotebookNode

    Returns
    -------
    dict
        Name of each cell that failed -> what went wrong, in words.
    """
    failures = {}
    ended = ""
    client.nb = nbformat.v4.new_notebook(cells=copy.deepcopy(list(cells)))
    for index, cell in enumerate(client.nb.cells):
        if cell.cell_type != "code":
            continue
        if ended:
            failures[name(cell)] = ended
        else:
            failures[name(cell)], ended = await _one(client, cell, index)
    return {cell: words for cell, words in failures.items() if words}


async def _one(client: Client, cell: NotebookNode, index: int) -> tuple[str, str]:
    """Execute one cell.

    Returns what went wrong, and what the cells after it have to be told; both are "" if
    all is well.
    """
    limit = float(client.timeout or 0)
    over = asyncio.timeout(limit + PATIENCE)
    try:
        async with over:
            await client.async_execute_cell(cell, index)
    except CellExecutionError as error:
        return _words(error, limit), ""
    except (DeadKernelError, TimeoutError):
        task = asyncio.current_task()
        if task and task.cancelling():
            # Ctrl-C, which nbclient takes for a dead kernel.
            raise asyncio.CancelledError from None
        reason = DIED
        if over.expired():
            reason = f"not finished after {limit:g} s, and could not be interrupted"
        return reason, f"{NOT_RUN}{name(cell)} ended the kernel"
    return "", ""


def _words(error: CellExecutionError, limit: float) -> str:
    """What a student is told of an error."""
    if error.ename == "AssertionError":
        return error.evalue or "the assertion is false"
    if error.ename == "NotImplementedError":
        return UNWRITTEN
    if error.ename == "KeyboardInterrupt":
        return f"not finished after {limit:g} s: is there a loop that never ends?"
    return f"stops with {error.ename}: {re.sub(r'[(][^()]*[.]py, ', '(', error.evalue)}"
