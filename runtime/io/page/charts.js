// Charts of curves as SVG, with zoom, values under the pointer, and curves that the legend
// switches. Their data are the output of to_json(Chart) in runtime/apps/tremolo/output/chart.h.
const kMargin = { left: 66, right: 14, top: 30, bottom: 46 }; // of the axes, px
const kReach = 24; // px from the pointer to a point that it means

// One chart. figure: the common state of its panels: looks, hidden labels, linked zoom.
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

  // The range of an axis: the zoomed one, else the chart's own, else that of its curves.
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

  // The selected range: a flat selection is of x alone, a steep one of y alone.
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
      this.play(to);
      if (this.chart.time) document.dispatchEvent(new CustomEvent('tremolo-seek', { detail: this.sx.value(to[0]) }));
      return;
    }
    const between = (scale, a, b) => [scale.value(Math.min(a, b)), scale.value(Math.max(a, b))].sort((p, q) => p - q);
    this.setZoom({ x: axes.x ? between(this.sx, from[0], to[0]) : this.zoom.x,
      y: axes.y ? between(this.sy, from[1], to[1]) : this.zoom.y });
  }

  // Plays the loop of the film that belongs to the closest point.
  play(at) {
    const found = this.nearest(at).filter(([curve]) => curve.loops);
    if (found.length === 0) return;
    const [curve, i] = found.reduce((a, b) => (b[2] < a[2] ? b : a));
    document.dispatchEvent(new CustomEvent('tremolo-loop', { detail: curve.loops[i] }));
  }

  drop() {
    this.from = null;
    this.box?.setAttribute('width', 0);
  }

  // The wheel zooms with ctrl, as in maps; alone it scrolls the page.
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

  // Shows the values at a point of the chart; null: none.
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

  // Marks the time of the film.
  follow(time) {
    if (!this.chart.time) return;
    this.now = time;
    if (!this.line) return;
    this.line.style.display = time === null ? 'none' : '';
    if (time === null) return;
    for (const end of ['x1', 'x2']) this.line.setAttribute(end, far(this.sx.pixel(time)));
  }
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
