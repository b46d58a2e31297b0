// Tables of results, and of their origin.
import { digits, download, el, fixed, table } from './dom.js';
import { ROWS } from './run.js';
import { listSeparations, SEPARATION_HEADINGS } from './verdict.js';

const norm = (v) => Math.hypot(...v);
const minus = (a, b) => a.map((value, k) => value - b[k]);

function section(title, note, ...content) {
  return el('section', { class: 'card' }, el('div', { class: 'cardhead' }, el('h2', {}, title), el('small', {}, note)), content);
}

function go(clock, t) {
  return el('button', { class: 'jump', onclick: () => clock.set(t) }, fixed(t, 4));
}

const MOST_ALIKE = 6;  // of more, as templates make them, one row is shown
const withoutNumbers = (name) => name.replace(/[0-9]+/g, '#');

// Rows whose names differ only in numbers, many of them: the one of the greatest rank, and the others on a click.
function fold(node, items) {
  const rows = [...node.querySelectorAll('tbody tr')];
  const groups = new Map();
  items.forEach((item, i) => {
    if (item.name === null) return;
    const key = `${item.run} ${withoutNumbers(item.name)}`;
    groups.set(key, [...(groups.get(key) ?? []), { ...item, row: rows[i] }]);
  });
  for (const group of groups.values()) {
    if (group.length <= MOST_ALIKE) continue;
    group.sort((a, b) => b.rank - a.rank);
    group[0].row.after(...group.slice(1).map((item) => item.row));
    const rest = group.slice(1);
    for (const item of rest) item.row.hidden = true;
    const more = el('tr', { class: 'more' }, el('td', { colspan: group[0].row.cells.length }, el('button', { class: 'jump', onclick: () => {
      for (const item of rest) item.row.hidden = false;
      more.remove();
    } }, `… and ${rest.length} more of ${withoutNumbers(group[0].name)}`)));
    group[0].row.after(more);
  }
  return node;
}

// One table with a column for the run if there are two. Items: {name (null: never folded), rank, cells}.
function both(runs, headings, listItems) {
  const two = runs.length > 1;
  const items = runs.flatMap((run) => listItems(run).map((item) => ({ ...item, run: run.label })));
  if (items.length === 0) return null;
  const rows = items.map(({ run, cells }) => (two ? [el('span', { class: `letter ${run}` }, run), ...cells] : cells));
  return fold(table(two ? ['', ...headings] : headings, rows), items);
}

// Distances of triangle meshes are marked apart from those of exact shapes, where a run has some.
function buildClearances(runs, clock) {
  const meshes = runs.some((run) => run.clearance.some((item) => item.method !== 'exact'));
  const describe = (item) => (item.min < 0 ? 'they overlap' : item.method === 'exact' ? 'they touch' : 'they touch or overlap: triangles have no depth');
  return both(runs, ['bodies', 'smallest, m', 'at t, s', ...(meshes ? ['distance'] : [])], (run) => run.clearance.map((item) => ({
    name: item.pair.join(' – '), rank: -item.min,
    cells: [item.pair.join(' – '), item.min > 0 ? fixed(item.min, 4) : el('strong', { class: 'badtext' }, `${fixed(item.min, 4)}, ${describe(item)}`), go(clock, item.t),
      ...(meshes ? [item.method] : [])] })));
}

function buildSeparations(runs, clock) {
  return both(runs, SEPARATION_HEADINGS, (run) => listSeparations(run, clock).map((cells) => ({ name: null, cells })));
}

function buildPeaks(runs, clock) {
  return both(runs, ['joint', ...ROWS.map((row, k) => `${row}, ${k < 3 ? 'N' : 'N m'}`), 'mode at the end'], (run) => (
    run.joints.map((joint) => ({ name: joint.name, rank: norm(joint.peaks.slice(0, 3).map((peak) => peak.value)), cells: [
      joint.name, ...joint.peaks.map((peak) => (
        el('button', { class: 'jump', title: `at ${digits(peak.t)} s${peak.at_ticks ? ', as sampled at ticks and events' : ''}`, onclick: () => clock.set(peak.t) },
          digits(peak.value, 5) + (peak.uncertainty ? ` ± ${digits(peak.uncertainty, 2)}` : '')))),
      run.finalModes[joint.name]] }))));
}

function buildContacts(runs, clock) {
  const time = (t) => (t === null ? '–' : go(clock, t));
  return both(runs, ['contact', 'first touch, s', 'latest lift, s', 'touches', 'closed for, s', 'peak force, N', 'at t, s', 'largest depth, m', 'impulse, N s',
    'slip, m', 'loss, J'], (run) => run.contacts.filter((item) => item.touches > 0 || item.closed_at_start).map((item) => ({
    name: item.name, rank: item.peak_force, cells: [
      item.name, item.closed_at_start && item.touch === null ? 'closed at the start' : time(item.touch), item.closed ? 'closed at the end' : time(item.lift),
      item.touches, digits(item.duration, 5), digits(item.peak_force, 6), time(item.t), digits(item.depth, 4), digits(item.impulse, 6), digits(item.slip, 4),
      digits(item.dissipated, 5)] })));
}

function buildRedundant(runs, clock) {
  return both(runs, ['joints', 'redundant rows', 'from t, s', 'to t, s'], (run) => run.redundant.map((item) => ({
    name: null, cells: [item.joints.join(', '), `${item.redundant} of ${item.rows}`, go(clock, item.from), go(clock, item.until)] })));
}

function buildAudit(runs, clock) {
  return both(runs, ['at t, s', 'momentum, kg m/s', 'angular momentum, kg m²/s', 'energy, J', 'allowed energy, J'], (run) => run.audit.map((item) => ({ name: null, cells: [
    go(clock, item.t), digits(norm(minus(item.momentum_jump, item.allowed.momentum_jump)), 3),
    digits(norm(minus(item.angular_momentum_jump, item.allowed.angular_momentum_jump)), 3),
    digits(item.energy_jump - item.allowed.energy_jump, 3), digits(item.allowed.energy_jump, 6)] })));
}

function buildProvenance(data, runs) {
  const rows = [
    ['recording', (run) => run.log], ['recorded by', (run) => `${run.program}, ${run.compiler}`], ['reported by', () => data.program],
    ['status', (run) => run.status + (run.message ? `: ${run.message}` : '')], ['pace', (run) => run.pace],
    ['ticks', (run) => `${run.first_tick} … ${run.ticks} of ${run.planned_tick} planned, ${digits(run.dt * 1e3)} ms each`],
    ['model hash', (run) => el('code', {}, run.model_hash)], ['state hash at the end', (run) => el('code', {}, run.hash)],
    ['replay', (run) => (run.replay.agrees ? `every bit agrees at ${run.replay.ticks_compared === 1 ? 'the 1 tick' : `all ${run.replay.ticks_compared} ticks`} compared` : 'differs')],
    ['scenario', (run) => run.scenario_path], ['--set', (run) => run.overrides.join('  ') || 'none'],
    ['in this page', (run) => `${run.frames.count} of ${run.frames.seen} states`],
  ];
  return table(['', ...runs.map((run) => (runs.length > 1 ? run.label : ''))], rows.map(([name, get]) => [name, ...runs.map(get)]), { class: 'plain' });
}

function buildTexts(runs) {
  const two = runs.length > 1;
  return runs.flatMap((run) => {
    const name = two ? ` of ${run.label}` : '';
    return [
      el('details', { class: 'text' }, el('summary', {}, `Scenario${name}: ${run.scenario_path}`),
        el('button', { onclick: () => download(`${run.scenario}.yaml`, run.scenario_text) }, 'save'), el('pre', {}, run.scenario_text)),
      el('details', { class: 'text' }, el('summary', {}, `Summary${name}, as \`unlatch replay\` prints it`), el('pre', {}, run.summary)),
    ];
  });
}

export function buildTables(data, runs, clock) {
  const add = (title, note, content) => (content ? section(title, note, content) : null);
  return el('div', {}, [
    add('Smallest clearances', 'located inside the step', buildClearances(runs, clock)),
    add('Separations', 'velocities and rates at the end of push, in the inertial frame; axial: about the separation axis', buildSeparations(runs, clock)),
    add('Peak reactions', 'located inside the step, signed, on the follower; click to go there', runs.some((run) => run.joints.length) ? buildPeaks(runs, clock) : null),
    add('Contacts', 'those that touch; located inside the step', buildContacts(runs, clock)),
    add('Reactions that are not unique', 'rows of these joints are redundant; split by equal stiffnesses, or as `share` says', buildRedundant(runs, clock)),
    add('Audit of momentum and energy', 'largest unexplained changes by events', buildAudit(runs, clock)),
    section('Where this comes from', '', buildProvenance(data, runs), buildTexts(runs)),
  ].filter(Boolean));
}
