// own.success, live: success curves, and the ranking at a limit that moves freely.

import { load } from "./host.js";
import { success } from "./method/evaluation.js";
import { linspace } from "./method/numbers.js";
import {
  axes,
  Canvas,
  Controls,
  el,
  legible,
  number,
  setBusy,
  takeOver,
  upright,
  within,
} from "./page.js";

const LIMITS = linspace(0, 1, 21); // of the curves, as in mkt.evaluation
const [ROW, BAR] = [32, 11]; // [px] of a tracker: its name, and its bar below
const DASHES = { "-": [], "--": [7, 4], "-.": [7, 3, 2, 3], ":": [2, 3] };

class Success {
  constructor(panel, name, { fields, trackers }) {
    this.trackers = trackers;
    const free = { ...fields, limit: { ...fields.limit, low: 0, high: 1, step: 0.01 } };
    this.controls = new Controls(name, free, () => this.follow());
    this.curves = new Canvas("", 1.25, (...pen) => this.drawCurves(...pen));
    const least = ROW * trackers.length + 26;
    this.ranking = new Canvas("", 0, (...pen) => this.drawRanking(...pen), least);
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the limit on the curves, or point at a row to see its curve. " +
        "Arrow keys do both.",
    );
    this.stage = el(
      "div",
      { class: "mkt-stage mkt-pairs" },
      this.curves.node,
      this.ranking.node,
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, this.stage, this.said, hint, this.controls.copies());
    this.hands();
  }

  async follow() {
    const { scene, seed } = this.controls.values;
    const wanted = `success-${scene}-${seed}`;
    if (this.wanted !== wanted) {
      this.wanted = wanted;
      this.said.textContent = "The trackers run over this scene.";
      setBusy(this.stage, true);
    }
    const runs = await load(wanted).catch((error) => error);
    if (this.wanted !== wanted) return;
    setBusy(this.stage, false);
    if (runs instanceof Error) {
      this.wanted = null; // to be tried again
      this.said.textContent = "";
      throw runs;
    }
    this.rank(runs, this.controls.values.limit);
  }

  rank({ seen, frames }, limit) {
    const rows = this.trackers.map((tracker, k) => {
      const curve = success(seen[k], LIMITS);
      const [share] = success(seen[k], [limit]);
      const area = curve.reduce((sum, each) => sum + each, 0) / curve.length;
      return {
        ...tracker,
        curve,
        share,
        every: (share * seen[k].length) / frames,
        area,
      };
    });
    this.rows = rows.sort((a, b) => b.share - a.share || b.area - a.area);
    this.draw();
  }

  draw() {
    const { limit } = this.controls.values;
    const percent = ({ share }) => `${(100 * share).toFixed(1)} %`;
    const best = this.rows[0].share ? this.best(percent) : "no tracker exceeds it";
    this.said.textContent = `At a limit of ${number(limit)}: ${best}.`;
    const order = this.rows.map((row) => `${row.label} ${percent(row)}`).join(", ");
    this.curves.node.setAttribute(
      "aria-label",
      `Success curves of ${this.rows.length} trackers, the limit at ` +
        `${number(limit)}`,
    );
    this.ranking.node.setAttribute("aria-label", `Ranking: ${order}`);
    this.curves.redraw();
    this.ranking.redraw();
  }

  // All who are first, and who comes next.
  best(percent) {
    const [{ share }] = this.rows;
    const tied = this.rows.filter((row) => row.share === share);
    const labels = tied.map(({ label }) => label).join("; "); // which have commas
    const names = labels.replace(/; ([^;]*)$/, " and $1");
    const next = this.rows[tied.length];
    return (
      `first ${tied.length > 1 ? "are" : "is"} ${names} with ` +
      `${percent(tied[0])} of the seen frames` +
      (next ? `, then ${next.label} with ${percent(next)}` : "")
    );
  }

  curveBox(width, height) {
    return [38, 22, width - 46, height - 62];
  }

  drawCurves(pen, width, height) {
    if (!this.rows) return;
    const box = this.curveBox(width, height);
    const limits = {
      x: [0, 1],
      y: [0, 1],
      xlabel: "T_lim",
      ylabel: "share of the seen frames",
    };
    const { across, down } = axes(pen, box, limits);
    const ink = pen.strokeStyle;
    for (const row of this.rows) {
      const faint = this.pointed && this.pointed !== row.label;
      this.style(pen, row, faint);
      pen.beginPath();
      row.curve.forEach((share, i) => pen.lineTo(across(LIMITS[i]), down(share)));
      pen.stroke();
    }
    pen.globalAlpha = 1;
    Object.assign(pen, { strokeStyle: ink, lineWidth: 1.5 });
    pen.setLineDash([5, 4]);
    const { limit } = this.controls.values;
    const line = upright(pen, across(limit), box[1], box[1] + box[3]);
    pen.setLineDash([]);
    return [line];
  }

  style(pen, { color, dashes }, faint) {
    // Black lines are of the page's ink, to be seen by night too.
    const ink = getComputedStyle(pen.canvas).color;
    pen.strokeStyle = color === "black" ? ink : legible(pen, ink, color);
    pen.lineWidth = 2;
    pen.globalAlpha = faint ? 0.15 : 1;
    pen.setLineDash(DASHES[dashes]);
  }

  drawRanking(pen, width) {
    if (!this.rows) return;
    const ink = pen.fillStyle;
    pen.textAlign = "left";
    pen.fillText("true positives, of all frames hatched", 0, 14);
    pen.textAlign = "right";
    pen.fillText("area", width, 14);
    this.rows.forEach((row, i) => {
      const y = 22 + ROW * i;
      this.style(pen, row, this.pointed && this.pointed !== row.label);
      pen.beginPath();
      pen.moveTo(0, y + 9);
      pen.lineTo(26, y + 9);
      pen.stroke();
      pen.setLineDash([]);
      Object.assign(pen, { fillStyle: ink, textAlign: "left" });
      pen.fillText(row.label, 32, y + 13);
      pen.textAlign = "right";
      pen.fillText(row.area.toFixed(2), width, y + 13);
      this.bar(pen, row, y + 18, width);
    });
  }

  // The share of the seen frames, and hatched over it that of all: the page's ground
  // shows through, from which every bar stands out.
  bar(pen, { share, every }, top, width) {
    pen.fillStyle = pen.strokeStyle;
    pen.fillRect(0, top, width * share, BAR);
    within(pen, [0, top, width * every, BAR], () => {
      Object.assign(pen, {
        globalCompositeOperation: "destination-out",
        lineWidth: 1.5,
      });
      pen.beginPath();
      for (let x = -BAR; x < width; x += 7) {
        pen.moveTo(x, top + BAR);
        pen.lineTo(x + BAR, top);
      }
      pen.stroke();
    });
  }

  hands() {
    const to = ([u]) => {
      const [left, , width] = this.curveBox(this.curves.node.clientWidth, 0);
      this.controls.set({ limit: Math.round((100 * (u - left)) / width) / 100 }, true);
    };
    this.curves.dragged(to, to, () => this.controls.set({}));
    this.curves.keyed(([right, down]) => {
      const { limit } = this.controls.values;
      this.controls.set({ limit: Math.round(100 * limit + right - down) / 100 });
    });
    this.ranking.hovered((point, taps) => {
      const row = point && this.rows?.[Math.floor((point[1] - 22) / ROW)];
      this.point(taps && row?.label === this.pointed ? null : row);
    });
    this.ranking.keyed(([right, down]) => {
      const rows = this.rows ?? [];
      const at = rows.findIndex(({ label }) => label === this.pointed) + right + down;
      this.point(rows[Math.min(at, rows.length - 1)]); // above the first one: all
    });
  }

  // Let one row stand out, or all.
  point(row) {
    this.pointed = row?.label ?? null;
    this.curves.redraw();
    this.ranking.redraw();
  }
}

export async function successCurves(panel, name) {
  const figure = new Success(panel, name, await load(name));
  figure.controls.show();
  if (!figure.controls.read()) await figure.controls.follow();
}
