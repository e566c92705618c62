"""Files of figures: the table is what is shown, and each says how it came about."""

import io
import zlib
from itertools import islice

import cv2
import numpy as np
import pandas as pd
import pytest
from PIL import Image, PdfParser

import mkt
from mkt.figures import export, light_pdf
from mkt.figures.registry import FIGURES, Shown, figure, grid_columns, shown
from mkt.files import DATA
from mkt.scenes.textures import texture
from tests.lot import DAY

FIGURE = "teuliere2009.fig2"
FACTS = (
    "teuliere2009.fig2: The multiple-kernel configuration.",
    "layout=2x2, span=0.8, profile=epanechnikov, item=car",
    "matplotlib",
    "Benchmarks at hand: ",
)


def read(path):
    """What a program finds in a file beside the picture, as one text."""
    if path.suffix == ".png":
        return str(Image.open(path).text)
    if path.suffix == ".pdf":
        return str(
            {
                key: PdfParser.decode_text(value)
                for key, value in PdfParser.PdfParser(path).info.items()
            }
        )
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("ending", [e for e in export.KEYS if e != export.MOVING])
def test_every_file_carries_title_parameters_versions_and_data_and_no_date(
    tmp_path, ending
):
    path, again = tmp_path / f"one{ending}", tmp_path / f"two{ending}"
    for each in (path, again):
        export.write(FIGURES[FIGURE], each, {"layout": "2x2", "span": 0.8})
    text = read(path)
    assert all(fact in text for fact in FACTS)
    assert all(
        f"{package} {version}" in text
        for package, version in (
            ("mkt", mkt.__version__),
            ("numpy", np.__version__),
            ("opencv", cv2.__version__),
        )
    )
    assert "Date" not in text
    assert path.read_bytes() == again.read_bytes()


def test_a_picture_for_print_has_200_dots_an_inch(tmp_path):
    export.write(FIGURES[FIGURE], tmp_path / "x.png", {})
    with Image.open(tmp_path / "x.png") as picture:
        assert picture.width == 200 * FIGURES[FIGURE].size[0]


def test_a_light_pdf_has_its_photographs_as_jpeg_and_its_letters_as_they_were(
    tmp_path,
):
    entry, read_as = FIGURES["own.run"], []
    fig, shown = entry.draw(100)
    for light in (False, True):
        path = tmp_path / "x.pdf"
        export.save(fig, shown, path, export.facts(entry, {}), light)
        read_as.append(path.read_bytes())
    full, light = read_as
    assert len(light) < 0.5 * len(full)
    assert full.count(b"/DCTDecode") == 0 < light.count(b"/DCTDecode")
    assert light_pdf.lighter(full) == light
    for file in read_as:  # the table at the end knows where everything is
        start = int(file.split()[-2])
        lines = file[start:].splitlines()
        for k, line in enumerate(lines[3 : int(lines[1].split()[1]) + 2], 1):
            assert file[int(line[:10]) :].startswith(b"%d 0 obj\n" % k)
    letters = [file.count(b"/Type /Font") for file in read_as]
    assert letters[0] == letters[1] > 0
    for file in read_as:
        path.write_bytes(file)
        assert entry.title in read(path)


def in_a_pdf(rgb):
    """A photograph as matplotlib writes it into a PDF."""
    height, width = rgb.shape[:2]
    body = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rgb))
    return (
        b"/Width %d /Height %d\n/ColorSpace /DeviceRGB\n/Filter /FlateDecode\n"
        b"/DecodeParms <<>>\n/Length 9 0 R\n>>\nstream\n%s\nendstream\nendobj\n"
        % (width, height, body)
    )


def smaller(thing):
    found = light_pdf.PHOTOGRAPH.match(thing)
    assert found
    return light_pdf._smaller(found)


def test_a_photograph_that_is_no_smaller_as_jpeg_stays_what_it_is():
    """Such as a lattice of two colours, of which a PNG needs a bit for a pixel."""
    pixels = np.zeros((32, 32, 3), np.uint8)
    pixels[::2, ::2] = 255
    assert smaller(in_a_pdf(pixels)) == in_a_pdf(pixels)


def test_a_photograph_as_jpeg_looks_as_it_did():
    photograph = np.ascontiguousarray(texture("workshop")[:200, :300, :3])
    light = smaller(in_a_pdf(photograph))
    jpeg = light[light.index(b"stream\n") + 7 : light.rindex(b"\nendstream")]
    bgr = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    off = np.abs(bgr[..., ::-1].astype(int) - photograph)
    assert off.mean() < 4.3 and len(light) < 0.1 * len(in_a_pdf(photograph))


def test_the_table_of_a_figure_is_what_its_function_returned(tmp_path):
    entry = FIGURES["own.resampling"]
    export.write(entry, tmp_path / "x.csv", {"n": 4})
    text = (tmp_path / "x.csv").read_text(encoding="utf-8")
    table = pd.read_csv(io.StringIO(text), comment="#")
    _, shown = entry.draw(n=4)
    assert list(table) == list(shown.table) and len(table) == len(shown.table)
    for name, column in shown.table.items():
        if column.dtype.kind == "f":
            assert table[name].to_numpy() == pytest.approx(
                column.to_numpy(), rel=1e-5, nan_ok=True
            )
    assert "# n_eff: " in text


def test_facts_of_up_to_twenty_numbers_stand_above_the_table():
    facts = {"few": np.arange(20.0), "many": np.arange(21.0)}
    head = export.as_csv(shown({"x": [1]}, **facts), {})
    assert "# few: [ 0., 1., " in head and " 19.]\n" in head and "many" not in head


def test_what_is_not_a_number_is_an_empty_cell():
    table = shown({"frame": [0, 1], "x [px]": [1.5, np.nan]})
    assert export.as_csv(table, {}) == "frame,x [px]\n0,1.5\n1,\n"


def test_facts_and_columns_are_read_by_name():
    shown = Shown(pd.DataFrame({"x": [1, 2]}), {"mean": 1.5})
    assert shown["mean"] == 1.5 and shown["x"].tolist() == [1, 2]


def test_a_surface_becomes_a_row_for_each_of_its_points():
    z = np.arange(6.0).reshape(2, 3)
    table = grid_columns({"y": [0, 5]}, {"x": [1, 2, 3]}, z=z)
    assert list(table) == ["y", "x", "z"]
    assert table.itertuples(index=False, name=None).__next__() == (0, 1, 0)
    assert table.iloc[-1].tolist() == [5, 3, 5]


def test_what_cannot_be_written_is_said_before_anything_is_drawn(tmp_path):
    with pytest.raises(
        ValueError,
        match=r"x.jpg: the ending says what to write; take one of .png, .pdf, .svg, ",
    ):
        export.write(None, tmp_path / "x.jpg", {})
    with pytest.raises(
        FileNotFoundError, match="no folder .*missing for x.png; make it first"
    ):
        export.write(None, tmp_path / "missing" / "x.png", {})


def test_a_figure_with_a_slider_of_frames_becomes_a_moving_picture(tmp_path):
    @figure("toy.moving", size=(2, 1), frame=(0, 8, 1))
    def moving(fig, *, frame=0, to=0):
        """A line that rises."""
        fig.subplots().plot([0, 1], [to, frame])
        return shown({"x": [0, 1]})

    export.write(FIGURES["toy.moving"], tmp_path / "x.gif", {"to": 3})
    with Image.open(tmp_path / "x.gif") as film:
        assert film.info["loop"] == 0  # for ever
        assert film.n_frames == 5  # every second one
        assert 80 <= film.info["duration"] <= 160  # [ms]: to be seen, and a motion
        comment = film.info["comment"].decode()
    about = "toy.moving: A line that rises.", "frame=0 to 8, to=3", "mkt ", "Benchmarks"
    lines = zip(comment.splitlines(), export.KEYS[".gif"], about, strict=True)
    assert all(line.startswith(f"{k}: ") and part in line for line, k, part in lines)
    export.write(FIGURES["toy.moving"], tmp_path / "again.gif", {"to": 3})
    first, again = (tmp_path / f"{name}.gif" for name in ("x", "again"))
    assert first.read_bytes() == again.read_bytes()
    with pytest.raises(ValueError, match="no parameter 'frame', over which"):
        export.write(FIGURES["teuliere2009.fig2"], tmp_path / "y.gif", {})
    with pytest.raises(ValueError, match=r"frame=3: a .gif moves over 'frame'; leave"):
        export.write(FIGURES["toy.moving"], tmp_path / "y.gif", {"frame": 3})
    assert not (tmp_path / "y.gif").exists()


def test_the_film_of_the_readme_is_what_its_command_draws_today():
    """One picture of it by lot, as far as 32 colours can show it."""
    k = DAY % 8
    drawn = export.moving(FIGURES["own.run"], {"tracker": "pf-75"}, export.MOVING_DPI)
    today = next(islice(drawn, k, None))
    with Image.open(DATA / "tracked.gif") as film:
        film.seek(k)
        off = np.subtract(film.convert("RGB"), today, dtype=float)
    assert np.abs(off).mean() < 4.3
