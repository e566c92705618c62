// own.interaction, live: what each velocity of the camera does to the car in the image,
// wherever the car is dragged.

import { load } from "./host.js";
import { motions } from "./method/servoing.js";
import {
  bitmap,
  Canvas,
  Controls,
  el,
  outline,
  takeOver,
  within,
  write,
} from "./page.js";
import { drawTable } from "./table.js";

const [CURRENT, INK] = ["#00a751", "#000"];
const [HEAD, FOOT, LINE] = [20, 36, 15]; // [px] above and below a view, of a line
const LEAST = 175; // [px] of the height of a view with its words
const TIP = 7; // [px] of an arrow
const FEATURES = ["x_n", "y_n", "a_n", "\u03b8"];
const AXES = ["v_x", "v_y", "v_z", "\u03c9_x", "\u03c9_y", "\u03c9_z"];
const PAIRS = [0, 4, 1, 3, 2, 5]; // beside a translation the turn that looks like it

const signed = (value) =>
  Math.abs(value) >= 5e-3
    ? `${value < 0 ? "\u2212" : "+"}${Math.abs(value).toFixed(2)}`
    : "0";

// The way of a corner, with a tip where it is long enough.
function arrow(pen, way) {
  const [end, before] = [way.at(-1), way.at(-2)];
  Object.assign(pen, { strokeStyle: INK, fillStyle: INK, lineWidth: 1.4 });
  pen.beginPath();
  way.forEach(([x, y]) => pen.lineTo(x, y));
  pen.stroke();
  if (Math.hypot(end[0] - way[0][0], end[1] - way[0][1]) < TIP / 2) return;
  const ahead = Math.atan2(end[1] - before[1], end[0] - before[0]);
  pen.beginPath();
  for (const [far, aside] of [
    [0, 0],
    [TIP, 0.4],
    [TIP, -0.4],
  ]) {
    const [c, s] = [Math.cos(ahead + aside), Math.sin(ahead + aside)];
    pen.lineTo(end[0] - far * c, end[1] - far * s);
  }
  pen.fill();
}

class Interaction {
  constructor(panel, name, data, picture) {
    Object.assign(this, data, { picture });
    const { x, y, turn, scale } = data.fields;
    const each = { x, y, turn, scale };
    this.controls = new Controls(name, each, () => this.follow());
    this.views = PAIRS.map((k) => {
      const view = new Canvas("", 0.86, (...pen) => this.drawView(k, ...pen), LEAST);
      this.hands(view);
      return view;
    });
    const stage = el(
      "div",
      { class: "mkt-stage mkt-track" },
      ...this.views.map(({ node }) => node),
    );
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the car in any view, or move it with the arrow keys. " +
        "Green is the car now, orange where it appears after the " +
        "camera alone has moved; below each view is its column of L.",
    );
    this.said = el("p", { class: "mkt-note", role: "status" });
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
  }

  follow() {
    const { x, y, turn, scale } = this.controls.values;
    const [cx, cy] = this.size.map((each) => (each - 1) / 2);
    const halves = this.halves.map((each) => each * scale);
    const region = [cx + x, cy + y, (turn * Math.PI) / 180, ...halves];
    Object.assign(this, motions(this, region, this.push));
    const above = Math.round(-100 * this.pose[2][3]);
    this.said.textContent = `The camera is ${above} cm above the table.`;
    PAIRS.forEach((k, place) => {
      const { node } = this.views[place];
      node.setAttribute("aria-label", `${this.title(k)}; ${this.column(k)}`);
      this.views[place].redraw();
    });
  }

  title = (k) => `${AXES[k]}: the camera ${this.motions[k]}`;

  entries = (k) => this.L.map((row, i) => `${FEATURES[i]} ${signed(row[k])}`);

  column = (k) => this.entries(k).join(",  ");

  // The scale of a view, and what is left beside it.
  fitted(width, height) {
    const scale = Math.min(width / this.size[0], (height - HEAD - FOOT) / this.size[1]);
    return [scale, (width - scale * this.size[0]) / 2];
  }

  drawView(k, pen, width, height) {
    if (!this.ways) return;
    const ink = pen.fillStyle;
    const [scale, left] = this.fitted(width, height);
    const [wide, high] = this.size.map((each) => scale * each);
    const onto = ([x, y]) => [left + (x + 0.5) * scale, HEAD + (y + 0.5) * scale];
    const way = this.ways[k].map((corners) => corners.map(onto));
    within(pen, [left, HEAD, wide, high], () => {
      drawTable(pen, this, this.picture, this.pose, onto);
      outline(pen, way[0], CURRENT, 2.5);
      outline(pen, way.at(-1), this.moved, 2.5);
      for (const corner of way[0].keys())
        arrow(
          pen,
          way.map((at) => at[corner]),
        );
    });
    Object.assign(pen, { fillStyle: ink, textAlign: "center" });
    const narrow = pen.measureText(this.column(k)).width > width;
    const title = narrow ? `${AXES[k]}: ${this.motions[k]}` : this.title(k);
    write(pen, title, width / 2, HEAD - 7);
    const entries = this.entries(k);
    const lines = narrow ? [entries.slice(0, 2), entries.slice(2)] : [entries];
    for (const [i, line] of lines.entries())
      write(pen, line.join(",  "), width / 2, HEAD + high + 16 + i * LINE);
    return way.slice(0, 1);
  }

  hands(view) {
    let from;
    const begin = (point) => {
      const { x, y } = this.controls.values;
      from = { point, x, y };
    };
    const to = ([u, v]) => {
      const { clientWidth, clientHeight } = view.node;
      const [scale] = this.fitted(clientWidth, clientHeight);
      const x = Math.round(from.x + (u - from.point[0]) / scale);
      const y = Math.round(from.y + (v - from.point[1]) / scale);
      this.controls.set({ x, y }, true);
    };
    view.dragged(begin, to, () => this.controls.set({}));
    view.keyed(([right, down]) => {
      const { x, y } = this.controls.values;
      this.controls.set({ x: x + right, y: y + down });
    });
  }
}

export async function interaction(panel, name) {
  const data = await load(name);
  const picture = await bitmap(data.picture);
  const figure = new Interaction(panel, name, data, picture);
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
