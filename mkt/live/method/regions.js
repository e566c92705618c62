// Regions [cx, cy, theta, hx, hy] in pixels and radians: mkt.regions.

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
