// Track something now: a camera, a video file or the book's clip, followed on the page.

import { load } from "./host.js";
import { COMBINED } from "./method/combined.js";
import { MOTION, restless, SCHEMES } from "./method/particles.js";
import { corners } from "./method/regions.js";
import { axes, button, Canvas, Controls, el, outline } from "./page.js";

const LARGEST = 320; // [px] a side of the picture that is tracked
const KEPT = 150; // frames of the curves
const LOWEST = 110; // [px] of a curve, on a narrow screen
const [BOX, FOUND, LOST] = ["#cf8200", "#00a751", "#cb1118"];
const REFUSED = {
  NotAllowedError: "The camera was refused",
  NotFoundError: "No camera was found",
  NotReadableError: "The camera is busy with another program",
};
const INSECURE =
  "Browsers give a camera only to pages that come by https or lie on this machine";
const LAYOUTS = {
  "nine tiles": { layout: "tiles", profile: "uniform" },
  "one kernel": { layout: "one" },
  "nine kernels": { layout: "3x3" },
};
const FIELDS = {
  tracker: { options: ["combination", "particle filter"], value: "combination" },
  particles: { low: 10, high: 500, step: 5, value: 75 },
  kernels: { options: Object.keys(LAYOUTS), value: "nine tiles" },
  noise: { low: 0.2, high: 4, step: 0.1, value: 1 },
  lambda: { low: 1, high: 60, step: 1, value: 20 },
  threshold: { low: 0, high: 1, step: 0.01, value: 0.6 },
  resampling: { options: Object.keys(SCHEMES), value: "multinomial" },
};
for (const field of Object.values(FIELDS)) field.own = true;

// The trackers' options as the controls stand.
function optionsOf({
  tracker,
  particles,
  kernels,
  noise,
  lambda,
  threshold,
  resampling,
}) {
  const filter = {
    ...COMBINED.filter,
    n: particles,
    kernels: LAYOUTS[kernels],
    lambda,
    motion: restless(MOTION, noise),
    scheme: resampling,
  };
  return { ...COMBINED, filter, threshold, refines: tracker === "combination" };
}

// Why a file cannot be played.
function whyNot({ name, size, type }) {
  if (!size) return `${name} is empty`;
  // Browsers tell of some videos no type.
  const other = type && !type.startsWith("video/");
  return other ? `${name} is no video` : `This browser cannot play ${name}`;
}

class Tracking {
  constructor(place, worker) {
    this.worker = worker;
    worker.onmessage = ({ data }) => this.hear(data);
    this.video = el("video", { muted: true, playsinline: true, loop: true });
    this.video.muted = true;
    this.picker = el("input", {
      type: "file",
      accept: "video/*",
      class: "mkt-hidden",
      tabindex: -1,
      "aria-label": "a video file",
      onchange: () => {
        const [file] = this.picker.files;
        this.picker.value = ""; // or the same file again would be no change
        this.open(file);
      },
    });
    this.controls = new Controls("own.track", FIELDS, () => {});
    this.stage = new Canvas("The picture: draw a box round something", 0.75, (...pen) =>
      this.draw(...pen),
    );
    this.stage.node.classList.add("mkt-wide");
    const curve = (title, value, color, top) =>
      new Canvas(
        `${title} of the last ${KEPT} frames`,
        0.45,
        (...pen) => this.drawCurve(title, value, color, top, ...pen),
        LOWEST,
      );
    this.curves = [
      curve("N_eff", "nEff", "#1e7dc1", () => this.controls.values.particles),
      curve("likeness exp(\u2212\u03bbd\u00b2)", "likelihood", FOUND, () => 1),
    ];
    this.said = el("p", { class: "mkt-note", role: "status" });
    this.numbers = el("p", { class: "mkt-note" });
    const sources = el(
      "div",
      { class: "mkt-controls mkt-sources" },
      button("Use the camera", () => this.camera()),
      button("Open a video", () => this.picker.click()),
      button("Play the book's clip", () => this.clip()),
      button("Stop", () => this.end()),
      this.picker,
    );
    this.begin = button("Track what is in the box", () => this.start());
    const again = button("Draw another box", () => this.small && this.anew());
    const acts = el("div", { class: "mkt-controls" }, this.begin, again);
    const curves = this.curves.map(({ node }) => node);
    const stage = el(
      "div",
      { class: "mkt-stage mkt-track" },
      this.stage.node,
      ...curves,
    );
    const { node, note } = this.controls;
    place.replaceChildren(
      sources,
      this.said,
      stage,
      el("p", { class: "mkt-note" }, `The curves show the last ${KEPT} frames.`),
      this.numbers,
      acts,
      node,
      note,
      this.controls.copies(false),
    );
    this.hands(place);
    this.sources = 0;
    this.controls.show();
    this.controls.read();
    this.end();
  }

  tell(words) {
    this.said.textContent = words;
  }

  // Sources

  // Only of what was chosen last: `sources` counts the choices.
  async camera() {
    const mine = ++this.sources;
    try {
      const asked = {
        width: { ideal: 640 },
        height: { ideal: 480 },
        facingMode: "environment",
      };
      if (!navigator.mediaDevices) throw new Error();
      const stream = await navigator.mediaDevices.getUserMedia({ video: asked });
      if (mine !== this.sources)
        return stream.getTracks().forEach((track) => track.stop());
      this.stop();
      this.video.srcObject = stream;
      await this.play();
    } catch (error) {
      if (mine !== this.sources) return;
      const unknown = isSecureContext ? "No camera can be used on this page" : INSECURE;
      await this.clip(REFUSED[error.name] ?? unknown);
    }
  }

  async open(file) {
    if (!file) return;
    const mine = ++this.sources;
    this.stop();
    this.video.src = URL.createObjectURL(file);
    try {
      await this.play();
    } catch {
      if (mine === this.sources) await this.clip(whyNot(file));
    }
  }

  // The book's, and why it is none of the reader's own.
  async clip(why = "") {
    const mine = ++this.sources;
    this.tell(`${why && `${why}. `}Loading the book's clip.`);
    try {
      await this.playClip(mine, why && `${why}; here is the book's clip instead. `);
    } catch ({ message }) {
      const words = `${why && `${why}. `}The book's clip cannot be shown: ${message}.`;
      if (mine === this.sources) this.tell(words);
    }
  }

  async playClip(mine, why) {
    const { film, region, source } = await load("track");
    if (mine !== this.sources) return;
    this.stop();
    const bytes = Uint8Array.from(atob(film.split(",")[1]), (sign) =>
      sign.charCodeAt(0),
    );
    this.video.src = URL.createObjectURL(new Blob([bytes], { type: "video/webm" }));
    await this.play();
    if (mine !== this.sources) return;
    this.box = region;
    this.tell(
      `${why}The clip: ${source}. A box is drawn already: track it, ` +
        "or draw another.",
    );
    this.stage.redraw();
  }

  // As it came: no camera, no picture.
  end() {
    this.sources++;
    this.stop();
    this.small = this.box = null;
    this.choose();
    this.stage.redraw();
    this.tell(
      "Choose what to look at. No picture leaves this machine: " +
        "nothing is sent, and nothing is kept.",
    );
  }

  stop() {
    this.video.pause();
    this.video.cancelVideoFrameCallback?.(this.waiting);
    clearTimeout(this.timer);
    this.video.srcObject?.getTracks().forEach((track) => track.stop());
    this.video.srcObject = null;
    if (this.video.src) URL.revokeObjectURL(this.video.src);
  }

  async play() {
    await this.video.play();
    const { videoWidth, videoHeight } = this.video;
    if (!videoWidth) throw new Error("nothing to see");
    const scale = Math.min(LARGEST / Math.max(videoWidth, videoHeight), 1);
    const size = {
      width: Math.max(Math.round(videoWidth * scale), 1),
      height: Math.max(Math.round(videoHeight * scale), 1),
    };
    this.small = el("canvas", size);
    this.pen = this.small.getContext("2d", { willReadFrequently: true });
    this.blank = true; // nothing can be learnt before its first picture
    this.stage.ratio = size.height / size.width;
    // Not higher than the screen, where a finger on it draws.
    this.stage.node.style.maxWidth = `${80 / this.stage.ratio}vh`;
    this.box = null;
    this.choose();
    this.next();
  }

  // One picture after the other; a worker that is busy leaves pictures out.
  next() {
    const { video } = this;
    const shown = () => {
      this.look();
      this.next();
    };
    if (video.requestVideoFrameCallback)
      this.waiting = video.requestVideoFrameCallback(shown);
    else this.timer = setTimeout(shown, 33);
  }

  look() {
    if (this.busy) return;
    const { width, height } = this.small;
    this.pen.drawImage(this.video, 0, 0, width, height);
    this.blank = false;
    if (!this.tracking) return this.stage.redraw();
    this.ask("step");
  }

  ask(kind) {
    const { width, height } = this.small;
    const { data } = this.pen.getImageData(0, 0, width, height);
    const options = optionsOf(this.controls.values);
    const message = { kind, picture: { data, width, height }, options };
    this.busy = true;
    this.worker.postMessage({ ...message, region: this.box, seed: 1 }, [data.buffer]);
  }

  // What the worker found

  start() {
    if (!this.small) return this.tell("First choose what to look at.");
    if (!this.box)
      return this.tell(
        "First draw a box round something: with the mouse, a finger, " +
          "or the arrow keys.",
      );
    if (this.busy || this.blank) return setTimeout(() => this.start(), 5);
    this.history = [];
    this.learning = true;
    this.ask("learn");
  }

  choose() {
    this.tracking = false;
    this.learning = false; // what is under way is of the old box
    this.found = null;
    this.history = [];
    this.numbers.textContent = "";
    this.stage.node.classList.toggle("mkt-drag", !!this.small);
    for (const canvas of this.curves) canvas.redraw();
    this.tell("Draw a box round something, then track it.");
  }

  anew() {
    this.box = null;
    this.choose();
    this.stage.redraw();
  }

  hear(answer) {
    this.busy = false;
    if (answer.kind === "trouble") {
      this.choose();
      return this.tell(`This cannot be tracked: ${answer.words}.`);
    }
    if (answer.kind === "learn") {
      if (!this.learning) return;
      this.tracking = true;
      this.times = [];
      return this.tell("Tracking. Move the sliders while it runs.");
    }
    if (!this.tracking) return;
    const { data, width, height } = answer.picture;
    this.pen.putImageData(new ImageData(data, width, height), 0, 0);
    this.found = answer;
    const likelihood = Math.exp(-this.controls.values.lambda * answer.distance ** 2);
    this.history = [...this.history, { ...answer, picture: null, likelihood }].slice(
      -KEPT,
    );
    this.times = [...this.times, performance.now()].slice(-31);
    this.report(answer, likelihood);
    for (const canvas of [this.stage, ...this.curves]) canvas.redraw();
  }

  report({ lost, distance, nEff, cost, steps }, likelihood) {
    const span = this.times.at(-1) - this.times[0];
    const rate = span ? Math.round((1000 * (this.times.length - 1)) / span) : 0;
    this.numbers.textContent =
      `${lost ? "LOST" : "found"} \u00b7 distance ${distance.toFixed(2)} \u00b7 ` +
      `likeness ${likelihood.toFixed(2)} \u00b7 N_eff ${nEff.toFixed(0)} \u00b7 ` +
      `${steps} Newton ${steps === 1 ? "step" : "steps"} \u00b7 ` +
      `${cost.toFixed(1)} ms for a frame \u00b7 ${rate} frames per second`;
  }

  draw(pen, width, height) {
    if (!this.small) {
      pen.textAlign = "center";
      pen.fillText("nothing to see yet", width / 2, height / 2);
      pen.strokeRect(0.5, 0.5, width - 1, height - 1);
      return;
    }
    const scale = width / this.small.width;
    pen.drawImage(this.small, 0, 0, width, height);
    const onto = ([x, y]) => [(x + 0.5) * scale, (y + 0.5) * scale];
    if (!this.found) {
      if (this.box) outline(pen, corners(this.box).map(onto), BOX, 3);
      return;
    }
    const { crowd, region, lost } = this.found;
    const most = crowd.reduce((top, w, i) => (i % 3 === 2 ? Math.max(top, w) : top), 0);
    pen.fillStyle = BOX;
    for (let i = 0; i < crowd.length; i += 3) {
      pen.globalAlpha = 0.25 + (0.75 * crowd[i + 2]) / most;
      pen.beginPath();
      pen.arc(...onto([crowd[i], crowd[i + 1]]), 2.5, 0, 7);
      pen.fill();
    }
    pen.globalAlpha = 1;
    outline(pen, corners(region).map(onto), lost ? LOST : FOUND, 3);
    if (!lost) return;
    Object.assign(pen, { fillStyle: LOST, textAlign: "left" });
    pen.fillRect(8, 8, 50, 22);
    pen.fillStyle = "#fff";
    pen.fillText("LOST", 16, 23);
  }

  drawCurve(title, value, color, top, pen, width, height) {
    const box = [38, 22, width - 46, height - 44];
    const { across, down } = axes(pen, box, {
      x: [-KEPT, 0],
      y: [0, top()],
      ylabel: title,
    });
    const last = this.history.length;
    pen.beginPath();
    this.history.forEach((each, i) =>
      pen.lineTo(across(i - last), down(Math.min(each[value], top()))),
    );
    Object.assign(pen, { strokeStyle: color, lineWidth: 2 });
    pen.stroke();
    pen.fillStyle = LOST;
    this.history.forEach(
      ({ lost }, i) => lost && pen.fillRect(across(i - last), box[1], 2, 5),
    );
  }

  // The box

  hands(place) {
    const toPixels = ([u, v]) => {
      const scale = this.small.width / this.stage.node.clientWidth;
      return [u * scale - 0.5, v * scale - 0.5];
    };
    let from = null;
    this.stage.dragged(
      (point) => {
        if (!this.small) return false;
        this.anew(); // a tap alone does not bring back the first one
        from = toPixels(point);
      },
      (point) => {
        const to = toPixels(point);
        const [hx, hy] = [0, 1].map((axis) => Math.abs(to[axis] - from[axis]) / 2);
        const [cx, cy] = [0, 1].map((axis) => (to[axis] + from[axis]) / 2);
        this.box = hx > 3 && hy > 3 ? [cx, cy, 0, hx, hy] : null;
        this.stage.redraw();
      },
      () => this.box && this.start(),
    );
    this.stage.keyed(([right, down], { shiftKey }) => {
      if (!this.small) return;
      const { width, height } = this.small;
      const [cx, cy, theta, hx, hy] = this.box ?? [
        width / 2,
        height / 2,
        0,
        width / 8,
        height / 8,
      ];
      if (this.tracking) this.choose();
      this.box = shiftKey
        ? [cx, cy, theta, Math.max(hx + right, 4), Math.max(hy + down, 4)]
        : [cx + 2 * right, cy + 2 * down, theta, hx, hy];
      this.stage.redraw();
    });
    this.stage.node.addEventListener(
      "keydown",
      ({ key }) => key === "Enter" && this.start(),
    );
    place.addEventListener("dragover", (event) => event.preventDefault());
    place.addEventListener("drop", (event) => {
      event.preventDefault();
      this.open(event.dataTransfer.files[0]);
    });
  }
}

export function camera(place, worker) {
  return new Tracking(place, worker);
}
