// Kernel-weighted histograms, and how alike they are: mkt.histograms.

import { fitted } from "./kernels.js";
import { total } from "./numbers.js";

const HALF_EVEN = 12582912; // 2^23 + 2^22: adding it rounds a single to a whole number

// The bin under every sample, m outside the image; in single precision, as OpenCV.
export function look(image, kernels, [cx, cy, theta, hx, hy]) {
  const { width, height, labels, m } = image;
  const { x, y } = kernels;
  const f = Math.fround;
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  const [xx, xy, yx, yy] = [f(c * hx), f(-s * hy), f(s * hx), f(c * hy)];
  const [tx, ty] = [f(cx), f(cy)];
  const bins = new Uint16Array(x.length);
  for (let i = 0; i < bins.length; i++) {
    const u = f(f(f(xx * x[i]) + xy * y[i]) + tx);
    const v = f(f(f(yx * x[i]) + yy * y[i]) + ty);
    const column = f(u + HALF_EVEN) - HALF_EVEN;
    const row = f(v + HALF_EVEN) - HALF_EVEN;
    const inside = column >= 0 && row >= 0 && column < width && row < height;
    bins[i] = inside ? labels[row * width + column] : m;
  }
  return bins;
}

// Counts (J, m + 1) as one array; the last bin is what lies outside.
function count(image, kernels, region) {
  const bins = look(image, kernels, region);
  const { sample, weight, starts } = kernels;
  const counts = new Float64Array((starts.length - 1) * (image.m + 1));
  for (let j = 0, p = 0; j + 1 < starts.length; j++) {
    const base = j * (image.m + 1);
    for (; p < starts[j + 1]; p++) counts[base + bins[sample[p]]] += weight[p];
  }
  return counts;
}

// q: one array (m,) for each kernel, of sum 1 or all zero.
export function histograms(image, kernels, region) {
  const counts = count(image, kernels, region);
  return Array.from({ length: kernels.starts.length - 1 }, (_, j) => {
    const q = counts.slice(j * (image.m + 1), j * (image.m + 1) + image.m);
    const total = Math.max(
      q.reduce((a, b) => a + b, 0),
      1e-9,
    );
    return q.map((value) => value / total);
  });
}

// The reference: kernels, histograms, and where these are not empty.
export function learn(image, region, spec) {
  const kernels = fitted(spec, region);
  const q = histograms(image, kernels, region);
  if (q.some((each) => !each.some((value) => value > 0)))
    throw new Error(
      "part of the region lies outside the image; choose a box inside it",
    );
  const filled = q.map((each) => [...each.keys()].filter((u) => each[u] > 0));
  return { kernels, q, filled, m: image.m };
}

// Bhattacharyya coefficients rho_j of one region with the reference.
export function coefficients({ kernels, q, filled, m }, image, region) {
  const counts = count(image, kernels, region);
  return q.map((reference, j) => {
    const base = j * (m + 1);
    let total = 0;
    for (let u = base; u < base + m; u++) total += counts[u];
    let rho = 0;
    for (const u of filled[j]) rho += Math.sqrt(counts[base + u] * reference[u]);
    return rho / Math.sqrt(Math.max(total, 1e-9));
  });
}

const squares = (rho) => rho.map((each) => Math.max(1 - each, 0));

// d_m over the kernels, and ln p(z | x) up to a constant.
const distance = (rho) => Math.sqrt(total(squares(rho)) / rho.length);
export const logLikelihood = (rho, lambda) => -lambda * total(squares(rho));
export const distanceAt = (target, image, region) =>
  distance(coefficients(target, image, region));
