// Draws bodies with WebGL 2: modes lie in a texture, a frame sends q and poses. A vertex is at
//
//     x = sum_b w_b T_b (X + sum_i q_i U_i)
//
// X, U: rest and shapes; T_b: the pose of bone b, of most bodies the only one, w_b: its weight.
// Normals are the same to first order in q. The live page and recorded motions share this file.
const kWidth = 2048; // of the textures, texels
const kMostModes = 192,
      kMostBones = 24;  // fit in 256 vectors of uniforms, which WebGL 2 guarantees

const kVertex = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D uFields; // (mode, 0: shape, 1: change of the normal; vertex): texels one after the other
uniform sampler2D uRest;   // (0: place, 1: normal, 2 + b: weight of bone b; vertex)
uniform vec4 uQ[${kMostModes / 4}];
uniform int uModes, uVertices, uBones;
uniform mat4 uView, uPoses[${kMostBones}];
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
    float q = uQ[i >> 2][i & 3];
    u += q * texel(uFields, 2 * i * uVertices + v);
    n += q * texel(uFields, (2 * i + 1) * uVertices + v);
  }
  mat4 pose = uPoses[0];
  if (uBones > 1) {
    pose = mat4(0.0);
    for (int b = 0; b < uBones; ++b) pose += texel(uRest, (2 + b) * uVertices + v).x * uPoses[b];
  }
  vec3 x = (pose * vec4(texel(uRest, v) + u, 1.0)).xyz;
  vNormal = mat3(pose) * n;
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
// groups: a number a vertex; those of one number share a normal. None: each has its own.
export function normalFields({ rest, shapes, corners, modes, groups }) {
  const n = rest.length, base = new Float32Array(n), change = new Float32Array(modes * n);
  const to = (v) => (groups ? groups[v] : v);
  const edge = (field, at, from, to, k) => field[at + 3 * to + k] - field[at + 3 * from + k];
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [corners[t], corners[t + 1], corners[t + 2]];
    const e = [0, 1, 2].map((k) => edge(rest, 0, a, b, k));
    const f = [0, 1, 2].map((k) => edge(rest, 0, a, c, k));
    const area = cross(e, f);
    for (const v of [a, b, c]) for (let k = 0; k < 3; ++k) base[3 * to(v) + k] += area[k];
    for (let i = 0; i < modes; ++i) {
      const de = [0, 1, 2].map((k) => edge(shapes, i * n, a, b, k));
      const df = [0, 1, 2].map((k) => edge(shapes, i * n, a, c, k));
      const p = cross(de, f), q = cross(e, df);
      for (const v of [a, b, c])
        for (let k = 0; k < 3; ++k) change[i * n + 3 * to(v) + k] += p[k] + q[k];
    }
  }
  if (groups)
    for (let i = -1; i < modes; ++i) {
      const field = i < 0 ? base : change.subarray(i * n, (i + 1) * n), sums = field.slice();
      for (let v = 0; v < groups.length; ++v)
        for (let k = 0; k < 3; ++k) field[3 * v + k] = sums[3 * groups[v] + k];
    }
  // Lengths near one, which half the texture's digits would not need.
  let most = 0;
  for (const x of base) most = Math.max(most, Math.abs(x));
  return { base: base.map((x) => x / most), change: change.map((x) => x / most) };
}

// The rotation x y z w and the position of a pose as a matrix, column by column.
export function poseMatrix([px, py, pz], [x, y, z, w]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0, px, py, pz, 1];
}

const kUnmoved = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const kColours = { horse: [0.62, 0.40, 0.24], heart: [0.74, 0.16, 0.18], tower: [0.52, 0.56, 0.62],
  bridge: [0.40, 0.48, 0.58], basket: [0.72, 0.53, 0.30], beam: [0.36, 0.52, 0.70],
  bell: [0.76, 0.60, 0.22], ball: [0.70, 0.30, 0.24] };

// Of a body by its name, "horse-free" like the horse; linear red, green and blue.
export function bodyColour(name) {
  return kColours[name.split(/[^a-z]/)[0]] ?? [0.5, 0.5, 0.55];
}

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext('webgl2', { alpha: false, antialias: true, stencil: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('this browser has no WebGL 2: the bodies cannot be drawn');
    this.gl = gl;
    this.turn = [0.75, 0.3]; // of the camera: about z, above the floor
    this.zoom = 1;
    this.bodies = [];
    this.prepare();
    // The browser may take the context away, when the graphics card is reset or too many pages use
    // one; the picture is drawn again when the context returns.
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.lost = true;
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost = false;
      this.prepare();
      this.bodies = this.bodies.map((body) => this.upload(body.shape));
    });
  }

  prepare() {
    this.program = this.compile(kVertex, kFragment);
    this.floor = this.compile(kFloorVertex, kFloorFragment);
    this.gl.enable(this.gl.DEPTH_TEST);
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

  // One body's textures and triangles on the graphics card.
  upload(shape) {
    const { gl } = this, { rest, shapes, corners, modes, bones = 1, weights } = shape;
    if (modes > kMostModes) throw new Error(`${modes} coordinates: the page draws ${kMostModes} at most`);
    if (bones > kMostBones) throw new Error(`${bones} bones: the page draws ${kMostBones} at most`);
    const normals = normalFields(shape);
    const n = rest.length, columns = [], base = [rest, normals.base];
    for (let i = 0; i < modes; ++i)
      columns.push(shapes.subarray(i * n, (i + 1) * n), normals.change.subarray(i * n, (i + 1) * n));
    for (let b = 0; bones > 1 && b < bones; ++b) {
      const column = new Float32Array(n);
      for (let v = 0; v < n / 3; ++v) column[3 * v] = weights[v * bones + b];
      base.push(column);
    }
    if (columns.length === 0) columns.push(new Float32Array(3));
    const body = { shape, fields: this.texture(columns), rest: this.texture(base),
      indices: gl.createBuffer(), count: corners.length, vertices: n / 3, modes, bones };
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, body.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    return body;
  }

  // Sets the bodies to draw. Of each: rest: 3 s; shapes: modes x 3 s; corners: 3 t; colour; of some
  // groups (normalFields), of bodies on bones their number and weights, s x bones. scenery: the
  // camera ignores it. bounds: the region in view, [low, high]; else that of the bodies. floor: its
  // height; else the floor is below the lowest point, unless scenery replaces it.
  show(list, bounds, floor) {
    const { gl } = this;
    for (const old of this.bodies) {
      gl.deleteTexture(old.fields);
      gl.deleteTexture(old.rest);
      gl.deleteBuffer(old.indices);
    }
    this.bodies = [];
    for (const shape of list) this.bodies.push(this.upload(shape));
    const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
    for (const { rest, scenery } of list)
      for (let k = 0; !scenery && k < rest.length; ++k) {
        low[k % 3] = Math.min(low[k % 3], rest[k]);
        high[k % 3] = Math.max(high[k % 3], rest[k]);
      }
    this.look(bounds ?? [low, high]);
    this.hasFloor = floor !== undefined || !list.some((one) => one.scenery);
    this.ground = floor ?? this.ground;
  }

  look([low, high]) {
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

  // The ray in the world through a point of the canvas, both coordinates from 0 to 1.
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

  // states: of each body q and, where it has moved as a whole, the matrices of its poses.
  draw(states, { heat = false } = {}) {
    const { gl, canvas } = this;
    if (this.lost) return;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.9, 0.91, 0.93, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    if (this.bodies.length === 0) return;
    const eye = this.eye();
    const view = multiply(perspective(this.fovy, canvas.width / canvas.height, 0.05 * this.radius,
      30 * this.radius), lookAt(eye, this.centre));
    const light = unit([0.45, -0.55, 0.85]);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    if (this.hasFloor) {
      gl.useProgram(this.floor.program);
      gl.uniformMatrix4fv(this.floor.at('uView'), false, view);
      gl.uniform4f(this.floor.at('uFloor'), this.centre[0], this.centre[1], 0, 4 * this.radius);
      gl.uniform1f(this.floor.at('uHeight'), this.ground);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    const { at, program } = this.program;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at('uView'), false, view);
    gl.uniform3fv(at('uLight'), light);
    gl.uniform3fv(at('uEye'), eye);
    gl.uniform1f(at('uSize'), this.size);
    gl.uniform1i(at('uColour'), heat ? 1 : 0);
    gl.uniform1i(at('uFields'), 0);
    gl.uniform1i(at('uRest'), 1);
    // The shadows, drawn once for each point of the floor.
    if (this.hasFloor) {
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.depthMask(false);
      gl.uniform4f(at('uGround'), ...light, this.ground);
      this.bodies.forEach((body, k) => this.drawBody(body, states[k]));
      gl.depthMask(true);
      gl.disable(gl.STENCIL_TEST);
    }
    gl.disable(gl.BLEND);
    gl.uniform4f(at('uGround'), 0, 0, 1, -1e9);
    this.bodies.forEach((body, k) => this.drawBody(body, states[k]));
  }

  drawBody(body, { q, poses = [kUnmoved] }) {
    const { gl } = this, { at } = this.program;
    const padded = new Float32Array(kMostModes);
    padded.set(q);
    gl.uniform4fv(at('uQ'), padded);
    gl.uniform1i(at('uModes'), body.modes);
    gl.uniform1i(at('uVertices'), body.vertices);
    gl.uniform1i(at('uBones'), body.bones);
    gl.uniformMatrix4fv(at('uPoses'), false, poses.flat());
    gl.uniform3fv(at('uBase'), body.shape.colour);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, body.fields);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, body.rest);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, body.indices);
    gl.drawElements(gl.TRIANGLES, body.count, gl.UNSIGNED_INT, 0);
  }
}
