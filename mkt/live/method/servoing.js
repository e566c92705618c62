// The loop of visual servoing on a car that stands still: [T09], section VI.  Poses are
// 4 x 4, twists (vx, vy, vz, wx, wy, wz) in the camera's frame, as in mkt.servoing.

import { CORNERS } from "./regions.js";

const BEHIND = 1e-9; // a depth that is none
const STEPS = 8; // on the way of a corner
const AXES = { 6: [0, 1, 2, 3, 4, 5], 4: [0, 1, 2, 5] };
// Gauss's three places along a side, and their weights.
const GAUSS = [
  [-Math.sqrt(0.6), 5 / 9],
  [0, 8 / 9],
  [Math.sqrt(0.6), 5 / 9],
];

const dot = (a, b) => a.reduce((sum, each, i) => sum + each * b[i], 0);
const transposed = (a) => a[0].map((_, k) => a.map((row) => row[k]));
const product = (a, b) =>
  a.map((row) => transposed(b).map((column) => dot(row, column)));
const sinc = (x) => (x === 0 ? 1 : Math.sin(x) / x);

function wrapped(angle) {
  const turn = 2 * Math.PI;
  const rest = (angle + Math.PI) % turn;
  return (rest < 0 ? rest + turn : rest) - Math.PI;
}

// The robot: mkt.servoing.robot

// pose exp(dt [twist]), by the formula of Rodrigues.
function move(pose, twist, dt) {
  const [v, w] = [twist.slice(0, 3), twist.slice(3)].map((each) =>
    each.map((x) => x * dt),
  );
  const angle = Math.hypot(...w);
  const [a, b] = [sinc(angle), sinc(angle / 2) ** 2 / 2];
  const c = angle > 1e-4 ? (1 - a) / angle ** 2 : 1 / 6;
  const K = [
    [0, -w[2], w[1]],
    [w[2], 0, -w[0]],
    [-w[1], w[0], 0],
  ];
  const KK = product(K, K);
  const step = K.map((row, i) => {
    const turn = row.map((each, k) => Number(i === k) + a * each + b * KK[i][k]);
    return [...turn, v[i] + b * dot(row, v) + c * dot(KK[i], v)];
  });
  return product(pose, [...step, [0, 0, 0, 1]]);
}

// The pose, parallel to the table, from which the car appears as a region.
function facing({ focal, size, sides, car: [X, Y, heading] }, [cx, cy, theta, hx]) {
  const [c, s] = [Math.cos(heading - theta), Math.sin(heading - theta)];
  const depth = (sides[0] * focal) / (2 * hx);
  const [x, y] = [cx, cy].map(
    (each, i) => ((each - (size[i] - 1) / 2) / focal) * depth,
  );
  const place = [X - (c * x - s * y), Y - (s * x + c * y), -depth];
  return [
    [c, -s, 0, place[0]],
    [s, c, 0, place[1]],
    [0, 0, 1, place[2]],
    [0, 0, 0, 1],
  ];
}

// The map (3, 3) from the table [m] to the image [px], times the depth.
export function homography({ focal, size }, pose) {
  const world = transposed(pose.slice(0, 3).map((row) => row.slice(0, 3)));
  const place = pose.slice(0, 3).map((row) => row[3]);
  const rows = world.map((row) => [row[0], row[1], -dot(row, place)]);
  const middle = size.map((each) => (each - 1) / 2);
  const onto = (row, i) => row.map((each, k) => focal * each + middle[i] * rows[2][k]);
  return [onto(rows[0], 0), onto(rows[1], 1), rows[2]];
}

// Points of the table in the image, or null where one is behind the camera.
export function through(map, points) {
  const seen = points.map(([x, y]) => map.map((row) => dot(row, [x, y, 1])));
  if (seen.some(([, , depth]) => depth <= BEHIND)) return null;
  return seen.map(([u, v, depth]) => [u / depth, v / depth]);
}

// Places of the car, given in shares (s, t) of its half sides, on the table.
function onTable({ sides, car: [X, Y, heading] }, shares) {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return shares.map(([along, across]) => {
    const [x, y] = [(along * sides[0]) / 2, (across * sides[1]) / 2];
    return [X + c * x - s * y, Y + s * x + c * y];
  });
}

const outlineOf = (scene, pose) =>
  through(homography(scene, pose), onTable(scene, CORNERS));

// The region of the similarity that carries the car best onto its image, or null.
function truthOf(scene, pose) {
  const { sides, car } = scene;
  const shares = GAUSS.flatMap(([t]) => GAUSS.map(([s]) => [s, t]));
  const weights = GAUSS.flatMap(([, a]) => GAUSS.map(([, b]) => a * b));
  const points = onTable(scene, shares);
  const seen = through(homography(scene, pose), points);
  if (!seen) return null;
  const all = weights.reduce((sum, each) => sum + each);
  const centre = [0, 1].map(
    (i) =>
      dot(
        weights,
        seen.map((each) => each[i]),
      ) / all,
  );
  let [along, across, size] = [0, 0, 0];
  points.forEach((point, k) => {
    const [x, y] = [point[0] - car[0], point[1] - car[1]];
    const [u, v] = [seen[k][0] - centre[0], seen[k][1] - centre[1]];
    along += weights[k] * (x * u + y * v);
    across += weights[k] * (x * v - y * u);
    size += weights[k] * (x * x + y * y);
  });
  const scale = Math.hypot(along, across) / size;
  const theta = wrapped(car[2] + Math.atan2(across, along));
  return [...centre, theta, ...sides.map((side) => (scale * side) / 2)];
}

// Features and law: mkt.servoing.features, mkt.servoing.law

function normalised({ focal, size }, [cx, cy, theta, hx, hy]) {
  const [x, y] = [cx, cy].map((each, i) => (each - (size[i] - 1) / 2) / focal);
  return [x, y, theta, hx / focal, hy / focal];
}

// s of (16): x_n, y_n, a_n, theta.
function features(scene, region) {
  const [x, y, theta, hx, hy] = normalised(scene, region);
  const size = 1 / Math.sqrt(4 * hx * hy);
  return [size * x, size * y, size, theta];
}

// L (4, 6).
function interactionMatrix(scene, region) {
  const [x, y, theta, hx, hy] = normalised(scene, region);
  const [w, h] = [2 * hx, 2 * hy];
  const [c2, s2] = [Math.cos(2 * theta), Math.sin(2 * theta)];
  const [p, q] = [w * w + h * h, w * w - h * h];
  const [n20, n02, n11] = [(p + q * c2) / 24, (p - q * c2) / 24, (q * s2) / 24];
  const a = 1 / Math.sqrt(w * h);
  const t = -1 / Math.sqrt(scene.sides[0] * scene.sides[1]);
  const xy = 4 * n11 - (x * y) / 2;
  const xx = 1 + 4 * n20 - (x * x) / 2;
  const yy = 1 + 4 * n02 - (y * y) / 2;
  const k = q / p;
  const turnX = (k * (x * c2 + y * s2) - x) / 2;
  const turnY = (k * (x * s2 - y * c2) - y) / 2;
  return [
    [t, 0, 0, a * xy, -a * xx, a * y],
    [0, t, 0, a * yy, -a * xy, -a * x],
    [0, 0, t, -1.5 * a * y, 1.5 * a * x, 0],
    [0, 0, 0, turnX, turnY, -1],
  ];
}

// Where the camera is from which the car appears as a region, L there, and for each
// axis the car's outlines while the camera moves by `push` along or about that axis
// alone.
export function motions(scene, region, push) {
  const pose = facing(scene, region);
  const parts = Array.from({ length: STEPS + 1 }, (_, step) => step / STEPS);
  const ways = push.map((far, k) => {
    const twist = push.map((_, axis) => (axis === k ? far : 0));
    return parts.map((part) => outlineOf(scene, move(pose, twist, part)));
  });
  return { pose, L: interactionMatrix(scene, region), ways };
}

// x of a x = b by elimination, which needs no pivots: a = L L^T is positive definite.
function solved(a, b) {
  const rows = a.map((row, i) => [...row, b[i]]);
  rows.forEach((_, k) => {
    rows.forEach((row, i) => {
      if (i === k) return;
      const share = row[k] / rows[k][k];
      for (let j = k; j < row.length; j++) row[j] -= share * rows[k][j];
    });
  });
  return rows.map((row, k) => row.at(-1) / row[k]);
}

// v = -gain L^+ e, (17), by the axes that the camera may use.
function twistOf(e, L, gain, dof) {
  const J = L.map((row) => AXES[dof].map((axis) => row[axis]));
  const wanted = e.map((each) => -gain * each);
  const shares = solved(product(J, transposed(J)), wanted);
  const v = [0, 0, 0, 0, 0, 0];
  transposed(J).forEach((column, i) => (v[AXES[dof][i]] = dot(column, shares)));
  return v;
}

// The loop: mkt.servoing.loop.close_loop with perfect regions, without compensation.

function errorOf(scene, region, goal) {
  const error = features(scene, region).map((each, i) => each - goal[i]);
  error[3] = wrapped(error[3]);
  return error;
}

// A row for each frame, until the car comes behind the camera: the camera's pose, the
// outline of the car, its error, and the twist of the controller, which knows the error
// `delay` frames later.
export function approached(scene, { gain, dt, delay, dof }, start, frames) {
  const goal = features(scene, scene.desired);
  const [rows, seen] = [[], []];
  let pose = move(facing(scene, scene.desired), start, 1);
  while (rows.length < frames) {
    const [truth, outline] = [truthOf(scene, pose), outlineOf(scene, pose)];
    if (!truth || !outline) break;
    seen.push(truth);
    const region = seen[Math.max(seen.length - 1 - delay, 0)];
    const known = errorOf(scene, region, goal);
    const twist = twistOf(known, interactionMatrix(scene, region), gain, dof);
    rows.push({ pose, outline, error: errorOf(scene, truth, goal), twist });
    pose = move(pose, twist, dt);
  }
  return rows;
}
