// Colours to bins: mkt.colors.

import { rint } from "./numbers.js";

const SPACES = { hsv: [10, 10, 10], rgb: [8, 8, 8], hs: [10, 10] };
const FIXED = 4096; // OpenCV's divisions are products with whole numbers over it
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
