// Figure 1 of [T09], live: the kernel dragged over the picture, and who counts where.

import { load } from "./host.js";
import { distanceAt, histograms, learn, look } from "./method/histograms.js";
import { fitted, layout } from "./method/kernels.js";
import { corners, displaced, warp } from "./method/regions.js";
import { SHOWN, still } from "./objects.js";
import { axes, Canvas, Controls, el, number, outline, takeOver } from "./page.js";

const NEAR = 12; // [px] from a bar, to have meant it
const GREEN = "#00a751";

class Histograms {
  constructor(panel, name, { fields, colors, highest }) {
    Object.assign(this, { colors, highest });
    const place = (reach, title) => ({
      low: -reach,
      high: reach,
      step: 1,
      value: 0,
      own: true,
      title,
    });
    const free = {
      ...fields,
      span: { ...fields.span, step: 0.01 },
      x: place(60, "x [px]"),
      y: place(50, "y [px]"),
    };
    this.controls = new Controls(name, free, (_values, _quick, asked) =>
      this.follow(asked),
    );
    this.frame = new Canvas("", 0.9, (...pen) => this.drawFrame(...pen));
    this.seen = new Canvas("", 0.9, (...pen) => this.drawSamples(...pen));
    this.bars = new Canvas("", 0.3, (...pen) => this.drawBars(...pen), 210);
    this.bars.node.classList.add("mkt-wide");
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the circle. Point at a bar, and its pixels light up; " +
        "point at a pixel, and its bar does. Tap it again to see all. " +
        "Arrow keys move the circle, and go from bar to bar.",
    );
    const nodes = [this.frame, this.seen, this.bars].map(({ node }) => node);
    const stage = el("div", { class: "mkt-stage mkt-pairs" }, ...nodes);
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
    this.hands();
  }

  async follow(asked) {
    if (asked) this.bin = null;
    const { profile, span, bins, item } = this.controls.values;
    const key = (this.wanted = `${item} ${bins}`);
    if (this.known !== key) {
      const object = await still(item, bins);
      if (this.wanted !== key) return;
      Object.assign(this, { known: key, object, bin: null });
    }
    this.spec = { layout: "one", profile, span };
    const { region, images } = this.object;
    this.kernels = fitted(this.spec, region);
    this.target = learn(images[0], region, this.spec);
    this.count();
  }

  // The histogram where the kernel is.
  count() {
    const { x, y } = this.controls.values;
    const { region, images } = this.object;
    const [image] = images;
    this.place = displaced(region, x, y, 0);
    this.labels = look(image, this.kernels, this.place);
    [this.q] = histograms(image, this.kernels, this.place);
    this.filled = [...this.q.keys()].filter((u) => this.q[u] > 0);
    this.distance = distanceAt(this.target, image, this.place);
    this.draw();
  }

  light(bin) {
    if (this.bin === bin) return;
    this.bin = bin;
    this.draw();
  }

  draw() {
    const { x, y } = this.controls.values;
    const words = [
      `At x = ${number(x)} px, y = ${number(y)} px: ` +
        `${this.filled.length} of ${this.q.length} bins filled`,
      `distance ${this.distance.toFixed(3)} to the histogram at the object`,
    ];
    if (this.bin !== null) {
      const samples = this.labels.filter((u) => u === this.bin).length;
      words.push(
        `bin ${this.bin} has q = ${this.q[this.bin].toFixed(4)}, from ` +
          `${samples} of ${this.labels.length} samples`,
      );
    }
    this.said.textContent = `${words.join("; ")}.`;
    const about = {
      frame: `The frame, with the kernel at x = ${number(x)}, y = ${number(y)}`,
      seen: "What the kernel sees: its samples, the darker the less they weigh",
      bars: "The histogram: a bar for each bin, in its colour",
    };
    for (const [name, description] of Object.entries(about)) {
      this[name].node.setAttribute("aria-label", description);
      this[name].redraw();
    }
  }

  drawFrame(pen, width, height) {
    if (!this.place) return;
    const [left, top, shown, down] = SHOWN;
    const { picture, images, region } = this.object;
    const scale = width / shown;
    pen.drawImage(picture, ...SHOWN, 0, 0, width, height);
    if (this.bin !== null) {
      const veil = el("canvas", { width: shown, height: down });
      const dark = new ImageData(shown, down);
      for (let i = 0; i < shown * down; i++) {
        const [row, column] = [top + Math.floor(i / shown), left + (i % shown)];
        const lit = images[0].labels[row * images[0].width + column] === this.bin;
        dark.data[4 * i + 3] = lit ? 0 : 190;
      }
      veil.getContext("2d").putImageData(dark, 0, 0);
      pen.imageSmoothingEnabled = false;
      pen.drawImage(veil, 0, 0, width, height);
    }
    this.scale = scale;
    const onto = ([x, y]) => [(x + 0.5 - left) * scale, (y + 0.5 - top) * scale];
    outline(pen, corners(region).map(onto), "#333", 1);
    const { half, radii } = layout(this.spec, region[3] / region[4]);
    const [rx, ry] = radii.map((radius, axis) => radius / half[axis]);
    const round = Array.from({ length: 60 }, (_, i) => {
      const angle = (i * Math.PI) / 30;
      return onto(warp(this.place, [rx * Math.cos(angle), ry * Math.sin(angle)]));
    });
    return [outline(pen, round, GREEN, 2.5)];
  }

  // The square that the canvas of the samples has for the canonical one.
  cell(width, height) {
    const [, , , hx, hy] = this.object.region;
    const fit = Math.min((width - 2) / hx, (height - 26) / hy) / 2;
    return ([x, y]) => [width / 2 + x * hx * fit, 12 + height / 2 + y * hy * fit];
  }

  drawSamples(pen, width, height) {
    if (!this.labels) return;
    const { x, y, weight } = this.kernels;
    const { photo } = this.object;
    const onto = this.cell(width, height);
    const most = Math.max(...weight);
    const [, , , hx, hy] = this.object.region;
    // Samples of a row are neighbours.
    let gap = 2;
    for (let i = 1; i < x.length; i++)
      if (y[i] === y[i - 1]) gap = Math.min(gap, x[i] - x[i - 1]);
    const side = onto([gap, 0])[0] - onto([0, 0])[0] + 0.5;
    pen.textAlign = "left";
    pen.fillText("pulled back, as bright as it weighs", 4, 14);
    const box = [
      ...onto([-1, -1]),
      ...[hx, hy].map((half, axis) => onto([1, 1])[axis] - onto([-1, -1])[axis]),
    ];
    pen.fillStyle = "#000"; // what weighs nothing
    pen.fillRect(...box);
    for (let i = 0; i < x.length; i++) {
      const [u, v] = warp(this.place, [x[i], y[i]]).map(Math.round);
      const p = 4 * (v * photo.width + u);
      const light = 0.25 + (0.75 * weight[i]) / most;
      const [r, g, b] = photo.data.slice(p, p + 3).map((value) => value * light);
      pen.globalAlpha = this.bin === null || this.labels[i] === this.bin ? 1 : 0.12;
      pen.fillStyle = `rgb(${r} ${g} ${b})`;
      const [left, top] = onto([x[i], y[i]]);
      pen.fillRect(left - side / 2, top - side / 2, side, side);
    }
    pen.globalAlpha = 1;
    pen.strokeRect(...box);
  }

  barBox(width, height) {
    return [46, 22, width - 54, height - 62];
  }

  drawBars(pen, width, height) {
    if (!this.q) return;
    const box = this.barBox(width, height);
    const { q, filled } = this;
    const top = Math.max(this.highest, ...q);
    const limits = {
      x: [-0.5, q.length - 0.5],
      y: [0, top],
      xlabel: "bin u",
      ylabel: "q_u",
    };
    const { across, down } = axes(pen, box, limits);
    const ink = pen.fillStyle;
    const thick = Math.max(box[2] / q.length - 1, 2);
    const colors = this.colors[this.controls.values.bins];
    for (const u of filled) {
      pen.globalAlpha = this.bin === null || this.bin === u ? 1 : 0.35;
      pen.fillStyle = `rgb(${colors[u].join(" ")})`;
      const bar = [across(u) - thick / 2, down(q[u]), thick, down(0) - down(q[u])];
      pen.fillRect(...bar);
      Object.assign(pen, { strokeStyle: "#888", lineWidth: 0.5 });
      pen.strokeRect(...bar);
    }
    pen.globalAlpha = 1;
    if (this.bin === null) return;
    Object.assign(pen, { fillStyle: ink, strokeStyle: ink, lineWidth: 1 });
    const right = this.bin > q.length / 2;
    pen.textAlign = right ? "right" : "left";
    const words = `bin ${this.bin}: ${q[this.bin].toFixed(4)}`;
    pen.fillText(
      words,
      across(this.bin) + (right ? -8 : 8),
      Math.max(down(q[this.bin]), box[1] + 12),
    );
    pen.beginPath();
    pen.moveTo(across(this.bin), down(0));
    pen.lineTo(across(this.bin), down(0) + 6);
    pen.stroke();
  }

  // Hands

  hands() {
    const settle = () => this.controls.set({});
    let [from, x, y] = [[0, 0], 0, 0];
    this.frame.dragged(
      (point) => {
        from = point;
        ({ x, y } = this.controls.values);
      },
      ([u, v]) => {
        const moved = [u - from[0], v - from[1]].map((each) =>
          Math.round(each / this.scale),
        );
        this.controls.set({ x: x + moved[0], y: y + moved[1] }, true);
      },
      settle,
    );
    this.frame.keyed(([right, down]) => {
      const { values } = this.controls;
      this.controls.set({ x: values.x + right, y: values.y + down });
    });
    const lit = (at) => (point, taps) => {
      if (!this.q) return;
      const bin = point && at(point);
      this.light(taps && bin === this.bin ? null : bin);
    };
    this.frame.hovered(lit((point) => this.binAt(point)));
    this.seen.hovered(lit((point) => this.sampleAt(point)));
    this.bars.hovered(lit((point) => this.barAt(point)));
    this.bars.keyed(([right, down]) => {
      const at = this.filled.indexOf(this.bin) + right - down;
      this.light(this.filled.at(at < 0 ? -1 : at % this.filled.length));
    });
  }

  binAt([u, v]) {
    const { width, labels } = this.object.images[0];
    const [column, row] = [SHOWN[0] + u / this.scale, SHOWN[1] + v / this.scale].map(
      Math.floor,
    );
    return labels[row * width + column] ?? null;
  }

  sampleAt([u, v]) {
    const { clientWidth, clientHeight } = this.seen.node;
    const onto = this.cell(clientWidth, clientHeight);
    const { x, y } = this.kernels;
    let [best, nearest] = [NEAR, null];
    for (let i = 0; i < x.length; i++) {
      const [left, top] = onto([x[i], y[i]]);
      const far = Math.hypot(left - u, top - v);
      if (far < best) [best, nearest] = [far, this.labels[i]];
    }
    return nearest;
  }

  barAt([u]) {
    const [left, , width] = this.barBox(this.bars.node.clientWidth, 0);
    const bin = ((u - left) / width) * this.q.length - 0.5;
    const off = (each) => Math.abs(each - bin);
    const nearest = this.filled.reduce((best, each) =>
      off(each) < off(best) ? each : best,
    );
    return (off(nearest) * width) / this.q.length < NEAR ? nearest : null;
  }
}

export async function histogramsOf(panel, name) {
  const figure = new Histograms(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) await figure.controls.follow();
}
