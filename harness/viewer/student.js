/* Tails of Student's distribution. */
(function (viewer) {
  "use strict";

  // Lanczos 1964, A Precision Approximation of the Gamma Function, g = 7, nine terms.
  const LANCZOS = [
    0.99999999999980993, 676.5203681218851, -1259.1392167224028, 771.32342877765313,
    -176.61502916214059, 12.507343278686905, -0.13857109526572012, 9.9843695780195716e-6,
    1.5056327351493116e-7,
  ];

  /** Logarithm of the gamma function for x >= 1/2. */
  function logGamma(x) {
    let sum = LANCZOS[0];
    for (let i = 1; i < LANCZOS.length; i++) sum += LANCZOS[i] / (x - 1 + i);
    const t = x + 6.5;
    return 0.5 * Math.log(2 * Math.PI) + (x - 0.5) * Math.log(t) - t + Math.log(sum);
  }

  /** Continued fraction of the incomplete beta function (DLMF 8.17.22), by Lentz's method. */
  function betaFraction(x, a, b) {
    const tiny = 1e-300;
    const away = (value) => (Math.abs(value) < tiny ? tiny : value);
    let c = 1;
    let d = 1 / away(1 - ((a + b) * x) / (a + 1));
    let fraction = d;
    for (let m = 1; m < 1000; m++) {
      const even = (m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m));
      d = 1 / away(1 + even * d);
      c = away(1 + even / c);
      fraction *= d * c;
      const odd = (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 / away(1 + odd * d);
      c = away(1 + odd / c);
      fraction *= d * c;
      if (Math.abs(d * c - 1) < 1e-14) break;
    }
    return fraction;
  }

  /** Regularized incomplete beta function I_x(a, b); `y` is 1 - x, apart to keep its digits. */
  function incompleteBeta(x, y, a, b) {
    if (x <= 0) return 0;
    if (y <= 0) return 1;
    const front = Math.exp(
      a * Math.log(x) + b * Math.log(y) + logGamma(a + b) - logGamma(a) - logGamma(b)
    );
    if (x < (a + 1) / (a + b + 2)) return (front * betaFraction(x, a, b)) / a;
    return 1 - (front * betaFraction(y, b, a)) / b;
  }

  /** Two-sided p-value of t with `degrees` of freedom: I_{v / (v + t^2)}(v / 2, 1 / 2). */
  viewer.studentP = function (t, degrees) {
    if (Number.isNaN(t)) return NaN;
    if (!Number.isFinite(t)) return 0;
    const total = degrees + t * t;
    return incompleteBeta(degrees / total, (t * t) / total, degrees / 2, 0.5);
  };
})(hasteViewer);
