"""What pages carry inside becomes files beside them."""

import base64

import cv2
import numpy as np

from mkt.course.book.lighter import lighten


def test_films_and_pictures_become_files_and_drawings_smaller(tmp_path):
    rng = np.random.default_rng(0)
    film = rng.bytes(3000)
    lines = np.full((80, 90, 3), 255, np.uint8)
    lines[40] = 0
    (tmp_path / "_images").mkdir()
    cv2.imwrite(str(tmp_path / "_images" / "ab12.png"), lines)
    inside = f"data:video/webm;base64,{base64.b64encode(film).decode()}"
    small = "data:image/webp;base64,AAAA"
    (tmp_path / "api").mkdir()
    for name in ("one.html", "api/two.html"):
        text = f'<video src="{inside}"><img src="{small}"><img src="_images/ab12.png">'
        (tmp_path / name).write_text(text)
    lighten(tmp_path)
    (kept,) = (tmp_path / "_static" / "data").iterdir()
    assert kept.read_bytes() == film and kept.suffix == ".webm"
    one, two = ((tmp_path / name).read_text() for name in ("one.html", "api/two.html"))
    assert f'<video src="_static/data/{kept.name}">' in one
    assert f'<video src="../_static/data/{kept.name}">' in two
    assert small in one and '<img src="_images/ab12.webp">' in one
    (drawing,) = (tmp_path / "_images").iterdir()
    assert (cv2.imread(str(drawing)) == lines).all()
