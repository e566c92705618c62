// own.beats, live: the particle filter as a film of four beats, and a wall to move.

import { resized } from "./crowd.js";
import { grained } from "./grain.js";
import { load } from "./host.js";
import { colorBins } from "./method/colors.js";
import { overlap } from "./method/evaluation.js";
import { coefficients, logLikelihood } from "./method/histograms.js";
import { linspace } from "./method/numbers.js";
import { FILTER, filterInit, filterStep } from "./method/particle_filter.js";
import { MOTION, restless } from "./method/particles.js";
import { random } from "./method/random.js";
import { corners, displaced, warp } from "./method/regions.js";
import {
  axes,
  bitmap,
  button,
  Canvas,
  Controls,
  dot,
  el,
  outline,
  outlineTruth,
  SLICE,
  takeOver,
  upright,
  within,
} from "./page.js";
import { Player } from "./player.js";

const BEATS = ["1 predict", "2 weigh", "3 estimate", "4 draw"];
// What the sticks are as high as.
const WEIGHTS = "weights over the largest one";
const STICKS = ["none weighs more yet", WEIGHTS, WEIGHTS, "offspring over the most"];
const WORDS = [
  () => "every particle moves on, by its velocity and by chance",
  () => "every particle weighs as much as its place looks like the car",
  () => "the weighted mean is the answer",
  ({ ancestors }) =>
    "the heavy are copied, the light are left out: " +
    `${new Set(ancestors).size} of ${ancestors.length} live on`,
];
const [REACH, PLACES] = [40, 81]; // [px] of the likelihood along x, and its places
const CLOSE = 34; // [px] round the crowd that are shown: no car is cut
const [CROWD, GREEN, BLUE] = ["#cf8200", "#00a751", "#1e7dc1"];
const [GREY, DEAD] = ["#888", "#555"];

function stick(pen, x, from, to, color) {
  Object.assign(pen, { strokeStyle: color, lineWidth: 2 });
  return upright(pen, x, from, to);
}

class Beats {
  constructor(panel, name, data, pictures) {
    Object.assign(this, data, pictures, { rounds: [], bins: colorBins() });
    const [width, height] = this.size;
    this.scene = el("canvas", { width, height });
    this.pen = this.scene.getContext("2d", { willReadFrequently: true });
    const { frame, n, noise, lam, scheme, wall } = data.fields;
    const fields = {
      frame,
      beat: { options: BEATS, value: BEATS[3], own: true },
      n,
      noise,
      lam,
      scheme,
      wall,
      pace: {
        low: 0.5,
        high: 20,
        step: 0.5,
        value: 4,
        own: true,
        title: "beats per second",
      },
    };
    this.controls = new Controls(name, fields, (_values, _quick, asked) =>
      this.follow(asked),
    );
    this.frame = new Canvas("", height / width, (...pen) => this.drawFrame(...pen));
    this.line = new Canvas("", 0.35, (...pen) => this.drawLine(...pen), 150);
    this.course = new Canvas("", 0.62, (...pen) => this.drawCourse(...pen), 190);
    this.show(panel);
    this.hands();
  }

  show(panel) {
    const by = (beats) => () => {
      this.player.stop();
      this.turn(beats);
    };
    const [back, on] = [button("one beat back", by(-1)), button("next beat", by(1))];
    this.said = el("p", { class: "mkt-note", role: "status" });
    this.player = new Player(
      this.said,
      () => this.turn(1, true),
      () => this.controls.set({}),
    );
    const acts = el("div", { class: "mkt-controls" }, this.player.node, back, on);
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the wall into the picture, or push it with the arrow " +
        "keys. What you change holds from this frame on, and where a link " +
        "is opened, from frame 1: the chance of each frame stays the same.",
    );
    const left = el("div", {}, this.frame.node, this.line.node);
    const right = el("div", {}, this.said, this.course.node);
    const stage = el("div", { class: "mkt-stage mkt-film" }, left, right);
    const { node, note } = this.controls;
    takeOver(panel, node, note, acts, stage, hint, this.controls.copies());
  }

  // The run

  // Keep what was before the change; a link or the reset button begins anew.
  follow(asked) {
    if (asked) this.player.stop();
    const { frame, beat, pace, ...settings } = this.controls.values;
    const known = JSON.stringify(settings);
    if (asked || this.known !== known)
      this.rounds.length = asked || !this.shown ? 0 : Math.min(this.shown, frame);
    this.known = known;
    this.player.at(pace);
    this.reach(frame);
  }

  // Compute what is missing, a slice of time after the other, and show the frame.
  reach(frame) {
    clearTimeout(this.later);
    const end = performance.now() + SLICE;
    while (this.rounds.length <= frame && performance.now() < end) this.advance();
    this.shown = Math.min(frame, this.rounds.length - 1);
    if (this.shown) this.draw();
    if (this.shown < frame) this.later = setTimeout(() => this.reach(frame));
  }

  advance() {
    const { n, noise, lam, scheme, wall } = this.controls.values;
    const options = {
      ...FILTER,
      n,
      lambda: lam,
      scheme,
      motion: restless(MOTION, noise),
    };
    const k = this.rounds.length;
    const rng = random(1000 + k);
    if (!k) {
      const image = this.bins(this.photograph(0, this.fields.wall.value));
      const next = filterInit(options, image, this.truth[0], rng);
      return this.rounds.push({ next });
    }
    const image = this.bins(this.photograph(k, wall));
    const last = resized(this.rounds[k - 1].next, n);
    const [next, found] = filterStep(options, last, image, rng);
    const iou = overlap(found.region, this.truth[k]);
    const before = last.particles.regions;
    this.rounds.push({ ...found, next, image, before, wall, lam, iou });
  }

  // What the sensor sees of a frame.
  photograph(k, wall) {
    this.paint(k, wall);
    const [width, height] = this.size;
    const picture = this.pen.getImageData(0, 0, width, height);
    grained(picture.data, k);
    return picture;
  }

  paint(k, wall) {
    const { pen, bricks } = this;
    const [cx, cy, theta, hx, hy] = this.truth[k];
    const [c, s] = [Math.cos(theta), Math.sin(theta)];
    pen.drawImage(this.ground, 0, 0);
    pen.setTransform(c, s, -s, c, cx + 0.5, cy + 0.5);
    pen.drawImage(this.car, -hx, -hy, 2 * hx, 2 * hy);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    for (let y = 0; y < this.size[1]; y += bricks.height)
      pen.drawImage(bricks, wall + 0.5 - bricks.width / 2, y);
  }

  // The film

  // So many beats on, where the film has them; whether more follow.
  turn(step, quick = false) {
    const { frame, beat } = this.controls.values;
    const at = 4 * (frame - 1) + BEATS.indexOf(beat) + step;
    const length = 4 * this.fields.frame.high;
    // What plays begins anew at its end.
    const to = quick ? at % length : at;
    if (to < 0 || to >= length) return;
    this.controls.set({ frame: 1 + Math.floor(to / 4), beat: BEATS[to % 4] }, quick);
    return to < length - 1;
  }

  // The pictures

  draw() {
    const round = this.rounds[this.shown];
    const beat = BEATS.indexOf(this.controls.values.beat);
    const { nEff, distance, iou, weights } = round;
    const place = `Frame ${this.shown} of ${this.truth.length - 1}`;
    this.said.textContent =
      `${place}, ${BEATS[beat]}: ${WORDS[beat](round)}. N_eff ` +
      `${nEff.toFixed(1)} of ${weights.length}, distance ` +
      `${distance.toFixed(2)}, overlap with the truth ` +
      `${iou.toFixed(2)}.`;
    const about = {
      frame:
        `${place} with the particles, ${BEATS[beat]}; the wall is at x ` +
        `= ${round.wall} px`,
      line: `The particles along x: ${STICKS[beat]}, and the likelihood`,
      course: "N_eff, distance and overlap over the frames so far",
    };
    for (const [name, words] of Object.entries(about)) {
      this[name].node.setAttribute("aria-label", words);
      this[name].redraw();
    }
  }

  // How large each particle is drawn, from 0 to 1, and whether it lives on.
  sizes({ weights, ancestors }, beat) {
    if (beat === 0) return weights.map(() => 0.08);
    let values = weights;
    if (beat === 3) {
      values = weights.map(() => 0);
      for (const i of ancestors) values[i]++;
    }
    const most = Math.max(...values);
    return values.map((value) => value / most);
  }

  // The part [left, top, width, height] of the frame with the crowd, and its scale.
  part({ before, particles }, width) {
    const there = [...before, ...particles, this.truth[this.shown]];
    const ends = this.size.map((_, axis) => {
      const along = there.map((region) => region[axis]);
      return [Math.min(...along) - CLOSE, Math.max(...along) + CLOSE];
    });
    const shares = ends.map(([low, high], axis) => (high - low) / this.size[axis]);
    const share = Math.min(Math.max(...shares), 1);
    const sides = this.size.map((side) => share * side);
    const from = ends.map(([low, high], axis) => {
      const first = (low + high - sides[axis]) / 2;
      return Math.min(Math.max(first, 0), this.size[axis] - sides[axis]);
    });
    return { part: [...from, ...sides], scale: width / sides[0] };
  }

  drawFrame(pen, width, height) {
    const round = this.rounds[this.shown];
    if (!round?.region) return;
    const { part, scale } = this.part(round, width);
    const onto = ([x, y]) =>
      [x + 0.5 - part[0], y + 0.5 - part[1]].map((u) => u * scale);
    this.paint(this.shown, round.wall);
    pen.fillStyle = "#fff"; // pale, by night too: particles are seen on it
    pen.fillRect(0, 0, width, height);
    pen.globalAlpha = 0.5;
    pen.drawImage(this.scene, ...part, 0, 0, width, height);
    pen.globalAlpha = 1;
    const beat = BEATS.indexOf(this.controls.values.beat);
    const sizes = this.sizes(round, beat);
    const places = round.particles.map(onto);
    this.drawDead(
      pen,
      places.filter((_, i) => !sizes[i]),
    );
    places.forEach(
      ([x, y], i) =>
        sizes[i] && dot(pen, x, y, 1.5 + 5 * Math.sqrt(sizes[i]), CROWD, "#000", 0.6),
    );
    if (beat === 0) this.drawWays(pen, round, onto);
    if (beat === 2) this.drawEstimate(pen, round, onto);
    return [corners([round.wall, 0, 0, this.bricks.width / 2, this.size[1]]).map(onto)];
  }

  // Crosses where none lives on, below those that do.
  drawDead(pen, places) {
    pen.beginPath();
    for (const [x, y] of places)
      for (const way of [3, -3]) {
        pen.moveTo(x - 3, y - way);
        pen.lineTo(x + 3, y + way);
      }
    Object.assign(pen, { strokeStyle: DEAD, lineWidth: 1 });
    pen.stroke();
  }

  drawEstimate(pen, { region }, onto) {
    outlineTruth(pen, corners(this.truth[this.shown]).map(onto));
    outline(pen, corners(region).map(onto), GREEN, 3);
    pen.beginPath();
    for (const end of [region, warp(region, [1, 0])]) pen.lineTo(...onto(end));
    pen.stroke();
  }

  // From where each particle came; over the dots, or they would hide it.
  drawWays(pen, { before, particles }, onto) {
    Object.assign(pen, { strokeStyle: "#000", lineWidth: 0.8 });
    pen.beginPath();
    before.forEach((region, i) => {
      pen.moveTo(...onto(region));
      pen.lineTo(...onto(particles[i]));
    });
    pen.stroke();
    for (const region of before) dot(pen, ...onto(region), 2, GREY);
  }

  // Along x: sticks, and the likelihood.
  drawLine(pen, width, height) {
    const round = this.rounds[this.shown];
    if (!round?.region) return;
    const beat = BEATS.indexOf(this.controls.values.beat);
    const middle = Math.round(round.region[0]);
    const box = [30, 22, width - 38, height - 62];
    const limits = {
      x: [middle - REACH, middle + REACH],
      y: [0, 1.1],
      xlabel: "x [px]",
      ylabel: STICKS[beat] + (beat ? "; likelihood (grey)" : ""),
    };
    const { across, down } = axes(pen, box, limits);
    within(pen, box, () => {
      const ink = pen.strokeStyle;
      if (beat) this.drawLikelihood(pen, round, across, down);
      const sizes = this.sizes(round, beat === 2 ? 1 : beat);
      round.particles.forEach(([x], i) => {
        const top = down(beat ? sizes[i] : 0.05);
        stick(pen, across(x), down(0), top, CROWD);
        if (sizes[i] > 0) dot(pen, across(x), top, 2.5, CROWD);
      });
      pen.setLineDash([5, 4]);
      stick(pen, across(this.truth[this.shown][0]), down(0), down(1.1), ink);
      pen.setLineDash([]);
      if (beat === 2) stick(pen, across(round.region[0]), down(0), down(1.1), GREEN);
    });
  }

  drawLikelihood(pen, round, across, down) {
    const { target } = round.next;
    round.curve ??= linspace(-REACH, REACH, PLACES).map((dx) => {
      const place = displaced(round.region, dx, 0, 0);
      return [
        place[0],
        logLikelihood(coefficients(target, round.image, place), round.lam),
      ];
    });
    const top = Math.max(...round.curve.map(([, value]) => value));
    pen.beginPath();
    for (const [x, value] of round.curve)
      pen.lineTo(across(x), down(Math.exp(value - top)));
    Object.assign(pen, { strokeStyle: GREY, lineWidth: 1.5 });
    pen.stroke();
  }

  courseBox(width, height) {
    return [38, 40, width - 46, height - 80];
  }

  drawCourse(pen, width, height) {
    if (!this.shown) return;
    const box = this.courseBox(width, height);
    const { across, down } = axes(pen, box, {
      x: [1, this.fields.frame.high],
      y: [0, 1],
      xlabel: "frame",
    });
    const curves = {
      "N_eff / N": [BLUE, [], ({ nEff, weights }) => nEff / weights.length],
      distance: [CROWD, [6, 4], ({ distance }) => distance],
      overlap: [GREEN, [2, 3], ({ iou }) => iou],
    };
    const ink = pen.fillStyle;
    let left = box[0];
    for (const [name, [color, dashes, of]] of Object.entries(curves)) {
      Object.assign(pen, { strokeStyle: color, lineWidth: 2, fillStyle: ink });
      pen.setLineDash(dashes);
      pen.beginPath();
      [left, left + 22].forEach((x) => pen.lineTo(x, 16));
      pen.stroke();
      pen.textAlign = "left";
      pen.fillText(name, left + 27, 20);
      left += 40 + pen.measureText(name).width;
      pen.beginPath();
      this.rounds.forEach((round, k) => k && pen.lineTo(across(k), down(of(round))));
      pen.stroke();
    }
    pen.setLineDash([]);
    return [stick(pen, across(this.shown), down(0), down(1), ink)];
  }

  // Hands

  hands() {
    const settle = () => this.controls.set({});
    let grip = 0;
    // Where along the frame a place on the canvas lies.
    const along = (u) => {
      const round = this.rounds[this.shown];
      const { part, scale } = this.part(round, this.frame.node.clientWidth);
      return part[0] + u / scale;
    };
    this.frame.dragged(
      ([u]) => {
        const { wall } = this.controls.values;
        // A wall out of sight comes to the hand.
        const near = Math.abs(along(u) - wall) < this.bricks.width / 2;
        grip = near ? wall - along(u) : 0;
        if (!near) this.controls.set({ wall: Math.round(along(u)) }, true);
      },
      ([u]) => this.controls.set({ wall: Math.round(along(u) + grip) }, true),
      settle,
    );
    this.frame.keyed(([right]) => {
      const { wall } = this.controls.values;
      this.controls.set({ wall: wall + 5 * right });
    });
    const to = ([u]) => {
      const [left, , width] = this.courseBox(this.course.node.clientWidth, 0);
      const { low, high } = this.fields.frame;
      const frame = Math.round(low + ((u - left) / width) * (high - low));
      this.controls.set({ frame }, true);
    };
    this.course.dragged(to, to, settle);
    this.course.keyed(([right]) => {
      const { frame } = this.controls.values;
      this.controls.set({ frame: frame + right });
    });
  }
}

export async function beats(panel, name) {
  const [data, workshop] = await Promise.all([name, "workshop"].map(load));
  const [ground, car, bricks] = await Promise.all(
    [workshop.picture, data.car, data.bricks].map(bitmap),
  );
  const figure = new Beats(panel, name, data, { ground, car, bricks });
  figure.controls.show();
  if (!figure.controls.read()) figure.follow(true);
}
