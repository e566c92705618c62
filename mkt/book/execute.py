"""Run the chapters: two kernels at a time, a time limit each, and no run twice of what has not changed.  Reading order from below.

nbclient waits for the reply to a cell in one long poll, which now and then misses it; the cell then sits until its time is up, and passes.
`Client` asks four times a second instead.
"""

import asyncio
import functools
import hashlib
import os
import re
import sys
import tempfile
import time
from contextlib import asynccontextmanager
from queue import Empty

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, DeadKernelError
from tqdm import tqdm
from traitlets.config import Config

from mkt.book.catalogue import ROOT, BookError
from mkt.book.checks import strip
from mkt.files import whole

SLICE = 0.25  # [s] between two looks for a reply
KERNELS = 2
RESULTS_DEPEND_ON = ("mkt/**/*.py", "data/**/*", "environment.txt")


class Client(NotebookClient):
    """nbclient with a patient ear, whose kernels end with their notebook whatever stops it."""

    @asynccontextmanager
    async def async_setup_kernel(self, **kwargs):
        """A kernel for the time of the notebook.  Unlike nbclient's it leaves Ctrl-C alone, which so cancels all notebooks at once."""
        manager = self.km = self.create_kernel_manager()
        with tempfile.TemporaryDirectory(prefix="mkt-", ignore_cleanup_errors=True) as sockets:
            if manager.transport == "ipc":  # kernel and client run in different folders: the default, a relative path, would part them
                manager.ip = os.path.join(sockets, "kernel")
            try:
                await self.async_start_new_kernel(**kwargs)
                await self.async_start_new_kernel_client()
                yield
            finally:
                self.km = manager
                await self._async_cleanup_kernel()

    async def async_start_new_kernel_client(self):
        """nbclient's client, its replies fetched in slices."""
        client = await super().async_start_new_kernel_client()
        client.shell_channel.get_msg = _in_slices(client.shell_channel.get_msg)
        return client


def _in_slices(get_msg):
    async def patient(timeout=None):
        end = time.monotonic() + (float("inf") if timeout is None else timeout)
        while True:
            try:
                return await get_msg(timeout=max(0, min(SLICE, end - time.monotonic())))
            except Empty:
                if time.monotonic() >= end:
                    raise

    return patient


async def run(chapter, on_cell=lambda: None):
    """Execute one `Chapter` as the book's readers see it.

    Returns the executed notebook; on_cell is called after each code cell.  Raises BookError naming notebook, cell and traceback.
    """
    notebook, cells = strip(nbformat.read(chapter.notebook, 4)), []
    client = Client(notebook, config=config(), timeout=None, record_timing=False, shutdown_kernel="immediate",
                    resources={"metadata": {"path": str(chapter.notebook.parent)}},
                    extra_arguments=["--InlineBackend.figure_formats={'retina'}"],
                    on_cell_start=lambda cell, cell_index: cells.append(cell), on_cell_executed=lambda **_: on_cell())
    limit = asyncio.timeout(chapter.timeout)
    try:
        async with limit:
            await client.async_execute(env=environment())
    except (RuntimeError, CellExecutionError, DeadKernelError, TimeoutError) as error:
        at = f"cell {cells[-1].id}:\n\n{cells[-1].source}\n\n" if cells else ""
        raise BookError(f"{chapter.notebook.name}, {at}{_reason(error, chapter, limit)}") from None
    notebook.metadata.pop("widgets", None)  # nbclient needs the state of widgets while it runs; a page without kernel has no use for it
    return notebook


def config():
    """The traitlets Config of a kernel: on this machine by sockets in a folder, where that is possible."""
    return Config() if os.name == "nt" else Config({"KernelManager": {"transport": "ipc"}})


def environment():
    """MPLBACKEND would silently take every figure out of the notebooks, so kernels never see it."""
    return {name: value for name, value in os.environ.items() if name != "MPLBACKEND"} | {"MKT_STATIC": "1"}


def _reason(error, chapter, limit):
    if limit.expired():  # nbclient takes the cancelled wait for a dead kernel, so the error does not tell
        return f"not finished after {chapter.timeout:g} s, the timeout of the chapter in book.toml"
    if isinstance(error, DeadKernelError):
        return "the kernel died, perhaps for want of memory"
    return re.sub(r"\x1b\[[0-9;]*m", "", getattr(error, "traceback", str(error)))


def key(chapter):
    """A fingerprint of all that the result depends on: the notebook without outputs, the library, the data, the packages, Python."""
    source = nbformat.writes(strip(nbformat.read(chapter.notebook, 4)))
    return hashlib.sha256((source + library_key()).encode()).hexdigest()


@functools.cache
def library_key():
    """A fingerprint of what every figure depends on.  How the pages look (mkt/book) and what the claims are is no part of it."""
    paths = sorted(path for pattern in RESULTS_DEPEND_ON for path in ROOT.glob(pattern) if path.is_file())
    digest = hashlib.sha256(f"{sys.version} {os.environ.get('MKT_DATA')}".encode())
    for path in paths:
        if path.parent.name not in ("book", "claims"):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def execute_all(chapters, folder):
    """Execute every `Chapter` whose result is not in `folder` yet, and say how long each took.

    Returns {name: executed notebook}.  Raises BookError with the troubles of all chapters that failed; the others' results are kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    found = {chapter.name: _kept(chapter, folder) for chapter in chapters}
    missing = [chapter for chapter in chapters if found[chapter.name] is None]
    results = asyncio.run(_run_all(missing, folder)) if missing else []
    troubles = [str(result) for result in results if isinstance(result, BookError)]
    if troubles:
        raise BookError("\n\n".join(troubles))
    return found | {chapter.name: notebook for chapter, notebook in zip(missing, results)}


def _kept(chapter, folder):
    path = folder / chapter.notebook.name
    notebook = nbformat.read(path, 4) if path.is_file() else None
    return notebook if notebook and notebook.metadata.get("mkt_key") == key(chapter) else None


async def _run_all(chapters, folder):
    gate, cells = asyncio.Semaphore(KERNELS), sum(_count(chapter) for chapter in chapters)
    with tqdm(total=cells, desc="notebooks", unit="cell", disable=None) as bar:
        results = await asyncio.gather(*(_timed(chapter, folder, gate, bar) for chapter in chapters), return_exceptions=True)
    for result in results:
        if isinstance(result, BaseException) and not isinstance(result, BookError):
            raise result
    return results


def _count(chapter):
    return sum(cell.cell_type == "code" for cell in nbformat.read(chapter.notebook, 4).cells)


async def _timed(chapter, folder, gate, bar):
    async with gate:
        start = time.monotonic()
        notebook = await run(chapter, bar.update)
    tqdm.write(f"{chapter.name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
    notebook.metadata["mkt_key"] = key(chapter)
    with whole(folder / chapter.notebook.name) as half:
        half.write_text(nbformat.writes(notebook), encoding="utf-8")
    return notebook
