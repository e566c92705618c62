// The filter, then SSD where it sees the target: mkt.trackers.combined.

import { FILTER, filterInit, filterStep } from "./particle_filter.js";
import { refine, SSD, ssdInit } from "./ssd.js";

export const COMBINED = { filter: FILTER, ssd: SSD, threshold: 0.6, refines: true };

export const combinedInit = (options, image, region, rng) => ({
  filter: filterInit(options.filter, image, region, rng),
  ssd: ssdInit(options.ssd, image, region),
});

// The estimate of the filter, refined where the target is seen: the switch.
function refined(options, ssd, image, info) {
  if (!options.refines || info.distance > options.threshold)
    return { ...info, steps: 0 };
  const better = refine(options.ssd, ssd, image, info.region);
  const lost = better.distance > options.ssd.lostAbove;
  return { ...info, ...better, lost };
}

export function combinedStep(options, state, image, rng) {
  const [filter, info] = filterStep(options.filter, state.filter, image, rng);
  return [{ ...state, filter }, refined(options, state.ssd, image, info)];
}

// The same as `track` of the combination, from what its filter found: the filter knows
// nothing of the steps that follow it, so another threshold needs no other filter.
export function refinedTrack(options, images, region, found) {
  const ssd = ssdInit(options.ssd, images[0], region);
  return found.map((info, k) => refined(options, ssd, images[k + 1], info));
}
