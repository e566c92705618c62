"""What computes in the pages: one script for all of them, and a script for each data.

Data are scripts too, since pages on a disk may not fetch.
"""

import json
from itertools import islice
from typing import Any

from mkt.figures.film import webm
from mkt.figures.live import DATA, bundle, content, names
from mkt.figures.pictures import data_uri
from mkt.sequences.carphone import carphone

SCRIPT = "live.js"
FILES = "_static/live"  # of the site: NAME.js of each data
PLAYED = 75  # frames of the clip, a quarter of a megabyte less than all


def script() -> str:
    """The modules as one script that stands for itself."""
    return f'"use strict";\n(() => {{\n{bundle("start")}}})();\n'


def data() -> dict[str, bytes]:
    """{file name: content} of all data of live figures."""
    return {f"{name}.js": _assigned(name).encode() for name in names()}


def _assigned(name: str) -> str:
    told = json.dumps(name)
    return f"(globalThis.mktData ??= {{}})[{told}] = {json.dumps(content(name))};\n"


@DATA.register("track")
def _clip() -> dict[str, Any]:
    """The clip that the camera's page plays where there is no camera."""
    clip = carphone()
    film, _ = webm(islice(clip.frames, PLAYED), clip.fps)
    return {
        "film": data_uri("video/webm", film),
        "region": clip.truth[0].tolist(),
        "source": clip.source,
    }
