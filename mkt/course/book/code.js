// A button on each cell of code that copies it.

function copies(block) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "mkt-copy";
  button.textContent = "copy";
  button.setAttribute("aria-label", "copy this code");
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(block.querySelector("pre").textContent);
      button.textContent = "copied";
    } catch {
      getSelection().selectAllChildren(block.querySelector("pre"));
      button.textContent = "selected"; // to be copied by hand
    }
  });
  block.append(button);
}

document.addEventListener("DOMContentLoaded", () => {
  for (const block of document.querySelectorAll(".cell_input .highlight"))
    copies(block);
});
