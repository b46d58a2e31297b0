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

// One table with a column for the run if there are two.
function both(runs, headings, rowsOf) {
  const two = runs.length > 1;
  const rows = runs.flatMap((run) => rowsOf(run).map((row) => (two ? [el('span', { class: `letter ${run.label}` }, run.label), ...row] : row)));
  return rows.length ? table(two ? ['', ...headings] : headings, rows) : null;
}

function buildClearances(runs, clock) {
  return both(runs, ['bodies', 'smallest, m', 'at t, s'], (run) => run.clearance.map((item) => (
    [item.pair.join(' – '), item.min > 0 ? fixed(item.min, 4) : el('strong', { class: 'badtext' }, 'they touch'), go(clock, item.t)])));
}

function buildSeparations(runs, clock) {
  return both(runs, SEPARATION_HEADINGS, (run) => listSeparations(run, clock));
}

function buildPeaks(runs, clock) {
  return both(runs, ['joint', ...ROWS.map((row, k) => `${row}, ${k < 3 ? 'N' : 'N m'}`), 'mode at the end'], (run) => (
    run.joints.map((joint) => [joint.name, ...joint.peaks.map((peak) => (
      el('button', { class: 'jump', title: `at ${digits(peak.t)} s`, onclick: () => clock.set(peak.t) }, digits(peak.value, 5)))),
    run.finalModes[joint.name]])));
}

function buildAudit(runs, clock) {
  return both(runs, ['at t, s', 'momentum, kg m/s', 'angular momentum, kg m²/s', 'energy, J', 'allowed energy, J'], (run) => run.audit.map((item) => [
    go(clock, item.t), digits(norm(minus(item.momentum_jump, item.allowed.momentum_jump)), 3),
    digits(norm(minus(item.angular_momentum_jump, item.allowed.angular_momentum_jump)), 3),
    digits(item.energy_jump - item.allowed.energy_jump, 3), digits(item.allowed.energy_jump, 6)]));
}

function buildProvenance(data, runs) {
  const rows = [
    ['recording', (run) => run.log], ['recorded by', (run) => `${run.program}, ${run.compiler}`], ['reported by', () => data.program],
    ['status', (run) => run.status + (run.message ? `: ${run.message}` : '')], ['pace', (run) => run.pace],
    ['ticks', (run) => `${run.first_tick} … ${run.ticks} of ${run.planned_tick} planned, ${digits(run.dt * 1e3)} ms each`],
    ['model hash', (run) => el('code', {}, run.model_hash)], ['state hash at the end', (run) => el('code', {}, run.hash)],
    ['replay', (run) => (run.replay.agrees ? `every bit agrees at all ${run.replay.ticks_compared} ticks compared` : 'differs')],
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
    add('Peak reactions', 'of every tick, signed, on the follower; click to go there', runs.some((run) => run.joints.length) ? buildPeaks(runs, clock) : null),
    add('Audit of momentum and energy', 'changes by events beyond the allowed ones', buildAudit(runs, clock)),
    section('Where this comes from', '', buildProvenance(data, runs), buildTexts(runs)),
  ].filter(Boolean));
}
