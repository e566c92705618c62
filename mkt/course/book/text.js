// What the text of a page needs: a button on each cell of code that copies it, a word
// under what is wider than the page, and its own line of the contents in view.

const COPY = "copy";
const WIDE = ".mkt-scroll, .mkt-formula, .cell_output, .table-wrapper";

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
  const see = () => (note.hidden = place.scrollWidth <= place.clientWidth + 1);
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

document.addEventListener("DOMContentLoaded", () => {
  showsItsLine();
  for (const block of document.querySelectorAll(".cell_input .highlight"))
    copies(block);
  document.querySelectorAll(WIDE).forEach(tellsItsWidth);
});
