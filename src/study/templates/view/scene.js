// A picture of a run by WebGL 2. Positions and values of a frame are textures, so that a frame costs two uploads.

const MAP = [[72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [109, 205, 89], [180, 222, 44], [253, 231, 37]];
const WIDE = 1024; // [1] texels of a row

// What all shaders share: places of nodes, and the share of the colour map that a value has; below 0 without one.
const SHARED = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D;
uniform usampler2D positions, values;
uniform vec3 origin, codeStep;
uniform mat4 view, lens;
uniform int valued;      // 0 nothing, 1 nodes, 2 cells
uniform int valuedCells;
uniform vec2 roots;      // cube root of a value = x + y code
uniform vec2 scale;      // share of the map = x + y value
ivec2 texel(uint i) { return ivec2(int(i % ${WIDE}u), int(i / ${WIDE}u)); }
vec4 seen(uint node) { return view * vec4(origin + codeStep * vec3(texelFetch(positions, texel(node), 0).rgb), 1.0); }
float share(uint node, uint cell) {
  if (valued == 0 || valued == 2 && int(cell) >= valuedCells) { return -9.0; }
  uint code = texelFetch(values, texel(valued == 1 ? node : cell), 0).r;
  float root = roots.x + roots.y * float(code);
  return code == 255u ? -9.0 : clamp(scale.x + scale.y * root * root * root, 0.0, 1.0);
}`;
const COLOURED = `
uniform sampler2D map;
uniform vec4 plain;
vec3 colour(float share) { return share < -0.5 ? plain.rgb : texture(map, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb; }`;

const SHADERS = {
  triangles: [`${SHARED}
layout(location = 0) in uvec2 corner;
out vec3 at; out float shown;
void main() { vec4 place = seen(corner.x); at = place.xyz; shown = share(corner.x, corner.y); gl_Position = lens * place; }`, `#version 300 es
precision highp float;${COLOURED}
in vec3 at; in float shown; out vec4 drawn;
void main() {
  vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
  float light = 0.72 + 0.28 * abs(dot(normal, normalize(vec3(0.45, 0.35, 0.82))));
  drawn = vec4(colour(shown) * light, 1.0);
}`],
  lines: [`${SHARED}
layout(location = 0) in uvec3 line;
uniform vec2 size; uniform float width;
out float shown;
void main() {
  vec4 a = lens * seen(line.x), b = lens * seen(line.y);
  bool end = (gl_VertexID & 1) == 1;
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  vec2 across = vec2(-along.y, along.x) / max(length(along), 1e-6) * (gl_VertexID < 2 ? width : -width);
  gl_Position = end ? b : a;
  gl_Position.xy += across / size * gl_Position.w;
  gl_Position.z -= 2e-4 * gl_Position.w;
  shown = share(end ? line.y : line.x, line.z);
}`, `#version 300 es
precision highp float;${COLOURED}
in float shown; out vec4 drawn;
void main() { drawn = vec4(colour(shown) * plain.a, plain.a); }`],
  dots: [`${SHARED}
layout(location = 0) in uvec2 corner;
uniform float width;
out float shown;
void main() { gl_Position = lens * seen(corner.x); gl_Position.z -= 4e-4 * gl_Position.w; gl_PointSize = width; shown = share(corner.x, corner.y); }`, `#version 300 es
precision highp float;${COLOURED}
in float shown; out vec4 drawn;
void main() { if (length(gl_PointCoord - 0.5) > 0.5) { discard; } drawn = vec4(colour(shown), 1.0); }`],
};

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) { throw new Error(gl.getShaderInfoLog(shader)); }
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) { throw new Error(gl.getProgramInfoLog(made)); }
  const at = {};
  for (let i = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS) - 1; i >= 0; i--) {
    const { name } = gl.getActiveUniform(made, i);
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}

// A picture of a run on a canvas; null without WebGL 2.
function pictureOf(canvas, run) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  if (!gl) { return null; }
  const programs = Object.fromEntries(Object.entries(SHADERS).map(([name, text]) => [name, program(gl, text)]));
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  const texture = (unit, format, rows) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const key of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) { gl.texParameteri(gl.TEXTURE_2D, key, gl.NEAREST); }
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, unit === 2 ? 256 : WIDE, Math.max(rows, 1));
  };
  texture(0, gl.RGB16UI, Math.ceil(run.nodes / WIDE));
  texture(1, gl.R8UI, Math.ceil(Math.max(run.cells, run.nodes) / WIDE));
  texture(2, gl.RGBA8, 1);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 256, 1, gl.RGBA, gl.UNSIGNED_BYTE, mapTexels());
  // Whole rows, then the rest of the last one.
  const upload = (unit, format, kind, numbers, components) => {
    const texels = numbers.length / components, rows = Math.floor(texels / WIDE), rest = texels - rows * WIDE;
    gl.activeTexture(gl.TEXTURE0 + unit);
    if (rows) { gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDE, rows, format, kind, numbers, 0); }
    if (rest) { gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows, rest, 1, format, kind, numbers, rows * WIDE * components); }
  };
  const parts = {};
  const part = (name, numbers, size, instanced) => {
    parts[name] = parts[name] || { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(parts[name].array);
    gl.bindBuffer(gl.ARRAY_BUFFER, parts[name].buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribIPointer(0, size, gl.UNSIGNED_INT, 0, 0);
    gl.vertexAttribDivisor(0, instanced ? 1 : 0);
    parts[name].count = numbers.length / size;
  };
  const picture = {
    gl,
    // What is drawn: lists of corners with their cells.
    show(lists) {
      part("triangles", lists.triangles, 2, false);
      part("mesh", lists.mesh, 3, true);
      part("lines", lists.lines, 3, true);
      part("dots", lists.dots, 2, false);
    },
    load(frame, field) {
      upload(0, gl.RGB_INTEGER, gl.UNSIGNED_SHORT, frame.positions, 3);
      if (field >= 0) { upload(1, gl.RED_INTEGER, gl.UNSIGNED_BYTE, frame.values[field], 1); }
    },
    draw(frame, field, range, target, radius, camera) {
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
      if (canvas.width !== w || canvas.height !== h) { [canvas.width, canvas.height] = [w, h]; }
      gl.viewport(0, 0, w, h);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LEQUAL);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      const { view, lens } = matricesOf(camera, radius, w / h);
      const own = field >= 0 && frame.ranges[field], on = own ? run.fields[field].on : null;
      const spread = range ? range[1] - range[0] : 0;
      const scale = !own ? [0, 0] : spread > 0 ? [-range[0] / spread, 1 / spread] : [0.5, 0], roots = own ? rootsOf(own) : [0, 0];
      const use = (name, plain, width, coloured) => {
        const { made, at } = programs[name];
        gl.useProgram(made);
        gl.uniform1i(at.positions, 0);
        gl.uniform1i(at.values, 1);
        gl.uniform1i(at.map, 2);
        gl.uniform3fv(at.origin, frame.low.map((x, i) => x - target[i]));
        gl.uniform3fv(at.codeStep, frame.step);
        gl.uniformMatrix4fv(at.view, false, view);
        gl.uniformMatrix4fv(at.lens, false, lens);
        gl.uniform1i(at.valued, !coloured || !on ? 0 : on === "nodes" ? 1 : 2);
        gl.uniform1i(at.valuedCells, on === "triangles" ? run.triangles : run.cells);
        gl.uniform2fv(at.scale, scale);
        gl.uniform2fv(at.roots, roots);
        gl.uniform4fv(at.plain, plain);
        if (at.size) { gl.uniform2f(at.size, w, h); }
        if (at.width) { gl.uniform1f(at.width, width * ratio); }
      };
      const each = (name, draw) => { if (parts[name] && parts[name].count) { gl.bindVertexArray(parts[name].array); draw(parts[name].count); } };
      each("triangles", (n) => { use("triangles", [0.62, 0.66, 0.7, 1], 0, true); gl.drawArrays(gl.TRIANGLES, 0, n); });
      each("mesh", (n) => { use("lines", [0.25, 0.25, 0.25, 0.35], 0.7, false); gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, n); });
      each("lines", (n) => { use("lines", [0.5, 0.53, 0.56, 1], 1.5, true); gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, n); });
      each("dots", (n) => { use("dots", [0.84, 0.37, 0, 1], 9, false); gl.drawArrays(gl.POINTS, 0, n); });
    },
  };
  return picture;
}

function mapTexels() {
  const texels = new Uint8Array(1024);
  for (let i = 0; i < 256; i++) {
    const place = i / 255 * (MAP.length - 1), low = Math.min(Math.floor(place), MAP.length - 2), share = place - low;
    for (let c = 0; c < 3; c++) { texels[4 * i + c] = Math.round(MAP[low][c] + share * (MAP[low + 1][c] - MAP[low][c])); }
    texels[4 * i + 3] = 255;
  }
  return texels;
}
