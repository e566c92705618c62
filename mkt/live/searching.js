// The search through the cumulative weights, counted:
// mkt.papers.cordoba2014.resampling.

// For each place in u, which rise, the first particle whose share reaches it, and how
// many comparisons that takes; begun anew for each, or where the last search stopped.
export function ancestors(cumulative, u, anew) {
  let [i, comparisons] = [0, 0];
  const chosen = u.map((place) => {
    if (anew) i = 0;
    comparisons++;
    while (place > cumulative[i]) {
      i++;
      comparisons++;
    }
    return i;
  });
  return { chosen, comparisons };
}

// The particles that each draw is compared with, first and last.
export const spans = (chosen, anew) =>
  chosen.map((last, draw) => [anew || !draw ? 0 : chosen[draw - 1], last]);

// Cumulative weights of n particles of random weight, and equally spaced places in
// them.
export function drawn(n, rng) {
  let sum = 0;
  const cumulative = Array.from(rng.uniforms(n), (u) => (sum -= Math.log(1 - u)));
  const [offset] = rng.uniforms(1);
  return { cumulative, u: cumulative.map((_, k) => ((k + offset) / n) * sum) };
}

// Whole numbers between two, each about as many times as large as the one before.
export function geometric(low, high, n) {
  const between = (k) => Math.round(low * (high / low) ** (k / (n - 1)));
  return Array.from({ length: n }, (_, k) => between(k));
}

// The slope of a straight line through points.
export function slope(points) {
  const mean = (axis) =>
    points.reduce((sum, point) => sum + point[axis], 0) / points.length;
  const [mx, my] = [mean(0), mean(1)];
  const sum = (of) => points.reduce((all, [x, y]) => all + of(x - mx, y - my), 0);
  return sum((x, y) => x * y) / sum((x) => x * x);
}
