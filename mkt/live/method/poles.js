// The loop of one feature: mkt.servoing.poles and mkt.servoing.self_motion.

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
