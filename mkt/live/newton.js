// own.newton, live: Gauss-Newton on kernels, from any start, step by step.

import { load } from "./host.js";
import { errors, overlap } from "./method/evaluation.js";
import { distanceAt, learn } from "./method/histograms.js";
import {
  differentiate,
  moved,
  newtonPath,
  newtonStep,
  SHORT,
} from "./method/newton.js";
import { corners, displaced, warp } from "./method/regions.js";
import { still } from "./objects.js";
import {
  axes,
  button,
  Canvas,
  Controls,
  el,
  knob,
  number,
  outline,
  outlineTruth,
  SLICE,
  takeOver,
  within,
} from "./page.js";

const STEPS = 10;
const FOUND = 0.8; // overlap with the truth beyond which a start led home
const CELLS = 25; // of the basin, a side
const [ORANGE, GREEN, BLUE] = ["#d25000", "#00a751", "#1e7dc1"];
const [REACH, TURN] = [64, 80]; // [px], [deg]: the ends of the sliders and of the basin

class Newton {
  constructor(panel, name, { fields }) {
    this.taken = 0;
    const { dx, turn, scale, layout, span, derivative_of_c } = fields;
    const free = {
      dx: { ...dx, low: -REACH, high: REACH, step: 1 },
      turn: { ...turn, low: -TURN, high: TURN, step: 1 },
      scale: { ...scale, step: 0.05 },
      layout,
      span: { ...span, step: 0.05 },
      derivative_of_c,
    };
    this.controls = new Controls(name, free, (_values, _quick, asked) =>
      this.follow(asked),
    );
    this.frame = new Canvas("", 0.77, (...pen) => this.drawFrame(...pen));
    this.basin = new Canvas("", 0.95, (...pen) => this.drawBasin(...pen));
    this.curve = new Canvas("", 0.5, (...pen) => this.drawCurve(...pen), 150);
    this.slope = new Canvas("", 0.5, (...pen) => this.drawSlope(...pen), 150);
    const acts = el(
      "div",
      { class: "mkt-controls" },
      button("to the start", () => this.walk(0)),
      button("step", () => this.walk(Math.min(this.taken + 1, STEPS))),
      button("all steps", () => this.walk(STEPS)),
    );
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the thick box or its knob, or choose a start on the map; " +
        "arrow keys move it too. On the map, dark starts lead home.",
    );
    const nodes = [this.frame, this.basin, this.curve, this.slope].map(
      ({ node }) => node,
    );
    const stage = el("div", { class: "mkt-stage mkt-pairs" }, ...nodes);
    const { node, note } = this.controls;
    takeOver(panel, node, note, acts, stage, this.said, hint, this.controls.copies());
    this.hands();
  }

  async read() {
    const { region, images, picture } = await still("car", "hsv");
    Object.assign(this, { truth: region, images, picture });
    this.controls.show();
    if (!this.controls.read()) this.follow();
  }

  // Everything that follows from the controls.
  follow(asked) {
    if (asked) this.taken = 0;
    const { layout, span, derivative_of_c, scale } = this.controls.values;
    const spec = {
      layout,
      span: layout === "one" ? Math.min(span, 1) : span,
      samples: 2400,
    };
    const known = JSON.stringify(spec);
    if (this.spec !== known) this.target = learn(this.images[0], this.truth, spec);
    this.spec = known;
    this.path = this.from(this.start());
    const map = JSON.stringify([spec, derivative_of_c, scale]);
    if (this.map !== map) this.fill(map);
    this.draw();
  }

  start() {
    const { dx, turn, scale } = this.controls.values;
    return displaced(this.truth, dx, 0, (turn * Math.PI) / 180, scale);
  }

  from(start, enough) {
    const derivative = this.controls.values.derivative_of_c === "yes";
    return newtonPath(this.target, this.images[1], start, STEPS, derivative, enough);
  }

  walk(taken) {
    this.taken = taken;
    this.draw();
  }

  // The basin: where ten steps lead from every start, a slice of time after the other.
  fill(map) {
    this.map = map;
    this.home = new Float32Array(CELLS * CELLS).fill(NaN);
    clearTimeout(this.later);
    // Every seventh cell, then the next ones: the picture is there early, and grows
    // dense.
    const order = Array.from(
      { length: CELLS * CELLS },
      (_, i) => (i * 7) % (CELLS * CELLS),
    );
    const { scale } = this.controls.values;
    const work = () => {
      const end = performance.now() + SLICE;
      while (order.length && performance.now() < end) {
        const i = order.shift();
        const dx = REACH * ((2 * (i % CELLS)) / (CELLS - 1) - 1);
        const turn = TURN * ((2 * Math.floor(i / CELLS)) / (CELLS - 1) - 1);
        const start = displaced(this.truth, dx, 0, (turn * Math.PI) / 180, scale);
        this.home[i] = overlap(this.from(start, SHORT).at(-1), this.truth);
      }
      this.basin.redraw();
      if (order.length) this.later = setTimeout(work);
      else this.describe();
    };
    this.later = setTimeout(work, 60);
  }

  draw() {
    this.distances = this.path.map((each) =>
      distanceAt(this.target, this.images[1], each),
    );
    this.describe();
    for (const canvas of [this.frame, this.basin, this.curve, this.slope])
      canvas.redraw();
  }

  describe() {
    const { dx, turn } = this.controls.values;
    const now = this.path[this.taken];
    const start = `start ${number(dx)} px and ${number(turn)} degrees off`;
    const [place, turned] = errors(now, this.truth);
    const size =
      100 * (Math.sqrt((now[3] * now[4]) / (this.truth[3] * this.truth[4])) - 1);
    const left =
      `still off by ${place.toFixed(1)} px, ` +
      `${((turned * 180) / Math.PI).toFixed(1)} degrees and ` +
      `${Math.abs(size).toFixed(1)} % in size`;
    this.said.textContent =
      `Step ${this.taken} of ${STEPS}, ${start}: distance ` +
      `${this.distances[this.taken].toFixed(3)}; ${left}.`;
    const share = this.home.filter((each) => each > FOUND).length / this.home.length;
    const about = {
      frame: `The frame with the truth, the ${start}, and the steps`,
      basin: `The basin: ${Math.round(100 * share)} of 100 starts lead home`,
      curve: "The distance after every step",
      slope:
        `O along the next step, ${this.costAt(now).toFixed(2)} at its ` +
        "beginning, and the parabola that Gauss-Newton takes it for",
    };
    for (const [name, words] of Object.entries(about))
      this[name].node.setAttribute("aria-label", words);
  }

  drawFrame(pen, width, height) {
    if (!this.path) return;
    const scale = width / 246;
    pen.globalAlpha = 0.55;
    pen.drawImage(this.picture, 60, 25, 246, 190, 0, 0, width, height);
    pen.globalAlpha = 1;
    this.onto = ([x, y]) => [(x - 59.5) * scale, (y - 24.5) * scale];
    const box = (region) => corners(region).map(this.onto);
    outlineTruth(pen, box(this.truth));
    for (const region of this.path.slice(1, this.taken))
      outline(pen, box(region), ORANGE, 1);
    const start = outline(pen, box(this.path[0]), ORANGE, 3);
    if (this.taken) outline(pen, box(this.path[this.taken]), GREEN, 2.5);
    this.knob = this.onto(warp(this.path[0], [1, 0]));
    return [start, knob(pen, this.knob, 7, ORANGE)];
  }

  basinBox(width, height) {
    return [38, 22, width - 46, height - 62];
  }

  drawBasin(pen, width, height) {
    if (!this.home) return;
    const box = this.basinBox(width, height);
    const [left, top, w, h] = box;
    // The middles of the outer cells lie on the edges of the box.
    const [cw, ch] = [w / (CELLS - 1), h / (CELLS - 1)];
    // What is missing lies below: where half transparent cells overlap there are lines.
    pen.fillStyle = "#8884";
    pen.fillRect(...box);
    within(pen, box, () =>
      this.home.forEach((iou, i) => {
        if (Number.isNaN(iou)) return;
        const row = CELLS - 1.5 - Math.floor(i / CELLS);
        const light = Math.round(95 - 60 * Math.max(iou, 0));
        pen.fillStyle = `hsl(203 60% ${light}%)`;
        const x = left + ((i % CELLS) - 0.5) * cw;
        pen.fillRect(x, top + row * ch, cw + 0.5, ch + 0.5);
      }),
    );
    pen.fillStyle = pen.strokeStyle;
    const limits = {
      x: [-REACH, REACH],
      y: [-TURN, TURN],
      xlabel: "dx of the start [px]",
      ylabel: "turn of the start [deg]",
    };
    const { across, down } = axes(pen, box, limits);
    const { dx, turn } = this.controls.values;
    return [knob(pen, [across(dx), down(turn)], 6, ORANGE)];
  }

  drawCurve(pen, width, height) {
    if (!this.path) return;
    const box = [38, 22, width - 46, height - 62];
    const { across, down } = axes(pen, box, {
      x: [0, STEPS],
      y: [0, 1],
      xlabel: "step",
      ylabel: "distance",
    });
    pen.beginPath();
    this.distances.forEach((d, k) => pen.lineTo(across(k), down(d)));
    Object.assign(pen, { strokeStyle: BLUE, lineWidth: 2 });
    pen.stroke();
    this.distances.forEach((d, k) => {
      pen.fillStyle = k === this.taken ? GREEN : BLUE;
      pen.beginPath();
      pen.arc(across(k), down(d), k === this.taken ? 6 : 3, 0, 7);
      pen.fill();
    });
  }

  // O(x), (6) of [T09]: 2 d^2 of each kernel.
  costAt(place) {
    const kernels = this.target.q.length;
    return 2 * kernels * distanceAt(this.target, this.images[1], place) ** 2;
  }

  // O along the next step, and the parabola whose lowest point the step goes to.
  drawSlope(pen, width, height) {
    if (!this.path) return;
    const from = this.path[this.taken];
    const derivative = this.controls.values.derivative_of_c === "yes";
    const at = differentiate(this.target, this.images[1], from, derivative);
    const step = newtonStep(at, this.target);
    const costAt = (t) => {
      const place = moved(
        from,
        step.map((each) => each * t),
      );
      return this.costAt(place);
    };
    const shares = Array.from({ length: 41 }, (_, i) => (i - 8) / 16);
    const real = shares.map(costAt);
    const reference = this.target.q.flatMap((each) => [...each]);
    let [error, drop, bend] = [0, 0, 0];
    at.q.forEach((value, u) => {
      if (value <= 1e-6) return void (error += reference[u]);
      const root = Math.sqrt(value);
      const e = root - Math.sqrt(reference[u]);
      const along =
        step.reduce((sum, each, k) => sum + each * at.dq[4 * u + k], 0) / (2 * root);
      error += e * e;
      drop += 2 * e * along;
      bend += along * along;
    });
    const model = shares.map((t) => error + drop * t + bend * t * t);
    const top = Math.max(...real, 1) * 1.1;
    const box = [38, 22, width - 46, height - 62];
    const limits = {
      x: [-0.5, 2],
      y: [0, top],
      xlabel: "share of the next step",
      ylabel: "O: real (blue), parabola (orange)",
    };
    const { across, down } = axes(pen, box, limits);
    within(pen, box, () => {
      for (const [values, color, dashes] of [
        [real, BLUE, []],
        [model, ORANGE, [5, 4]],
      ]) {
        pen.beginPath();
        values.forEach((value, i) => pen.lineTo(across(shares[i]), down(value)));
        pen.setLineDash(dashes);
        Object.assign(pen, { strokeStyle: color, lineWidth: 2 });
        pen.stroke();
      }
    });
  }

  hands() {
    const set = (dx, turn, quick) => this.controls.set({ dx, turn }, quick);
    const settle = () => this.controls.set({});
    let [begin, dx0, turning] = [0, 0, false];
    this.frame.dragged(
      ([u, v], reach) => {
        turning = Math.hypot(u - this.knob[0], v - this.knob[1]) < reach;
        [begin, dx0] = [u, this.controls.values.dx];
      },
      ([u, v]) => {
        const scale = this.frame.node.clientWidth / 246;
        const { turn } = this.controls.values;
        if (!turning) return set(Math.round(dx0 + (u - begin) / scale), turn, true);
        const [cx, cy] = this.onto(this.path[0]);
        set(dx0, Math.round((Math.atan2(v - cy, u - cx) * 180) / Math.PI), true);
      },
      settle,
    );
    const to = ([u, v]) => {
      const { clientWidth, clientHeight } = this.basin.node;
      const [left, top, w, h] = this.basinBox(clientWidth, clientHeight);
      set(
        Math.round(REACH * ((2 * (u - left)) / w - 1)),
        Math.round(TURN * (1 - (2 * (v - top)) / h)),
        true,
      );
    };
    this.basin.dragged(to, to, settle);
    const step =
      (sign) =>
      ([right, down]) => {
        const { dx, turn } = this.controls.values;
        set(dx + 2 * right, turn + 2 * sign * down);
      };
    this.frame.keyed(step(1));
    this.basin.keyed(step(-1));
  }
}

export async function newton(panel, name) {
  await new Newton(panel, name, await load(name)).read();
}
