"""A live figure in JupyterLab: one kernel for all of its cells, and nothing stays."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from mkt.evaluation import success
from mkt.figures import explore
from mkt.figures.live import bundle, content
from mkt.papers.lessons import benchmark
from mkt.trackers import by_name
from tests.live.conftest import DOCUMENT, fixture_of, in_browser

MODULE = (
    f"{DOCUMENT}{bundle('widget')}export const {{ initialize, render }} = widget_js;"
)
# A kernel that sends what `data.kept` has at once, and all that still runs: {what}.
MODEL = """
const running = new Set();
const counted = (name, begin, end) => {
  globalThis[name] = class extends globalThis[name] {
    constructor(...about) {
      super(...about);
      running.add(this);
    }
    [end]() {
      running.delete(this);
      super[end]();
    }
  };
};
counted("ResizeObserver", "observe", "disconnect");
counted("MutationObserver", "observe", "disconnect");
counted("Worker", "postMessage", "terminate");
globalThis.matchMedia = () => ({
  addEventListener: (_, again) => running.add(again),
  removeEventListener: (_, again) => running.delete(again),
});
globalThis.setInterval = (work) => running.add(work) && work;
globalThis.clearInterval = (work) => running.delete(work);

const [hearing, following] = [[], []];
const answer = (message) => hearing.forEach((hear) => hear(message));
const model = {
  asked: [],
  moved: {},
  get: (name) => model[name] ?? data[name],
  set(name, value) {
    // As Backbone compares; the very object that it has is never news.
    if (JSON.stringify(model[name]) === JSON.stringify(value)) return;
    model[name] = value;
    for (const hear of following) hear();
  },
  save_changes() {},
  on: (what, hear) => (what === "change:moved" ? following : hearing).push(hear),
  off: (_, hear) => following.splice(following.indexOf(hear), 1),
  send({ name }) {
    model.asked.push(name);
    if (data.kept?.[name]) answer({ name, data: data.kept[name] });
  },
};
const rest = (ms = 50) => new Promise((next) => setTimeout(next, ms));
const until = async (found) => {
  for (let tries = 0; tries < 1000 && !found(); tries++) await rest(10);
};
const texts = (cell) => [...cell.querySelectorAll("p")].map((p) => p.textContent);
const cells = [0, 1].map(() => document.createElement("div"));
live.initialize({ model });
const ends = cells.map((el) => live.render({ model, el }));
"""

widget = fixture_of(MODULE)


@pytest.fixture
def in_a_browser(browser):
    """The widget where there are pictures, too."""
    with in_browser(browser) as engine:
        engine.load(MODULE)
        yield engine


def shown(engine, name, body, **data):
    """What a body tells of a figure in two cells."""
    about = {"name": name, "caption": "", "first": explore(name).first}
    return engine(f"return (async () => {{ {MODEL} {body} }})();", **about, **data)


def test_one_answer_of_the_kernel_is_for_all_cells_of_a_figure(widget):
    trackers = explore("own.success").first["own.success"]["trackers"]
    runs = {"seen": [[0.9, 0.1]] * len(trackers), "frames": 2}
    body = """
    await rest();
    answer({ name: "what another browser asked for", data: null });
    answer({ name: model.asked[0], data: data.runs });
    await rest();
    return { asked: model.asked, said: cells.map(texts) };
    """
    found = shown(widget, "own.success", body, runs=runs)
    assert found["asked"] == ["success-occlusion-0"]
    for words in found["said"]:
        assert any("At a limit of 0.2: first are (1)" in each for each in words)


def test_what_the_kernel_could_not_answer_is_said_and_asked_for_again(widget):
    trackers = explore("own.success").first["own.success"]["trackers"]
    runs = {"seen": [[0.9, 0.1]] * len(trackers), "frames": 2}
    body = """
    await rest();
    const busy = () =>
      [...cells[0].querySelectorAll("*")]
        .map((node) => node.getAttribute("aria-busy"))
        .filter((state) => state);
    const seen = [busy()];
    answer({ name: model.asked[0], error: "it was stopped" });
    await rest();
    seen.push(busy(), texts(cells[0]));
    model.set("moved", { limit: 0.3 });
    await rest();
    answer({ name: model.asked[1], data: data.runs });
    await rest();
    return { asked: model.asked, seen, now: texts(cells[0]) };
    """
    found = shown(widget, "own.success", body, runs=runs)
    assert found["asked"] == ["success-occlusion-0"] * 2
    *busy, words = found["seen"]
    assert busy == [["true"], ["false"]]
    assert any("cannot be drawn: it was stopped." in each for each in words)
    assert not any("run over this scene" in each for each in words)
    assert any("At a limit of 0.3" in each for each in found["now"])


def test_a_kernel_that_has_gone_is_said_each_time(widget):
    """Jupyter's own words say nothing, and an answer never comes."""
    body = """
    await rest();
    model.send = () => { throw new Error("Cannot send"); };
    const said = [];
    for (const item of ["cat", "car", "cat"]) {
      model.set("moved", { item });
      await rest();
      said.push(texts(cells[0]).filter((each) => each.includes("its kernel has gone")));
    }
    return said.map(({ length }) => length);
    """
    assert shown(widget, "teuliere2009.fig3", body) == [1, 0, 1]


def test_surfaces_of_an_object_that_did_not_come_are_asked_for_again(widget):
    body = """
    await rest();
    model.set("moved", { item: "cat" });
    await rest();
    answer({ name: model.asked[0], error: "it was stopped" });
    await rest();
    const said = texts(cells[0]);
    model.set("moved", { item: "cat", rotation: 3 });
    await rest();
    return { asked: model.asked, said };
    """
    found = shown(widget, "teuliere2009.fig3", body)
    assert found["asked"] == ["surfaces-cat-hsv"] * 2
    assert any("cannot be drawn: it was stopped." in each for each in found["said"])


def test_trackers_that_tie_are_ranked_by_their_area_in_both_languages(widget):
    names = by_name.quick()
    iou = np.tile([0.9, 0.1], (len(names), 1))
    iou[:, 0] -= np.arange(len(names)) % 4 / 10  # all are above .2, and some areas tie
    area, half = success(iou).mean(1), np.full(len(names), 0.5)
    ax = Figure().subplots()
    benchmark._draw_ranking(ax, names, half, half, area)
    drawn = [text.get_text() for text in ax.get_yticklabels()][::-1]
    assert drawn[0] == by_name.LABELS[names[0]]
    body = """
    await rest();
    answer({ name: model.asked[0], data: data.runs });
    await rest();
    return texts(cells[0]).find((text) => text.startsWith("At a limit"));
    """
    runs = {"seen": iou.tolist(), "frames": 2}
    said = shown(widget, "own.success", body, runs=runs)
    assert sorted(drawn, key=said.index) == drawn


MOVE = """
const gains = (cell) => cell.querySelector("[aria-label='gain [1/s], as a number']");
await until(() => cells.every(gains));
gains(cells[0]).value = "3";
gains(cells[0]).dispatchEvent(new Event("change"));
const later = document.createElement("div");
live.render({ model, el: later });
await until(() => gains(later));
return [...cells, later].map((cell) => Number(gains(cell).value));
"""


@pytest.mark.slow
def test_all_cells_show_what_was_moved_in_one_and_those_that_come_later_too(
    in_a_browser,
):
    assert shown(in_a_browser, "own.root_locus", MOVE) == [3, 3, 3]


@pytest.mark.slow
def test_a_cell_that_is_gone_follows_nothing_any_more(in_a_browser):
    body = """
    await until(() => following.length === 2);
    ends[0]();
    const one = following.length;
    ends[1]();
    return [one, following.length];
    """
    assert shown(in_a_browser, "own.root_locus", body) == [1, 0]


@pytest.mark.slow
def test_the_second_move_is_told_to_the_kernel_as_the_first_one_is(in_a_browser):
    body = """
    const told = [];
    following.push(() => told.push(model.moved.gain));
    const typed = "[aria-label='gain [1/s], as a number']";
    await until(() => cells.every((cell) => cell.querySelector(typed)));
    for (const gain of [3, 2, 1.5]) {
      const input = cells[0].querySelector(typed);
      input.value = gain;
      input.dispatchEvent(new Event("change"));
    }
    return told;
    """
    assert shown(in_a_browser, "own.root_locus", body) == [3, 2, 1.5]


PLAY = """
const play = [...cell.querySelectorAll("button")].find((b) => b.textContent === "play");
play?.dispatchEvent(new Event("click"));
"""
LEFT = f"""
await until(() => running.size >= data.least);
for (const cell of cells) {{ {PLAY} }}
const before = running.size;
ends[0]();
await rest();
const one = running.size;
ends[1]();
await rest();
return [before, one, running.size];
"""


# Of each canvas two observers, the colours of the night and the pixels of the screen,
# and what plays.
@pytest.mark.parametrize(
    "name, each",
    [("own.root_locus", 8), ("cordoba2014.complexity", 9), ("own.success", 8)],
)
def test_nothing_of_a_figure_runs_on_when_its_cell_is_gone(widget, name, each):
    assert shown(widget, name, LEFT, least=12) == [2 * each, each, 0]


@pytest.mark.slow
def test_the_worker_of_figure_6_ends_with_its_cell(in_a_browser):
    name = "teuliere2009.fig6"
    kept = {name: content(name) for name in ("own.beats", "workshop")}
    assert shown(in_a_browser, name, LEFT, kept=kept, least=18) == [20, 10, 0]
    soon = "ends.forEach((end) => end()); await until(() => running.size >= 18);"
    soon += "await until(() => !running.size); return 'none';"
    assert shown(in_a_browser, name, soon, kept=kept) == "none"


@pytest.mark.slow
def test_a_typed_frame_is_the_nearest_of_which_there_are_data(in_a_browser):
    body = """
    const [cell] = cells;
    await until(() => texts(cell).some((words) => words.startsWith("Frame 101")));
    const typed = cell.querySelector("[aria-label='frame, as a number']");
    typed.value = "104";
    typed.dispatchEvent(new Event("change"));
    await until(() => texts(cell).some((words) => words.startsWith("Frame 106")));
    return [typed.value, model.moved.frame, model.asked];
    """
    kept = {"doors-106": content("doors-106")}
    found = shown(in_a_browser, "nummiaro2003.fig3", body, kept=kept)
    assert found == ["106", 106, ["doors-106"]]
