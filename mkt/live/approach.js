// own.approach, live: the loop closes on a car that stands still, with any gain, rate
// and delay; the start is dragged, too.

import { load } from "./host.js";
import { approached } from "./method/servoing.js";
import {
  axes,
  bitmap,
  Canvas,
  Controls,
  el,
  legible,
  number,
  outline,
  takeOver,
  within,
  write,
} from "./page.js";
import { drawTable } from "./table.js";

const SECONDS = 6;
const [NEAR, DEEP] = [0.3, -0.12]; // [m] of the start, beside and behind the goal
const AWAY = 1e4; // of what runs away
const [TALL, HEAD, GAP] = [112, 24, 30]; // [px] of a plot
const [RED, GREEN, BLACK] = ["#cb1118", "#00a751", "#000"];
const ERRORS = ["x_n", "y_n", "a_n", "\u03b8"];
const MOVES = ["v_x", "v_y", "v_z"];
const TURNS = ["\u03c9_x", "\u03c9_y", "\u03c9_z"];

// The next of 1, 2, 5, 10, ...
function round(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].find((each) => each * power >= value) * power;
}

const most = (values) => Math.max(...values.map(Math.abs));
// Of what is drawn: neither nothing nor what has run away.
const reachOf = (values) =>
  round(Math.max(most(values.filter((each) => Math.abs(each) < AWAY)), 1e-3));

const dashesOf = ({ dashes }) => (dashes === "-" ? [] : [7, 4]);

// A piece of a curve before its name; returns the width that it takes.
function sample(pen, color, style, left, y) {
  Object.assign(pen, { strokeStyle: color, lineWidth: 2 });
  pen.setLineDash(dashesOf(style));
  pen.beginPath();
  pen.moveTo(left, y);
  pen.lineTo(left + 18, y);
  pen.stroke();
  pen.setLineDash([]);
  return 22;
}

class Approach {
  constructor(panel, name, data, table) {
    Object.assign(this, data, { table });
    const { gain, fps, delay, dof, turn } = data.fields;
    const side = (title, value) => ({
      low: -NEAR,
      high: NEAR,
      step: 0.01,
      value,
      own: true,
      title,
    });
    const each = {
      gain,
      fps,
      delay,
      dof,
      turn,
      right: side("start: right [m]", 0.05),
      down: side("start: down [m]", -0.06),
    };
    this.controls = new Controls(name, each, () => this.follow());
    this.view = new Canvas("", this.size[1] / this.size[0], (...pen) =>
      this.drawView(...pen),
    );
    const tall = 3 * (HEAD + TALL) + GAP;
    this.plots = new Canvas("", 0, (...pen) => this.drawPlots(...pen), tall);
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the view to begin from another place; the arrow keys " +
        "turn the gain. Red is where the car should appear, green " +
        "where it appears at the start; black are the ways of its " +
        "corners, with a dot for each frame.",
    );
    const left = el("div", {}, this.view.node, this.said);
    const stage = el("div", { class: "mkt-stage mkt-film" }, left, this.plots.node);
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, hint, this.controls.copies());
    this.hands();
  }

  follow() {
    const { gain, fps, delay, dof, turn, right, down } = this.controls.values;
    const law = { gain, dt: 1 / fps, delay, dof };
    const start = [right, down, DEEP, 0, 0, (turn * Math.PI) / 180];
    this.frames = Math.round(SECONDS * fps) + 1;
    this.rows = approached(this, law, start, this.frames);
    this.draw();
  }

  draw() {
    const { gain, fps } = this.controls.values;
    const product = `Gain x frame period = ${number(gain / fps, 3)}`;
    this.said.textContent = `${product}: ${this.end()}.`;
    this.view.node.setAttribute(
      "aria-label",
      "The view at the start, and the ways of the car's corners in " +
        `${this.rows.length} frames`,
    );
    this.plots.node.setAttribute(
      "aria-label",
      "Errors, velocities and turning rates of the camera over 6 s; " + `${this.end()}`,
    );
    this.view.redraw();
    this.plots.redraw();
  }

  // How it ends, in words.
  end() {
    const { rows } = this;
    const { fps } = this.controls.values;
    if (!rows.length) return "at the start the camera does not see the car";
    if (rows.length < this.frames)
      return (
        `it runs away; after ${(rows.length / fps).toFixed(1)} s the ` +
        "car is behind the camera"
      );
    const [first, last] = [rows[0], rows.at(-1)].map(({ error }) => most(error));
    const share = (100 * last) / first;
    const left = share < 0.01 ? "less than 0.01" : number(share, 2);
    return share < 1000
      ? `after 6 s the largest error is ${left} % of the first one`
      : "it runs away";
  }

  drawView(pen, width) {
    if (!this.rows?.length) return;
    const scale = width / this.size[0];
    const onto = ([x, y]) => [(x + 0.5) * scale, (y + 0.5) * scale];
    drawTable(pen, this, this.table, this.rows[0].pose, onto);
    outline(pen, this.wanted.map(onto), RED, 2.5);
    const start = outline(pen, this.rows[0].outline.map(onto), GREEN, 2.5);
    for (const corner of [0, 1, 2, 3]) {
      const way = this.rows.map((row) => onto(row.outline[corner]));
      Object.assign(pen, { strokeStyle: BLACK, fillStyle: BLACK, lineWidth: 1 });
      pen.beginPath();
      way.forEach(([x, y]) => pen.lineTo(x, y));
      pen.stroke();
      for (const [x, y] of way) {
        pen.beginPath();
        pen.arc(x, y, 1.8, 0, 7);
        pen.fill();
      }
    }
    return [start];
  }

  drawPlots(pen, width) {
    if (!this.rows?.length) return;
    const { gain, fps } = this.controls.values;
    const first = this.rows[0].error;
    const promised = this.rows.map((_, k) =>
      first.map((each) => each * Math.exp((-gain * k) / fps)),
    );
    const errors = this.rows.map(({ error }) => error);
    const moves = this.rows.map(({ twist }) => twist.slice(0, 3));
    const turns = this.rows.map(({ twist }) => twist.slice(3));
    const styles = [...this.styles.slice(0, 3), this.styles[5]];
    const plots = [
      ["error", ERRORS, errors, styles, reachOf(first), promised],
      ["[m/s]", MOVES, moves, this.styles.slice(0, 3), reachOf(moves.flat())],
      ["[rad/s]", TURNS, turns, this.styles.slice(3), reachOf(turns.flat())],
    ];
    plots.forEach((plot, i) => this.drawPlot(pen, width, i, ...plot));
  }

  drawPlot(pen, width, i, unit, names, values, styles, reach, promised) {
    const ink = pen.strokeStyle;
    const colors = styles.map(({ color }) => legible(pen, ink, color));
    const box = [44, i * (HEAD + TALL) + HEAD, width - 54, TALL - 14];
    const limits = {
      x: [0, SECONDS],
      y: [-reach, reach],
      bare: i < 2,
      xlabel: i < 2 ? "" : "time [s]",
    };
    const { across, down } = axes(pen, box, limits);
    pen.textAlign = "left";
    let left = box[0];
    for (const [k, word] of [unit, ...names].entries()) {
      if (k) left += sample(pen, colors[k - 1], styles[k - 1], left, box[1] - 10);
      left += write(pen, word, left, box[1] - 6) + 12;
    }
    within(pen, box, () => {
      const line = (series, k, dashes, thick) => {
        Object.assign(pen, { strokeStyle: colors[k], lineWidth: thick });
        pen.setLineDash(dashes);
        pen.beginPath();
        const far = 9 * reach; // what runs away may be infinite
        const { fps } = this.controls.values;
        series.forEach((row, at) => {
          const height = down(Math.min(Math.max(row[k], -far), far));
          pen.lineTo(across(at / fps), height);
          // Held until the next frame.
          if (i) pen.lineTo(across((at + 1) / fps), height);
        });
        pen.stroke();
      };
      names.forEach((_, k) => {
        if (promised) line(promised, k, [1.5, 3], 1.2);
        line(values, k, dashesOf(styles[k]), 2);
      });
      pen.setLineDash([]);
    });
    Object.assign(pen, { fillStyle: ink, strokeStyle: ink, lineWidth: 1 });
  }

  hands() {
    let from;
    const begin = (point) => {
      const { right, down } = this.controls.values;
      from = { point, right, down };
    };
    // The camera goes the other way than what it sees.  It turns on its way, so that
    // the way is an arc, whose chord points along half the turn.
    const to = ([u, v]) => {
      const metres = this.metresAPixel();
      const [x, y] = [u - from.point[0], v - from.point[1]].map(
        (each) => each * metres,
      );
      const half = (this.controls.values.turn * Math.PI) / 360;
      const longer = half ? half / Math.sin(half) : 1;
      const [c, s] = [longer * Math.cos(half), longer * Math.sin(half)];
      const right = from.right - (c * x - s * y);
      const down = from.down - (s * x + c * y);
      this.controls.set({ right, down }, true);
    };
    this.view.dragged(begin, to, () => this.controls.set({}));
    const step = ([right, down]) => {
      const { gain } = this.controls.values;
      this.controls.set({ gain: gain + 0.05 * (right - down) });
    };
    this.view.keyed(step);
    this.plots.keyed(step);
  }

  // Of the table at the start, on the canvas.
  metresAPixel() {
    const depth = -this.rows[0].pose[2][3];
    return (depth / this.focal) * (this.size[0] / this.view.node.clientWidth);
  }
}

export async function approach(panel, name) {
  const data = await load(name);
  const table = await bitmap(data.picture);
  const figure = new Approach(panel, name, data, table);
  figure.controls.show();
  if (!figure.controls.read()) figure.follow();
}
