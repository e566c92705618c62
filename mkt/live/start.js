// A page of the book: its live figures, and the camera.

import { camera } from "./camera.js";
import { LIVE } from "./figures.js";
import { worker } from "./host.js";
import { complain } from "./page.js";

// The first panel of each live figure that has sliders, {name: panel}.
function found() {
  const panels = new Map();
  for (const block of document.querySelectorAll("figure.mkt-panel > .mkt-data")) {
    const { file, live } = JSON.parse(block.textContent);
    if (live && !panels.has(file)) panels.set(file, block.parentElement);
  }
  return panels;
}

// What was drawn beforehand stands there until the figure comes near.
function begin(panel, file) {
  panel.classList.add("mkt-soon");
  const start = ([{ isIntersecting }], observer) => {
    if (!isIntersecting) return;
    observer.disconnect();
    LIVE[file](panel, file).catch(complain(panel));
  };
  new IntersectionObserver(start, { rootMargin: "800px" }).observe(panel);
}

// A link with settings leads to its figure, which those above it push down as they come
// to live, until a hand moves something.
function lead(panel) {
  const watch = new ResizeObserver(() => panel.scrollIntoView({ behavior: "instant" }));
  const end = () => watch.disconnect();
  watch.observe(document.body);
  for (const hand of ["wheel", "keydown", "pointerdown"]) addEventListener(hand, end);
  setTimeout(end, 5000);
}

document.addEventListener("DOMContentLoaded", () => {
  const panels = found();
  panels.forEach(begin);
  const [key] = location.hash.slice(1).split("?");
  for (const [file, panel] of panels)
    if (file.endsWith(`.${key}`)) lead(panel);
  const place = document.querySelector("[data-live=track]");
  if (place) camera(place, worker());
});
