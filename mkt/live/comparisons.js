// cordoba2014.complexity, live: two readings of the search through the cumulative
// weights, draw by draw, and their cost for more particles.

import { load } from "./host.js";
import { random } from "./method/random.js";
import { axes, Canvas, Controls, dot, el, takeOver } from "./page.js";
import { Player } from "./player.js";
import { ancestors, drawn, geometric, slope, spans } from "./searching.js";

const READINGS = [true, false]; // whether the search begins anew
const [FEWEST, SIZES] = [25, 7]; // numbers of particles on each line, and the least
const PATIENCE = 4; // [ms] for which a search is timed
const PACE = 3; // draws a second
const PALE = 0.4;

// [ms] of a search, repeated until the browser's clock can tell.
function timed(search) {
  const start = performance.now();
  let times = 0;
  for (; performance.now() - start < PATIENCE; times++) search();
  return (performance.now() - start) / times;
}

class Comparisons {
  constructor(panel, name, { fields, labels, colors }) {
    Object.assign(this, { labels, colors });
    const { particles, largest, seed } = fields;
    const high = particles.high;
    const own = { own: true, title: "draws to come" };
    const left = { low: 0, high, step: 1, value: 0, words: "one a particle", ...own };
    const all = { particles, left, largest, seed };
    this.controls = new Controls(name, all, (_values, _quick, asked) =>
      this.follow(asked),
    );
    this.rows = new Canvas("", 0.85, (...pen) => this.drawRows(...pen), 260);
    this.lines = new Canvas("", 0.85, (...pen) => this.drawLines(...pen), 260);
    this.said = el("p", { class: "mkt-note", role: "status" });
    this.player = new Player(
      this.said,
      () => this.on(),
      () => this.controls.set({}),
    );
    this.player.at(PACE);
    const acts = el("div", { class: "mkt-controls" }, this.player.node);
    const names = labels.map((label, k) => {
      const sign = el("span", {}, "\u25a0 ");
      sign.style.color = colors[k];
      return el("span", {}, sign, label, " ");
    });
    const key = el("p", { class: "mkt-note" }, ...names);
    const stage = el(
      "div",
      { class: "mkt-stage mkt-pairs" },
      this.rows.node,
      this.lines.node,
    );
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Each row is a draw, as long as there are particles that it is " +
        "compared with. The arrow keys take a draw more or less; play " +
        "takes them all.",
    );
    const { node, note } = this.controls;
    takeOver(
      panel,
      node,
      note,
      acts,
      key,
      stage,
      this.said,
      hint,
      this.controls.copies(),
    );
    const step = ([right, down]) => this.take(right + down);
    for (const canvas of [this.rows, this.lines]) canvas.keyed(step);
  }

  done() {
    const { left, particles } = this.controls.values;
    return particles - left;
  }

  // So many draws more.
  take(more, quick = false) {
    const { particles } = this.controls.values;
    this.controls.set({ left: particles - this.done() - more }, quick);
  }

  // A draw more, or from the end the first one; whether there are more.
  on() {
    this.take(this.controls.values.left ? 1 : -this.done(), true);
    return this.controls.values.left > 0;
  }

  follow(begun) {
    if (begun) this.player.stop();
    const { values } = this.controls;
    const { particles, largest, seed } = values;
    values.left = Math.min(values.left, particles);
    const { input, typed } = this.controls.inputs.left;
    input.max = typed.max = particles;
    this.controls.show();
    const { cumulative, u } = drawn(particles, random(seed));
    this.chosen = ancestors(cumulative, u, false).chosen;
    const asked = `${largest} ${seed}`;
    if (this.asked !== asked) this.measure(Number(largest), seed);
    this.asked = asked;
    this.draw();
  }

  measure(largest, seed) {
    const sizes = geometric(FEWEST, largest, SIZES);
    const each = sizes.map((n) => drawn(n, random(seed)));
    const { cumulative, u } = each.at(-1);
    this.costs = READINGS.map((anew) => ({
      counts: each.map((one) => ancestors(one.cumulative, one.u, anew).comparisons),
      ms: timed(() => ancestors(cumulative, u, anew)),
    }));
    this.sizes = sizes;
  }

  // What is compared in the draws that are done, for a reading.
  shown(anew) {
    return spans(this.chosen, anew).slice(0, this.done());
  }

  draw() {
    const done = this.done();
    const counts = READINGS.map((anew) =>
      this.shown(anew).reduce((sum, [first, last]) => sum + last - first + 1, 0),
    );
    const [anew, swept] = this.costs.map(({ ms }) => ms.toPrecision(2));
    const last = done ? `The last one took particle ${this.chosen[done - 1]}. ` : "";
    this.said.textContent =
      `${done} of ${this.chosen.length} draws: ${counts[0]} ` +
      `${counts[0] === 1 ? "comparison" : "comparisons"} where each search ` +
      `begins anew, ${counts[1]} in one sweep. ${last}With ` +
      `${this.sizes.at(-1)} particles this browser takes ${anew} and ${swept} ms.`;
    this.rows.node.setAttribute(
      "aria-label",
      "The particles that each draw is compared with: " + `${counts.join(" and ")}`,
    );
    const slopes = this.costs.map((cost) => this.exponent(cost)).join(" and ");
    this.lines.node.setAttribute(
      "aria-label",
      "Comparisons over the number of particles, with the exponents " + `${slopes}`,
    );
    this.rows.redraw();
    this.lines.redraw();
  }

  points({ counts }) {
    return counts.map((count, k) => [Math.log10(this.sizes[k]), Math.log10(count)]);
  }

  exponent(cost) {
    return slope(this.points(cost)).toFixed(2);
  }

  drawRows(pen, width, height) {
    if (!this.chosen) return;
    const n = this.chosen.length;
    const box = [30, 22, width - 38, height - 62];
    const limits = {
      x: [-0.5, n - 0.5],
      y: [n - 0.5, -0.5],
      xlabel: "particle i",
      ylabel: "draw",
    };
    const { across, down } = axes(pen, box, limits);
    const thick = (0.8 * box[3]) / n;
    READINGS.forEach((anew, k) => {
      pen.globalAlpha = anew ? PALE : 1;
      pen.fillStyle = this.colors[k];
      this.shown(anew).forEach(([first, last], draw) => {
        const left = across(first - 0.5);
        pen.fillRect(left, down(draw) - thick / 2, across(last + 0.5) - left, thick);
      });
    });
    pen.globalAlpha = 1;
  }

  drawLines(pen, width, height) {
    if (!this.costs) return;
    const all = this.costs.map((cost) => this.points(cost));
    const [, top] = all[0].at(-1);
    const box = [30, 22, width - 38, height - 62];
    const limits = {
      x: [1.3, 3.3],
      y: [1, Math.ceil(top)],
      xlabel: "log10 of the particles N",
      ylabel: "log10 of the comparisons",
    };
    const { across, down } = axes(pen, box, limits);
    all.forEach((points, k) => {
      pen.beginPath();
      points.forEach(([x, y]) => pen.lineTo(across(x), down(y)));
      Object.assign(pen, { strokeStyle: this.colors[k], lineWidth: 2 });
      pen.stroke();
      for (const [x, y] of points) dot(pen, across(x), down(y), 4, this.colors[k]);
      const [x, y] = points.at(-2);
      Object.assign(pen, {
        fillStyle: getComputedStyle(pen.canvas).color,
        textAlign: "right",
      });
      pen.fillText(
        `exponent ${this.exponent(this.costs[k])}`,
        across(x) - 6,
        down(y) - 10,
      );
    });
  }
}

export async function comparisons(panel, name) {
  const figure = new Comparisons(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
