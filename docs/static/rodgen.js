// What scrolls can be reached by the keyboard, and pictures of the gallery say where they lead.
document.addEventListener("DOMContentLoaded", () => {
  for (const one of document.querySelectorAll("pre, .math-wrapper")) one.tabIndex = 0;
  for (const link of document.querySelectorAll(".sphx-glr-thumbcontainer a"))
    link.setAttribute("aria-label", link.textContent.trim());
});
