/* Keys of the viewer, which hold while the focus is within it, and the overlay that lists them. */
(function (viewer) {
  "use strict";

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const LEAP = 8;
  const ZOOM_STEP = Math.SQRT2;
  const SPLIT_STEP = 0.05;
  const STOPS_STEP = 0.5;

  /** Keys in the order of the overlay: how they are called, what they do, and do it. */
  const KEYS = [
    ["n", "next scene (Shift: previous)", (app, back) => app.stepScene(back ? -1 : 1)],
    ["m", "next model (Shift: previous)", (app, back) => app.stepModel(back ? -1 : 1)],
    ["a", "next image A (Shift: previous)", (app, back) => app.stepImage("a", back ? -1 : 1)],
    ["b", "next image B (Shift: previous)", (app, back) => app.stepImage("b", back ? -1 : 1)],
    ...Object.entries(viewer.MODES).map(([mode, { key, title }]) => [
      key,
      title,
      (app) => app.change({ mode }),
    ]),
    ["v", "panes side by side, split, or flipping", (app) => app.stepLayout()],
    ["f", "flip to the other side", (app) => app.flip()],
    ["[", "divider to the left", (app) => app.moveDivider(-SPLIT_STEP)],
    ["]", "divider to the right", (app) => app.moveDivider(SPLIT_STEP)],
    ["+", "zoom in at the cursor", (app) => app.zoomBy(ZOOM_STEP)],
    ["-", "zoom out", (app) => app.zoomBy(1 / ZOOM_STEP)],
    ["0", "whole image", (app) => app.fit()],
    ["c", "centre the view on the cursor", (app) => app.centre()],
    ["w", "go to the worst pixel: the largest value of the map", (app) => app.findLargest()],
    ["e", "images half a stop brighter (Shift: darker)", (app, back) =>
      app.expose(app.state.exposure + (back ? -STOPS_STEP : STOPS_STEP))],
    ["s", "scale of a map half a stop finer (Shift: coarser)", (app, back) =>
      app.refine(app.state.finer + (back ? -STOPS_STEP : STOPS_STEP))],
    ["r", "exposure and scale of 0 stops", (app) => app.change({ exposure: 0, finer: 0 })],
    ["l", "copy a link to this view", (app) => app.copyLink()],
    ["?", "this list", (app) => app.showHelp()],
  ];

  const SHIFTED = new Set(["n", "m", "a", "b", "e", "s"]);
  const ALIASES = { "=": "+", "–": "-", "−": "-" };

  viewer.listenToKeyboard = function (app, root, stage) {
    root.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target.closest("select, input, dialog")) return;
      if (event.target === stage.element && event.key in ARROWS) {
        const [x, y] = ARROWS[event.key].map((step) => step * (event.shiftKey ? LEAP : 1));
        app.moveCursor(x, y);
        event.preventDefault();
        return;
      }
      if (event.target === stage.element && event.key === " ") {
        app.hold(true);
        event.preventDefault();
        return;
      }
      const small = event.key.toLowerCase();
      const name = SHIFTED.has(small) ? small : (ALIASES[event.key] ?? event.key);
      const found = KEYS.find(([key]) => key === name);
      if (!found) return;
      found[2](app, event.shiftKey);
      event.preventDefault();
    });
    root.addEventListener("keyup", (event) => {
      if (event.key === " ") app.hold(false);
    });
    stage.element.addEventListener("blur", () => app.hold(false));

    const list = root.querySelector(".viewer-help dl");
    const always = [
      ["← → ↑ ↓", "move the cursor by a pixel (Shift: by eight), with the focus on the pictures"],
      ["Space", "hold: the other side"],
    ];
    for (const [key, does] of [...always, ...KEYS]) {
      const [term, text] = ["dt", "dd"].map((tag) => document.createElement(tag));
      const cap = document.createElement("kbd");
      cap.textContent = key;
      term.append(cap);
      text.textContent = does;
      list.append(term, text);
    }
  };
})(hasteViewer);
