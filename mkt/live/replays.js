// Whole runs over the same painted frames, in the worker: figure 6 of [T09].

import { grained } from "./grain.js";
import { colorBins } from "./method/colors.js";
import { COMBINED, refinedTrack } from "./method/combined.js";
import { FILTER, filterInit, filterStep } from "./method/particle_filter.js";
import { random } from "./method/random.js";
import { SSD, ssdInit, ssdStep } from "./method/ssd.js";
import { track } from "./method/tracking.js";

const bins = colorBins();
const ONE = { ...FILTER, kernels: { layout: "one" } };
let scene = null;

// The frames that all runs share, and where the target is in the first one.
export function remember({ pictures, region }) {
  scene = { pictures, region, seen: new Map(), found: new Map() };
  return {};
}

// The bins of all frames as the sensor of one run sees them; bytes, as there are many.
function images(run) {
  if (!scene.seen.has(run))
    scene.seen.set(
      run,
      scene.pictures.map(({ data, width, height }, k) => {
        const noisy = Uint8ClampedArray.from(data);
        grained(noisy, k + run * scene.pictures.length);
        const { labels, m } = bins({ data: noisy, width, height });
        return { labels: Uint8Array.from(labels), width, height, m };
      }),
    );
  return scene.seen.get(run);
}

const follow = (tracker, run) =>
  track(tracker, images(run), scene.region, random(1000 + run));

// The filter's finds with one number of particles, kept for other thresholds.
function crowd(n, run) {
  const known = scene.found.get(run);
  if (known?.n === n) return known.found;
  const found = follow([filterInit, filterStep, { ...FILTER, n }], run);
  scene.found.set(run, { n, found });
  return found;
}

const several = (kernels, run) =>
  follow([filterInit, filterStep, { ...kernels, n: 500 }], run);

const JOBS = {
  ssd: (_, run) => ({ ssd: follow([ssdInit, ssdStep, SSD], run) }),
  pair: ({ n, threshold }, run) => {
    const found = crowd(n, run);
    const options = { ...COMBINED, threshold };
    const combined = refinedTrack(options, images(run), scene.region, found);
    return { "pf-75": found, combined };
  },
  "pf-500": (_, run) => ({ "pf-500": several(FILTER, run) }),
  "pf-1": (_, run) => ({ "pf-1": several(ONE, run) }),
};

// The regions (frames, 5) that the trackers of a job find, by their names.
export function replayed({ job, run, settings }) {
  const began = performance.now();
  const found = JOBS[job](settings, run);
  const tracks = Object.fromEntries(
    Object.entries(found).map(([name, infos]) => [
      name,
      [scene.region, ...infos.map(({ region }) => region)],
    ]),
  );
  return { tracks, cost: performance.now() - began };
}
