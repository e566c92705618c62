// Figures 3 and 4 of [T09], live: the distance over rotation and place, two surfaces
// side by side: of two layouts of kernels, or of a sharp frame and a blurred one.

import { grained } from "./grain.js";
import { load } from "./host.js";
import { colorBins } from "./method/colors.js";
import { distanceAt, learn } from "./method/histograms.js";
import { linspace } from "./method/numbers.js";
import { corners, displaced, warp } from "./method/regions.js";
import { blurred } from "./method/scenes.js";
import { SHOWN, still } from "./objects.js";
import {
  axes,
  Canvas,
  Controls,
  el,
  knob,
  legible,
  number,
  outline,
  pixels,
  SLICE,
  takeOver,
  within,
} from "./page.js";

const [CELLS, COARSE] = [61, 4]; // a side; while a hand moves, every fourth
const TURN = 60; // [deg]
const HIGH = 0.9; // where the colours of the distance end, but for larger ones
const BAR = 90; // [px] of the scale of colours
const EXTENT = 30; // [px] where no slider says it
const RED = "#cb1118";

// Figure 3: one kernel and several, in one frame.
const TWO_LAYOUTS = {
  colors: ["#cf8200", "#1e7dc1"],
  async fields({ fields }) {
    const span = { ...fields.span, step: 0.01 };
    const extent = { ...fields.extent, step: 1 };
    return { ...fields, span, extent };
  },
  pairs({ layout, span }, { region, images }) {
    const single = Math.min(span, 1);
    const specs = [
      { layout: "one", span: single, samples: 2400 },
      { layout, span: layout === "one" ? single : span, samples: 2400 },
    ];
    const titles = [
      "(a) one kernel",
      layout === "one" ? "(b) one kernel again" : `(b) ${layout} kernels`,
    ];
    return specs.map((spec, k) => ({
      target: learn(images[0], region, spec),
      image: images[1],
      title: titles[k],
      name: k ? layout : "one kernel",
    }));
  },
};

// Figure 4: the object standing still, and crossing while the shutter is open.
const TWO_FRAMES = {
  colors: ["#888", "#b60269"],
  async fields({ fields }) {
    this.ground = await pixels((await load("workshop")).picture);
    const exposure = { ...fields.exposure, step: 0.01 };
    const speed = { ...fields.speed, step: 1, title: "speed [px a frame]" };
    return { ...fields, exposure, speed };
  },
  async pairs({ layout, item, exposure, speed }, object) {
    const { region, images } = object;
    if (this.item !== item) {
      this.sprite = await pixels((await load(`sprite-${item}`)).picture);
      this.item = item;
    }
    const seen = blurred(this.ground, this.sprite, region, { exposure, speed });
    const { width, height } = seen;
    grained(seen.data, 1);
    object.picture = await createImageBitmap(new ImageData(seen.data, width, height));
    const target = learn(images[0], region, { layout });
    return [
      { target, image: images[1], title: "standing still", name: "the sharp frame" },
      { target, image: colorBins()(seen), title: "crossing", name: "the blurred one" },
    ];
  },
};

function stroke(pen, style, thick, lines) {
  Object.assign(pen, { strokeStyle: style, lineWidth: thick });
  pen.beginPath();
  for (const [x, y, right, below] of lines) {
    pen.moveTo(x, y);
    pen.lineTo(right, below);
  }
  pen.stroke();
}

// Two lines that cross at a place, with a rim that shows on any ground.
function cross(pen, u, v, color, long, slant) {
  const lines = [
    [u - long, v - slant, u + long, v + slant],
    [u - slant, v + long, u + slant, v - long],
  ];
  stroke(pen, color === RED ? "#fff" : "#000", 4, lines);
  stroke(pen, color, 2, lines);
  return [[u, v]];
}

class Surfaces {
  constructor(panel, name, { viridis }, kind, fields) {
    Object.assign(this, { viridis, kind, maps: [[], []] });
    const free = {
      ...fields,
      x: { low: -40, high: 40, step: 0.5, value: 0, own: true, title: "x [px]" },
      rotation: {
        low: -TURN,
        high: TURN,
        step: 1,
        value: 0,
        own: true,
        title: "rotation [deg]",
      },
    };
    this.controls = new Controls(name, free, () => this.follow());
    this.frame = new Canvas("", 0.9, (...pen) => this.drawFrame(...pen));
    this.canvases = [0, 1].map(
      (k) => new Canvas("", 1.12, (...pen) => this.drawMap(k, ...pen)),
    );
    this.cut = new Canvas("", 0.3, (...pen) => this.drawCut(...pen), 208);
    this.cut.node.classList.add("mkt-wide");
    this.hands();
    this.said = el("p", { class: "mkt-note", role: "status" });
    const hint = el(
      "p",
      { class: "mkt-note" },
      "Drag the box, its knob, or the red cross on a map; arrow keys move it, too.",
    );
    const three = [this.frame, ...this.canvases, this.cut].map(({ node }) => node);
    const stage = el("div", { class: "mkt-stage" }, ...three);
    const { node, note } = this.controls;
    takeOver(panel, node, note, stage, this.said, hint, this.controls.copies());
  }

  // What a change asks for: new data, new surfaces, or only another point.
  async follow() {
    const { x: _x, rotation: _turn, ...settings } = this.controls.values;
    const wanted = JSON.stringify(settings);
    if (wanted === this.made) return this.draw();
    this.made = wanted;
    const seen = await this.look(settings).catch((error) => error);
    if (this.made !== wanted) return;
    if (seen instanceof Error) {
      this.made = null; // to be tried again
      throw seen;
    }
    const { extent = EXTENT } = settings;
    Object.assign(this, seen, { extent });
    this.x = linspace(-extent, extent, CELLS);
    this.theta = linspace(-TURN, TURN, CELLS).map(
      (degrees) => (degrees * Math.PI) / 180,
    );
    clearTimeout(this.later);
    this.whole = false;
    this.fill(COARSE);
    this.draw();
    this.refine(wanted, 0);
  }

  // The object, under its name, and what its surfaces compare.
  async look(settings) {
    const { item, bins = "hsv" } = settings;
    const seen = `${item} ${bins}`;
    const data = this.seen === seen ? this.data : await still(item, bins);
    return { seen, data, pairs: await this.kind.pairs(settings, data) };
  }

  at(k, row, column) {
    const place = displaced(this.data.region, this.x[column], 0, this.theta[row]);
    return distanceAt(this.pairs[k].target, this.pairs[k].image, place);
  }

  // Every so-many-th cell, spread over its neighbours.
  fill(step) {
    this.maps = [0, 1].map((k) => {
      const map = new Float64Array(CELLS * CELLS);
      for (let row = 0; row < CELLS; row += step)
        for (let column = 0; column < CELLS; column += step) {
          const value = this.at(k, row, column);
          for (let i = row; i < Math.min(row + step, CELLS); i++)
            map.fill(
              value,
              i * CELLS + column,
              i * CELLS + Math.min(column + step, CELLS),
            );
        }
      return map;
    });
  }

  // The whole grid, row by row, a slice of time after the other.
  refine(wanted, from) {
    this.later = setTimeout(() => {
      const end = performance.now() + SLICE;
      let row = from;
      for (; row < CELLS && performance.now() < end; row++)
        for (let k = 0; k < 2; k++)
          for (let column = 0; column < CELLS; column++)
            this.maps[k][row * CELLS + column] = this.at(k, row, column);
      if (this.made !== wanted) return;
      if (row < CELLS) return this.refine(wanted, row);
      this.whole = true;
      this.draw();
    });
  }

  point() {
    const { x, rotation } = this.controls.values;
    return displaced(this.data.region, x, 0, (rotation * Math.PI) / 180);
  }

  // Whether the point is one of the maps'.
  onMaps() {
    return Math.abs(this.controls.values.x) <= this.extent;
  }

  draw() {
    if (!this.pairs) return;
    const { x, rotation } = this.controls.values;
    const at = ({ target, image }, turn) =>
      distanceAt(target, image, displaced(this.data.region, x, 0, turn));
    this.cuts = this.pairs.map((pair) => this.theta.map((turn) => at(pair, turn)));
    this.here = this.pairs.map((pair) => at(pair, (rotation * Math.PI) / 180));
    const words = this.here.map((d) => d.toFixed(3));
    const [one, other] = this.pairs.map(({ name }) => name);
    const place = `x = ${number(x, 3)} px, rotation = ${number(rotation, 3)} degrees`;
    this.said.textContent =
      `At ${place}${this.onMaps() ? "" : ", outside the maps"}: ` +
      `distance ${words[0]} for ${one}, ${words[1]} for ${other}.`;
    this.frame.node.setAttribute("aria-label", `The frame with the region at ${place}`);
    this.cut.node.setAttribute(
      "aria-label",
      "The distance along rotation at this x, for both",
    );
    for (const [k, canvas] of this.canvases.entries()) {
      const lowest = Math.min(...this.maps[k]).toFixed(2);
      canvas.node.setAttribute(
        "aria-label",
        `${this.pairs[k].title}: the distance over x and rotation, ` +
          `lowest ${lowest}, here ${words[k]}`,
      );
      canvas.redraw();
    }
    this.frame.redraw();
    this.cut.redraw();
  }

  drawFrame(pen, width, height) {
    if (!this.pairs) return;
    const [left, top, shown] = SHOWN;
    const scale = width / shown;
    pen.drawImage(this.data.picture, ...SHOWN, 0, 0, width, height);
    const onto = ([x, y]) => [(x + 0.5 - left) * scale, (y + 0.5 - top) * scale];
    outline(pen, corners(this.data.region).map(onto), "#333", 1);
    const region = this.point();
    const box = outline(pen, corners(region).map(onto), RED);
    this.knob = onto(warp(region, [1, 0]));
    return [box, knob(pen, this.knob, 7, RED)];
  }

  mapBox(width, height) {
    return [38, 42, width - 44, height - 82]; // the scale is above
  }

  // What the colours mean, from 0 to the highest value.
  drawScale(pen, left, high) {
    const label = "distance 0";
    pen.textAlign = "left";
    pen.fillText(label, left, 12);
    const from = Math.round(left + pen.measureText(label).width) + 5;
    const ink = pen.fillStyle;
    for (let x = 0; x < BAR; x++) {
      const color = this.viridis[Math.round((255 * x) / (BAR - 1))];
      pen.fillStyle = `rgb(${color.join(" ")})`;
      pen.fillRect(from + x, 3, 1, 9);
    }
    pen.fillStyle = ink;
    pen.fillText(number(high, 2), from + BAR + 6, 12);
  }

  drawMap(k, pen, width, height) {
    const map = this.maps[k];
    if (!map.length || !this.pairs) return;
    const [left, top, w, h] = this.mapBox(width, height);
    const small = el("canvas", { width: CELLS, height: CELLS });
    const cells = new ImageData(CELLS, CELLS);
    const high = Math.max(HIGH, ...this.maps.flatMap((each) => [...each]));
    for (let i = 0; i < map.length; i++) {
      const row = CELLS - 1 - Math.floor(i / CELLS);
      const color = this.viridis[Math.round((map[i] / high) * 255)];
      cells.data.set([...color, 255], 4 * (row * CELLS + (i % CELLS)));
    }
    this.drawScale(pen, left, high);
    small.getContext("2d").putImageData(cells, 0, 0);
    pen.imageSmoothingEnabled = this.whole;
    // The middles of the outer cells lie on the edges of the box.
    const [dw, dh] = [w / (CELLS - 1), h / (CELLS - 1)];
    within(pen, [left, top, w, h], () =>
      pen.drawImage(small, left - dw / 2, top - dh / 2, w + dw, h + dh),
    );
    const { extent } = this;
    const { x, rotation } = this.controls.values;
    const limits = {
      x: [-extent, extent],
      y: [-TURN, TURN],
      xlabel: "x [px]",
      ylabel: `${this.pairs[k].title}, rotation [deg]`,
    };
    const { across, down } = axes(pen, [left, top, w, h], limits);
    // The truth, where dotted lines meet, and the lowest point.
    pen.setLineDash([1, 3]);
    stroke(pen, "#fff", 1, [
      [left, down(0), left + w, down(0)],
      [across(0), top, across(0), top + h],
    ]);
    pen.setLineDash([]);
    const at = map.indexOf(Math.min(...map));
    const turn = (this.theta[Math.floor(at / CELLS)] * 180) / Math.PI;
    if (this.whole) cross(pen, across(this.x[at % CELLS]), down(turn), "#fff", 6, 6);
    return this.onMaps() ? [cross(pen, across(x), down(rotation), RED, 8, 0)] : [];
  }

  drawCut(pen, width, height) {
    if (!this.cuts) return;
    const box = [38, 40, width - 50, height - 80]; // the legend is above
    const { x, rotation } = this.controls.values;
    const limits = {
      x: [-TURN, TURN],
      y: [0, 1],
      xlabel: "rotation [deg]",
      ylabel: `distance at x = ${number(x, 3)} px`,
    };
    const { across, down } = axes(pen, box, limits);
    const ink = pen.fillStyle;
    this.cuts.forEach((cut, k) => {
      const color = legible(pen, ink, this.kind.colors[k]);
      pen.beginPath();
      cut.forEach((d, row) =>
        pen.lineTo(across((this.theta[row] * 180) / Math.PI), down(d)),
      );
      Object.assign(pen, { strokeStyle: color, lineWidth: 2.5, fillStyle: color });
      pen.setLineDash(k ? [] : [6, 4]);
      pen.stroke();
      pen.setLineDash([]);
      pen.fillRect(across(-TURN) + 130 * k, 10, 16, 3);
      Object.assign(pen, { fillStyle: ink, textAlign: "left" });
      pen.fillText(this.pairs[k].title, across(-TURN) + 21 + 130 * k, 16);
      pen.beginPath();
      pen.arc(across(rotation), down(this.here[k]), 4, 0, 7);
      pen.fillStyle = legible(pen, ink, RED);
      pen.fill();
    });
  }

  hands() {
    const set = (x, rotation, quick) => this.controls.set({ x, rotation }, quick);
    const settle = () => this.controls.set({});
    const places = { begin: [0, 0], turning: false };
    this.frame.dragged(
      ([u, v], reach) => {
        const { x, rotation } = this.controls.values;
        const [ku, kv] = this.knob;
        places.turning = Math.hypot(u - ku, v - kv) < reach;
        places.begin = [u, x, rotation];
      },
      ([u, v]) => {
        const [left, top, shown] = SHOWN;
        const scale = this.frame.node.clientWidth / shown;
        const [begin, x, rotation] = places.begin;
        if (!places.turning) return set(x + (u - begin) / scale, rotation, true);
        const [cx, cy] = this.point();
        const turn = Math.atan2(
          v / scale + top - 0.5 - cy,
          u / scale + left - 0.5 - cx,
        );
        set(x, Math.round((turn * 180) / Math.PI), true);
      },
      settle,
    );
    const step = ([right, down]) => {
      const { x, rotation } = this.controls.values;
      set(x + right, rotation + 2 * down);
    };
    this.frame.keyed(step);
    for (const canvas of this.canvases) {
      const to = ([u, v]) => {
        const { clientWidth, clientHeight } = canvas.node;
        const [left, top, w, h] = this.mapBox(clientWidth, clientHeight);
        const { extent } = this;
        const x = Math.min(Math.max((2 * (u - left)) / w - 1, -1), 1) * extent;
        set(Math.round(2 * x) / 2, Math.round(TURN - (2 * TURN * (v - top)) / h), true);
      };
      canvas.dragged(to, to, settle);
      canvas.keyed(([right, down]) => step([right, -down]));
    }
  }
}

const begin = (kind) => async (panel, name) => {
  const data = await load(name);
  const figure = new Surfaces(panel, name, data, kind, await kind.fields(data));
  figure.controls.show();
  if (!figure.controls.read()) await figure.controls.follow();
};

export const surfaces = begin(TWO_LAYOUTS);
export const blur = begin(TWO_FRAMES);
