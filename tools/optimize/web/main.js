// The page of an optimisation: its tables and texts; the plots are those of plots.js.
import { byId, data, fill, make, show, withUnit } from '../../pages/web/elements.js';
import { message, plots } from '../../pages/web/plot.js';
import { showFlights, showRuns, showSlices } from './plots.js';
import { best, constraints, limitText, manifest, objectives, pointOf, result, showValue, start, variables } from './problem.js';

document.title = `${result.problem}: optimisation`;
byId('title').textContent = data.title || result.problem;
byId('facts').textContent = `${result.runs} runs of the search and ${result.study_runs} around its result${{ runs: ', ended by budget.runs', seconds: ', ended by budget.seconds' }[result.ended_by] ?? ''}; method ${result.exhaustive ? 'all combinations' : result.method}, seed ${result.seed}, scenario ${result.scenario}, ${manifest.program}`;
const verdicts = {
  optimal: 'The search has converged: all constraints are met.', budget: 'The budget is spent: all constraints are met; a longer search may find better.',
  'not-converged': 'All constraints are met, but samples that the search had not seen leave room at its limits: better designs may be near. Raise campaign.samples and campaign.most, or start from here.',
  infeasible: 'No point meets all constraints. Shown is the point of the least violation.',
  'not-found': 'No feasible point was found within the budget: raise it. Shown is the point of the least violation.', undecided: result.violation ? 'The samples of the search are too few to decide: other samples do not show that the point misses the probability. Raise campaign.samples.'
    : 'The search has ended, and samples that it had not seen neither confirm nor refute the result. Raise campaign.checks, campaign.samples and campaign.most, or lower the probability.',
  unresolved: 'The step does not resolve the nearest point: it neither meets nor misses the constraints. Make the step smaller.', interrupted: 'The search was interrupted. Shown is the best so far.',
  refuted: 'The search has ended, and samples that it had not seen refute the result: it does not meet all constraints.', unverified: 'The search has ended, and its result is not verified.',
};
byId('verdict').append(make('span', verdicts[result.status] ?? result.status, { class: ['optimal', 'budget', 'not-converged'].includes(result.status) ? 'good' : 'bad' }));
if (result.violation) byId('verdict').append(make('span', ` ${result.violation.text}.`));

fill('variables', ['variable', 'start', 'result', 'between', 'set by'], variables.map((v) => [
  v.name, showValue(v, v.start), make('strong', showValue(v, pointOf(v)) + (best[v.name].at_bound ? ' (at its bound)' : '')),
  v.catalogue.length > 0 ? `${v.catalogue.length} values` : `${show(v.lower, 6)} and ${show(v.upper, 6)} ${v.unit}`, v.paths.join(', ')]));
fill('objectives', ['objective', 'start', 'result'], objectives.map((o, k) => [
  `${o.sense} ${withUnit(o.of, o.unit)}`, start ? show(start.objectives[k], 7) : '–', make('strong', show(o.value, 7))]));
fill('constraints', ['constraint', 'limit', 'start', 'result', 'margin', 'active', 'shadow'], result.constraints.map((c, k) => [
  withUnit(c.id, c.unit), limitText(constraints[k]),
  start ? make('span', show(start.values[k], 6), { class: start.margins[k] !== null && start.margins[k] >= 0 ? '' : 'bad' }) : '–',
  make('span', show(c.value, 6), { class: c.met ? '' : 'bad' }), show(c.margin, 4), c.active ? 'active' : '', c.shadow === undefined ? '' : show(c.shadow, 5)]));

const sensitive = Object.entries(result.sensitivities);
if (sensitive.length > 0) {
  const names = Object.keys(sensitive[0][1]);
  fill('sensitivities', ['for each unit of', ...names], sensitive.map(([name, row]) => [
    withUnit(name, variables.find((v) => v.name === name).unit), ...names.map((n) => show(row[n], 5))]));
} else {
  message('sensitivities', 'None: the variables are entries of catalogues, or the budget left no runs for them.');
}

const verification = result.verification ?? {};
const verdictTexts = { confirmed: 'met', open: 'neither confirmed nor refuted', refuted: 'NOT MET' };
byId('verification').textContent = verification.hash === undefined ? (verification.finished === false && result.status !== 'infeasible' ? 'Not finished: the result was not flown once more to the end.' : 'The result was not flown once more.') :
  `patch.yaml was read anew and flown once more: ${verification.met ? 'all constraints are met' : 'not all constraints are met'}, ${verification.same_bits ? 'with the same bits' : 'with OTHER bits'} (hash ${verification.hash}).` +
  (verification.dispersed ?? []).map((d) => ` ${d.id}: ${d.failed} of ${d.samples} samples that the search had not seen fail, probability ${show(d.probability[0], 3)} to ${show(d.probability[1], 3)} (95 %), at most ${show(d.allowed, 3)} is allowed: ${verdictTexts[d.verdict]}.`).join('') +
  (verification.finished ? '' : ' The check by other samples is not finished.') +
  (constraints.some((c) => c.probability > 0) ? '' : ' One run; dispersions are not part of this statement.');
byId('problem-text').textContent = manifest.problem_text;
byId('patch-text').textContent = data.patch;

showRuns();
showFlights();
showSlices();
window.unlatchReport = { problem: result.problem, data, plots };  // drawn
