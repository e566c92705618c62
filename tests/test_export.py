"""Files of figures: what is in the table is what is drawn, and every file says how it came about."""

import csv
import re

import cv2
import numpy as np
import pytest
from PIL import Image, PdfParser

import mkt
from mkt import export, figures
from mkt.plotting import canvas, draw_map, draw_surface

FIGURE = "teuliere2009.fig2"
FACTS = ("teuliere2009.fig2: The multiple-kernel configuration.", "layout=2x2, span=0.8, profile=epanechnikov, object=car", "matplotlib", "Benchmarks at hand: ")


def table(draw, **place):
    """The rows (series, x, y, z) of a figure of one chart, as floats."""
    fig = canvas((4, 3))
    draw(fig.add_subplot(**place))
    fig.canvas.draw()
    return [(series, *(float(value) for value in values if value != "")) for _, series, *values in export.curves(fig)]


@pytest.mark.parametrize("draw, rows", [
    (lambda ax: ax.plot([1, 2], [3, 4], label="a"), [("a", 1, 3), ("a", 2, 4)]),
    (lambda ax: ax.plot([[1, 5], [2, 6]]), [("line 1", 0, 1), ("line 1", 1, 2), ("line 2", 0, 5), ("line 2", 1, 6)]),
    (lambda ax: [ax.axhline(1), ax.axvspan(0, 1)], []),
    (lambda ax: ax.scatter([1, 2], [3, 4], label="b"), [("b", 1, 3), ("b", 2, 4)]),
    (lambda ax: ax.vlines([1], 0, 2, label="c"), [("c", 1, 0), ("c", 1, 2)]),
    (lambda ax: ax.bar([1, 2], [3, 4], bottom=1), [("bars 1", 1, 4), ("bars 1", 2, 5)]),
    (lambda ax: ax.barh(["u", "v"], [3, 4]), [("bars 1", 3, 0), ("bars 1", 4, 1)]),
    (lambda ax: ax.hist([0.2, 0.4, 1.2], [0, 1, 2]), [("bars 1", 0.5, 2), ("bars 1", 1.5, 1)]),
    (lambda ax: ax.stairs([3, 4], [0, 1, 3], fill=True), [("steps 1", 0.5, 3), ("steps 1", 2, 4)]),
    (lambda ax: ax.imshow([[1, 2], [3, 4]]), [("image 1", 0, 0, 1), ("image 1", 1, 0, 2), ("image 1", 0, 1, 3), ("image 1", 1, 1, 4)]),
    (lambda ax: ax.imshow([[7], [8]], extent=(0, 2, 0, 4), origin="lower"), [("image 1", 1, 1, 7), ("image 1", 1, 3, 8)]),
    (lambda ax: ax.fill_between([0, 1], 0, 1, where=[False, False]), []),
    (lambda ax: ax.imshow(np.zeros((2, 2, 3))), []),
    (lambda ax: [ax.set_axis_off(), ax.plot([1], [2])], []),
], ids=["line", "two lines", "edge to edge", "dots", "vertical lines", "bars", "lying bars", "histogram", "steps", "image", "image from below", "nothing filled", "photograph", "over one"])
def test_the_table_has_what_is_drawn(draw, rows):
    drawn = table(draw)
    assert [row[0] for row in drawn] == [row[0] for row in rows]
    assert [value for row in drawn for value in row[1:]] == pytest.approx([value for row in rows for value in row[1:]])


def test_the_table_of_a_map_has_its_values_and_the_lowest_point_but_no_colour_bar():
    x, y, z = np.array([0.0, 1.0, 2.0]), np.array([0.0, 5.0]), np.array([[1.0, 2, 3], [4, 0, 6]])
    rows = table(lambda ax: ax.figure.colorbar(draw_map(ax, x, y, z)))
    assert [row[1:] for row in rows if row[0].startswith("marks")] == [(a, b, z[j, i]) for j, b in enumerate(y) for i, a in enumerate(x)]
    assert [row[1:] for row in rows if row[0].startswith("line")] == [(1, 5)]


def test_the_table_of_a_surface_has_the_corners_that_are_drawn_and_a_curve_over_it():
    x, y = np.arange(5.0), np.arange(7.0)
    z = x + 10 * y[:, None]
    rows = table(lambda ax: [draw_surface(ax, x, y, z), ax.plot([1, 2], [3, 4], [5, 6], label="path")], projection="3d")
    assert [row[1:] for row in rows if row[0] == "path"] == [(1, 3, 5), (2, 4, 6)]
    assert sorted(row[1:] for row in rows if row[0] != "path") == [(a, b, a + 10 * b) for a in x[::2] for b in y[::2]]


def test_figures_of_photographs_give_their_numbers():
    assert export.listed("", {"a": 1, "b": {"c": [2, "x"]}, "d": np.array([3, 4]), "e": np.array([[5, 6]])}) == [
        ("", "a", "", 1, ""), ("", "b c[0]", "", 2, ""), ("", "b c[1]", "", "x", ""), ("", "d", 0, 3, ""), ("", "d", 1, 4, ""),
        ("", "e", 0, 0, 5), ("", "e", 1, 0, 6)]
    assert [row[3] for row in export.listed("", {"f": np.arange(8).reshape(2, 2, 2)}) if row[1] == "f[1]"] == [0, 0, 1, 1]


def read(path):
    """What a program finds in a file beside the picture, as one text."""
    if path.suffix == ".png":
        return str(Image.open(path).text)
    if path.suffix == ".pdf":
        return str({key: PdfParser.decode_text(value) for key, value in PdfParser.PdfParser(path).info.items()})
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("ending", export.KEYS)
def test_every_file_carries_title_parameters_versions_and_data_and_no_date(tmp_path, ending):
    path, again = tmp_path / f"one{ending}", tmp_path / f"two{ending}"
    for each in (path, again):
        export.write(figures.get(FIGURE), each, {"layout": "2x2", "span": 0.8})
    text = read(path)
    assert all(fact in text for fact in FACTS)
    assert all(f"{package} {version}" in text for package, version in (("mkt", mkt.__version__), ("numpy", np.__version__), ("opencv", cv2.__version__)))
    assert "Date" not in text
    assert path.read_bytes() == again.read_bytes()


def test_a_heavy_pdf_becomes_one_picture_that_still_says_how_it_came_about(tmp_path):
    entry, sizes = figures.get(FIGURE), []
    for largest in (np.inf, 1):
        export.save(*entry.draw(), tmp_path / "x.pdf", export.facts(entry, {"layout": "2x2", "span": 0.8}), largest)
        assert all(fact in read(tmp_path / "x.pdf") for fact in FACTS) and "Date" not in read(tmp_path / "x.pdf")
        sizes.append((tmp_path / "x.pdf").read_bytes().count(b"/DCTDecode"))
    assert sizes == [0, 1]


def test_a_table_says_what_its_panels_are(tmp_path):
    export.write(figures.get("own.resampling"), tmp_path / "x.csv", {"n": 4})
    lines = (tmp_path / "x.csv").read_text(encoding="utf-8").splitlines()
    head, rows = [line for line in lines if line[0] == "#"], list(csv.DictReader(line for line in lines if line[0] != "#"))
    assert any(line.startswith("# panel 3: ") and "x is particle; y is offspring" in line for line in head)
    assert any("y is (0 = multinomial, 1 = stratified" in line for line in head)
    assert len([row for row in rows if row["panel"] == "3" and row["series"] == "expected, $N w$"]) == 4
    assert all(re.fullmatch(r"-?[\d.e+-]+", row["x"]) for row in rows)


def test_what_cannot_be_written_is_said_before_anything_is_drawn(tmp_path):
    with pytest.raises(ValueError, match=r"x.jpg: the ending says what to write; take one of .png, .pdf, .svg, .csv"):
        export.write(None, tmp_path / "x.jpg", {})
    with pytest.raises(FileNotFoundError, match="no folder .*missing for x.png; make it first"):
        export.write(None, tmp_path / "missing" / "x.png", {})
