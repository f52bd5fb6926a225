/* FLIP, a difference as it is seen when two images alternate. Andersson et al. 2020, FLIP: A
   Difference Evaluator for Alternating Images, and 2021, Visualizing Errors in Rendered High
   Dynamic Range Images; constants as there. Images are arrays of three planes. */
(function (viewer) {
  "use strict";

  /** Pixels a degree: 0.7 m from a monitor of 3840 pixels on 0.7 m. */
  const PIXELS_PER_DEGREE = (0.7 * 3840 * Math.PI) / (0.7 * 180);
  /** Contrast sensitivity of Y, Cx, Cz: a and b of Gaussians a sqrt(pi / b) e^(-pi^2 x^2 / b). */
  const SENSITIVITY = [[[1, 0.0047]], [[1, 0.0053]], [[34.1, 0.04], [13.5, 0.025]]];
  const WIDEST = 0.04;
  const COLOUR_EXPONENT = 0.7;
  const KNEE = 0.4;
  const KNEE_VALUE = 0.95;
  /** Width of the edge detector in degrees, and the exponent of the feature difference. */
  const FEATURE_WIDTH = 0.082;
  const FEATURE_EXPONENT = 0.5;
  /** Narkowicz's fit of the ACES tone curve with exposure 0.6. */
  const ACES = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

  const TO_XYZ = [
    [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
    [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
    [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
  ];
  /** D65, the white of that matrix. */
  const WHITE = TO_XYZ.map((row) => row[0] + row[1] + row[2]);
  const FROM_XYZ = invert(TO_XYZ);

  function invert(m) {
    const cofactor = (i, j) => {
      const [a, b] = [(i + 1) % 3, (i + 2) % 3];
      const [c, d] = [(j + 1) % 3, (j + 2) % 3];
      return m[a][c] * m[b][d] - m[a][d] * m[b][c];
    };
    const determinant = [0, 1, 2].reduce((sum, j) => sum + m[0][j] * cofactor(0, j), 0);
    return m.map((_, i) => m.map((_, j) => cofactor(j, i) / determinant));
  }

  /** A matrix times each pixel of three planes. */
  function transform(m, [x, y, z]) {
    return m.map(([a, b, c]) => {
      const result = new Float64Array(x.length);
      for (let i = 0; i < result.length; i++) result[i] = a * x[i] + b * y[i] + c * z[i];
      return result;
    });
  }

  const fromWhite = TO_XYZ.map((row, c) => row.map((value) => value / WHITE[c]));
  const toWhite = FROM_XYZ.map((row) => row.map((value, c) => value * WHITE[c]));

  /** YCxCz of linear RGB. */
  function toOpponent(rgb) {
    const [x, y, z] = transform(fromWhite, rgb);
    for (let i = 0; i < y.length; i++) {
      const whiteness = y[i];
      y[i] = 116 * whiteness - 16;
      x[i] = 500 * (x[i] - whiteness);
      z[i] = 200 * (whiteness - z[i]);
    }
    return [y, x, z];
  }

  /** Linear RGB of YCxCz, clipped to [0, 1]. */
  function fromOpponent([brightness, red, blue]) {
    const xyz = [red, brightness, blue].map((plane) => new Float64Array(plane.length));
    for (let i = 0; i < brightness.length; i++) {
      const y = (brightness[i] + 16) / 116;
      xyz[0][i] = y + red[i] / 500;
      xyz[1][i] = y;
      xyz[2][i] = y - blue[i] / 200;
    }
    return transform(toWhite, xyz).map((plane) =>
      plane.map((value) => Math.min(Math.max(value, 0), 1))
    );
  }

  const bend = (t) => (t > (6 / 29) ** 3 ? Math.cbrt(t) : t / (3 * (6 / 29) ** 2) + 4 / 29);

  /** CIELab of linear RGB, with chroma reduced in the dark after Hunt. */
  function toHuntLab(rgb) {
    const [x, y, z] = transform(fromWhite, rgb);
    for (let i = 0; i < y.length; i++) {
      const [fx, fy, fz] = [bend(x[i]), bend(y[i]), bend(z[i])];
      const lightness = 116 * fy - 16;
      y[i] = lightness;
      x[i] = 0.01 * lightness * 500 * (fx - fy);
      z[i] = 0.01 * lightness * 200 * (fy - fz);
    }
    return [y, x, z];
  }

  /** HyAB distance (Abasi et al. 2020) of the colours of pixel i, to the power of colours. */
  function distance(p, q, i) {
    const chroma = Math.sqrt((p[1][i] - q[1][i]) ** 2 + (p[2][i] - q[2][i]) ** 2);
    return (Math.abs(p[0][i] - q[0][i]) + chroma) ** COLOUR_EXPONENT;
  }

  const [GREEN, BLUE] = [[[0], [1], [0]], [[0], [0], [1]]].map(toHuntLab);
  const LARGEST_COLOUR = distance(GREEN, BLUE, 0);

  /** A distance of colours, the larger ones compressed, in [0, 1]. */
  function redistribute(error) {
    const knee = KNEE * LARGEST_COLOUR;
    if (error < knee) return (KNEE_VALUE / knee) * error;
    return KNEE_VALUE + ((error - knee) / (LARGEST_COLOUR - knee)) * (1 - KNEE_VALUE);
  }

  /** Convolve a plane with `across` along rows and `down` along columns; edges are repeated. */
  function convolve(plane, width, height, across, down) {
    const radius = (across.length - 1) / 2;
    const between = new Float64Array(plane.length);
    const result = new Float64Array(plane.length);
    const row = new Float64Array(width + 2 * radius);
    for (let y = 0; y < height; y++) {
      const line = plane.subarray(y * width, (y + 1) * width);
      row.fill(line[0], 0, radius);
      row.set(line, radius);
      row.fill(line[width - 1], radius + width);
      for (let x = 0; x < width; x++) {
        let sum = 0;
        for (let k = 0; k < across.length; k++) sum += across[k] * row[x + k];
        between[y * width + x] = sum;
      }
    }
    for (let y = 0; y < height; y++) {
      for (let k = -radius; k <= radius; k++) {
        const from = Math.min(Math.max(y + k, 0), height - 1) * width;
        const weight = down[k + radius];
        for (let x = 0; x < width; x++) result[y * width + x] += weight * between[from + x];
      }
    }
    return result;
  }

  const kernel = (radius, value) =>
    Float64Array.from({ length: 2 * radius + 1 }, (_, k) => value(k - radius));
  const sumOf = (values) => values.reduce((sum, value) => sum + value, 0);

  /** Blur the channels of YCxCz as the eye does at this distance. */
  function filterByEye(planes, width, height) {
    const widest = Math.sqrt(WIDEST / (2 * Math.PI ** 2));
    const radius = Math.ceil(3 * widest * PIXELS_PER_DEGREE);
    return planes.map((plane, channel) => {
      const parts = SENSITIVITY[channel].map(([a, b]) => {
        const falloff = (Math.PI / PIXELS_PER_DEGREE) ** 2 / b;
        const bell = kernel(radius, (k) => Math.exp(-falloff * k * k));
        const weight = a * Math.sqrt(Math.PI / b);
        return { bell, weight, total: weight * sumOf(bell) ** 2 };
      });
      const total = sumOf(parts.map((part) => part.total));
      const result = new Float64Array(plane.length);
      for (const { bell, weight } of parts) {
        const blurred = convolve(plane, width, height, bell, bell);
        for (let i = 0; i < result.length; i++) result[i] += (weight / total) * blurred[i];
      }
      return result;
    });
  }

  /** Positive and negative weights scaled to sums of 1 and -1. */
  function balance(weights) {
    const positive = sumOf(weights.filter((weight) => weight > 0));
    const negative = -sumOf(weights.filter((weight) => weight < 0));
    return weights.map((weight) => weight / (weight > 0 ? positive : negative));
  }

  /** Strengths of edges and of points of a plane of brightness. */
  function findFeatures(plane, width, height) {
    const deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    const radius = Math.ceil(3 * deviation);
    const bell = kernel(radius, (k) => Math.exp(-(k * k) / (2 * deviation ** 2)));
    const smooth = bell.map((weight) => weight / sumOf(bell));
    const slope = balance(bell.map((weight, k) => -(k - radius) * weight));
    const bend = balance(
      bell.map((weight, k) => (((k - radius) / deviation) ** 2 - 1) * weight)
    );
    return [slope, bend].map((weights) => {
      const across = convolve(plane, width, height, weights, smooth);
      const down = convolve(plane, width, height, smooth, weights);
      return across.map((value, i) => Math.hypot(value, down[i]));
    });
  }

  /** What FLIP compares of an image: linear RGB in [0, 1], as three planes. */
  function perceive(planes, width, height) {
    const opponent = toOpponent(planes);
    const brightness = opponent[0].map((value) => (value + 16) / 116);
    const colours = toHuntLab(fromOpponent(filterByEye(opponent, width, height)));
    const [edges, points] = findFeatures(brightness, width, height);
    return { colours, edges, points };
  }

  /** LDR-FLIP of two images of linear RGB in [0, 1], three planes each: one value a pixel. */
  function ldr(test, reference, width, height) {
    const [a, b] = [test, reference].map((planes) => perceive(planes, width, height));
    return a.edges.map((edge, i) => {
      const feature = Math.max(Math.abs(edge - b.edges[i]), Math.abs(a.points[i] - b.points[i]));
      const weight = Math.min((feature / Math.SQRT2) ** FEATURE_EXPONENT, 1);
      return redistribute(distance(a.colours, b.colours, i)) ** (1 - weight);
    });
  }

  function toneMap(value) {
    const x = Math.max(value, 0);
    const mapped =
      (ACES[0] * x * x + ACES[1] * x + ACES[2]) / (ACES[3] * x * x + ACES[4] * x + ACES[5]);
    return Math.min(Math.max(mapped, 0), 1);
  }

  /** An image's three planes at an exposure: tone-mapped, what is no number black. */
  function expose(image, factor) {
    return [0, 1, 2].map((c) =>
      Float64Array.from({ length: image.rgb.length / 3 }, (_, i) => {
        const value = image.rgb[3 * i + c];
        if (Number.isFinite(value)) return toneMap(factor * value);
        return value === Infinity ? 1 : 0;
      })
    );
  }

  const hasNaN = (image, i) =>
    [0, 1, 2].some((c) => Number.isNaN(image.rgb[3 * i + c]));

  /**
   * HDR-FLIP: the largest LDR-FLIP over `count` exposures from `start` to `stop`; NaN where an
   * image has it. `rest` is awaited after each exposure: large images take seconds.
   */
  async function hdr(test, reference, { start, stop, count }, rest) {
    const { width, height } = test;
    const largest = new Float32Array(width * height);
    for (let k = 0; k < count; k++) {
      const factor = 2 ** (start + (k * (stop - start)) / (count - 1));
      const error = ldr(expose(test, factor), expose(reference, factor), width, height);
      error.forEach((value, i) => (largest[i] = Math.max(largest[i], value)));
      await rest();
    }
    return largest.map((value, i) => (hasNaN(test, i) || hasNaN(reference, i) ? NaN : value));
  }

  viewer.flip = { ldr, hdr };
})(hasteViewer);
