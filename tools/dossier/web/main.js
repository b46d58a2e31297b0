// The page of a dossier: its tables. Texts only ever become textContent.
import { byId, copyButton, data, fill, make, show } from '../../pages/web/elements.js';
import { plots } from '../../pages/web/plot.js';
import { showCampaign } from './campaign.js';
import { code, mark, rows } from './cells.js';
import { showData } from './values.js';

const { run, campaign, verification } = data;
const VERDICTS = { met: 'good', 'not met': 'bad', 'not evaluated': 'bad', unresolved: 'warn' };

const sum = (key) => data.data.counts.model[key] + data.data.counts.input[key];
const met = run.requirements.filter((r) => r.met).length;
byId('title').textContent = data.title || data.scenario;
document.title = `${data.scenario}: dossier`;
byId('facts').textContent = `Dossier of ${data.file}, scenario ${data.scenario}; ${verification.program}, commit ${verification.commit}, ${verification.compiler}; model ${run.model_hash}, run ${run.hash}` +
  (campaign ? `; campaign ${campaign.name} ${campaign.hash}` : '') + (data.author ? `; ${data.author}` : '');
byId('chips').append(
  mark(`run: ${run.status}`, run.status === 'ok' ? 'good' : 'bad'),
  mark(`${met} of ${run.requirements.length} requirements met`, met === run.requirements.length ? 'good' : 'bad'),
  mark(`${sum('none')} of ${sum('all')} values without a basis`, sum('none') === 0 ? 'good' : 'warn'),
  mark(`${run.notices.length} notices, ${run.findings.length} findings`, run.notices.length > 0 ? 'warn' : ''),
  ...(campaign ? [mark(`${campaign.samples} samples`, campaign.unresolved.length > 0 ? 'warn' : '')] : []));
byId('use').replaceChildren(make('b', 'Intended use: '), data.intended_use || make('span', 'not stated (intended_use in the file of --statements)', { class: 'none' }));

// --- Credibility -------------------------------------------------------------------------------------------------------

const listOf = (texts) => {
  const list = make('ul', undefined, { class: 'evidence' });
  texts.forEach((text) => list.append(make('li', text)));
  return list;
};
fill('factors', ['factor', 'asks', 'evidence', 'statement', 'level'], data.factors.map((f) => [
  f.name, f.asks, f.evidence.length > 0 ? listOf(f.evidence) : make('span', 'none from the program', { class: 'dim' }),
  f.statement === null ? make('span', 'not stated', { class: 'none' }) : make('span', f.statement, { class: 'stated' }), f.level === null ? '–' : String(f.level)]));

// --- Requirements ------------------------------------------------------------------------------------------------------

const ofCampaign = (id) => campaign?.requirements.find((r) => r.id === id);
const text = (r) => {
  const cell = make('div', r.text || '', { class: 'long' });
  cell.append(make('div', `${r.quantity}, ${r.criterion}`, { class: 'dim' }));
  return cell;
};
const result = (r) => (r.evaluated ? `${show(r.value)} ${r.unit} at ${show(r.t)} s` : r.why ?? '');
const verdict = (r) => {
  const cell = make('div');
  cell.append(make('span', r.verdict, { class: VERDICTS[r.verdict] }));
  if (r.unresolved) cell.append(make('div', `depends on ${r.unresolved}`, { class: 'dim' }));
  return cell;
};
const failed = (r) => {
  const cell = make('div', `${r.failed} failed, ${r.unresolved} unresolved`, { class: r.failed > 0 ? 'bad' : '' });
  cell.append(make('div', r.probability ? `${r.probability[0].toExponential(2)} … ${r.probability[1].toExponential(2)}` : 'chosen points, no probability', { class: 'dim' }));
  return cell;
};
const worst = (r) => {
  if (!r.worst) return '–';
  const cell = make('div', `sample ${r.worst.sample}, margin ${show(r.worst.margin)}, hash ${r.worst.hash} `);
  cell.append(make('div'), code(r.worst.command), ' ', copyButton(r.worst.command));
  return cell;
};
rows('requirements', ['id', 'parent', 'requirement', 'rationale', 'nominal run', 'margin', 'verdict', ...(campaign ? ['campaign, 95 %', 'worst sample'] : [])],
  run.requirements.map((r) => [r.id, r.parent || '–', text(r), make('div', r.rationale || '–', { class: 'long' }), result(r), r.evaluated ? `${show(r.margin)} ${r.unit}` : '–', verdict(r),
    ...(campaign ? (ofCampaign(r.id) ? [failed(ofCampaign(r.id)), worst(ofCampaign(r.id))] : ['–', '–']) : [])]), 'The scenario has no requirements.');

// --- The step, notices, findings ---------------------------------------------------------------------------------------

const { accuracy } = run;
byId('accuracy-result').textContent = accuracy.skipped ? `Not estimated: ${accuracy.skipped}.`
  : accuracy.mismatch ? `The runs differ: ${accuracy.mismatch}.`
    : `The step is ${show(run.dt)} s. ` + (accuracy.largest_step === null ? `No step was found that meets ${show(accuracy.tolerance)} of each value's size; ${accuracy.limited_by} does not.`
      : `The largest step that meets ${show(accuracy.tolerance)} of each value's size is ${show(accuracy.largest_step)} s${accuracy.limited_by ? `, limited by ${accuracy.limited_by}` : ''}.`);
if (accuracy.values) {
  rows('accuracy', ['value', 'result', 'error', 'order', 'if it does not converge, why'], accuracy.values.map((v) => [
    v.what, `${show(v.value, 9)} ${v.unit}`, `${Number(v.error).toExponential(1)} ${v.unit}`, v.order === null ? '–' : v.order.toFixed(1), v.settles ? '' : make('span', v.reason, { class: 'warn' })]), 'No values.');
}
if (accuracy.growth?.length > 0) {
  rows('growth', ['an error of the start', 'of', 'at the end, times as far'], accuracy.growth.map((g) => [g.of, `${g.start} → ${g.end}`, show(g.factor, 3)]), '');
}
rows('notices', ['time', 'notice', 'of', ''], run.notices.map((n) => [`${show(n.t)} s`, make('span', n.name, { class: n.unresolved ? 'warn' : '' }), n.subject, n.text]), 'No notice: the run found nothing that its step does not resolve.');
rows('findings', ['finding', 'place', ''], run.findings.map((f) => [f.name, f.file ? `${f.file}:${f.line}` : '–', `${f.where} ${f.text}`]), 'No findings on the scenario.');
byId('energy').textContent = `Energy: motion gained ${show(run.energy.gained)} J; unexplained at most ${show(run.energy.largest_unexplained, 3)} J at ${show(run.energy.t)} s, of a largest energy of ${show(run.energy.scale)} J.`;

// --- Verification, validation, commands --------------------------------------------------------------------------------

const plain = (words) => {
  const node = make('span');
  words.split('`').forEach((part, k) => node.append(k % 2 === 1 ? make('code', part) : part));
  return node;
};
byId('version').textContent = `${verification.program}, commit ${verification.commit}, built with ${verification.compiler}.`;
rows('verified', ['system', 'compared with', 'agreement'], verification.verified.map((v) => [plain(v.what), plain(v.compared_with), plain(v.agreement)]), '');
byId('promises-title').textContent = `${verification.promises.length} promises, each with its tests`;
rows('promises', ['part', 'promise', 'test'], verification.promises.map((p) => [p.group, plain(p.promise), plain(p.test)]), '');
for (const [id, texts, tag] of [['flights', verification.flights, 'p'], ['not-validated', verification.not_validated, 'li'], ['known', verification.known_to_be_wrong, 'li']]) {
  texts.forEach((words) => { const node = make(tag); node.append(plain(words)); byId(id).append(node); });
}
rows('commands', ['gives', 'command', '', 'hash'], data.commands.map((c) => [c.what, code(c.command), copyButton(c.command), c.hash ? code(c.hash) : '–']), '');
byId('hash').textContent = data.sha256;
byId('scenario-text').textContent = data.scenario_text;

showData(data.data);
if (campaign) showCampaign(campaign, data.data.values);
window.unlatchReport = { data, plots };
