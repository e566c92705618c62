"""What several files of tests share: the executed notebooks and the site of them."""

from contextlib import contextmanager

import pytest
from hypothesis import settings

from mkt.course import book
from mkt.course.book import contents, execute
from tests import made_up

# A busy machine is no fault of the code: no test has a time limit for each example.
settings.register_profile("patient")
settings.load_profile("patient")

OF_THE_SITE = ("test_book.py", "test_pages.py")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """The tests of one file share its costly results, so they run in one worker.

    So do the files that share the site.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.split("::")[0]
            return "site" if file.endswith(OF_THE_SITE) else file

    return ByFile(config, log)


@pytest.fixture(scope="session")
def notebooks():
    """The executed chapters, {name: notebook}."""
    with without_data():
        return execute.execute_all(contents.read().chapters)


@pytest.fixture(scope="session")
def site():
    """The folder of the whole book, with the claims and the boards made up."""
    with without_data():
        folder = book.BUILD / "tests"
        return book.build(folder, made_up.results, made_up.boards).parent


@contextmanager
def without_data():
    """The book as most readers build it, which takes half the time.

    That is without benchmarks, whatever is on this machine.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("MKT_DATA", raising=False)
        yield
