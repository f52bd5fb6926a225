/* Mouse, pen and fingers on the stage: the cursor, pan, zoom, pinch and the divider. */
(function (viewer) {
  "use strict";

  /** Reach of the divider in CSS pixels. */
  const REACH = 12;
  /** A wheel's notch of 100 zooms by this factor. */
  const NOTCH = 1.25;

  viewer.listenToPointer = function (app, stage) {
    const { element } = stage;
    /** Pointers that are down, by their ids: places in CSS pixels of the stage. */
    const down = new Map();
    let drags = null;

    const place = (event) => {
      const box = element.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };

    function nearDivider({ x }) {
      const { layout, split } = app.state;
      return layout === "split" && Math.abs(x - split * element.clientWidth) < REACH;
    }

    function pointAt({ x, y }) {
      const { panel } = app.state;
      const found = stage.locate(x, y);
      const inside =
        found.x >= 0 && found.y >= 0 && found.x < panel.columns && found.y < panel.rows;
      if (inside) app.point({ x: Math.floor(found.x), y: Math.floor(found.y) });
    }

    /** Zoom by a factor; what was at `from` is then at `to`. */
    function zoomAt(from, to, factor) {
      const { state } = app;
      const before = stage.locate(from.x, from.y);
      const { frame } = before.pane;
      const zoom = viewer.link.clamp(state.zoom * factor, viewer.link.ZOOM);
      const scale = (stage.scale(frame) * zoom) / state.zoom;
      const { block } = state.panel;
      const ratio = stage.ratio();
      app.change({
        zoom,
        x: block * (before.x - (to.x * ratio - frame.left - frame.width / 2) / scale),
        y: block * (before.y - (to.y * ratio - frame.top - frame.height / 2) / scale),
      });
    }

    const middle = ([p, q]) => ({ x: (p.x + q.x) / 2, y: (p.y + q.y) / 2 });
    const span = ([p, q]) => Math.max(Math.hypot(p.x - q.x, p.y - q.y), 1);

    element.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "mouse" && event.button !== 0) return;
      const at = place(event);
      down.set(event.pointerId, at);
      element.setPointerCapture(event.pointerId);
      drags = nearDivider(at) ? "divider" : "view";
      if (event.pointerType !== "mouse") pointAt(at);
    });

    element.addEventListener("pointermove", (event) => {
      const at = place(event);
      if (!down.has(event.pointerId)) {
        element.style.cursor = nearDivider(at) ? "col-resize" : "";
        if (event.pointerType === "mouse") pointAt(at);
        return;
      }
      const before = [...down.values()];
      const last = down.get(event.pointerId);
      down.set(event.pointerId, at);
      if (before.length === 2) {
        const after = [...down.values()];
        zoomAt(middle(before), middle(after), span(after) / span(before));
      } else if (drags === "divider") {
        app.change({ split: viewer.link.clamp(at.x / element.clientWidth, [0, 1]) });
      } else if (before.length === 1) {
        zoomAt(last, at, 1);
      }
    });

    for (const name of ["pointerup", "pointercancel"]) {
      element.addEventListener(name, (event) => down.delete(event.pointerId));
    }

    element.addEventListener("dblclick", () => app.fit());

    element.addEventListener(
      "wheel",
      (event) => {
        // Otherwise nobody could scroll past the stage.
        if (!event.ctrlKey && document.activeElement !== element) return;
        event.preventDefault();
        const at = place(event);
        zoomAt(at, at, NOTCH ** (-event.deltaY / 100));
      },
      { passive: false }
    );
  };
})(hasteViewer);
