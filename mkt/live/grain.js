// The sensor's noise, the same in page and worker.

import { random } from "./method/random.js";

const NOISE = 3; // of the sensor [grey levels], as in mkt.scenes.rendering
const TABLE = 65536;
let grain = null;

// Add the sensor's noise of frame k to pixels (RGBA), in place.
export function grained(data, k) {
  grain ??= random(1)
    .normals(TABLE)
    .map((each) => NOISE * each);
  for (let i = 0, p = 7919 * k; i < data.length; i += 4)
    for (let channel = 0; channel < 3; channel++, p++)
      data[i + channel] += grain[p % TABLE];
}
