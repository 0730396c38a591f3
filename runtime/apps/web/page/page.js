// The page: a body that the reader can pull. Steps are made in real time between two pictures, as
// many as the time since the last one requires; the picture is interpolated between the last two
// states.
const kFirst = 'horse';
const kShown = 10; // seconds of energy in the plot
const kBudget = 12;  // ms of a frame that steps may take; the excess is shown as lag

const get = (id) => document.getElementById(id);
const canvas = get('scene');
const say = (text) => { get('message').textContent = text; };

const started = performance.now();
let tremolo, renderer;
try {
  renderer = new Renderer(canvas);
  tremolo = await loadTremolo({ wasmBinary: tremoloWasm() });
} catch (error) {
  say(error.message);
  throw error;
}
const page = { model: null, body: null, hand: null, before: null, now: null, energies: [], owed: 0,
  lag: 0, paused: false, name: '', stepCost: 0, firstFrame: 0 };
window.tremoloPage = page; // for tests, and for the curious

for (const name of tremolo.integrators) get('integrator').add(new Option(name, name));
get('integrator').value = 'ep4';
for (const name of tremoloModelNames) get('model').add(new Option(name, name));

// The bytes of a sample model, from the page or from a file in its folder.
function bytesOf(name) {
  if (tremoloModels[name]) return Promise.resolve(tremoloModels[name]);
  return new Promise((resolve, reject) => {
    tremoloWaiting[name] = resolve;
    const script = document.createElement('script');
    script.src = `models/${name}.js`;
    script.onerror = () => reject(new Error(`models/${name}.js is not beside the page`));
    document.head.append(script);
  });
}

function fail(error) {
  say(error.message);
  page.paused = true;
}

function options() {
  const step = 1e-3 * Number(get('step').value), beta = 1e-3 * Number(get('beta').value);
  return { integrator: get('integrator').value, step, beta };
}

// A body with the state of the one before.
function makeBody(keep) {
  const state = keep && page.body ? page.body.state() : null;
  const body = page.model.createBody(options());
  body.setContact();
  if (state) body.setState(state.q, state.p);
  page.body?.release();
  page.body = body;
  page.hand = null;
  page.now = page.before = Float64Array.from(body.state().q);
  page.owed = 0;
}

function open(bytes, name) {
  const model = tremolo.loadModel(bytes);
  try {
    const { rest, shapes } = model.shapes();
    const corners = model.corners();
    renderer.show([{ rest, shapes, corners, modes: model.modes, colour: bodyColour(name) }]);
    page.shapes = shapes;
    page.lambda = model.frequencies().map((f) => (2 * Math.PI * f) ** 2);
  } catch (error) {
    model.release();
    throw error;
  }
  page.body?.release();
  page.body = null;
  page.model?.release();
  page.model = model;
  page.name = name;
  page.energies = [];
  page.paused = false;
  makeBody(false);
  kick(0.6);
}

async function choose(name) {
  try {
    open(await bytesOf(name), name);
    say('');
  } catch (error) {
    fail(error);
  }
}

// Compliance of a vertex, m/N, and its inverse mass, 1/kg, both means over the directions.
function give(vertex) {
  const { shapes, lambda } = page;
  const n = 3 * page.model.vertices;
  let soft = 0, light = 0;
  for (let i = 0; i < page.model.modes; ++i) {
    const at = i * n + 3 * vertex;
    const square = (shapes[at] ** 2 + shapes[at + 1] ** 2 + shapes[at + 2] ** 2) / 3;
    soft += square / lambda[i];
    light += square;
  }
  return { soft, light };
}

// A blow that the softest coordinates feel, of the given part of the body's size.
function kick(strength = 1) {
  const { q, p } = page.body.state();
  const n = 3 * page.model.vertices;
  for (let i = 0; i < Math.min(3, p.length); ++i) {
    let most = 0;
    for (let k = 0; k < n; k += 3)
      most = Math.max(most, Math.hypot(...page.shapes.subarray(i * n + k, i * n + k + 3)));
    const reach = (0.12 * strength * renderer.size) / most / (1 + i);
    p[i] += (i % 2 === 0 ? 1 : -1) * reach * Math.sqrt(page.lambda[i]);
  }
  page.body.setState(q, p);
}

function step() {
  page.before = page.now;
  const begun = performance.now();
  page.body.step(1);
  page.stepCost += 0.05 * (performance.now() - begun - page.stepCost);
  page.now = page.body.state().q;
}

let last = performance.now();
function frame(time) {
  requestAnimationFrame(frame);
  if (canvas.width !== canvas.clientWidth * devicePixelRatio || canvas.height !== canvas.clientHeight * devicePixelRatio) {
    canvas.width = Math.max(1, canvas.clientWidth * devicePixelRatio);
    canvas.height = Math.max(1, canvas.clientHeight * devicePixelRatio);
  }
  const passed = Math.min(0.1, 1e-3 * Math.max(0, time - last));
  last = time;
  if (!page.body) return;
  const speed = 10 ** Number(get('speed').value), h = options().step;
  try {
    if (!page.paused && h > 0) {
      page.owed += passed * speed;
      const begun = performance.now();
      while (page.owed >= h && performance.now() - begun < kBudget) {
        step();
        page.owed -= h;
      }
      page.lag = page.owed >= h ? page.owed - h : 0;
      if (page.lag > 0) page.owed = h;
      const energy = page.body.energy();
      page.energies.push([page.body.time, energy.total, energy.kinetic]);
      while (page.energies.length > 2000 || page.energies[0][0] < page.body.time - kShown)
        page.energies.shift();
    }
  } catch (error) {
    fail(error);
  }
  const share = Math.min(1, Math.max(0, page.owed / h));
  const q = page.now.map((x, i) => page.before[i] + share * (x - page.before[i]));
  renderer.draw([{ q }], { heat: get('colour').value === 'displacement' });
  if (!page.firstFrame) page.firstFrame = performance.now() - started;
  page.frames = (page.frames ?? 0) + 1;
  if (page.frames % 4 === 0) tell();
}

function tell() {
  const plot = get('plot'), context = plot.getContext('2d');
  plot.width = plot.clientWidth * devicePixelRatio;
  plot.height = plot.clientHeight * devicePixelRatio;
  const end = page.body.time, most = Math.max(1e-300, ...page.energies.map((e) => e[1]));
  const curve = (column, colour) => {
    context.strokeStyle = colour;
    context.lineWidth = 1.5 * devicePixelRatio;
    context.beginPath();
    for (const row of page.energies)
      context.lineTo((1 - (end - row[0]) / kShown) * plot.width,
        plot.height * (1 - 0.92 * (row[column] / most)) - 2);
    context.stroke();
  };
  curve(2, '#9db4d8');
  curve(1, '#1f4e9c');
  const energy = page.energies.at(-1)?.[1] ?? 0;
  const lag = page.lag > 0 ? `, ${(1e3 * page.lag).toFixed(0)} ms behind` : '';
  get('readout').textContent =
      `t = ${end.toFixed(2)} s, energy ${energy.toPrecision(4)} J (kinetic pale), ` +
      `${(1e3 * page.stepCost).toFixed(0)} µs a step${lag}`;
}

// Pulling: the hand holds the point under the pointer, at its distance from the eye.
const pointers = new Map();
function rayOf(event) {
  const box = canvas.getBoundingClientRect();
  return renderer.ray((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
}
canvas.addEventListener('pointerdown', (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, event);
  if (!page.body || page.hand !== null || pointers.size > 1) return;
  const { origin, direction } = rayOf(event);
  const hit = page.body.pick(origin, direction);
  if (!hit) return;
  const corners = page.model.corners();
  const best = [0, 1, 2].reduce((a, b) => (hit.weights[b] > hit.weights[a] ? b : a), 0);
  const { soft, light } = give(corners[3 * hit.triangle + best]);
  const stiffness = 2 / soft;
  page.hand = { number: page.body.grab(hit, stiffness, Math.sqrt(stiffness / light)),
    depth: hit.distance, pointer: event.pointerId };
  canvas.style.cursor = 'grabbing';
});
canvas.addEventListener('pointermove', (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  pointers.set(event.pointerId, event);
  if (page.hand?.pointer === event.pointerId) {
    const { origin, direction } = rayOf(event);
    const length = Math.hypot(...direction);
    page.body.moveHand(page.hand.number, origin.map((x, k) => x + (page.hand.depth / length) * direction[k]));
    return;
  }
  renderer.turn[0] -= 0.006 * (event.clientX - before.clientX);
  renderer.turn[1] = Math.min(1.5, Math.max(-0.1, renderer.turn[1] + 0.006 * (event.clientY - before.clientY)));
});
function leave(event) {
  pointers.delete(event.pointerId);
  if (page.hand?.pointer !== event.pointerId) return;
  page.body.letGo(page.hand.number);
  page.hand = null;
  canvas.style.cursor = 'grab';
}
canvas.addEventListener('pointerup', leave);
canvas.addEventListener('pointercancel', leave);
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  renderer.zoom = Math.min(20, Math.max(0.2, renderer.zoom * Math.exp(-0.001 * event.deltaY)));
}, { passive: false });

get('model').addEventListener('change', () => choose(get('model').value));
for (const id of ['integrator', 'step'])
  get(id).addEventListener('change', () => {
    try {
      makeBody(true);
      say('');
      page.paused = false;
    } catch (error) {
      fail(error);
    }
  });
get('beta').addEventListener('change', () => {
  try {
    page.body.setDamping(0, options().beta);
    say('');
  } catch (error) {
    say(error.message);
  }
});
get('kick').addEventListener('click', () => { page.paused = false; kick(); });
get('pause').addEventListener('click', () => { page.paused = !page.paused; });
get('reset').addEventListener('click', () => {
  page.paused = false;
  say('');
  page.energies = [];
  makeBody(false);
});
addEventListener('dragover', (event) => event.preventDefault());
addEventListener('drop', async (event) => {
  event.preventDefault();
  const file = event.dataTransfer.files[0];
  if (!file) return;
  try {
    open(new Uint8Array(await file.arrayBuffer()), file.name);
    say('');
  } catch (error) {
    say(`${file.name}: ${error.message}`);
  }
});

get('model').value = kFirst;
await choose(kFirst);
requestAnimationFrame(frame);
