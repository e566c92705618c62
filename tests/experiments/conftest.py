"""Every test of this folder has a cache of its own, empty at first."""

import pytest


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    """The folder in which results of this test are kept."""
    folder = tmp_path / "kept"
    monkeypatch.setenv("MKT_CACHE", str(folder))
    return folder
