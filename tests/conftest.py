"""What several files of tests share: the executed notebooks and the site of them."""

import functools
import gc
import os
import re
import signal
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import settings

from mkt.course import book
from mkt.course.book import contents, execute
from mkt.files import alone
from tests.course import worked

# A busy machine is no fault of the code: no test has a time limit for each example.
settings.register_profile("patient", deadline=None, max_examples=50)
settings.register_profile("thorough", deadline=None, max_examples=500)
settings.load_profile("patient")

# The first worker makes the site.  What looks at it, or shows figures whose runs are
# known once it is there, comes last, the longest parts first, in any worker.  To begin
# with browsers while others compute gains nothing: they compute as much.
OF_THE_SITE = ("test_worked.py", "test_book.py")
LOOKING = (
    "test_live.py",
    "test_jupyterlab.py",
    "test_pages.py",
    "test_every_figure.py",
)


def pytest_configure(config):
    """Long ones first: the order below is the order in which tests are handed out.

    A shell starts programs in the background deaf to Ctrl-C, and what they start is as
    deaf as they are; some tests press it.
    """
    config.option.loadscopereorder = False
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_runtest_setup():
    """Forget what was computed before a fault was planted: mutmut's tests are forks.

    And what other tests have kept, or only the first of them would seem to use it.
    """
    if "MUTANT_UNDER_TEST" in os.environ:
        for thing in gc.get_objects():
            if isinstance(thing, functools._lru_cache_wrapper):
                thing.cache_clear()


def pytest_collection_modifyitems(items):
    """The site first, then all that is apart from it, then what looks at it."""

    def turn(item):
        name = item.path.name
        if name in OF_THE_SITE:
            return 0
        return 2 + LOOKING.index(name) if name in LOOKING else 1

    items.sort(key=turn)
    for item in items:
        if "answered" in item.fixturenames:
            item.add_marker("slow")


def pytest_collection_finish():
    """What is there by now stays: not to look through it saves 6 % of CPU.

    But for mutmut's tests, which have to find it, see above.
    """
    if "MUTANT_UNDER_TEST" not in os.environ:
        gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """One more than there are processors: a test of a browser waits as often as not."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """The tests of one file share its costly results, so they run in one worker.

    So do the files that make the site.  Of those that look at it, the tests of each
    page or figure do: in the end all workers are to stop at the same time.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file, _, test = nodeid.partition("::")
            if file.endswith(OF_THE_SITE):
                return "site"
            if file.endswith(LOOKING):
                return file + re.split(r"[\[\]-]", test + "[")[1]
            return file

    return ByFile(config, log)


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """The folder of this run of the tests, one for all workers."""
    folder = tmp_path_factory.getbasetemp()
    return folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder


@pytest.fixture(scope="session")
def answered(run, tmp_path_factory):
    """Today's executed chapters with their worked answers, {name: notebook}.

    The first worker executes them, the others read what it has kept.
    """
    folder = tmp_path_factory.mktemp("answers")
    with alone(run / "answers.lock", "execution of the chapters"), without_data():
        return worked.executed(worked.of_today(contents.read().chapters), folder)


@pytest.fixture(scope="session")
def notebooks(answered):
    """The executed chapters as the book shows them, {name: notebook}."""
    with without_data():
        return execute.execute_all(contents.read().chapters)


@pytest.fixture(scope="session")
def site(notebooks, run):
    """The folder of the whole book, made by the first worker that asks for it."""
    known = run / "site.txt"
    with alone(run / "site.lock", "site"), without_data():
        if not known.exists():
            first_page = book.build(book.BUILD / "tests")
            known.write_text(str(first_page.parent), encoding="utf-8")
    return Path(known.read_text(encoding="utf-8"))


@contextmanager
def without_data():
    """The book as most readers build it, which takes half the time.

    That is without benchmarks, whatever is on this machine.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("MKT_DATA", raising=False)
        yield
