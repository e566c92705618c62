"""A client of Jupyter's kernels that misses no reply.

nbclient waits for the reply to a cell in one long poll, which now and then misses it;
the cell then waits until its time is up, and counts as passed.  `Client` asks four
times a second instead.
"""

import os
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from queue import Empty
from typing import Any

from nbclient import NotebookClient
from traitlets.config import Config

SLICE = 0.25  # [s] between two looks for a reply
KERNELS = 2  # at a time


class Client(NotebookClient):
    """nbclient's client, made patient; its kernel always ends with the notebook."""

    @asynccontextmanager
    async def async_setup_kernel(self, **kwargs: Any) -> AsyncIterator[None]:
        """A kernel for the time of the notebook.

        Unlike nbclient it does not catch Ctrl-C, which can then cancel all notebooks at
        once.
        """
        manager = self.km = self.create_kernel_manager()
        with tempfile.TemporaryDirectory(
            prefix="mkt-", ignore_cleanup_errors=True
        ) as sockets:
            if manager.transport == "ipc":
                # Kernel and client run in different folders: the default, a relative
                # path, would separate them.
                manager.ip = str(Path(sockets, "kernel"))
            try:
                await self.async_start_new_kernel(**kwargs)
                await self.async_start_new_kernel_client()
                yield
            finally:
                self.km = manager
                await self._async_cleanup_kernel()

    async def async_start_new_kernel_client(self) -> Any:
        """A client of nbclient's, its replies fetched in slices."""
        client = await super().async_start_new_kernel_client()
        client.shell_channel.get_msg = _in_slices(client.shell_channel.get_msg)
        return client


def _in_slices(get_msg: Callable) -> Callable:
    async def patient(timeout: float | None = None):
        end = time.monotonic() + (float("inf") if timeout is None else timeout)
        while True:
            left = max(0, end - time.monotonic())
            try:
                return await get_msg(timeout=min(SLICE, left))
            except Empty:
                if time.monotonic() >= end:
                    raise

    return patient


def config() -> Config:
    """Settings of a kernel on this machine.

    It is reached by sockets in a folder where that is possible, since ipykernel warns
    of TCP at every start.
    """
    if os.name == "nt":
        return Config()
    return Config({"KernelManager": {"transport": "ipc"}})


def environment() -> dict[str, str]:
    """The environment of a kernel that runs a chapter of the book.

    The variable MPLBACKEND would silently remove every figure from the notebooks, so
    kernels never see it.
    """
    seen = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    return seen | {"MKT_STATIC": "1"}
