// Figure 6 of [T09], live: five trackers run behind the wall, five runs each, in the
// worker, with any number of particles and any threshold.

import { Exposure } from "./exposure.js";
import { load, worker } from "./host.js";
import { errors, overlap } from "./method/evaluation.js";
import { corners } from "./method/regions.js";
import { beside } from "./method/scenes.js";
import {
  axes,
  bitmap,
  Canvas,
  Controls,
  el,
  GONE,
  legible,
  outline,
  outlineTruth,
  setBusy,
  SLICE,
  takeOver,
  upright,
  within,
} from "./page.js";
import { Player } from "./player.js";

const PACE = 10; // frames a second
const PATIENCE = 150; // [ms] of rest before a wall is built anew
const QUANTITIES = ["x [px]", "y [px]", "orientation [deg]"];
const PAIR = ["pf-75", "combined"]; // (4) and (5), which have the settings
const [TALL, HEAD] = [78, 26]; // [px] of a tracker's row
const COLUMNS = [
  "tracker",
  "before [px]",
  "after [px]",
  "before [deg]",
  "after [deg]",
  "lost",
];

const median = (values) => {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
};

class Wall {
  constructor(panel, name, data, pictures, worker) {
    Object.assign(this, data, { worker, latest: {}, done: new Map() });
    this.exposure = new Exposure(data, pictures);
    const { particles, threshold, occlusion, seed } = data.fields;
    const fields = {
      particles: { ...particles, title: "particles of (4) and (5)" },
      threshold: { ...threshold, title: "threshold of (5)" },
      occlusion: { ...occlusion, title: "frames behind the wall" },
      seed: { ...seed, title: "path" },
      frame: {
        low: 0,
        high: data.length - 1,
        step: 1,
        value: data.first + 8,
        own: true,
      },
      quantity: { options: QUANTITIES, value: QUANTITIES[0], own: true },
    };
    this.controls = new Controls(name, fields, (...moved) => this.follow(...moved));
    this.frame = new Canvas("", this.size[1] / this.size[0], (...pen) =>
      this.drawFrame(...pen),
    );
    const tall = HEAD + TALL * this.trackers.length + 40;
    this.rows = new Canvas("", 0, (...pen) => this.drawRows(...pen), tall);
    this.show(panel);
    this.hands();
    worker.onmessage = ({ data: answer }) => this.hear(answer);
    panel.addEventListener(GONE, () => worker.terminate());
  }

  show(panel) {
    this.said = el("p", { class: "mkt-note", role: "status" });
    this.cells = this.trackers.map(() =>
      COLUMNS.slice(1).map(() => el("td", {}, "...")),
    );
    const line = ({ label }, i) =>
      el("tr", {}, el("th", { scope: "row" }, label), ...this.cells[i]);
    const head = COLUMNS.map((title) => el("th", { scope: "col" }, title));
    const body = el("tbody", {}, ...this.trackers.map(line));
    const table = el("table", {}, el("thead", {}, el("tr", {}, ...head)), body);
    this.labels = [...body.rows].map((row) => row.firstChild);
    const scroll = el(
      "div",
      {
        class: "mkt-wide mkt-table",
        tabindex: 0,
        role: "region",
        "aria-label": "The errors of all trackers",
      },
      table,
    );
    this.player = new Player(
      this.said,
      () => this.on(),
      () => this.controls.set({}),
    );
    this.player.at(PACE);
    const acts = el("div", { class: "mkt-controls" }, this.player.node);
    const left = el("div", {}, this.frame.node, acts, this.said);
    this.stage = el(
      "div",
      { class: "mkt-stage mkt-film" },
      left,
      this.rows.node,
      scroll,
    );
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Play the run, drag along the curves or take the arrow keys to " +
        "see another frame: thick is run 0, whose boxes the frame " +
        "shows; black and white is the truth. In the table, medians " +
        "over five runs of a run's median error before the wall and " +
        "after it.",
    );
    const { node, note } = this.controls;
    takeOver(panel, node, note, this.stage, hint, this.controls.copies());
  }

  // A frame on, after the last one the first; whether there are more.
  on() {
    const frame = (this.controls.values.frame + 1) % this.length;
    this.controls.set({ frame }, true);
    return frame < this.length - 1;
  }

  // The frames

  follow(values, quick, asked) {
    if (asked) this.player.stop();
    const { seed, occlusion, particles, threshold } = values;
    const place = `${seed} ${occlusion}`;
    const pair = `${particles} ${threshold}`;
    // Runs of other settings are not those of the row any more.
    if (this.pair !== pair) for (const name of PAIR) delete this.latest[name];
    this.pair = pair;
    if (this.place !== place) {
      this.place = place;
      this.exposure.set(this.paths[seed], occlusion);
      this.truth = Array.from({ length: this.length }, (_, k) =>
        this.exposure.regionAt(k),
      );
      Object.assign(this, { photos: null, latest: {} });
      this.done.clear();
      clearTimeout(this.later);
      this.later = setTimeout(() => this.photograph([], place), quick ? PATIENCE : 0);
    }
    this.next();
    this.draw();
  }

  // A slice of frames after the other; then the worker has them all.
  photograph(photos, place) {
    const end = performance.now() + SLICE;
    while (photos.length < this.length && performance.now() < end)
      photos.push(this.exposure.photograph(photos.length));
    if (photos.length < this.length) {
      this.later = setTimeout(() => this.photograph(photos, place));
      return;
    }
    this.photos = photos;
    this.draw();
    this.worker.postMessage({
      kind: "scene",
      pictures: photos,
      region: this.truth[0],
      ticket: place,
    });
    this.next();
  }

  // The runs

  jobs() {
    const { particles: n, threshold } = this.controls.values;
    const runs = (job, key = job) =>
      Array.from({ length: this.runs }, (_, run) => ({
        job,
        run,
        key: `${key} ${run}`,
      }));
    const quick = [runs("ssd"), runs("pair", `pair ${n} ${threshold}`)];
    return [...quick, runs("pf-500"), runs("pf-1")].flat();
  }

  missing() {
    return this.jobs().filter(({ key }) => !this.done.has(key));
  }

  // One job at a time, so that what is asked last is not behind what is out of date.
  next() {
    if (!this.photos || this.asked) return;
    const [job] = this.missing();
    if (!job) return;
    const { particles: n, threshold } = this.controls.values;
    this.asked = { ...job, place: this.place };
    this.worker.postMessage({
      kind: "run",
      ...job,
      settings: { n, threshold },
      ticket: this.place,
    });
  }

  hear({ kind, ticket, tracks, words }) {
    if (kind === "trouble") {
      this.asked = null;
      this.said.textContent = words;
    }
    if (kind !== "run" || !this.asked) return;
    const { key } = this.asked;
    this.asked = null;
    // Of settings that have changed since, it is kept for when they come back.
    if (ticket === this.place) this.done.set(key, tracks);
    this.next();
    this.draw();
  }

  keep(tracks, run) {
    for (const [name, regions] of Object.entries(tracks)) {
      this.latest[name] ??= [];
      this.latest[name][run] = { regions, ...this.judged(regions) };
    }
  }

  // Median errors before the wall and after it, and whether the end is lost.
  judged(regions) {
    const seen = this.truth.map((region, k) => k && this.visible(k) > this.limits.seen);
    const off = regions.map((region, k) => errors(region, this.truth[k]));
    const between = (low, high, i) =>
      median(
        off.filter((_, k) => seen[k] && k >= low && k < high).map((each) => each[i]),
      );
    const parts = [
      [0, this.first],
      [this.first, this.length],
    ];
    const degrees = (value) => (value * 180) / Math.PI;
    const end = this.limits.last;
    const last = regions
      .slice(-end)
      .map((region, k) => overlap(region, this.truth.slice(-end)[k]));
    return {
      px: parts.map(([low, high]) => between(low, high, 0)),
      deg: parts.map(([low, high]) => degrees(between(low, high, 1))),
      lost: median(last) <= this.limits.hit,
    };
  }

  visible(k) {
    const { middle, width } = this.exposure.screen;
    return beside(this.truth[k], middle(k), width);
  }

  // What is shown

  draw() {
    // Runs of these settings that are known already stand there at once.
    for (const { key, run } of this.jobs())
      if (this.done.has(key)) this.keepIfOther(this.done.get(key), run);
    const { frame } = this.controls.values;
    const [all, left] = [this.jobs().length, this.missing().length];
    const done = left
      ? `${all - left} of ${all} runs done, (4) and (5) in one`
      : "All runs done";
    const state = this.photos ? done : "Painting the frames";
    setBusy(this.stage, !this.photos || left > 0);
    const hidden = 100 - Math.round(100 * this.visible(frame));
    this.said.textContent =
      `Frame ${frame} of ${this.length - 1}: the wall hides ` +
      `${hidden} % of the car. ${state}.`;
    this.fill();
    const { quantity } = this.controls.values;
    this.frame.node.setAttribute(
      "aria-label",
      `Frame ${frame} with the boxes of run 0 and the truth`,
    );
    this.rows.node.setAttribute(
      "aria-label",
      `${quantity} over the frames, a row for each tracker; the ` +
        "errors stand in the table below",
    );
    this.frame.redraw();
    this.rows.redraw();
  }

  keepIfOther(tracks, run) {
    const [name] = Object.keys(tracks).slice(-1);
    if (this.latest[name]?.[run]?.regions !== tracks[name]) this.keep(tracks, run);
  }

  labelOf({ name, label }) {
    const { particles } = this.controls.values;
    return PAIR.includes(name) ? label.replace("75", particles) : label;
  }

  fill() {
    this.trackers.forEach((tracker, i) => {
      const runs = Object.values(this.latest[tracker.name] ?? []);
      this.labels[i].textContent = this.labelOf(tracker);
      if (!runs.length)
        return this.cells[i].forEach((cell) => (cell.textContent = "..."));
      const of = (what, part, places) =>
        median(runs.map((run) => run[what][part])).toFixed(places);
      const lost = `${runs.filter((run) => run.lost).length} of ${runs.length}`;
      const words = [
        of("px", 0, 2),
        of("px", 1, 1),
        of("deg", 0, 1),
        of("deg", 1, 1),
        lost,
      ];
      words.forEach((word, k) => (this.cells[i][k].textContent = word));
    });
  }

  drawFrame(pen, width, height) {
    if (!this.truth) return;
    const { frame } = this.controls.values;
    const scale = width / this.size[0];
    const onto = ([x, y]) => [(x + 0.5) * scale, (y + 0.5) * scale];
    const ink = pen.strokeStyle;
    const photo = this.photos?.[frame];
    if (photo) this.exposure.pen.putImageData(photo, 0, 0);
    else this.exposure.paint(frame);
    pen.drawImage(this.exposure.scene, 0, 0, width, height);
    outlineTruth(pen, corners(this.truth[frame]).map(onto));
    for (const { name, color } of this.trackers) {
      const run = this.latest[name]?.[0];
      if (!run) continue;
      const box = corners(run.regions[frame]).map(onto);
      outline(pen, box, legible(pen, ink, color), 2.5); // as its curve
    }
  }

  boxOf(i, width) {
    return [38, HEAD + i * TALL + 18, width - 46, TALL - 26];
  }

  drawRows(pen, width) {
    if (!this.truth) return;
    const { frame, quantity, occlusion } = this.controls.values;
    const which = QUANTITIES.indexOf(quantity);
    const ink = pen.strokeStyle;
    const truth = this.curve(this.truth, which);
    const [right, bottom] = this.size;
    const limits =
      which === 2
        ? this.turns(truth)
        : [
            [0, right],
            [bottom, 0],
          ][which];
    pen.textAlign = "left";
    pen.fillText(quantity, 2, 13);
    return this.trackers.map((tracker, i) => {
      Object.assign(pen, { fillStyle: ink, strokeStyle: ink, lineWidth: 1 });
      const box = this.boxOf(i, width);
      const last = i === this.trackers.length - 1;
      const { across, down } = axes(pen, box, {
        x: [0, this.length - 1],
        y: limits,
        ylabel: this.labelOf(tracker),
        xlabel: last ? "frame" : "",
        bare: !last,
      });
      within(pen, box, () => {
        pen.globalAlpha = 0.25;
        pen.fillStyle = "#888";
        const from = across(this.first - 0.5);
        pen.fillRect(from, box[1], across(this.first + occlusion - 0.5) - from, box[3]);
        pen.globalAlpha = 1;
        const line = (values, color, thick) => {
          Object.assign(pen, { strokeStyle: color, lineWidth: thick });
          pen.beginPath();
          values.forEach((value, k) => pen.lineTo(across(k), down(value)));
          pen.stroke();
        };
        const color = legible(pen, ink, tracker.color);
        const runs = this.latest[tracker.name] ?? [];
        runs.forEach(({ regions }, run) =>
          line(this.curve(regions, which), color, run ? 1 : 3),
        );
        line(truth, ink, 1.2);
        pen.setLineDash([3, 3]);
        pen.lineWidth = 1;
        upright(pen, across(frame), box[1], box[1] + box[3]);
      });
      return [[across(frame)]];
    });
  }

  // What the curves of all runs reach, at least 60 degrees beside the truth.
  turns(truth) {
    const runs = this.trackers.flatMap(({ name }) => this.latest[name] ?? []);
    const angles = runs.flatMap(({ regions }) => this.curve(regions, 2));
    const low = Math.min(...truth) - 60;
    const high = Math.max(...truth) + 60;
    return [Math.min(low, ...angles), Math.max(high, ...angles)];
  }

  // Angles on the turn nearest the truth's.
  curve(regions, which) {
    if (which < 2) return regions.map((region) => region[which]);
    return regions.map(([, , theta], k) => {
      const turn = this.truth[k][2];
      const off = Math.atan2(Math.sin(theta - turn), Math.cos(theta - turn));
      return ((turn + off) * 180) / Math.PI;
    });
  }

  hands() {
    const to = ([u]) => {
      const [left, , width] = this.boxOf(0, this.rows.node.clientWidth);
      const frame = Math.round(((u - left) / width) * (this.length - 1));
      this.controls.set({ frame }, true);
    };
    this.rows.dragged(to, to, () => this.controls.set({}));
    const step = ([right]) =>
      this.controls.set({ frame: this.controls.values.frame + right });
    this.rows.keyed(step);
    this.frame.keyed(step);
  }
}

export async function wall(panel, name) {
  const [data, film, workshop] = await Promise.all(
    [name, "own.beats", "workshop"].map(load),
  );
  const [ground, car, bricks] = await Promise.all(
    [workshop.picture, film.car, data.bricks].map(bitmap),
  );
  const figure = new Wall(panel, name, data, { ground, car, bricks }, worker());
  figure.controls.show();
  if (!figure.controls.read()) figure.follow(figure.controls.values);
}
