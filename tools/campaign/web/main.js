// The page of a campaign: its tables; the plots are those of plots.js.
import { byId, copyButton, data, fill, make, show, withUnit } from '../../pages/web/elements.js';
import { message, plots } from '../../pages/web/plot.js';
import { command } from './commands.js';
import { find, quantities, rareColumn, rareFails, showCurve, showDistribution, showEvents, showRareCurve, showScatter } from './plots.js';

const { summary, manifest } = data;

function showRare(rare) {
  if (!rare) return;
  byId('rare').hidden = false;
  const failure = `${rare.column} ${rare.above ? 'above' : 'below'} ${show(rare.limit)} ${rare.unit}`;
  const result = !rare.finished ? 'The campaign has not ended.'
    : rare.unresolved_samples > 0 ? `at most ${rare.interval[1].toExponential(2)} (95 %), without an estimate: ${rare.unresolved_samples} unresolved samples are taken for failures`
    : rare.unseen.length > 0 ? `undecided: at most ${rare.interval[1].toExponential(2)} (95 %), without an estimate: failures have values of ${rare.unseen.join(', ')} that none of the independent samples has`
    : !rare.decided ? `undecided: at most ${rare.interval[1].toExponential(2)} (95 %), without an estimate: ${rare.levels_run.at(-1).failed} of the last level fail${rare.tied ? ', and so many of the others have the same margin that no level leads further' : ''}`
    : `${rare.probability.toExponential(2)}, 95 %: ${rare.interval[0].toExponential(2)} … ${rare.interval[1].toExponential(2)}, coefficient of variation ${show(rare.deviation, 2)}` +
      (rare.reached ? '' : rare.tied ? '; few samples fail, and no level leads further: more samples' : '; the last level had too few failures: more levels, or a probability that is smaller still') + (rare.at_most < 1 ? `; allowed are ${rare.at_most.toExponential(2)}` : '');
  byId('rare-result').replaceChildren(`P(${failure}): `, make('b', result, { class: rare.met ? 'good' : 'bad' }), ` (${summary.samples} runs, ${rare.failed_samples} of them failed)`);
  fill('rare-levels', ['level', 'samples', withUnit('margin', rare.unit), 'probability', 'c.o.v.', 'accepted'], rare.levels_run.map((level, k) => [
    k, `${level.first} to ${level.last - 1}`, show(level.threshold), show(level.probability, 4), show(level.deviation, 3), k === 0 ? '' : show(level.acceptance, 2)]));
  showRareCurve(rare);
}

// A button that opens the page of a sample's flight, where the report has one.
function flightOf(sample) {
  if (!data.flights[sample]) return null;
  const button = make('button', 'fly', { class: 'flight' });
  button.addEventListener('click', () => window.open(data.flights[sample], '_blank'));
  return button;
}
// Values of a requirement or an input in the unit that the files use.
const unitOf = (item) => item.shown?.unit ?? item.unit;
const valueOf = (item, value) => show(value === null || value === undefined ? null : value / (item.shown?.factor ?? 1));
const limitsOf = (r) => [r.at_least !== null ? `≥ ${valueOf(r, r.at_least)}` : '', r.at_most !== null ? `≤ ${valueOf(r, r.at_most)}` : ''].filter(Boolean).join(', ');
const boundsOf = (pair) => (pair ? `${pair[0].toExponential(2)} … ${pair[1].toExponential(2)}` : '–');
// Zero failures are good only where no sample is unresolved.
const countFailed = (r) => make('span', r.failed, { class: r.failed > 0 ? 'bad' : r.unresolved > 0 ? '' : 'good' });
const countBad = (n) => make('span', n, { class: n > 0 ? 'bad' : '' });

// Tolerance limit of the side that has a limit: 99 % of all runs are beyond it, with 95 % confidence (Wilks).
function toleranceOf(r) {
  if (!r.tolerance) return '–';
  if (r.tolerance.without_value > 0) return `none: ${r.tolerance.without_value} without a value`;
  if (r.tolerance.lower === undefined) return `needs ${r.tolerance.samples_needed} values`;
  return [r.at_least !== null ? `≥ ${valueOf(r, r.tolerance.lower)}` : '', r.at_most !== null ? `≤ ${valueOf(r, r.tolerance.upper)}` : ''].filter(Boolean).join(', ');
}

byId('title').textContent = manifest.title || manifest.campaign;
document.title = `${manifest.campaign}: campaign`;
byId('facts').textContent = `${summary.samples}${summary.rare ? '' : ` of ${summary.planned}`} samples (${Object.entries(summary.statuses).filter(([, n]) => n > 0).map(([s, n]) => `${n} ${s}`).join(', ')}), ` +
  `${manifest.sampling}${summary.rare ? ` (at most ${summary.planned})` : ''}, seed ${manifest.seed}, scenario ${manifest.scenario}, campaign hash ${summary.hash}, ${manifest.program}` + (data.every > 1 ? `; the plot of any two shows every ${data.every}th sample` : '');
if (summary.requirements.length === 0) message('verdict', 'The scenario has no requirements.');
else {
  const any = summary.any_requirement;
  const rows = summary.requirements.map((r) => [
    Object.assign(make('span', r.id), { title: r.text }), `${limitsOf(r)} ${unitOf(r)}`,
    countFailed(r), countBad(r.unresolved), countBad(r.faulted), countBad(r.not_evaluated), boundsOf(r.probability), valueOf(r, r.min), valueOf(r, r.max),
    ...['0.01', '0.05', '0.5', '0.95', '0.99'].map((p) => valueOf(r, r.quantiles[p])), toleranceOf(r)]);
  if (any && rows.length > 1) rows.push(['any requirement', '', countFailed(any), countBad(any.unresolved), '', '', boundsOf(any.probability), '', '', '', '', '', '', '', '']);
  byId('basis').textContent = [summary.basis.text && `Sampling ${summary.basis.sampling}: ${summary.basis.text}.`,
    ...summary.requirements.filter((r) => r.without_blow).map((r) => `The values of ${r.id} in ${r.without_blow} ${r.without_blow === 1 ? 'sample is' : 'samples are'} without the impulse of a blow through the joint.`),
    ...summary.requirements.filter((r) => r.uncertain).map((r) => `${r.id}: ${r.uncertain.samples} ${r.uncertain.samples === 1 ? 'sample' : 'samples'} known to ± ${r.uncertain.by.toPrecision(2)} ${r.unit} at worst, between steps.`)].filter(Boolean).join(' ');
  fill('verdict', ['requirement', 'limit', 'failed', 'unresolved', 'faulted', 'missing', 'probability, 95 %', 'least', 'greatest', '1 %', '5 %', 'median', '95 %', '99 %', 'tolerance, 99 % / 95 %'], rows);
}
fill('orders', ['order of events', 'samples', 'first'], summary.orders.classes.slice(0, 8).map((c) => [c.order || 'no event', c.samples, c.first]));
if (summary.orders.count > 8) byId('orders').append(make('p', `${summary.orders.count} different orders in all`, { class: 'dim' }));
fill('worst', ['sample', ...(rareColumn ? [withUnit(rareColumn.name, rareColumn.unit)] : []), ...summary.requirements.map((r) => withUnit(r.id, unitOf(r))), 'run it again', ''], summary.worst.map((sample) => {
  const i = data.samples.indexOf(sample);
  const rareValue = rareColumn && i >= 0 ? rareColumn.values[i] : null;
  return [String(sample), ...(rareColumn ? [make('span', show(rareValue), { class: rareFails(rareValue) ? 'bad' : '' })] : []), ...summary.requirements.map((r) => { const v = i < 0 ? null : find(r.id).values[i], m = i < 0 ? 0 : find(`${r.id}.margin`).values[i]; return make('span', valueOf(r, v), { class: m === null || m < 0 ? 'bad' : '' }); }), make('code', command(sample)), flightOf(sample) || copyButton(command(sample))];
}));
fill('inputs', ['input', 'unit', 'mean', 'standard deviation', 'least', 'greatest'], summary.inputs.map((c) => [c.name, unitOf(c), ...[c.mean, c.deviation, c.min, c.max].map((v) => valueOf(c, v))]));
byId('campaign-text').textContent = manifest.campaign_text;
byId('scenario-text').textContent = manifest.scenario_text;
for (const id of ['quantity', 'across', 'up']) {
  quantities.forEach((q, k) => byId(id).append(make('option', withUnit(q.name, q.unit), { value: k })));
}
const inputPlace = summary.columns.length;
if (rareColumn) byId('quantity').value = byId('up').value = quantities.indexOf(rareColumn);
byId('across').value = Math.min(inputPlace, quantities.length - 1);
byId('quantity').addEventListener('change', showDistribution);
byId('across').addEventListener('change', showScatter);
byId('up').addEventListener('change', showScatter);
showDistribution();
showScatter();
showEvents();
showRare(summary.rare);
if (summary.curves) {
  byId('curves').hidden = false;
  summary.curves.forEach((curve, k) => byId('curve').append(make('option', withUnit(curve.name, curve.unit), { value: k })));
  byId('curve').addEventListener('change', showCurve);
  showCurve();
}
window.unlatchReport = { campaign: manifest.campaign, data, quantities, plots };  // drawn
