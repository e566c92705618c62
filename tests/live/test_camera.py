"""The camera's page tracks what the reader means: the last box, and no earlier one."""

import pytest

from mkt.figures.live import joined
from tests.live.conftest import DOCUMENT, fixture_of

EXPORTS = "\nexport const { camera } = camera_js, { host } = host_js;"
# A place for the camera's page, under an address that asks for nothing.
PLACE = """
const { camera, host } = live;
Object.assign(host, { heard() {}, keep() {}, asked: () => null });
const place = document.createElement("div");
place.replaceChildren = (...nodes) => place.append(...nodes);
"""
READER = """
const sent = [];
const page = camera(place, { postMessage: ({ kind }) => sent.push(kind) });
page.small = { width: 32, height: 24 };
page.pen = { drawImage() {}, getImageData: () => ({ data: new Uint8ClampedArray(4) }) };
page.box = [16, 12, 0, 5, 5];
page.start();
if (data.again) page.choose();
page.hear({ kind: "learn" });
page.look();
return [sent, page.tracking];
"""

LIKELY = """
globalThis.ImageData ??= class {};
host.asked = () => `lambda=${data.lambda}`;
const page = camera(place, { postMessage() {} });
page.pen = { putImageData() {} };
Object.assign(page, { tracking: true, times: [] });
const found = { lost: false, distance: 0.5, nEff: 1, cost: 1, steps: 1 };
const small = { data: new Uint8ClampedArray(4), width: 1, height: 1 };
page.hear({ kind: "step", picture: small, ...found });
return page.numbers.textContent;
"""

STOPPED = """
const page = camera(place, { postMessage() {} });
const done = [];
page.video = {
  srcObject: { getTracks: () => [{ stop: () => done.push("camera off") }] },
  pause: () => done.push("clip paused"),
};
Object.assign(page, { small: {}, box: [16, 12, 0, 5, 5], tracking: true });
[...place.querySelectorAll("button")]
  .find(({ textContent }) => textContent === "Stop")
  .dispatchEvent(new Event("click"));
return [done.sort(), page.small, page.box, page.tracking];
"""

# A film of a given size, chosen: the picture that is tracked, and if a finger draws.
CHOSEN = """
const page = camera(place, { postMessage() {} });
const opened = [];
const draws = () => page.stage.node.classList.contains("mkt-drag");
const before = draws();
const all = document.createElement("canvas").constructor.prototype;
all.getContext = () => ({});
page.video = {
  videoWidth: data.width, videoHeight: data.height,
  play() {}, pause() {}, requestVideoFrameCallback() {},
};
page.clip = (why) => opened.push(why);
const file = Object.assign(new Blob([data.content], data), { name: data.name });
Object.defineProperty(page.picker, "files", { value: [file] });
Object.defineProperty(page.picker, "value", { value: "film.webm", writable: true });
page.picker.dispatchEvent(new Event("change"));
await new Promise((next) => setTimeout(next, 20));
const side = (name) => (page.small.width ? page.small : page.small.attributes)[name];
const size = page.small && ["width", "height"].map(side);
return [opened, size, page.picker.value, before, draws()];
"""


ANEW = """
const page = camera(place, { postMessage() {} });
Object.assign(page, { small: { width: 32, height: 24 }, box: [16, 12, 0, 5, 5] });
[...place.querySelectorAll("button")]
  .find(({ textContent }) => textContent === "Draw another box")
  .dispatchEvent(new Event("click"));
return [page.box, page.said.textContent];
"""


page = fixture_of(DOCUMENT + joined("camera") + EXPORTS)


@pytest.mark.parametrize(
    "again, sent", [(False, ["learn", "step"]), (True, ["learn"])], ids=["one", "anew"]
)
def test_what_was_learnt_of_an_earlier_box_is_not_tracked(page, again, sent):
    assert page(PLACE + READER, again=again) == [sent, not again]


@pytest.mark.parametrize("strength, likelihood", [(1, 0.78), (20, 0.01)])
def test_the_likelihood_is_that_of_the_lambda_that_is_set(page, strength, likelihood):
    assert f"likeness {likelihood:.2f}" in page(PLACE + LIKELY, **{"lambda": strength})


def test_stop_switches_the_camera_off_and_leaves_no_picture(page):
    assert page(PLACE + STOPPED) == [["camera off", "clip paused"], None, None, False]


def test_who_draws_another_box_sees_the_old_one_no_more(page):
    words = "Draw a box round something, then track it."
    assert page(PLACE + ANEW) == [None, words]


def chosen(page, width, height, **file):
    body = f"return (async () => {{ {PLACE} {CHOSEN} }})();"
    film = {"name": "film.mkv", "type": "", "content": "a film"}
    return page(body, width=width, height=height, **film | file)


@pytest.mark.parametrize(
    "file, why",
    [
        ({}, "This browser cannot play film.mkv"),
        ({"type": "video/webm"}, "This browser cannot play film.mkv"),
        ({"name": "notes.txt", "type": "text/plain"}, "notes.txt is no video"),
        ({"type": "video/webm", "content": ""}, "film.mkv is empty"),
    ],
)
def test_a_film_without_a_picture_leads_to_the_clip(page, file, why):
    [words], small, *_ = chosen(page, 0, 0, **file)
    assert words == why and small is None


def test_a_flat_film_has_a_picture_and_can_be_chosen_again(page):
    assert chosen(page, 1600, 2) == [[], [320, 1], "", False, True]


UNLOADED = """
host.load = async () => { throw new Error("its file is missing"); };
const page = camera(place, { postMessage() {} });
await page.clip(data.why);
const said = page.said.textContent;
page.end();
[...place.querySelectorAll("button")]
  .find(({ textContent }) => textContent === "Draw another box")
  .dispatchEvent(new Event("click"));
return [said, page.said.textContent];
"""


@pytest.mark.parametrize("why", ["", "No camera was found"])
def test_a_clip_that_cannot_be_loaded_is_said_behind_the_reason_for_it(page, why):
    body = f"return (async () => {{ {PLACE} {UNLOADED} }})();"
    said, then = page(body, why=why)
    expected = "The book's clip cannot be shown: its file is missing."
    assert said == (f"{why}. {expected}" if why else expected)
    # There is nothing yet that a box could be drawn round.
    assert then.startswith("Choose what to look at.")


LATE = """
const page = camera(place, { postMessage() {} });
let grant;
const done = [];
const stream = { getTracks: () => [{ stop: () => done.push("camera off") }] };
const getUserMedia = () => new Promise((resolve) => (grant = () => resolve(stream)));
globalThis.navigator ??= {};
const value = { getUserMedia };
Object.defineProperty(navigator, "mediaDevices", { value, configurable: true });
page.video = { pause() {} };
page.camera();
page.sources++; // another source was chosen meanwhile
grant();
return new Promise((next) => setTimeout(() => next(done), 20));
"""


def test_a_camera_that_is_granted_too_late_is_switched_off(page):
    assert page(PLACE + LATE) == ["camera off"]


REFUSED = """
Object.defineProperty(globalThis, "isSecureContext", {
  value: data.secure, configurable: true,
});
globalThis.navigator ??= {};
Object.defineProperty(navigator, "mediaDevices", {
  value: undefined, configurable: true,
});
const page = camera(place, { postMessage() {} });
const said = [];
page.clip = (why) => said.push(why);
await page.camera();
return said;
"""


@pytest.mark.parametrize(
    "secure, why",
    [
        (True, "No camera can be used on this page"),
        (
            False,
            "Browsers give a camera only to pages that come by https "
            "or lie on this machine",
        ),
    ],
)
def test_a_page_that_gets_no_camera_says_why(page, secure, why):
    body = f"return (async () => {{ {PLACE} {REFUSED} }})();"
    assert page(body, secure=secure) == [why]
