// A live figure in a cell of JupyterLab: what anywidget runs in the browser.

import { LIVE } from "./figures.js";
import { host } from "./host.js";
import { complain, el, leave } from "./page.js";

// The kernel in the place of the page: it makes the data, and hears what is moved.
function kernel(model) {
  const known = new Map(Object.entries(model.get("first")));
  const waiting = new Map();
  // Answers come to each browser, whichever has asked.
  model.on("msg:custom", ({ name, data, error }) => {
    if (error) {
      waiting.get(name)?.reject(new Error(error));
      known.delete(name); // to be asked for again
    } else waiting.get(name)?.resolve(data);
  });
  return {
    async load(name) {
      if (!known.has(name)) {
        const answer = (resolve, reject) => waiting.set(name, { resolve, reject });
        known.set(name, new Promise(answer));
        try {
          model.send({ name });
        } catch {
          known.delete(name); // to be asked for again
          throw new Error("its kernel has gone; run the cell again");
        }
      }
      return known.get(name);
    },
    // A further view, and other cells, show what was moved in one.
    asked: () => new URLSearchParams(model.get("moved")).toString() || null,
    heard(again) {
      model.on("change:moved", again);
      return () => model.off("change:moved", again);
    },
    keep(_key, _words, values) {
      // Values of its own: a model hears of no change inside an object that it has.
      model.set("moved", { ...values });
      model.save_changes();
    },
    link: null,
  };
}

// Once for a figure, in however many cells it is shown; a module is of one figure.
export function initialize({ model }) {
  Object.assign(host, kernel(model));
}

// A cell's view; what is returned ends it.
export function render({ model, el: cell }) {
  const name = model.get("name");
  const id = name.replace(".", "-"); // which a saved picture has as its name
  const words = el("figcaption");
  words.innerHTML = model.get("caption");
  const save = el(
    "button",
    { type: "button", class: "mkt-save" },
    "picture of what is shown",
  );
  const files = el("p", { class: "mkt-note mkt-files" }, save);
  const panel = el("figure", { class: "mkt-panel mkt-soon", id }, files, words);
  // Keys belong to what has the focus, not to JupyterLab's shortcuts, which look for
  // this on the element itself first.
  const own = ({ target }) => target.setAttribute("data-lm-suppress-shortcuts", "true");
  cell.append(el("div", { class: "mkt-cell", onfocusin: own }, panel));
  const begun = LIVE[name](panel, name).catch(complain(panel));
  const end = () => leave(panel);
  return () => {
    end();
    begun.then(end); // of a view that goes while it begins
  };
}
