// The campaign's part: sensitivities of requirements, dispersed inputs.
import { byId, make, show, withUnit } from '../../pages/web/elements.js';
import { message, plot } from '../../pages/web/plot.js';
import { rows } from './cells.js';

const unitOf = (item) => item.shown?.unit ?? item.unit;
const valueOf = (item, value) => show(value === null || value === undefined ? null : value / (item.shown?.factor ?? 1));
const interval = (index) => (index ? `${show(index.index, 2)} (${show(index.interval[0], 2)} … ${show(index.interval[1], 2)})` : '–');

function showStrongest(requirement) {
  const list = requirement.strongest ?? [];
  const orders = list.length > 0 && list[0].first_order !== undefined;
  byId('strongest-caption').textContent = orders ? 'First-order indices: the part of the variance that each input decides alone; the strongest inputs'
    : "Spearman's rank correlations, without their sign; the strongest inputs";
  const sizes = list.map((one) => Math.max(0, (orders ? one.first_order.index : Math.abs(one.spearman)) ?? 0));
  if (list.length === 0) message('strongest', 'No inputs.');
  else {
    plot('strongest', { height: 60 + 28 * list.length, x: { label: orders ? 'first-order index' : '|rank correlation|', range: [0, Math.max(0.1, ...sizes)], pad: 0.02 },
      y: { names: list.map((one) => one.input), range: [-0.6, list.length - 0.4] },
      layers: [{ kind: 'rows', name: 'sensitivity', colour: 'blue', x: sizes, from: sizes.map(() => 0), y: sizes.map((_, k) => k) }] });
  }
  rows('sensitivities', ['input', 'first-order index, 95 %', 'rank correlation'], list.map((one) => [one.input, orders ? interval(one.first_order) : '–', show(one.spearman, 3)]), 'No inputs.');
}

// The basis of what an input disperses, if it is a value of the scenario.
function basisOf(input, values) {
  const words = (input.paths ?? []).map((path) => values.find((value) => value.path === path.replace(/\[(\d+)\]$/, ''))?.basis).filter(Boolean);
  return [...new Set(words)].join(', ') || '–';
}

export function showCampaign(campaign, values) {
  byId('sensitivity-part').hidden = false;
  byId('to-sensitivity').hidden = false;
  byId('campaign-file').hidden = false;
  byId('campaign-text').textContent = campaign.campaign_text;
  byId('campaign-facts').textContent = `Campaign ${campaign.name}: ${campaign.samples} samples, ${campaign.sampling}, seed ${campaign.seed}, ` +
    `${Object.entries(campaign.statuses).filter(([, n]) => n > 0).map(([name, n]) => `${n} ${name}`).join(', ')}; hash ${campaign.hash}, ${campaign.program}.${campaign.basis.text ? ` Sampling ${campaign.sampling}: ${campaign.basis.text}.` : ''}`;
  const select = byId('of');
  campaign.requirements.forEach((one, k) => select.append(make('option', one.id, { value: k })));
  if (campaign.requirements.length > 0) {
    select.addEventListener('change', () => showStrongest(campaign.requirements[select.value]));
    showStrongest(campaign.requirements[0]);
  } else message('strongest', 'The scenario has no requirements.');
  rows('inputs', ['input', 'sets', 'mean', 'standard deviation', 'least', 'greatest', 'basis of the value'], campaign.inputs.map((input) => [
    withUnit(input.name, unitOf(input)), make('div', (input.paths ?? []).join(', '), { class: 'long' }), ...[input.mean, input.deviation, input.min, input.max].map((v) => valueOf(input, v)), basisOf(input, values)]), 'No inputs.');
}
