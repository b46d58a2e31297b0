// The data of the scenario and their basis: a bar of their kinds, and the table.
import { byId, make, show } from '../../pages/web/elements.js';
import { mark, rows } from './cells.js';

const KINDS = [['none', 'without a basis'], ['assumed', 'assumed'], ['derived', 'derived'], ['datasheet', 'from a data sheet'], ['measured', 'measured'], ['follows', 'from constants']];
const CLASSES = { none: 'none', assumed: 'warn', measured: 'good' };

function drawBar(place, counts) {
  const bar = make('div', undefined, { class: 'bar', role: 'img', 'aria-label': KINDS.map(([key, name]) => `${counts[key]} ${name}`).join(', ') });
  const legend = make('div', undefined, { class: 'legend' });
  for (const [key, name] of KINDS) {
    if (counts[key] === 0) continue;
    const part = make('i', undefined, { class: `b-${key}` });
    part.style.flexGrow = counts[key];
    bar.append(part);
    const entry = make('span', undefined);
    entry.append(make('i', undefined, { class: `b-${key}` }), `${counts[key]} ${name}`);
    legend.append(entry);
  }
  byId(place).replaceChildren(bar, legend);
}

function describeUncertainty(value) {
  if (!value.uncertainty) return '–';
  const sizes = [...new Set(value.uncertainty.sizes.map((size) => show(size, 3)))];
  return value.uncertainty.text + (sizes.length > 0 ? ` (${sizes.join(', ')} ${value.unit})` : '');
}

export function showData({ counts, values }) {
  drawBar('model-bar', counts.model);
  drawBar('input-bar', counts.input);
  const select = byId('basis');
  const add = (key, name, count) => select.append(make('option', `${name} (${count})`, { value: key }));
  const count = (key) => counts.model[key] + counts.input[key];
  add('all', 'all values', count('all'));
  for (const [key, name] of KINDS) if (count(key) > 0) add(key, name, count(key));
  const fillTable = () => rows('values', ['value', 'as written', 'basis', 'uncertainty', 'source', 'place'],
    values.filter((v) => select.value === 'all' || v.basis === select.value).map((v) => [
      v.path + (v.role === 'input' ? ' (input)' : ''), make('div', v.text.length > 120 ? `${v.text.slice(0, 120)}…` : v.text, { class: 'long' }),
      mark(v.basis === 'follows' ? `from ${v.constants.join(', ')}` : v.basis, CLASSES[v.basis]), describeUncertainty(v), make('div', v.source ?? '–', { class: 'long' }), v.place]), 'There are none.');
  select.value = count('none') > 0 ? 'none' : 'all';
  select.addEventListener('change', fillTable);
  fillTable();
}
