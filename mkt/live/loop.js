// own.root_locus, live: the poles of the loop, dragged along their way, and its answer.

import { load } from "./host.js";
import { linspace } from "./method/numbers.js";
import { oneFeature, poles } from "./method/poles.js";
import { axes, Canvas, Controls, dot, el, number, takeOver, within } from "./page.js";

const RATIOS = { off: 0, raw: Infinity, Kalman: 1 }; // Q / R of the filters
const [MOST, STEPS] = [10, 101]; // [1/s] gains of the locus, and how many
const [REAL, IMAGINARY] = [1.9, 1.6]; // the plane's halves
const [SECONDS, SPEED, LEAST] = [18, 5, 16]; // [s], [cm/s], [cm] of the errors shown
const [ORANGE, GREEN, GREY] = ["#cf8200", "#00a751", "#888"];

// A target that sets off, turns back and stops [cm/s].
const speedAt = (t) => SPEED * ((t >= 1) - 2 * (t >= 8) + (t >= 12));

// A pole's size in three places, or in more where it would seem to be at the limit.
const inPlaces = (radius) =>
  radius.toFixed([3, 4, 5, 6].find((n) => Number(radius.toFixed(n)) !== 1) ?? 3);

class RootLocus {
  constructor(panel, name, { fields, viridis }) {
    this.viridis = viridis;
    const free = (field, low, high, step, title) => ({
      low,
      high,
      step,
      value: Number(field.value),
      title,
    });
    const { gain, delay, compensation, fps, mismatch } = fields;
    const each = {
      gain: free(gain, 0.05, MOST, 0.05, "gain [1/s]"),
      delay: free(delay, 0, 6, 1, "delay [frames]"),
      compensation,
      fps: free(fps, 1, 30, 0.5, "fps"),
      mismatch: free(mismatch, 0.2, 4, 0.05, "mismatch"),
    };
    this.controls = new Controls(name, each, () => this.follow());
    this.plane = new Canvas("", 0.9, (...pen) => this.drawPlane(...pen));
    this.answer = new Canvas("", 0.9, (...pen) => this.drawAnswer(...pen));
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag a cross along its way, or turn the gain up with the arrow keys.",
    );
    const stage = el(
      "div",
      { class: "mkt-stage mkt-pairs" },
      this.plane.node,
      this.answer.node,
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
    this.hands();
  }

  loop(gain = this.controls.values.gain) {
    const { delay, compensation, fps, mismatch } = this.controls.values;
    return { gain, dt: 1 / fps, delay, ratio: RATIOS[compensation], mismatch };
  }

  follow() {
    const { gain, ...others } = this.controls.values;
    const known = JSON.stringify(others);
    if (this.known !== known) {
      this.gains = linspace(MOST / (STEPS - 1), MOST, STEPS - 1);
      let last;
      this.ways = this.gains.map((each) => (last = poles(this.loop(each), last)));
    }
    this.known = known;
    this.chosen = poles(this.loop());
    if (!this.chosen.length) this.chosen = [[0, 0]]; // of an error that is gone at once
    this.radius = Math.max(...this.chosen.map((z) => Math.hypot(...z)));
    const { dt } = this.loop();
    this.times = Array.from(
      { length: Math.ceil(SECONDS / dt - 1e-9) },
      (_, k) => k * dt,
    );
    this.speeds = this.times.map(speedAt);
    this.errors = oneFeature(
      this.loop(),
      this.speeds,
      this.times.map(() => 0),
    );
    this.draw();
  }

  draw() {
    const { gain, fps, delay, mismatch } = this.controls.values;
    const beyond = Math.abs(this.radius - 1) < 1e-6 ? 0 : this.radius - 1;
    const stable = beyond ? (beyond < 0 ? "stable" : "runs away") : "at the limit";
    const product = `Gain x frame period${mismatch === 1 ? "" : " / mismatch"}`;
    const far = Math.max(...this.errors.map(Math.abs));
    // Of one that runs away the beginning is shown.
    this.reach = this.radius < 1 ? Math.max(LEAST, 1.05 * far) : LEAST;
    const away = this.errors.findIndex((each) => Math.abs(each) > this.reach);
    this.seen = away < 0 ? this.errors : this.errors.slice(0, away + 1);
    const reach = far < 1000 ? `${far.toFixed(1)} cm` : "more than 10 m";
    this.said.textContent =
      `Largest pole ${inPlaces(this.radius)}: ${stable}. ${product} ` +
      `= ${number(gain / fps / mismatch, 3)}, ${this.chosen.length} ` +
      `${this.chosen.length > 1 ? "poles" : "pole"} beside values ` +
      `that are stored for one frame, greatest distance ${reach}.` +
      this.outside();
    const words = this.chosen.map(
      ([re, im]) =>
        `${re.toFixed(2)} ${im < 0 ? "-" : "+"} ${Math.abs(im).toFixed(2)} i`,
    );
    this.plane.node.setAttribute(
      "aria-label",
      `The complex plane; poles at ${words.join(", ")}; ${stable}`,
    );
    this.answer.node.setAttribute(
      "aria-label",
      "How far the camera is behind a target of 5 cm/s that turns " +
        `back and stops, with ${delay} frames of delay: at most ` +
        `${reach}`,
    );
    this.plane.redraw();
    this.answer.redraw();
  }

  // In words, whether some pole is not drawn.
  outside() {
    const away = this.chosen.some(
      ([re, im]) => Math.abs(re) > REAL || Math.abs(im) > IMAGINARY,
    );
    return away ? " A pole lies outside of the plane shown." : "";
  }

  // Both axes alike, however wide the canvas is.
  planeBox(width, height) {
    const fit = Math.min((width - 46) / (2 * REAL), (height - 62) / (2 * IMAGINARY));
    return [38, 22, 2 * REAL * fit, 2 * IMAGINARY * fit];
  }

  drawPlane(pen, width, height) {
    if (!this.chosen) return;
    const box = this.planeBox(width, height);
    const limits = {
      x: [-REAL, REAL],
      y: [-IMAGINARY, IMAGINARY],
      xlabel: "real part",
      ylabel: "imaginary part; dots: gain from 0 (dark) to 10",
    };
    const { across, down } = axes(pen, box, limits);
    const crosses = this.chosen.map(([re, im]) => [[across(re), down(im)]]);
    within(pen, box, () => {
      pen.strokeStyle = GREY;
      pen.beginPath();
      pen.arc(across(0), down(0), across(1) - across(0), 0, 7);
      pen.stroke();
      pen.globalAlpha = 0.4;
      pen.beginPath();
      pen.moveTo(across(-REAL), down(0));
      pen.lineTo(across(REAL), down(0));
      pen.moveTo(across(0), down(-IMAGINARY));
      pen.lineTo(across(0), down(IMAGINARY));
      pen.stroke();
      pen.globalAlpha = 1;
      this.ways.forEach((found, i) => {
        const color = this.viridis[Math.round((255 * i) / this.ways.length)];
        for (const [re, im] of found)
          dot(pen, across(re), down(im), 2.5, `rgb(${color.join(" ")})`, GREY, 0.5);
      });
      for (const [color, thick] of [
        ["#000", 5.5],
        [ORANGE, 3],
      ]) {
        Object.assign(pen, { strokeStyle: color, lineWidth: thick });
        for (const [[u, v]] of crosses) {
          pen.beginPath();
          for (const way of [6, -6]) {
            pen.moveTo(u - 6, v - way);
            pen.lineTo(u + 6, v + way);
          }
          pen.stroke();
        }
      }
    });
    return crosses;
  }

  drawAnswer(pen, width, height) {
    if (!this.errors) return;
    const box = [38, 22, width - 46, height - 62];
    const limits = {
      x: [0, SECONDS],
      y: [-this.reach, this.reach],
      xlabel: "time [s]",
      ylabel: "error [cm] (green), target's velocity [cm/s]",
    };
    const { across, down } = axes(pen, box, limits);
    within(pen, box, () => {
      for (const [values, color, thick] of [
        [this.speeds, GREY, 1.2],
        [this.seen, GREEN, 2],
      ]) {
        Object.assign(pen, { strokeStyle: color, lineWidth: thick });
        pen.beginPath();
        values.forEach((value, k) => {
          const cut = Math.min(Math.max(value, -99), 99); // some are infinite
          pen.lineTo(across(this.times[k]), down(cut));
          pen.lineTo(across(this.times[k + 1] ?? SECONDS), down(cut));
        });
        pen.stroke();
      }
    });
  }

  hands() {
    const to = ([u, v]) => {
      const { clientWidth, clientHeight } = this.plane.node;
      const [left, top, width, height] = this.planeBox(clientWidth, clientHeight);
      const re = REAL * ((2 * (u - left)) / width - 1);
      const im = IMAGINARY * (1 - (2 * (v - top)) / height);
      const away = this.ways.map((found) =>
        Math.min(...found.map(([x, y]) => Math.hypot(x - re, y - im))),
      );
      const gain = this.gains[away.indexOf(Math.min(...away))];
      this.controls.set({ gain }, true);
    };
    this.plane.dragged(to, to, () => this.controls.set({}));
    const step = ([right, down]) => {
      const { gain } = this.controls.values;
      this.controls.set({ gain: gain + 0.05 * (right - down) });
    };
    this.plane.keyed(step);
    this.answer.keyed(step);
  }
}

export async function rootLocus(panel, name) {
  const figure = new RootLocus(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
