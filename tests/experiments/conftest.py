"""Every test of this folder has a cache of its own, empty at first."""

import cv2
import pytest


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    """The folder in which results of this test are kept."""
    folder = tmp_path / "kept"
    monkeypatch.setenv("MKT_CACHE", str(folder))
    return folder


@pytest.fixture
def two_threads():
    """OpenCV has two threads, and afterwards as many as before."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(2)
    yield
    cv2.setNumThreads(before)
