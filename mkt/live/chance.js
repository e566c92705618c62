// own.chance, live: how many samples appear by chance, and how long none starts.

import { binomial, falseStart, most, tails } from "./binomial.js";
import { load } from "./host.js";
import { axes, Canvas, Controls, el, number, takeOver, upright } from "./page.js";

const DECADES = 6; // of probability that are drawn
const ROOM = [46, 22, 54, 62]; // [px] left of and above the axes, and around them
const MANY = 4; // [px] from bar to bar, below which there is no gap
const GREY = "rgb(125 125 125)"; // seen by day and by night

const percent = (share) => `${(100 * share).toFixed(1)}\u00a0%`;

// How often something of a probability happens, in words.
function often(each) {
  if (each < 1e-6) return "less than one frame in a million";
  if (each > 0.99) return "nearly every frame";
  return `one frame in ${Number((1 / each).toPrecision(2)).toLocaleString("en")}`;
}

class Chance {
  constructor(panel, name, { fields, wait, highest, margin, compared, colors }) {
    const range = [-margin, highest + margin];
    Object.assign(this, { wait, highest, range, compared, colors });
    const free = { ...fields, b: { ...fields.b, step: 0.01 } };
    this.controls = new Controls(name, free, () => this.follow());
    this.counts = new Canvas("", 0.75, (...pen) => this.drawCounts(...pen), 260);
    this.waits = new Canvas("", 0.75, (...pen) => this.drawWaits(...pen), 260);
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the dashed line, which is b, or move it with the arrow " +
        "keys. The dotted one is what one zone of three can hold; thin " +
        "lines are for the named shares of the background.",
    );
    const stage = el(
      "div",
      { class: "mkt-stage mkt-pairs" },
      this.counts.node,
      this.waits.node,
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
    for (const canvas of [this.counts, this.waits]) this.hands(canvas);
  }

  hands(canvas) {
    const to = ([u]) => {
      const [left, , width] = this.box(canvas.node.clientWidth, 0);
      const [low, high] = this.range;
      const b = low + ((u - left) / width) * (high - low);
      this.controls.set({ b: Math.round(100 * b) / 100 }, true);
    };
    canvas.dragged(to, to, () => this.controls.set({}));
    canvas.keyed(([right, down]) => {
      const { b } = this.controls.values;
      this.controls.set({ b: Math.round(100 * b + right - down) / 100 });
    });
  }

  follow() {
    const { epsilon, particles, b } = this.controls.values;
    const p = epsilon / 100;
    this.probabilities = binomial(particles, p);
    const each = falseStart(particles, p, b);
    const none = (1 - each) ** this.wait;
    this.said.textContent =
      `Of ${particles} samples ${number(p * particles)} appear by ` +
      "chance in a frame, on average; more than " +
      `${most(b, particles)} start the tracking: ${often(each)}. With a ` +
      `probability of ${percent(none)} there is no false start in ` +
      `${this.wait} frames.`;
    this.counts.node.setAttribute(
      "aria-label",
      "How many samples appear by chance: a false start in " + often(each),
    );
    this.waits.node.setAttribute(
      "aria-label",
      `No false start in ${this.wait} frames with a probability of ${percent(none)}`,
    );
    this.counts.redraw();
    this.waits.redraw();
  }

  box(width, height) {
    const [left, top, across, down] = ROOM;
    return [left, top, width - across, height - down];
  }

  drawCounts(pen, width, height) {
    if (!this.probabilities) return;
    const { particles, b } = this.controls.values;
    const box = this.box(width, height);
    const limits = {
      x: this.range,
      y: [-DECADES, 0],
      xlabel: "share of the samples that appear",
      ylabel: "log10 of the probability",
    };
    const { across, down } = axes(pen, box, limits);
    const apart = across(1 / particles) - across(0);
    const thick = apart < MANY ? apart : 0.9 * apart;
    const { a: sharp } = pen.getTransform();
    const whole = (x) => Math.round(x * sharp) / sharp;
    const last = Math.round(this.highest * particles);
    this.probabilities.slice(0, last + 1).forEach((probability, k) => {
      const high = Math.max(Math.log10(probability), -DECADES);
      pen.fillStyle = this.colors[k > most(b, particles) ? 1 : 0];
      const middle = across(k / particles);
      // Between pixels the ground would shine through, as stripes.
      const [left, right] = [-0.5, 0.5].map((end) => whole(middle + end * thick));
      pen.fillRect(left, down(high), right - left, down(-DECADES) - down(high));
    });
    return this.drawLimits(pen, box, across);
  }

  drawWaits(pen, width, height) {
    if (!this.probabilities) return;
    const { epsilon, particles } = this.controls.values;
    const box = this.box(width, height);
    const limits = {
      x: this.range,
      y: [0, 1],
      xlabel: "kick-off fraction b",
      ylabel: `no false start in ${this.wait} frames`,
    };
    const { across, down } = axes(pen, box, limits);
    const ink = pen.strokeStyle;
    const line = (probabilities) => {
      const waited = tails(probabilities).map((each) => (1 - each) ** this.wait);
      pen.beginPath();
      waited.forEach((none, k) => {
        const ends = [k, k + 1].map((count) =>
          Math.min(count / particles, this.highest),
        );
        for (const end of ends) pen.lineTo(across(end), down(none));
      });
      pen.stroke();
      return waited;
    };
    Object.assign(pen, { strokeStyle: GREY, lineWidth: 1 });
    const others = this.compared.filter((each) => each !== epsilon);
    const labels = others.map((share, k) => {
      const waited = line(binomial(particles, share / 100));
      const height = (k + 1) / (others.length + 1);
      const limit = waited.findIndex((none) => none > height) / particles;
      return [`${share} %`, across(Math.min(limit, this.highest)), down(height)];
    });
    Object.assign(pen, { strokeStyle: this.colors[0], lineWidth: 2.5 });
    line(this.probabilities);
    pen.strokeStyle = ink;
    const dragged = this.drawLimits(pen, box, across);
    for (const label of labels) this.interrupt(pen, ...label);
    return dragged;
  }

  // Words on a curve, in a gap of all that is drawn.
  interrupt(pen, words, x, y) {
    const half = pen.measureText(words).width / 2 + 2;
    pen.clearRect(x - half, y - 8, 2 * half, 16);
    pen.textAlign = "center";
    pen.fillText(words, x, y + 4);
  }

  // What one zone of three can hold, and b, which is dragged.
  drawLimits(pen, [, top, , height], across) {
    const line = (dashes, value) => {
      pen.setLineDash(dashes);
      return upright(pen, across(value), top, top + height);
    };
    pen.lineWidth = 1.5;
    line([2, 3], 1 / 3);
    const b = line([6, 4], this.controls.values.b);
    pen.setLineDash([]);
    return [b];
  }
}

export async function chance(panel, name) {
  const figure = new Chance(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
