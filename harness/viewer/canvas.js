/* Painter without WebGL: the same pixels, one after the other. */
(function (viewer) {
  "use strict";

  const { colour } = viewer;

  /** Whether a value has no colour: no number, or, of radiance, not finite. */
  viewer.isBroken = (value, channels) =>
    channels === 1 ? Number.isNaN(value) : !Number.isFinite(value);

  /** Colours of a picture's pixels, RGBA bytes in one number each, as an ImageData has them. */
  function colourPicture({ picture, gain, map, scale }) {
    const { width, height, channels, values } = picture;
    const bytes = new Uint8ClampedArray(4 * width * height);
    for (let i = 0; i < width * height; i++) {
      let broken = false;
      for (let c = 0; c < channels; c++) {
        broken ||= viewer.isBroken(values[channels * i + c], channels);
      }
      const entry = map && !broken ? colour.entryOf(values[i], scale) : 0;
      for (let c = 0; c < 3; c++) {
        if (broken) bytes[4 * i + c] = colour.BROKEN[c];
        else if (map) bytes[4 * i + c] = map[3 * entry + c];
        else {
          const linear = Math.min(Math.max(gain * values[3 * i + c], 0), 1);
          bytes[4 * i + c] = Math.floor(255 * colour.encodeSrgb(linear) + 0.5);
        }
      }
      bytes[4 * i + 3] = 255;
    }
    return new Uint32Array(bytes.buffer);
  }

  viewer.makeCanvasPainter = function () {
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("2d", { willReadFrequently: true });
    // The last colours of each side: panning does not change them.
    const kept = new Map();

    function coloursOf(side, shade) {
      const { picture, gain, map, scale } = shade;
      const key = [gain, scale?.low, scale?.high].join();
      const last = kept.get(side);
      if (last && last.picture === picture && last.map === map && last.key === key) {
        return last.colours;
      }
      const colours = colourPicture(shade);
      kept.set(side, { picture, map, key, colours });
      return colours;
    }

    return {
      name: "canvas",
      canvas,
      paint(panes) {
        const { width, height } = canvas;
        const image = context.createImageData(width, height);
        const stage = new Uint32Array(image.data.buffer);
        for (const { clip, side, tables, shade } of panes) {
          const colours = coloursOf(side, shade);
          const { columns, rows } = tables;
          for (let y = clip.top; y < clip.top + clip.height; y++) {
            if (rows[y] < 0) continue;
            const from = rows[y] * shade.picture.width;
            for (let x = clip.left; x < clip.left + clip.width; x++) {
              if (columns[x] >= 0) stage[y * width + x] = colours[from + columns[x]];
            }
          }
        }
        context.putImageData(image, 0, 0);
      },
      /** RGBA from the upper left corner. */
      pixels() {
        const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
        return new Uint8Array(data.buffer);
      },
    };
  };
})(hasteViewer);
