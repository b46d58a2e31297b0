// Curves over time: one time axis, one cursor, zoomed together. The time shown is a line in every plot; a click sets it.
import uPlot from 'uplot';
import { colour, css, dash, secondColour } from './colours.js';
import { digits, el, select } from './dom.js';
import { buildQuantities } from './quantities.js';
import { findLimits } from './verdict.js';

const HEIGHT = 210, WIDTH = 76;  // px, of a plot and of its axis: of all the same, so that times stand below one another
const MOST_SHOWN = 12;  // curves at first; the others are a click on their name away
const NOISE = 1e-6;     // of a quantity's size: less is rounding, and no axis is drawn for it
const SMALLEST = { N: 1e-6, 'N m': 1e-6 };  // the size of a quantity that is zero but for rounding; 1e-9 of other units
const CLICK = 4;        // px that the pointer may move during one
const GREAT = { N: [[2e6, 1e6, 'MN'], [2e3, 1e3, 'kN']], 'N m': [[2e6, 1e6, 'MN m'], [2e3, 1e3, 'kN m']] };

// Times of all runs' frames, in order.
function joinTimes(runs) {
  if (runs.length === 1) return runs[0].time;
  return Float64Array.from(new Set(runs.flatMap((run) => Array.from(run.time)))).sort();
}

function describeSampling({ frames, dt }) {
  if (frames.count === frames.seen) return `every tick (${digits(1 / dt)} Hz)`;
  return `every ${frames.every === 1 ? 'tick' : `${frames.every} ticks`} (${digits(1 / dt / frames.every)} Hz), and every tick within ${frames.around} of an event: `
    + `${frames.count} of ${frames.seen} states`;
}

// A run's values at those times; nothing outside of the run, and where it has no number.
function resample(run, values, times) {
  if (times === run.time && values.every(Number.isFinite)) return values;
  return Array.from(times, (t) => {
    if (t < run.first || t > run.last) return null;
    const { index, fraction } = run.find(t);
    const value = fraction === 0 ? values[index] : values[index] + fraction * (values[index + 1] - values[index]);
    return Number.isFinite(value) ? value : null;
  });
}

function calcLargest(curves) {
  let largest = 0;
  for (const curve of curves) for (const value of curve.values) if (Number.isFinite(value)) largest = Math.max(largest, Math.abs(value));
  return largest;
}

// Curves of one run that lie on one another take turns along the line, so that all of their colours are seen.
function calcDash(curve, curves, floor) {
  const PERIOD = 28;  // px
  const lies = (other) => other.run === curve.run && other.ranksFirst && other.values.length === curve.values.length
    && other.values.every((value, i) => !(Math.abs(value - curve.values[i]) > floor));
  const alike = curve.second || !curve.ranksFirst ? [] : curves.filter(lies);
  const k = alike.indexOf(curve);
  if (k < 1) return curve.second ? [4, 8] : dash(curve.colour);
  return [PERIOD * (alike.length - k) / alike.length, PERIOD * k / alike.length];
}

// Limits of an axis for values from `least` to `most`, at least `floor` apart.
function widen(least, most, floor) {
  if (least === null || most === null) return [-floor, floor];
  const lack = Math.max(0, floor - (most - least)) / 2;
  const gap = lack > 0 ? 0 : 0.06 * (most - least);
  return [least - lack - gap, most + lack + gap];
}

// As many digits as the ticks need to differ.
function writeTicks(ticks) {
  const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : 1;
  const size = Math.max(...ticks.map(Math.abs));
  const count = Math.min(12, Math.max(3, 2 + Math.ceil(Math.log10(Math.max(size / step, 1)))));
  return ticks.map((tick) => digits(Math.abs(tick) < 1e-9 * step ? 0 : tick, count));
}

// A scale that holds the limits too, but for those further away than the curves are high.
function reach(limits, low, high) {
  if (limits.length === 0 || low === null || high === null) return [low, high];
  const height = high - low;
  const near = limits.map((limit) => limit.value).filter((value) => value >= low - 2 * height && value <= high + 2 * height);
  return [Math.min(low, ...near), Math.max(high, ...near)];
}

// A dashed line for each limit, with the ids of its requirements.
function drawLimits(plot, limits) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = 'right';
  for (const { value, id, met } of limits) {
    if (value < plot.scales.y.min || value > plot.scales.y.max) continue;
    const y = Math.round(plot.valToPos(value, 'y', true)) + 0.5;
    ctx.strokeStyle = css(met ? '--good' : '--bad');
    ctx.fillStyle = ctx.strokeStyle;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.fillText(id, bbox.left + bbox.width - 4 * devicePixelRatio, y - 3 * devicePixelRatio);
  }
  ctx.restore();
}

export class Plots {
  constructor(runs, clock) {
    this.runs = runs;
    this.clock = clock;
    this.times = joinTimes(runs);
    this.events = [...new Set(runs.flatMap((run) => run.timeline().map((entry) => entry.t)))];
    this.cards = buildQuantities(runs).map((group) => this.buildCard(group));
    this.others = [];  // other plots that are painted with these
    const sampled = runs.map(describeSampling).filter((text, i, all) => all.indexOf(text) === i).join('; run B: ');
    this.node = el('div', { class: 'plots' },
      el('p', { class: 'note' }, `Sampled at ${sampled}. Triangles mark extremes, which are of every tick. A click goes to that time, a drag zooms, a double click shows all. Keys: space plays, ← → step, shift ← → go by event.`),
      this.cards.map((card) => card.node));
    this.visible = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const card = this.cards.find((candidate) => candidate.node === entry.target);
        card.visible = entry.isIntersecting;
        if (card.visible) this.moveTo(card);
      }
    });
    for (const card of this.cards) this.visible.observe(card.node);
    this.sizes = new ResizeObserver(() => { for (const card of this.cards) card.plot?.setSize(this.size(card)); });
    this.sizes.observe(this.node);
    clock.listen(() => { for (const card of this.cards) if (card.visible) this.moveTo(card); });
  }

  buildCard(group) {
    const card = { group, choice: group.choices[0], body: el('div', { class: 'plot' }), left: el('small', {}), shown: new Map(), fresh: true };
    const names = group.choices.map((choice, i) => [i, choice.name]);
    card.node = el('section', { class: 'card' },
      el('div', { class: 'cardhead' }, el('h2', {}, group.title), el('small', {}, group.note), el('span', { class: 'grow' }),
        names.length > 1 ? select('of', names, 0, (value) => { card.choice = group.choices[value]; card.shown.clear(); card.fresh = true; this.paintCard(card); }) : null),
      card.body, card.left);
    return card;
  }

  size(card) { return { width: Math.max(card.body.clientWidth, 200), height: HEIGHT }; }

  paint() {
    for (const card of this.cards) this.paintCard(card);
    for (const other of this.others) other();
  }

  // Curves of both runs, those of B dashed, in the unit that suits their size.
  buildCurves(card) {
    const built = new Map();  // by choice, for each run
    const build = (choice) => built.get(choice) ?? built.set(choice, this.runs.map((run) => choice.build(run))).get(choice);
    const curves = build(card.choice).flatMap((own, r) => own.map((curve) => ({ ...curve, run: this.runs[r], second: r > 0 })));
    const largest = calcLargest(curves);
    card.size ??= new Map();  // of the quantity, by unit: of all components together
    if (!card.size.has(card.choice.unit)) {
      const alike = card.group.choices.filter((choice) => choice.unit === card.choice.unit);
      card.size.set(card.choice.unit, calcLargest(alike.flatMap((choice) => build(choice).flat())));
    }
    const floor = Math.max(NOISE * card.size.get(card.choice.unit), SMALLEST[card.choice.unit] ?? 1e-9);
    const [, scale, unit] = (GREAT[card.choice.unit] ?? []).find(([least]) => largest >= least) ?? [0, 1, card.choice.unit];
    // The largest are drawn, the same ones of both runs; where that is said otherwise, by rank.
    const ranks = new Map();
    for (const curve of curves) ranks.set(curve.name, Math.max(ranks.get(curve.name) ?? -Infinity, curve.rank ?? calcLargest([curve])));
    const first = new Set([...ranks.keys()].sort((a, b) => ranks.get(b) - ranks.get(a)).slice(0, MOST_SHOWN));
    for (const curve of curves) {
      curve.ranksFirst = first.has(curve.name);
      if (scale !== 1) curve.values = Float64Array.from(curve.values, (value) => value / scale);
      curve.marks = curve.marks.filter((mark) => mark.t !== null && Number.isFinite(mark.value)).map((mark) => ({ ...mark, value: mark.value / scale }));
      curve.values = resample(curve.run, curve.values, this.times);
    }
    card.left.textContent = ranks.size > MOST_SHOWN
      ? `${MOST_SHOWN} of ${ranks.size} curves are drawn, those with the ${curves[0].rank === undefined ? 'largest' : 'smallest'} values; a click on a name shows or hides one` : '';
    const limits = findLimits(this.runs, card.group, card.choice).map((limit) => ({ ...limit, value: limit.value / scale }));
    return { curves, unit, floor: floor / scale, limits };
  }

  paintCard(card) {
    const { curves, unit, floor, limits } = this.buildCurves(card);
    card.limits = limits;
    const axis = { stroke: css('--faint'), grid: { stroke: css('--line'), width: 1 }, ticks: { stroke: css('--line'), width: 1, size: 4 },
      font: '11px system-ui, sans-serif', labelFont: '11px system-ui, sans-serif', labelSize: 16, labelGap: 0 };
    const zoom = card.plot ? { ...card.plot.scales.x } : null;
    card.plot?.destroy();
    card.plot = new uPlot({
      ...this.size(card),
      // Limits within reach of the curves widen the scale; others would flatten them.
      scales: { x: { time: false }, y: { range: (plot, least, most) => this.chooseRange(card, plot, ...reach(limits, least, most), floor) } },
      axes: [{ ...axis, label: 'time, s', size: 30 },
        { ...axis, label: unit === '1' ? '' : unit, size: (_, ticks) => Math.max(WIDTH, 24 + 6.5 * Math.max(0, ...(ticks ?? []).map((text) => text.length))), values: (_, ticks) => writeTicks(ticks) }],
      series: [{ label: 't, s', value: (_, value) => (value === null ? '' : digits(value, 7)) }, ...curves.map((curve, i) => ({
        label: this.runs.length > 1 ? `${curve.run.label} ${curve.name}` : curve.name, stroke: curve.second ? secondColour(curve.colour) : colour(curve.colour), width: curve.second ? 1.6 : 1.5,
        dash: calcDash(curve, curves, floor), spanGaps: true, points: { show: false },
        show: card.shown.get(i) ?? curve.ranksFirst, value: (_, value) => digits(value, 5) }))],
      cursor: { sync: { key: 'time', setSeries: false, scales: ['x', null] }, y: false, drag: { x: true, y: false },
        points: { size: 6 } },
      hooks: { drawClear: [(plot) => this.drawEvents(plot)], draw: [(plot) => this.drawMarks(plot, curves), (plot) => drawLimits(plot, limits), () => this.moveTo(card)],
        setSeries: [(plot, i) => { if (i) card.shown.set(i - 1, plot.series[i].show); }] },
    }, [this.times, ...curves.map((curve) => curve.values)], card.body);
    const { window } = card.choice;
    if (card.fresh && window) card.plot.setScale('x', { min: window.x[0], max: window.x[1] });
    else if (zoom && !card.fresh && (zoom.min > this.clock.first || zoom.max < this.clock.last)) card.plot.setScale('x', zoom);
    card.fresh = false;
    this.addPointer(card);
    this.moveTo(card);
  }

  // The heights of a choice's own window while its times are shown; else of the values, but no less than `floor`.
  chooseRange(card, plot, least, most, floor) {
    const { window } = card.choice;
    const { min, max } = plot.scales.x;
    if (window && min >= window.x[0] - 1e-9 && max <= window.x[1] + 1e-9) return window.y;
    return widen(least, most, floor);
  }

  drawEvents(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = css('--event');
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (const t of this.events) {
      if (t < plot.scales.x.min || t > plot.scales.x.max) continue;
      const x = Math.round(plot.valToPos(t, 'x', true)) + 0.5;
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
    }
    ctx.stroke();
    ctx.restore();
  }

  drawMarks(plot, curves) {
    const { ctx, bbox } = plot;
    const size = 4.5 * devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top - size, bbox.width, bbox.height + 2 * size);
    ctx.clip();
    curves.forEach((curve, i) => {
      if (!plot.series[i + 1].show) return;
      ctx.fillStyle = curve.second ? secondColour(curve.colour) : colour(curve.colour);
      for (const { t, value } of curve.marks) {
        const x = plot.valToPos(t, 'x', true), y = plot.valToPos(value, 'y', true);
        ctx.beginPath();
        ctx.moveTo(x, y);
        ctx.lineTo(x - size, y - 1.6 * size);
        ctx.lineTo(x + size, y - 1.6 * size);
        ctx.fill();
      }
    });
    ctx.restore();
  }

  addPointer(card) {
    const { over } = card.plot;
    card.now = over.appendChild(el('div', { class: 'now' }));
    let pressed = null;
    over.addEventListener('mousedown', (event) => { pressed = event.clientX; });
    over.addEventListener('mouseup', (event) => {
      if (pressed === null || Math.abs(event.clientX - pressed) > CLICK) return;
      this.clock.play(false);
      this.clock.set(card.plot.posToVal(event.clientX - over.getBoundingClientRect().left, 'x'));
    });
    over.addEventListener('mouseleave', () => requestAnimationFrame(() => {
      for (const other of this.cards) if (other.visible) this.moveTo(other);
    }));
  }

  // The line of the time shown, and the values there, unless the pointer asks for others.
  moveTo(card) {
    if (!card.plot || !card.now) return;
    const left = card.plot.valToPos(this.clock.t, 'x');
    const inside = left >= 0 && left <= card.plot.over.clientWidth;
    card.now.style.display = inside ? '' : 'none';
    card.now.style.transform = `translateX(${left}px)`;
    if (!this.cards.some((other) => other.plot?.over.matches(':hover'))) card.plot.setCursor({ left, top: 0 }, false);
  }
}
