// As much of a browser's page as live figures need to begin in node: elements that keep
// what they are told, and watchers that can be counted.

class Element extends EventTarget {
  constructor(tag) {
    super();
    Object.assign(this, {
      tag,
      children: [],
      style: {},
      attributes: {},
      clientWidth: 0,
    });
    const names = new Set();
    this.classList = {
      add: (name) => names.add(name),
      contains: (name) => names.has(name),
      toggle: (name, on) => (on ? names.add(name) : names.delete(name)),
    };
  }
  setAttribute(name, value) {
    this.attributes[name] = value;
  }
  getAttribute(name) {
    return this.attributes[name] ?? null;
  }
  removeAttribute(name) {
    delete this.attributes[name];
  }
  get textContent() {
    return this.children.map((node) => node.textContent ?? node).join("");
  }
  set textContent(words) {
    this.children = [words];
  }
  append(...nodes) {
    this.children.push(...nodes);
  }
  pause() {}
  prepend(...nodes) {
    this.children.unshift(...nodes);
  }
  // All that is inside, or what has a tag.
  querySelectorAll(tag) {
    const inside = this.children
      .filter((node) => node instanceof Element)
      .flatMap((node) => [node, ...node.querySelectorAll("*")]);
    return tag === "*" ? inside : inside.filter((node) => node.tag === tag);
  }
  querySelector(tag) {
    return this.querySelectorAll(tag)[0] ?? null;
  }
}

class Watcher {
  observe() {}
  disconnect() {}
}

class Helper {
  postMessage() {}
  terminate() {}
}

if (!globalThis.document)
  Object.assign(globalThis, {
    devicePixelRatio: 1,
    document: { createElement: (tag) => new Element(tag), body: new Element("body") },
    matchMedia: () => new EventTarget(),
    MutationObserver: Watcher,
    ResizeObserver: Watcher,
    Worker: Helper,
  });
