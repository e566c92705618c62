"""What pages carry inside becomes files beside them."""

import base64

import cv2
import numpy as np
import pytest

from mkt.course.book import lighter
from mkt.course.book.lighter import lighten
from mkt.course.book.punctuation import with_signs, with_units


def test_films_and_pictures_become_files_and_drawings_smaller(tmp_path):
    rng = np.random.default_rng(0)
    film = rng.bytes(3000)
    lines = np.full((80, 90, 3), 255, np.uint8)
    lines[40] = 0
    (tmp_path / "_images").mkdir()
    cv2.imwrite(str(tmp_path / "_images" / "ab12.png"), lines)
    inside = f"data:video/webm;base64,{base64.b64encode(film).decode()}"
    drawn = b"<svg>" + b" " * 3000 + b"</svg>"
    lines_inside = f"data:image/svg+xml;base64,{base64.b64encode(drawn).decode()}"
    small = "data:image/webp;base64,AAAA"
    photograph = cv2.GaussianBlur(
        rng.integers(0, 256, (80, 90, 3), np.uint8), (9, 9), 0
    )
    cv2.imwrite(str(tmp_path / "_images" / "cd34.png"), photograph)
    code = '<span class="n">x</span><span class="p">(</span><span class="mi">1</span>'
    (tmp_path / "api").mkdir()
    for name in ("one.html", "api/two.html"):
        text = f'<video src="{inside}"><img src="{small}"><img src="_images/ab12.png">'
        text += (
            f'<img src="{lines_inside}"><img src="_images/cd34.png"><pre>{code}</pre>'
        )
        (tmp_path / name).write_text(text)
    lighten(tmp_path)
    (kept,) = (tmp_path / "_static" / "data").glob("*.webm")
    (vector,) = (tmp_path / "_static" / "data").glob("*.svg")
    assert vector.read_bytes() == drawn
    assert kept.read_bytes() == film and kept.suffix == ".webm"
    one, two = ((tmp_path / name).read_text() for name in ("one.html", "api/two.html"))
    assert f'<video src="_static/data/{kept.name}">' in one
    assert f'<video src="../_static/data/{kept.name}">' in two
    assert f'<img src="_static/data/{vector.name}">' in one
    assert small in one and '<img src="_images/ab12.webp">' in one
    assert '<img src="_images/cd34.avif">' in one
    assert '<pre>x(<span class="mi">1</span></pre>' in one
    drawing, photographed = sorted((tmp_path / "_images").iterdir())
    assert (cv2.imread(str(drawing)) == lines).all()
    off = cv2.imread(str(photographed)).astype(float) - photograph
    assert np.abs(off).mean() < 6


def test_a_drawing_that_was_made_smaller_is_known(tmp_path, monkeypatch):
    monkeypatch.setenv("MKT_CACHE", str(tmp_path / "cache"))
    made = []
    for name in ("one", "two"):
        (tmp_path / name / "_images").mkdir(parents=True)
        picture = tmp_path / name / "_images" / "ab.png"
        cv2.imwrite(str(picture), np.full((8, 8, 3), 200, np.uint8))
        lighten(tmp_path / name)
        (smaller,) = (tmp_path / name / "_images").iterdir()
        made.append((smaller.name, smaller.read_bytes()))
        monkeypatch.setattr(lighter, "_smallest", None)
    assert made[0] == made[1]


def test_what_no_reader_sees_goes_and_what_is_code_stays_as_it_is(tmp_path):
    shown = "<pre>\n    x = 1\n\n\n    y</pre>\n<script>a\n   = `\n  <!-- `</script>"
    icons = '<symbol id="svg-sun">\n  <path/></symbol>\n<symbol id="svg-eye"></symbol>'
    page = tmp_path / "one.html"
    style = '<link rel="stylesheet" type="text/css" href="a.css">'
    words = f'<p>a\n     b</p>{style}<!-- said\nto nobody --><use href="#svg-sun"/>'
    page.write_text(f"{icons}\n   {words}\n\n{shown}\n")
    lighten(tmp_path)
    sun = '<symbol id="svg-sun">\n<path/></symbol>\n'
    style = '<link rel="stylesheet" href="a.css">'
    text = f'<p>a\nb</p>{style}<use href="#svg-sun"/>\n{shown}\n'
    assert page.read_text() == sun + text


@pytest.mark.parametrize(
    "text, whole",
    [
        ("T is {}.  Will", "T is [{}.]  Will"),
        ("({}), and {}, {}", "[({}),] and [{},] {}"),
        ("a {} b", "a {} b"),
        ("{}\u2019s", "[{}\u2019]s"),
        ("<div>{}</div>.", "<div>{}</div>."),
    ],
)
def test_a_formula_keeps_the_signs_beside_it(text, whole):
    formula = '<svg width="1em" class="mkt-math" role="img"><path d="m 1 2" /></svg>'
    whole = whole.replace("[", '<span class="mkt-whole">').replace("]", "</span>")
    kept = text.replace("{}", formula)
    assert with_signs(kept) == whole.replace("{}", formula)
    other = kept.replace("mkt-math", "icon")
    assert with_signs(other) == other


@pytest.mark.parametrize(
    "text, whole",
    [
        ("<p>at 2.3 % of 40 px, 5 s</p>", "<p>at 2.3~% of 40~px, 5~s</p>"),
        ("<p>5 <b>3 ms</b></p>", "<p>5 <b>3~ms</b></p>"),
        ("<p>2 students, 3 mice, 9 m2</p>",) * 2,
        ("<pre>a % b 3 % 5 px</pre> <code>3 % 2</code>",) * 2,
        ('<img alt="3 px"><script>{"a": "3 px"}</script>',) * 2,
    ],
)
def test_no_line_parts_a_number_from_its_unit(text, whole):
    assert with_units(text) == whole.replace("~", "\N{NO-BREAK SPACE}")
