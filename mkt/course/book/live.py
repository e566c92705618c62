"""What computes in the pages: one script for all of them, and a script for each data.

Data are scripts too, since pages on a disk may not fetch.
"""

import json
from itertools import islice
from typing import Any

from mkt.figures.data_uri import data_uri
from mkt.figures.film import webm
from mkt.figures.live import DATA, bundle, content, names
from mkt.sequences.carphone import carphone

SCRIPT = "live.js"
PLAYED = 75  # frames of the clip, a quarter of a megabyte less than all


def scripts() -> dict[str, str]:
    """{name below the static folder: text} of all that the live figures need."""
    return {SCRIPT: script()} | {
        f"live/{name}.js": f"(globalThis.mktData ??= {{}})[{json.dumps(name)}] = "
        f"{json.dumps(content(name))};\n"
        for name in names()
    }


def script() -> str:
    """The modules as one script that stands for itself."""
    return f'"use strict";\n(() => {{\n{bundle("start")}}})();\n'


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
