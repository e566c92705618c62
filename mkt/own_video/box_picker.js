// A box on a picture: drawn and moved with the mouse or a finger, with the arrow keys,
// or through five number fields.
const NAMES = ["x", "y", "w", "h", "angle"];
const UNITS = { angle: "°" };
const WIDE = 480; // [px] on the screen; smaller pictures are enlarged
const CLICK = 2; // [px] of the picture: a shorter drag draws nothing
const ARROWS = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
const GRIP = 8; // [px] on the screen round a corner, where a drag changes the size
const HELP =
  "The first frame. Drag to draw the box; drag inside it to move " +
  "it (with Shift, to draw a new one there), at a corner to " +
  "change its size, elsewhere to draw anew. Arrow keys move it " +
  "by a pixel; with Shift they change its width and height.";

const centre = ([x, y, w, h]) => [x + w / 2, y + h / 2];
const moved = ([x, y, w, h, angle], dx, dy) => [x + dx, y + dy, w, h, angle];
const grown = ([x, y, w, h, angle], dw, dh) => [
  x,
  y,
  Math.max(1, w + dw),
  Math.max(1, h + dh),
  angle,
];
const spanned = (a, b) => [
  Math.min(a[0], b[0]),
  Math.min(a[1], b[1]),
  Math.abs(a[0] - b[0]),
  Math.abs(a[1] - b[1]),
  0,
];

const drawn = (box) => box[2] > 0 && box[3] > 0;

function turned([x, y], degrees) {
  const t = (degrees * Math.PI) / 180;
  return [x * Math.cos(t) - y * Math.sin(t), x * Math.sin(t) + y * Math.cos(t)];
}

function corners(box) {
  // clockwise from the upper left one; the opposite one is two further
  const [cx, cy] = centre(box);
  return [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ].map(([i, j]) => {
    const [dx, dy] = turned([(i * box[2]) / 2, (j * box[3]) / 2], box[4]);
    return [cx + dx, cy + dy];
  });
}

function stretched(anchor, here, angle) {
  // the box of that angle with these two opposite corners
  const [w, h] = turned([here[0] - anchor[0], here[1] - anchor[1]], -angle).map(
    (side) => Math.max(1, Math.abs(side)),
  );
  return [(anchor[0] + here[0] - w) / 2, (anchor[1] + here[1] - h) / 2, w, h, angle];
}

function contains(box, [px, py]) {
  const [cx, cy] = centre(box),
    t = (box[4] * Math.PI) / 180,
    dx = px - cx,
    dy = py - cy;
  return (
    Math.abs(dx * Math.cos(t) + dy * Math.sin(t)) <= box[2] / 2 &&
    Math.abs(dy * Math.cos(t) - dx * Math.sin(t)) <= box[3] / 2
  );
}

function element(tag, parent, properties) {
  return parent.appendChild(Object.assign(document.createElement(tag), properties));
}

function outline(context, box, scale) {
  const [, , w, h, angle] = box.map((number) => number * scale),
    [cx, cy] = centre(box);
  context.save();
  context.translate(cx * scale, cy * scale);
  context.rotate(((angle / scale) * Math.PI) / 180);
  for (const [color, width] of [
    ["black", 4],
    ["#7dff7d", 2],
  ]) {
    // seen on any ground
    context.strokeStyle = color;
    context.lineWidth = width;
    context.strokeRect(-w / 2, -h / 2, w, h);
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(w / 2, 0); // shows the angle
    context.stroke();
  }
  context.restore();
  context.fillStyle = "#7dff7d";
  for (const [x, y] of corners(box))
    context.fillRect(x * scale - GRIP / 2, y * scale - GRIP / 2, GRIP, GRIP);
}

function render({ model, el }) {
  el.classList.add("mkt-box-picker");
  el.dataset.lmSuppressShortcuts = "true"; // else arrow keys would choose another cell
  const canvas = element("canvas", el, {
    tabIndex: 0,
    className: "mkt-box-canvas",
    title: HELP,
  });
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", HELP);
  const row = element("div", el, { className: "mkt-box-fields" });
  const fields = NAMES.map((name) => {
    const label = element("label", row, { textContent: `${name} ` });
    return element("input", label, {
      type: "number",
      step: "any",
      className: "mkt-box-field",
      name,
      title: `${name} [${UNITS[name] ?? "px"}]`,
    });
  });
  const picture = new Image();
  let box = model.get("box"),
    scale = 1,
    drag = null,
    own = false; // whether the reader has drawn it: another one gives way to any drag

  const draw = () => {
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = scale < 1;
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (picture.naturalWidth)
      context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    if (drawn(box)) outline(context, box, scale);
    fields.forEach((field, i) => {
      if (field !== document.activeElement) field.value = +box[i].toFixed(2);
    });
  };
  const load = () => {
    own = false;
    const url = URL.createObjectURL(new Blob([model.get("frame")]));
    picture.onload = () => {
      URL.revokeObjectURL(url);
      scale = Math.max(1, WIDE / picture.naturalWidth);
      canvas.width = Math.round(picture.naturalWidth * scale);
      canvas.height = Math.round(picture.naturalHeight * scale);
      draw();
    };
    picture.src = url;
  };
  const receive = () => {
    box = model.get("box");
    draw();
  };
  const send = (changed) => {
    box = changed;
    own = true;
    model.set("box", box);
    model.save_changes();
    draw();
  };
  const enable = () => {
    for (const field of fields) field.disabled = !model.get("enabled");
    el.classList.toggle("mkt-busy", !model.get("enabled"));
  };
  const place = (event) => {
    // whole pixels of the picture, inside it
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const inside = (ratio, size) => Math.round(Math.min(Math.max(ratio, 0), 1) * size);
    return [
      inside((event.clientX - left) / width, picture.naturalWidth),
      inside((event.clientY - top) / height, picture.naturalHeight),
    ];
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (!model.get("enabled")) return;
    const start = place(event),
      near = (GRIP * picture.naturalWidth) / canvas.getBoundingClientRect().width;
    const grip = drawn(box)
      ? corners(box).findIndex(
          ([x, y]) => Math.hypot(x - start[0], y - start[1]) <= near,
        )
      : -1;
    const anchor =
      !event.shiftKey && own && grip >= 0 ? corners(box)[(grip + 2) % 4] : null;
    drag = {
      start,
      before: box,
      anchor,
      moving: !event.shiftKey && own && contains(box, start),
    };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const here = place(event),
      [dx, dy] = [here[0] - drag.start[0], here[1] - drag.start[1]];
    const fresh =
      Math.min(Math.abs(dx), Math.abs(dy)) >= CLICK
        ? spanned(drag.start, here)
        : drag.before;
    if (drag.anchor) box = stretched(drag.anchor, here, drag.before[4]);
    else box = drag.moving ? moved(drag.before, dx, dy) : fresh;
    draw();
  });
  canvas.addEventListener("pointerup", () => {
    if (!drag) return;
    const changed = box !== drag.before;
    drag = null;
    if (changed) send(box); // a click alone draws nothing
  });
  canvas.addEventListener("pointercancel", () => {
    if (drag) {
      box = drag.before;
      drag = null;
      draw();
    }
  });
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in ARROWS) || !model.get("enabled") || !drawn(box)) return;
    if (event.altKey || event.ctrlKey || event.metaKey) return; // a shortcut: back
    event.preventDefault();
    event.stopPropagation();
    send((event.shiftKey ? grown : moved)(box, ...ARROWS[event.key]));
  });
  fields.forEach((field, i) => {
    field.addEventListener("change", () => {
      const number = field.value === "" ? NaN : +field.value,
        good = Number.isFinite(number) && (number > 0 || (i !== 2 && i !== 3));
      field.value = good ? number : box[i];
      if (good) send(box.with(i, number));
    });
    field.addEventListener("blur", draw);
  });
  model.on("change:frame", load);
  model.on("change:box", receive);
  model.on("change:enabled", enable);
  load();
  enable();
  return () => {
    model.off("change:frame", load);
    model.off("change:box", receive);
    model.off("change:enabled", enable);
  };
}

export default { render };
