// Several kernels and SSD: mkt.trackers.ssd.

import { distanceAt, learn } from "./histograms.js";
import { newtonPath, SHORT } from "./newton.js";

export const SSD = {
  kernels: { layout: "3x3" },
  iterations: 10,
  derivativeOfC: true,
  sizes: [0.3, 3],
  lostAbove: 0.65,
};

// Minimise from a start, the size bounded by that of the first frame [px].
export function refine(options, { target, size }, image, start) {
  const { iterations, derivativeOfC, sizes } = options;
  const path = newtonPath(target, image, start, iterations, derivativeOfC, SHORT);
  const [cx, cy, theta, hx, hy] = path.at(-1);
  const found = Math.sqrt(hx * hy);
  const factor = Math.min(Math.max(found, sizes[0] * size), sizes[1] * size) / found;
  const region = [cx, cy, theta, hx * factor, hy * factor];
  return {
    region,
    distance: distanceAt(target, image, region),
    steps: path.length - 1,
  };
}

export const ssdInit = (options, image, region) => ({
  target: learn(image, region, options.kernels),
  size: Math.sqrt(region[3] * region[4]),
  region,
});

// Minimise from the last estimate.
export function ssdStep(options, state, image) {
  const found = refine(options, state, image, state.region);
  const lost = found.distance > options.lostAbove;
  return [
    { ...state, region: found.region },
    { ...found, lost },
  ];
}
