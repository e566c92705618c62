// Whether the target is there, and where to wait for it: mkt.trackers.appearance, with
// the ellipses of mkt.trackers.ellipses.

import { look } from "./histograms.js";
import { pixelGrid, ROUNDING } from "./kernels.js";

const BAND = 1; // width of the band along the borders, in half axes
const SPREAD = 0.1; // of the size of placed particles
const BINS = 50; // of the histogram of coefficients

// The samples of the unit disc, as many as lie in it.
export function disc(samples) {
  const points = pixelGrid(samples, 1).filter(
    ([x, y]) => x * x + y * y <= 1 + ROUNDING,
  );
  const along = (axis) => Float32Array.from(points, (point) => point[axis]);
  return { x: along(0), y: along(1) };
}

// The histogram of an upright ellipse (m,), of sum 1 or all zero: (2), (3) of [N03],
// with the printed radius.
function ellipseHistogram(image, disc, region) {
  const bins = look(image, disc, region);
  const [, , , hx, hy] = region;
  const f = (hx * hx) / (hx * hx + hy * hy);
  const counts = new Float64Array(image.m + 1);
  bins.forEach((u, i) => {
    const [x, y] = [disc.x[i], disc.y[i]];
    counts[u] += f * (1 - x * x) + (1 - f) * (1 - y * y);
  });
  const inside = counts.slice(0, image.m);
  const total = Math.max(
    inside.reduce((a, b) => a + b, 0),
    1e-9,
  );
  return inside.map((value) => value / total);
}

// The Bhattacharyya coefficient of an ellipse with a model [[bin, share], ...].
export function coefficient(image, disc, region, model) {
  const p = ellipseHistogram(image, disc, region);
  return model.reduce((rho, [u, share]) => rho + Math.sqrt(p[u] * share), 0);
}

// Particles that wait, as regions: the zones take turns.  A zone is "anywhere",
// "borders", or a door [x, y, spread x, spread y].
export function place(zones, size, halfAxes, n, rng) {
  const centres = Array(n);
  zones.forEach((zone, k) => {
    const many = Math.ceil((n - k) / zones.length);
    const drawn = inZone(zone, size, halfAxes, Math.max(many, 0), rng);
    drawn.forEach((centre, i) => (centres[k + i * zones.length] = centre));
  });
  const growths = rng.normals(n);
  return centres.map((centre, i) => {
    const growth = Math.exp(SPREAD * growths[i]);
    return [...centre, 0, ...halfAxes.map((half) => growth * half)];
  });
}

const pairs = (flat) =>
  Array.from({ length: flat.length / 2 }, (_, i) => [flat[2 * i], flat[2 * i + 1]]);

function inZone(zone, [width, height], halfAxes, n, rng) {
  const most = [width - 1, height - 1];
  const anywhere = () =>
    pairs(rng.uniforms(2 * n)).map((u) => u.map((each, i) => each * most[i]));
  if (zone === "anywhere") return anywhere();
  if (zone === "borders") return alongBorders(anywhere(), most, halfAxes, rng);
  const [x, y, ...spread] = zone;
  return pairs(rng.normals(2 * n)).map(([u, v]) => [
    x + spread[0] * u,
    y + spread[1] * v,
  ]);
}

// Centres that were anywhere, moved into the band along the sides, as many for each
// pixel of border.
function alongBorders(centres, most, halfAxes, rng) {
  const n = centres.length;
  const depths = pairs(rng.uniforms(2 * n));
  const [sides, ends] = [rng.uniforms(n), rng.uniforms(n)];
  const upright = (most[1] + 1) / (most[0] + most[1] + 2);
  return centres.map((centre, i) => {
    const axis = sides[i] < upright ? 0 : 1;
    const depth = BAND * halfAxes[axis] * depths[i][axis];
    const moved = [...centre];
    moved[axis] = ends[i] < 0.5 ? depth : most[axis] - depth;
    return moved;
  });
}

// Mean and spread of the background's coefficients, (13) and (14), and how many fall
// into each of 50 bins.
export function summary(rho) {
  const mean = rho.reduce((a, b) => a + b, 0) / rho.length;
  const squares = rho.reduce((sum, each) => sum + (each - mean) ** 2, 0);
  const counts = Array(BINS).fill(0);
  for (const each of rho) counts[Math.min(Math.floor(BINS * each), BINS - 1)]++;
  return { mean, spread: Math.sqrt(squares / rho.length), counts };
}
