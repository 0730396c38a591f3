// Draws one body with WebGL 2: modes lie in a texture, a frame sends q. Vertices are rest + sum of
// q_i shape_i, normals the same to first order in q.
const kWidth = 2048; // of the textures, texels

const kVertex = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D uFields; // (mode, 0: shape, 1: change of the normal; vertex): texels one after the other
uniform sampler2D uRest;   // (0: place, 1: normal; vertex)
uniform float uQ[64];
uniform int uModes, uVertices;
uniform mat4 uView, uPoses;
uniform vec4 uGround;      // of a shadow: the light's direction, the height; w < -1e8: none
uniform float uSize;
uniform int uColour;
out vec3 vNormal, vPlace;
out float vMoved;
vec3 texel(sampler2D from, int index) {
  return texelFetch(from, ivec2(index % ${kWidth}, index / ${kWidth}), 0).xyz;
}
void main() {
  int v = gl_VertexID;
  vec3 u = vec3(0.0), n = texel(uRest, uVertices + v);
  for (int i = 0; i < uModes; ++i) {
    u += uQ[i] * texel(uFields, 2 * i * uVertices + v);
    n += uQ[i] * texel(uFields, (2 * i + 1) * uVertices + v);
  }
  vec3 x = (uPoses * vec4(texel(uRest, v) + u, 1.0)).xyz;
  vNormal = mat3(uPoses) * n;
  vPlace = x;
  vMoved = length(u) / uSize;
  if (uGround.w > -1e8) x -= uGround.xyz * ((x.z - uGround.w) / uGround.z) - vec3(0, 0, 1e-3 * uSize);
  gl_Position = uView * vec4(x, 1.0);
}`;

const kFragment = `#version 300 es
precision highp float;
in vec3 vNormal, vPlace;
in float vMoved;
uniform vec3 uLight, uEye, uBase;
uniform vec4 uGround;
uniform int uColour;
out vec4 colour;
vec3 heat(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(1.6 * t - 0.1, 1.4 - abs(2.6 * t - 1.4), 1.2 - 2.2 * t), 0.0, 1.0);
}
void main() {
  if (uGround.w > -1e8) { colour = vec4(0.05, 0.06, 0.09, 0.33); return; }
  vec3 n = normalize(vNormal), toEye = normalize(uEye - vPlace);
  if (dot(n, toEye) < 0.0) n = -n;
  vec3 base = uColour == 1 ? heat(8.0 * vMoved) : uBase;
  float sun = max(dot(n, uLight), 0.0), sky = 0.5 + 0.5 * n.z;
  float fill = max(dot(n, normalize(vec3(-uLight.xy, 0.2))), 0.0);
  float shine = pow(max(dot(n, normalize(uLight + toEye)), 0.0), 40.0);
  float rim = pow(1.0 - max(dot(n, toEye), 0.0), 3.0);
  vec3 lit = base * (0.75 * sun + mix(0.16, 0.34, sky) + 0.14 * fill) + 0.16 * shine + 0.10 * rim;
  colour = vec4(pow(lit, vec3(1.0 / 2.2)), 1.0);
}`;

const kFloorVertex = `#version 300 es
precision highp float;
uniform mat4 uView;
uniform vec4 uFloor; // centre, half width
uniform float uHeight;
out vec2 vAt;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  vAt = corner;
  gl_Position = uView * vec4(uFloor.xy + corner * uFloor.w, uHeight, 1.0);
}`;

const kFloorFragment = `#version 300 es
precision highp float;
in vec2 vAt;
out vec4 colour;
void main() {
  float far = length(vAt);
  vec2 cell = fract(vAt * 12.0) - 0.5;
  float line = max(smoothstep(0.47, 0.5, abs(cell.x)), smoothstep(0.47, 0.5, abs(cell.y)));
  vec3 tone = mix(vec3(0.83, 0.85, 0.88), vec3(0.74, 0.77, 0.81), 0.7 * line);
  colour = vec4(tone, smoothstep(1.0, 0.35, far));
}`;

function perspective(fovy, aspect, near, far) {
  const f = 1 / Math.tan(fovy / 2), d = 1 / (near - far);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * d, -1, 0, 0, 2 * near * far * d, 0];
}

export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const unit = (a) => a.map((x) => x / Math.hypot(...a));

function lookAt(eye, at) {
  const z = unit(minus(eye, at)), x = unit(cross([0, 0, 1], z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}

function multiply(a, b) {
  const out = new Array(16).fill(0);
  for (let i = 0; i < 4; ++i)
    for (let j = 0; j < 4; ++j)
      for (let k = 0; k < 4; ++k) out[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return out;
}

// Sums of the normals of a vertex's triangles by their area, and how each shape changes them.
export function normalFields(rest, shapes, corners, modes) {
  const n = rest.length, base = new Float32Array(n), change = new Float32Array(modes * n);
  const edge = (field, at, from, to, k) => field[at + 3 * to + k] - field[at + 3 * from + k];
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [corners[t], corners[t + 1], corners[t + 2]];
    const e = [0, 1, 2].map((k) => edge(rest, 0, a, b, k));
    const f = [0, 1, 2].map((k) => edge(rest, 0, a, c, k));
    const area = cross(e, f);
    for (const v of [a, b, c]) for (let k = 0; k < 3; ++k) base[3 * v + k] += area[k];
    for (let i = 0; i < modes; ++i) {
      const de = [0, 1, 2].map((k) => edge(shapes, i * n, a, b, k));
      const df = [0, 1, 2].map((k) => edge(shapes, i * n, a, c, k));
      const p = cross(de, f), q = cross(e, df);
      for (const v of [a, b, c])
        for (let k = 0; k < 3; ++k) change[i * n + 3 * v + k] += p[k] + q[k];
    }
  }
  // Lengths near one, which half the texture's digits would not need.
  let most = 0;
  for (const x of base) most = Math.max(most, Math.abs(x));
  return { base: base.map((x) => x / most), change: change.map((x) => x / most) };
}

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext('webgl2', { alpha: false, antialias: true, stencil: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('this browser has no WebGL 2: the bodies cannot be drawn');
    this.gl = gl;
    this.program = this.compile(kVertex, kFragment);
    this.floor = this.compile(kFloorVertex, kFloorFragment);
    this.turn = [-0.75, 0.32]; // of the camera: about z, above the floor
    this.zoom = 1;
    gl.enable(gl.DEPTH_TEST);
  }

  compile(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const places = new Map();
    return { program, at: (name) => {
      if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
      return places.get(name);
    } };
  }

  texture(columns) {
    const { gl } = this;
    const texels = columns.reduce((sum, column) => sum + column.length / 3, 0);
    const rows = Math.ceil(texels / kWidth);
    const data = new Float32Array(4 * kWidth * rows);
    let at = 0;
    for (const column of columns)
      for (let k = 0; k < column.length; k += 3, at += 4) {
        data[at] = column[k];
        data[at + 1] = column[k + 1];
        data[at + 2] = column[k + 2];
      }
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, kWidth, rows, 0, gl.RGBA, gl.FLOAT, data);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  // rest: 3 s; shapes: modes x 3 s; corners: 3 t.
  show({ rest, shapes, corners, modes, colour }) {
    const { gl } = this;
    for (const old of [this.fields, this.restTexture]) if (old) gl.deleteTexture(old);
    if (this.indices) gl.deleteBuffer(this.indices);
    if (modes > 64) throw new Error(`${modes} coordinates: the page draws 64 at most`);
    const normals = normalFields(rest, shapes, corners, modes);
    const n = rest.length;
    const columns = [];
    for (let i = 0; i < modes; ++i)
      columns.push(shapes.subarray(i * n, (i + 1) * n), normals.change.subarray(i * n, (i + 1) * n));
    this.fields = this.texture(columns);
    this.restTexture = this.texture([rest, normals.base]);
    this.indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    this.count = corners.length;
    this.modes = modes;
    this.vertices = n / 3;
    this.colour = colour;
    const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
    for (let k = 0; k < n; ++k) {
      low[k % 3] = Math.min(low[k % 3], rest[k]);
      high[k % 3] = Math.max(high[k % 3], rest[k]);
    }
    this.centre = low.map((x, k) => 0.5 * (x + high[k]));
    this.size = Math.max(...low.map((x, k) => high[k] - x));
    this.radius = 0.5 * Math.hypot(...low.map((x, k) => high[k] - x));
    this.ground = low[2];
  }

  eye() {
    const far = (3.1 * this.radius) / this.zoom / Math.min(1, this.canvas.width / this.canvas.height);
    const [a, b] = this.turn;
    return [this.centre[0] + far * Math.cos(b) * Math.sin(a),
      this.centre[1] - far * Math.cos(b) * Math.cos(a), this.centre[2] + far * Math.sin(b)];
  }

  // The world's ray through a place of the canvas, both from 0 to 1.
  ray(x, y) {
    const eye = this.eye(), z = unit(minus(eye, this.centre));
    const right = unit(cross([0, 0, 1], z)), up = cross(z, right);
    const half = Math.tan(0.5 * this.fovy), aspect = this.canvas.width / this.canvas.height;
    const [sx, sy] = [(2 * x - 1) * half * aspect, (1 - 2 * y) * half];
    return { origin: eye, direction: [0, 1, 2].map((k) => sx * right[k] + sy * up[k] - z[k]) };
  }

  get fovy() {
    return 0.75;
  }

  draw(q, { heat = false } = {}) {
    const { gl, canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.9, 0.91, 0.93, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    if (!this.count) return;
    const eye = this.eye();
    const view = multiply(perspective(this.fovy, canvas.width / canvas.height, 0.05 * this.radius,
      30 * this.radius), lookAt(eye, this.centre));
    const light = unit([0.45, -0.55, 0.85]);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.floor.program);
    gl.uniformMatrix4fv(this.floor.at('uView'), false, view);
    gl.uniform4f(this.floor.at('uFloor'), this.centre[0], this.centre[1], 0, 4 * this.radius);
    gl.uniform1f(this.floor.at('uHeight'), this.ground);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    const { at, program } = this.program;
    gl.useProgram(program);
    gl.uniform1fv(at('uQ'), Float32Array.from(q));
    gl.uniform1i(at('uModes'), this.modes);
    gl.uniform1i(at('uVertices'), this.vertices);
    gl.uniformMatrix4fv(at('uView'), false, view);
    gl.uniformMatrix4fv(at('uPoses'), false, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    gl.uniform3fv(at('uLight'), light);
    gl.uniform3fv(at('uEye'), eye);
    gl.uniform3fv(at('uBase'), this.colour);
    gl.uniform1f(at('uSize'), this.size);
    gl.uniform1i(at('uColour'), heat ? 1 : 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.fields);
    gl.uniform1i(at('uFields'), 0);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.restTexture);
    gl.uniform1i(at('uRest'), 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    // The shadow, each place of the floor once.
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    gl.depthMask(false);
    gl.uniform4f(at('uGround'), ...light, this.ground);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
    gl.depthMask(true);
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.BLEND);
    gl.uniform4f(at('uGround'), 0, 0, 1, -1e9);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }
}
