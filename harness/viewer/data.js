/* The panels of the report, and their images: half floats, widened when first asked for. */
var hasteViewer = {};

(function (viewer) {
  "use strict";

  /** Float32 values of the 65536 half floats (IEEE 754 binary16). */
  const WIDE = Float32Array.from({ length: 65536 }, (_, bits) => {
    const sign = bits & 0x8000 ? -1 : 1;
    const exponent = (bits >> 10) & 31;
    const fraction = bits & 1023;
    if (exponent === 31) return fraction ? NaN : sign * Infinity;
    if (exponent === 0) return sign * fraction * 2 ** -24;
    return sign * (1024 + fraction) * 2 ** (exponent - 25);
  });

  /** Bytes of a deflated text in base64 (RFC 1950, RFC 4648). */
  async function inflate(text) {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser is too old for the images: it has no DecompressionStream");
    }
    const packed = atob(text);
    const bytes = new Uint8Array(packed.length);
    for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** An image: rgb [3 n] interleaved and sigma [n], from low and high bytes of four planes. */
  async function decode(text, about, width, height) {
    const bytes = await inflate(text);
    const pixels = width * height;
    const values = 4 * pixels;
    if (bytes.length !== 2 * values) {
      throw new Error(`${about.name}: ${bytes.length} bytes, expected ${2 * values}`);
    }
    const scale = 2 ** about.exponent;
    const value = (i) => WIDE[bytes[i] | (bytes[values + i] << 8)] * scale;
    const rgb = new Float32Array(3 * pixels);
    const sigma = new Float32Array(pixels);
    for (let i = 0; i < pixels; i++) {
      for (let c = 0; c < 3; c++) rgb[3 * i + c] = value(c * pixels + i);
      sigma[i] = value(3 * pixels + i);
    }
    return { name: about.name, count: about.count, spp: about.spp, width, height, rgb, sigma };
  }

  const registered = new Map();

  /** Called by the scripts of full-size images: the images of a panel, in its order. */
  function register(key, lines) {
    registered.set(key, lines);
  }

  function loadScript(address) {
    return new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = address;
      script.onload = resolve;
      script.onerror = () => reject(new Error(`${address} cannot be read: is all unpacked?`));
      document.head.append(script);
    });
  }

  async function linesOf(panel) {
    if (registered.has(panel.key)) return registered.get(panel.key);
    if (panel.script) {
      await loadScript(panel.script);
    } else {
      const blob = document.querySelector(`.viewer-data[data-panel="${CSS.escape(panel.key)}"]`);
      register(panel.key, blob.textContent.trim().split("\n"));
      blob.remove();
    }
    if (!registered.has(panel.key)) throw new Error(`${panel.script} holds no ${panel.key}`);
    return registered.get(panel.key);
  }

  /** Panels of a catalogue by their keys, each with `image(name)`, a promise kept once decoded. */
  function openCatalogue(catalogue) {
    const panels = new Map();
    for (const entry of catalogue.panels) {
      const panel = { ...entry, key: `${entry.scene}/${entry.model}`, decoded: new Map() };
      panel.columns = Math.ceil(panel.width / panel.block);
      panel.rows = Math.ceil(panel.height / panel.block);
      panel.names = panel.images.map((image) => image.name);
      panel.image = (name) => {
        if (!panel.decoded.has(name)) {
          const index = panel.names.indexOf(name);
          const decoding = linesOf(panel).then((lines) =>
            decode(lines[index], panel.images[index], panel.columns, panel.rows)
          );
          panel.decoded.set(name, decoding);
        }
        return panel.decoded.get(name);
      };
      panels.set(panel.key, panel);
    }
    return panels;
  }

  viewer.register = register;
  viewer.openCatalogue = openCatalogue;
})(hasteViewer);
