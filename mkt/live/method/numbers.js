// Rows of numbers, and how a number is rounded.

export const linspace = (low, high, n) =>
  Array.from({ length: n }, (_, i) =>
    n > 1 ? low + (i * (high - low)) / (n - 1) : low,
  );

export const total = (values) => values.reduce((a, b) => a + b, 0);

// To the nearest whole number, halves to the even one, as numpy and OpenCV round.
export const rint = (x) =>
  2 * Math.round(x / 2) === x + 0.5 ? x + 0.5 : Math.ceil(x - 0.5);
