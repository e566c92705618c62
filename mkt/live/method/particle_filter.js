// The particle filter: mkt.trackers.particle_filter.

import { coefficients, distanceAt, learn, logLikelihood } from "./histograms.js";
import {
  effectiveSampleSize,
  meanRegion,
  MOTION,
  normalised,
  predict,
  scatter,
  SCHEMES,
} from "./particles.js";

export const FILTER = {
  n: 75,
  kernels: { layout: "tiles", profile: "uniform" },
  lambda: 20,
  motion: MOTION,
  scheme: "multinomial",
  lostAbove: 0.65,
};

export const filterInit = (options, image, region, rng) => ({
  target: learn(image, region, options.kernels),
  particles: scatter(region, options.n, options.motion, rng),
});

// Predict, weigh, estimate, draw: [the next state, what it found].
export function filterStep(options, { target, particles: before }, image, rng) {
  const particles = predict(before, options.motion, rng);
  const { regions, velocities } = particles;
  const rho = regions.map((region) => coefficients(target, image, region));
  const weights = normalised(rho.map((each) => logLikelihood(each, options.lambda)));
  const region = meanRegion(regions, weights);
  const d = distanceAt(target, image, region);
  const ancestors = SCHEMES[options.scheme](weights, rng);
  const drawn = {
    regions: ancestors.map((i) => regions[i]),
    velocities: ancestors.map((i) => velocities[i]),
  };
  const nEff = effectiveSampleSize(weights);
  const lost = d > options.lostAbove;
  const found = {
    region,
    distance: d,
    lost,
    nEff,
    particles: regions,
    weights,
    ancestors,
  };
  return [{ target, particles: drawn }, found];
}
