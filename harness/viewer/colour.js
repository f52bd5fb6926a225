/* Colours of values: sRGB of exposed radiance, and maps of errors with their scales. */
(function (viewer) {
  "use strict";

  /** Entries of a colour map once interpolated: neighbours differ by less than an 8-bit level. */
  const STEPS = 2048;
  /** What is no number, in every mode. */
  const BROKEN = [255, 0, 255];

  /** Linear Rec. 709 in [0, 1] to sRGB in [0, 1] (IEC 61966-2-1). */
  function encodeSrgb(value) {
    return value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
  }

  /** A colour map of STEPS entries, three bytes each, from one in hexadecimal. */
  function readMap(hexadecimal) {
    const given = hexadecimal.match(/../g).map((byte) => parseInt(byte, 16));
    const entries = given.length / 3;
    const map = new Uint8Array(3 * STEPS);
    for (let i = 0; i < STEPS; i++) {
      const place = (i * (entries - 1)) / (STEPS - 1);
      const left = Math.min(Math.floor(place), entries - 2);
      for (let c = 0; c < 3; c++) {
        const [a, b] = [given[3 * left + c], given[3 * left + 3 + c]];
        map[3 * i + c] = Math.round(a + (place - left) * (b - a));
      }
    }
    return map;
  }

  /** Entry of a colour map for a value on a scale from `low` to `high`. */
  function entryOf(value, { low, high }) {
    const position = Math.min(Math.max((value - low) / (high - low), 0), 1);
    return Math.floor(position * (STEPS - 1) + 0.5);
  }

  /** A number for people: a real minus sign, powers of ten where they are shorter. */
  function formatNumber(value, digits = 3, zeros = false) {
    if (Number.isNaN(value)) return "not known";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    const size = Math.abs(value);
    const text =
      size !== 0 && (size < 1e-3 || size >= 1e6)
        ? value.toExponential(digits - 1).replace("e+", "e")
        : zeros
          ? value.toPrecision(digits)
          : String(Number(value.toPrecision(digits)));
    return text.replaceAll("-", "−");
  }

  /** Ticks of a scale of decimal logarithms: every decade, or every other one of many. */
  function decades({ low, high }) {
    const ticks = [];
    const step = high - low > 4.5 ? 2 : 1;
    for (let k = Math.ceil(low - 1e-9); k <= high + 1e-9; k += step) {
      ticks.push({ at: k, label: formatNumber(10 ** k, 1) });
    }
    return ticks;
  }

  viewer.colour = { STEPS, BROKEN, encodeSrgb, readMap, entryOf, formatNumber, decades };
})(hasteViewer);
