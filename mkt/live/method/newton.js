// Gauss-Newton on kernels: mkt.trackers.newton.

import { look } from "./histograms.js";
import { total } from "./numbers.js";

const EMPTY = 1e-6;
const FLAT = 1e-3;
const LARGEST_STEP = 0.5;
export const SHORT = 1e-2; // a step that ends the way

// Eigenvalues and vectors of a symmetric matrix, by Jacobi's rotations.
function eigen(matrix) {
  const n = matrix.length;
  const a = matrix.map((row) => [...row]);
  const vectors = a.map((_, i) => a.map((_, k) => (i === k ? 1 : 0)));
  for (let sweep = 0; sweep < 30; sweep++)
    for (let p = 0; p < n; p++)
      for (let q = p + 1; q < n; q++) {
        if (a[p][q] === 0) continue;
        const angle = Math.atan2(2 * a[p][q], a[q][q] - a[p][p]) / 2;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        const turn = (x, y) => [c * x - s * y, s * x + c * y];
        for (const row of a) [row[p], row[q]] = turn(row[p], row[q]);
        for (let k = 0; k < n; k++) [a[p][k], a[q][k]] = turn(a[p][k], a[q][k]);
        for (const row of vectors) [row[p], row[q]] = turn(row[p], row[q]);
      }
  return a.map((row, k) => [row[k], vectors.map((each) => each[k])]);
}

// q (J m) and its derivatives (J m, 4) by a shift along x and y, a turn, the log size.
export function differentiate({ kernels, m }, image, region, derivativeOfC = true) {
  const bins = look(image, kernels, region);
  const { sample, starts, columns } = kernels;
  const size = starts.length - 1;
  const [q, dq] = [new Float64Array(size * m), new Float64Array(4 * size * m)];
  for (let j = 0, p = 0; j < size; j++) {
    const sums = [0, 0, 0, 0, 0];
    for (; p < starts[j + 1]; p++) {
      const u = bins[sample[p]];
      if (u === m) continue;
      for (let k = 0; k < 5; k++) sums[k] += columns[5 * p + k];
      q[j * m + u] += columns[5 * p];
      for (let k = 0; k < 4; k++) dq[4 * (j * m + u) + k] += columns[5 * p + k + 1];
    }
    const all = Math.max(sums[0], EMPTY);
    for (let u = j * m; u < (j + 1) * m; u++) {
      q[u] /= all;
      for (let k = 0; k < 4; k++)
        dq[4 * u + k] =
          (dq[4 * u + k] - (derivativeOfC ? q[u] * sums[k + 1] : 0)) / all;
    }
  }
  return { q, dq };
}

// Delta x = -2 J_U^+ e, (9) of [T09].
export function newtonStep({ q, dq }, target) {
  const reference = target.q.flatMap((each) => [...each]);
  const axes = [0, 1, 2, 3];
  const curvature = axes.map(() => [0, 0, 0, 0]);
  const slope = [0, 0, 0, 0];
  q.forEach((value, u) => {
    if (value <= EMPTY) return;
    const root = Math.sqrt(value);
    const row = axes.map((k) => dq[4 * u + k] / root);
    for (const i of axes) {
      slope[i] += row[i] * (root - Math.sqrt(reference[u]));
      for (const k of axes) curvature[i][k] += row[i] * row[k];
    }
  });
  const directions = eigen(curvature);
  const steepest = Math.max(...directions.map(([value]) => value));
  const step = [0, 0, 0, 0];
  for (const [value, vector] of directions) {
    if (value <= FLAT * steepest) continue;
    const along = (-2 * total(axes.map((k) => vector[k] * slope[k]))) / value;
    for (const k of axes) step[k] += along * vector[k];
  }
  return step;
}

export function moved([cx, cy, theta, hx, hy], step) {
  const [x, y, turn, growth] = step.map((each) =>
    Math.min(Math.max(each, -LARGEST_STEP), LARGEST_STEP),
  );
  const [c, s, size] = [Math.cos(theta), Math.sin(theta), Math.sqrt(hx * hy)];
  const shifted = [cx + size * (c * x - s * y), cy + size * (s * x + c * y)];
  return [...shifted, theta + turn, hx * Math.exp(growth), hy * Math.exp(growth)];
}

// Regions from a start, one step after the other, `enough` says when to end.
export function newtonPath(target, image, start, steps, derivativeOfC, enough = 0) {
  const regions = [start];
  for (let short = false; !short && regions.length <= steps;) {
    const at = differentiate(target, image, regions.at(-1), derivativeOfC);
    const step = newtonStep(at, target);
    regions.push(moved(regions.at(-1), step));
    short = step.every((each) => Math.abs(each) < enough);
  }
  return regions;
}
