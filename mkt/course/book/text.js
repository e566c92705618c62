// What the text of a page needs: a button on each cell of code that copies it, a word
// under what is wider than the page, its own line of the contents in view, and keys for
// the theme's two lists.

const COPY = "copy";
const WIDE = ".mkt-scroll, .mkt-formula, .cell_output, .table-wrapper";
// The lists at the sides: the box that opens each on a narrow screen, and its name.
const LISTS = {
  ".sidebar-drawer": ["__navigation", "Pages"],
  ".toc-drawer": ["__toc", "On this page"],
};

function copies(block) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "mkt-copy";
  const says = (words) => (button.textContent = words);
  says(COPY);
  button.setAttribute("aria-live", "polite"); // or what it says then is not read out
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(block.querySelector("pre").textContent);
      says("copied");
    } catch {
      getSelection().selectAllChildren(block.querySelector("pre"));
      says("selected"); // to be copied by hand
    }
    setTimeout(says, 2000, COPY);
  });
  block.append(button);
}

function tellsItsWidth(place) {
  if (getComputedStyle(place).overflowX === "visible") return;
  const note = document.createElement("p");
  note.className = "mkt-more";
  note.textContent = "Wider than the page: move it sideways.";
  const reached = place.hasAttribute("tabindex");
  const see = () => {
    note.hidden = place.scrollWidth <= place.clientWidth + 1;
    if (reached) return;
    if (note.hidden) place.removeAttribute("tabindex");
    else place.tabIndex = 0; // or no key could move it
  };
  place.after(note);
  see();
  new ResizeObserver(see).observe(place);
}

function showsItsLine() {
  const list = document.querySelector(".sidebar-scroll");
  const line = list?.querySelector(".current-page");
  if (!line) return;
  const [end, here] = [list, line].map((one) => one.getBoundingClientRect().bottom);
  if (here > end) list.scrollTop += here - end + list.clientHeight / 2;
}

// On a narrow screen the theme opens a list by a label alone, which no key reaches.
function opensByKeys([list, [id, name]]) {
  document.querySelector(list)?.setAttribute("aria-label", name);
  const box = document.getElementById(id);
  const labels = document.querySelectorAll(`label[for=${id}]:not(.overlay)`);
  const tell = () => {
    for (const label of labels) label.setAttribute("aria-expanded", box.checked);
  };
  for (const label of labels) {
    label.tabIndex = 0;
    label.setAttribute("role", "button");
    label.setAttribute("aria-label", name);
    label.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      label.click();
    });
  }
  box?.addEventListener("change", tell);
  addEventListener("keydown", ({ key }) => {
    if (key === "Escape" && box?.checked) box.click();
  });
  if (box) tell();
}

document.addEventListener("DOMContentLoaded", () => {
  showsItsLine();
  Object.entries(LISTS).forEach(opensByKeys);
  for (const block of document.querySelectorAll(".cell_input .highlight"))
    copies(block);
  document.querySelectorAll(WIDE).forEach(tellsItsWidth);
});
