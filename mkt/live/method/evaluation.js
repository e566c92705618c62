// Overlap and success: mkt.evaluation.

import { total } from "./numbers.js";
import { corners } from "./regions.js";

const cross = ([ax, ay], [bx, by], [px, py]) =>
  (bx - ax) * (py - ay) - (by - ay) * (px - ax);
const area = (polygon) =>
  total(polygon.map((p, i) => cross([0, 0], p, polygon[(i + 1) % polygon.length]))) / 2;

// What of a polygon lies to the right of the line from a to b, seen on the screen.
function cut(polygon, a, b) {
  return polygon.flatMap((p, i) => {
    const before = polygon.at(i - 1);
    const [here, there] = [cross(a, b, p), cross(a, b, before)];
    const t = there / (there - here);
    const between = before.map((value, axis) => value + t * (p[axis] - value));
    if (here >= 0) return there >= 0 ? [p] : [between, p];
    return there >= 0 ? [between] : [];
  });
}

// Intersection over union of two rotated rectangles.
export function overlap(one, other) {
  const around = corners(other);
  const common = around.reduce(
    (polygon, a, i) =>
      polygon.length ? cut(polygon, a, around[(i + 1) % 4]) : polygon,
    corners(one),
  );
  const both = common.length ? area(common) : 0;
  return both / (area(corners(one)) + area(around) - both);
}

// How far a region is off the truth: [px, rad].
export function errors([x, y, theta], [trueX, trueY, turn]) {
  const off = theta - turn;
  const wrapped = Math.abs(Math.atan2(Math.sin(off), Math.cos(off)));
  return [Math.hypot(x - trueX, y - trueY), wrapped];
}

// The share of overlaps above each limit.
export const success = (overlaps, limits) =>
  limits.map(
    (limit) => overlaps.filter((each) => each > limit).length / overlaps.length,
  );
