// Figures open enlarged; folded parts and the film's still are printed.
(function () {
  const large = document.querySelector("dialog"), shown = document.createElement("img");
  large.append(shown);
  for (const button of document.querySelectorAll("button.sheet")) {
    button.addEventListener("click", function () {
      const picture = button.querySelector("img");
      shown.src = picture.src;
      shown.alt = picture.alt;
      large.showModal();
    });
  }
  large.addEventListener("click", function (event) {
    if (event.target === large || event.target.tagName === "IMG") large.close();
  });
  window.addEventListener("beforeprint", function () {
    for (const folded of document.querySelectorAll("details")) folded.open = true;
  });
  const film = document.querySelector("video"), still = document.querySelector("div.print");
  if (film && still) {
    const picture = document.createElement("img");
    picture.src = film.poster;
    picture.alt = still.dataset.alt;
    still.append(picture);
  }
})();
