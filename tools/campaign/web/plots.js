// The quantities of a campaign and their plots.
import { byId, data, make, show, withUnit } from '../../pages/web/elements.js';
import { message, plot } from '../../pages/web/plot.js';
import { command } from './commands.js';

const { summary, manifest } = data;

export const quantities = [
  ...summary.columns.map((column, k) => ({ ...manifest.columns[k], values: data.columns[k], of: column, distribution: data.column_distributions[k] })),
  ...manifest.inputs.map((input, k) => ({ ...input, kind: 'input', values: data.inputs[k], of: summary.inputs[k], distribution: data.input_distributions[k] })),
];
export const find = (name) => quantities.find((q) => q.name === name);
const requirementOf = (quantity) => summary.requirements.find((r) => r.id === quantity.name);

export function showDistribution() {
  const quantity = quantities[byId('quantity').value];
  const distribution = quantity.distribution;  // of all samples
  const requirement = requirementOf(quantity);
  const limits = requirement ? [requirement.at_least, requirement.at_most].filter((v) => v !== null) : [];
  const label = withUnit(quantity.name, quantity.unit);
  byId('moments').textContent = `${quantity.of.count} values, ${quantity.of.missing} missing; mean ${show(quantity.of.mean)}, standard deviation ${show(quantity.of.deviation)}, ` +
    `${quantity.of.quantiles['0.5'] === null ? `least ${show(quantity.of.min)}, greatest ${show(quantity.of.max)}`
      : `1 % ${show(quantity.of.quantiles['0.01'])}, median ${show(quantity.of.quantiles['0.5'])}, 99 % ${show(quantity.of.quantiles['0.99'])}`} ${quantity.unit}`;
  showTornado(quantity);
  showConvergence(requirement);
  if (!distribution) { message('histogram', 'No sample has this value.'); message('cdf', ''); return; }
  const { from, size, counts, steps } = distribution;
  const x = { label, range: [Math.min(from, ...limits), Math.max(from + size * counts.length, steps[steps.length - 1][0], ...limits)] };
  const marks = limits.map((at) => ({ kind: 'rule', name: 'limit', at, colour: 'red', dash: [6, 4], text: 'limit' }));
  plot('histogram', { x, y: { label: 'samples', range: [0, 1.05 * Math.max(...counts)] }, layers: [
    { kind: 'bars', name: 'samples', colour: 'blue', x: counts.map((_, k) => from + k * size), y: counts, width: size }, ...marks] });
  const intervals = Object.entries(quantity.of.intervals).map(([p, bounds]) => [Number(p), ...bounds]).sort((a, b) => a[0] - b[0]);
  plot('cdf', { x, y: { label: 'part of the samples', range: [0, 1] }, layers: [
    ...(intervals.length > 1 ? [buildQuantileBand(intervals)] : []),
    { kind: 'line', name: 'part', colour: 'blue', width: 2, x: steps.map((s) => s[0]), y: steps.map((s) => s[1]) }, ...marks] });
}

// Between the lower bounds of the quantiles, the upper edge, and their upper bounds: both as lines over the value.
function buildQuantileBand(intervals) {
  const along = (bound) => (value) => {
    const points = intervals.map((entry) => [entry[bound], entry[0]]);
    const k = points.findIndex(([at]) => at >= value);
    if (k <= 0) return k === 0 ? points[0][1] : points[points.length - 1][1];
    const [[x0, p0], [x1, p1]] = [points[k - 1], points[k]];
    return x1 > x0 ? p0 + ((value - x0) / (x1 - x0)) * (p1 - p0) : p1;
  };
  const x = [...new Set(intervals.flatMap(([, low, high]) => [low, high]))].sort((a, b) => a - b);
  return { kind: 'band', name: 'intervals', colour: 'blue', alpha: 0.2, x, high: x.map(along(1)), low: x.map(along(2)) };
}

function showTornado(quantity) {
  const sensitivity = quantity.of.sensitivity;
  let bars = [], caption = 'First-order index: part of the variance that each input explains alone', line;
  if (!sensitivity) {
    byId('tornado-caption').textContent = caption;
    return message('tornado', 'An input.');
  }
  if (sensitivity.sobol) {
    caption = "Sobol' indices: total (bar, with its interval) and first order (mark)";
    bars = sensitivity.sobol.map((s) => ({ name: s.parameter, value: s.total, mark: s.first, interval: s.total_interval ?? undefined }));
    if (sensitivity.sobol.some((s) => s.total !== null && !s.total_interval)) caption += '; too few blocks for intervals';
  } else if (sensitivity.morris) {
    caption = 'Elementary effects (Morris): mean size (bar), standard deviation (mark)';
    bars = sensitivity.morris.map((m) => ({ name: m.parameter, value: m.mean_size, mark: m.deviation }));
  } else if (sensitivity.swings) {
    caption = 'Range over the levels of each input, the others at their medians';
    bars = sensitivity.swings.map((s) => ({ name: s.parameter, value: s.least === null ? null : s.greatest - s.least }));
  } else if (sensitivity.grid_effects) {
    caption = 'Part of the variance over the grid that each input explains alone';
    bars = sensitivity.grid_effects.map((value, k) => ({ name: manifest.inputs[k].name, value }));
  } else {
    bars = sensitivity.first_order.map((s, k) => ({ name: manifest.inputs[k].name, value: s.index, interval: s.interval, rank: sensitivity.spearman[k] }));
    line = sensitivity.significant;
    const sum = bars.reduce((total, bar) => total + Math.max(0, bar.value || 0), 0);
    caption += ` (interval; right of the dashed line: not by chance, 95 %; ↑ and ↓: rank correlation beyond ±0.1). Sum ${show(sum, 2)}: ` +
      (summary.correlated ? 'inputs may be correlated, their parts overlap and do not add up' : sum > 0.9 ? 'the inputs add up' : 'what is missing from 1 is interaction of inputs, or what happens at few values');
  }
  const blocks = sensitivity.blocks;
  if (blocks && blocks.left_out > 0) caption += `; ${blocks.left_out} of ${blocks.used + blocks.left_out} blocks of the design left out, which lack a value`;
  byId('tornado-caption').textContent = `${caption}: ${quantity.name}`;
  bars = bars.filter((bar) => bar.value !== null).sort((a, b) => Math.abs(b.value) - Math.abs(a.value)).slice(0, 12);
  if (bars.length === 0) return message('tornado', 'Nothing varies.');
  // Indices are parts of 1: their scale is fixed, so that noise is not drawn as large as a driver.
  const most = Math.max(...bars.map((b) => Math.max(Math.abs(b.value), b.mark || 0, b.interval ? b.interval[1] : 0)), sensitivity.morris || sensitivity.swings ? 1e-300 : 1);
  const places = bars.map((_, k) => k), arrowOf = ({ rank }) => (rank === undefined || Math.abs(rank) < 0.1 ? '' : rank > 0 ? ' ↑' : ' ↓');
  const marked = bars.map((bar, k) => ({ ...bar, k })), intervals = marked.filter((bar) => bar.interval), marks = marked.filter((bar) => bar.mark !== undefined);
  plot('tornado', { height: 60 + 26 * bars.length, x: { label: '', range: [Math.min(0, ...bars.map((b) => b.value)), most] },
    y: { label: '', range: [-0.6, bars.length - 0.4], names: bars.map((bar) => bar.name) }, layers: [
      { kind: 'rows', name: 'effects', colour: 'blue', x: bars.map((bar) => bar.value), y: places, from: bars.map(() => 0) },
      { kind: 'rows', name: 'intervals', colour: 'ink', thick: 1, x: intervals.map((bar) => bar.interval[1]), y: intervals.map((bar) => bar.k), from: intervals.map((bar) => Math.max(0, bar.interval[0])) },
      { kind: 'points', name: 'marks', colour: 'red', size: 3.5, x: marks.map((bar) => bar.mark), y: marks.map((bar) => bar.k) },
      ...(line ? [{ kind: 'rule', name: 'significant', at: line, colour: 'red', dash: [4, 3] }] : []),
      ...marked.map((bar) => ({ kind: 'note', at: bar.k, colour: 'dim', text: show(bar.value, 3) + arrowOf(bar) }))] });
}

function showConvergence(requirement) {
  const shown = requirement || summary.requirements.slice().sort((a, b) => b.failed - a.failed)[0];
  if (!shown) return message('convergence', 'The scenario has no requirements.');
  const points = shown.convergence;
  if (points.length === 0) return message('convergence', summary.basis.draws === null ? 'The samples are chosen points, without a probability.' : 'There are no samples.');
  const column = (k) => points.map((point) => point[k]);  // the part is null where all are unresolved
  plot('convergence', { x: { label: 'samples', range: [0, points[points.length - 1][0]] },
    y: { label: `P(${shown.id} fails)`, range: [0, Math.min(1, Math.max(...points.slice(Math.floor(points.length / 4)).map((c) => c[3])))] }, layers: [
      { kind: 'band', name: 'bounds', colour: 'blue', alpha: 0.2, x: column(0), low: column(2), high: column(3) },
      { kind: 'line', name: 'probability', colour: 'blue', width: 2, x: column(0), y: column(1) }] });
}

export const rareColumn = summary.rare && find(summary.rare.column);
export const rareFails = (value) => value === null || (summary.rare.above ? value > summary.rare.limit : value < summary.rare.limit);
const failedAt = (i) => (rareColumn && rareFails(rareColumn.values[i])) || summary.requirements.some((r) => { const margin = find(`${r.id}.margin`).values[i]; return margin === null || margin < 0; });

const unresolved = new Set(data.unresolved), isOpen = (i) => unresolved.has(i);

export function showScatter() {
  const a = quantities[byId('across').value], b = quantities[byId('up').value];
  const places = data.samples.map((_, i) => i).filter((i) => a.values[i] !== null && b.values[i] !== null);
  if (places.length === 0) return message('scatter', 'No sample has both values.');
  const range = (values) => places.reduce(([low, high], i) => [Math.min(low, values[i]), Math.max(high, values[i])], [Infinity, -Infinity]);
  const layer = (name, colour, kept) => ({ kind: 'points', name, colour, size: 2.5, alpha: 0.6, kept, x: kept.map((i) => a.values[i]), y: kept.map((i) => b.values[i]) });
  plot('scatter', { height: 380, x: { label: withUnit(a.name, a.unit), range: range(a.values), pad: 0.03 }, y: { label: withUnit(b.name, b.unit), range: range(b.values), pad: 0.03 },
    layers: [layer('met', 'blue', places.filter((i) => !isOpen(i) && !failedAt(i))), layer('failed', 'red', places.filter((i) => !isOpen(i) && failedAt(i))),
      ...(data.unresolved.length > 0 ? [layer('unresolved', 'dim', places.filter(isOpen))] : [])],
    pick: ({ kept }, k) => {
      const i = kept[k];
      byId('picked').replaceChildren(make('span', `Sample ${data.samples[i]}: ${a.name} ${show(a.values[i], 7)}, ${b.name} ${show(b.values[i], 7)} `), make('code', command(data.samples[i])));
    } });
}

export function showEvents() {
  const events = quantities.filter((q) => q.kind === 'event' && q.of.count > 0).sort((a, b) => a.of.min - b.of.min || a.of.max - b.of.max);
  const never = quantities.filter((q) => q.kind === 'event' && q.of.count === 0);
  byId('never').textContent = never.length > 0 && events.length > 0 ? `In no sample: ${never.map((e) => e.name.slice(6)).join(', ')}` : '';
  if (events.length === 0) return message('events', never.length > 0 ? 'None of the events came in any sample.' : 'The scenario has no events.');
  const places = events.map((_, k) => k), quantile = (p) => events.map((e) => e.of.quantiles[p]);
  plot('events', { height: 60 + 22 * events.length, x: { label: 't [s]', range: [Math.min(...events.map((e) => e.of.min)), Math.max(...events.map((e) => e.of.max))] },
    y: { label: '', range: [-0.6, events.length - 0.4], names: events.map((e) => e.name.slice(6)) }, layers: [
      { kind: 'rows', name: 'all', colour: 'dim', thick: 1, x: events.map((e) => e.of.max), y: places, from: events.map((e) => e.of.min) },
      ...(events[0].of.quantiles['0.5'] === null ? [] : [
        { kind: 'rows', name: 'most', colour: 'blue', thick: 8, x: quantile('0.95'), y: places, from: quantile('0.05') },
        { kind: 'points', name: 'median', colour: 'red', size: 3.5, x: quantile('0.5'), y: places }]),
      ...events.flatMap((e, k) => (e.of.missing > 0 ? [{ kind: 'note', at: k, colour: 'dim', text: `${e.of.missing} without` }] : []))] });
}

// Bands of a curve; gaps where no sample has a value.
export function showCurve() {
  const curve = summary.curves[byId('curve').value];
  const places = curve.times.map((_, i) => i).filter((i) => curve.count[i] > 0);
  const most = Math.max(...curve.count), least = Math.min(...curve.count);
  byId('bands-missing').textContent = least < most ? `Of ${most} samples at most ${most - least} lack a point, such as those that ended before.` : '';
  if (places.length === 0) return message('bands', 'No sample has this curve.');
  const pick = (values) => places.map((i) => values[i]), x = pick(curve.times);
  plot('bands', { height: 380, x: { label: 't [s]', range: [curve.times[0], curve.times[curve.times.length - 1]] },
    y: { label: withUnit(curve.name, curve.unit), range: [Math.min(...pick(curve.min)), Math.max(...pick(curve.max))] }, layers: [
      { kind: 'band', name: 'all', colour: 'blue', alpha: 0.15, x, low: pick(curve.min), high: pick(curve.max) },
      ...(pick(curve['0.5']).some((v) => v === null) ? [] : [
        { kind: 'band', name: 'most', colour: 'blue', alpha: 0.3, x, low: pick(curve['0.05']), high: pick(curve['0.95']) },
        { kind: 'line', name: 'median', colour: 'blue', width: 2, x, y: pick(curve['0.5']) }])] });
}

// Probabilities of smaller margins, on a logarithmic scale.
export function showRareCurve(rare) {
  const points = rare.curve.filter((c) => c[1] > 0);
  if (points.length === 0) return message('rare-curve', 'No margins.');
  let before = 1;
  const levels = rare.levels_run.map((level) => [level.threshold, before *= level.probability]).filter(([margin, p]) => margin !== null && p > 0);
  const margins = [0, ...points.map((c) => c[0]), ...levels.map((c) => c[0])], least = Math.min(...points.map((c) => c[1]), ...levels.map((c) => c[1]), rare.interval[0] || 1);
  const reach = 0.01 * (Math.max(...margins) - Math.min(...margins));
  plot('rare-curve', { x: { label: withUnit('margin', rare.unit), range: [Math.min(...margins), Math.max(...margins)] }, y: { label: 'probability', log: true, range: [0.7 * least, 1] }, layers: [
    ...(rare.probability > 0 && rare.interval[0] > 0 ? [{ kind: 'band', name: 'interval', colour: 'blue', alpha: 0.3, x: [-reach, reach], low: [rare.interval[0], rare.interval[0]], high: [rare.interval[1], rare.interval[1]] }] : []),
    { kind: 'rule', name: 'limit', at: 0, colour: 'red', dash: [6, 4] },
    { kind: 'line', name: 'curve', colour: 'blue', width: 2, x: points.map((c) => c[0]), y: points.map((c) => c[1]) },
    { kind: 'points', name: 'levels', colour: 'red', size: 3.5, x: levels.map((c) => c[0]), y: levels.map((c) => c[1]) }] });
}
