/* The stage: its panes painted, and what lies over them: names, divider, cursor. */
(function (viewer) {
  "use strict";

  const { geometry, MODES } = viewer;
  const MIN_HEIGHT = 220;
  const MAX_HEIGHT = 640;

  /** The name over a pane. */
  function nameOf(state, side) {
    const mode = MODES[state.mode];
    const [letter, name] = side ? ["B", state.b] : ["A", state.a];
    if (!mode.own) return side ? `${mode.title}, A against ${state.b}` : `A: ${name}`;
    return mode.map ? `${letter}: ${name}, ${mode.title}` : `${letter}: ${name}`;
  }

  viewer.makeStage = function (element, overlay) {
    let painter = null;
    let state = null;
    let images = null;

    function useCanvas() {
      painter?.canvas.remove();
      painter = viewer.makeCanvasPainter();
      element.prepend(painter.canvas);
      if (images) paint();
    }

    painter = viewer.makeWebglPainter((event) => {
      event.preventDefault();
      useCanvas();
    });
    if (painter) element.prepend(painter.canvas);
    else useCanvas();

    const ratio = () => window.devicePixelRatio || 1;

    function panes() {
      const { width, height } = painter.canvas;
      return geometry.panesOf(state, width, height, ratio());
    }

    /** As high as its panes need for whole images, within bounds. */
    function fit() {
      const { panel } = state;
      const width = element.clientWidth;
      const proportion = panel.rows / panel.columns;
      const stacked = state.layout === "side" && width < geometry.NARROW;
      const across = state.layout === "side" && !stacked ? width / 2 : width;
      const most = Math.min(MAX_HEIGHT, 0.75 * window.innerHeight) * (stacked ? 2 : 1);
      const wanted = across * proportion * (stacked ? 2 : 1);
      const height = Math.round(Math.max(Math.min(wanted, most), MIN_HEIGHT));
      element.style.height = `${height}px`;
      const size = [Math.round(width * ratio()), Math.round(height * ratio())];
      const { canvas } = painter;
      if (canvas.width !== size[0]) canvas.width = size[0];
      if (canvas.height !== size[1]) canvas.height = size[1];
    }

    function shadeOf(side) {
      const { panel, mode } = state;
      const { a, b } = images;
      if (MODES[mode].own) return viewer.pictureOf(panel, mode, side ? b : a, a, state);
      return viewer.pictureOf(panel, side ? mode : "image", a, b, state);
    }

    /** Show a state and its two images. */
    function paint(newState = state, newImages = images) {
      [state, images] = [newState, newImages];
      // A finger pans what is magnified, and the page otherwise.
      element.classList.toggle("viewer-zoomed", state.zoom > 1);
      fit();
      const { width, height } = painter.canvas;
      const painted = panes().map((pane) => {
        const side = state.held ? 1 - pane.side : pane.side;
        const tables = geometry.tablesOf(state, state.panel, pane.frame, width, height);
        return { ...pane, side, tables, shade: shadeOf(side) };
      });
      painter.paint(painted);
      showNames(painted);
      showDivider();
      showCursor();
    }

    function showNames(painted) {
      overlay.names.forEach((label, index) => {
        const pane = painted[index];
        label.hidden = !pane || pane.clip.width < 40 * ratio();
        if (label.hidden) return;
        const { clip } = pane;
        label.textContent = nameOf(state, pane.side);
        const right = state.layout === "split" && index === 1;
        // In parts of the stage, which is narrower on paper.
        const { width, height } = painter.canvas;
        label.style.top = `${(100 * clip.top) / height}%`;
        label.style.left = right ? "auto" : `${(100 * clip.left) / width}%`;
        label.style.right = right ? "0" : "auto";
        label.style.maxWidth = `${(100 * clip.width) / width}%`;
      });
    }

    function showDivider() {
      overlay.divider.hidden = state.layout !== "split";
      overlay.divider.style.left = `${100 * state.split}%`;
    }

    function showCursor() {
      const shown = state.cursor ? panes() : [];
      overlay.cursors.forEach((box, index) => {
        const pane = shown[index];
        box.hidden = true;
        if (!pane) return;
        const { clip, frame } = pane;
        const { x, y } = state.cursor;
        const corner = geometry.toStage(state, state.panel, frame, x, y);
        const side = geometry.scaleOf(state, state.panel, frame);
        const middle = { x: corner.x + side / 2, y: corner.y + side / 2 };
        if (middle.x < clip.left || middle.x > clip.left + clip.width) return;
        if (middle.y < clip.top || middle.y > clip.top + clip.height) return;
        const length = Math.max(side / ratio(), 5);
        box.hidden = false;
        box.style.left = `${middle.x / ratio() - length / 2}px`;
        box.style.top = `${middle.y / ratio() - length / 2}px`;
        box.style.width = box.style.height = `${length}px`;
      });
    }

    /** The pane under a place of the stage in CSS pixels, and the place in the image. */
    function locate(left, top) {
      const [x, y] = [left * ratio(), top * ratio()];
      const inside = ({ clip }) =>
        x >= clip.left && x < clip.left + clip.width && y >= clip.top && y < clip.top + clip.height;
      const pane = panes().find(inside) ?? panes()[0];
      return { pane, ...geometry.toImage(state, state.panel, pane.frame, x, y) };
    }

    return {
      element,
      paint,
      locate,
      panes,
      ratio,
      get painter() {
        return painter.name;
      },
      get size() {
        return { width: painter.canvas.width, height: painter.canvas.height };
      },
      /** RGBA of the stage from the upper left corner. */
      pixels: () => painter.pixels(),
      scale: (frame) => geometry.scaleOf(state, state.panel, frame),
    };
  };
})(hasteViewer);
