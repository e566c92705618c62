// The trackers beside the page, so that it never waits: one answer to each message.

import { resized } from "./crowd.js";
import { colorBins } from "./method/colors.js";
import { combinedInit, combinedStep } from "./method/combined.js";
import { learn } from "./method/histograms.js";
import { random } from "./method/random.js";
import { remember, replayed } from "./replays.js";

const bins = colorBins();
let [known, state, rng] = [null, null, null];

const answers = {
  // Learn the object inside a region of a picture.
  learn({ picture, region, options, seed }) {
    rng = random(seed);
    known = { image: bins(picture), region, layout: options.filter.kernels.layout };
    state = combinedInit(options, known.image, region, rng);
    return { region };
  },
  // Find it in the next one.
  step({ picture, options }) {
    const began = performance.now();
    const { filter } = options;
    if (known.layout !== filter.kernels.layout) {
      known.layout = filter.kernels.layout;
      const target = learn(known.image, known.region, filter.kernels);
      state = { ...state, filter: { ...state.filter, target } };
    }
    state = { ...state, filter: resized(state.filter, filter.n) };
    const image = bins(picture);
    const [next, found] = combinedStep(options, state, image, rng);
    state = next;
    const { region, distance, lost, nEff, particles, weights, steps } = found;
    const crowd = Float32Array.from(
      particles.flatMap(([x, y], i) => [x, y, weights[i]]),
    );
    const cost = performance.now() - began;
    return { region, distance, lost, nEff, crowd, steps, cost };
  },
  // Whole runs over frames that are handed over once.
  scene: remember,
  run: replayed,
};

self.onmessage = ({ data }) => {
  try {
    const answer = answers[data.kind](data);
    const { kind, picture, ticket } = data;
    self.postMessage({ ...answer, kind, picture, ticket });
  } catch (error) {
    self.postMessage({ kind: "trouble", words: error.message });
  }
};
