"""JupyterLab as a reader has it on the screen: `serving` starts it, a `Chapter` is one open notebook, a `Slider` one control of a figure."""

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
PROGRAM = "import sys; from mkt import cli; cli.NOTEBOOKS = sys.argv[1]; cli.run(cli.parse(['lab', *sys.argv[2:]]))"
HASH = """async (image) => {
  const digest = await crypto.subtle.digest("SHA-256", await (await fetch(image.src)).arrayBuffer());
  return [...new Uint8Array(digest)].join(" ");
}"""
PLAYED = """async (film) => {
  film.scrollIntoView();
  await film.play();
  const before = film.currentTime;
  for (let tries = 0; tries < 100 && film.currentTime <= before; tries++) await new Promise((next) => setTimeout(next, 50));
  return [before, film.currentTime];
}"""
FAILURE = '[data-mime-type="application/vnd.jupyter.error"]'
SECONDS = 1000  # playwright counts in milliseconds


@contextmanager
def serving(notebooks, settled=60):
    """Run ``mkt lab`` on a folder of notebooks, with nobody's own settings.  Yields the address."""
    with tempfile.TemporaryDirectory(prefix="mkt-lab-", ignore_cleanup_errors=True) as home:
        with socket.socket() as free:
            free.bind(("localhost", 0))
            port = free.getsockname()[1]
        words = ["--no-browser", "--allow-root", f"--port={port}", "--ServerApp.port_retries=0", f"--IdentityProvider.token={TOKEN}"]
        log = open(Path(home, "log"), "w+")
        server = subprocess.Popen([sys.executable, "-c", PROGRAM, notebooks, *words], stdout=log, stderr=log, env=_environment(home))
        try:
            _wait_for(f"http://localhost:{port}/api?token={TOKEN}", server, log, time.monotonic() + settled)
            yield f"http://localhost:{port}"
        finally:
            server.terminate()  # its kernels end with it
            server.wait(30)


def _environment(home):
    kept = {name: value for name, value in os.environ.items() if name not in ("MPLBACKEND", "MKT_STATIC", "MKT_DATA")}
    return kept | {name: str(Path(home, name)) for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")}


def _wait_for(url, server, log, end):
    while True:
        try:
            return urlopen(url).close()
        except OSError:
            if server.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"JupyterLab did not start:\n{Path(log.name).read_text()}") from None
            time.sleep(0.2)


class Chapter:
    """A notebook, opened in a page of a browser."""

    def __init__(self, page, address, notebook):
        self.page, self.source = page, notebook.read_text(encoding="utf-8")
        page.goto(f"{address}/lab/workspaces/{notebook.stem}/tree/{notebook.name}?reset&token={TOKEN}")
        self._wait_until_idle(120)

    def run_all(self, timeout):
        """Run all cells from the menu, as a reader does; wait until all have their numbers, or one failed, at most `timeout` [s]."""
        self.page.get_by_role("menuitem", name="Run", exact=True).click()
        self.page.get_by_role("menuitem", name="Run All Cells", exact=True).click()
        self.page.wait_for_function("""(failure) => document.querySelector(failure) || [...document.querySelectorAll(".jp-CodeCell .jp-InputPrompt")]
            .every((prompt) => /\\[\\d+\\]/.test(prompt.textContent))""", arg=FAILURE, timeout=timeout * SECONDS, polling=250)
        self._wait_until_idle(timeout)

    def _wait_until_idle(self, timeout):
        self.page.get_by_text("Python 3 (ipykernel) | Idle").wait_for(timeout=timeout * SECONDS)  # before, cells would run into nothing

    def errors(self):
        """The texts of all tracebacks."""
        return self.page.locator(FAILURE).all_text_contents()

    def figures(self):
        """Every figure with sliders, as a locator."""
        return self.page.locator(".mkt-panel").all()

    def close(self):
        """End the kernel and leave the page; nothing is saved."""
        self.page.evaluate("""async () => {
            const {baseUrl, token} = JSON.parse(document.getElementById("jupyter-config-data").textContent);
            const headers = {Authorization: `token ${token}`}, sessions = await (await fetch(`${baseUrl}api/sessions`, {headers})).json();
            await Promise.all(sessions.map(({id}) => fetch(`${baseUrl}api/sessions/${id}`, {method: "DELETE", headers})));
        }""")
        self.page.close()


def controls(figure):
    """The sliders and lists of choices of a figure, in their order, as `Slider` and `Choice`."""
    return [(Slider if box.locator("[role=slider]").count() else Choice)(figure, box) for box in figure.locator(".widget-slider, .widget-dropdown").all()]


class Control:
    """What moves a figure: its name, its position, and the picture."""

    def __init__(self, figure, box):
        self.name = box.locator("label").text_content()
        self._box, self._image = box, figure.locator("img").first

    def picture(self, other_than=None, timeout=60):
        """The fingerprint of the picture; waits at most `timeout` [s] for one that is another."""
        end = time.monotonic() + timeout
        while (fingerprint := self._image.evaluate(HASH)) == other_than and time.monotonic() < end:
            self._image.page.wait_for_timeout(50)
        return fingerprint


class Slider(Control):
    """Moved one step by the keyboard, and back by the mouse."""

    def position(self):
        """The number of the step it stands at."""
        return self._now("now")

    def step(self):
        """Press an arrow key: upwards, or downwards from the end."""
        self._handle.press("ArrowLeft" if self.position() == self._now("max") else "ArrowRight")

    def put(self, position):
        """Click where the slider is to stand; where its steps are as narrow as the mouse is wide, arrow keys do the rest."""
        way = self._box.locator(".noUi-base")
        size = way.bounding_box()
        way.click(position={"x": position / self._now("max") * (size["width"] - 1), "y": size["height"] / 2}, force=True)
        while (now := self.position()) != position:
            self._handle.press("ArrowLeft" if now > position else "ArrowRight")

    @property
    def _handle(self):
        return self._box.locator("[role=slider]")

    def _now(self, which):
        return round(float(self._handle.get_attribute(f"aria-value{which}")))


class Choice(Control):
    """A list; its pop-up belongs to the system, so that neither key nor mouse of the test reaches it."""

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
