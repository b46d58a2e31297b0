// The page: reads the document, and joins the parts by one clock.
import { Clock } from './clock.js';
import { el } from './dom.js';
import { buildHead } from './head.js';
import { Plots } from './plots.js';
import { BODY, Run } from './run.js';
import { Stage } from './stage.js';
import { buildTables } from './tables.js';
import { Timeline } from './timeline.js';
import { buildTiming } from './timing.js';
import { buildVerdict } from './verdict.js';

function open() {
  const data = JSON.parse(document.getElementById('data').textContent);
  const runs = data.runs.map((run, i) => new Run(run, 'AB'[i]));
  const clock = new Clock(Math.min(...runs.map((run) => run.first)), Math.max(...runs.map((run) => run.last)));
  document.title = `${runs.map((run) => run.scenario).join(' | ')} – unlatch report`;

  document.getElementById('head').append(buildHead(data, runs, clock));
  const stage = new Stage(runs, clock);
  const timeline = new Timeline(runs, clock);
  document.getElementById('stage').append(stage.node, timeline.node);
  const plots = new Plots(runs, clock);
  document.getElementById('results').prepend(
    ...[buildVerdict(runs, clock)].filter(Boolean), plots.node, buildTiming(runs, plots), buildTables(data, runs, clock));

  const redraw = () => { stage.paint(); plots.paint(); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  document.addEventListener('theme', redraw);
  plots.paint();

  // #t=0.73 opens the page at that time.
  const wanted = () => Number(/[#&]t=([-+0-9.e]+)/.exec(location.hash)?.[1] ?? NaN);
  addEventListener('hashchange', () => { if (Number.isFinite(wanted())) clock.set(wanted()); });
  clock.set(Number.isFinite(wanted()) ? wanted() : clock.first);

  // For the browser's console, and for tests.
  window.unlatchReport = {
    runs, clock, stage, plots,
    getPosition: (name, t, run = 0) => {
      const body = runs[run].bodies.findIndex((candidate) => candidate.name === name);
      const place = runs[run].find(t), origin = runs[run].origin(place);
      return runs[run].vector(runs[run].bodies[body].column + BODY.p, place).map((value, k) => value + origin[k]);
    },
  };
}

try {
  open();
} catch (error) {
  document.body.prepend(el('p', { class: 'banner bad' }, `This report cannot be shown: ${error.message}`));
  throw error;
}
