// Which figures of a page are live, and how each begins.  WORKER is the text of the
// worker: pages on a disk may start one only from a text that they hold.

import { beats } from "./beats.js";
import { camera } from "./camera.js";
import { histogramsOf } from "./histograms.js";
import { kernels } from "./kernels.js";
import { rootLocus } from "./loop.js";
import { newton } from "./newton.js";
import { resampling } from "./resampling.js";
import { successCurves } from "./success.js";
import { blur, surfaces } from "./surfaces.js";
import { wall } from "./wall.js";

const LIVE = {
  "own.beats": beats,
  "own.newton": newton,
  "own.resampling": resampling,
  "own.root_locus": rootLocus,
  "own.success": successCurves,
  "teuliere2009.fig1": histogramsOf,
  "teuliere2009.fig2": kernels,
  "teuliere2009.fig3": surfaces,
  "teuliere2009.fig4": blur,
  "teuliere2009.fig6": wall,
};

// The first panel of each live figure that has sliders, {name: panel}.
function found() {
  const panels = new Map();
  for (const block of document.querySelectorAll("figure.mkt-panel > .mkt-data")) {
    const { file, live } = JSON.parse(block.textContent);
    if (live && !panels.has(file))
      panels.set(file, block.parentElement);
  }
  return panels;
}

function worker() {
  const text = new Blob([WORKER], { type: "text/javascript" });
  return new Worker(URL.createObjectURL(text));
}

// What was drawn beforehand stands there until the figure comes near.
function begin(panel, file) {
  panel.classList.add("mkt-soon");
  const start = ([{ isIntersecting }], observer) => {
    if (!isIntersecting) return;
    observer.disconnect();
    LIVE[file](panel, file, worker);
  };
  new IntersectionObserver(start, { rootMargin: "800px" }).observe(panel);
}

document.addEventListener("DOMContentLoaded", () => {
  const panels = found();
  panels.forEach(begin);
  // A link with settings leads to its figure.
  const [key] = location.hash.slice(1).split("?");
  for (const [file, panel] of panels)
    if (file.endsWith(`.${key}`)) panel.scrollIntoView();
  const place = document.querySelector("[data-live=track]");
  if (place) camera(place, worker());
});
