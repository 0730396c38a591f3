// Charts of curves as SVG: zoom, values under the pointer, curves that come and go by the legend.
// A chart is what to_json(Chart) of runtime/program/output/chart.h writes.

// A method looks the same on every page. Eight colours, dark enough for thin lines on white and
// apart for the colour-blind as far as eight can be, each with two dashes; marks tell the sixteen
// apart in print. Of one colour are two that are seldom in one picture.
const kMethods = ['ep4', 'imexv', 'newmark', 'implicit-euler', 'verlet', 'midpoint', 'imexv-linear',
  'imexv-adaptive', 'rk4', 'imexv-thesis', 'avf', 'explicit-euler', 'verlet4', 'ep2', 'imexv-coupled', 'rk2'];
const kInks = ['#0060a8', '#d95f02', '#1b9e77', '#7b3fa0', '#d01c6f', '#8c5a1e', '#1c2126', '#3aa6dd'];
const kDashes = ['', '8 4', '2 3', '10 3 2 3'];
const kMarks = ['circle', 'square', 'triangle', 'diamond', 'cross', 'plus', 'drop', 'star'];
const kMargin = { left: 66, right: 14, top: 30, bottom: 46 }; // of the axes, px
const kReach = 24; // px from the pointer to a point that it means
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

// Of all curves of a figure, by label and colour: the same label looks the same in all its charts.
// Methods have their places; others take the first that is free.
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

// x never falls: what is nearest to an x can then be looked up.
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

// What a curve's path goes through, in pixels; null is a gap. Of long series each column of pixels
// keeps its first, lowest, highest and last point, which looks the same.
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

// Marks of a line lie apart, and beside those of its neighbours.
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

// One chart. figure: what its panels share: looks, hidden labels, whether they zoom together.
class ChartPanel {
  constructor(chart, height, figure) {
    Object.assign(this, { chart, height, figure, zoom: { x: null, y: null }, now: null });
    this.svg = drawn('svg', { role: 'img', 'aria-label': chart.title || chart.y_label });
    this.told = element('div', { class: 'told', hidden: '' });
    this.panel = element('div', { class: 'panel', style: `height:${height}px` }, this.svg, this.told);
    this.svg.addEventListener('pointerdown', (event) => this.press(event));
    this.svg.addEventListener('pointermove', (event) => this.point(event));
    this.svg.addEventListener('pointerup', (event) => this.release(event));
    this.svg.addEventListener('pointercancel', () => this.drop());
    this.svg.addEventListener('pointerleave', () => this.tell(null));
    this.svg.addEventListener('dblclick', () => this.setZoom({ x: null, y: null }));
    this.svg.addEventListener('wheel', (event) => this.roll(event), { passive: false });
    new ResizeObserver(() => this.draw()).observe(this.panel);
  }

  shown() {
    return this.chart.curves.filter((curve) => !this.figure.hidden.has(curve.label));
  }

  // The range of an axis: what was zoomed to, what the chart says, or what its curves need.
  range(axis) {
    const { chart } = this, logarithmic = chart[`log_${axis}`], told = chart[`${axis}_range`];
    if (this.zoom[axis]) return this.zoom[axis];
    if (told && !(logarithmic && told[0] <= 0)) return told;
    const marks = chart.curves.some((curve) => curve.style.includes('points'));
    const curves = this.shown().length > 0 ? this.shown() : chart.curves;
    return rangeOf(curves.map((curve) => curve[axis]), logarithmic,
      { zero: axis === 'y' && chart.zero, room: axis === 'y' ? 0.05 : marks ? 0.03 : 0 });
  }

  draw() {
    const width = this.panel.clientWidth;
    if (width < 80) return;
    const { chart, height } = this, right = width - kMargin.right, bottom = height - kMargin.bottom;
    this.sx = makeScale(chart.log_x, this.range('x'), [kMargin.left, right]);
    this.sy = makeScale(chart.log_y, this.range('y'), [bottom, kMargin.top]);
    this.svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    const clip = `clip-${this.figure.number}-${this.figure.panels.indexOf(this)}`;
    const frame = { x: kMargin.left, y: kMargin.top, width: right - kMargin.left, height: bottom - kMargin.top };
    const inside = drawn('g', { 'clip-path': `url(#${clip})` });
    this.shown().forEach((curve) => inside.append(...this.curve(curve)));
    this.marks = drawn('g');
    this.line = drawn('line', { class: 'now', y1: kMargin.top, y2: bottom });
    this.box = drawn('rect', { class: 'box', width: 0, height: 0 });
    inside.append(this.line, this.marks, this.box);
    this.svg.replaceChildren(drawn('clipPath', { id: clip }, drawn('rect', frame)), ...this.axes(frame), inside);
    this.follow(this.now);
  }

  axes({ x, y, width, height }) {
    const { chart } = this, bottom = y + height, parts = [];
    for (const value of ticksOf(this.sy, height / 42)) {
      const at = this.sy.pixel(value);
      parts.push(drawn('line', { class: 'grid', x1: x, x2: x + width, y1: at, y2: at }),
        drawn('text', { x: x - 7, y: at + 4, 'text-anchor': 'end' }, shownNumber(value, 10)));
    }
    for (const value of ticksOf(this.sx, width / 80)) {
      const at = this.sx.pixel(value);
      parts.push(drawn('line', { class: 'grid', x1: at, x2: at, y1: y, y2: bottom }),
        drawn('text', { x: at, y: bottom + 17, 'text-anchor': 'middle' }, shownNumber(value, 10)));
    }
    parts.push(drawn('path', { class: 'frame', d: `M${x} ${y}V${bottom}H${x + width}` }),
      drawn('text', { class: 'title', x: x + width / 2, y: 17, 'text-anchor': 'middle' }, chart.title),
      drawn('text', { x: x + width / 2, y: bottom + 37, 'text-anchor': 'middle' }, chart.x_label),
      drawn('text', { 'text-anchor': 'middle', transform: `translate(13 ${y + height / 2}) rotate(-90)` }, chart.y_label));
    return parts;
  }

  curve(curve) {
    const look = this.figure.looks.get(curve), pixels = pixelsOf(curve, this.sx, this.sy), parts = [];
    const points = curve.style.includes('points');
    if (curve.style !== 'points')
      parts.push(drawn('path', { class: 'curve', d: linePath(pixels), stroke: look.colour, 'stroke-dasharray': look.dash }));
    const marked = points ? pixels.filter(Boolean) : look.many ? sparse(pixels, kMarks.indexOf(look.mark)) : [];
    if (marked.length > 0)
      parts.push(drawn('path', { class: 'mark', stroke: look.colour, fill: look.colour,
        d: marked.map(([x, y]) => markPath(look.mark, far(x), far(y), 3.2)).join('') }));
    return parts;
  }

  setZoom(zoom) {
    for (const panel of this.figure.linked ? this.figure.panels : [this]) {
      panel.zoom = { x: zoom.x, y: panel === this || !zoom.x ? zoom.y : panel.zoom.y };
      panel.draw();
    }
    this.tell(null);
  }

  place(event) {
    const box = this.svg.getBoundingClientRect(), scale = this.panel.clientWidth / box.width;
    return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
  }

  press(event) {
    if (event.button !== 0 || event.pointerType === 'touch') return;
    this.from = this.place(event);
    this.svg.setPointerCapture(event.pointerId);
  }

  // The stretch that is drawn: a flat one is of x alone, a steep one of y alone.
  stretch(to) {
    const [dx, dy] = [Math.abs(to[0] - this.from[0]), Math.abs(to[1] - this.from[1])];
    if (Math.max(dx, dy) < 6) return null;
    return { x: dx >= 14 || dy < 14, y: dy >= 14 || dx < 14 };
  }

  point(event) {
    const at = this.place(event);
    if (!this.from) {
      this.tell(at);
      return;
    }
    const axes = this.stretch(at), bottom = this.height - kMargin.bottom;
    const span = (k, whole, low, high) => (whole ? [Math.min(at[k], this.from[k]), Math.abs(at[k] - this.from[k])] : [low, high - low]);
    const [x, width] = span(0, axes?.x, kMargin.left, this.panel.clientWidth - kMargin.right);
    const [y, height] = span(1, axes?.y, kMargin.top, bottom);
    const box = axes ? { x, y, width, height } : { width: 0, height: 0 };
    for (const [name, value] of Object.entries(box)) this.box.setAttribute(name, value);
    this.tell(null);
  }

  release(event) {
    if (!this.from) return;
    const to = this.place(event), axes = this.stretch(to), from = this.from;
    this.drop();
    if (!axes) {
      if (this.chart.time) document.dispatchEvent(new CustomEvent('tremolo-seek', { detail: this.sx.value(to[0]) }));
      return;
    }
    const between = (scale, a, b) => [scale.value(Math.min(a, b)), scale.value(Math.max(a, b))].sort((p, q) => p - q);
    this.setZoom({ x: axes.x ? between(this.sx, from[0], to[0]) : this.zoom.x,
      y: axes.y ? between(this.sy, from[1], to[1]) : this.zoom.y });
  }

  drop() {
    this.from = null;
    this.box?.setAttribute('width', 0);
  }

  // The wheel with ctrl, as maps have it; alone it moves the page.
  roll(event) {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const factor = Math.exp(0.002 * event.deltaY), at = this.place(event);
    const grown = (scale, p, from, to) => [scale.value(p + (from - p) * factor), scale.value(p + (to - p) * factor)];
    this.setZoom({ x: grown(this.sx, at[0], kMargin.left, this.panel.clientWidth - kMargin.right),
      y: grown(this.sy, at[1], this.height - kMargin.bottom, kMargin.top) });
  }

  // Of each curve the point that a pointer there means: [curve, index, distance in px].
  nearest([px, py]) {
    const found = [];
    for (const curve of this.shown()) {
      let best = -1, least = Infinity;
      const sorted = ascends(curve), middle = sorted ? indexAt(curve, this.sx.value(px)) : 0;
      const first = sorted ? Math.max(0, middle - 1) : 0, last = sorted ? middle + 1 : curve.x.length;
      for (let i = first; i < Math.min(last, curve.x.length); ++i) {
        if (!isDrawn(curve, i)) continue;
        const dx = Math.abs(this.sx.pixel(curve.x[i]) - px);
        const distance = sorted ? dx : Math.hypot(dx, this.sy.pixel(curve.y[i]) - py);
        if (distance < least) [best, least] = [i, distance];
      }
      if (best < 0 || least > kReach) continue;
      found.push([curve, best, Math.hypot(this.sx.pixel(curve.x[best]) - px, this.sy.pixel(curve.y[best]) - py)]);
    }
    return found;
  }

  // Values at a place of the chart; null: none.
  tell(at) {
    const inside = at && at[0] >= kMargin.left && at[1] >= kMargin.top && at[1] <= this.height - kMargin.bottom;
    const found = inside ? this.nearest(at) : [];
    this.told.hidden = found.length === 0;
    this.marks?.replaceChildren();
    if (found.length === 0) return;
    const closest = found.reduce((a, b) => (b[2] < a[2] ? b : a));
    const rows = found.map(([curve, i]) => element('div', curve === closest[0] ? { class: 'closest' } : {},
      swatch(this.figure.looks.get(curve), curve), `${curve.label ? `${curve.label}: ` : ''}${shownNumber(curve.y[i])}`,
      curve.x[i] === closest[0].x[closest[1]] ? '' : ` at ${shownNumber(curve.x[i])}`));
    this.told.replaceChildren(
      element('b', {}, `${this.chart.x_label || 'x'}: ${shownNumber(closest[0].x[closest[1]])}`), ...rows);
    const over = at[0] > this.panel.clientWidth / 2;
    Object.assign(this.told.style, { left: over ? '' : `${at[0] + 16}px`,
      right: over ? `${this.panel.clientWidth - at[0] + 16}px` : '', top: `${kMargin.top}px` });
    for (const [curve, i] of found)
      this.marks.append(drawn('circle', { class: 'found', r: curve === closest[0] ? 4.5 : 3,
        cx: this.sx.pixel(curve.x[i]), cy: this.sy.pixel(curve.y[i]), stroke: this.figure.looks.get(curve).colour }));
  }

  // Where the film is.
  follow(time) {
    if (!this.chart.time) return;
    this.now = time;
    if (!this.line) return;
    this.line.style.display = time === null ? 'none' : '';
    if (time === null) return;
    for (const end of ['x1', 'x2']) this.line.setAttribute(end, far(this.sx.pixel(time)));
  }
}

function swatch(look, curve) {
  const svg = drawn('svg', { class: 'swatch-line', viewBox: '0 0 30 12', width: 30, height: 12 });
  if (curve.style !== 'points')
    svg.append(drawn('path', { class: 'curve', d: 'M0 6H30', stroke: look.colour, 'stroke-dasharray': look.dash }));
  if (curve.style.includes('points') || look.many)
    svg.append(drawn('path', { class: 'mark', d: markPath(look.mark, 15, 6, 3.2), stroke: look.colour, fill: look.colour }));
  return svg;
}

let figures = 0;

// A row of panels with one legend. linked: they zoom along x together.
function chartFigure({ charts, columns, height, caption, linked = false }) {
  const figure = { number: ++figures, looks: looksOf(charts), hidden: new Set(), panels: [], linked };
  figure.panels = charts.map((chart) => new ChartPanel(chart, height, figure));
  const entries = new Map();
  for (const curve of charts.flatMap((chart) => chart.curves))
    if (curve.label) entries.set(curve.label + curve.colour + curve.style, curve);
  const labels = [...new Set([...entries.values()].map((curve) => curve.label))];
  const redraw = () => {
    for (const button of buttons) button.setAttribute('aria-pressed', !figure.hidden.has(button.label));
    for (const panel of figure.panels) panel.draw();
  };
  const buttons = [...entries.values()].map((curve) => {
    const button = element('button', { type: 'button', title: 'hide or show; double click: this one alone' },
      swatch(figure.looks.get(curve), curve), curve.label);
    button.label = curve.label;
    button.onclick = () => {
      if (!figure.hidden.delete(curve.label)) figure.hidden.add(curve.label);
      redraw();
    };
    button.ondblclick = () => {
      const alone = figure.hidden.size === labels.length - 1 && !figure.hidden.has(curve.label);
      figure.hidden = new Set(alone ? [] : labels.filter((label) => label !== curve.label));
      redraw();
    };
    return button;
  });
  document.addEventListener('tremolo-time', (event) => figure.panels.forEach((panel) => panel.follow(event.detail)));
  redraw();
  return element('figure', {}, element('div', { class: 'drawing' },
    element('div', { class: 'panels', style: `grid-template-columns:repeat(${columns},1fr)` },
      ...figure.panels.map((panel) => panel.panel)),
    element('div', { class: 'legend' }, ...buttons),
    element('div', { class: 'hint' }, 'drag to zoom, double click to go back; a click in the legend hides, a double click shows one alone')),
    element('figcaption', {}, ...marked(caption)));
}
