/* Which pixel of the images is seen where on the stage: panes, pan and zoom. */
(function (viewer) {
  "use strict";

  /** Narrower stages, in CSS pixels, have their panes one above the other. */
  const NARROW = 560;
  const GAP = 6;

  /**
   * Panes of a stage of device pixels: `frame`, in which the view is centred, `clip`, the part
   * of it that is seen, and `side`, 0 for A and 1 for B or the map. Rectangles: left, top, width,
   * height.
   */
  function panesOf(state, width, height, ratio) {
    const whole = { left: 0, top: 0, width, height };
    if (state.layout === "flip") return [{ frame: whole, clip: whole, side: state.shown }];
    if (state.layout === "split") {
      const edge = Math.round(state.split * width);
      return [
        { frame: whole, clip: { ...whole, width: edge }, side: 0 },
        { frame: whole, clip: { ...whole, left: edge, width: width - edge }, side: 1 },
      ];
    }
    const gap = Math.round(GAP * ratio);
    const stacked = width / ratio < NARROW;
    const length = Math.floor(((stacked ? height : width) - gap) / 2);
    return [0, 1].map((side) => {
      const start = side * (length + gap);
      const frame = stacked
        ? { left: 0, top: start, width, height: length }
        : { left: start, top: 0, width: length, height };
      return { frame, clip: frame, side };
    });
  }

  /** Device pixels of a pixel of the images. */
  function scaleOf(state, panel, frame) {
    return state.zoom * Math.min(frame.width / panel.columns, frame.height / panel.rows);
  }

  /** Place on the stage (device pixels) -> place in an image (its pixels), within a pane. */
  function toImage(state, panel, frame, x, y) {
    const scale = scaleOf(state, panel, frame);
    return {
      x: state.x / panel.block + (x - frame.left - frame.width / 2) / scale,
      y: state.y / panel.block + (y - frame.top - frame.height / 2) / scale,
    };
  }

  /** Place in an image -> place on the stage. */
  function toStage(state, panel, frame, x, y) {
    const scale = scaleOf(state, panel, frame);
    return {
      x: frame.left + frame.width / 2 + (x - state.x / panel.block) * scale,
      y: frame.top + frame.height / 2 + (y - state.y / panel.block) * scale,
    };
  }

  /** Column of the image in each column of the stage, and row in each row; -1 outside of it. */
  function tablesOf(state, panel, frame, width, height) {
    const pixel = (value, count) => (value >= 0 && value < count ? Math.floor(value) : -1);
    const at = (x, y) => toImage(state, panel, frame, x + 0.5, y + 0.5);
    return {
      columns: Int16Array.from({ length: width }, (_, x) => pixel(at(x, 0).x, panel.columns)),
      rows: Int16Array.from({ length: height }, (_, y) => pixel(at(0, y).y, panel.rows)),
    };
  }

  viewer.geometry = { NARROW, panesOf, scaleOf, toImage, toStage, tablesOf };
})(hasteViewer);
