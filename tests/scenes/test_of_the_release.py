"""Scenes are those on which the numbers in data/ were measured, to the last way-point.

Behaviour is tested elsewhere; a scene that is a little easier would still pass there.
"""

import hashlib
import re
from dataclasses import replace
from functools import partial

import pytest

from mkt.scenes import SCENES, cards, nummiaro2003, varied
from mkt.scenes.drawn import HELD_BACK, drawn


def _drawn(kind, seed):
    return drawn(kind, seed).scene()


def _varied(kind, seed):
    return varied.Varied(kind, seed).scene()


MADE = {kind: partial(_drawn, kind) for kind in SCENES}
MADE |= {f"card {kind}": partial(cards.card, kind) for kind in cards.KINDS}
MADE |= {f"varied {kind}": partial(_varied, kind) for kind in varied.KINDS}
MADE |= {
    f"traffic {look}": partial(nummiaro2003.traffic, look=look)
    for look in nummiaro2003.LOOKS
}
MADE |= {
    f"parking {target}": partial(nummiaro2003.parking, target=target)
    for target in ("car", "person")
}
MADE["students"] = nummiaro2003.students
KNOWN = {
    "background": "70e15d6e",
    "base": "135b6285",
    "blur": "840b68ed",
    "clutter": "a7a4ad1d",
    "fast": "b93d5680",
    "hidden": "c08d359d",
    "illumination": "70afe289",
    "look-alike": "cae39461",
    "occlusion": "59f753db",
    "passers": "aa49902b",
    "pillars": "5cd1ae54",
    "scale": "f9848331",
    "trajectory": "91a57c9f",
    "card base": "2853a775",
    "card blur": "09dfb220",
    "card noise": "31db08d2",
    "card occlusion": "e4338943",
    "varied light": "a27f6f84",
    "varied noise": "e1cb65df",
    "varied cut-out": "a46f4841",
    "varied car": "df924f56",
    "varied calm": "5f33dc78",
    "varied swift": "95602dca",
    "traffic fades": "588ee841",
    "traffic turns": "833cc619",
    "traffic same": "5bf60213",
    "parking car": "6ab72a77",
    "parking person": "453012c4",
    "students": "5025f34c",
}


def fingerprint(scenes):
    """Of all that they are made of, numbers to nine digits.

    The last ones differ from processor to processor, and from one numpy to another.
    """

    def rounded(number):
        return f"{float(number[0]) + 0.0:.9g}"  # and -0.0 is 0

    words = re.sub(r"-?\d+\.\d+(?:e[-+]\d+)?", rounded, repr(scenes))
    words = re.sub(r"np\.str_\(('[^']*')\)", r"\1", words)
    return hashlib.sha256(words.encode()).hexdigest()[:8]


@pytest.mark.parametrize("kind", MADE)
def test_scenes_are_those_of_the_release(kind):
    found = fingerprint([MADE[kind](seed) for seed in HELD_BACK])
    assert kind in KNOWN, f"the scenes {kind!r} are new: write {found!r} here"
    assert found == KNOWN[kind], (
        f"the scenes {kind!r} are no longer those on which the tables in data/ were "
        "made. Was that meant? Then measure anew, `python -m mkt bench tracking "
        "--release` and `python -m mkt claims --release`, unless the frames are the "
        f"same, as with a new field at its default; and write {found!r} here"
    )


def test_a_fingerprint_sees_a_changed_number_but_not_its_last_digit():
    scene = SCENES["base"](1000)
    wider = [
        replace(scene, target=replace(scene.target, width=80.0 * factor))
        for factor in (1 + 1e-13, 1 - 1e-13, 1 + 1e-6)
    ]
    same, too, other = map(fingerprint, wider)
    assert fingerprint(scene) == same == too != other
