// The table that the robot's camera looks down on.

import { homography, through } from "./method/servoing.js";

// A picture of it as a camera sees it that is not tilted: only moved and turned.
export function drawTable(pen, scene, picture, pose, onto) {
  const [o, u, , v] = through(homography(scene, pose), scene.corners).map(onto);
  const { width, height } = picture;
  pen.save();
  pen.transform(
    (u[0] - o[0]) / width,
    (u[1] - o[1]) / width,
    (v[0] - o[0]) / height,
    (v[1] - o[1]) / height,
    o[0],
    o[1],
  );
  pen.drawImage(picture, 0, 0);
  pen.restore();
}
