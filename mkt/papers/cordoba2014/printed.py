"""The printed Table 1 of [C14]: its numbers, its trackers, what stands for its data.

Where MKT_DATA has the BoBoT benchmark, its sequences are used, else their synthetic
twins of `mkt.scenes.cordoba2014`; `said` names the one in use.
"""

from dataclasses import dataclass

from mkt.evaluation import scored_frames
from mkt.papers.runs import clip
from mkt.plotting import CONTRAST
from mkt.scenes.drawn import Drawn
from mkt.sequences import benchmarks
from mkt.sequences.benchmarks import Found
from mkt.tracking import Source

# In the order of the table's columns.
NAMES = {"pfhr": "PFHR", "sir": "SIR", "wm": "WM"}
COLORS: dict[str, str] = dict(zip(("sir", "wm", "pfhr"), CONTRAST, strict=True))


@dataclass(frozen=True)
class Row:
    """A row of Table 1, and what was inferred from it (notebook 14).

    Parameters
    ----------
    title : str
    printed : tuple of str
        The percentages of PFHR, SIR and WM as printed.
    bobot : str
        How the name of its BoBoT sequence begins; inferred.
    frames : int
        The number of frames that the percentages are fractions of; inferred.
    twin : tuple of str
        Item and ground of its synthetic twin: much like that sequence's.
    """

    title: str
    printed: tuple[str, str, str]
    bobot: str
    frames: int
    twin: tuple[str, str]

    @property
    def percent(self) -> tuple[float, ...]:
        """The printed percentages as numbers."""
        return tuple(map(float, self.printed))


PEOPLE = "student", "campus"
TABLE = {
    "clutter": Row(
        "Cluttered environments",
        ("97.60", "95.21", "82.93"),
        "Vid_B",
        627,
        ("cup", "planks"),
    ),
    "passers": Row(
        "Outdoor w/ total occlusion",
        ("93.79", "90.18", "70.07"),
        "Vid_I",
        1016,
        PEOPLE,
    ),
    # The first row again; D has 946 or 947 frames, which none of the three fits.
    "background": Row(
        "Background changes", ("97.60", "95.21", "82.93"), "Vid_D", 627, PEOPLE
    ),
    "scale": Row(
        "Scale variations",
        ("92.30", "94.96", "33.90"),
        "Vid_G",
        715,
        ("cube", "planks"),
    ),
    "trajectory": Row(
        "Trajectory changes",
        ("95.67", "76.87", "87.18"),
        "Vid_A",
        601,
        ("ball", "grass"),
    ),
    "pillars": Row(
        "Indoor w/ total occlusion", ("88.93", "86.06", "30.08"), "Vid_F", 452, PEOPLE
    ),
}
# Printed; the mean of the printed PFHR column is 94.31.
OVERALL = ("94.75", "89.74", "64.51")


def source(kind: str, seed: int = 0) -> Found | Drawn:
    """What stands for a row of `TABLE`: its BoBoT sequence where it is, else a twin.

    Parameters
    ----------
    kind : str
        A key of `TABLE`.
    seed : int
        Of the twin; the BoBoT sequence is the same for all seeds.
    """
    beginning = f"BoBoT/{TABLE[kind].bobot}"
    found = [one for one in benchmarks.sequences() if one.name.startswith(beginning)]
    return found[0] if found else Drawn(kind, seed, *TABLE[kind].twin)


def share_seen(source: Source) -> float:
    """The share of a source's frames in which the target can be seen."""
    return float(scored_frames(clip(source))[1:].mean())


def said(source: Found | Drawn) -> str:
    """What the reader is looking at, in a few words."""
    if isinstance(source, Drawn):
        return f'synthetic twin "{source.kind}"'
    words = [source.name, source.archive.licence]
    if "reconstructed" in clip(source).source:
        words.append("frames reconstructed")
    return ", ".join(words)
