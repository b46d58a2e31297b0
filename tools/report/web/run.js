// One run of the document: its columns, and its state at any time of it.

function decode(text, Type) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i += 1) bytes[i] = binary.charCodeAt(i);
  return new Type(bytes.buffer);
}

export const BODY = { p: 0, q: 3, v: 7, w: 10 };
export const ROWS = ['x', 'y', 'z', 'rot_x', 'rot_y', 'rot_z'];
export const GROUND = -1;
const MOST_OF_A_NAME = 200;  // events of the session, in the list

export class Run {
  constructor(json, label) {
    Object.assign(this, json);
    this.label = label;  // 'A' or 'B'
    const { frames } = json;
    const ticks = decode(frames.ticks, Float64Array);
    this.time = ticks.map((tick) => tick * json.dt);
    this.count = ticks.length;
    this.first = this.time[0];
    this.last = this.time[this.count - 1];
    this.origins = decode(frames.origins, Float64Array);
    this.values = decode(frames.values, Float32Array);
    this.places = new Map(frames.varying.map((column, place) => [column, place]));
    this.constants = new Map();
    Object.assign(this, json.structure, { finalModes: json.joints });  // both have joints
  }

  isConstant(column) { return !this.places.has(column); }

  // The column's value in each frame.
  column(column) {
    const place = this.places.get(column);
    if (place !== undefined) return this.values.subarray(place * this.count, (place + 1) * this.count);
    if (!this.constants.has(column)) {
      this.constants.set(column, new Float32Array(this.count).fill(this.frames.first[column] ?? NaN));
    }
    return this.constants.get(column);
  }

  // Position of t among the frames: `index`, and `fraction` of the interval to the next.
  find(t) {
    let low = 0, high = this.count - 1;
    if (!(t > this.first)) return { index: 0, fraction: 0 };
    if (t >= this.last) return { index: high, fraction: 0 };
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= t) low = middle; else high = middle;
    }
    return { index: low, fraction: (t - this.time[low]) / (this.time[high] - this.time[low]) };
  }

  // A column at a place; modes and the like do not become fractions.
  at(column, { index, fraction }, whole = false) {
    const place = this.places.get(column);
    if (place === undefined) return this.frames.first[column];
    const from = place * this.count + index;
    const value = this.values[from];
    return fraction === 0 || whole ? value : value + fraction * (this.values[from + 1] - value);
  }

  vector(column, place) { return [0, 1, 2].map((k) => this.at(column + k, place)); }

  origin({ index, fraction }) {
    return [0, 1, 2].map((k) => {
      const value = this.origins[3 * index + k];
      return fraction === 0 ? value : value + fraction * (this.origins[3 * index + 3 + k] - value);
    });
  }

  // p_WB − p_W(first body), m, and the attitude w x y z; between frames the shorter way round, normalised.
  pose(body, place) {
    const { column } = this.bodies[body];
    const q = [0, 1, 2, 3].map((k) => this.at(column + BODY.q + k, { index: place.index, fraction: 0 }));
    if (place.fraction > 0) {
      const next = [0, 1, 2, 3].map((k) => this.at(column + BODY.q + k, { index: place.index + 1, fraction: 0 }));
      const sign = q.reduce((sum, value, k) => sum + value * next[k], 0) < 0 ? -1 : 1;
      for (let k = 0; k < 4; k += 1) q[k] += place.fraction * (sign * next[k] - q[k]);
    }
    const size = Math.hypot(...q);
    return { p: this.vector(column + BODY.p, place), q: q.map((value) => value / size) };
  }

  mode(joint, place) {
    return joint.modes[Math.round(this.at(joint.column, place, true))];
  }

  // Events of the model and what the executive said, in order of time; `kind` decides mark and colour.
  timeline() {
    const entry = (kind) => ({ t, name, subject }) => ({ t, name, subject, kind, run: this });
    const notice = (item) => entry(item.name.startsWith('fault.') ? 'fault' : item.name.startsWith('accuracy.') ? 'accuracy' : 'notice')(item);
    const isSaid = new Set(this.notices.map((item) => item.name));  // what the executive said is among the notices
    const byName = new Map();
    for (const item of this.session_events) if (!isSaid.has(item.name)) (byName.get(item.name) ?? byName.set(item.name, []).get(item.name)).push(item);
    const many = [...byName.values()].flatMap((list) => list.slice(0, MOST_OF_A_NAME).map((item, i) => (
      i === MOST_OF_A_NAME - 1 && list.length > MOST_OF_A_NAME ? { ...item, subject: `${item.subject}; and ${list.length - MOST_OF_A_NAME} more` } : item)));
    const session = (item) => entry(item.name.startsWith('overrun.') ? 'overrun' : item.name.startsWith('fault.') ? 'fault' : 'notice')(item);
    const all = [...this.events.map(entry('event')), ...this.notices.map(notice), ...many.map(session)];
    if (this.status === 'fault') all.push({ t: this.last, name: 'fault', subject: this.message, kind: 'fault', run: this });
    return all.sort((a, b) => a.t - b.t);
  }
}

// Rotates v by the unit quaternion w x y z; with `back`, by its inverse.
export function rotate([w, x, y, z], [a, b, c], back = false) {
  const s = back ? -1 : 1;
  const [i, j, k] = [s * x, s * y, s * z];
  const [u, v, t] = [2 * (j * c - k * b), 2 * (k * a - i * c), 2 * (i * b - j * a)];
  return [a + w * u + (j * t - k * v), b + w * v + (k * u - i * t), c + w * t + (i * v - j * u)];
}

// Of a body, in the axes of another.
export function relativePosition(run, body, reference, place) {
  const from = run.pose(reference, place);
  const p = run.vector(run.bodies[body].column + BODY.p, place);
  return rotate(from.q, p.map((value, k) => value - from.p[k]), true);
}
