// The problem of an optimisation and its result.
import { data, show } from '../../pages/web/elements.js';

export const { result, manifest, variables, runs } = data;
export const constraints = data.constraints.map((c, k) => ({ ...c, limit: result.constraints[k].limit }));  // at the result
export const objectives = result.objectives;
export const start = runs[0], best = result.variables;
// Long expressions stand in the table above.
export const nameOf = (o) => (o.of.length <= 24 ? o.of : objectives.length === 1 ? 'objective' : `objective ${objectives.indexOf(o) + 1}`);
export const isMet = (run) => run.margins.every((m) => m !== null && m >= 0);
export const isFound = (run) => run.objectives.every((v) => v !== null);

export function showValue(variable, value) {
  if (variable.catalogue.length > 0) return variable.catalogue[value];
  return `${show(value, 6)} ${variable.unit}`;
}
export const pointOf = (variable) => (variable.catalogue.length > 0 ? best[variable.name].entry : best[variable.name].value);
export const limitText = (c) => (c.both ? 'within two limits' : `${c.at_least ? '≥' : '≤'} ${show(c.limit, 6)}`) + (c.probability > 0 ? `, probability ${c.probability}` : '');
