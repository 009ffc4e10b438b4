(() => {
  const root = document.documentElement;

  // Dark where the browser is; viser asks this before it draws for the first time.
  const dark = matchMedia("(prefers-color-scheme: dark)");
  window.__VISER_EMBED_CONFIG__ = { darkMode: dark.matches };
  dark.addEventListener("change", () => location.reload());
  if (dark.matches) {  // a line that is black on paper is white here
    const kind = CanvasRenderingContext2D.prototype;
    const own = Object.getOwnPropertyDescriptor(kind, "strokeStyle");
    const set = function (colour) { own.set.call(this, colour === "#000000" ? "#f1f3f5" : colour); };
    Object.defineProperty(kind, "strokeStyle", { ...own, set });
  }

  // viser draws as often as it can. Here it draws 30 times a second at most; where drawing takes long, which it does
  // without a graphics card, it rests as long as it draws: the simulation needs the processor too.
  const QUICK = 30, SHORTEST = 1000 / 30 - 4, LONGEST = 400;
  const frame = window.requestAnimationFrame.bind(window);
  let waiting = new Map(), number = 0, busy = false, drawn = 0, slow = 0, started = 0, rest = 0;
  const draw = (now) => {  // stays busy: what is asked for meanwhile belongs to the next picture
    const due = waiting;
    waiting = new Map();
    for (const callback of due.values()) {
      try { callback(now); } catch (error) { reportError(error); }
    }
    drawn += 1;
    const begun = performance.now();
    frame(() => {
      started = performance.now();
      const spent = started - begun;
      rest = Math.max(SHORTEST - spent, spent > QUICK ? Math.min(spent, LONGEST) : 0);
      if (spent > QUICK) slow += 1;
      busy = false;
      if (waiting.size) ask();
    });
  };
  const ask = () => {
    busy = true;
    const left = started + rest - performance.now();
    left > 1 ? setTimeout(() => frame(draw), left) : frame(draw);
  };
  window.requestAnimationFrame = (callback) => {
    waiting.set(++number, callback);
    if (!busy) ask();
    return number;
  };
  window.cancelAnimationFrame = (which) => waiting.delete(which);

  // Whoever looks is told how often that is, over the scene.
  const told = document.createElement("div");
  told.className = "contarm-drawn";
  const EVERY = 2;
  setInterval(() => {
    const rate = drawn / EVERY, late = slow > 0;
    drawn = slow = 0;
    const picture = document.querySelector("canvas[data-engine]")?.parentElement?.parentElement;
    if (picture && told.parentElement !== picture) picture.append(told);
    told.textContent = rate > 0 && rate < 20 && late
      ? `This browser draws ${rate < 9.5 ? rate.toFixed(1) : rate.toFixed(0)} pictures a second, to leave the processor to the arm.` : "";
  }, 1000 * EVERY);

  // The sheet with the controls on a phone covers nothing of the scene; viser's notice about software says less than
  // the line above.
  const watch = new ResizeObserver((seen) => {
    root.style.setProperty("--sheet", `${seen[seen.length - 1].target.offsetHeight}px`);
  });
  let sheet = null;
  new MutationObserver(() => {
    const found = document.querySelector('[style*="max-height: 60%"]');
    if (found && found !== sheet) {
      watch.disconnect();
      watch.observe((sheet = found));
    }
    for (const notice of document.querySelectorAll(".mantine-Notification-root")) {
      if (notice.textContent.includes("Software WebGL")) notice.querySelector("button")?.click();
    }
  }).observe(root, { childList: true, subtree: true });
})();
