// own.resampling, live: darts on the bar of weights, under four schemes.

import { thrown } from "./darts.js";
import { load } from "./host.js";
import { logLikelihood } from "./method/histograms.js";
import { effectiveSampleSize, normalised, SCHEMES } from "./method/particles.js";
import { random, replay } from "./method/random.js";
import { axes, Canvas, Controls, dot, el, takeOver } from "./page.js";

const REPEATS = 400; // draws of which the scatter is taken
const GREY = "#999";

class Resampling {
  constructor(panel, name, { fields, distances, uniforms, colors }) {
    Object.assign(this, { distances, uniforms, colors });
    const free = {
      ...fields,
      n: { ...fields.n, step: 1 },
      lam: { ...fields.lam, step: 1 },
    };
    this.controls = new Controls(name, free, () => this.follow());
    const canvas = (...about) => new Canvas("", ...about);
    this.bar = canvas(0.16, (...pen) => this.drawBar(...pen), 110);
    this.bar.node.classList.add("mkt-wide");
    this.weights = canvas(0.8, (...pen) => this.drawWeights(...pen));
    this.offspring = canvas(0.8, (...pen) => this.drawOffspring(...pen));
    this.scatter = canvas(0.8, (...pen) => this.drawScatter(...pen));
    this.said = el("p", { class: "mkt-note", role: "status" });
    const all = [this.bar, this.weights, this.offspring, this.scatter];
    const stage = el("div", { class: "mkt-stage" }, ...all.map(({ node }) => node));
    const keys = el(
      "p",
      { class: "mkt-note" },
      "Arrow keys on a picture: lambda (right, left), seed (down, up).",
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, keys, this.controls.copies());
    const step = ([right, down]) => {
      const { lam, seed } = this.controls.values;
      this.controls.set({ lam: lam + right, seed: seed + down });
    };
    for (const each of all) each.keyed(step);
  }

  follow() {
    const { scheme, n, lam, seed } = this.controls.values;
    this.d = this.distances[n];
    this.w = normalised(this.d.map((d) => logLikelihood([1 - d * d], lam)));
    const drawn = this.uniforms[seed];
    this.ancestors = SCHEMES[scheme](this.w, replay({ uniforms: drawn, normals: [] }));
    this.counts = counted(this.ancestors, n);
    const known = `${n} ${lam}`;
    if (this.known !== known)
      this.spreads = Object.keys(SCHEMES).map((each) => spread(each, this.w));
    this.known = known;
    Object.assign(this, thrown(scheme, this.w, drawn));
    this.draw();
  }

  draw() {
    const { scheme, n } = this.controls.values;
    const alive = this.counts.filter((count) => count).length;
    this.nEff = effectiveSampleSize(this.w);
    this.said.textContent =
      `${scheme}: ${alive} of ${n} live on; offspring ` +
      `${this.counts.join(" ")}. N_eff ${this.nEff.toFixed(1)} of ` +
      `${n}.`;
    const spreads = Object.keys(SCHEMES).map(
      (name, k) => `${name} ${this.spreads[k].toFixed(2)}`,
    );
    const about = {
      bar: `The weights end to end, with ${this.darts.length} draws`,
      weights: "The weights over the distances that made them",
      offspring: "The offspring of each particle, and what is expected",
      scatter: `How far the offspring scatter: ${spreads.join(", ")}`,
    };
    for (const [name, words] of Object.entries(about)) {
      this[name].node.setAttribute("aria-label", words);
      this[name].redraw();
    }
  }

  drawBar(pen, width, height) {
    if (!this.shares) return;
    const ink = pen.fillStyle;
    const [left, wide, top, bottom] = [6, width - 12, 44, height - 8];
    const many = this.darts.length;
    const residual = this.controls.values.scheme === "residual";
    const over = many
      ? "what rounding left over, and the draws from it"
      : "nothing is left over";
    pen.textAlign = "left";
    pen.fillText(residual ? over : `${many} draws`, left, 12);
    if (!many) return;
    let from = 0;
    this.shares.forEach((share, i) => {
      pen.fillStyle = this.colors[i];
      const box = [left + from * wide, top, share * wide, bottom - top];
      pen.fillRect(...box);
      pen.strokeRect(...box);
      pen.fillStyle = "#000";
      pen.textAlign = "center";
      if (share * wide > 14)
        pen.fillText(String(i), box[0] + box[2] / 2, (top + bottom) / 2 + 4);
      from += share;
    });
    for (const dart of this.darts) {
      const x = left + dart * wide;
      pen.fillStyle = "#000"; // on the colours, which are light by night too
      pen.fillRect(x - 1, top, 2, 14);
      pen.fillStyle = ink;
      pen.fillRect(x - 1, top - 12, 2, 12);
      pen.beginPath();
      [
        [-5, -22],
        [5, -22],
        [0, -12],
      ].forEach(([u, v]) => pen.lineTo(x + u, top + v));
      pen.fill();
    }
  }

  drawWeights(pen, width, height) {
    if (!this.w) return;
    const box = [38, 22, width - 46, height - 62];
    const limits = { x: [0, 0.7], y: [0, 1], xlabel: "distance d", ylabel: "weight w" };
    const { across, down } = axes(pen, box, limits);
    this.w.forEach((w, i) => dot(pen, across(this.d[i]), down(w), 6, this.colors[i]));
  }

  drawOffspring(pen, width, height) {
    if (!this.counts) return;
    const n = this.counts.length;
    const box = [30, 22, width - 38, height - 62];
    const limits = {
      x: [-0.5, n - 0.5],
      y: [0, n],
      xlabel: "particle",
      ylabel: "offspring; lines: expected, N w",
    };
    const { across, down } = axes(pen, box, limits);
    const ink = pen.strokeStyle;
    const thick = (0.8 * box[2]) / n;
    this.counts.forEach((count, i) => {
      const left = across(i) - thick / 2;
      pen.fillStyle = this.colors[i];
      pen.fillRect(left, down(count), thick, down(0) - down(count));
      pen.fillStyle = ink;
      pen.fillRect(left, down(n * this.w[i]) - 1, thick, 2);
    });
  }

  drawScatter(pen, width, height) {
    if (!this.spreads) return;
    const box = [82, 22, width - 92, height - 62];
    const limits = { x: [0, 1.3], y: [0, 1], xlabel: "scatter of the offspring" };
    const ink = pen.fillStyle;
    const { across } = axes(pen, box, limits);
    // No numbers at the left: the names stand there.
    pen.clearRect(0, 0, box[0] - 2, box[1] + box[3] + 5);
    pen.textAlign = "right";
    const row = box[3] / 4;
    Object.keys(SCHEMES).forEach((name, k) => {
      const top = box[1] + row * (k + 0.15);
      pen.fillStyle = name === this.controls.values.scheme ? ink : GREY;
      pen.fillRect(box[0], top, across(this.spreads[k]) - box[0], 0.7 * row);
      pen.fillStyle = ink;
      pen.fillText(name, box[0] - 6, top + 0.35 * row + 4);
    });
  }
}

function counted(ancestors, n) {
  const counts = Array(n).fill(0);
  for (const i of ancestors) counts[i]++;
  return counts;
}

// Root mean square of the offspring minus N w.
function spread(scheme, weights) {
  const [rng, n] = [random(1), weights.length];
  let sum = 0;
  for (let k = 0; k < REPEATS; k++)
    counted(SCHEMES[scheme](weights, rng), n).forEach((count, i) => {
      sum += (count - n * weights[i]) ** 2;
    });
  return Math.sqrt(sum / REPEATS / n);
}

export async function resampling(panel, name) {
  const figure = new Resampling(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
