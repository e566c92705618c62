// A box on a picture: drawn and moved with the mouse or a finger, with the arrow keys, or through five number fields.
const NAMES = ["x", "y", "w", "h", "angle"];
const UNITS = { angle: "°" };
const WIDE = 480; // [px] on the screen; smaller pictures are enlarged
const CLICK = 2; // [px] of the picture: a shorter drag draws nothing
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const HELP = "The first frame. Drag to draw the box, drag inside the box to move it (with Shift, to draw a new one there). " +
  "Arrow keys move it by a pixel; with Shift they change its width and height.";

const centre = ([x, y, w, h]) => [x + w / 2, y + h / 2];
const moved = ([x, y, w, h, angle], dx, dy) => [x + dx, y + dy, w, h, angle];
const grown = ([x, y, w, h, angle], dw, dh) => [x, y, Math.max(1, w + dw), Math.max(1, h + dh), angle];
const spanned = (a, b) => [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1]), 0];

function contains(box, [px, py]) {
  const [cx, cy] = centre(box), t = (box[4] * Math.PI) / 180, dx = px - cx, dy = py - cy;
  return Math.abs(dx * Math.cos(t) + dy * Math.sin(t)) <= box[2] / 2 && Math.abs(dy * Math.cos(t) - dx * Math.sin(t)) <= box[3] / 2;
}

function element(tag, parent, properties) {
  return parent.appendChild(Object.assign(document.createElement(tag), properties));
}

function outline(context, box, scale) {
  const [, , w, h, angle] = box.map((number) => number * scale), [cx, cy] = centre(box);
  context.save();
  context.translate(cx * scale, cy * scale);
  context.rotate(((angle / scale) * Math.PI) / 180);
  for (const [color, width] of [["black", 4], ["#7dff7d", 2]]) { // seen on any ground
    context.strokeStyle = color;
    context.lineWidth = width;
    context.strokeRect(-w / 2, -h / 2, w, h);
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(w / 2, 0); // shows the angle
    context.stroke();
  }
  context.restore();
}

function render({ model, el }) {
  el.classList.add("mkt-box-picker");
  el.dataset.lmSuppressShortcuts = "true"; // else the arrow keys would choose another cell of the notebook
  const canvas = element("canvas", el, { tabIndex: 0, className: "mkt-box-canvas", title: HELP });
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", HELP);
  const row = element("div", el, { className: "mkt-box-fields" });
  const fields = NAMES.map((name) => {
    const label = element("label", row, { textContent: `${name} ` });
    return element("input", label, { type: "number", step: "any", className: "mkt-box-field", name, title: `${name} [${UNITS[name] ?? "px"}]` });
  });
  const picture = new Image();
  let box = model.get("box"), scale = 1, drag = null;

  const draw = () => {
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = scale < 1;
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (picture.naturalWidth) context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    outline(context, box, scale);
    fields.forEach((field, i) => { if (field !== document.activeElement) field.value = +box[i].toFixed(2); });
  };
  const load = () => {
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
  const receive = () => { box = model.get("box"); draw(); };
  const send = (changed) => { box = changed; model.set("box", box); model.save_changes(); draw(); };
  const enable = () => {
    for (const field of fields) field.disabled = !model.get("enabled");
    el.classList.toggle("mkt-busy", !model.get("enabled"));
  };
  const place = (event) => { // whole pixels of the picture, inside it
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const inside = (ratio, size) => Math.round(Math.min(Math.max(ratio, 0), 1) * size);
    return [inside((event.clientX - left) / width, picture.naturalWidth), inside((event.clientY - top) / height, picture.naturalHeight)];
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (!model.get("enabled")) return;
    const start = place(event);
    drag = { start, before: box, moving: !event.shiftKey && contains(box, start) };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const here = place(event), [dx, dy] = [here[0] - drag.start[0], here[1] - drag.start[1]];
    const drawn = Math.min(Math.abs(dx), Math.abs(dy)) >= CLICK ? spanned(drag.start, here) : drag.before;
    box = drag.moving ? moved(drag.before, dx, dy) : drawn;
    draw();
  });
  canvas.addEventListener("pointerup", () => { if (drag) { drag = null; send(box); } });
  canvas.addEventListener("pointercancel", () => { if (drag) { box = drag.before; drag = null; draw(); } });
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in ARROWS) || !model.get("enabled")) return;
    event.preventDefault();
    event.stopPropagation();
    send((event.shiftKey ? grown : moved)(box, ...ARROWS[event.key]));
  });
  fields.forEach((field, i) => {
    field.addEventListener("change", () => {
      const number = field.value === "" ? NaN : +field.value, good = Number.isFinite(number) && (number > 0 || (i !== 2 && i !== 3));
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
