"""The sequences of [N03], rebuilt: seed -> `Scene`.

The head of figure 10 is in `mkt.sequences.carphone`.

The paper's videos (PETS2001, students before a university, a factory) cannot be had;
these scenes ask of a tracker what the paper says that they asked.  Paths vary with the
seed, around a common story.  People, van and tree are painted (`mkt.scenes.objects`);
the van's side has other colours than its rear.
"""

import numpy as np

from mkt.checks import check_known
from mkt.scenes.layers import Layer
from mkt.scenes.paths import Path, as_path, lots, standing, way
from mkt.scenes.rendering import Scene
from mkt.types import Array

STUDENTS, TREE = 222, 101  # frames of figure 6, and that behind the tree: printed
# Frames of the two short occlusions: ours, figure 7 is not legible in our copy.
PASSES = 45, 165
TREE_X, TREE_WIDTH = 160.0, 76.0  # [px]
RAISED = 0.3  # of the tree's width, its middle above the student's: it hides all
PERSON = 30.0  # width of a student [px]
PASSERS = "passer in blue", "passer in green"
PACE = 8.0  # [px/frame] at which others pass
WALKER = 22.0  # width of the person on the parking place [px]
REAR = "van from behind"
SIDE = Layer("van from the side", 80.0, standing(0, 0))
LOOKS = "fades", "turns", "same"  # what becomes of the van in traffic
CAR_WIDTHS = {"parking": 80.0, "traffic": 72.0}  # [px]


def students(seed: int, tree: float = TREE_WIDTH) -> Scene:
    """Figures 6 and 7: a student walks from the left to the right and leaves the view.

    Two others come from the right, in other clothes, and hide most of the student for a
    few frames.  The student is out of the view after about frame 205.

    Parameters
    ----------
    seed : int
    tree : float [px]
        Its width; ours hides all of the student for 29 to 34 frames around frame 99.
    """
    rng = lots(11, seed)
    times = np.arange(0.0, STUDENTS + 12, 11)
    straight = np.interp(times, [0, TREE, STUDENTS], [30, TREE_X, 365])
    unsteady = rng.normal(0, 1.5, len(times)) * (np.abs(times - TREE) > 15)
    x = straight + unsteady
    y = rng.uniform(115, 145) + np.cumsum(rng.normal(0, 2, len(times)))
    others = [
        Layer(name, 1.1 * PERSON, _passing(times, x, y, frame))
        for frame, name in zip(PASSES, rng.permutation(PASSERS), strict=True)
    ]
    height = np.interp(TREE, times, y) - RAISED * tree
    standing_tree = Layer("tree", float(tree), way([0], TREE_X, height))
    target = Layer("student", PERSON, way(times, x, y))
    return Scene(target, "campus", STUDENTS, front=(*others, standing_tree), seed=seed)


def _passing(times: Array, x: Array, y: Array, frame: int) -> Path:
    """The path of somebody who comes from the right and meets this one at a frame."""
    place, height = np.interp(frame, times, x), np.interp(frame, times, y)
    ends = np.array([0, times[-1]])
    return way(ends, place - PACE * (ends - frame), height)


def doors(scene: Scene) -> tuple:
    """Where the student of a scene may appear again, as zones of a tracker.

    They are the two sides of the tree, and "borders", those of the image.
    """
    tree = scene.front[-1]
    _, x, height, *_ = tree.path[0]
    y = height + RAISED * tree.width
    beside = (tree.width + PERSON) / 2
    spread = PERSON / 3, PERSON / 3
    return (x - beside, y, *spread), (x + beside, y, *spread), "borders"


def parking(seed: int, target: str = "car") -> Scene:
    """Figure 4: a parking place seen from a window, 150 frames.

    A person walks, and a van comes closer, to double its size, and turns its side.

    Parameters
    ----------
    seed : int
    target : {"car", "person"}
        The other one moves behind.

    Raises
    ------
    ValueError
        For any other target.
    """
    rng = lots(12, seed)
    layers = {"person": _walker(rng), "car": _turning_car(rng)}
    check_known("target", target, layers)
    chosen = layers.pop(target)
    behind = tuple(layers.values())
    return Scene(chosen, "parking place", 150, behind=behind, seed=seed)


def _walker(rng) -> Layer:
    times = np.arange(0.0, 176, 25)
    x = np.linspace(40, 250, 8) + rng.normal(0, 5, 8)
    y = np.linspace(205, 150, 8) + rng.normal(0, 5, 8)
    return Layer("student", WALKER, way(times, x, y))


def _turning_car(rng) -> Layer:
    times = np.arange(0.0, 176, 25)
    x = np.linspace(270, 90, 8) + rng.normal(0, 6, 8)
    y = np.linspace(45, 120, 8) + rng.normal(0, 4, 8)
    path = way(times, x, y, scale=np.linspace(0.6, 1.3, 8))
    turn = (50.0, 0.0), (110.0, 0.5)
    return Layer(REAR, CAR_WIDTHS["parking"], path, view=SIDE, turn=turn, box=True)


def traffic(seed: int, look: str = "fades", growth: float = 1.8) -> Scene:
    """Figures 8 and 9: a van ahead, seen from a car, 150 frames.

    It moves fast on the screen, grows by a factor, and changes its look.

    Parameters
    ----------
    seed : int
    look : {"fades", "turns", "same"}
        "fades", all of its rear slowly takes the colours of its side; "turns", it is a
        box whose side comes to sight while its rear goes away; "same", nothing but its
        size changes.
    growth : float

    Raises
    ------
    ValueError
        For any other look.
    """
    check_known("look", look, LOOKS)
    rng = lots(13, seed)
    times = np.arange(0.0, 176, 25)
    x = np.clip(160 + np.cumsum(rng.normal(0, 22, 8)), 90, 230)
    y = 120 + rng.normal(0, 10, 8)
    scales = growth ** np.clip((times - 15) / 110, 0, 1)
    beats = np.arange(0.0, 161, 10)
    shake = rng.normal(0, 4, (len(beats), 2))
    still = np.column_stack([np.zeros(len(beats)), np.ones(len(beats))])
    camera = as_path(np.column_stack([beats, shake, still]))
    view = None if look == "same" else SIDE
    path = way(times, x, y, scale=scales)
    turn = ((15.0, 0.0), (135.0, 1.0))
    width = CAR_WIDTHS["traffic"]
    box = look == "turns"
    van = Layer(REAR, width, path, view=view, turn=turn, box=box)
    return Scene(van, "street", 150, camera=camera, seed=seed)
