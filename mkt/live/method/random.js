// Random numbers of a seed.

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

// The numbers that Python drew, in its order.
export function replay({ uniforms, normals }) {
  const from = (drawn) => {
    let at = 0;
    return (n) => drawn.slice(at, (at += n));
  };
  return { uniforms: from(uniforms), normals: from(normals) };
}
