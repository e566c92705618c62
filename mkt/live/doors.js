// Figure 3 of [N03], live: samples wait for a student behind a tree, at doors that are
// dragged, and those that look enough like the model appear.

import { most } from "./binomial.js";
import { load } from "./host.js";
import { coefficient, disc, place, summary } from "./method/appearance.js";
import { colorBins } from "./method/colors.js";
import { random } from "./method/random.js";
import { corners } from "./method/regions.js";
import {
  axes,
  bitmap,
  Canvas,
  Controls,
  dot,
  el,
  number,
  pixels,
  takeOver,
} from "./page.js";

const [WAITING, APPEARS, MEAN, DOOR] = ["#fff", "#d62728", "#737373", "#cc79a7"];
const REACH = 2; // spreads of a door, as far as it is drawn
const [RUG, GAP] = [10, 8]; // [px] of a sample's mark below the histogram, and over it
const BARS = "#999";

class Doors {
  constructor(panel, name, data) {
    Object.assign(this, data, {
      disc: disc(data.samples),
      bins: colorBins({ space: "rgb" }),
    });
    this.around = summary(data.background);
    const { placement, particles, frame, seed } = data.fields;
    const [width, height] = data.size;
    const [[x1, y, spread], [x2]] = data.doors;
    const own = (title, high, value) => ({
      low: 0,
      high,
      step: 1,
      value: Math.round(value),
      title,
      own: true,
    });
    const fields = {
      placement,
      particles,
      frame: { ...frame, only: true }, // those of which there are data
      seed,
      x1: own("left door: x [px]", width - 1, x1),
      y1: own("left door: y [px]", height - 1, y),
      x2: own("right door: x [px]", width - 1, x2),
      y2: own("right door: y [px]", height - 1, y),
      spread: { ...own("spread of the doors [px]", 60, spread), low: 1 },
      sigmas: {
        low: 0,
        high: 5,
        step: 0.1,
        value: 2,
        title: "spreads above the mean",
        own: true,
      },
    };
    this.controls = new Controls(name, fields, () => this.follow());
    this.view = new Canvas("", height / width, (...pen) => this.drawView(...pen));
    this.plot = new Canvas("", 0.75, (...pen) => this.drawPlot(...pen), 258);
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag a door, or move the right one with the arrow keys. White " +
        "samples wait, red ones fulfil (15), pink circles are the " +
        "doors, twice their spread wide; the dashed ellipse is the " +
        "student while in view. Point at a sample to see its " +
        "coefficient.",
    );
    const left = el("div", {}, this.view.node, this.said);
    const stage = el("div", { class: "mkt-stage mkt-pairs" }, left, this.plot.node);
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, hint, this.controls.copies());
    this.hands();
  }

  // Pictures come one by one; what is asked last counts.
  async follow() {
    const { frame } = this.controls.values;
    this.wanted = frame;
    if (this.shown !== frame) {
      const { picture, binned, truth } = await load(`doors-${frame}`);
      const both = [bitmap(picture), pixels(binned)];
      const [photo, flat] = await Promise.all(both);
      if (this.wanted !== frame) return;
      Object.assign(this, { photo, truth, image: this.bins(flat), shown: frame });
    }
    this.wait();
  }

  zones() {
    const { placement, x1, y1, x2, y2, spread } = this.controls.values;
    const doors = [
      [x1, y1, spread, spread],
      [x2, y2, spread, spread],
    ];
    return {
      doors,
      borders: ["borders"],
      "doors and borders": [...doors, "borders"],
      anywhere: ["anywhere"],
    }[placement];
  }

  wait() {
    const { particles, sigmas, seed } = this.controls.values;
    const rng = random(seed);
    this.regions = place(this.zones(), this.size, this.halfAxes, particles, rng);
    this.rho = this.regions.map((region) =>
      coefficient(this.image, this.disc, region, this.model),
    );
    this.limit = this.around.mean + sigmas * this.around.spread;
    this.positives = this.rho.filter((rho) => rho > this.limit).length;
    this.pointed = undefined; // it was one of those before
    this.draw();
  }

  draw() {
    const { frame, particles } = this.controls.values;
    const needed = most(this.share, particles);
    const begun = this.positives > needed;
    this.said.textContent =
      `Frame ${frame}: ${this.positives} of ${particles} appear; it ` +
      `takes more than ${number(needed)}, so the tracking ` +
      `${begun ? "starts" : "does not start"}.`;
    this.view.node.setAttribute(
      "aria-label",
      `Frame ${frame} with ${particles} samples, of which ` +
        `${this.positives} appear`,
    );
    this.plot.node.setAttribute(
      "aria-label",
      "Coefficients of the background, the limit at " +
        `${this.limit.toFixed(2)}, the student at ` +
        `${this.student.toFixed(2)}, and a mark for each sample`,
    );
    this.view.redraw();
    this.plot.redraw();
  }

  drawView(pen, width, height) {
    if (!this.photo) return;
    const scale = width / this.size[0];
    const ellipse = ([cx, cy, , hx, hy], color, thick) => {
      pen.beginPath();
      pen.ellipse(
        (cx + 0.5) * scale,
        (cy + 0.5) * scale,
        hx * scale,
        hy * scale,
        0,
        0,
        7,
      );
      Object.assign(pen, { strokeStyle: color, lineWidth: thick });
      pen.stroke();
    };
    pen.drawImage(this.photo, 0, 0, width, height);
    const colors = this.rho.map((rho) => (rho > this.limit ? APPEARS : WAITING));
    pen.globalAlpha = 0.3;
    this.regions.forEach((region, i) => ellipse(region, colors[i], 1.2));
    pen.globalAlpha = 1;
    this.regions.forEach(([cx, cy], i) =>
      dot(pen, (cx + 0.5) * scale, (cy + 0.5) * scale, 2.6, colors[i]),
    );
    const things = [];
    for (const [x, y, reach] of this.zones())
      if (Number.isFinite(reach)) {
        const region = [x, y, 0, REACH * reach, REACH * reach];
        ellipse(region, "#fff", 4);
        ellipse(region, DOOR, 2.2);
        things.push(corners(region).map((end) => end.map((u) => (u + 0.5) * scale)));
      }
    if (this.truth) {
      ellipse(this.truth, "#000", 2.5); // the colours of outlineTruth
      pen.setLineDash([5, 4]);
      ellipse(this.truth, "#fff", 1.2);
      pen.setLineDash([]);
    }
    const i = this.pointed;
    if (i !== undefined) ellipse(this.regions[i], colors[i], 3);
    return things;
  }

  drawPlot(pen, width, height) {
    if (!this.rho) return;
    const ink = pen.fillStyle;
    const { counts, mean } = this.around;
    const tallest = Math.max(...counts);
    const box = [34, 40, width - 42, height - 102]; // the legend is above
    const { across, down } = axes(pen, box, {
      x: [0, 1],
      y: [0, tallest],
      ylabel: "ellipses of the background",
    });
    const wide = across(1 / counts.length) - across(0);
    pen.fillStyle = BARS;
    counts.forEach((count, i) =>
      pen.fillRect(across(i / counts.length), down(count), wide, down(0) - down(count)),
    );
    const { sigmas } = this.controls.values;
    const lines = [
      [mean, MEAN, "\u03bc"],
      [this.limit, APPEARS, `\u03bc + ${number(sigmas)} \u03c3`],
      [this.student, ink, "student"],
    ];
    pen.textAlign = "left";
    let [left] = box;
    for (const [value, color, label] of lines) {
      const words = `${label} ${value.toFixed(2)}`;
      pen.fillStyle = color;
      pen.fillRect(across(value) - 1, box[1], 2, box[3]);
      pen.fillRect(left, 7, 9, 9);
      pen.fillStyle = ink;
      pen.fillText(words, left + 13, 16);
      left += 27 + pen.measureText(words).width;
    }
    const below =
      this.background.filter((rho) => rho <= this.limit).length /
      this.background.length;
    Object.assign(pen, { fillStyle: ink, textAlign: "left" });
    pen.fillText(
      `${(100 * below).toFixed(1)} % of the background below the limit`,
      box[0],
      height - 4,
    );
    const top = height - 54;
    this.rho.forEach((rho, i) => {
      pen.fillStyle = rho > this.limit ? APPEARS : MEAN;
      const thick = i === this.pointed ? 5 : 1.2;
      pen.fillRect(across(rho) - thick / 2, top + GAP, thick, RUG);
    });
    Object.assign(pen, { fillStyle: ink, textAlign: "right" });
    pen.fillText(
      "a mark for each sample; coefficient \u03c1",
      box[0] + box[2],
      height - 20,
    );
  }

  hands() {
    const toImage = ([u, v]) => {
      const scale = this.size[0] / this.view.node.clientWidth;
      return [u * scale - 0.5, v * scale - 0.5];
    };
    const far = ([u, v], [x, y]) => Math.hypot(u - x, v - y);
    const centres = () => {
      const { x1, y1, x2, y2 } = this.controls.values;
      return [
        [x1, y1],
        [x2, y2],
      ];
    };
    let door = 0;
    const to = (point) => {
      const [x, y] = toImage(point).map(Math.round);
      this.controls.set({ [`x${door + 1}`]: x, [`y${door + 1}`]: y }, true);
    };
    const hasDoors = () => this.controls.values.placement.startsWith("doors");
    this.view.dragged(
      (point) => {
        if (!hasDoors()) return false;
        const [one, other] = centres().map((centre) => far(centre, toImage(point)));
        door = one <= other ? 0 : 1;
        to(point);
      },
      to,
      () => this.controls.set({}),
    );
    this.view.keyed(([right, down]) => {
      if (!hasDoors()) return;
      const { x2, y2 } = this.controls.values;
      this.controls.set({ x2: x2 + right, y2: y2 + down });
    });
    this.view.hovered((point) => this.point(point && toImage(point), far));
  }

  point(at, far) {
    if (!this.regions) return;
    const off = this.regions.map((region) => (at ? far(region, at) : Infinity));
    const least = Math.min(...off);
    const pointed = least < 6 ? off.indexOf(least) : undefined;
    if (pointed === this.pointed) return;
    this.pointed = pointed;
    this.view.redraw();
    this.plot.redraw();
  }
}

export async function doors(panel, name) {
  const figure = new Doors(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) await figure.controls.follow();
}
