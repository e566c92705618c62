// The frames of figures 6 and 7 of [T09], painted: the car on its path, the screen
// before it, and the shutter open for a share of the frame, as mkt.scenes.rendering has
// them.

import { linspace } from "./method/numbers.js";
import { corners } from "./method/regions.js";
import { MAX_SUBFRAMES, screen } from "./method/scenes.js";
import { el } from "./page.js";

export class Exposure {
  constructor({ size: [width, height], shutter, first, times, halves }, pictures) {
    Object.assign(this, { shutter, first, times, halves, pictures, width, height });
    this.scene = el("canvas", { width, height });
    this.pen = this.scene.getContext("2d", { willReadFrequently: true });
  }

  // The path of one seed [x, y, theta] at `times`, and the frames that the screen
  // hides.
  set(path, frames) {
    this.path = path;
    const { shutter, first } = this;
    this.screen = screen((t) => this.regionAt(t), { shutter, first, frames });
  }

  regionAt(t) {
    const [start, step] = this.times;
    const at = Math.min(Math.max((t - start) / step, 0), this.path.length - 1);
    const [k, share] = [Math.floor(at), at % 1];
    const [one, next] = [
      this.path[k],
      this.path[Math.min(k + 1, this.path.length - 1)],
    ];
    return [
      ...one.map((value, i) => value + share * (next[i] - value)),
      ...this.halves,
    ];
  }

  // So many that nothing jumps by more than a pixel.
  instants(k) {
    const ends = this.ends(k);
    const [from, to] = ends.map((t) => corners(this.regionAt(t)).flat());
    const [left, right] = ends.map((t) => this.screen.middle(t)[0]);
    const jumps = from.map((value, i) => Math.abs(value - to[i]));
    const most = Math.max(...jumps, this.inSight(k) ? Math.abs(right - left) : 0);
    const n = Math.min(Math.max(Math.ceil(most), 1), MAX_SUBFRAMES);
    const half = (this.shutter * (1 - 1 / n)) / 2;
    return linspace(k - half, k + half, n);
  }

  ends(k) {
    return [k - this.shutter / 2, k + this.shutter / 2];
  }

  inSight(k) {
    const reach = (this.width + this.screen.width) / 2;
    return this.ends(k).some(
      (t) => Math.abs(this.screen.middle(t)[0] - this.width / 2) < reach,
    );
  }

  // The part of the picture that moves while the shutter is open, as left, top, width,
  // height; all of it while the screen is in sight.
  moving(k) {
    if (this.inSight(k)) return [0, 0, this.width, this.height];
    const points = this.ends(k).flatMap((t) => corners(this.regionAt(t)));
    const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
    const left = Math.max(Math.floor(Math.min(...xs)) - 2, 0);
    const top = Math.max(Math.floor(Math.min(...ys)) - 2, 0);
    const right = Math.min(Math.ceil(Math.max(...xs)) + 3, this.width);
    const bottom = Math.min(Math.ceil(Math.max(...ys)) + 3, this.height);
    return [left, top, right - left, bottom - top];
  }

  // Frame k without the sensor's noise, RGBA.
  photograph(k) {
    const { width, height } = this;
    const instants = this.instants(k);
    const box = this.moving(k);
    const sum = new Float32Array(4 * box[2] * box[3]);
    for (const t of instants) {
      this.paint(t, box);
      const { data } = this.pen.getImageData(...box);
      for (let p = 0; p < sum.length; p++) sum[p] += data[p];
    }
    this.pen.drawImage(this.pictures.ground, 0, 0);
    const picture = this.pen.getImageData(0, 0, width, height);
    for (let row = 0, p = 0; row < box[3]; row++) {
      const from = 4 * ((box[1] + row) * width + box[0]);
      for (let i = 0; i < 4 * box[2]; i++, p++)
        picture.data[from + i] = sum[p] / instants.length;
    }
    return picture;
  }

  // An instant, on the canvas `scene`.
  paint(t, box = [0, 0, this.width, this.height]) {
    const { pen } = this;
    const { ground, car, bricks } = this.pictures;
    const [cx, cy, theta, hx, hy] = this.regionAt(t);
    const [c, s] = [Math.cos(theta), Math.sin(theta)];
    pen.drawImage(ground, ...box, ...box);
    pen.setTransform(c, s, -s, c, cx + 0.5, cy + 0.5);
    pen.drawImage(car, -hx, -hy, 2 * hx, 2 * hy);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    const [x, y] = this.screen.middle(t);
    const side = this.screen.width; // the bricks are a square
    pen.drawImage(bricks, x + 0.5 - side / 2, y + 0.5 - side / 2, side, side);
  }
}
