"""One browser for all tests of a file, the one that is on the machine.

Without one they skip.
"""

import os
import shutil
from contextlib import contextmanager

import pytest
from playwright.sync_api import Error, sync_playwright

from mkt.course.doctor import BROWSERS
from mkt.files import BUILD

PICTURES = BUILD / "screenshots"
NONE = (
    "no browser here: install chromium-headless-shell or chromium with the system's "
    "packages, or `playwright install chromium`"
)


# Not longer than a file: its event loop would keep the book's from running.
@pytest.fixture(scope="module")
def driver():
    """Playwright."""
    with sync_playwright() as playwright:
        yield playwright


@contextmanager
def launched(driver, *arguments):
    """A running Chromium with some arguments of the command line."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    root = hasattr(os, "getuid") and os.getuid() == 0
    try:
        running = driver.chromium.launch(
            executable_path=found, args=[*arguments, *["--no-sandbox"] * root]
        )
    except Error as error:
        pytest.skip(f"{NONE} ({str(error).splitlines()[0]})")
    yield running
    running.close()


@pytest.fixture(scope="module")
def browser(driver):
    """A running Chromium."""
    with launched(driver) as running:
        yield running


@pytest.fixture(scope="session")
def pictures():
    """Where the screenshots are kept."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    return PICTURES
