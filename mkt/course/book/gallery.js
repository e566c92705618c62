// The picture of a card under the mouse, or with the focus, shows what its first slider
// does.

const PAUSE = 700; // [ms]

function plays(picture) {
  const still = picture.src;
  const card = picture.closest(".mkt-card");
  let timer;
  const stop = () => {
    clearInterval(timer);
    picture.src = still;
  };
  const start = () => {
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    const others = picture.dataset.moves.split(" ").map((src) => {
      const other = new Image();
      other.src = src;
      return other;
    });
    clearInterval(timer);
    timer = setInterval(() => {
      others.push(others.shift());
      if (others.at(-1).complete) picture.src = others.at(-1).src;
    }, PAUSE);
  };
  for (const [begin, end] of [
    ["mouseenter", "mouseleave"],
    ["focusin", "focusout"],
  ]) {
    card.addEventListener(begin, start);
    card.addEventListener(end, stop);
  }
}

document.addEventListener("DOMContentLoaded", () => {
  document.querySelectorAll("img[data-moves]").forEach(plays);
});
