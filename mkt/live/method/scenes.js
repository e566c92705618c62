// What a camera sees: mkt.scenes.rendering, and the screen of mkt.scenes.teuliere2009.

import { linspace } from "./numbers.js";
import { warp } from "./regions.js";

export const MAX_SUBFRAMES = 32;

// What a camera sees, without noise, of an object that crosses the place of a region
// along x while the shutter is open: the mean of sub-frames.  Pictures are RGBA; the
// speed is in pixels a frame, the exposure a share of the frame.
export function blurred(ground, sprite, [cx, cy], { exposure, speed }) {
  const path = speed * exposure;
  const n = Math.min(Math.max(Math.ceil(path), 1), MAX_SUBFRAMES);
  const { width, height } = ground;
  const [left, top] = [
    cx + 0.5 - sprite.width / 2,
    Math.round(cy + 0.5 - sprite.height / 2),
  ];
  const lefts = Array.from(
    { length: n },
    (_, k) => left + path * ((k + 0.5) / n - 0.5),
  );
  const mean = Float64Array.from(ground.data);
  const first = Math.max(Math.floor(left - path / 2) - 1, 0);
  const last = Math.min(Math.ceil(left + path / 2) + sprite.width + 1, width);
  for (let row = Math.max(top, 0); row < Math.min(top + sprite.height, height); row++)
    for (let column = first; column < last; column++) {
      const p = 4 * (row * width + column);
      const painted = [0, 0, 0, 0];
      for (const each of lefts)
        between(sprite, column - each, row - top).forEach(
          (value, i) => (painted[i] += value / n),
        );
      for (let i = 0; i < 3; i++)
        mean[p + i] = ground.data[p + i] * (1 - painted[3]) + painted[i];
    }
  const data = Uint8ClampedArray.from(mean, (value, i) => (i % 4 === 3 ? 255 : value));
  return { data, width, height };
}

const NOTHING = [0, 0, 0, 0];

// A picture between two pixels of a row: colours times opacity, and the opacity.
function between({ data, width, height }, x, row) {
  const first = Math.floor(x);
  if (row < 0 || row >= height || first < -1 || first >= width) return NOTHING;
  const share = x - first;
  const sum = [0, 0, 0, 0];
  for (const [column, weight] of [
    [first, 1 - share],
    [first + 1, share],
  ]) {
    if (column < 0 || column >= width || !weight) continue;
    const p = 4 * (row * width + column);
    const opacity = (weight * data[p + 3]) / 255;
    for (let k = 0; k < 3; k++) sum[k] += opacity * data[p + k];
    sum[3] += opacity;
  }
  return sum;
}

const PASSING = 24; // [px/frame] of a screen, beside the target

// Its width, and its middle at any time; `regionAt(t)` is the target's region.
export function screen(regionAt, { shutter, first, frames }) {
  const ends = [first - shutter / 2, first + frames - 1 + shutter / 2];
  const reach = ends.map((end) => {
    const [, , theta, hx, hy] = regionAt(end);
    return hx * Math.abs(Math.cos(theta)) + hy * Math.abs(Math.sin(theta));
  });
  const left = (t) => -reach[0] - PASSING * (t - ends[0]);
  const right = (t) => reach[1] - PASSING * (t - ends[1]);
  const middle = (t) => {
    const [x, y] = regionAt(t);
    return [x + (left(t) + right(t)) / 2, y];
  };
  return { width: Math.ceil(right(0) - left(0)), middle };
}

const MANY = linspace(-0.98, 0.98, 50);

// The share of a region's box that lies beside a screen with this middle and width.
export function beside(region, [middle], width) {
  const points = MANY.flatMap((y) => MANY.map((x) => warp(region, [x, y])));
  const out = points.filter(([x]) => Math.abs(x - middle) > width / 2);
  return out.length / points.length;
}
