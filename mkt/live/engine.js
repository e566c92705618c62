// The method in the reader's browser: what mkt's Python computes, without a kernel.
//
// Python is the reference; tests/live holds both to the same numbers.  Nothing is
// imported, and every function is pure but for the random numbers that it is handed:
// `random(seed)`, or in tests those that Python drew.  A region is
// [cx, cy, theta, hx, hy] in pixels and radians, as in mkt.regions.

// Colours to bins: mkt.colors

const SPACES = { hsv: [10, 10, 10], rgb: [8, 8, 8], hs: [10, 10] };
const FIXED = 4096; // OpenCV's divisions are products with whole numbers over it
const rint = (x) => (2 * Math.round(x / 2) === x + 0.5 ? x + 0.5 : Math.ceil(x - 0.5));
const over = (top) =>
  Int32Array.from({ length: 256 }, (_, i) => (i ? rint((top * FIXED) / i) : 0));
const BY_VALUE = over(255);
const BY_RANGE = over(30);

// Hue in [0, 180) and saturation in [0, 255], with the rounding of cv2.cvtColor.
function hueSaturation(r, g, b) {
  const value = Math.max(r, g, b);
  const range = value - Math.min(r, g, b);
  let hue = r - g + 4 * range;
  if (value === r) hue = g - b;
  else if (value === g) hue = b - r + 2 * range;
  hue = (hue * BY_RANGE[range] + FIXED / 2) >> 12;
  return [hue < 0 ? hue + 180 : hue, (range * BY_VALUE[value] + FIXED / 2) >> 12];
}

// b(l): a function from RGBA pixels, as a canvas has them, to an image of bins.
export function colorBins({ space = "hsv", sMin = 0.1, vMin = 0.2 } = {}) {
  const counts = SPACES[space];
  const product = counts.reduce((a, b) => a * b);
  const m = space === "hsv" ? counts[0] * counts[1] + counts[2] : product;
  const step = (channel, of, k) =>
    Math.min(Math.floor((channel * counts[k]) / of), counts[k] - 1);
  const binOf = {
    rgb: (r, g, b) =>
      (step(r, 256, 0) * counts[1] + step(g, 256, 1)) * counts[2] + step(b, 256, 2),
    hs: (r, g, b) => {
      const [hue, saturation] = hueSaturation(r, g, b);
      return step(hue, 180, 0) * counts[1] + step(saturation, 256, 1);
    },
    hsv: (r, g, b) => {
      const [hue, saturation] = hueSaturation(r, g, b);
      const value = Math.max(r, g, b);
      if (saturation <= 255 * sMin || value <= 255 * vMin)
        return m - counts[2] + step(value, 256, 2);
      return step(hue, 180, 0) * counts[1] + step(saturation, 256, 1);
    },
  }[space];
  return ({ data, width, height }) => {
    const labels = new Uint16Array(width * height);
    for (let i = 0, p = 0; i < labels.length; i++, p += 4)
      labels[i] = binOf(data[p], data[p + 1], data[p + 2]);
    return { labels, width, height, m };
  };
}

// Frames: mkt.scenes.rendering

export const MOST_SUBFRAMES = 32;

// What a camera sees, without noise, of an object that crosses the place of a region
// along x while the shutter is open: the mean of sub-frames.  Pictures are RGBA; the
// speed is in pixels a frame, the exposure a share of the frame.
export function blurred(ground, sprite, [cx, cy], { exposure, speed }) {
  const path = speed * exposure;
  const n = Math.min(Math.max(Math.ceil(path), 1), MOST_SUBFRAMES);
  const { width, height } = ground;
  const [left, top] = [
    cx + 0.5 - sprite.width / 2,
    Math.round(cy + 0.5 - sprite.height / 2),
  ];
  const lefts = Array.from(
    { length: n },
    (_, k) => left + path * ((k + 0.5) / n - 0.5),
  );
  const mean = Float64Array.from(ground.data);
  const first = Math.max(Math.floor(left - path / 2) - 1, 0);
  const last = Math.min(Math.ceil(left + path / 2) + sprite.width + 1, width);
  for (let row = Math.max(top, 0); row < Math.min(top + sprite.height, height); row++)
    for (let column = first; column < last; column++) {
      const p = 4 * (row * width + column);
      const painted = [0, 0, 0, 0];
      for (const each of lefts)
        between(sprite, column - each, row - top).forEach(
          (value, i) => (painted[i] += value / n),
        );
      for (let i = 0; i < 3; i++)
        mean[p + i] = ground.data[p + i] * (1 - painted[3]) + painted[i];
    }
  const data = Uint8ClampedArray.from(mean, (value, i) => (i % 4 === 3 ? 255 : value));
  return { data, width, height };
}

const NOTHING = [0, 0, 0, 0];

// A picture between two pixels of a row: colours times opacity, and the opacity.
function between({ data, width, height }, x, row) {
  const first = Math.floor(x);
  if (row < 0 || row >= height || first < -1 || first >= width) return NOTHING;
  const share = x - first;
  const sum = [0, 0, 0, 0];
  for (const [column, weight] of [
    [first, 1 - share],
    [first + 1, share],
  ]) {
    if (column < 0 || column >= width || !weight) continue;
    const p = 4 * (row * width + column);
    const opacity = (weight * data[p + 3]) / 255;
    for (let k = 0; k < 3; k++) sum[k] += opacity * data[p + k];
    sum[3] += opacity;
  }
  return sum;
}

// Regions: mkt.regions

export function warp([cx, cy, theta, hx, hy], [x, y]) {
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  return [cx + c * hx * x - s * hy * y, cy + s * hx * x + c * hy * y];
}

export const CORNERS = [
  [-1, -1],
  [1, -1],
  [1, 1],
  [-1, 1],
];
export const corners = (region) => CORNERS.map((point) => warp(region, point));

export const displaced = ([cx, cy, theta, hx, hy], dx, dy, turn, scale = 1) => [
  cx + dx,
  cy + dy,
  theta + turn,
  hx * scale,
  hy * scale,
];

export const linspace = (low, high, n) =>
  Array.from({ length: n }, (_, i) =>
    n > 1 ? low + (i * (high - low)) / (n - 1) : low,
  );

// Kernels: mkt.kernels, with points in the canonical square

const GRIDS = { one: 1, "2x2": 2, "3x3": 3, "4x4": 4 };
export const ROUNDING = 1e-9;

// The places of about so many samples, rows of nearly square cells.
export function pixelGrid(samples, aspect) {
  const nx = rint(Math.min(Math.max(Math.sqrt(samples * aspect), 1), samples));
  const ny = rint(samples / nx);
  const along = (n) => Array.from({ length: n }, (_, i) => (2 * i + 1) / n - 1);
  return along(ny).flatMap((y) => along(nx).map((x) => [x, y]));
}

// Centres and radii in the object plane, where the object has the area 4.
export function layout({ layout: name = "3x3", span = 1, elliptic = false }, aspect) {
  const half = [Math.sqrt(aspect), 1 / Math.sqrt(aspect)];
  const tiles = name === "tiles";
  const k = tiles || name === "cut" ? 3 : GRIDS[name];
  const shorter = 2 * Math.min(...half);
  const radii = half.map((side) =>
    tiles ? (span * side) / 3 : (span * (elliptic ? 2 * side : shorter) * 2) / (k + 3),
  );
  const reach = half.map((side, axis) =>
    tiles || name === "cut" ? (side * 2) / 3 : Math.max(side - radii[axis], 0),
  );
  const along = k > 1 ? linspace(-1, 1, k) : [0];
  const centres = along.flatMap((y) => along.map((x) => [reach[0] * x, reach[1] * y]));
  return { half, radii, centres };
}

// The samples that some kernel sees, and for each kernel its samples with their
// weights.  `columns` holds a pair's weight and its derivatives by a shift along x and
// y, a turn and the logarithm of the size, with C held fixed:
// mkt.trackers.newton.template.
export function fitted(spec, region) {
  const { layout: name = "3x3", profile = "epanechnikov", samples = 1200 } = spec;
  const aspect = Math.max(Number((region[3] / region[4]).toFixed(6)), 1e-6);
  const { half, radii, centres } = layout(spec, aspect);
  const points = pixelGrid(samples, aspect).map(([x, y]) => ({ x, y, index: -1 }));
  const starts = [0];
  const [pairs, sums] = [[], []];
  for (const centre of centres) {
    let sum = 0;
    for (const point of points) {
      const dx = point.x * half[0] - centre[0];
      const dy = point.y * half[1] - centre[1];
      const [ux, uy] = [(dx / radii[0]) ** 2, (dy / radii[1]) ** 2];
      const r2 = name === "tiles" ? Math.max(ux, uy) : ux + uy;
      const flat = r2 <= 1 + ROUNDING ? 1 : 0;
      const k = profile === "uniform" ? flat : Math.max(1 - r2, 0);
      if (k > 0) pairs.push({ point, k, dx, dy });
      sum += k;
    }
    if (!sum) throw new Error("a kernel covers no sample: raise span or samples");
    starts.push(pairs.length);
    sums.push(sum);
  }
  return { starts, ...packed(points, pairs, starts, sums, half, radii) };
}

function packed(points, pairs, starts, sums, half, radii) {
  for (const { point } of pairs) point.index = 0;
  const seen = points.filter(({ index }) => index === 0);
  seen.forEach((point, i) => (point.index = i));
  const columns = new Float64Array(5 * pairs.length);
  for (let j = 0, p = 0; j < sums.length; j++)
    for (; p < starts[j + 1]; p++) {
      const { point, k, dx, dy } = pairs[p];
      const [x, y] = [point.x * half[0], point.y * half[1]];
      const kx = (-2 * dx) / radii[0] ** 2 / sums[j];
      const ky = (-2 * dy) / radii[1] ** 2 / sums[j];
      columns[5 * p] = k / sums[j];
      columns[5 * p + 1] = -kx;
      columns[5 * p + 2] = -ky;
      columns[5 * p + 3] = kx * y - ky * x;
      columns[5 * p + 4] = -(x * kx + y * ky);
    }
  return {
    x: Float32Array.from(seen, ({ x }) => x),
    y: Float32Array.from(seen, ({ y }) => y),
    sample: Int32Array.from(pairs, ({ point }) => point.index),
    weight: Float64Array.from(pairs, (_, p) => columns[5 * p]),
    columns,
  };
}

// Histograms: mkt.histograms

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
const total = (values) => values.reduce((a, b) => a + b, 0);

// d_m over the kernels, and ln p(z | x) up to a constant.
const distance = (rho) => Math.sqrt(total(squares(rho)) / rho.length);
export const logLikelihood = (rho, lambda) => -lambda * total(squares(rho));
export const distanceAt = (target, image, region) =>
  distance(coefficients(target, image, region));

// Random numbers

export function random(seed) {
  let state = seed >>> 0;
  const next = () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const normal = () =>
    Math.sqrt(-2 * Math.log(1 - next())) * Math.cos(2 * Math.PI * next());
  const several = (draw) => (n) => Float64Array.from({ length: n }, draw);
  return { uniforms: several(next), normals: several(normal) };
}

// The numbers that Python drew, in its order: for tests.
export function replay({ uniforms, normals }) {
  const from = (drawn) => {
    let at = 0;
    return (n) => drawn.slice(at, (at += n));
  };
  return { uniforms: from(uniforms), normals: from(normals) };
}

// Particles: mkt.particles

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

function predict({ regions, velocities }, motion, rng) {
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

function scatter(region, n, motion, rng) {
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

function meanRegion(regions, weights) {
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

// The particle filter, SSD and their combination: mkt.trackers

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

const EMPTY = 1e-6;
const FLAT = 1e-3;
const LARGEST_STEP = 0.5;
export const SHORT = 1e-2; // a step that ends the way

// Eigenvalues and vectors of a symmetric matrix, by Jacobi's rotations.
function eigen(matrix) {
  const n = matrix.length;
  const a = matrix.map((row) => [...row]);
  const vectors = a.map((_, i) => a.map((_, k) => (i === k ? 1 : 0)));
  for (let sweep = 0; sweep < 30; sweep++)
    for (let p = 0; p < n; p++)
      for (let q = p + 1; q < n; q++) {
        if (a[p][q] === 0) continue;
        const angle = Math.atan2(2 * a[p][q], a[q][q] - a[p][p]) / 2;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        const turn = (x, y) => [c * x - s * y, s * x + c * y];
        for (const row of a) [row[p], row[q]] = turn(row[p], row[q]);
        for (let k = 0; k < n; k++) [a[p][k], a[q][k]] = turn(a[p][k], a[q][k]);
        for (const row of vectors) [row[p], row[q]] = turn(row[p], row[q]);
      }
  return a.map((row, k) => [row[k], vectors.map((each) => each[k])]);
}

// q (J m) and its derivatives (J m, 4) by a shift along x and y, a turn, the log size.
export function differentiate({ kernels, m }, image, region, derivativeOfC = true) {
  const bins = look(image, kernels, region);
  const { sample, starts, columns } = kernels;
  const size = starts.length - 1;
  const [q, dq] = [new Float64Array(size * m), new Float64Array(4 * size * m)];
  for (let j = 0, p = 0; j < size; j++) {
    const sums = [0, 0, 0, 0, 0];
    for (; p < starts[j + 1]; p++) {
      const u = bins[sample[p]];
      if (u === m) continue;
      for (let k = 0; k < 5; k++) sums[k] += columns[5 * p + k];
      q[j * m + u] += columns[5 * p];
      for (let k = 0; k < 4; k++) dq[4 * (j * m + u) + k] += columns[5 * p + k + 1];
    }
    const all = Math.max(sums[0], EMPTY);
    for (let u = j * m; u < (j + 1) * m; u++) {
      q[u] /= all;
      for (let k = 0; k < 4; k++)
        dq[4 * u + k] =
          (dq[4 * u + k] - (derivativeOfC ? q[u] * sums[k + 1] : 0)) / all;
    }
  }
  return { q, dq };
}

// Delta x = -2 J_U^+ e, (9) of [T09].
export function newtonStep({ q, dq }, target) {
  const reference = target.q.flatMap((each) => [...each]);
  const axes = [0, 1, 2, 3];
  const curvature = axes.map(() => [0, 0, 0, 0]);
  const slope = [0, 0, 0, 0];
  q.forEach((value, u) => {
    if (value <= EMPTY) return;
    const root = Math.sqrt(value);
    const row = axes.map((k) => dq[4 * u + k] / root);
    for (const i of axes) {
      slope[i] += row[i] * (root - Math.sqrt(reference[u]));
      for (const k of axes) curvature[i][k] += row[i] * row[k];
    }
  });
  const directions = eigen(curvature);
  const steepest = Math.max(...directions.map(([value]) => value));
  const step = [0, 0, 0, 0];
  for (const [value, vector] of directions) {
    if (value <= FLAT * steepest) continue;
    const along = (-2 * total(axes.map((k) => vector[k] * slope[k]))) / value;
    for (const k of axes) step[k] += along * vector[k];
  }
  return step;
}

export function moved([cx, cy, theta, hx, hy], step) {
  const [x, y, turn, growth] = step.map((each) =>
    Math.min(Math.max(each, -LARGEST_STEP), LARGEST_STEP),
  );
  const [c, s, size] = [Math.cos(theta), Math.sin(theta), Math.sqrt(hx * hy)];
  const shifted = [cx + size * (c * x - s * y), cy + size * (s * x + c * y)];
  return [...shifted, theta + turn, hx * Math.exp(growth), hy * Math.exp(growth)];
}

// Regions from a start, one step after the other, `enough` says when to end.
export function newtonPath(target, image, start, steps, derivativeOfC, enough = 0) {
  const regions = [start];
  for (let short = false; !short && regions.length <= steps;) {
    const at = differentiate(target, image, regions.at(-1), derivativeOfC);
    const step = newtonStep(at, target);
    regions.push(moved(regions.at(-1), step));
    short = step.every((each) => Math.abs(each) < enough);
  }
  return regions;
}

export const SSD = {
  kernels: { layout: "3x3" },
  iterations: 10,
  derivativeOfC: true,
  sizes: [0.3, 3],
  lostAbove: 0.65,
};

// Minimise from a start, the size bounded by that of the first frame [px].
function refine(options, { target, size }, image, start) {
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

// What a tracker [init, step, options] finds in every image after the first one.
export function track([init, step, options], images, region, rng) {
  let state = init(options, images[0], region, rng);
  return images.slice(1).map((image) => {
    let found;
    [state, found] = step(options, state, image, rng);
    return found;
  });
}

// The same as `track` of the combination, from what its filter found: the filter knows
// nothing of the steps that follow it, so another threshold needs no other filter.
export function refinedTrack(options, images, region, found) {
  const ssd = ssdInit(options.ssd, images[0], region);
  return found.map((info, k) => refined(options, ssd, images[k + 1], info));
}

// The screen before the target: mkt.scenes.teuliere2009

const PASSING = 24; // [px/frame] of a screen, beside the target

// Its width, and its middle at any time; `regionAt(t)` is the target's region.
export function screen(regionAt, { shutter, first, frames }) {
  const ends = [first - shutter / 2, first + frames - 1 + shutter / 2];
  const reach = ends.map((end) => {
    const [, , theta, hx, hy] = regionAt(end);
    return hx * Math.abs(Math.cos(theta)) + hy * Math.abs(Math.sin(theta));
  });
  const left = (t) => -reach[0] - PASSING * (t - ends[0]);
  const right = (t) => reach[1] - PASSING * (t - ends[1]);
  const middle = (t) => {
    const [x, y] = regionAt(t);
    return [x + (left(t) + right(t)) / 2, y];
  };
  return { width: Math.ceil(right(0) - left(0)), middle };
}

const MANY = linspace(-0.98, 0.98, 50);

// The share of a region's box that lies beside a screen with this middle and width.
export function beside(region, [middle], width) {
  const points = MANY.flatMap((y) => MANY.map((x) => warp(region, [x, y])));
  const out = points.filter(([x]) => Math.abs(x - middle) > width / 2);
  return out.length / points.length;
}

// The loop of one feature: mkt.servoing.poles, mkt.servoing.self_motion

// The steady gain of the filter for de/dt, by repeating its equation.
function kalmanGain(ratio, rho) {
  if (ratio === 0) return [0, 0];
  if (ratio === Infinity) return [1, rho];
  let [a, b, d] = [1, 0, 1];
  for (let k = 0; k < 10000; k++) {
    const [ka, kb] = [a / (a + 1), b / (a + 1)];
    const [fa, fb, fd] = [a - ka * a, b - ka * b, d - kb * b];
    [a, b, d] = [fa + 2 * fb + fd, rho * (fb + fd), rho * rho * fd + ratio];
  }
  return [a / (a + 1), b / (a + 1)];
}

// The true errors, frame by frame; velocity and noise have one number a frame.
export function oneFeature(loop, velocity, noise) {
  const { gain, dt, delay, ratio, rho = 0.3, mismatch = 1 } = loop;
  const k = kalmanGain(ratio, rho);
  const [errors, seen, sent] = [[], [], Array(delay + 1).fill(0)];
  let [e, own, coloured] = [0, 0, 0];
  velocity.forEach((speed, frame) => {
    errors.push(e);
    seen.push(e + noise[frame]);
    const now = seen[Math.max(frame - delay, 0)];
    const before = seen[Math.max(frame - delay - 1, 0)];
    if (frame) {
      const surprise = (now - before) / dt + sent.at(-1 - delay) - (own + coloured);
      [own, coloured] = [own + coloured, rho * coloured].map(
        (value, i) => value + k[i] * surprise,
      );
    }
    sent.push(gain * now + own);
    e += dt * (speed - sent.at(-1) / mismatch);
  });
  return errors;
}

// Polynomials are their coefficients, the highest power first.
const product = (a, b) => {
  const result = Array(a.length + b.length - 1).fill(0);
  a.forEach((x, i) => b.forEach((y, k) => (result[i + k] += x * y)));
  return result;
};
const sum = (a, b) => {
  const long = Math.max(a.length, b.length);
  const padded = [a, b].map((each) => [...Array(long - each.length).fill(0), ...each]);
  return padded[0].map((x, i) => x + padded[1][i]);
};
const times = (a, factor) => a.map((x) => factor * x);

// The filter from z to de/dt, as the ratio of two polynomials.
function filterRatio(ratio, rho) {
  if (ratio === 0) return [[0], [1]];
  const [own, coloured] = kalmanGain(ratio, rho);
  const left = 1 - own;
  const [a, d] = [left, rho - coloured]; // A = (a, a; -coloured, d) of mkt's Kalman
  const numerator = [own, a * coloured - d * own, 0];
  return [numerator, [1, -a - d, a * d + a * coloured]];
}

// What must be zero at the poles of the loop: its characteristic polynomial, without
// the zeros of values that are only stored.
function characteristic({ gain, dt, delay, ratio = 0, rho = 0.3, mismatch = 1 }) {
  const [top, bottom] = filterRatio(ratio, rho);
  const late = [1, ...Array(delay + 1).fill(0)];
  const plant = sum(product(late, bottom), times(top, -1));
  const pushed = product([gain * dt, 0], bottom);
  const compensated = product(top, [1, -1]);
  const all = sum(
    product([1, -1], plant),
    times(sum(pushed, compensated), 1 / mismatch),
  );
  let length = all.length;
  while (Math.abs(all[length - 1]) < 1e-12) length--;
  return all.slice(0, length);
}

// The roots of a polynomial that begins with 1, by Durand and Kerner's method, quicker
// from a start that is near them.  Each is [real part, imaginary part].
function roots(polynomial, start) {
  const by = ([a, b], [c, d]) => [a * c - b * d, a * d + b * c];
  const at = (z) =>
    polynomial.reduce(
      (value, each) => {
        const [re, im] = by(value, z);
        return [re + each, im];
      },
      [0, 0],
    );
  const spread = (i) => [Math.cos(i + 0.4), Math.sin(i + 0.4)];
  // From the real axis alone no pair of complex roots is ever found.
  const beside = ([re, im], i) => [re, im + 1e-3 * (i + 1)];
  // Of another number they are no start: at some gains the degree falls.
  const near = start?.length === polynomial.length - 1 && start.map(beside);
  let found =
    near || Array.from({ length: polynomial.length - 1 }, (_, i) => spread(i));
  for (let round = 0, change = 1; round < 500 && change > 1e-11; round++) {
    change = 0;
    found = found.map((z, i) => {
      const others = found.filter((_, k) => k !== i);
      const [c, d] = others.reduce((p, [x, y]) => by(p, [z[0] - x, z[1] - y]), [1, 0]);
      const size = c * c + d * d || 1e-30;
      const [re, im] = by(at(z), [c / size, -d / size]);
      change = Math.max(change, Math.abs(re), Math.abs(im));
      return [z[0] - re, z[1] - im];
    });
  }
  return found;
}

// The poles of the loop: gain, dt, delay, and if need be ratio and rho of the filter
// and mismatch, as in mkt.servoing.poles; `start` has those of a gain that is near.
export const poles = (loop, start) => roots(characteristic(loop), start);

// Overlap and success: mkt.evaluation

const cross = ([ax, ay], [bx, by], [px, py]) =>
  (bx - ax) * (py - ay) - (by - ay) * (px - ax);
const area = (polygon) =>
  total(polygon.map((p, i) => cross([0, 0], p, polygon[(i + 1) % polygon.length]))) / 2;

// What of a polygon lies to the right of the line from a to b, seen on the screen.
function cut(polygon, a, b) {
  return polygon.flatMap((p, i) => {
    const before = polygon.at(i - 1);
    const [here, there] = [cross(a, b, p), cross(a, b, before)];
    const t = there / (there - here);
    const between = before.map((value, axis) => value + t * (p[axis] - value));
    if (here >= 0) return there >= 0 ? [p] : [between, p];
    return there >= 0 ? [between] : [];
  });
}

// Intersection over union of two rotated rectangles.
export function overlap(one, other) {
  const around = corners(other);
  const common = around.reduce(
    (polygon, a, i) =>
      polygon.length ? cut(polygon, a, around[(i + 1) % 4]) : polygon,
    corners(one),
  );
  const both = common.length ? area(common) : 0;
  return both / (area(corners(one)) + area(around) - both);
}

// How far a region is off the truth: [px, rad].
export function errors([x, y, theta], [trueX, trueY, turn]) {
  const off = theta - turn;
  const wrapped = Math.abs(Math.atan2(Math.sin(off), Math.cos(off)));
  return [Math.hypot(x - trueX, y - trueY), wrapped];
}

// The share of overlaps above each limit.
export const success = (overlaps, limits) =>
  limits.map(
    (limit) => overlaps.filter((each) => each > limit).length / overlaps.length,
  );
