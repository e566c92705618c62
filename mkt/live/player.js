// A button that plays a figure: a step at a time, until it is paused or at its end.

import { button, GONE } from "./page.js";

export class Player {
  // `step()` moves on and says whether there is more; `said` is not read out meanwhile,
  // as nobody listens that fast; `done()` when it rests again.
  constructor(said, step, done) {
    Object.assign(this, { said, step, done });
    this.node = button("play", () => this.turn());
    this.node.addEventListener(GONE, () => clearInterval(this.timer));
  }

  // Between two steps [1/s]; by a hand that turns it while it plays, too.
  at(pace) {
    if (this.pace === pace) return;
    this.pace = pace;
    if (this.timer) this.start();
  }

  turn() {
    if (this.timer) return this.pause();
    this.node.textContent = "pause";
    this.said.setAttribute("aria-live", "off");
    this.start();
  }

  start() {
    clearInterval(this.timer);
    this.timer = setInterval(() => this.step() || this.pause(), 1000 / this.pace);
  }

  pause() {
    this.stop();
    this.done();
  }

  // Whether it plays or not, as a reset asks for.
  stop() {
    clearInterval(this.timer);
    this.timer = null;
    this.node.textContent = "play";
    this.said.removeAttribute("aria-live");
  }
}
