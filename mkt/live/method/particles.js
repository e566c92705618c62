// Particles: mkt.particles, and the louder motion of mkt.papers.lessons.beats.

import { total } from "./numbers.js";

export const MOTION = {
  position: 0.06,
  velocity: 0.05,
  angle: 0.08,
  scale: 0.03,
  damping: 0.8,
};

// The motion model with so many times its noise.
export function restless(motion, noise) {
  const louder = { ...motion };
  for (const name of ["position", "velocity", "angle", "scale"]) louder[name] *= noise;
  return louder;
}

export function predict({ regions, velocities }, motion, rng) {
  const n = regions.length;
  const draws = [
    rng.normals(2 * n),
    rng.normals(2 * n),
    rng.normals(n),
    rng.normals(n),
  ];
  const [kicks, walk, turns, growths] = draws;
  const moved = velocities.map((velocity, i) => {
    const unit = Math.sqrt(regions[i][3] * regions[i][4]);
    return velocity.map(
      (v, axis) => motion.damping * v + motion.velocity * unit * kicks[2 * i + axis],
    );
  });
  return {
    velocities: moved,
    regions: regions.map(([cx, cy, theta, hx, hy], i) => {
      const unit = motion.position * Math.sqrt(hx * hy);
      const growth = Math.exp(motion.scale * growths[i]);
      return [
        cx + moved[i][0] + unit * walk[2 * i],
        cy + moved[i][1] + unit * walk[2 * i + 1],
        theta + motion.angle * turns[i],
        hx * growth,
        hy * growth,
      ];
    }),
  };
}

export function scatter(region, n, motion, rng) {
  const still = Array.from({ length: n }, () => [0, 0]);
  return predict({ regions: still.map(() => region), velocities: still }, motion, rng);
}

export function normalised(logWeights) {
  const top = Math.max(...logWeights);
  if (!Number.isFinite(top)) return logWeights.map(() => 1 / logWeights.length);
  const weights = logWeights.map((value) => Math.exp(value - top));
  const sum = total(weights);
  return weights.map((weight) => weight / sum);
}

export const effectiveSampleSize = (weights) => 1 / total(weights.map((w) => w * w));

export function meanRegion(regions, weights) {
  const mean = (of) =>
    regions.reduce((sum, region, i) => sum + weights[i] * of(region), 0);
  return [
    mean(([cx]) => cx),
    mean(([, cy]) => cy),
    Math.atan2(
      mean(([, , t]) => Math.sin(t)),
      mean(([, , t]) => Math.cos(t)),
    ),
    Math.exp(mean(([, , , hx]) => Math.log(hx))),
    Math.exp(mean(([, , , , hy]) => Math.log(hy))),
  ];
}

function search(weights, positions) {
  let sum = 0;
  const cumulative = Array.from(weights, (weight) => (sum += weight));
  return Array.from(positions, (position) => {
    let [low, high] = [0, cumulative.length - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (cumulative[middle] / sum > position) high = middle;
      else low = middle + 1;
    }
    return low;
  });
}

const spaced = (weights, offsets) =>
  search(
    weights,
    weights.map((_, i) => (i + offsets(i)) / weights.length),
  );

// Weights and random numbers to the indices of those that live on.
export const SCHEMES = {
  multinomial: (weights, rng) => search(weights, rng.uniforms(weights.length)),
  stratified: (weights, rng) => {
    const offsets = rng.uniforms(weights.length);
    return spaced(weights, (i) => offsets[i]);
  },
  systematic: (weights, rng) => {
    const [offset] = rng.uniforms(1);
    return spaced(weights, () => offset);
  },
  residual: (weights, rng) => {
    const n = weights.length;
    const certain = weights.map((weight) => Math.floor(n * weight + 1e-9));
    const left = weights.map((weight, i) => Math.max(n * weight - certain[i], 0));
    const copies = certain.flatMap((times, i) => Array(times).fill(i));
    const missing = n - copies.length;
    return missing ? [...copies, ...search(left, rng.uniforms(missing))] : copies;
  },
};
