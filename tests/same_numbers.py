"""Do all figures and tracks have the same numbers as before a change?

    python tests/same_numbers.py record before.npz     # before it
    python tests/same_numbers.py compare before.npz    # after it

Draws every figure at its defaults, takes its table and its facts, and lets every
tracker run over `base(0)`, `blur(1)` and the clip, with nothing known beforehand; names
what differs by more than 1e-9.
"""

import argparse
import os
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from mkt.figures.registry import FIGURES
from mkt.scenes import SCENES
from mkt.sequences.carphone import Carphone
from mkt.trackers.by_name import TRACKERS
from mkt.tracking import track

TIMED = ("ms", "CPU", "time")  # words in the names of what differs from run to run
# Figures of times, whose facts are fitted to them.
OF_TIMES = ("cordoba2014.complexity", "nummiaro2003.fig5")
SOURCES = {"base": SCENES["base"](0), "blur": SCENES["blur"](1), "clip": Carphone()}


def numbers_of(fact):
    """Every number of a fact, however deep, as a flat list; words have none."""
    if isinstance(fact, pd.DataFrame):
        fact = fact.select_dtypes("number")
    if isinstance(fact, dict):
        fact = list(fact.values())
    if isinstance(fact, list | tuple):
        return [number for part in fact for number in numbers_of(part)]
    if isinstance(fact, str):
        return []
    return np.ravel(np.asarray(fact, float)).tolist()


def numbers():
    """All of them, {name: flat array}."""
    for name in tqdm(FIGURES, "figures"):
        _, shown = FIGURES[name].draw()
        facts = {} if name in OF_TIMES else shown.facts
        parts = dict(shown.table.select_dtypes("number")) | facts
        for key, part in parts.items():
            if not any(word in key for word in TIMED):
                yield f"{name} {key}", np.array(numbers_of(part))
    for label, source in SOURCES.items():
        clip = source.sequence()
        for name, tracker in tqdm(TRACKERS.items(), label):
            run = track(tracker, clip, 0)
            for part in ("regions", "score", "lost"):
                yield (
                    f"{name} on {label}: {part}",
                    np.ravel(np.asarray(getattr(run, part), float)),
                )


def compare(before, after):
    """What differs, in sentences."""
    for name in sorted({*before, *after}):
        if name not in before or name not in after:
            yield f"{name}: only {'after' if name in after else 'before'} the change"
        elif before[name].shape != after[name].shape:
            yield f"{name}: {before[name].shape} before, {after[name].shape} after"
        elif not np.allclose(before[name], after[name], 1e-9, 1e-9, equal_nan=True):
            yield f"{name}: up to {np.nanmax(np.abs(before[name] - after[name])):.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=["record", "compare"])
    parser.add_argument("file", type=Path)
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MKT_CACHE"] = folder
        found = dict(numbers())
    if words.what == "record":
        np.savez(words.file, **found)
    else:
        differences = list(compare(dict(np.load(words.file)), found))
        print("\n".join(differences) or f"{len(found)} sets of numbers, all the same")


if __name__ == "__main__":
    main()
