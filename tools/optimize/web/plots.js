// The plots of an optimisation: its search or front, flights before and after, slices.
import { byId, data, make, show, withUnit } from '../../pages/web/elements.js';
import { message, plot } from '../../pages/web/plot.js';
import { constraints, isFound, isMet, nameOf, objectives, pointOf, result, runs, showValue, variables } from './problem.js';

const COLOURS = ['blue', 'amber', 'green', 'red', 'dim'];
const colourOf = (k) => COLOURS[k % COLOURS.length];

function key(place, colour, text) {
  const span = make('span');
  span.append(make('i', '', { class: colour }), document.createTextNode(text));
  byId(place).append(span);
}
function range(values) {
  const kept = values.filter((v) => v !== null && v !== undefined && Number.isFinite(v));
  return kept.length === 0 ? null : [Math.min(...kept), Math.max(...kept)];
}
function addFigure(place, id, caption) {
  const figure = make('figure');
  figure.append(make('figcaption', caption), make('div', '', { id }));
  byId(place).append(figure);
}

// --- The search ------------------------------------------------------------------------------------------------------

function describe(run) {
  return `Run ${run.run}: ${variables.map((v, k) => `${v.name} ${showValue(v, run.point[k])}`).join(', ')}; ${objectives.map((o, k) => `${nameOf(o)} ${show(run.objectives[k], 6)} ${o.unit}`).join(', ')}; ${isMet(run) ? 'all constraints met' : `not met: ${constraints.filter((c, k) => run.margins[k] === null || run.margins[k] < 0).map((c) => c.name).join(', ')}`}`;
}
const pickRun = ({ kept }, k) => { byId('picked').textContent = describe(kept[k]); };
// Runs as points: those that meet all constraints, and the others.
const layRuns = (list, x, y) => [['others', 'dim', 0.35, list.filter((run) => !isMet(run))], ['met', 'blue', 0.8, list.filter(isMet)]]
  .map(([name, colour, alpha, kept]) => ({ kind: 'points', name, colour, alpha, kept, x: kept.map(x), y: kept.map(y) }));

// Points of the front: those that fresh samples confirm, or that need none, and the others.
const isSure = (point) => (point.verdict ?? 'confirmed') === 'confirmed';
const layFront = (front, i, k) => [['front', 'red', front.filter(isSure)], ['unsure', 'amber', front.filter((point) => !isSure(point))]]
  .filter(([name, , kept]) => name === 'front' || kept.length > 0)
  .map(([name, colour, kept]) => ({ kind: 'points', name, colour, shape: 'ring', size: 4, x: kept.map((point) => point.objectives[i]), y: kept.map((point) => point.objectives[k]) }));

// One pair of objectives: runs, the front, the chosen point.
function drawPair(place, found, i, k, height) {
  const met = found.filter(isMet), shown = met.length > 0 ? met : found, front = result.front ?? [];
  const [a, b] = [objectives[i], objectives[k]], chosen = [a.value, b.value];
  const x = range(shown.map((run) => run.objectives[i])), y = range(shown.map((run) => run.objectives[k]));
  const inside = (run) => run.objectives[i] >= x[0] && run.objectives[i] <= x[1] && run.objectives[k] >= y[0] && run.objectives[k] <= y[1];
  plot(place, { height, x: { label: withUnit(nameOf(a), a.unit), range: x, pad: 0.03 }, y: { label: withUnit(nameOf(b), b.unit), range: y, pad: 0.03 }, pick: pickRun, layers: [
    ...layRuns(found.filter(inside), (run) => run.objectives[i], (run) => run.objectives[k]),
    ...layFront(front, i, k),
    ...(chosen.every((v) => v !== null) ? [{ kind: 'points', name: 'chosen', colour: 'amber', shape: 'diamond', size: 7, x: [chosen[0]], y: [chosen[1]] }] : [])] });
}
function showFront(found) {
  byId('search-title').textContent = 'Pareto front';
  byId('search-caption').textContent = objectives.length > 2 ? 'Every run in each pair of objectives; click one for its values' : 'Every run; click one for its values';
  if (objectives.length === 2) {
    drawPair('search', found, 0, 1, 320);
  } else {
    objectives.forEach((a, i) => objectives.slice(i + 1).forEach((b, n) => {
      const k = i + 1 + n;
      addFigure('fronts', `front-${i}-${k}`, `${nameOf(b)} over ${nameOf(a)}`);
      drawPair(`front-${i}-${k}`, found, i, k, 260);
    }));
  }
  key('search-keys', 'blue', 'meets all constraints');
  key('search-keys', 'dim', 'does not');
  key('search-keys', 'red', 'front');
  if ((result.front ?? []).some((point) => !isSure(point))) key('search-keys', 'amber', 'front, not confirmed by fresh samples');
  key('search-keys', 'amber', 'patch.yaml');
}
function showSearch(found) {
  byId('search-title').textContent = 'Search';
  byId('search-caption').textContent = 'Objective of every run, and the best so far that meets all constraints; click a run for its values';
  const o = objectives[0];
  const met = found.filter(isMet), shown = met.length > 0 ? met : found;
  const [low, high] = range(shown.map((run) => run.objectives[0]));
  const span = high - low || Math.abs(high) || 1, y = [low - 0.05 * span, high + 0.05 * span];
  const steps = [];
  let least = null;
  for (const run of met) {
    const value = run.objectives[0];
    if (least !== null && !(o.sense === 'maximise' ? value > least : value < least)) continue;
    if (least !== null) steps.push([run.run, least]);
    least = value;
    steps.push([run.run, least]);
  }
  if (least !== null) steps.push([result.runs, least]);
  plot('search', { height: 320, x: { label: 'run', range: [1, Math.max(2, result.runs)], pad: 0.01 }, y: { label: withUnit(nameOf(o), o.unit), range: y }, pick: pickRun, layers: [
    ...layRuns(found.filter((run) => run.objectives[0] >= y[0] && run.objectives[0] <= y[1]), (run) => run.run, (run) => run.objectives[0]),
    ...(steps.length > 0 ? [{ kind: 'line', name: 'best', colour: 'red', width: 2, x: steps.map((s) => s[0]), y: steps.map((s) => s[1]) }] : [])] });
  key('search-keys', 'blue', 'meets all constraints');
  key('search-keys', 'dim', 'does not');
  key('search-keys', 'red', 'best so far');
}
export function showRuns() {
  const found = runs.filter(isFound);
  if (found.length === 0) message('search', 'No run gave all of the objectives.');
  else if (objectives.length > 1) showFront(found);
  else showSearch(found);
}

// --- Flights ---------------------------------------------------------------------------------------------------------

export function showFlights() {
  key('flight-keys', 'dim', 'start');
  key('flight-keys', 'blue', 'result');
  key('flight-keys', 'red', 'limit');
  let flights = 0;
  // Beyond the constraints: quantities of a problem whose constraints have none over time.
  const watched = data.after.map((curve, k) => constraints[k] ?? { name: curve.name || data.before[k].name, unit: curve.unit || data.before[k].unit, limit: null });
  byId('flight-text').textContent = watched.length > constraints.length
    ? 'Quantities of the scenario over time: at the start of the search, and at the result. No constraint has one.'
    : 'The quantity of each constraint over time: at the start of the search, and at the result. Requirements on events have no curve.';
  watched.forEach((c, k) => {
    const before = data.before[k], after = data.after[k];
    const times = range([...before.times, ...after.times]), values = range([...before.values, ...after.values]);
    if (times === null || values === null) return;
    ++flights;
    addFigure('flights', `flight-${k}`, c.name);
    const limits = c.both || c.limit === null ? [] : c.of_size && values[0] < 0 ? [c.limit, -c.limit] : [c.limit];
    plot(`flight-${k}`, { height: 240, x: { label: 'time [s]', range: times }, y: { label: withUnit('value', c.unit), range: [Math.min(values[0], ...limits), Math.max(values[1], ...limits)] }, layers: [
      { kind: 'line', name: 'before', colour: 'dim', width: 2, dash: [5, 3], x: before.times, y: before.values },
      { kind: 'line', name: 'after', colour: 'blue', width: 2, x: after.times, y: after.values },
      ...limits.map((at) => ({ kind: 'rule', name: 'limit', across: true, at, colour: 'red', dash: [6, 4] }))] });
  });
  if (flights === 0) message('flights', ['interrupted', 'unverified'].includes(result.status) ? 'Not flown to the end: interrupted.' : 'No quantity over time has a value.');
}

// --- Slices ----------------------------------------------------------------------------------------------------------

const MOST_MARGIN = 0.5;  // of a plot: what is further away does not decide

function showSlice(v, i, slice) {
  const xs = slice.map((s) => s.value);
  const x = { label: withUnit(v.name, v.unit), range: range(xs), pad: 0.02 }, mark = { kind: 'rule', name: 'result', at: pointOf(v), colour: 'amber' };
  objectives.forEach((o, k) => {
    const ys = slice.map((s) => s.objectives[k]);
    if (range(ys) === null) return;
    addFigure('slices', `slice-${i}-${k}`, `${nameOf(o)} over ${v.name}`);
    const points = (name, colour, met) => ({ kind: 'points', name, colour, x: xs, y: ys.map((value, n) => (slice[n].margins.every((m) => m !== null && m >= 0) === met ? value : null)) });
    plot(`slice-${i}-${k}`, { height: 220, x, y: { label: withUnit(nameOf(o), o.unit), range: range(ys), pad: 0.04 }, layers: [
      { kind: 'line', name: 'objective', colour: 'blue', width: 2, x: xs, y: ys }, points('met', 'blue', true), points('others', 'red', false), mark] });
  });
  const scaled = constraints.map((c, k) => slice.map((s) => (s.margins[k] === null ? null : s.margins[k] / (Math.abs(c.limit) || 1))));
  const all = range(scaled.flat());
  if (all === null) return;
  addFigure('slices', `margins-${i}`, `margins over ${v.name}`);
  const y = [Math.max(-MOST_MARGIN, Math.min(all[0], 0)), Math.min(MOST_MARGIN, Math.max(all[1], 0))];
  plot(`margins-${i}`, { height: 220, x, y: { label: 'margin / limit', range: y }, layers: [
    ...constraints.map((c, k) => ({ kind: 'line', name: c.name, colour: colourOf(k), width: 2, x: xs, y: scaled[k].map((m) => (m === null || m < y[0] || m > y[1] ? null : m)) })),
    { kind: 'rule', name: 'zero', across: true, at: 0, colour: 'ink' }, mark] });
  byId(`margins-${i}`).after(make('p', undefined, { class: 'keys', id: `margin-keys-${i}` }));
  constraints.forEach((c, k) => key(`margin-keys-${i}`, colourOf(k), scaled[k].some((m) => m !== null && Math.abs(m) <= MOST_MARGIN) ? c.name : `${c.name}: beyond ${MOST_MARGIN}`));
}
export function showSlices() {
  variables.forEach((v, i) => {
    const slice = (result.slices ?? {})[v.name];
    if (slice && slice.length > 1) showSlice(v, i, slice);
  });
  if (byId('slices').children.length === 0) message('slices', 'None: the budget left no runs for them.');
}
