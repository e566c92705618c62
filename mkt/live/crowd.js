// Another number of particles, or other noise: for sliders that move during a run.

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

// The motion model with so many times its noise.
export function restless(motion, noise) {
  const louder = { ...motion };
  for (const name of ["position", "velocity", "angle", "scale"]) louder[name] *= noise;
  return louder;
}
