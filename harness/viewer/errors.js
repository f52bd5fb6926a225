/* Errors of one image against another, pixel by pixel, in double precision from the half floats. */
(function (viewer) {
  "use strict";

  /** Relative difference that rounding two values to half floats may leave between equal ones. */
  const ROUNDING = 2 ** -10;
  /** Values on each side from which Welch's degrees of freedom hold, as in harness/statistics. */
  const WELCH_COUNT = 16;
  /** A variance below this part of the mean is the rounding of equal values. */
  const CERTAIN = 2 ** -48;

  function luminance(image, i) {
    const [red, green, blue] = viewer.luminanceWeights;
    return red * image.rgb[3 * i] + green * image.rgb[3 * i + 1] + blue * image.rgb[3 * i + 2];
  }

  /** Signed relative error of the luminance: (x - r) / sqrt(r^2 + epsilon). */
  function relative(panel, first, second, i) {
    const reference = luminance(second, i);
    return (luminance(first, i) - reference) / Math.sqrt(reference ** 2 + panel.epsilon);
  }

  /** Squared relative error, the mean over channels of (x - r)^2 / (r^2 + epsilon). */
  function squared(panel, first, second, i) {
    let sum = 0;
    for (let c = 3 * i; c < 3 * i + 3; c++) {
      sum += (first.rgb[c] - second.rgb[c]) ** 2 / (second.rgb[c] ** 2 + panel.epsilon);
    }
    return sum / 3;
  }

  /** Standard deviation of the luminance of one sample, from the standard error of the mean. */
  function deviation(image, i) {
    return image.sigma[i] * Math.sqrt(image.count * image.spp);
  }

  /** Degrees of freedom where `share` of the squared standard error comes from the first image. */
  function degreesOf(share, first, second) {
    const fewer = Math.min(first, second);
    if (fewer < WELCH_COUNT) return fewer - 1;
    return 1 / (share ** 2 / (first - 1) + (1 - share) ** 2 / (second - 1));
  }

  /** Welch's statistic z of equal luminances, less what half floats lose, and its two-sided p. */
  function welch(first, second, i) {
    const x = luminance(first, i);
    const r = luminance(second, i);
    if (!Number.isFinite(x) || !Number.isFinite(r)) return { z: NaN, p: 0 };
    const scale = Math.max(Math.abs(x), Math.abs(r));
    const excess = Math.max(Math.abs(x - r) - ROUNDING * scale, 0);
    const sign = x < r ? -1 : 1;
    const own = first.sigma[i] ** 2;
    const total = own + second.sigma[i] ** 2;
    if (Number.isNaN(total)) return { z: NaN, p: NaN };
    if (!(total > (CERTAIN * scale) ** 2)) {
      return excess > 0 ? { z: sign * Infinity, p: 0 } : { z: 0, p: 1 };
    }
    const z = (sign * excess) / Math.sqrt(total);
    return { z, p: viewer.studentP(z, degreesOf(own / total, first.count, second.count)) };
  }

  /** A map of n values, the function of each pixel. */
  function map(image, value) {
    const values = new Float32Array(image.width * image.height);
    for (let i = 0; i < values.length; i++) values[i] = value(i);
    return values;
  }

  viewer.errors = { luminance, relative, squared, deviation, welch, map };
})(hasteViewer);
