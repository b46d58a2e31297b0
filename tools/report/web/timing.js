// Timing of a run in the loop: histograms and percentiles.
import uPlot from 'uplot';
import { colour, css } from './colours.js';
import { digits, el, select, table } from './dom.js';

const KINDS = [['step_ns', 'step'], ['wakeup_ns', 'wake-up latency'], ['turnaround_ns', 'command in, state out'],
  ['round_trip_ns', 'state out, answer in']];
const PERCENTILES = [['p50', 'p50'], ['p90', 'p90'], ['p99', 'p99'], ['p999', 'p99.9'], ['p9999', 'p99.99'], ['p99999', 'p99.999'], ['max', 'max']];
const PER_OCTAVE = 8;

const micro = (ns) => digits(ns * 1e-3, 4);

// Counts per eighth of an octave of duration, in µs; buckets that nothing fell into have none.
function gather(summary) {
  const counts = new Map();
  for (const [upper, count] of summary.histogram) {
    const bucket = Math.ceil(Math.log2(Math.max(upper, 1)) * PER_OCTAVE - 1e-9);
    counts.set(bucket, (counts.get(bucket) ?? 0) + count);
  }
  return counts;
}

function buildSeries(runs, share) {
  const kinds = runs.flatMap((run, r) => KINDS.map(([key, name], k) => ({ run, second: r > 0, summary: run.timing[key], name, k })))
    .filter(({ summary }) => summary.count > 0);
  const gathered = kinds.map(({ summary }) => gather(summary));
  const buckets = gathered.flatMap((counts) => [...counts.keys()]);
  const first = Math.min(...buckets) - 1, last = Math.max(...buckets) + 1;
  const places = Array.from({ length: last - first + 1 }, (_, i) => first + i);
  const values = gathered.map((counts, i) => {
    let above = kinds[i].summary.count;
    return places.map((bucket) => {
      const count = counts.get(bucket) ?? 0;
      above -= count;
      if (share) return above > 0 ? above / kinds[i].summary.count : null;
      return count > 0 ? count : null;
    });
  });
  return { kinds, x: places.map((bucket) => 2 ** (bucket / PER_OCTAVE) * 1e-3), values };
}

export function buildTiming(runs, plots) {
  const two = runs.length > 1;
  const kinds = runs.flatMap((run) => KINDS.map(([key, name]) => ({ run, name, summary: run.timing[key] }))).filter(({ summary }) => summary.count > 0);
  if (kinds.length === 0) return el('section', { class: 'card' }, el('h2', {}, 'Timing'), el('p', {}, 'The recording has none: it was cut short.'));
  const body = el('div', { class: 'plot' });
  let share = false, plot = null;
  const paint = () => {
    const { kinds: shown, x, values } = buildSeries(runs, share);
    const axis = { stroke: css('--faint'), grid: { stroke: css('--line'), width: 1 }, ticks: { stroke: css('--line'), width: 1, size: 4 },
      font: '11px system-ui, sans-serif', labelFont: '11px system-ui, sans-serif', labelSize: 16, labelGap: 0 };
    const powers = (_, ticks) => ticks.map((tick) => (Math.abs(Math.log10(tick) % 1) < 1e-6 ? digits(tick, 3) : null));
    plot?.destroy();
    plot = new uPlot({
      width: Math.max(body.clientWidth, 200), height: 210,
      scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
      axes: [{ ...axis, label: 'duration, µs', size: 30, values: powers }, { ...axis, label: share ? 'share of ticks above' : 'ticks per ⅛ octave', size: 54, values: powers }],
      series: [{ label: 'up to, µs', value: (_, value) => digits(value, 4) }, ...shown.map(({ run, name, k, second }) => ({
        label: two ? `${run.label} ${name}` : name, stroke: colour(k + 1), width: 1.5, dash: second ? [4, 4] : [], spanGaps: share,
        paths: uPlot.paths.stepped({ align: -1 }), points: { show: !share, size: 4 }, value: (_, value) => digits(value, 4) }))],
      cursor: { y: false },
    }, [x, ...values], body);
  };
  plots.others.push(paint);
  new ResizeObserver(() => plot?.setSize({ width: Math.max(body.clientWidth, 200), height: 210 })).observe(body);

  const percentiles = table(['µs', 'count', ...PERCENTILES.map(([, name]) => name)], kinds.map(({ run, name, summary }) => (
    [two ? `${run.label} ${name}` : name, String(summary.count), ...PERCENTILES.map(([key]) => micro(summary[key]))])));
  return el('section', { class: 'card', id: 'timing' },
    el('div', { class: 'cardhead' }, el('h2', {}, 'Timing'), el('small', {}, 'wall time, of every tick of the recorded run'), el('span', { class: 'grow' }),
      select('as', [[0, 'histogram'], [1, 'share above']], 0, (value) => { share = value === '1'; paint(); })),
    body, percentiles, runs.map((run) => buildCounts(run, two)), runs.map((run) => buildOverruns(run, two)));
}

function buildCounts(run, two) {
  const { timing } = run;
  const causes = Object.entries(timing.overrun_causes).filter(([, count]) => count > 0).map(([cause, count]) => `${cause} ${count}`);
  const refused = Object.entries(timing.rejected).filter(([, count]) => count > 0).map(([reason, count]) => `${reason} ${count}`);
  const parts = [`overruns ${timing.overruns}${causes.length ? ` (${causes.join(', ')})` : ''}`, `late commands ${timing.late_commands}`,
    `messages dropped ${timing.dropped}`, `states resent ${timing.resent}`, `commands refused ${refused.length ? refused.join(', ') : 0}`];
  if (timing.slipped_ns) parts.push(`slipped ${micro(timing.slipped_ns)} µs`);
  if (timing.skipped_outputs) parts.push(`states not sent ${timing.skipped_outputs}`);
  return el('p', { class: timing.overruns || timing.dropped ? 'counts bad' : 'counts' }, (two ? `${run.label}: ` : '') + parts.join(' · '));
}

function buildOverruns(run, two) {
  const worst = run.timing.worst_overruns;
  if (worst.length === 0) return null;
  return el('details', {}, el('summary', {}, `${two ? `${run.label}: ` : ''}${worst.length === 1 ? 'the worst overrun' : `the ${worst.length} worst overruns`}`),
    table(['tick', 'cause', 'late, µs', 'woken', 'inputs', 'step', 'outputs', 'page faults', 'preemptions'], worst.map((overrun) => [
      String(overrun.tick), overrun.cause, micro(overrun.late_ns), micro(overrun.wakeup_ns), micro(overrun.input_ns), micro(overrun.step_ns),
      micro(overrun.output_ns), String(overrun.page_faults), String(overrun.preemptions)])));
}
