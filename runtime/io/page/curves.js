// Curves of charts: their colours and dashes, the range of their axes, and their points.

// A method looks the same on every page. There are eight colours, dark enough for thin lines on
// white and as different for the colour-blind as eight can be, each with two dashes; marks
// distinguish the sixteen in print. Methods of the same colour rarely appear in one picture.
const kMethods = ['ep4', 'imexv', 'newmark', 'implicit-euler', 'verlet', 'midpoint', 'imexv-linear',
  'imexv-adaptive', 'rk4', 'imexv-thesis', 'avf', 'explicit-euler', 'verlet4', 'ep2', 'imexv-coupled', 'rk2'];
const kInks = ['#0060a8', '#d95f02', '#1b9e77', '#7b3fa0', '#d01c6f', '#8c5a1e', '#1c2126', '#3aa6dd'];
const kDashes = ['', '8 4', '2 3', '10 3 2 3'];
const kMarks = ['circle', 'square', 'triangle', 'diamond', 'cross', 'plus', 'drop', 'star'];
const kMany = 5; // curves from which on lines have marks

const kSvg = (() => {
  const probe = document.createElement('div');
  probe.innerHTML = '<svg></svg>';
  return probe.firstChild.namespaceURI;
})();

function drawn(tag, attributes = {}, ...children) {
  const made = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function lookOfNumber(k) {
  return { colour: kInks[k % 8], dash: kDashes[Math.floor(k / 8) % 4], mark: kMarks[(k + Math.floor(k / 8)) % 8] };
}

// Looks of all curves of a figure, by label: the same label looks the same in all its charts.
// Methods have fixed looks; others take the first free one.
function looksOf(charts) {
  const looks = new Map(), labels = [], numbers = new Map(), taken = new Set();
  for (const curve of charts.flatMap((chart) => chart.curves))
    if (!labels.includes(curve.label)) labels.push(curve.label);
  for (const label of labels) {
    const method = kMethods.indexOf(label);
    if (method < 0) continue;
    numbers.set(label, method);
    taken.add(method);
  }
  let free = 0;
  for (const label of labels) {
    if (numbers.has(label)) continue;
    while (taken.has(free)) ++free;
    numbers.set(label, free++);
  }
  for (const curve of charts.flatMap((chart) => chart.curves)) {
    const look = lookOfNumber(numbers.get(curve.label));
    if (curve.colour) Object.assign(look, { colour: curve.colour, dash: '' });
    if (curve.style === 'dashes') look.dash = '8 5';
    looks.set(curve, { ...look, many: labels.length > kMany });
  }
  return looks;
}

function markPath(kind, x, y, r) {
  const s = 0.89 * r, t = 1.15 * r, n = (value) => value.toFixed(1);
  const polygon = (...at) => `M${at.map(([a, b]) => `${n(x + a)} ${n(y + b)}`).join('L')}Z`;
  switch (kind) {
    case 'square': return polygon([-s, -s], [s, -s], [s, s], [-s, s]);
    case 'triangle': return polygon([0, -t], [t, 0.8 * t], [-t, 0.8 * t]);
    case 'drop': return polygon([0, t], [t, -0.8 * t], [-t, -0.8 * t]);
    case 'diamond': return polygon([0, -1.3 * r], [1.3 * r, 0], [0, 1.3 * r], [-1.3 * r, 0]);
    case 'cross': return `M${n(x - s)} ${n(y - s)}l${n(2 * s)} ${n(2 * s)}m0 ${n(-2 * s)}l${n(-2 * s)} ${n(2 * s)}`;
    case 'plus': return `M${n(x - t)} ${n(y)}h${n(2 * t)}M${n(x)} ${n(y - t)}v${n(2 * t)}`;
    case 'star': return markPath('cross', x, y, 0.9 * r) + markPath('plus', x, y, r);
    default: return `M${n(x - r)} ${n(y)}a${r} ${r} 0 1 0 ${n(2 * r)} 0a${r} ${r} 0 1 0 ${n(-2 * r)} 0Z`;
  }
}

function shownNumber(value, digits = 6) {
  const number = Number(value.toPrecision(digits)), size = Math.abs(number);
  return size > 0 && (size < 1e-3 || size >= 1e6) ? number.toExponential() : String(number);
}

// An axis from `low` to `high` over the pixels from `from` to `to`.
function makeScale(logarithmic, [low, high], [from, to]) {
  const f = logarithmic ? Math.log10 : (v) => v, back = logarithmic ? (v) => 10 ** v : (v) => v;
  const a = f(low), width = f(high) - a || 1;
  return { logarithmic, low, high, pixel: (v) => from + ((f(v) - a) / width) * (to - from),
    value: (p) => back(a + ((p - from) / (to - from)) * width) };
}

function ticksOf(scale, count) {
  const { low, high } = scale, decades = scale.logarithmic ? Math.log10(high / low) : 0;
  const ticks = [];
  if (decades > 0.7) {
    const every = Math.max(1, Math.ceil(decades / count));
    const leads = decades * 3 <= count && decades < 3 ? [1, 2, 5] : [1];
    for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); ++e)
      for (const lead of leads) {
        const value = lead * 10 ** e;
        if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9) && e % every === 0) ticks.push(value);
      }
    return ticks;
  }
  const raw = (high - low) / Math.max(2, count), unit = 10 ** Math.floor(Math.log10(raw));
  const step = unit * [1, 2, 5, 10].find((lead) => lead * unit >= raw * (1 - 1e-9));
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push(k * step);
  return ticks;
}

const isDrawn = (curve, i) => curve.x[i] !== null && curve.y[i] !== null;

// True if x never falls, so that an x can be searched.
function ascends(curve) {
  if (curve.ascends === undefined) {
    const x = curve.x.filter((value) => value !== null);
    curve.ascends = x.every((value, i) => i === 0 || value >= x[i - 1]) && x.length === curve.x.length;
  }
  return curve.ascends;
}

// The first index whose x is not below the value.
function indexAt(curve, value) {
  let low = 0, high = curve.x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (curve.x[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Points of a curve's path, in pixels; null is a gap. For long series only the first, lowest,
// highest and last point of each column of pixels are kept, which gives the same picture.
function pixelsOf(curve, sx, sy) {
  const sorted = ascends(curve), end = curve.x.length;
  const first = sorted ? Math.max(0, indexAt(curve, sx.low) - 1) : 0;
  const last = sorted ? Math.min(end, indexAt(curve, sx.high) + 2) : end;
  const at = (i) => (isDrawn(curve, i) ? [sx.pixel(curve.x[i]), sy.pixel(curve.y[i])] : null);
  const all = [];
  if (!sorted || last - first < 3000) {
    for (let i = first; i < last; ++i) all.push(at(i));
    return all;
  }
  for (let i = first; i < last;) {
    const column = Math.floor(sx.pixel(curve.x[i]));
    let low = i, high = i, end = i;
    for (; end < last && Math.floor(sx.pixel(curve.x[end])) === column; ++end) {
      if (curve.y[end] !== null && !(curve.y[end] >= curve.y[low])) low = end;
      if (curve.y[end] !== null && !(curve.y[end] <= curve.y[high])) high = end;
    }
    for (const k of [...new Set([i, low, high, end - 1])].sort((a, b) => a - b)) all.push(at(k));
    i = end;
  }
  return all;
}

const far = (v) => Math.min(1e5, Math.max(-1e5, v)); // what renderers take without trouble

function linePath(pixels) {
  let path = '', pen = false;
  for (const at of pixels) {
    path += at ? `${pen ? 'L' : 'M'}${far(at[0]).toFixed(1)} ${far(at[1]).toFixed(1)}` : '';
    pen = at !== null;
  }
  return path;
}

// Marks of a line are spaced, and offset from those of its neighbours.
function sparse(pixels, number) {
  const chosen = [];
  let next = -Infinity;
  for (const at of pixels) {
    if (!at) continue;
    if (next === -Infinity) next = at[0] + 12 + 11 * (number % 8);
    if (at[0] < next) continue;
    chosen.push(at);
    next = at[0] + 96;
  }
  return chosen;
}

function rangeOf(values, logarithmic, { zero = false, room = 0 }) {
  let low = Infinity, high = -Infinity;
  for (const list of values)
    for (const v of list)
      if (v !== null) {
        if (v < low) low = v;
        if (v > high) high = v;
      }
  if (!(low <= high)) return logarithmic ? [0.1, 1] : [0, 1];
  if (logarithmic) {
    const grown = Math.max(room, low === high ? 0.3 : 0) * Math.log10(Math.max(high / low, 10));
    return [low / 10 ** grown, high * 10 ** grown];
  }
  if (zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
  if (zero && low === high) return [0, 1];
  const width = high - low || Math.abs(high) || 1;
  return [zero && low === 0 ? 0 : low - room * width, zero && high === 0 ? 0 : high + room * width];
}

function swatch(look, curve) {
  const svg = drawn('svg', { class: 'swatch-line', viewBox: '0 0 30 12', width: 30, height: 12 });
  if (curve.style !== 'points')
    svg.append(drawn('path', { class: 'curve', d: 'M0 6H30', stroke: look.colour, 'stroke-dasharray': look.dash }));
  if (curve.style.includes('points') || look.many)
    svg.append(drawn('path', { class: 'mark', d: markPath(look.mark, 15, 6, 3.2), stroke: look.colour, fill: look.colour }));
  return svg;
}
