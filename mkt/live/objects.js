// The objects of chapters 1 and 2: a picture of each, and the bins of two frames.

import { load } from "./host.js";
import { pixels } from "./page.js";

export const SHOWN = [60, 30, 200, 180]; // of a frame: left, top, width, height [px]

// The two bin images of an object that share a picture: low bytes and high bits.
async function binImages(address, m) {
  const { data, width, height } = await pixels(address);
  const images = [0, 1].map(() => ({
    labels: new Uint16Array(width * height),
    width,
    height,
    m,
  }));
  for (let i = 0, p = 0; i < width * height; i++, p += 4)
    images.forEach(({ labels }, k) => {
      labels[i] = data[p + k] + 256 * ((data[p + 2] >> (4 * k)) & 15);
    });
  return images;
}

// An object that stands still: its region, the two bin images, and the second frame as
// numbers and as a picture.
export async function still(item, space) {
  const { bins, m, frame, region } = await load(`surfaces-${item}-${space}`);
  const photo = await pixels(frame);
  const picture = await createImageBitmap(photo);
  return { region, images: await binImages(bins, m), photo, picture };
}
