// Common parts of the pages of unlatch: elements, numbers, tables, plots. `data` is what the page was written with.
'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const SVG = 'http://www.w3.org/2000/svg';
const css = (name) => `var(--${name})`;
const byId = (id) => document.getElementById(id);

function make(tag, text, attributes = {}) {
  const node = document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
}
function draw(parent, tag, attributes, text) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}
const show = (x, digits = 5) => (x === null || x === undefined ? '–' : String(Number(Number(x).toPrecision(digits))));
const withUnit = (name, unit) => (unit ? `${name} [${unit}]` : name);

function fill(place, heads, rows) {
  const table = make('table');
  const head = make('tr');
  heads.forEach((text) => head.append(make('th', text)));
  table.append(head);
  for (const cells of rows) {
    const row = make('tr');
    for (const cell of cells) {
      const td = make('td');
      if (cell instanceof Node) td.append(cell); else td.textContent = cell;
      row.append(td);
    }
    table.append(row);
  }
  byId(place).replaceChildren(table);
}

// --- Plots -----------------------------------------------------------------------------------------------------------

function ticks(low, high, count = 5) {
  const raw = (high - low) / count, size = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * size).find((s) => s >= raw);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) list.push(k * step);
  return list;
}
// A plot of fixed size, scaled by the page; x, y: [low, high].
function plot(place, x, y, labels, height = 280) {
  const width = 520, left = 64, right = 26, top = 10, bottom = 42;
  const widen = ([a, b]) => (b > a ? [a, b] : [a - Math.abs(a) * 0.01 - 1e-9, b + Math.abs(b) * 0.01 + 1e-9]);
  const [x0, x1] = widen(x), [y0, y1] = widen(y);
  const svg = document.createElementNS(SVG, 'svg');
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  svg.setAttribute('role', 'img');
  svg.setAttribute('aria-label', labels.join(' over '));
  const px = (v) => left + ((v - x0) / (x1 - x0)) * (width - left - right);
  const py = (v) => height - bottom - ((v - y0) / (y1 - y0)) * (height - top - bottom);
  for (const v of ticks(x0, x1)) {
    draw(svg, 'line', { x1: px(v), x2: px(v), y1: top, y2: height - bottom, stroke: css('line') });
    draw(svg, 'text', { x: px(v), y: height - bottom + 16, 'text-anchor': 'middle', class: 'dim' }, show(v, 4));
  }
  for (const v of ticks(y0, y1)) {
    draw(svg, 'line', { x1: left, x2: width - right, y1: py(v), y2: py(v), stroke: css('line') });
    draw(svg, 'text', { x: left - 6, y: py(v) + 4, 'text-anchor': 'end', class: 'dim' }, show(v, 4));
  }
  draw(svg, 'text', { x: (left + width - right) / 2, y: height - 6, 'text-anchor': 'middle' }, labels[1]);
  draw(svg, 'text', { x: 14, y: (top + height - bottom) / 2, 'text-anchor': 'middle', transform: `rotate(-90 14 ${(top + height - bottom) / 2})` }, labels[0]);
  byId(place).replaceChildren(svg);
  return { svg, px, py, x: [x0, x1], y: [y0, y1], bottom: height - bottom, top };
}
function message(place, text) { byId(place).replaceChildren(make('p', text, { class: 'dim' })); }

// A button that copies a command.
function copyButton(text) {
  const button = make('button', 'copy');
  button.addEventListener('click', () => {
    const area = make('textarea', text);
    document.body.append(area);
    area.select();
    document.execCommand('copy');
    area.remove();
    button.textContent = 'copied';
  });
  return button;
}
