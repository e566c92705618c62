// Moves the sliders of the figures on a page without a kernel: each panel has its
// pictures, drawn beforehand, in a data block, or there their addresses.

const BACK = "; the others are back where they began. In JupyterLab all move together.";

function said(titles, shown, names) {
  return names.map((name) => `${titles[name]} = ${shown[name]}`).join(", ");
}

function begin(panel) {
  const data = JSON.parse(panel.querySelector(".mkt-data").textContent);
  const shown = { ...data.shown };
  const image = panel.querySelector("img");
  const note = panel.querySelector("[role=status]");
  const first = note?.textContent;
  data.frames[0] = image.getAttribute("src");
  const controls = [...panel.querySelectorAll("[data-name]")];

  const put = (control, position) => {
    const { name } = control.dataset;
    const label = data.sliders[name].labels[position];
    shown[name] = label;
    control.value = position;
    if (control.type === "range") {
      control.nextElementSibling.value = label;
      control.setAttribute("aria-valuetext", label);
    }
  };

  const place = (group) =>
    group.names.reduce((at, name) => {
      const control = controls.find(({ dataset }) => dataset.name === name);
      return at * data.sliders[name].labels.length + Number(control.value);
    }, 0);

  const groupOf = (moved) =>
    moved
      ? data.groups.find(({ names }) => names.includes(moved.dataset.name))
      : { names: [], frames: [0] };

  const show = (moved) => {
    const group = groupOf(moved);
    const inside = ({ dataset }) => group.names.includes(dataset.name);
    const others = controls.filter((control) => !inside(control));
    for (const control of others)
      put(control, data.sliders[control.dataset.name].start);
    for (const control of controls.filter(inside)) put(control, Number(control.value));
    image.src = data.frames[group.frames[place(group)]];
    if (controls.length) {
      image.alt = `${data.title} ${said(data.titles, shown, Object.keys(shown))}.`;
    }
    if (note) {
      note.innerHTML = moved
        ? said(data.marked, shown, group.names) + (others.length ? BACK : ".")
        : first;
    }
  };

  const save = () => {
    const canvas = document.createElement("canvas");
    const link = document.createElement("a");
    canvas.width = image.naturalWidth;
    canvas.height = image.naturalHeight;
    canvas.getContext("2d").drawImage(image, 0, 0);
    const changed = Object.keys(data.shown)
      .filter((name) => shown[name] !== data.shown[name])
      .map((name) => `${name}=${shown[name]}`);
    const name = [data.file, ...changed].join(" ");
    try {
      link.href = canvas.toDataURL("image/png");
      link.download = `${name}.png`;
    } catch {
      link.href = image.src; // a page on a disk may not read a file beside it,
      link.target = "_blank"; // and leaves for it, where it cannot be saved either
      link.download = `${name}.avif`;
    }
    link.click();
  };

  const [around, swipe] = [".mkt-shown", ".mkt-swipe"].map((name) =>
    panel.querySelector(name),
  );
  const tell = () => (swipe.hidden = around.scrollWidth <= around.clientWidth);
  new ResizeObserver(tell).observe(around);

  for (const control of controls)
    control.addEventListener("input", () => show(control));
  panel.querySelector(".mkt-reset")?.addEventListener("click", () => show());
  const button = panel.querySelector(".mkt-save");
  button.hidden = false; // without this script it could do nothing
  button.addEventListener("click", save);
  show();
  // Back on the page the browser sets the controls as they were, not the picture.
  addEventListener("pageshow", ({ persisted }) => persisted || show());
}

document.addEventListener("DOMContentLoaded", () => {
  for (const block of document.querySelectorAll("figure.mkt-panel > .mkt-data")) {
    begin(block.parentElement);
  }
});
