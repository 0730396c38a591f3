// Plays recorded motion: shapes in WebGL, coordinates and poses interpolated linearly between two
// frames. A film is the output of page_motion in runtime/io/page/document.h.
const kKinds = { int16: Int16Array, uint32: Uint32Array, float32: Float32Array };
const kSpeeds = [[1, 'real time'], [0.5, '1/2'], [0.2, '1/5'], [0.1, '1/10'], [0.05, '1/20'], [0.02, '1/50'], [0.005, '1/200']];

function decoded({ type, data }) {
  const raw = atob(data), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return new kKinds[type](bytes.buffer);
}

// U, r x 3 s: floats, or whole numbers times a scale for each coordinate.
function fieldsOf(shape) {
  const fields = decoded(shape.fields);
  if (!shape.scales) return fields;
  const n = 3 * shape.vertices, out = new Float32Array(fields.length);
  for (let i = 0; i < shape.modes; ++i)
    for (let k = 0; k < n; ++k) out[i * n + k] = shape.scales[i] * fields[i * n + k];
  return out;
}

class Film {
  constructor(film) {
    this.times = decoded(film.times);
    this.loops = film.loops ?? null;  // of each: from, to (s), label
    this.shapes = film.shapes.map((shape) => ({ modes: shape.modes, rest: decoded(shape.rest),
      shapes: fieldsOf(shape), corners: decoded(shape.corners), groups: shape.groups && decoded(shape.groups) }));
    this.bodies = film.bodies.map((body) => ({ ...body, of: this.shapes[body.shape], q: decoded(body.q),
      poses: decoded(body.poses), weights: body.weights && decoded(body.weights),
      shown: body.shown && decoded(body.shown) }));
    // The renderer has z up.
    this.root = film.up === 'y' ? [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1] : null;
  }

  get end() {
    return this.times[this.times.length - 1];
  }

  // The frame at or before a time, and the fraction of the interval to the next.
  moment(time) {
    let low = 0, high = this.times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    const next = Math.min(low + 1, this.times.length - 1), width = this.times[next] - this.times[low];
    return { frame: low, next, share: width > 0 ? Math.min(1, Math.max(0, (time - this.times[low]) / width)) : 0 };
  }

  coordinates(body, { frame, next, share }) {
    const r = body.of.modes, q = new Float32Array(r);
    for (let i = 0; i < r; ++i) q[i] = (1 - share) * body.q[frame * r + i] + share * body.q[next * r + i];
    return q;
  }

  // The matrices of a body's poses. A body at rest has one set for all frames; one that is not there has zeros, which
  // leave nothing of it to draw.
  matrices(body, { frame, next, share }) {
    if (body.shown && !body.shown[frame]) return Array.from({ length: body.bones }, () => new Array(16).fill(0));
    const width = 7 * body.bones, still = body.poses.length === width, matrices = [];
    for (let b = 0; b < body.bones; ++b) {
      const at = (f) => Array.from(body.poses.subarray((still ? 0 : f) * width + 7 * b, (still ? 0 : f) * width + 7 * b + 7));
      const first = at(frame), second = at(next);
      const sign = first[3] * second[3] + first[4] * second[4] + first[5] * second[5] + first[6] * second[6] < 0 ? -1 : 1;
      const between = first.map((x, k) => (1 - share) * x + share * (k < 3 ? 1 : sign) * second[k]);
      const length = Math.hypot(...between.slice(3));
      const matrix = poseMatrix(between.slice(0, 3), between.slice(3).map((x) => x / length));
      matrices.push(this.root ? multiply(this.root, matrix) : matrix);
    }
    return matrices;
  }

  states(time) {
    const moment = this.moment(time);
    return this.bodies.map((body) => ({ q: this.coordinates(body, moment), poses: this.matrices(body, moment) }));
  }

  // Positions of a body's vertices in the body's own frame, X + U q; for tests and inspection.
  positions(number, time) {
    const body = this.bodies[number], { rest, shapes, modes } = body.of, q = this.coordinates(body, this.moment(time));
    return Array.from(rest, (x, k) => {
      for (let i = 0; i < modes; ++i) x += q[i] * shapes[i * rest.length + k];
      return x;
    });
  }

  // World positions of every `every`-th vertex of a body: [x, y, z] for each.
  places(body, { q, poses }, every) {
    const { rest, shapes, modes } = body.of, places = [];
    for (let v = 0; v < rest.length / 3; v += every) {
      const x = [0, 1, 2].map((k) => {
        let sum = rest[3 * v + k];
        for (let i = 0; i < modes; ++i) sum += q[i] * shapes[i * rest.length + 3 * v + k];
        return sum;
      });
      const at = (m, k) => m[k] * x[0] + m[4 + k] * x[1] + m[8 + k] * x[2] + m[12 + k];
      places.push([0, 1, 2].map((k) => (body.bones === 1 ? at(poses[0], k)
        : poses.reduce((sum, matrix, b) => sum + body.weights[v * body.bones + b] * at(matrix, k), 0))));
    }
    return places;
  }

  // The region in the camera's view: the box of all bodies at twenty times.
  bounds() {
    const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
    const bodies = this.bodies.filter((body) => !body.scenery);
    const every = 1 + Math.floor(bodies.reduce((sum, body) => sum + body.of.rest.length / 3, 0) / 20000);
    for (let look = 0; look < 20; ++look) {
      const states = this.states((look / 19) * this.end);
      this.bodies.forEach((body, number) => {
        if (body.scenery || (body.shown && !body.shown[this.moment((look / 19) * this.end).frame])) return;
        for (const x of this.places(body, states[number], every))
          for (let k = 0; k < 3; ++k) [low[k], high[k]] = [Math.min(low[k], x[k]), Math.max(high[k], x[k])];
      });
    }
    return [low, high];
  }

  // The height of level scenery at rest, which is drawn as the floor; null: none.
  floorOf(number) {
    const body = this.bodies[number];
    if (!body.scenery || body.poses.length !== 7) return null;
    const places = this.places(body, this.states(this.times[0])[number], 1).map((x) => x[2]);
    const [low, high] = [Math.min(...places), Math.max(...places)];
    return places.length === 4 && high - low <= 1e-6 * Math.hypot(...body.of.rest) ? low : null;
  }
}

// The mouse and fingers rotate the camera; the wheel zooms once the stage has been touched.
function orbit(canvas, renderer) {
  const pointers = new Map();
  canvas.addEventListener('pointerdown', (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (pointers.size > 1) {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]) + 1;
      renderer.zoom = Math.min(20, Math.max(0.2, (renderer.zoom * apart([event.clientX, event.clientY])) / apart(before)));
      return;
    }
    renderer.turn[0] -= 0.006 * (event.clientX - before[0]);
    renderer.turn[1] = Math.min(1.5, Math.max(-0.1, renderer.turn[1] + 0.006 * (event.clientY - before[1])));
  });
  for (const name of ['pointerup', 'pointercancel'])
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    renderer.zoom = Math.min(20, Math.max(0.2, renderer.zoom * Math.exp(-0.001 * event.deltaY)));
  }, { passive: false });
}

function filmControls(film, player) {
  const control = (text, made) => element('label', {}, text, made);
  const play = element('button', { type: 'button', id: 'play' }, 'pause');
  const place = element('input', { type: 'range', id: 'time', min: 0, max: film.end, step: 'any', 'aria-label': 'time' });
  const speed = element('select', { id: 'speed' }, ...kSpeeds.map(([value, text]) => element('option', { value }, text)));
  const colour = element('select', { id: 'colour' }, element('option', {}, 'material'), element('option', {}, 'displacement'));
  const told = element('output', { id: 'told' });
  play.onclick = () => { player.playing = !player.playing; };
  place.oninput = () => player.seek(Number(place.value));
  player.speed = () => Number(speed.value);
  player.heat = () => colour.value === 'displacement';
  player.tell = () => {
    play.textContent = player.playing ? 'pause' : 'play';
    if (document.activeElement !== place || player.playing) place.value = player.time;
    told.textContent = player.loop ? player.loop.label : `t = ${player.time.toFixed(3)} s of ${film.end.toFixed(2)}`;
  };
  return element('div', { class: 'controls' }, play, place, told, control('speed', speed), control('colour', colour));
}

function playFilm(film, canvas, renderer, player) {
  const show = () => {
    const box = canvas.getBoundingClientRect();
    if (box.width === 0 || box.bottom < 0 || box.top > innerHeight) return;  // not visible
    for (const [side, size] of [['width', box.width], ['height', box.height]]) {
      const pixels = Math.max(1, Math.round(size * devicePixelRatio));
      if (canvas[side] !== pixels) canvas[side] = pixels;
    }
    const states = film.states(player.time);
    renderer.draw(player.shown.map((number) => states[number]), { heat: player.heat() });
  };
  let last = performance.now();
  const frame = (time) => {
    requestAnimationFrame(frame);
    const passed = Math.min(1, 1e-3 * Math.max(0, time - last));
    last = time;
    document.dispatchEvent(new CustomEvent('tremolo-time', { detail: player.hidden ? null : player.time }));
    if (player.hidden) return;
    if (player.playing) player.time += passed * player.speed();
    const [begin, finish] = player.loop ? [player.loop.from, player.loop.to] : [film.times[0], film.end];
    if (player.time > finish) player.time = finish > begin ? begin + ((player.time - begin) % (finish - begin)) : begin;
    show();
    player.frames = (player.frames ?? 0) + 1;
    player.tell();
  };
  requestAnimationFrame(frame);
}

// A stage with the recorded motion. live: a page in the same folder whose bodies the engine itself
// moves; it is shown first, and the recording behind a button.
function showFilm(data) {
  const canvas = element('canvas', { id: 'scene', tabindex: 0, 'aria-label': 'the moving bodies' });
  const stage = element('div', { class: 'stage' }, canvas);
  const film = new Film(data), player = { time: film.times[0], playing: !matchMedia('(prefers-reduced-motion: reduce)').matches };
  player.loop = film.loops && film.loops[0];
  player.seek = (time) => { player.time = Math.min(film.end, Math.max(film.times[0], time)); };
  const controls = filmControls(film, player);
  const hint = element('p', { class: 'hint' },
    `drag to turn, wheel to come nearer (after a click), space to pause; a click in a chart ${
      film.loops ? 'plays the motion of that point' : 'goes to that time'}`);
  const part = element('div', { class: 'film' }, stage, controls, hint);
  document.addEventListener('tremolo-loop', (event) => {
    player.loop = film.loops[event.detail];
    player.time = player.loop.from;
    player.playing = true;
  });
  document.addEventListener('tremolo-seek', (event) => player.seek(event.detail));
  canvas.addEventListener('keydown', (event) => {
    if (event.key !== ' ') return;
    event.preventDefault();
    player.playing = !player.playing;
  });
  window.tremoloFilm = { film, player }; // for tests, and for the curious
  try {
    const renderer = new Renderer(canvas);
    const floors = film.bodies.map((body, number) => film.floorOf(number));
    player.shown = film.bodies.map((body, number) => number).filter((number) => floors[number] === null);
    renderer.show(player.shown.map((number) => film.bodies[number]).map((body) => ({ ...body.of,
      colour: body.scenery ? [0.6, 0.63, 0.67] : bodyColour(body.name), scenery: body.scenery, bones: body.bones,
      weights: body.weights })), film.bounds(), floors.find((height) => height !== null));
    renderer.zoom = 1.3;  // no scenery in front of the body here
    orbit(canvas, renderer);
    window.tremoloFilm.renderer = renderer;
    playFilm(film, canvas, renderer, player);
  } catch (error) {
    stage.replaceChildren(element('p', { class: 'notice' }, `The motion cannot be shown: ${error.message}.`));
  }
  return data.live ? withLive(data.live, player, [canvas, controls, hint], part) : part;
}

// recorded: elements of the recording alone.
function withLive(path, player, recorded, part) {
  const live = element('iframe', { src: path, title: 'the live engine' });
  const choice = element('div', { class: 'choice', role: 'group', 'aria-label': 'what is shown' });
  const choose = (isLive) => {
    live.hidden = !isLive;
    for (const one of recorded) one.hidden = isLive;
    player.hidden = isLive;
    [...choice.children].forEach((button, k) => button.setAttribute('aria-pressed', isLive === (k === 0)));
  };
  for (const [text, isLive] of [['live: pull it', true], ['recorded', false]]) {
    const button = element('button', { type: 'button' }, text);
    button.onclick = () => choose(isLive);
    choice.append(button);
  }
  part.querySelector('.stage').append(live);
  part.prepend(choice);
  choose(true);
  return part;
}
