"""A figure as a file that says how it came about: a picture (.png, .pdf, .svg), or its curves as a table (.csv).

Every file carries four facts: the title, the parameters, the versions, and the data.  It has no date in it, so that the same figure makes the same file.
"""

import csv
import io
from functools import singledispatch
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from matplotlib.category import StrCategoryFormatter
from matplotlib.collections import Collection, PathCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.contour import ContourSet
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import StepPatch
from matplotlib.ticker import FixedFormatter
from mpl_toolkits.mplot3d.art3d import Line3D, Poly3DCollection
from PIL import Image
from tqdm import tqdm

import mkt
from mkt import archives
from mkt.files import whole

KEYS = {  # what each format calls the four facts
    ".png": ("Title", "Comment", "Software", "Source"), ".pdf": ("Title", "Keywords", "Creator", "Subject"),
    ".svg": ("Title", "Keywords", "Creator", "Source"), ".csv": ("Title", "Parameters", "Versions", "Data"),
}
UNDATED = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
COLUMNS = ("panel", "series", "x", "y", "z")
SHARP_DPI, LIGHT_DPI = 200, 150


def checked(path):
    """The path of a file to write, before the long work rather than after it.  Raises ValueError or FileNotFoundError that says what to do."""
    path = Path(path)
    if path.suffix.lower() not in KEYS:
        raise ValueError(f"{path}: the ending says what to write; take one of {', '.join(KEYS)}")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"no folder {path.parent} for {path.name}; make it first")
    return path


def write(entry, path, parameters):
    """Draw an `mkt.figures.Entry` with its defaults, but for the parameters, into a file of the format that its ending names.

    Raises ValueError for another ending, an unknown parameter or one that leaves nothing to draw, FileNotFoundError for a missing folder, and OSError.
    """
    path = checked(path)
    try:
        canvas, numbers = entry.draw(SHARP_DPI, **parameters)
    except (ValueError, IndexError, ArithmeticError) as error:
        values = ", ".join(f"{name}={value}" for name, value in parameters.items()) or "its defaults"
        raise ValueError(f"{entry.id} cannot be drawn with {values}: {error}") from error
    with whole(path) as half:
        save(canvas, numbers, half, facts(entry, parameters))


def write_all(entries, folder, format):
    """Draw figures with their defaults into folder/ID.format, a progress bar above.  Raises OSError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OSError(f"{folder} cannot be made a folder: {error.strerror}") from error
    for entry in tqdm(entries, desc="figures", unit="figure", disable=None):
        write(entry, folder / f"{entry.id}.{format}", {})


def facts(entry, parameters):
    """Title, parameters, versions and data of a figure, four texts.  The data are what the caption says, and which benchmarks are at hand."""
    values = ", ".join(f"{name}={value}" for name, value in (entry.defaults | parameters).items())
    benchmarks = ", ".join(sorted({found.archive.name for found in archives.sequences()})) or "none"
    versions = f"mkt {mkt.__version__}, numpy {np.__version__}, matplotlib {matplotlib.__version__}, opencv {cv2.__version__}"
    return f"{entry.id}: {entry.title}", values, versions, " ".join(f"{entry.caption} Benchmarks at hand: {benchmarks}.".split())


def save(canvas, numbers, path, facts, largest=np.inf):
    """Write a drawn Figure, and the numbers that its function returned, into a file.  A PDF of more than `largest` bytes becomes one picture."""
    ending = path.suffix.lower()
    named = dict(zip(KEYS[ending], facts))
    if ending == ".csv":
        return _save_table(canvas, numbers, path, named)
    with matplotlib.rc_context({"svg.hashsalt": "mkt"}):
        picture = io.BytesIO()  # not the file itself: a PDF that cannot be written ends in an error that says nothing
        canvas.savefig(picture, format=ending[1:], metadata=named | UNDATED.get(ending, {}))
    path.write_bytes(picture.getvalue())
    if ending == ".pdf" and path.stat().st_size > largest:
        _save_light(canvas, path, named)


def _save_light(canvas, path, named):
    """A PDF of one JPEG, which matplotlib does not write: film strips are a tenth of their size so."""
    sharp = io.BytesIO()
    canvas.savefig(sharp, dpi=LIGHT_DPI, format="png")
    undated = {"creationDate": None, "modDate": None}
    Image.open(sharp).convert("RGB").save(path, resolution=LIGHT_DPI, quality=85, **{name.lower(): text for name, text in named.items()}, **undated)


def _save_table(canvas, numbers, path, named):
    rows = curves(canvas)
    head = [f"{name}: {text}" for name, text in named.items()]
    head += [f"panel {number}: {_described(ax)}" for number, ax in enumerate(charts(canvas), 1)] if rows else ["numbers that the figure shows"]
    with path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {line}\n" for line in head)
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *(rows or listed("", numbers))])


def _described(ax):
    """Label or title, and axes, of a chart, with the names that stand at ticks instead of numbers."""
    title = ax.get_label() or next(filter(None, map(ax.get_title, ("center", "left", "right"))), "")
    axes = {name: getattr(ax, f"{name}axis") for name in "xyz" if hasattr(ax, f"{name}axis")}
    parts = [title] * bool(title) + [f"{name} is {_axis(axis)}" for name, axis in axes.items() if _axis(axis)]
    return "; ".join(part.replace("\n", " ") for part in parts)


def _axis(axis):
    named = isinstance(axis.get_major_formatter(), (FixedFormatter, StrCategoryFormatter))
    ticks = ", ".join(f"{place:g} = {text.get_text()}" for place, text in zip(axis.get_majorticklocs(), axis.get_ticklabels()))
    return " ".join(filter(None, (axis.get_label().get_text(), f"({ticks})" if named and ticks else "")))


def charts(fig):
    """The axes of a drawn Figure that show numbers: not those without a frame, which show photographs and tables, nor colour bars."""
    bars = [artist.colorbar.ax for ax in fig.axes for artist in (*ax.collections, *ax.images) if artist.colorbar]
    return [ax for ax in fig.axes if (ax.axison or ax.name == "3d") and ax not in bars]


def curves(fig):
    """What the `charts` of a drawn Figure show: a list of rows (panel, series, x, y, z) of numbers; z is empty where there is none.

    Panels are counted from 1.  A series is called by its label, or by its kind and number.  What has no place in the data, such as a line
    from edge to edge, is left out.
    """
    rows = []
    for panel, ax in enumerate(charts(fig), 1):
        for kind, artists in {"line": ax.lines, "marks": ax.collections, "image": ax.images, "bars": ax.containers, "steps": ax.patches}.items():
            for number, artist in enumerate(artists, 1):
                label = str(artist.get_label())
                series = f"{kind} {number}" if label.startswith("_") or not label else label
                rows += [(panel, series, *(f"{value:.6g}" for value in point), *[""] * (3 - len(point))) for point in points(artist)]
    return rows


def listed(name, shown):
    """Numbers that a figure's function returned, dicts, lists and arrays of them, as rows of the same table; x, then y, count from 0."""
    if isinstance(shown, dict):
        return [row for key, value in shown.items() for row in listed(f"{name} {key}".strip(), value)]
    if isinstance(shown, (list, tuple)) or np.ndim(shown) > 2:
        return [row for k, value in enumerate(shown) for row in listed(f"{name}[{k}]", value)]
    if np.ndim(shown) == 2:
        return [("", name, x, y, value) for y, line in enumerate(shown) for x, value in enumerate(line)]
    return [("", name, x, value, "") for x, value in enumerate(shown)] if np.ndim(shown) == 1 else [("", name, "", shown, "")]


@singledispatch
def points(artist):
    """The points (n, 2) or (n, 3) that an artist of matplotlib draws, in the units of its axes; none for what is no curve."""
    return np.empty((0, 2))


@points.register
def _(line: Line2D):
    return np.column_stack(line.get_data()) if line.get_transform() == line.axes.transData else np.empty((0, 2))


@points.register
def _(line: Line3D):
    return np.column_stack(line.get_data_3d())


@points.register
def _(surface: Poly3DCollection):
    return np.unique(np.reshape(surface._faces, (-1, 3)), axis=0)  # matplotlib has no public way to them


@points.register
def _(dots: PathCollection):
    return np.ma.getdata(dots.get_offsets())


@points.register
def _(mesh: QuadMesh):
    edges = mesh.get_coordinates()
    middles = (edges[1:, 1:] + edges[1:, :-1] + edges[:-1, 1:] + edges[:-1, :-1]) / 4
    return np.column_stack([middles.reshape(-1, 2), np.ravel(mesh.get_array())])


@points.register
def _(paths: Collection):
    inside = paths.get_transform() == paths.axes.transData
    return np.concatenate([np.empty((0, 2)), *(path.vertices for path in paths.get_paths() if inside)])


@points.register
def _(contours: ContourSet):
    return np.empty((0, 2))  # they repeat the map that they lie on


@points.register
def _(image: AxesImage):
    values = image.get_array()
    if values.ndim != 2:
        return np.empty((0, 2))  # a photograph
    (left, right, low, high), (rows, columns) = image.get_extent(), values.shape
    first, last = (high, low) if image.origin == "upper" else (low, high)
    x, y = np.meshgrid(left + (np.arange(columns) + 0.5) / columns * (right - left), first + (np.arange(rows) + 0.5) / rows * (last - first))
    return np.column_stack([x.ravel(), y.ravel(), np.ravel(values)])


@points.register
def _(bars: BarContainer):
    ends = [(bar.get_x() + bar.get_width(), bar.get_y() + bar.get_height(), *bar.get_center()) for bar in bars]
    return np.array([(x, middle_y) if bars.orientation == "horizontal" else (middle_x, y) for x, y, middle_x, middle_y in ends])


@points.register
def _(steps: StepPatch):
    values, edges, _ = steps.get_data()
    return np.column_stack([(edges[1:] + edges[:-1]) / 2, values])
