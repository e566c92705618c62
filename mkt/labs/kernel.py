"""Run cells in a kernel whatever they do: errors, endless loops, endless output, the end of the kernel itself.

What comes back is one sentence for each cell that failed; for a check the words of its assertion.
"""

import asyncio
import copy
import re
import tempfile
from contextlib import asynccontextmanager

import nbformat
from nbclient.exceptions import CellExecutionError, DeadKernelError

from mkt.book import execute
from mkt.labs.notebooks import name

UNWRITTEN, NOT_RUN = "not written yet", "not run: "
DIED = "the kernel died, perhaps for want of memory, or a cell ended it (exit)"
PATIENCE = 10  # [s] for a cell that was interrupted to end; then its kernel is given up


class _Deaf(execute.Client):
    """A client that keeps no output, of which a loop can print a gigabyte."""

    def output(self, outs, msg, display_id, cell_index):
        """Nothing is kept."""


@asynccontextmanager
async def kernel(limit=60):
    """A fresh kernel in an empty folder of its own, as a client for `run`; limit: seconds a cell may take."""
    with tempfile.TemporaryDirectory(prefix="mkt-lab-", ignore_cleanup_errors=True) as folder:
        client = _Deaf(nbformat.v4.new_notebook(), config=execute.config(), timeout=limit, interrupt_on_timeout=True, record_timing=False,
                       shutdown_kernel="immediate", on_cell_executed=_heed_exit, resources={"metadata": {"path": folder}})
        async with client.async_setup_kernel(env=execute.environment() | {"MKT_STATIC": "0"}):
            yield client


async def _heed_exit(execute_reply, **_):
    """`exit()` ends the kernel a moment after its cell, in the midst of the next one: end it here, where it was asked for."""
    if any(item["source"] == "ask_exit" for item in execute_reply["content"].get("payload", [])):
        raise DeadKernelError("exit")


async def run(client, cells):
    """Execute the code cells one after the other, whatever becomes of them.

    client: from `kernel`, which keeps what earlier calls defined.  Returns {name of the cell: what went wrong, in words} of those that failed.
    """
    failures, ended = {}, ""
    client.nb = nbformat.v4.new_notebook(cells=copy.deepcopy(list(cells)))
    for index, cell in enumerate(client.nb.cells):
        if cell.cell_type != "code":
            continue
        if not ended:
            failures[name(cell)], ended = await _one(client, cell, index)
        else:
            failures[name(cell)] = ended
    return {cell: words for cell, words in failures.items() if words}


async def _one(client, cell, index):
    """Execute one cell.  Returns what went wrong, and what the cells after it have to be told, both "" if all is well."""
    over = asyncio.timeout(client.timeout + PATIENCE)
    try:
        async with over:
            await client.async_execute_cell(cell, index)
    except CellExecutionError as error:
        return _words(error, client.timeout), ""
    except (DeadKernelError, TimeoutError):
        if asyncio.current_task().cancelling():  # Ctrl-C, which nbclient takes for a dead kernel
            raise asyncio.CancelledError from None
        end = f"not finished after {client.timeout:g} s, and could not be interrupted" if over.expired() else DIED
        return end, f"{NOT_RUN}{name(cell)} ended the kernel"
    return "", ""


def _words(error, limit):
    """What a student is told of an error."""
    if error.ename == "AssertionError":
        return error.evalue or "the assertion is false"
    if error.ename == "NotImplementedError":
        return UNWRITTEN
    if error.ename == "KeyboardInterrupt":
        return f"not finished after {limit:g} s: is there a loop that never ends?"
    return f"stops with {error.ename}: {re.sub(r'[(][^()]*[.]py, ', '(', error.evalue)}"
