// The draws of a resampling scheme, as darts on a bar of the weights.

// The shares of the bar and the darts on it: of residual, of what is left over by those
// that are certain.
export function thrown(scheme, weights, drawn) {
  const n = weights.length;
  const places = {
    multinomial: (i) => drawn[i],
    stratified: (i) => (i + drawn[i]) / n,
    systematic: (i) => (i + drawn[0]) / n,
    residual: (i) => drawn[i],
  }[scheme];
  const certain = weights.map((w) =>
    scheme === "residual" ? Math.floor(n * w + 1e-9) : 0,
  );
  const left = weights.map((w, i) => Math.max(n * w - certain[i], 0));
  const sum = left.reduce((a, b) => a + b, 0);
  const many = n - certain.reduce((a, b) => a + b, 0);
  const shares = left.map((each) => each / Math.max(sum, 1e-9));
  return { certain, shares, darts: Array.from({ length: many }, (_, i) => places(i)) };
}
