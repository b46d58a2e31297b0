// Elements, numbers and tables of the pages of studies. `data` is what the page was written with; its texts only ever become textContent.
export const data = JSON.parse(document.getElementById('data').textContent);
export const byId = (id) => document.getElementById(id);

export function make(tag, text, attributes = {}) {
  const node = document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
}
export const show = (x, digits = 5) => (x === null || x === undefined ? '–' : String(Number(Number(x).toPrecision(digits))));
export const withUnit = (name, unit) => (unit ? `${name} [${unit}]` : name);

// A table; cells are texts or nodes.
export function fill(place, heads, rows) {
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

// A button that copies a command.
export function copyButton(text) {
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
