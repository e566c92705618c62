"""An empty folder to work in, and a video in it."""

import pytest

from tests.own_video import films


@pytest.fixture
def place(tmp_path, monkeypatch):
    """An empty folder, where the notebook is thought to lie."""
    monkeypatch.delenv("MKT_STATIC", raising=False)
    monkeypatch.setattr("mkt.own_video.workbench.SETTLED", 0.02)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def car(place):
    """A video beside the notebook."""
    return films.write(place / "car.mkv", films.driving(films.LENGTH).frames)
