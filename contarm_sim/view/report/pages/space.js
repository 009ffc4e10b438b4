// The interactive view: plotly is unpacked, and drawn in the colours of the scheme.
(async function () {
  const view = document.getElementById("view"), given = JSON.parse(document.getElementById("space").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)"), narrow = window.matchMedia("(max-width: 40rem)");
  const shade = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function set(owner, path, value) {
    const names = path.split("."), last = names.pop();
    names.reduce((inner, name) => (inner[name] = inner[name] || {}), owner)[last] = value;
  }
  function coloured() {
    const shown = structuredClone(given);
    if (dark.matches) {
      shown.dark.forEach((others, i) => Object.entries(others).forEach(([path, value]) => set(shown.data[i], path, value)));
    }
    set(shown.layout, "font", { color: shade("--ink"), family: "system-ui, sans-serif", size: narrow.matches ? 11 : 13 });
    const back = Math.max(1, 1.1 * view.clientHeight / view.clientWidth), eye = shown.layout.scene.camera.eye;
    for (const axis of ["x", "y", "z"]) eye[axis] *= back; // a narrow picture shows as much to the left and right
    for (const axis of ["xaxis", "yaxis", "zaxis"]) {
      set(shown.layout, `scene.${axis}.gridcolor`, shade("--rule"));
      set(shown.layout, `scene.${axis}.zerolinecolor`, shade("--rule"));
      set(shown.layout, `scene.${axis}.color`, shade("--soft"));
    }
    return shown;
  }

  try {
    const packed = Uint8Array.from(atob(document.getElementById("plotly").textContent), (letter) => letter.charCodeAt(0));
    const library = document.createElement("script");
    library.textContent = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
    document.head.append(library);
    view.replaceChildren();
    const draw = function () {
      const shown = coloured();
      return Plotly.react(view, shown.data, shown.layout, { responsive: true, displaylogo: false });
    };
    await draw();
    dark.addEventListener("change", draw);
  } catch (error) {
    view.textContent = "This browser cannot show the view: " + error.message + ". The figures below need nothing.";
  }
})();
