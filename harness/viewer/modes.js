/* What can stand beside image A: image B, or a map of a mode's values with its scale. */
(function (viewer) {
  "use strict";

  const { errors, colour, flip } = viewer;
  /** A pause in which the page answers. */
  const rest = () => new Promise((resolve) => setTimeout(resolve));
  /** Decades below the upper end that a logarithmic scale shows. */
  const DECADES = 4;
  /** The p-values of the p-map's darkest and brightest colour are 1 and 10^-6. */
  const P_DECADES = 6;

  const log10 = (value) => Math.log10(value);
  const percent = (value) => `${colour.formatNumber(100 * value)} %`;

  /** A logarithmic scale whose upper end is `finer` stops below its limit. */
  function logarithmic(limit, finer) {
    const high = log10(limit) - finer * log10(2);
    return { low: high - DECADES, high };
  }

  /**
   * Modes by name. `own`: A and B each have a map, otherwise A is an image beside the map of A
   * against B. `values(panel, a, b)`: a map on the axis of `scale`, or a promise of
   * it; `scale(panel, finer)`: its ends, which are divided by 2^finer unless `fixed`;
   * `ticks(scale)`: of the colour bar; `format`: a value as people read it.
   */
  const MODES = {
    image: {
      title: "image",
      key: "1",
      own: true,
      about: "radiance, exposed and in sRGB",
    },
    relative: {
      title: "relative error",
      key: "2",
      about: "(A − B) / √(B² + ε) of the luminance; blue: A is darker, red: A is brighter",
      map: "signed",
      values: (panel, a, b) => errors.map(a, (i) => errors.relative(panel, a, b, i)),
      scale: (panel, finer) => {
        const high = panel.limits.relative * 2 ** -finer;
        return { low: -high, high };
      },
      ticks: ({ high }) =>
        [-1, -0.5, 0, 0.5, 1].map((part) => ({ at: part * high, label: percent(part * high) })),
      format: percent,
    },
    squared: {
      title: "squared error",
      key: "3",
      about: "mean over channels of (A − B)² / (B² + ε); its mean over an image is a relMSE",
      map: "magnitude",
      values: (panel, a, b) => errors.map(a, (i) => log10(errors.squared(panel, a, b, i))),
      scale: (panel, finer) => logarithmic(panel.limits.squared, finer),
      ticks: colour.decades,
      format: (value) => colour.formatNumber(value),
    },
    deviation: {
      title: "standard deviation",
      key: "4",
      own: true,
      about: "of the luminance of one sample, in units of radiance",
      map: "magnitude",
      values: (panel, a) => errors.map(a, (i) => log10(errors.deviation(a, i))),
      scale: (panel, finer) => logarithmic(panel.limits.deviation, finer),
      ticks: colour.decades,
      format: (value) => colour.formatNumber(value),
    },
    p: {
      title: "p-map",
      key: "5",
      about: "two-sided p of equal luminances (Welch’s test); bright: A and B differ beyond noise",
      map: "magnitude",
      values: (panel, a, b) => errors.map(a, (i) => -log10(errors.welch(a, b, i).p)),
      fixed: true,
      scale: () => ({ low: 0, high: P_DECADES }),
      ticks: () =>
        [0, 2, 4, 6].map((k) => ({
          at: k,
          label: `${k === P_DECADES ? "≤ " : ""}${colour.formatNumber(10 ** -k, 1)}`,
        })),
      format: (value) => colour.formatNumber(value),
    },
    flip: {
      title: "FLIP",
      key: "6",
      about: "HDR-FLIP, 0: no visible difference, 1: the largest; exposures pinned by the truth",
      map: "magnitude",
      values: (panel, a, b) => flip.hdr(a, b, panel.flip, rest),
      scale: (panel, finer) => ({ low: 0, high: Math.min(2 ** -finer, 1) }),
      ticks: ({ high }) =>
        [0, 0.25, 0.5, 0.75, 1].map((part) => {
          const at = part * high;
          return { at, label: colour.formatNumber(at) };
        }),
      format: (value) => colour.formatNumber(value),
    },
  };

  viewer.MODES = MODES;

  /** Maps that were made, by panel, mode and images: FLIP takes longer than a frame. */
  const made = new Map();
  const KEPT = 64;

  const keyOf = (panel, mode, a, b) =>
    [panel.key, mode, a.name, MODES[mode].own ? "" : b.name].join("\n");

  /** Make what a mode shows of images a and b, where it is not there yet. */
  viewer.makeMap = async function (panel, mode, a, b) {
    if (!MODES[mode].map) return;
    const key = keyOf(panel, mode, a, b);
    // One that is being made is not begun again by every move of the mouse.
    const entry = made.get(key) ?? begin(panel, mode, a, b);
    // Those asked for last are the last to go.
    made.delete(key);
    if (made.size >= KEPT) made.delete(made.keys().next().value);
    made.set(key, entry);
    await entry.done;
  };

  function begin(panel, mode, a, b) {
    const entry = { picture: null };
    const finish = (values) => {
      entry.picture = { width: panel.columns, height: panel.rows, channels: 1, values };
    };
    entry.done = Promise.resolve(MODES[mode].values(panel, a, b)).then(finish);
    return entry;
  }

  /**
   * What a mode shows of images a and b, in the form that painters take: a picture [values by
   * pixel, 3 or 1 of them] and how its values become colours, by a state's `exposure` and `finer`.
   * Maps must have been made.
   */
  viewer.pictureOf = function (panel, mode, a, b, { exposure, finer }) {
    const { map, scale } = MODES[mode];
    if (!map) {
      // Kept on its image, so that painters recognize what they have uploaded.
      a.picture ??= { width: panel.columns, height: panel.rows, channels: 3, values: a.rgb };
      return { picture: a.picture, gain: panel.exposure * 2 ** exposure };
    }
    const { picture } = made.get(keyOf(panel, mode, a, b));
    return { picture, map: viewer.maps[map], scale: scale(panel, finer) };
  };
})(hasteViewer);
