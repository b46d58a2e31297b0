// Head of the page: the run, its end, and warnings.
import { digits, el, plural } from './dom.js';

const MARKS = { ok: '✓', fault: '✕', aborted: '✕', unresolved: '✕', different: '≠', damaged: '✕', truncated: '…' };

function describe(run, two) {
  const ok = run.status === 'ok';
  const replay = run.replay.agrees ? `replayed: every bit agrees at ${plural(run.replay.ticks_compared, 'tick')}` : 'does not replay as recorded';
  return el('div', { class: 'run' },
    two ? el('span', { class: `letter ${run.label}` }, run.label) : null,
    el('span', { class: `status ${ok ? 'good' : 'bad'}` }, `${MARKS[run.status] ?? ''} ${run.status}`),
    el('span', { class: run.replay.agrees ? 'fact' : 'fact bad' }, replay),
    el('span', { class: 'fact' }, `${digits(run.last - run.first, 7)} s at ${digits(run.dt * 1e3)} ms`),
    el('span', { class: 'fact' }, run.pace === 'fast' ? 'without flight software' : `in the loop, ${run.pace}`),
    el('span', { class: 'fact' }, 'state ', el('code', {}, run.hash)),
    el('span', { class: 'fact file', title: run.log }, run.log));
}

function jump(clock, t, text) {
  return el('button', { class: 'jump', onclick: () => clock.set(t) }, text ?? `${digits(t, 7)} s`);
}

function describeDifference(diff, clock) {
  if (diff.refused) return el('p', { class: 'banner' }, `Not compared bit by bit: ${diff.refused}.`);
  const { difference, first_input: input } = diff;
  if (!difference) {
    const text = { same: 'the same bits to the same end', inputs: 'the same states, from other inputs',
      ends: 'the same bits as far as both go', damaged: 'the same bits up to the damage' }[diff.result];
    return el('p', { class: 'banner good' }, `A and B: ${text} (${plural(diff.ticks_compared, 'tick')} compared).`);
  }
  const fields = difference.fields.slice(0, 4).map((field) => (
    `${field.of} ${field.field}: ${digits(field.a, 9)} / ${digits(field.b, 9)}${field.ulp ? ` (${field.ulp} ULP)` : ''}`));
  const more = difference.fields.length - fields.length;
  return el('div', { class: 'banner bad' },
    el('strong', {}, `A and B first differ at tick ${difference.tick}, `), jump(clock, difference.t), ' ',
    fields.join('; ') + (more > 0 ? `; and ${more} more ${more === 1 ? 'field' : 'fields'}.` : '.'),
    input ? [` First other input: ${input.channel}, ${digits(input.a)} / ${digits(input.b)}, at tick ${input.tick}.`] : null);
}

function setTheme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
  document.dispatchEvent(new Event('theme'));
}

export function buildHead(data, runs, clock) {
  const two = runs.length === 2;
  const banners = [];
  for (const run of runs) {
    const who = two ? `${run.label}: ` : '';
    if (run.message) banners.push(el('p', { class: 'banner bad' }, who + run.message));
    if (run.replay.mismatch) banners.push(el('p', { class: 'banner bad' }, who + run.replay.mismatch));
    if (run.replay.first_difference) {
      const { tick, recorded, replayed } = run.replay.first_difference;
      banners.push(el('p', { class: 'banner bad' }, `${who}the replay leaves the recording at tick ${tick} `,
        `(recorded ${recorded}, replayed ${replayed}); what is shown ends there.`));
    }
    for (const { t, name, subject, text } of run.notices.filter((notice) => notice.name.startsWith('accuracy.'))) {
      banners.push(el('p', { class: 'banner warn' }, `${who}not resolved by the step from ${t.toFixed(6)} s on: ${name.slice(9)} ${subject}: ${text}`));
    }
    for (const { where, text } of run.warnings) banners.push(el('p', { class: 'banner warn' }, `${who}at the start: ${where} ${text}`));
    for (const verdict of run.verdicts) banners.push(el('p', { class: 'banner warn' }, who + verdict));
  }
  const titles = [...new Set(runs.map((run) => run.title || run.scenario))];
  return el('div', {},
    el('div', { class: 'titles' },
      el('h1', {}, [...new Set(runs.map((run) => run.scenario))].join(' | ')), el('span', { class: 'title' }, titles.join(' | ')),
      el('span', { class: 'grow' }), el('span', { class: 'made' }, `${data.program}`),
      el('button', { title: 'light or dark', 'aria-label': 'light or dark', onclick: setTheme }, '◐')),
    runs.map((run) => describe(run, two)),
    data.diff ? describeDifference(data.diff, clock) : null,
    banners);
}
