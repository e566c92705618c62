"""Scenes drawn by lot: a kind and a seed; a rule says what moves before what.

Seed k shows one of four items before one of four grounds, so that sixteen seeds are all
pairs of them, each on a path of its own.
"""

from dataclasses import dataclass

from mkt.checks import check_seed
from mkt.scenes import SCENES
from mkt.scenes.rendering import Scene
from mkt.tracking import Sequence

ITEMS = ("car", "astronaut", "motorcycle", "hopper")
GROUNDS = ("workshop", "tissue", "bricks", "grass")
# Seeds on which claims and trackers are judged, two of each pair, and on which nothing
# was ever tuned: the lower ones were looked at while the trackers were made.
HELD_BACK = range(1000, 1032)
FRESH = range(3000, 3032)  # on which claims are put to the test once more
TUNING = range(500, 516)  # on which constants were chosen; see each one's record


@dataclass(frozen=True)
class Drawn:
    """The specification of a scene of `mkt.scenes.SCENES`.

    Parameters
    ----------
    kind : str
        Its name there.
    seed : int
        Of its paths and its noise.
    item, ground : str
        Textures of the target and of the background.

    Raises
    ------
    ValueError
        For a seed that is none.
    """

    kind: str
    seed: int = 0
    item: str = "car"
    ground: str = "workshop"

    def __post_init__(self):
        check_seed(self.seed)

    @property
    def name(self) -> str:
        """What tables call it: its kind."""
        return self.kind

    def scene(self) -> Scene:
        """The `Scene`.  Raises UnknownName, a ValueError, for an unknown kind."""
        return SCENES[self.kind](self.seed, self.item, self.ground)

    def sequence(self) -> Sequence:
        """The `Sequence`."""
        return self.scene().sequence(self.kind)


def drawn(kind: str, seed: int) -> Drawn:
    """The scene that the rule of this module gives to a seed.

    Raises
    ------
    ValueError
        For a seed that is none.
    """
    check_seed(seed)
    return Drawn(kind, seed, ITEMS[seed % 4], GROUNDS[seed // 4 % 4])
