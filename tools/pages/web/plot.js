// Plots of the pages of studies, by uPlot: layers of lines, points, bars and bands over common axes. A drag zooms, a double click shows all.
//
//   plot('place', {
//     x: { label, range: [low, high] }, y: the same,     // `names`: of rows, instead of numbers; `log`: logarithmic; `pad`: part of the range
//                                                        // that is shown beyond it, so that points at its ends are whole
//     height, layers: [layer, …],
//     pick: (layer, index) => …                          // the point that was clicked, of the layers that have `kept`: what each point is
//   })
//
// A layer has `kind`, `name` (what it shows, for tests), `colour` (a variable of page.css), `x` and `y` (lists; null: a gap), and
//   line    width, dash
//   points  size, shape: dot, ring or diamond; alpha
//   bars    y is the height above 0; `width` in units of x from each x
//   rows    a bar from `from` to `x` in the row `y`; `thick` in px
//   band    between `low` and `high` over x
//   rule    a line through the whole plot at x or at y; `text`
//   note    `text` at the right end of row y
import uPlot from 'uplot';
import { byId, make, show } from './elements.js';

export const plots = {};  // uPlot's object by the id of its place; `layers` has what it shows
const built = new Map();  // what draws each of them again
const NEAR = 14;          // px from a point that a click means
const CHARACTER = 6.6;    // px, about, of the font below
const FONT = '12px system-ui, sans-serif';

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Limits with some room; equal ones apart.
function widen({ range: [low, high], log, pad = 0 }) {
  if (log) return high > low ? [low, high] : [low / 10, high * 10];
  return high > low ? [low - pad * (high - low), high + pad * (high - low)] : [low - Math.abs(low) * 0.01 - 1e-9, high + Math.abs(high) * 0.01 + 1e-9];
}

export function message(place, text) {
  forget(place);
  byId(place).replaceChildren(make('p', text, { class: 'dim' }));
}

function forget(place) {
  plots[place]?.destroy();
  delete plots[place];
  built.delete(place);
}

// --- Paths of the layers, in pixels of the canvas ---------------------------------------------------------------------

function eachPoint(plot, { x, y }, call) {
  for (let i = 0; i < x.length; ++i)
    if (x[i] !== null && y[i] !== null) call(plot.valToPos(x[i], 'x', true), plot.valToPos(y[i], 'y', true), i);
}
const PATHS = {
  line(plot, layer) {
    const stroke = new Path2D();
    let drawn = -2;
    eachPoint(plot, layer, (x, y, i) => { if (i === drawn + 1) stroke.lineTo(x, y); else stroke.moveTo(x, y); drawn = i; });
    return { stroke };
  },
  points(plot, layer) {
    const path = new Path2D(), size = (layer.size ?? 3) * devicePixelRatio;
    eachPoint(plot, layer, (x, y) => {
      if (layer.shape === 'diamond') {
        path.moveTo(x, y - size);
        for (const [dx, dy] of [[size, 0], [0, size], [-size, 0]]) path.lineTo(x + dx, y + dy);
        path.closePath();
      } else {
        path.moveTo(x + size, y);
        path.arc(x, y, size, 0, 2 * Math.PI);
      }
    });
    return layer.shape === 'ring' ? { stroke: path } : { fill: path };
  },
  bars(plot, layer) {
    const fill = new Path2D(), base = plot.valToPos(0, 'y', true);
    eachPoint(plot, layer, (x, y, i) => {
      const end = plot.valToPos(layer.x[i] + layer.width, 'x', true);
      fill.rect(x, y, Math.max(devicePixelRatio, end - x - devicePixelRatio), base - y);
    });
    return { fill };
  },
  rows(plot, layer) {
    const fill = new Path2D(), thick = (layer.thick ?? 14) * devicePixelRatio;
    eachPoint(plot, layer, (x, y, i) => {
      const from = plot.valToPos(layer.from[i], 'x', true);
      fill.rect(Math.min(from, x), y - thick / 2, Math.max(devicePixelRatio, Math.abs(x - from)), thick);
    });
    return { fill };
  },
  band(plot, { x, low, high }) {
    const fill = new Path2D();
    const go = (i, list, k) => fill[k === 0 ? 'moveTo' : 'lineTo'](plot.valToPos(x[i], 'x', true), plot.valToPos(list[i], 'y', true));
    x.forEach((_, i) => go(i, high, i));
    for (let i = x.length - 1; i >= 0; --i) go(i, low, 1);
    fill.closePath();
    return { fill };
  },
  rule(plot, layer) {
    const stroke = new Path2D(), { left, top, width, height } = plot.bbox;
    if (layer.across) {
      const y = plot.valToPos(layer.at, 'y', true);
      stroke.moveTo(left, y);
      stroke.lineTo(left + width, y);
    } else {
      const x = plot.valToPos(layer.at, 'x', true);
      stroke.moveTo(x, top);
      stroke.lineTo(x, top + height);
    }
    return { stroke };
  },
  note: () => null,
};

// Texts of rules and notes.
function drawTexts(plot, layers) {
  const { ctx, bbox } = plot, inside = (v, scale) => v >= scale.min && v <= scale.max;
  ctx.save();
  ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  for (const layer of layers) {
    if (!layer.text) continue;
    ctx.fillStyle = css(layer.colour ?? 'ink');
    if (layer.kind === 'note') {
      ctx.textAlign = 'right';
      ctx.textBaseline = 'middle';
      ctx.fillText(layer.text, bbox.left + bbox.width + plot.room * devicePixelRatio - 2, plot.valToPos(layer.at, 'y', true));
    } else if (inside(layer.at, layer.across ? plot.scales.y : plot.scales.x)) {
      ctx.textAlign = 'left';
      ctx.textBaseline = layer.across ? 'bottom' : 'top';
      const x = layer.across ? bbox.left : plot.valToPos(layer.at, 'x', true), y = layer.across ? plot.valToPos(layer.at, 'y', true) : bbox.top;
      ctx.fillText(layer.text, x + 4 * devicePixelRatio, y);
    }
  }
  ctx.restore();
}

// --- The plot ---------------------------------------------------------------------------------------------------------

const DATA = { line: 1, points: 1, bars: 1, rows: 1 };
const listsOf = (layer) => (layer.kind in DATA ? [layer.x, layer.y] : [[0], [0]]);

function buildAxis(which, axis) {
  const common = { stroke: () => css('dim'), grid: { stroke: () => css('line'), width: 1 }, ticks: { show: false }, font: FONT, labelFont: FONT,
    label: axis.label, labelSize: axis.label ? 18 : 0, labelGap: 0, gap: 6 };
  if (axis.names) {
    return { ...common, grid: { show: false }, splits: () => axis.names.map((_, k) => k), values: () => axis.names,
      size: Math.min(220, 14 + CHARACTER * Math.max(...axis.names.map((name) => name.length))) };
  }
  const values = (_, ticks) => (axis.log ? ticks.map((tick) => (Math.abs(Math.log10(tick) % 1) < 1e-9 ? tick.toExponential(0) : '')) : ticks.map((tick) => show(tick, 6)));
  return which === 'x' ? { ...common, values, size: 26, space: 60 }
    : { ...common, values, size: (_, ticks) => Math.max(44, 14 + CHARACTER * Math.max(0, ...(ticks ?? []).map((text) => text.length))) };
}

function findNearest(plot, layers, left, top) {
  let best = null, least = NEAR;
  for (const layer of layers) {
    if (!layer.kept) continue;
    layer.x.forEach((x, i) => {
      if (x === null || layer.y[i] === null) return;
      const distance = Math.hypot(plot.valToPos(x, 'x') - left, plot.valToPos(layer.y[i], 'y') - top);
      if (distance < least) [best, least] = [{ layer, index: i }, distance];
    });
  }
  return best;
}

function build(place, { x, y, layers, height = 280, pick }) {
  plots[place]?.destroy();
  const node = byId(place), ranges = { x: widen(x), y: widen(y) };
  const notes = layers.filter((layer) => layer.kind === 'note').map((layer) => layer.text.length);
  const room = Math.max(14, ...notes.map((length) => 12 + CHARACTER * length));
  const scale = (key, axis) => ({ time: false, distr: axis.log ? 3 : 1, dir: axis.names ? -1 : 1,
    range: (_, low, high) => (low === null || low === undefined ? ranges[key] : [low, high]) });
  const plot = new uPlot({
    mode: 2, width: Math.max(node.clientWidth, 240), height, padding: [10, room, 0, 0],
    legend: { show: false },
    cursor: { x: false, y: false, points: { show: false }, dataIdx: () => null, drag: { x: true, y: true, dist: 6 } },
    scales: { x: scale('x', x), y: scale('y', y) },
    axes: [buildAxis('x', x), buildAxis('y', y)],
    series: [{}, ...layers.map((layer) => ({
      facets: [{ scale: 'x', auto: false }, { scale: 'y', auto: false }], points: { show: false }, alpha: layer.alpha ?? 1, width: layer.width && layer.kind === 'line' ? layer.width : 1.5,
      dash: layer.dash, stroke: () => css(layer.colour ?? 'ink'), fill: () => css(layer.colour ?? 'ink'),
      paths: (self) => PATHS[layer.kind](self, layer) }))],
    hooks: { draw: [(self) => { self.room = room; drawTexts(self, layers); }] },
  }, [null, ...layers.map(listsOf)], node);
  plot.batch(() => { for (const key of ['x', 'y']) plot.setScale(key, { min: ranges[key][0], max: ranges[key][1] }); });
  plot.over.addEventListener('dblclick', () => plot.batch(() => { for (const key of ['x', 'y']) plot.setScale(key, { min: ranges[key][0], max: ranges[key][1] }); }));
  if (pick) {
    plot.over.classList.add('picks');
    plot.over.addEventListener('click', (event) => {
      const box = plot.over.getBoundingClientRect(), found = findNearest(plot, layers, event.clientX - box.left, event.clientY - box.top);
      if (found) pick(found.layer, found.index);
    });
  }
  plot.layers = layers;
  plots[place] = plot;
  return plot;
}

export function plot(place, shown) {
  forget(place);
  const node = byId(place);
  node.replaceChildren();
  node.setAttribute('role', 'img');
  node.setAttribute('aria-label', [shown.y.label, shown.x.label].filter(Boolean).join(' over '));
  built.set(place, shown);
  return build(place, shown);
}

const widths = new ResizeObserver(() => {
  for (const [place, shown] of built) if (plots[place] && Math.abs(byId(place).clientWidth - plots[place].width) > 1) build(place, shown);
});
widths.observe(document.body);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { for (const [place, shown] of built) build(place, shown); });
