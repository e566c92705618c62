"""JupyterLab as a reader has it on the screen.

`serving` starts it, a `Notebook` is an open one, a `Slider` one control of a
figure.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

TOKEN = "for-this-test"
PROGRAM = """
import sys
from mkt.course import cli
from mkt.course.commands import lab
lab.NOTEBOOKS = sys.argv[1]
lab._tell_git = lambda: None  # the clone under test keeps its settings
cli.run(cli.parse(["lab", *sys.argv[2:]]))
"""
HASH = """async (image) => {
  const picture = await (await fetch(image.src)).arrayBuffer();
  const digest = await crypto.subtle.digest("SHA-256", picture);
  return [...new Uint8Array(digest)].join(" ");
}"""
LIVE_HASH = """async (figure, settled) => {
  const wait = (time) => new Promise((next) => setTimeout(next, time));
  const all = [...figure.querySelectorAll("canvas")];
  const look = () => all.map((each) => each.toDataURL());
  // A canvas that nobody has drawn on has the size that HTML gives it.
  const blank = (each) => each.width === 300 && each.height === 150;
  const busy = () => figure.querySelector("[aria-busy=true]") || all.some(blank);
  let [before, now] = [[], look()];
  while (settled && (`${before}` !== `${now}` || busy())) {
    await wait(300);
    [before, now] = [now, look()];
  }
  const bytes = new TextEncoder().encode(now);
  const digest = await crypto.subtle.digest("SHA-256", bytes);
  return [...new Uint8Array(digest)].join(" ");
}"""
STARTED = """() => {
  const cells = [...document.querySelectorAll(".mkt-cell")];
  return cells.every((cell) => cell.querySelector("canvas"));
}"""
PLAYED = """async (film) => {
  film.scrollIntoView();
  await film.play();
  const before = film.currentTime;
  for (let tries = 0; tries < 100 && film.currentTime <= before; tries++) {
    await new Promise((next) => setTimeout(next, 50));
  }
  return [before, film.currentTime];
}"""
# Cells that are folded have no number to be seen.
FINISHED = """(failure) => {
  const prompts = document.querySelectorAll(
    ".jp-CodeCell .jp-InputPrompt:not(.jp-Placeholder-prompt)");
  return document.querySelector(failure)
    || [...prompts].every((prompt) => /\\[\\d+\\]/.test(prompt.textContent));
}"""
END_KERNELS = """async () => {
  const config = document.getElementById("jupyter-config-data").textContent;
  const {baseUrl, token} = JSON.parse(config);
  const headers = {Authorization: `token ${token}`};
  const address = `${baseUrl}api/sessions`;
  const sessions = await (await fetch(address, {headers})).json();
  const end = ({id}) => fetch(`${address}/${id}`, {method: "DELETE", headers});
  await Promise.all(sessions.map(end));
}"""
FAILURE = '[data-mime-type="application/vnd.jupyter.error"]'
SECONDS = 1000  # playwright counts in milliseconds
QUIET = 10  # looks, a tenth of a second apart, at a kernel that has nothing to do
HIDDEN = ("MPLBACKEND", "MKT_STATIC", "MKT_DATA")
OWN = (
    "JUPYTER_CONFIG_DIR",
    "JUPYTER_DATA_DIR",
    "JUPYTER_RUNTIME_DIR",
    "IPYTHONDIR",
)


@contextmanager
def serving(notebooks, settled=60):
    """Run ``mkt lab`` on a folder of notebooks, with nobody's own settings.

    Yields the address.
    """
    with tempfile.TemporaryDirectory(
        prefix="mkt-lab-", ignore_cleanup_errors=True
    ) as home:
        port = _free_port()
        log = Path(home, "log")
        with log.open("w") as output:
            server = subprocess.Popen(
                [sys.executable, "-c", PROGRAM, notebooks, *_options(port)],
                stdout=output,
                stderr=output,
                env=_environment(home),
            )
        try:
            _wait_for(port, server, log, time.monotonic() + settled)
            yield f"http://localhost:{port}"
        finally:
            server.terminate()  # its kernels end with it
            server.wait(30)


def _free_port():
    with socket.socket() as free:
        free.bind(("localhost", 0))
        return free.getsockname()[1]


def _options(port):
    return [
        "--no-browser",
        "--allow-root",
        f"--port={port}",
        "--ServerApp.port_retries=0",
        f"--IdentityProvider.token={TOKEN}",
    ]


def _environment(home):
    kept = {name: value for name, value in os.environ.items() if name not in HIDDEN}
    return kept | {name: str(Path(home, name)) for name in OWN}


def _wait_for(port, server, log, end):
    while True:
        try:
            urlopen(f"http://localhost:{port}/api?token={TOKEN}").close()
            return
        except OSError:
            if server.poll() is not None or time.monotonic() > end:
                raise RuntimeError(
                    f"JupyterLab did not start:\n{log.read_text()}"
                ) from None
            time.sleep(0.2)


class Notebook:
    """A notebook, opened in a page of a browser."""

    def __init__(self, page, address, notebook):
        self.page = page
        self.source = notebook.read_text(encoding="utf-8")
        place = f"lab/workspaces/{notebook.stem}/tree/{notebook.name}"
        page.goto(f"{address}/{place}?reset&token={TOKEN}")
        self._wait_until_idle(120)

    def run_all(self, timeout):
        """Run all cells from the menu, as a reader does.

        Waits until all have their numbers, or one failed, at most `timeout` [s].
        """
        self.page.get_by_role("menuitem", name="Run", exact=True).click()
        self.page.get_by_role("menuitem", name="Run All Cells", exact=True).click()
        self.page.wait_for_function(
            FINISHED, arg=FAILURE, timeout=timeout * SECONDS, polling=250
        )
        self._wait_until_idle(timeout)

    def _wait_until_idle(self, timeout):
        """Before, cells would run into nothing; between two it is idle for a moment."""
        state = self.page.get_by_text("Python 3 (ipykernel) | Idle")
        quiet = 0
        while quiet < QUIET:
            state.wait_for(timeout=timeout * SECONDS)
            self.page.wait_for_timeout(100)
            quiet = quiet + 1 if state.count() else 0

    def errors(self):
        """The texts of all tracebacks."""
        return self.page.locator(FAILURE).all_text_contents()

    def figures(self):
        """Every figure with sliders, as a locator."""
        self.page.wait_for_function(STARTED, timeout=60 * SECONDS)
        return self.page.locator(".mkt-panel, .mkt-drawn").all()

    def close(self):
        """End the kernel and leave the page; nothing is saved."""
        self.page.evaluate(END_KERNELS)
        self.page.close()


def controls(figure):
    """The sliders and lists of a figure, in their order, as `Slider` and `Choice`."""
    boxes = figure.locator(".widget-slider, .widget-dropdown, .mkt-control").all()
    return [_control(figure, box) for box in boxes]


def _control(figure, box):
    if box.locator("[role=slider]").count():
        return Slider(figure, box)
    if box.locator("[type=range]").count():
        return LiveSlider(figure, box)
    return Choice(figure, box)


class Control:
    """What moves a figure: its name, its position, and the picture."""

    def __init__(self, figure, box):
        self.name = box.locator("label").text_content()
        self._box = box
        self._figure = figure
        self._live = figure.locator("canvas").count() > 0

    def picture(self, other_than=None, timeout=60):
        """The fingerprint of the picture, once it has come to rest.

        Waits at most `timeout` [s] for one that is another.
        """
        return self._awaited(lambda now: now != other_than, timeout, settled=True)

    def picture_again(self, before, timeout=60):
        """The fingerprint of the picture, once it is an earlier one again.

        On its way back a slider may show others.  Waits at most `timeout` [s].
        """
        return self._awaited(lambda now: now == before, timeout, settled=False)

    def _awaited(self, is_there, timeout, settled):
        end = time.monotonic() + timeout
        fingerprint = self._fingerprint(settled)
        while not is_there(fingerprint) and time.monotonic() < end:
            self._figure.page.wait_for_timeout(50)
            fingerprint = self._fingerprint(settled)
        return fingerprint

    def _fingerprint(self, settled):
        if self._live:
            return self._figure.evaluate(LIVE_HASH, settled)
        return self._figure.locator("img").first.evaluate(HASH)


class Slider(Control):
    """Moved one step by the keyboard, and back by the mouse."""

    def position(self):
        """The number it stands at, as it is read beside the slider.

        What the slider tells a screen reader is rounded to tenths.
        """
        text = self._box.locator(".widget-readout").text_content()
        return float(text.replace("\N{MINUS SIGN}", "-"))

    def step(self):
        """Press an arrow key: upwards, or downwards from the end."""
        last = self._now("now") == self._now("max")
        self._handle.press("ArrowLeft" if last else "ArrowRight")

    def put(self, position):
        """Click where the slider is to stand.

        Where its steps are as narrow as the mouse is wide, arrow keys do the rest.
        """
        way = self._box.locator(".noUi-base")
        size = way.bounding_box()
        low, high = self._now("min"), self._now("max")
        x = (position - low) / (high - low) * (size["width"] - 1)
        way.click(position={"x": x, "y": size["height"] / 2}, force=True)
        while (now := self.position()) != position:
            self._handle.press("ArrowLeft" if now > position else "ArrowRight")

    @property
    def _handle(self):
        return self._box.locator("[role=slider]")

    def _now(self, which):
        return float(self._handle.get_attribute(f"aria-value{which}"))


class LiveSlider(Control):
    """One of a figure that computes in the browser; any number can be typed."""

    def position(self):
        """The number beside it."""
        return float(self._typed.input_value())

    def step(self):
        """Press page down or up, a tenth of the way, towards the farther end."""
        way = self._box.locator("[type=range]")
        low, high = (float(way.get_attribute(end)) for end in ("min", "max"))
        far = self.position() < (low + high) / 2
        way.press("PageUp" if far else "PageDown")

    def put(self, position):
        """Type where the slider is to stand."""
        self._typed.fill(f"{position:g}")
        self._typed.press("Enter")

    @property
    def _typed(self):
        return self._box.locator("[type=number]")


class Choice(Control):
    """A list.

    Its pop-up belongs to the system, so that neither key nor mouse of the test reaches
    it.
    """

    def position(self):
        """The number of what is chosen."""
        return self._list.evaluate("list => list.selectedIndex")

    def step(self):
        """Choose the next, or the first from the end."""
        self.put((self.position() + 1) % self._list.locator("option").count())

    def put(self, position):
        """Choose by number."""
        self._list.select_option(index=position)

    @property
    def _list(self):
        return self._box.locator("select")
