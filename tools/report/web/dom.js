// Elements and numbers as text. Text from the data only ever becomes textContent.

// el('div', {class: 'x', onclick: f}, 'text', child, [more])
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

export function select(label, options, value, onchange) {
  const box = el('select', { 'aria-label': label, onchange: (event) => onchange(event.target.value) },
    options.map(([key, text]) => el('option', { value: key, selected: String(key) === String(value) }, text)));
  return el('label', { class: 'field' }, label, box);
}

export function checkbox(label, checked, onchange, hint) {
  return el('label', { class: 'field', title: hint },
    el('input', { type: 'checkbox', checked, onchange: (event) => onchange(event.target.checked) }), label);
}

// So many significant digits, no exponent between 1e-4 and 1e7: 1234.5, 0.0123, 1.23e-9.
export function digits(value, count = 5) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  const text = size >= 1e7 || size < 1e-4 ? value.toExponential(count - 1) : Number(value.toPrecision(count)).toString();
  return text.replace('-', '−');
}

export function plural(count, noun) { return `${count} ${noun}${count === 1 ? '' : 's'}`; }

export function fixed(value, places) {
  if (!Number.isFinite(value)) return digits(value);
  const text = value.toFixed(places);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '−');
}

// A table; cells that are numbers stand to the right.
export function table(headings, rows, options = {}) {
  return el('div', { class: 'scroll' }, el('table', { class: options.class },
    el('thead', {}, el('tr', {}, headings.map((heading) => el('th', {}, heading)))),
    el('tbody', {}, rows.map((row) => el('tr', {}, row.map((cell) => (
      el('td', { class: typeof cell === 'string' && /^[−∞–0-9]/.test(cell) ? 'number' : null }, cell))))))));
}

export function download(name, text) {
  const link = el('a', { download: name, href: `data:text/plain;charset=utf-8,${encodeURIComponent(text)}` });
  link.click();
}
