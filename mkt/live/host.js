// What stands round live figures: a page of the book, or, where widget.js has put
// itself in its place, a cell of JupyterLab.

const AT_ONCE = 1000; // [ms]
const HERE = document.currentScript?.src;

export const host = {
  // The data of a figure, from a script beside this one: pages on a disk may not fetch.
  load(name) {
    const known = (globalThis.mktData ??= {});
    return new Promise((resolve, reject) => {
      if (known[name]) return resolve(known[name]);
      const script = document.createElement("script");
      script.src = new URL(`live/${name}.js`, HERE).href;
      script.onload = () => resolve(known[name]);
      script.onerror = () =>
        reject(new Error(`${script.src} is missing: build the book anew`));
      document.head.append(script);
    });
  },
  // What the page's address asks of a figure, "name=value&...", or null.  Who goes back
  // asks for all figures as they were: the address has one of them, its entry in the
  // browser's history has all that were moved.
  asked(key, again) {
    const [mine, words = ""] = location.hash.split("?");
    if (mine === `#${key}`) return words;
    const { moved = again && !location.hash && {} } = history.state ?? {};
    return moved ? (moved[key] ?? "") : null;
  },
  // Call `again` when it asks for something else, until what is returned is called.
  heard(again) {
    const turned = () => {
      this.carry();
      again();
    };
    addEventListener("hashchange", turned);
    return () => removeEventListener("hashchange", turned);
  },
  // A link within the page, such as a heading's, makes an entry without state: what was
  // moved goes on to it, or a reload would forget it.
  carry() {
    if (!history.state && this.moved && location.hash)
      history.replaceState({ moved: this.moved }, "");
    this.moved = history.state?.moved;
  },
  moved: globalThis.history?.state?.moved, // outside a browser there is none
  // Have it carry the settings of a figure, "name=value&...".  Moves that follow one
  // another at once are one step back.
  keep(key, words) {
    const mine = location.hash.split("?")[0] === `#${key}`;
    const { moved = {} } = history.state ?? {};
    if (this.link(key, words) === location.href) return;
    if (!mine && !words && !moved[key]) return;
    const now = performance.now();
    const on = mine && now - this.kept < AT_ONCE;
    if (!history.state) history.replaceState({ moved }, "");
    const state = { moved: { ...moved, [key]: words } };
    history[on ? "replaceState" : "pushState"](state, "", this.link(key, words));
    this.moved = state.moved;
    this.kept = now;
  },
  link: (key, words) => `${location.href.split("#")[0]}#${key}${words && "?"}${words}`,
};

export const load = (name) => host.load(name);

// The trackers beside the page.  WORKER is the worker's text: pages on a disk may start
// one only from a text that they hold.
export function worker() {
  const text = new Blob([WORKER], { type: "text/javascript" });
  return new Worker(URL.createObjectURL(text));
}
