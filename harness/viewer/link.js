/* A view as a link, and back: #view=scene/model/tracer&mode=relative&x=12&y=30&zoom=4. Lengths are
   in pixels of the images as the tracers made them: links hold in every copy of the report. */
(function (viewer) {
  "use strict";

  const ZOOM = [1, 64];
  const STOPS = [-10, 10];
  const LAYOUTS = ["side", "split", "flip"];

  const clamp = (value, [low, high]) => Math.min(Math.max(value, low), high);
  const short = (value) => String(Number(value.toFixed(2)));

  /** The link of a state, what has its usual value left out. */
  function format(state) {
    const { panel } = state;
    const path = [panel.scene, panel.model, state.a].map(encodeURIComponent).join("/");
    const parts = [`view=${path}`, `mode=${state.mode}`];
    if (state.b !== "truth") parts.push(`b=${encodeURIComponent(state.b)}`);
    parts.push(`x=${short(state.x)}`, `y=${short(state.y)}`, `zoom=${short(state.zoom)}`);
    parts.push(`exposure=${short(state.exposure)}`);
    if (state.finer) parts.push(`finer=${short(state.finer)}`);
    if (state.layout !== "side") parts.push(`layout=${state.layout}`);
    if (state.layout === "split") parts.push(`split=${short(state.split)}`);
    if (state.layout === "flip") parts.push(`shown=${state.shown ? "b" : "a"}`);
    if (state.cursor) {
      parts.push(`at=${state.cursor.x * panel.block},${state.cursor.y * panel.block}`);
    }
    return `#${parts.join("&")}`;
  }

  function decodeParts(text) {
    try {
      return text.split("/").map(decodeURIComponent);
    } catch {
      return [];
    }
  }

  /**
   * What a link says: null if it is none of a view, otherwise `state`, complete but for what it
   * does not name, and `problem`, a sentence where it names what is not here.
   */
  function parse(hash, panels, { elsewhere, full_size: archive }) {
    if (!hash.startsWith("#view=")) return null;
    const pairs = hash.slice(1).split("&").map((part) => {
      const equals = part.indexOf("=");
      return equals < 0 ? [part, ""] : [part.slice(0, equals), part.slice(equals + 1)];
    });
    const given = Object.fromEntries(pairs);
    const [scene, model, tracer] = decodeParts(given.view);
    const panel = panels.get(`${scene}/${model}`);
    if (!panel) {
      const known = elsewhere.some((entry) => entry.scene === scene && entry.model === model);
      const where = known ? `is in ${archive}, not in this page` : "is not here";
      return { problem: `${scene ?? ""} in ${model ?? ""} ${where}.` };
    }
    const state = { panel, layout: "side", shown: 0, cursor: null };
    let problem = "";
    if (panel.names.includes(tracer)) state.a = tracer;
    else if (tracer) problem = `${tracer} has no image of ${scene} in ${model}.`;
    const [other] = decodeParts(given.b ?? "truth");
    if (panel.names.includes(other)) state.b = other;
    else problem = `${other ?? given.b} has no image of ${scene} in ${model}.`;
    state.mode = Object.hasOwn(viewer.MODES, given.mode ?? "") ? given.mode : "image";
    const number = (name, usual, range) => {
      const value = given[name] ? Number(given[name]) : NaN;
      return Number.isFinite(value) ? clamp(value, range) : usual;
    };
    state.x = number("x", panel.width / 2, [0, panel.width]);
    state.y = number("y", panel.height / 2, [0, panel.height]);
    state.zoom = number("zoom", 1, ZOOM);
    state.exposure = number("exposure", 0, STOPS);
    state.finer = number("finer", 0, STOPS);
    state.split = number("split", 0.5, [0, 1]);
    if (LAYOUTS.includes(given.layout)) state.layout = given.layout;
    else if (given.split) state.layout = "split";
    if (given.shown === "b") state.shown = 1;
    const at = given.at ? given.at.split(",") : [given.x, given.y];
    const [x, y] = at.map((text) => Math.floor(Number(text || NaN) / panel.block));
    if (x >= 0 && y >= 0) {
      state.cursor = { x: Math.min(x, panel.columns - 1), y: Math.min(y, panel.rows - 1) };
    }
    return { state, problem };
  }

  viewer.link = { ZOOM, STOPS, LAYOUTS, clamp, format, parse };
})(hasteViewer);
