"""Parts: where they begin, what is in them, and that they are jobs of their own."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.evaluation import SEEN
from mkt.regions import HX
from mkt.sequences import parts as made
from mkt.sequences.parts import Part, parts
from mkt.tracking import Sequence

visibilities = st.lists(st.sampled_from([0.0, 0.4, 0.6, 1.0]), min_size=2, max_size=40)


@dataclass(frozen=True)
class Whole:
    """A sequence whose frames, regions and names are their numbers."""

    visibility: list = field(default_factory=list)
    name: str = "whole"

    def identity(self):
        return self.name

    def sequence(self):
        numbers = np.arange(len(self.visibility), dtype=float)
        truth = np.repeat(numbers[:, None], 5, 1)
        truth[:, HX:] += 1  # what has no area is not seen
        seen = np.array(self.visibility)
        return Sequence(self.name, list(range(len(seen))), truth, seen, upright=True)


@given(visibilities, st.integers(1, 8))
def test_parts_begin_where_the_target_is_seen_each_in_a_frame_of_its_own(seen, n):
    all_parts = parts(Whole(seen), n)
    begun = [(part.start, part.way) for part in all_parts]
    assert len(set(begun)) == len(begun) <= 2 * n
    assert all(seen[start] > SEEN for start, _ in begun)
    assert all((part.sequence().visibility[1:] > SEEN).any() for part in all_parts)
    ways = [way for _, way in begun]
    assert ways == sorted(ways, reverse=True)  # forwards first
    there = np.flatnonzero(np.array(seen) > SEEN)
    if len(there) > 1:
        # From the first frame in which it is seen, and back from the last one.
        assert begun[0] == (there[0], 1) and (there[-1], -1) in begun


@given(visibilities, st.data())
def test_a_part_is_the_whole_from_its_start_on_either_way(seen, data):
    start = data.draw(st.integers(0, len(seen) - 1))
    whole = Whole(seen).sequence()
    there = Part(Whole(seen), start).sequence()
    back = Part(Whole(seen), start, -1).sequence()
    assert list(there.frames) == list(range(start, len(seen)))
    assert list(back.frames) == list(range(start, -1, -1))
    for part in (there, back):
        numbers = list(part.frames)
        assert (part.truth[:, 0] == numbers).all()
        assert (part.visibility == whole.visibility[numbers]).all()
        assert part.upright and part.name == "whole"


@pytest.mark.parametrize("way", [1, -1])
def test_a_part_is_no_longer_than_is_said(way):
    whole = Whole([1.0] * (2 * made.LONGEST))
    frames = Part(whole, made.LONGEST, way).sequence().frames
    assert len(frames) == made.LONGEST
    assert frames[-1] == made.LONGEST + way * (made.LONGEST - 1)


def test_a_part_that_meets_the_first_frame_ends_there():
    frames = Part(Whole([1.0] * (2 * made.LONGEST)), 100, -1).sequence().frames
    assert list(frames) == list(range(100, -1, -1))


def test_starts_are_spread_and_leave_something_to_track():
    begun = [part.start for part in parts(Whole([1.0] * 301), 3)]
    last = 300
    spread = [0, (last - made.SHORTEST) // 2, last - made.SHORTEST]
    assert begun == spread + [last - k for k in spread]


def test_a_short_sequence_is_halved_at_most():
    made_of = parts(Whole([1.0] * 40), 3)
    lengths = [len(part.sequence()) for part in made_of]
    assert lengths == [40, 30, 21] * 2 and len(made_of) == 6


def test_each_part_is_another_source_under_the_name_of_the_whole():
    every = parts(Whole([1.0] * 200), 4)
    assert len({part.identity() for part in every}) == len(every) == 8
    assert {part.name for part in every} == {"whole"}
    assert Part(Whole(), 5).identity() != Part(Whole(), 5, -1).identity()
