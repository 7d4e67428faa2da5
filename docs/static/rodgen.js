// What scrolls can be reached by the keyboard, and pictures of the gallery say where they lead.
document.addEventListener("DOMContentLoaded", () => {
  for (const one of document.querySelectorAll("pre, .math-wrapper")) one.tabIndex = 0;
  for (const link of document.querySelectorAll(".sphx-glr-thumbcontainer a"))
    link.setAttribute("aria-label", link.textContent.trim());
  // Lines of a signature are definitions without terms, which they only look like.
  for (const one of document.querySelectorAll(".sig > dl, .sig > dl > dd")) one.role = "presentation";
  // Films stop and go on by their button. Who wants less motion starts them by hand.
  for (const button of document.querySelectorAll(".rodgen-film button")) {
    const film = button.parentElement.querySelector("video");
    const show = () => (button.textContent = film.paused ? "play" : "pause");
    film.onplay = film.onpause = show;
    button.onclick = () => (film.paused ? film.play() : film.pause());
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) film.pause();
    show();
  }
  // From the file system no page can read another: results of a search have no excerpts there.
  if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
});
