"""The made-up lab in the place of the real ones."""

import nbformat
import pytest

from mkt.course.labs import notebooks
from tests.course.toy_lab import TOY


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """A folder of labs with only the toy in it."""
    folder = tmp_path / "labs"
    folder.mkdir()
    nbformat.write(TOY, folder / "toy.ipynb")
    monkeypatch.setattr(notebooks, "FOLDER", folder)
    return tmp_path
