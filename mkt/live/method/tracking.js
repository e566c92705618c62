// Frame by frame: mkt.tracking.

// What a tracker [init, step, options] finds in every image after the first one.
export function track([init, step, options], images, region, rng) {
  let state = init(options, images[0], region, rng);
  return images.slice(1).map((image) => {
    let found;
    [state, found] = step(options, state, image, rng);
    return found;
  });
}
