"""The controls of live figures stand only where there is something to show."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from mkt.figures.live import joined
from mkt.papers.lessons.benchmark import styles
from mkt.plotting import TRUTH
from mkt.trackers.by_name import quick
from tests.live.conftest import DOCUMENT, fixture_of
from tests.test_palette import BLINDNESS, DIFFERENT, contrast, seen

EXPORTS = """
export const { Canvas, Controls, legible, write } = page_js, { host } = host_js;
"""
CONTROLS = """
const { Controls, host } = live;
const seen = [];
Object.assign(host, { heard() {}, keep() {}, asked: () => data.words });
const each = (values) => seen.push({ ...values });
const controls = new Controls("own.toy", data.fields, each);
"""
# A pen whose letters are half as wide as high, and what it writes.
PEN = """
const written = [];
const pen = {
  font: "12px Arial", textAlign: data.align,
  high() { return parseFloat(this.font); },
  measureText(word) { return { width: (word.length * this.high()) / 2 }; },
  fillText(word, x, y) { written.push([word, x, y, this.high(), this.textAlign]); },
};
const width = live.write(pen, data.words, 100, 50);
return [written, width, pen.font, pen.textAlign];
"""
FREE = {"low": 0.4, "high": 1.4, "step": 0.1, "value": 1.0}
WHOLE = {"low": 0, "high": 4, "step": 2, "value": 0}
ONLY = {"low": 101, "high": 141, "step": 5, "value": 101, "only": True}

page = fixture_of(DOCUMENT + joined("page") + EXPORTS)


def read(engine, words, **fields):
    """The values that a link asks for, and what is said of it."""
    values, said = engine(
        CONTROLS + "controls.read(); return [seen[0], controls.note.textContent];",
        words=words,
        fields=fields,
    )
    return values, said


@pytest.mark.parametrize(
    "field, word, complaint",
    [
        (FREE, "9", "must be a number from 0.4 to 1.4"),
        (FREE, "", "must be a number from 0.4 to 1.4"),
        (FREE, "NaN", "must be a number from 0.4 to 1.4"),
        (WHOLE, "2.5", "must be a whole number from 0 to 4"),
        (WHOLE, "5", "must be a whole number from 0 to 4"),
        (ONLY, "103", "must be a whole number from 101 to 141 in steps of 5"),
        (ONLY, "Infinity", "must be a whole number from 101 to 141 in steps of 5"),
        ({"options": ["a", "b"], "value": "a"}, "c", "must be one of a, b"),
    ],
)
def test_a_link_to_what_a_control_cannot_show_says_so(page, field, word, complaint):
    values, said = read(page, f"toy={word}&other=1", toy=field, other=WHOLE)
    assert values == {"toy": field["value"], "other": 1}
    assert said == (
        f"In this page's address toy is {word or 'empty'}, but {complaint}. "
        "The rest was taken."
    )


@pytest.mark.parametrize("field, number", [(FREE, 0.77), (WHOLE, 3), (ONLY, 136)])
def test_a_link_to_what_a_control_can_show_is_followed(page, field, number):
    assert read(page, f"toy={number}", toy=field) == ({"toy": number}, "")


@pytest.mark.parametrize(
    "field, typed, taken",
    [
        (FREE, 0.77, 0.77),
        (FREE, 9, 1.4),
        (WHOLE, 3, 3),
        (WHOLE, 2.6, 3),
        (ONLY, 103, 101),
        (ONLY, 104, 106),
        (ONLY, 500, 141),
    ],
)
def test_a_control_moves_to_the_nearest_that_can_be_shown(page, field, typed, taken):
    found = page(
        CONTROLS + "controls.set({ toy: data.typed });"
        "return [seen[0].toy, Number(controls.inputs.toy.typed.value)];",
        fields={"toy": field},
        typed=typed,
    )
    assert found == [taken, pytest.approx(taken, abs=0.05)]


FAILING = """
const { Controls, host } = live;
Object.assign(host, { heard() {}, keep() {}, asked: () => null });
const fails = () => Promise.reject(new Error("there is no ground"));
const controls = new Controls("own.toy", data.fields, fails);
controls.set({ toy: 2 });
return new Promise((done) => setTimeout(() => done(controls.note.textContent), 50));
"""


def test_what_cannot_be_drawn_is_said(page):
    said = page(FAILING, fields={"toy": WHOLE})
    assert said == "This cannot be drawn: there is no ground."


GOING = """
const { Controls, host } = live;
let [asked, again] = [null, null];
const seen = [];
Object.assign(host, { heard: (call) => (again = call), keep() {}, asked: () => asked });
const each = ({ toy }, _, anew) => seen.push([toy, anew]);
const controls = new Controls("own.toy", data.fields, each);
const ask = (words) => ((asked = words), again());
controls.set({ toy: 0.9 });
ask("toy=0.9");  // as it stands
ask(null);       // of another figure
ask("toy=1.2");
ask("");         // as the page came
return seen;
"""


def test_what_is_asked_again_is_followed_where_it_is_something_else(page):
    found = page(GOING, fields={"toy": FREE})
    assert found == [[0.9, False], [1.2, True], [1.0, True]]


KEYS = """
const steps = [];
const canvas = new live.Canvas("", 1, () => {});
canvas.keyed((step) => steps.push(step));
for (const more of [{}, { altKey: true }, { ctrlKey: true }, { metaKey: true }]) {
  const event = new Event("keydown", { cancelable: true });
  Object.assign(event, { key: "ArrowLeft", ...more });
  canvas.node.dispatchEvent(event);
  steps.push(event.defaultPrevented);
}
return steps;
"""


def test_arrows_with_a_modifier_belong_to_the_browser(page):
    assert page(KEYS) == [[-1, 0], True, False, False, False]


BUTTONS = """
const begun = [];
const canvas = new live.Canvas("", 1, () => {});
canvas.placeOf = () => [0, 0];
canvas.node.setPointerCapture = () => {};
canvas.dragged(() => begun.push("drag"), () => {}, () => {});
for (const button of [0, 1, 2])
  canvas.node.dispatchEvent(Object.assign(new Event("pointerdown"), { button }));
return begun;
"""


def test_only_the_first_button_of_a_mouse_drags(page):
    assert page(BUTTONS) == ["drag"]


FINGERS = """
const heard = [];
const canvas = new live.Canvas("", 1, () => {});
canvas.placeOf = ({ clientX, clientY }) => [clientX, clientY];
canvas.node.setPointerCapture = () => {};
canvas.things = data.things ?? undefined;
canvas.dragged(
  (place) => heard.push(["begins", ...place]),
  (place) => heard.push(["follows", ...place]),
  () => heard.push(["ends"]),
);
for (const [name, pointerId, clientX, clientY, pointerType] of data.events) {
  const event = new Event(name, { cancelable: true });
  const more = { pointerId, clientX, clientY, pointerType, button: 0 };
  canvas.node.dispatchEvent(Object.assign(event, more));
  if (event.defaultPrevented) heard.push(["the page stays"]);
}
return heard;
"""
BOX = [[0, 0], [200, 0], [200, 100], [0, 100]]


def heard(page, things, *events):
    """What a canvas does: its things, and (name, pointer, x, y) of some events."""
    touches = [[*event, "touch"][:5] for event in events]
    return page(FINGERS, things=things, events=touches)


@pytest.mark.parametrize(
    "things, x, y, meant",
    [
        ([[[50, 50]]], 77, 50, True),
        ([[[50, 50]]], 79, 50, False),
        ([[[50]]], 77, 900, True),
        ([[[50]]], 79, 900, False),
        ([BOX], 100, 50, True),
        ([BOX[::-1]], 100, 50, True),
        ([BOX], 100, 105, False),
        ([BOX, [[100, 120]]], 100, 105, True),
        ([], 50, 50, False),
        (None, 50, 50, True),  # a box is drawn from anywhere
    ],
)
def test_a_finger_drags_at_once_what_it_lands_on_alone(page, things, x, y, meant):
    found = heard(page, things, ("pointerdown", 1, x, y), ("touchstart", 1, x, y))
    assert found == [["begins", x, y], ["the page stays"]] * meant


@pytest.mark.parametrize(
    "x, y, last, found",
    [
        (3, 4, "pointerup", [["begins", 90, 90], ["ends"]]),
        (3, 40, "pointerup", []),
        (3, 40, "pointercancel", []),
        (3, 4, "pointercancel", []),
        (40, 3, "pointerup", [["begins", 90, 90], ["follows", 130, 93], ["ends"]]),
    ],
)
def test_beside_all_things_a_finger_taps_or_goes_aside(page, x, y, last, found):
    events = [("pointerdown", 1, 90, 90), ("pointermove", 1, 90 + x, 90 + y)]
    events += [(name, 1, 90 + x, 90 + y) for name in (last, "lostpointercapture")]
    assert heard(page, [[[10, 10]]], *events) == found
    # And the next one is heard again.
    again = heard(page, [[[10, 10]]], *events, ("pointerdown", 2, 10, 10))
    assert again == [*found, ["begins", 10, 10]]


@pytest.mark.parametrize("x, begun", [(10, [["begins", 10, 10]]), (90, [])])
def test_a_second_finger_does_nothing(page, x, begun):
    second = [(name, 2, 10, 10) for name in ("pointerdown", "pointermove", "pointerup")]
    assert heard(page, [[[10, 10]]], ("pointerdown", 1, x, 10), *second) == begun


SHARPER = """
const lists = [];
globalThis.matchMedia = (words) => {
  const list = Object.assign(new EventTarget(), { words });
  lists.push(list);
  return list;
};
const canvas = new live.Canvas("", 1, () => {});
const drawn = [];
canvas.redraw = () => drawn.push(devicePixelRatio);
for (const ratio of [2, 1.5]) {
  const before = `(resolution: ${devicePixelRatio}dppx)`;
  Object.defineProperty(globalThis, "devicePixelRatio", {
    value: ratio, configurable: true, writable: true,
  });
  for (const list of lists.filter(({ words }) => words === before))
    list.dispatchEvent(new Event("change"));
}
return drawn;
"""


def test_on_a_screen_with_other_pixels_a_canvas_is_drawn_anew_each_time(page):
    assert page(SHARPER) == [2, 1.5]


POINTED = """
const heard = [];
const canvas = new live.Canvas("", 1, () => {});
canvas.placeOf = ({ clientX, clientY }) => [clientX, clientY];
canvas.node.setPointerCapture = () => {};
if (data.drags) canvas.dragged(() => {}, () => {}, () => {});
canvas.hovered((place, taps = false) => heard.push([place, taps]));
for (const [name, clientX, clientY] of data.events) {
  const more = { pointerType: data.kind, pointerId: 1, button: 0, clientX, clientY };
  canvas.node.dispatchEvent(Object.assign(new Event(name), more));
}
canvas.node.dispatchEvent(Object.assign(new Event("keydown"), { key: "Escape" }));
return heard;
"""
DOWN, MOVE, UP = (f"pointer{name}" for name in ("down", "move", "up"))
SCROLLS = [(DOWN, 9, 9), (MOVE, 9, 15), (MOVE, 9, 90), ("pointercancel", 9, 90)]
TAPS = [(DOWN, 9, 9), (MOVE, 9, 12), (UP, 9, 12)]
DRAGS = [(DOWN, 9, 9), (MOVE, 9, 60), (UP, 9, 60)]
NOTHING = [None, False]


@pytest.mark.parametrize(
    "kind, drags, events, meant",
    [
        ("touch", False, SCROLLS, []),
        ("touch", False, TAPS, [[[9, 12], True]]),
        ("touch", True, TAPS, [[[9, 12], True]]),
        ("touch", True, DRAGS, [NOTHING]),
        ("mouse", True, [(MOVE, 5, 5), *DRAGS], [[[5, 5], False], NOTHING]),
        ("mouse", False, DRAGS, [[[9, 60], False]]),
        ("pen", False, [(MOVE, 5, 5), ("pointerleave", 5, 5)], [[[5, 5], 0], NOTHING]),
    ],
)
def test_a_mouse_points_and_a_finger_taps_but_not_while_it_drags_or_scrolls(
    page, kind, drags, events, meant
):
    found = page(POINTED, kind=kind, drags=drags, events=events)
    assert found == [*meant, NOTHING]  # at last comes Escape


@pytest.mark.parametrize("kind", ["mouse", "pen"])
def test_a_mouse_and_a_pen_drag_from_anywhere(page, kind):
    event = ("pointerdown", 1, 90, 90, kind)
    assert heard(page, [[[10, 10]]], event) == [["begins", 90, 90]]


@pytest.mark.parametrize("align, left", [("left", 100.0), ("center", 86.5)])
def test_a_letter_behind_a_line_is_written_small_and_low(page, align, left):
    pieces = ["v", 0, 50, 12], ["x", 6, 53, 9], [" a", 10.5, 50, 12], ["n", 22.5, 53, 9]
    written = [[word, left + x, y, high, "left"] for word, x, y, high in pieces]
    found = page(PEN, words="v_x a_n", align=align)
    assert found == [written, 27.0, "12px Arial", align]


def test_curves_by_night_are_bright_and_differ_as_they_do_by_day(page):
    colors = sorted({style["color"] for style in styles(quick())} - {TRUTH})
    body = 'return data.colors.map((color) => live.legible({}, "#d1d1d1", color));'
    found = [night(color) for color in page(body, colors=colors)]
    lab = seen(["#d1d1d1", *found], BLINDNESS["none"])
    assert lab[:, 0].min() > 45
    ground = "#1a1c1e"  # of a panel by night
    assert min(contrast(color, ground) for color in found) >= 3
    assert min(np.linalg.norm(a - b) for a, b in combinations(lab, 2)) > DIFFERENT


def night(color):
    """A colour as a page writes it, "rgb(1 2 3)" or "#010203", as numbers to 1."""
    if color.startswith("#"):
        return to_rgb(color)
    return tuple(int(each) / 255 for each in color[4:-1].split())
