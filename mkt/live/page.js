// What live figures share: controls whose values a link carries, crisp canvases, data.

import { host } from "./host.js";

const TEXT = 12; // [px]
const [REACH, FINGER] = [22, 28]; // [px] round what a hand means, and a finger
const SLIP = 10; // [px] of a finger that taps
export const SLICE = 12; // [ms] of work before the page may breathe

// An element with attributes, listeners ("onclick") and children; texts stay texts.
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

export const button = (title, onclick) =>
  el("button", { type: "button", onclick }, title);

// The pixels of a picture given as a data address.
export async function pixels(address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = el("canvas", {
    width: image.naturalWidth,
    height: image.naturalHeight,
  });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  pen.drawImage(image, 0, 0);
  return pen.getImageData(0, 0, canvas.width, canvas.height);
}

// The same as a picture that a canvas draws.
export const bitmap = async (address) => createImageBitmap(await pixels(address));

// Says in a panel what went wrong with its figure, whose picture stays.
export const complain =
  (panel) =>
  ({ message }) =>
    panel.prepend(el("p", { class: "mkt-note", role: "alert" }, message));

// What each element of a panel hears when the panel is gone for good, to end what runs
// on.
export const GONE = "mkt-gone";

export function leave(panel) {
  for (const node of [panel, ...panel.querySelectorAll("*")])
    node.dispatchEvent(new Event(GONE));
}

// Controls

let serial = 0;

const isWhole = ({ low, step }) => Number.isInteger(low) && Number.isInteger(step);

// The value next to one at which a control can stand: a whole number where its steps
// are whole, and one of these where a figure has data for them `only`.
function nearest(field, value) {
  const { options, low, high, step, only } = field;
  if (options) return value;
  const unit = only ? step : 1;
  const there = isWhole(field) ? low + unit * Math.round((value - low) / unit) : value;
  return Math.min(Math.max(there, low), high);
}

// A value as words give it, or an error that says what may stand there.
function understood(field, words) {
  const { options, low, high, step, only } = field;
  if (options) {
    if (options.includes(words)) return words;
    throw new Error(`must be one of ${options.join(", ")}`);
  }
  const value = Number(words);
  if (words.trim() !== "" && value === nearest(field, value)) return value;
  const kind = isWhole(field) ? "a whole number" : "a number";
  throw new Error(
    `must be ${kind} from ${low} to ` + `${high}${only ? ` in steps of ${step}` : ""}`,
  );
}

const BELOW = /_(\w+)|[^_]+/g; // what stands behind a "_" is a subscript

const places = ({ step }) => (step < 1 ? (step < 0.1 ? 2 : 1) : 0);

const shownAs = (field, value) =>
  field.options ? value : value.toFixed(places(field));

function inputOf(name, field, moved) {
  const id = `live-${name}-${++serial}`;
  const { options, low, high, step, value, title = name, words = title } = field;
  const pieces = [...title.matchAll(BELOW)].map(([all, below]) =>
    below ? el("sub", {}, below) : all,
  );
  const label = el("label", { for: id, title: words }, ...pieces);
  if (options) {
    const input = el("select", { id, onchange: () => moved(input.value) });
    input.append(...options.map((option) => el("option", { value: option }, option)));
    return { node: el("span", { class: "mkt-control" }, label, input), input };
  }
  const limits = { min: low, max: high, step, value };
  const input = el("input", { id, type: "range", ...limits });
  const typed = el("input", {
    type: "number",
    "aria-label": `${title}, as a number`,
    ...limits,
  });
  input.addEventListener("input", () => moved(Number(input.value), true));
  input.addEventListener("change", () => moved(Number(input.value)));
  const take = () => {
    const words = typed.value === "" ? input.value : typed.value;
    moved(Number(Number(words).toFixed(places(field))));
  };
  typed.addEventListener("change", take);
  // A wheel scrolls the page: browsers do not tell of its last number as a change.
  typed.addEventListener("wheel", () => typed.blur(), { passive: true });
  // JupyterLab keeps the change that Enter brings to itself.
  typed.addEventListener("keydown", ({ key }) => key === "Enter" && take());
  const node = el("span", { class: "mkt-control" }, label, input, typed);
  return { node, input, typed };
}

// Controls of a figure.  `fields` has {name: field}; a field with `own` is no parameter
// of the figure in Python, one with `only` has nothing between its steps.
// `changed(values, quick, asked)` follows every move; `asked` is one that a link or the
// reset button asks for.
export class Controls {
  constructor(figure, fields, changed) {
    Object.assign(this, { figure, fields, changed, inputs: {} });
    this.key = figure.slice(figure.lastIndexOf(".") + 1);
    const each = Object.entries(fields);
    this.start = Object.fromEntries(each.map(([name, { value }]) => [name, value]));
    this.values = { ...this.start };
    this.node = el("div", { class: "mkt-controls" });
    this.note = el("p", { class: "mkt-note", role: "status" });
    for (const [name, field] of each) {
      const moved = (value, quick) => this.set({ [name]: value }, quick);
      this.inputs[name] = inputOf(name, field, moved);
      this.node.append(this.inputs[name].node);
    }
    const reset = () => this.set(this.start, false, true);
    this.node.append(
      el("button", { type: "button", class: "mkt-reset", onclick: reset }, "reset"),
    );
    this.node.addEventListener(
      GONE,
      host.heard(() => this.read(true)),
    );
  }

  // Move some controls; `quick` while a hand is still moving them.
  set(values, quick = false, asked = false) {
    for (const [name, value] of Object.entries(values))
      this.values[name] = nearest(this.fields[name], value);
    this.note.textContent = ""; // a link or a command in it would be of what was shown
    this.show();
    this.follow(quick, asked);
    if (!quick) host.keep(this.key, this.settings(), this.values);
  }

  show() {
    for (const [name, { input, typed }] of Object.entries(this.inputs)) {
      const words = shownAs(this.fields[name], this.values[name]);
      input.value = this.values[name];
      if (!typed) continue;
      typed.value = words;
      input.setAttribute("aria-valuetext", words);
    }
  }

  moved(own) {
    return Object.entries(this.values).filter(
      ([name, value]) => value !== this.start[name] && (own || !this.fields[name].own),
    );
  }

  // What was moved, as a link carries it.
  settings() {
    const settings = this.moved(true).map(([name, value]) => {
      const words = shownAs(this.fields[name], value);
      return `${name}=${encodeURIComponent(words)}`;
    });
    return settings.join("&");
  }

  // Take over what is asked of this figure, and say what is wrong in it; `again` when
  // that may be what is shown already.
  read(again = false) {
    const words = host.asked(this.key, again);
    if (words === null) return false;
    const wrong = [];
    const values = { ...this.start };
    for (const [name, word] of new URLSearchParams(words))
      if (!Object.hasOwn(this.fields, name)) wrong.push(`there is no ${name}`);
      else
        try {
          values[name] = understood(this.fields[name], word);
        } catch (error) {
          wrong.push(`${name} is ${word || "empty"}, but ${error.message}`);
        }
    const there = Object.entries(values).every(
      ([name, value]) => this.values[name] === value,
    );
    if (again && there && !wrong.length) return false;
    this.note.textContent = wrong.length
      ? `In this page's address ${wrong.join("; ")}. The rest was taken.`
      : "";
    this.values = values;
    this.show();
    this.follow(false, true);
    return true;
  }

  // Have the figure follow, and say where it cannot.
  follow(quick, asked) {
    return new Promise((done) => done(this.changed(this.values, quick, asked))).catch(
      (error) => (this.note.textContent = `This cannot be drawn: ${error.message}.`),
    );
  }

  // The line that makes the same figure with Python.
  command() {
    const set = this.moved(false).map(
      ([name, value]) => ` --set ${name}=${shownAs(this.fields[name], value)}`,
    );
    return `python3 -m mkt figure ${this.figure} -o figure.pdf${set.join("")}`;
  }

  // What was moved that the command's figure does not have, in words.
  beyond() {
    const own = this.moved(true).filter(([name]) => this.fields[name].own);
    const titles = own.map(([name]) => this.fields[name].title ?? name);
    return titles.length ? ` draws a figure which has no ${titles.join(", ")}` : "";
  }

  // Buttons that copy the link, and the command where Python draws the figure too.
  copies(inPython = true) {
    const link = () => host.link(this.key, this.settings());
    const copied = async (words, remark = "") => {
      try {
        await navigator.clipboard.writeText(words);
        this.note.replaceChildren("Copied: ", el("code", {}, words), remark);
      } catch {
        // To be copied by hand.
        this.note.replaceChildren(el("code", {}, words), remark);
      }
    };
    const buttons = [];
    if (host.link)
      buttons.push(
        button("link to what is shown", () => copied(link())),
        " ",
      );
    const command = () => copied(this.command(), this.beyond());
    if (inPython) buttons.push(button("command for a PDF of it", command));
    return el("p", { class: "mkt-note mkt-files" }, "Copy: ", ...buttons);
  }
}

// Canvases

// A canvas's own pixels in one of the page: no fewer where a page is made smaller.
const sharpness = () => Math.max(devicePixelRatio, 1);

// A canvas as wide as its place and `ratio` as high, but not lower than `least` [px];
// it is drawn anew whenever that changes.  Where it is `dragged`, `draw` returns what a
// finger drags: the corners of each thing.
export class Canvas {
  constructor(label, ratio, draw, least = 0) {
    this.node = el("canvas", { role: "img", "aria-label": label, class: "mkt-canvas" });
    Object.assign(this, { ratio, draw, least, held: null });
    const again = () => this.redraw();
    const [size, theme] = [new ResizeObserver(again), new MutationObserver(again)];
    const media = ["(prefers-color-scheme: dark)", "print"].map((each) =>
      matchMedia(each),
    );
    size.observe(this.node);
    theme.observe(document.body, {
      attributeFilter: ["data-theme", "data-jp-theme-name"],
    });
    for (const each of media) each.addEventListener("change", again);
    // A page that goes to another screen has other pixels, and no other size.
    let screen;
    const watch = () => {
      screen = matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
      screen.addEventListener("change", sharpen, { once: true });
    };
    const sharpen = () => {
      watch();
      this.redraw();
    };
    watch();
    this.node.addEventListener(GONE, () => {
      size.disconnect();
      theme.disconnect();
      for (const each of media) each.removeEventListener("change", again);
      screen.removeEventListener("change", sharpen);
    });
  }

  redraw() {
    const width = this.node.clientWidth;
    if (!width) return;
    const height = Math.round(Math.max(width * this.ratio, this.least));
    const sharp = sharpness();
    const size = [Math.round(width * sharp), Math.round(height * sharp)];
    if (this.node.width !== size[0] || this.node.height !== size[1])
      [this.node.width, this.node.height] = size;
    this.node.style.aspectRatio = `${width} / ${height}`;
    const pen = this.node.getContext("2d");
    const { color, fontFamily } = getComputedStyle(this.node);
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    pen.clearRect(0, 0, width, height);
    Object.assign(pen, { fillStyle: color, strokeStyle: color, lineWidth: 1 });
    pen.font = `${TEXT}px ${fontFamily}`;
    this.things = this.draw(pen, width, height);
  }

  // The place of a pointer [px].
  placeOf({ clientX, clientY }) {
    const { left, top } = this.node.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }

  // Follow a mouse or a finger: places in the canvas's own pixels; `done` at the end.
  // A finger beside all things waits until it taps or goes aside, or the page scrolls.
  dragged(begin, follow, done) {
    this.node.classList.add("mkt-drag");
    // `held` is the pointer that drags: a second finger does nothing.
    const take = (event) => {
      this.waiting = null;
      const reach = touches(event) ? FINGER : REACH;
      if (begin(this.placeOf(event), reach) !== false) this.held = event.pointerId;
    };
    const decide = (event) => {
      const { waiting } = this;
      if (event.pointerId !== waiting?.pointerId) return;
      const [aside, along] = between(waiting, event);
      const taps = event.type === "pointerup" && aside + along < SLIP;
      if (taps || aside - along > SLIP) take(waiting);
    };
    const on = (name, hear) =>
      this.node.addEventListener(name, hear, { passive: false });
    on("pointerdown", (event) => {
      if (event.button || this.held !== null || this.waiting) return;
      const place = this.placeOf(event);
      const beside = this.things?.every((thing) => !holds(thing, place));
      if (beside && touches(event)) this.waiting = event;
      else take(event);
      if (this.held !== null) this.node.setPointerCapture(this.held);
    });
    // Comes after the one above: what a finger drags does not scroll the page.
    on("touchstart", (event) => this.held !== null && event.preventDefault());
    on("pointermove", (event) => {
      decide(event);
      if (event.pointerId === this.held) follow(this.placeOf(event));
    });
    on("pointerup", decide);
    on("lostpointercapture", ({ pointerId }) => {
      if (pointerId === this.waiting?.pointerId) this.waiting = null;
      if (pointerId !== this.held) return;
      this.held = null;
      done();
    });
  }

  // Follow a mouse over it, and the taps of a finger, which otherwise scrolls or drags;
  // null when nothing is meant: the mouse leaves, something is dragged, or Escape.
  hovered(over) {
    const on = (name, hear) => this.node.addEventListener(name, hear);
    let begun;
    const taps = (event) =>
      touches(event) && between(begun, event).every((way) => way < SLIP);
    on("pointerdown", (event) => (begun = event));
    on("pointermove", (event) => {
      if (this.held === null) touches(event) || over(this.placeOf(event));
      else taps(event) || over(null);
    });
    on("pointerup", (event) => taps(event) && over(this.placeOf(event), true));
    on("pointerleave", (event) => touches(event) || over(null));
    on("keydown", ({ key }) => key === "Escape" && over(null));
  }

  // Arrow keys: steps [right, down], with the event for its modifiers. A picture has no
  // keys to those who hear the page, an application does.
  keyed(step) {
    const ways = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, -1],
      ArrowDown: [0, 1],
    };
    Object.assign(this.node, { tabIndex: 0, role: "application" });
    this.node.addEventListener("keydown", (event) => {
      // With one of these it is a shortcut, such as Alt and left: back.
      if (!ways[event.key] || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      step(ways[event.key], event);
    });
  }
}

const touches = ({ pointerType }) => pointerType === "touch";

// How far a pointer has gone, aside and along the page [px].
const between = (from, to) =>
  ["clientX", "clientY"].map((axis) => Math.abs(to[axis] - from[axis]));

// Whether a finger means the thing of these corners: it is inside, or near one of them.
// One without y is an upright line.
function holds(corners, [u, v]) {
  const near = ([x, y = v]) => Math.hypot(x - u, y - v) < FINGER;
  const sides = corners.map(([x, y], i) => {
    const [left, top] = corners.at(i - 1);
    return Math.sign((x - left) * (v - y) - (y - top) * (u - x));
  });
  const inside = (sign) => sides.every((side) => side === sign);
  return corners.some(near) || inside(1) || inside(-1);
}

// What is drawn inside a box [left, top, width, height] alone.
export function within(pen, box, draw) {
  pen.save();
  pen.beginPath();
  pen.rect(...box);
  pen.clip();
  draw();
  pen.restore();
}

// Words at a place, aligned as the pen is.
// Returns their width.
export function write(pen, words, x, y) {
  const { font, textAlign } = pen;
  const small = font.replace(/[\d.]+px/, `${0.75 * TEXT}px`);
  const pieces = [...words.matchAll(BELOW)].map(([all, below]) => {
    pen.font = below ? small : font;
    const word = below ?? all;
    return {
      word,
      font: pen.font,
      drop: below ? 3 : 0,
      width: pen.measureText(word).width,
    };
  });
  const width = pieces.reduce((sum, piece) => sum + piece.width, 0);
  let left = x - ({ center: 0.5, right: 1 }[textAlign] ?? 0) * width;
  pen.textAlign = "left";
  for (const piece of pieces) {
    pen.font = piece.font;
    pen.fillText(piece.word, left, y + piece.drop);
    left += piece.width;
  }
  Object.assign(pen, { font, textAlign });
  return width;
}

// Red, green and blue of a colour; a pen gives it back as "#rrggbb".
function channels(pen, color) {
  pen.strokeStyle = color;
  return [1, 3, 5].map((at) => parseInt(pen.strokeStyle.slice(at, at + 2), 16));
}

const brightness = ([r, g, b]) => 0.3 * r + 0.59 * g + 0.11 * b; // from 0 to 255

// A colour of lines and letters; where it is too dark for a page by night, whose ink is
// bright, the brightest of its hue, which no other colour runs together with.
export function legible(pen, ink, color) {
  const { strokeStyle } = pen;
  const [bright, own] = [ink, color].map((each) => channels(pen, each));
  pen.strokeStyle = strokeStyle;
  if (brightness(bright) < 128 || brightness(own) > 90) return color;
  const most = Math.max(...own);
  if (most === 0) return ink;
  return `rgb(${own.map((each) => Math.round((255 * each) / most)).join(" ")})`;
}

// Round steps between two values, about so many, and two at the least.
function ticks(low, high, most) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const steps = [0.5, 1, 2, 3, 5, 10].map((k) => k * power);
  const count = (step) => Math.floor(high / step) - Math.ceil(low / step) + 1;
  const fit = steps.findIndex((each) => each >= rough);
  const step = count(steps[fit]) < 2 ? steps[fit - 1] : steps[fit];
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

export const number = (value, digits = 6) =>
  String(Number(value.toPrecision(digits))).replace("-", "\u2212");

// Axes round a box [left, top, width, height]: functions from values to its pixels.
// Bare ones have no numbers along x, where another box below has them.
export function axes(pen, [left, top, width, height], { x, y, xlabel, ylabel, bare }) {
  const across = (value) => left + ((value - x[0]) / (x[1] - x[0])) * width;
  const down = (value) => top + height - ((value - y[0]) / (y[1] - y[0])) * height;
  pen.strokeRect(left, top, width, height);
  pen.textAlign = "center";
  const rising = (ends) => [Math.min(...ends), Math.max(...ends)];
  for (const tick of bare ? [] : ticks(...rising(x), Math.max(width / 60, 2))) {
    const words = number(tick);
    const half = pen.measureText(words).width / 2;
    const middle = Math.min(across(tick), pen.canvas.clientWidth - half);
    pen.fillText(words, middle, top + height + TEXT + 3);
  }
  pen.textAlign = "right";
  for (const tick of ticks(...rising(y), Math.max(height / 40, 2)))
    pen.fillText(number(tick), left - 4, down(tick) + 4);
  pen.textAlign = "left";
  if (ylabel) write(pen, ylabel, left, top - 6);
  pen.textAlign = "right";
  if (xlabel) write(pen, xlabel, left + width, top + height + 2 * TEXT + 5);
  return { across, down };
}

// What follows draws things, and returns their corners for the finger.

// The outline of something with corners, light round dark so that it shows anywhere.
export function outline(pen, points, color, width = 2) {
  for (const [style, thick] of [
    ["#fff", width + 2],
    [color, width],
  ]) {
    pen.beginPath();
    points.forEach(([x, y]) => pen.lineTo(x, y));
    pen.closePath();
    Object.assign(pen, { strokeStyle: style, lineWidth: thick });
    pen.stroke();
  }
  return points;
}

// An upright line.
export function upright(pen, x, from, to) {
  pen.beginPath();
  pen.moveTo(x, from);
  pen.lineTo(x, to);
  pen.stroke();
  return [[x]];
}

// The outline of the truth: black with white dashes, as mkt.plotting.draw_truth has it.
export function outlineTruth(pen, points) {
  outline(pen, points, "#000", 2.5);
  pen.setLineDash([4, 4]);
  Object.assign(pen, { strokeStyle: "#fff", lineWidth: 1.2 });
  pen.stroke();
  pen.setLineDash([]);
}

// A dot with a dark rim, which shows on any ground.
export function dot(pen, x, y, radius, color, rim = "#0008", thick = 1) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 7);
  Object.assign(pen, { fillStyle: color, strokeStyle: rim, lineWidth: thick });
  pen.fill();
  pen.stroke();
  return [[x, y]];
}

// One with a light rim, which a hand moves.
export const knob = (pen, [x, y], radius, color) =>
  dot(pen, x, y, radius, color, "#fff", 2);

// All canvases of a panel as they stand, as one picture to be saved.
function save(panel) {
  const canvases = [...panel.querySelectorAll(".mkt-stage canvas")];
  const boxes = canvases.map((canvas) => canvas.getBoundingClientRect());
  const least = (side) => Math.min(...boxes.map((box) => box[side]));
  const [left, top] = [least("left"), least("top")];
  const places = boxes.map((box) =>
    [box.left - left, box.top - top].map((each) => Math.round(each * sharpness())),
  );
  const most = (axis, side) =>
    Math.max(...places.map((place, k) => place[axis] + canvases[k][side]));
  const whole = el("canvas", { width: most(0, "width"), height: most(1, "height") });
  const pen = whole.getContext("2d");
  pen.fillStyle = getComputedStyle(panel).backgroundColor;
  pen.fillRect(0, 0, whole.width, whole.height);
  canvases.forEach((canvas, k) => pen.drawImage(canvas, ...places[k]));
  el("a", { href: whole.toDataURL("image/png"), download: `${panel.id}.png` }).click();
}

// Put something live in the place of what was drawn beforehand.
export function takeOver(panel, ...nodes) {
  for (const old of panel.querySelectorAll(
    ":scope > .mkt-controls, :scope > .mkt-note:not(.mkt-files), " +
      ":scope > .mkt-shown",
  ))
    old.remove();
  const still = panel.querySelector(".mkt-save");
  const live = el("button", {
    type: "button",
    class: "mkt-save",
    onclick: () => save(panel),
  });
  live.textContent = still?.textContent ?? "picture of what is shown";
  still?.replaceWith(live);
  // The caption so far is that of the picture, for readers without JavaScript.
  const computed = panel.querySelector(":scope > template.mkt-computed");
  if (computed) panel.querySelector("figcaption").replaceChildren(computed.content);
  panel.prepend(...nodes);
  panel.classList.add("mkt-live");
}

// Whether more is to come on the stage of a panel, of which half is not to be saved.
export function setBusy(stage, busy) {
  stage.setAttribute("aria-busy", String(busy));
  const live = stage.parentElement?.querySelector(".mkt-save");
  if (live) live.disabled = busy;
}
