/* What the pixel under the cursor has, and the colour bar. */
(function (viewer) {
  "use strict";

  const { errors, colour, MODES } = viewer;
  /** Decimal digits that tell every half float from its neighbours. */
  const DIGITS = 5;
  const NOWHERE = "No pixel chosen: point at one, or use the arrow keys on the pictures";

  const exact = (value) => colour.formatNumber(value, DIGITS, true);

  /** Texts of the read-out of pixel i, by the name of their cell. */
  function describe(panel, a, b, i) {
    const cells = {};
    for (const [letter, image] of [["a", a], ["b", b]]) {
      cells[`${letter}-name`] = image.name;
      ["red", "green", "blue"].forEach((name, c) => {
        cells[`${letter}-${name}`] = exact(image.rgb[3 * i + c]);
      });
      cells[`${letter}-luminance`] = exact(errors.luminance(image, i));
      cells[`${letter}-sigma`] = exact(image.sigma[i]);
    }
    const { z, p } = errors.welch(a, b, i);
    cells.relative = MODES.relative.format(errors.relative(panel, a, b, i));
    cells.squared = MODES.squared.format(errors.squared(panel, a, b, i));
    cells.z = colour.formatNumber(z);
    cells.p = colour.formatNumber(p);
    return cells;
  }

  viewer.makeReadout = function (root) {
    const cells = new Map(
      [...root.querySelectorAll("[data-cell]")].map((cell) => [cell.dataset.cell, cell])
    );
    const place = root.querySelector(".viewer-place");
    const status = root.querySelector(".viewer-status");
    const bar = root.querySelector(".viewer-bar");
    let announcing = 0;

    function show(state, images) {
      const { panel, cursor } = state;
      const texts = cursor
        ? describe(panel, images.a, images.b, cursor.y * panel.columns + cursor.x)
        : { "a-name": state.a, "b-name": state.b };
      for (const [name, cell] of cells) {
        const text = texts[name] ?? "";
        if (cell.textContent !== text) cell.textContent = text;
      }
      cells.get("flip").textContent = flipOf(state, images);
      place.textContent = cursor ? placeOf(panel, cursor) : NOWHERE;
      showBar(state);
    }

    /** FLIP needs the whole image: it is known where the mode shows it. */
    function flipOf(state, { a, b }) {
      const { panel, mode, cursor } = state;
      if (mode !== "flip" || !cursor) return "";
      const { values } = viewer.pictureOf(panel, mode, a, b, state).picture;
      return colour.formatNumber(values[cursor.y * panel.columns + cursor.x]);
    }

    function placeOf({ block }, { x, y }) {
      if (block === 1) return `Pixel x = ${x}, y = ${y}`;
      return `Mean of ${block} × ${block} pixels from x = ${x * block}, y = ${y * block}`;
    }

    /** Say the pixel's values to those who do not see them, once the cursor rests. */
    function announce(state, images) {
      clearTimeout(announcing);
      announcing = setTimeout(() => {
        const { panel, cursor } = state;
        if (!cursor) return;
        const texts = describe(panel, images.a, images.b, cursor.y * panel.columns + cursor.x);
        status.textContent =
          `${placeOf(panel, cursor)}: luminance of A ${texts["a-luminance"]}, ` +
          `of B ${texts["b-luminance"]}; relative error ${texts.relative}; z ${texts.z}`;
      }, 300);
    }

    function showBar(state) {
      const mode = MODES[state.mode];
      bar.querySelector(".viewer-about").textContent = mode.about;
      const strip = bar.querySelector("canvas");
      const ticks = bar.querySelector(".viewer-ticks");
      strip.hidden = ticks.hidden = !mode.map;
      ticks.replaceChildren();
      if (!mode.map) return;
      paintStrip(strip, viewer.maps[mode.map]);
      const scale = mode.scale(state.panel, state.finer);
      for (const { at, label } of mode.ticks(scale)) {
        const tick = document.createElement("span");
        const part = (at - scale.low) / (scale.high - scale.low);
        tick.textContent = label;
        tick.style.left = `${100 * part}%`;
        // Labels at the ends stay within the bar.
        tick.style.transform = `translateX(${-100 * part}%)`;
        ticks.append(tick);
      }
    }

    return { show, announce };
  };

  function paintStrip(strip, map) {
    strip.width = colour.STEPS;
    strip.height = 1;
    const context = strip.getContext("2d");
    const image = context.createImageData(colour.STEPS, 1);
    for (let i = 0; i < colour.STEPS; i++) {
      image.data.set([map[3 * i], map[3 * i + 1], map[3 * i + 2], 255], 4 * i);
    }
    context.putImageData(image, 0, 0);
  }
})(hasteViewer);
