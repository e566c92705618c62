"""The page's engine, run by a browser and, where there is one, by node."""

import base64
import json
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from mkt.figures.live import EXPORT, MODULES, _word, calls, maker, needed, source
from tests.browser.conftest import browser, driver  # noqa: F401, fixtures

METHOD = sorted(f"method/{path.stem}" for path in (MODULES / "method").glob("*.js"))


def _exported(name):
    """The line that hands on what a bundled module exports."""
    words = ", ".join(found for _, found in EXPORT.findall(source(name)))
    return f"export const {{ {words} }} = {_word(name)}_js;\n"


def _engine():
    """All modules of the method as one."""
    ordered = list(dict.fromkeys(module for name in METHOD for module in needed(name)))
    made = "".join(map(maker, ordered)) + calls(ordered)
    return made + "".join(map(_exported, METHOD))


ENGINE = _engine()
# Where node takes the place of a browser's page.
DOCUMENT = Path(__file__).with_name("document.js").read_text("utf-8")
# A text as a module, and what a function body makes of it and of some data, as JSON.
LOAD = """async (text) => {
  const url = `data:text/javascript,${encodeURIComponent(text)}`;
  globalThis.live = await import(url);
}"""
CALL = """async ([body, data]) => {
  const flat = (key, value) => (ArrayBuffer.isView(value) ? [...value] : value);
  return JSON.stringify(await new Function("live", "data", body)(live, data), flat);
}"""
IN_NODE = f"""
import {{ createInterface }} from "node:readline";
for await (const line of createInterface({{ input: process.stdin }})) {{
  const {{ load, call }} = JSON.parse(line);
  if (load) await ({LOAD})(load);
  console.log(load ? "null" : await ({CALL})(call));
}}
"""
# What bodies need beside the engine: pictures travel as base64 of their bytes.
HELP = """
const bytes = (text) => Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
const picture = ({ rgba, width, height }) => ({ data: bytes(rgba), width, height });
"""


class Engine:
    """The engine's functions as ``live`` in bodies of JavaScript functions."""

    def __init__(self, load, call):
        self._call = call
        load(ENGINE)
        self.load = load

    def __call__(self, body, **data):
        """What a body returns for ``data``."""
        return json.loads(self._call([HELP + body, data]))


@contextmanager
def in_node():
    """An engine in a process of its own."""
    program = [shutil.which("node"), "--input-type=module", "--eval", IN_NODE]
    pipe = subprocess.PIPE
    with subprocess.Popen(program, stdin=pipe, stdout=pipe, text=True) as process:

        def ask(**question):
            print(json.dumps(question), file=process.stdin, flush=True)
            return process.stdout.readline()

        yield Engine(lambda text: ask(load=text), lambda words: ask(call=words))
        process.stdin.close()


@contextmanager
def in_browser(browser):  # noqa: F811
    """An engine on an empty page."""
    page = browser.new_page()
    yield Engine(
        lambda text: page.evaluate(LOAD, text), lambda words: page.evaluate(CALL, words)
    )
    page.close()


# The loop of somebody who changes a line takes node, where there is one.
IN_BROWSER = pytest.param("browser", marks=pytest.mark.slow)


@pytest.fixture(scope="module", params=[IN_BROWSER, "node"])
def engine(request):
    """The engine as a reader gets it."""
    if request.param == "node" and not shutil.which("node"):
        pytest.skip("no node here; the browser runs the same cases")
    if request.param == "node":
        made = in_node()
    else:
        made = in_browser(request.getfixturevalue("browser"))
    with made as ready:
        yield ready


def picture(frame):
    """A frame (H, W, 3) as a canvas would hand it to the engine."""
    rgba = np.dstack([frame, np.full(frame.shape[:2], 255, np.uint8)])
    return {
        "rgba": base64.b64encode(rgba.tobytes()).decode(),
        "width": frame.shape[1],
        "height": frame.shape[0],
    }


class Recorded:
    """A generator that remembers all that it drew, for the engine's `replay`."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)
        self.drawn = {"uniforms": [], "normals": []}

    def standard_normal(self, shape):
        numbers = self._rng.standard_normal(shape)
        self.drawn["normals"] += np.ravel(numbers).tolist()
        return numbers

    def random(self, n=None):
        numbers = self._rng.random(n)
        self.drawn["uniforms"] += np.ravel(numbers).tolist()
        return numbers


def fixture_of(text):
    """A fixture: what a module exports as ``live``, and afterwards the engine's."""

    @pytest.fixture
    def loaded(engine):
        engine.load(text)
        yield engine
        engine.load(ENGINE)

    return loaded


def assert_found(engine, text, right, wrong, check):
    """A fault that is planted in a module's text fails a check."""
    assert right in text
    engine.load(text.replace(right, wrong))
    with pytest.raises(AssertionError):
        check(engine)
