"""What several files of tests share: the executed notebooks and the site made of them."""

import pytest

from mkt import book
from mkt.book import catalogue, execute
from tests import made_up

OF_THE_SITE = ("test_book.py", "test_pages.py")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """The tests of one file share its costly results, so they run in one worker; and so do the files that share the site."""
    for item in items:
        item.add_marker(pytest.mark.xdist_group("site" if item.path.name in OF_THE_SITE else str(item.path)))


@pytest.fixture(scope="session")
def notebooks():
    return execute.execute_all(catalogue.read().chapters, book.BUILD / "executed")


@pytest.fixture(scope="session")
def site():
    """The folder of the whole book, with the claims and the boards made up."""
    return book.build(book.BUILD / "tests", made_up.results, made_up.boards).parent
