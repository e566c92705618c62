// Kernels, with points in the canonical square: mkt.kernels.

import { linspace, rint } from "./numbers.js";

const GRIDS = { one: 1, "2x2": 2, "3x3": 3, "4x4": 4 };
export const ROUNDING = 1e-9;

// The places of about so many samples, rows of nearly square cells.
export function pixelGrid(samples, aspect) {
  const nx = rint(Math.min(Math.max(Math.sqrt(samples * aspect), 1), samples));
  const ny = rint(samples / nx);
  const along = (n) => Array.from({ length: n }, (_, i) => (2 * i + 1) / n - 1);
  return along(ny).flatMap((y) => along(nx).map((x) => [x, y]));
}

// Centres and radii in the object plane, where the object has the area 4.
export function layout({ layout: name = "3x3", span = 1, elliptic = false }, aspect) {
  const half = [Math.sqrt(aspect), 1 / Math.sqrt(aspect)];
  const tiles = name === "tiles";
  const k = tiles || name === "cut" ? 3 : GRIDS[name];
  const shorter = 2 * Math.min(...half);
  const radii = half.map((side) =>
    tiles ? (span * side) / 3 : (span * (elliptic ? 2 * side : shorter) * 2) / (k + 3),
  );
  const reach = half.map((side, axis) =>
    tiles || name === "cut" ? (side * 2) / 3 : Math.max(side - radii[axis], 0),
  );
  const along = k > 1 ? linspace(-1, 1, k) : [0];
  const centres = along.flatMap((y) => along.map((x) => [reach[0] * x, reach[1] * y]));
  return { half, radii, centres };
}

// The samples that some kernel sees, and for each kernel its samples with their
// weights.  `columns` holds a pair's weight and its derivatives by a shift along x and
// y, a turn and the logarithm of the size, with C held fixed:
// mkt.trackers.newton.template.
export function fitted(spec, region) {
  const { layout: name = "3x3", profile = "epanechnikov", samples = 1200 } = spec;
  const aspect = Math.max(Number((region[3] / region[4]).toFixed(6)), 1e-6);
  const { half, radii, centres } = layout(spec, aspect);
  const points = pixelGrid(samples, aspect).map(([x, y]) => ({ x, y, index: -1 }));
  const starts = [0];
  const [pairs, sums] = [[], []];
  for (const centre of centres) {
    let sum = 0;
    for (const point of points) {
      const dx = point.x * half[0] - centre[0];
      const dy = point.y * half[1] - centre[1];
      const [ux, uy] = [(dx / radii[0]) ** 2, (dy / radii[1]) ** 2];
      const r2 = name === "tiles" ? Math.max(ux, uy) : ux + uy;
      const flat = r2 <= 1 + ROUNDING ? 1 : 0;
      const k = profile === "uniform" ? flat : Math.max(1 - r2, 0);
      if (k > 0) pairs.push({ point, k, dx, dy });
      sum += k;
    }
    if (!sum) throw new Error("a kernel covers no sample: raise span or samples");
    starts.push(pairs.length);
    sums.push(sum);
  }
  return { starts, ...packed(points, pairs, starts, sums, half, radii) };
}

function packed(points, pairs, starts, sums, half, radii) {
  for (const { point } of pairs) point.index = 0;
  const seen = points.filter(({ index }) => index === 0);
  seen.forEach((point, i) => (point.index = i));
  const columns = new Float64Array(5 * pairs.length);
  for (let j = 0, p = 0; j < sums.length; j++)
    for (; p < starts[j + 1]; p++) {
      const { point, k, dx, dy } = pairs[p];
      const [x, y] = [point.x * half[0], point.y * half[1]];
      const kx = (-2 * dx) / radii[0] ** 2 / sums[j];
      const ky = (-2 * dy) / radii[1] ** 2 / sums[j];
      columns[5 * p] = k / sums[j];
      columns[5 * p + 1] = -kx;
      columns[5 * p + 2] = -ky;
      columns[5 * p + 3] = kx * y - ky * x;
      columns[5 * p + 4] = -(x * kx + y * ky);
    }
  return {
    x: Float32Array.from(seen, ({ x }) => x),
    y: Float32Array.from(seen, ({ y }) => y),
    sample: Int32Array.from(pairs, ({ point }) => point.index),
    weight: Float64Array.from(pairs, (_, p) => columns[5 * p]),
    columns,
  };
}
