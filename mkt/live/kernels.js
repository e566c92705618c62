// Figure 2 of [T09], live: where kernels lie, and what each of them weighs.

import { load } from "./host.js";
import { fitted, layout, pixelGrid } from "./method/kernels.js";
import { still } from "./objects.js";
import { Canvas, Controls, el, number, takeOver } from "./page.js";

const SAMPLES = 1200;
const [BLUE, LIGHT] = ["#1e7dc1", "#fff"];
const WIDEST = { one: 1, "2x2": 1.25, tiles: 1 }; // spans that stay inside the object

class Kernels {
  constructor(panel, name, { fields }) {
    const free = {
      ...fields,
      span: { ...fields.span, step: 0.01 },
      kernel: { low: 1, high: 16, step: 1, value: 5, own: true },
    };
    this.controls = new Controls(name, free, () => this.follow());
    this.object = new Canvas("", 0.75, (...pen) => this.drawObject(...pen));
    this.weights = new Canvas("", 0.75, (...pen) => this.drawWeights(...pen));
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Point at a kernel, or go from one to the next with the arrow keys.",
    );
    const stage = el(
      "div",
      { class: "mkt-stage mkt-pairs" },
      this.object.node,
      this.weights.node,
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
    this.hands();
  }

  async follow() {
    const { layout: name, item, span: asked } = this.controls.values;
    const span = Math.min(asked, WIDEST[name] ?? asked);
    this.wanted = item;
    if (this.item !== item) {
      const { region, picture } = await still(item, "hsv");
      if (this.wanted !== item) return;
      Object.assign(this, { item, region, picture });
    }
    const tiled = name === "tiles"; // whose profile no one chooses
    const profile = tiled ? "uniform" : this.controls.values.profile;
    this.controls.inputs.profile.input.disabled = tiled;
    this.spec = { layout: name, span, profile, samples: SAMPLES };
    this.kernels = fitted(this.spec, this.region);
    this.plan = layout(this.spec, this.region[3] / this.region[4]);
    const { values } = this.controls;
    values.kernel = Math.min(values.kernel, this.plan.centres.length);
    this.controls.show();
    const [a, b] = this.plan.half;
    for (const canvas of [this.object, this.weights]) canvas.ratio = b / a;
    this.draw();
  }

  // Which kernel is looked at, from 0 on.
  chosen() {
    return this.controls.values.kernel - 1;
  }

  // In words, what was cut off the span.
  cut() {
    const { span } = this.spec;
    return span < this.controls.values.span ? ` Its span stays ${span}.` : "";
  }

  draw() {
    const { starts, weight, x } = this.kernels;
    const k = this.chosen();
    const many = this.plan.centres.length;
    const mine = weight.slice(starts[k], starts[k + 1]);
    const all = pixelGrid(SAMPLES, this.region[3] / this.region[4]).length;
    const worth = 1 / mine.reduce((sum, w) => sum + w * w, 0);
    const covered = Math.round((100 * x.length) / all);
    this.said.textContent =
      `Kernel ${k + 1} of ${many}, ${this.spec.profile}: it sees ` +
      `${mine.length} of ${all} samples, worth ${Math.round(worth)} ` +
      `equal ones (1 / sum K\u00b2). ${covered} % of the object lies ` +
      `under at least one kernel.${this.cut()}`;
    this.object.node.setAttribute(
      "aria-label",
      `The object with ${many} kernels, number ${k + 1} thick`,
    );
    this.weights.node.setAttribute(
      "aria-label",
      `The weights of kernel ${k + 1} over the object, ` +
        `${number(mine.length)} samples`,
    );
    this.object.redraw();
    this.weights.redraw();
  }

  // From the object plane to the canvas, which the object fills but for a margin.
  onto(width, height) {
    const [a, b] = this.plan.half;
    const fit = Math.min((width - 16) / (2 * a), (height - 16) / (2 * b));
    return { fit, place: ([x, y]) => [width / 2 + x * fit, height / 2 + y * fit] };
  }

  drawPicture(pen, width, height) {
    const [cx, cy, , hx, hy] = this.region;
    const { fit, place } = this.onto(width, height);
    const [a, b] = this.plan.half;
    const part = [cx - hx + 0.5, cy - hy + 0.5, 2 * hx, 2 * hy];
    pen.drawImage(this.picture, ...part, ...place([-a, -b]), 2 * a * fit, 2 * b * fit);
  }

  drawObject(pen, width, height) {
    if (!this.plan) return;
    this.drawPicture(pen, width, height);
    const { fit, place } = this.onto(width, height);
    const [rx, ry] = this.plan.radii;
    this.plan.centres.forEach((centre, k) => {
      const [u, v] = place(centre);
      const mine = k === this.chosen();
      for (const [color, thick] of [
        ["#000a", mine ? 6 : 3.5],
        [mine ? BLUE : LIGHT, mine ? 3.5 : 1.5],
      ]) {
        Object.assign(pen, { strokeStyle: color, lineWidth: thick });
        pen.beginPath();
        if (this.spec.layout === "tiles")
          pen.rect(u - rx * fit, v - ry * fit, 2 * rx * fit, 2 * ry * fit);
        else pen.ellipse(u, v, rx * fit, ry * fit, 0, 0, 7);
        pen.moveTo(u - 5, v);
        pen.lineTo(u + 5, v);
        pen.moveTo(u, v - 5);
        pen.lineTo(u, v + 5);
        pen.stroke();
      }
    });
  }

  drawWeights(pen, width, height) {
    if (!this.plan) return;
    pen.globalAlpha = 0.25;
    this.drawPicture(pen, width, height);
    const { place, fit } = this.onto(width, height);
    const { x, y, sample, weight, starts } = this.kernels;
    const [from, to] = [starts[this.chosen()], starts[this.chosen() + 1]];
    const most = weight.slice(from, to).reduce((top, w) => Math.max(top, w), 0);
    const [a, b] = this.plan.half;
    const side = (2 * fit) / Math.sqrt(SAMPLES); // the object's area is 4
    pen.fillStyle = BLUE;
    for (let p = from; p < to; p++) {
      const [u, v] = place([x[sample[p]] * a, y[sample[p]] * b]);
      pen.globalAlpha = 0.08 + (0.92 * weight[p]) / most;
      pen.fillRect(u - side / 2, v - side / 2, side - 0.6, side - 0.6);
    }
    pen.globalAlpha = 1;
    pen.strokeRect(...place([-a, -b]), 2 * a * fit, 2 * b * fit);
  }

  hands() {
    const near = ([u, v]) => {
      const { clientWidth, clientHeight } = this.object.node;
      const { place } = this.onto(clientWidth, clientHeight);
      const far = this.plan.centres.map((centre) => {
        const [x, y] = place(centre);
        return Math.hypot(x - u, y - v);
      });
      const kernel = far.indexOf(Math.min(...far)) + 1;
      if (kernel !== this.controls.values.kernel) this.controls.set({ kernel }, true);
    };
    const step = ([right, down]) => {
      const side = Math.round(Math.sqrt(this.plan.centres.length));
      const kernel = this.chosen() + 1 + right + side * down;
      if (kernel <= this.plan.centres.length) this.controls.set({ kernel });
    };
    for (const canvas of [this.object, this.weights]) {
      canvas.hovered((point) => point && this.plan && near(point));
      canvas.keyed(step);
    }
  }
}

export async function kernels(panel, name) {
  const figure = new Kernels(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) await figure.controls.follow();
}
