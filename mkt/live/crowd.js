// Another number of particles in the middle of a run: for sliders that move meanwhile.

// All weigh the same, so some are taken twice, or left out, at equal distances.
export function resized(filter, n) {
  const { regions, velocities } = filter.particles;
  if (regions.length === n) return filter;
  const chosen = Array.from({ length: n }, (_, i) =>
    Math.floor((i * regions.length) / n),
  );
  const particles = {
    regions: chosen.map((i) => regions[i]),
    velocities: chosen.map((i) => velocities[i]),
  };
  return { ...filter, particles };
}
