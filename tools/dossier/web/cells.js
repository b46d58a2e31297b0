// Cells and tables of the dossier.
import { byId, fill, make } from '../../pages/web/elements.js';

export const mark = (text, kind) => make('span', text, kind ? { class: kind } : {});
export const code = (text) => make('code', text);

// A table, or a sentence if it has no rows.
export function rows(place, heads, cells, empty) {
  if (cells.length > 0) fill(place, heads, cells);
  else byId(place).replaceChildren(make('p', empty, { class: 'dim' }));
}
