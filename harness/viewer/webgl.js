/* Painter with WebGL 2. Like the one without: the same pixels but for an 8-bit level. */
(function (viewer) {
  "use strict";

  const VERTICES = `#version 300 es
    void main() {
      vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
      gl_Position = vec4(corner, 0.0, 1.0);
    }`;

  const FRAGMENTS = `#version 300 es
    precision highp float;
    precision highp int;
    precision highp sampler2D;
    precision highp isampler2D;
    uniform isampler2D columns;
    uniform isampler2D rows;
    uniform sampler2D picture;
    uniform sampler2D ramp;
    uniform int stage_height;
    uniform float gain;
    uniform bool mapped;
    uniform vec2 ends;
    out vec4 colour;

    float encode_srgb(float value) {
      return value <= 0.0031308 ? 12.92 * value : 1.055 * pow(value, 1.0 / 2.4) - 0.055;
    }

    void main() {
      ivec2 place = ivec2(gl_FragCoord.xy);
      int column = texelFetch(columns, ivec2(place.x, 0), 0).r;
      int row = texelFetch(rows, ivec2(stage_height - 1 - place.y, 0), 0).r;
      if (column < 0 || row < 0) {
        colour = vec4(0.0);
        return;
      }
      vec4 value = texelFetch(picture, ivec2(column, row), 0);
      if (value.a == 0.0) {
        colour = vec4(1.0, 0.0, 1.0, 1.0);
      } else if (mapped) {
        float position = clamp((value.r - ends.x) / (ends.y - ends.x), 0.0, 1.0);
        int steps = textureSize(ramp, 0).x;
        int entry = int(floor(position * float(steps - 1) + 0.5));
        colour = texelFetch(ramp, ivec2(entry, 0), 0);
      } else {
        vec3 linear = clamp(gain * value.rgb, 0.0, 1.0);
        colour = vec4(encode_srgb(linear.r), encode_srgb(linear.g), encode_srgb(linear.b), 1.0);
      }
    }`;

  const UNIFORMS = [
    "columns", "rows", "picture", "ramp", "stage_height", "gain", "mapped", "ends",
  ];

  function compile(gl) {
    const program = gl.createProgram();
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, VERTICES],
      [gl.FRAGMENT_SHADER, FRAGMENTS],
    ]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
  }

  function makeTexture(gl) {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  /** Four floats a pixel: the values, and 1, or 0 where one of them is broken. */
  function padPicture({ width, height, channels, values }) {
    const padded = new Float32Array(4 * width * height);
    for (let i = 0; i < width * height; i++) {
      let sound = 1;
      for (let c = 0; c < channels; c++) {
        const value = values[channels * i + c];
        padded[4 * i + c] = value;
        if (viewer.isBroken(value, channels)) sound = 0;
      }
      // A map's zero has the logarithm minus infinity, which is below every scale.
      if (channels === 1) padded[4 * i] = Math.min(Math.max(padded[4 * i], -1e30), 1e30);
      padded[4 * i + 3] = sound;
    }
    return padded;
  }

  /** A painter on a new canvas, or null where there is no WebGL 2. `lost` is called if it goes. */
  viewer.makeWebglPainter = function (lost) {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", {
      alpha: true,
      antialias: false,
      preserveDrawingBuffer: true,
      // WebGL in software starts later, and is no faster, than the painter without.
      failIfMajorPerformanceCaveat: true,
    });
    const program = gl && compile(gl);
    if (!program) return null;
    canvas.addEventListener("webglcontextlost", lost);
    const at = Object.fromEntries(
      UNIFORMS.map((name) => [name, gl.getUniformLocation(program, name)])
    );
    const [columns, rows] = [makeTexture(gl), makeTexture(gl)];
    const uploaded = new Map();
    gl.useProgram(program);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    UNIFORMS.slice(0, 4).forEach((name, unit) => gl.uniform1i(at[name], unit));

    function bind(unit, texture) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    }

    function bindTable(unit, texture, table) {
      bind(unit, texture);
      const size = [table.length, 1, 0];
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16I, ...size, gl.RED_INTEGER, gl.SHORT, table);
    }

    function bindOnce(unit, what, upload) {
      if (uploaded.has(what)) return bind(unit, uploaded.get(what));
      if (uploaded.size >= 32) {
        const [oldest, texture] = uploaded.entries().next().value;
        gl.deleteTexture(texture);
        uploaded.delete(oldest);
      }
      gl.activeTexture(gl.TEXTURE0 + unit);
      uploaded.set(what, makeTexture(gl));
      upload();
    }

    function bindPicture(picture) {
      bindOnce(2, picture, () => {
        const size = [picture.width, picture.height, 0];
        const padded = padPicture(picture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ...size, gl.RGBA, gl.FLOAT, padded);
      });
    }

    function bindMap(map) {
      bindOnce(3, map, () => {
        const size = [map.length / 3, 1, 0];
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, ...size, gl.RGB, gl.UNSIGNED_BYTE, map);
      });
    }

    return {
      name: "WebGL",
      canvas,
      paint(panes) {
        const { width, height } = canvas;
        gl.viewport(0, 0, width, height);
        gl.disable(gl.SCISSOR_TEST);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT);
        gl.enable(gl.SCISSOR_TEST);
        for (const { clip, tables, shade } of panes) {
          gl.scissor(clip.left, height - clip.top - clip.height, clip.width, clip.height);
          bindTable(0, columns, tables.columns);
          bindTable(1, rows, tables.rows);
          bindPicture(shade.picture);
          bindMap(shade.map ?? viewer.maps.magnitude);
          gl.uniform1i(at.stage_height, height);
          gl.uniform1i(at.mapped, shade.map ? 1 : 0);
          gl.uniform1f(at.gain, shade.gain ?? 1);
          gl.uniform2f(at.ends, shade.scale?.low ?? 0, shade.scale?.high ?? 1);
          gl.drawArrays(gl.TRIANGLES, 0, 3);
        }
      },
      /** RGBA from the upper left corner. */
      pixels() {
        const { width, height } = canvas;
        const upward = new Uint8Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, upward);
        const result = new Uint8Array(upward.length);
        for (let y = 0; y < height; y++) {
          const line = upward.subarray(4 * width * y, 4 * width * (y + 1));
          result.set(line, 4 * width * (height - 1 - y));
        }
        return result;
      },
    };
  };
})(hasteViewer);
