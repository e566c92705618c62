"""Pages with marks are read on a telephone, too."""

import pytest

from mkt.course.labs import pages, table
from mkt.course.labs.notebooks import labs, of_role

LONG = "q" * 1500  # an address, a path, a list without blanks


@pytest.mark.parametrize("width", [320, 390, 1400])
@pytest.mark.parametrize("title", labs())
def test_a_page_is_never_wider_than_the_screen(browser, tmp_path, title, width):
    lab = labs()[title]
    checks = dict.fromkeys(of_role(lab, "check", "question"), "2.25")
    row = dict.fromkeys(table.NEEDED, LONG) | checks | {"lab": title, "total": "15.5"}
    row |= {"student": "ada", "file": f"ada/{title}.ipynb", "note": f"{LONG}\n{LONG}"}
    pages.write(tmp_path / "grades.csv", row, lab, models=True)
    (path,) = (tmp_path / "grades_pages" / "ada").iterdir()
    page = browser.new_page(viewport={"width": width, "height": 900})
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.close()
