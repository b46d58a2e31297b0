// The verdict on the requirements, the separations, and the limits that plots show.
import { digits, el, fixed, table } from './dom.js';

const DEG = 180 / Math.PI;
const SIZE = { force: '|F|', moment: '|M|' };

const withUnit = (value, unit) => digits(value, 6) + (unit ? ` ${unit}` : '');
const withError = ({ value, uncertainty, unit }) => withUnit(value, '') + (uncertainty ? ` ± ${digits(uncertainty, 2)}` : '') + (unit ? ` ${unit}` : '') + (uncertainty === null ? ' (± not known)' : '');

function describeLimit({ at_least: least, at_most: most, unit }) {
  if (most === null) return `at least ${withUnit(least, unit)}`;
  if (least === null) return `at most ${withUnit(most, unit)}`;
  return `${digits(least, 6)} … ${withUnit(most, unit)}`;
}

function word(item) {
  if (!item.resolved) return el('strong', { class: 'badtext' }, 'unresolved');
  if (item.met) return el('strong', { class: 'goodtext' }, 'met');
  return el('strong', { class: 'badtext' }, item.evaluated ? 'not met' : 'not evaluated');
}

function jump(clock, t) { return el('button', { class: 'jump', onclick: () => clock.set(t) }, fixed(t, 6)); }

function countMissed({ verdict, session_limits: limits }) {
  const all = [...verdict, ...limits.map((limit) => ({ ...limit, resolved: true }))];
  const unresolved = all.filter((item) => !item.resolved).length, missed = all.filter((item) => item.resolved && !item.met).length;
  const parts = [[missed, 'not met'], [unresolved, 'unresolved']].filter(([number]) => number > 0);
  return parts.length ? parts.map(([number, text]) => `${number} of ${all.length} ${text}`).join(', ') : 'all met';
}

// The table on top of the results, the limits of sessions below the requirements; nothing if no run has either.
export function buildVerdict(runs, clock) {
  if (!runs.some((run) => run.verdict.length || run.session_limits.length)) return null;
  const two = runs.length > 1;
  const letter = (run) => (two ? [el('span', { class: `letter ${run.label}` }, run.label)] : []);
  const rows = runs.flatMap((run) => run.verdict.map((item) => [
    ...letter(run), item.id, word(item),
    ...(item.evaluated ? [withError(item), describeLimit(item), withUnit(item.margin, item.unit), jump(clock, item.t)]
      : [item.why, describeLimit(item), '', '']),
    (item.text ? `${item.text} (${item.quantity})` : item.quantity) + (item.resolved ? '' : `; depends on ${item.unresolved}`)
      + (item.at_ticks ? '; as sampled at ticks and events' : '')
      + ('without_blow' in item ? `; without the impulse of the blow at ${digits(item.without_blow, 6)} s` : '')]));
  const limits = runs.flatMap((run) => run.session_limits.map((limit) => [
    ...letter(run), limit.id, word({ ...limit, resolved: true, evaluated: true }), digits(limit.value, 6),
    limit.at_most === null ? 'no limit' : `at most ${digits(limit.at_most, 6)}`, '', '', limit.text]));
  const count = runs.map((run) => (two ? `${run.label}: ` : '') + countMissed(run)).join('; ');
  return el('section', { class: 'card', id: 'verdict' }, el('div', { class: 'cardhead' }, el('h2', {}, 'Requirements'), el('small', {}, count)),
    table([...(two ? [''] : []), 'id', 'verdict', 'value', 'limit', 'margin', 'at t, s', 'requirement'], [...rows, ...limits]));
}

// Rows of the table of separations.
export function listSeparations(run, clock) {
  return run.separations.map((pair) => [
    pair.pair.join(' – '), jump(clock, pair.release), jump(clock, pair.end_of_push),
    `${digits(pair.velocity.along)} along ${pair.axis}, ${digits(pair.velocity.across, 3)} across`,
    `${fixed(pair.relative_rate.axial * DEG, 4)}, ${fixed(pair.relative_rate.transverse * DEG, 4)}`,
    pair.sides.map((side) => `${side.body} ${fixed(side.rate.axial * DEG, 4)}, ${fixed(side.rate.transverse * DEG, 4)}`).join('; '),
    pair.sides.filter((side) => side.nutation_period !== null)
      .map((side) => `${side.body} ${digits(side.coning_half_angle * DEG, 4)}°, ${digits(side.nutation_period, 4)} s`).join('; '),
    pair.clearance ? `${fixed(pair.clearance.min, 4)} at ${fixed(pair.clearance.t, 4)} s${pair.clearance.closing ? ', still closing at the end' : ''}` : '–',
    pair.springs.map((spring) => `${spring.name} ${digits(spring.impulse)} N s, ${digits(spring.energy)} J`).join('; ')]);
}

export const SEPARATION_HEADINGS = ['bodies', 'released, s', 'end of push, s', 'relative velocity, m/s', 'relative rate, axial, transverse, deg/s',
  'rates, deg/s', 'coning half-angle, nutation period', 'smallest clearance, m', 'springs'];

// A requirement limits the curves of this choice; `scale` turns its SI unit into the plot's.
function limits(item, first, group, choice) {
  const { kind, row, relative_to: reference } = item.of;
  if (group.kind === 'requirement') return choice.name === item.id ? 1 : null;
  if (kind !== group.kind) return null;
  if (kind === 'clearance') return 1;
  if (kind === 'reaction') return choice.name === (SIZE[row] ?? row) ? 1 : null;
  if (kind === 'rate') return choice.name === 'size' && row === 'size' && reference === 'ground' ? DEG : null;
  if (kind === 'velocity' || kind === 'position') return choice.name === (kind === 'position' ? 'distance' : 'size') && row === 'size' && reference === first ? 1 : null;
  if (kind === 'sensor') return choice.unit === item.unit ? 1 : null;
  return null;
}

// Limits of the requirements on what a plot shows: {value, id, met}, each value once.
export function findLimits(runs, group, choice) {
  const found = new Map();
  for (const run of runs) {
    for (const item of run.verdict) {
      const scale = limits(item, run.bodies[0].name, group, choice);
      if (scale === null) continue;
      const values = [item.at_least, item.at_most].filter((value) => value !== null);
      if (item.of.take === 'peak') values.push(...values.map((value) => -value));
      for (const value of values) {
        const key = `${value}`, before = found.get(key);
        found.set(key, { value: value * scale, id: before && !before.id.split(', ').includes(item.id) ? `${before.id}, ${item.id}` : before?.id ?? item.id, met: item.met && (before?.met ?? true) });
      }
    }
  }
  return [...found.values()];
}
