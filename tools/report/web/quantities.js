// Quantities for plots: groups of curves over time, each group with one unit. A group has `choices` (components, units, …), and
// choice.build(run) gives the run's curves: {name, colour (number), values (on the run's frames), marks: [{t, value}]}.
import { PALETTE } from './colours.js';
import { digits } from './dom.js';
import { BODY, GROUND, ROWS, relativePosition, rotate } from './run.js';

const DEG = 180 / Math.PI;
const XYZ = ['x', 'y', 'z'];
const DUPLICATED = new Set([0, 1, 2, 3, 7]);  // sensors of what bodies' and joints' own plots show, see Sensor::Kind

function map(count, calc) { return Float64Array.from({ length: count }, (_, i) => calc(i)); }
function atFrame(index) { return { index, fraction: 0 }; }

function norm(run, column, count = 3) {
  const columns = Array.from({ length: count }, (_, k) => run.column(column + k));
  return map(run.count, (i) => Math.hypot(...columns.map((values) => values[i])));
}

function isSilent(run, column, width) {
  return Array.from({ length: width }, (_, k) => column + k).every((k) => run.isConstant(k) && run.frames.first[k] === 0);
}

const bodyName = (run, index) => (index === GROUND ? 'ground' : run.bodies[index].name);

// A pair is shown in the colour of the body that is not the first.
const pairColour = (pair) => Math.max(pair.a, pair.b) + (Math.min(pair.a, pair.b) === 0 ? 0 : 8 * (1 + Math.min(pair.a, pair.b)));

// The time and heights that show the nearest approach, where the rest of the curves would hide it.
function findNearest(runs) {
  const pairs = runs.flatMap((run) => run.pairs.map((pair) => ({ ...pair, run })));
  if (pairs.length === 0) return null;
  const nearest = pairs.reduce((best, pair) => (pair.min < best.min ? pair : best));
  const limit = 4 * Math.max(Math.abs(nearest.min), 0.05);
  const values = nearest.run.column(nearest.column);
  const largest = values.reduce((size, value) => (Number.isFinite(value) ? Math.max(size, value) : size), 0);
  if (largest < 2 * limit) return null;
  let first = nearest.run.find(nearest.t).index, last = first;
  while (first > 0 && !(values[first] > limit)) first -= 1;
  while (last < nearest.run.count - 1 && !(values[last] > limit)) last += 1;
  return { pair: nearest, x: [nearest.run.time[first], nearest.run.time[last]], y: [Math.min(0, 1.1 * nearest.min), limit] };
}

function clearances(runs) {
  const nearest = findNearest(runs);
  const all = runs.some((run) => run.pairs_in_all > run.pairs.length) ? '; of many pairs the 40 nearest' : '';
  const build = (run) => run.pairs.map((pair) => ({
    name: pair.method === 'exact' ? pair.name : `${pair.name}, ${pair.method}`, colour: pairColour(pair), values: run.column(pair.column),
    rank: -pair.min, marks: [{ t: pair.t, value: pair.min }] }));
  const smallest = nearest === null ? ''
    : `; the smallest ${digits(nearest.pair.min, 4)} m at ${digits(nearest.pair.t, 5)} s, ${nearest.pair.name}`;
  return { kind: 'clearance', title: 'Clearances', note: `smallest distance between two bodies’ shapes, negative where they overlap${all}${smallest}`, choices: [
    { name: 'all', unit: 'm', build }, ...(nearest === null ? [] : [{ name: 'nearest approach', unit: 'm', build, window: nearest }])] };
}

// The joints of one follower share its colour; dashes distinguish them.
function jointColour(run, joint) {
  const before = run.joints.filter((other) => other.follower === joint.follower && other.column < joint.column).length;
  return joint.follower + PALETTE * before;
}

function reactions(first, unit, title) {
  const held = (run) => run.joints.filter((joint) => !isSilent(run, joint.column + 1 + first, 3));
  const choices = [{ name: first === 0 ? '|F|' : '|M|', unit, build: (run) => held(run).map((joint) => (
    { name: joint.name, colour: jointColour(run, joint), values: norm(run, joint.column + 1 + first), marks: [] })) }];
  for (let row = first; row < first + 3; row += 1) {
    choices.push({ name: ROWS[row], unit, build: (run) => held(run).map((joint) => (
      { name: joint.name, colour: jointColour(run, joint), values: run.column(joint.column + 1 + row),
        marks: joint.peaks[row].value ? [joint.peaks[row]] : [] })) });
  }
  return { kind: 'reaction', title, note: `the base’s on the follower, along the ${first === 0 ? 'joint' : 'rotation'} frame`, choices };
}

function vectors(title, note, unit, column, scale) {
  const curve = (run, body, i, values) => ({ name: body.name, colour: i, values, marks: [] });
  return { title, note, choices: [
    { name: 'size', unit, build: (run) => run.bodies.map((body, i) => curve(run, body, i, norm(run, body.column + column).map((v) => v * scale))) },
    ...XYZ.map((axis, k) => ({ name: axis, unit, build: (run) => run.bodies.map((body, i) => (
      curve(run, body, i, map(run.count, (frame) => run.column(body.column + column + k)[frame] * scale)))) })),
  ] };
}

// Positions of the other bodies, seen from the first body.
function relative(runs) {
  const curves = (pick) => (run) => run.bodies.map((body, i) => ({ name: body.name, colour: i, marks: [],
    values: map(run.count, (frame) => pick(relativePosition(run, i, 0, atFrame(frame)))) })).slice(1);
  const name = runs[0].bodies[0].name;
  return { kind: 'position', title: `Position from ${name}`, note: `of the bodies’ origins, in the axes of ${name}`, choices: [
    { name: 'distance', unit: 'm', build: curves((p) => Math.hypot(...p)) },
    ...XYZ.map((axis, k) => ({ name: axis, unit: 'm', build: curves((p) => p[k]) })) ] };
}

// Velocities in the axes of the first body, for an observer who does not rotate with it.
function relativeVelocity(runs) {
  const calc = (run, i, frame) => {
    const place = atFrame(frame);
    const v = run.vector(run.bodies[i].column + BODY.v, place), v0 = run.vector(run.bodies[0].column + BODY.v, place);
    return rotate(run.pose(0, place).q, v.map((value, k) => value - v0[k]), true);
  };
  const curves = (pick) => (run) => run.bodies.map((body, i) => ({ name: body.name, colour: i, marks: [],
    values: map(run.count, (frame) => pick(calc(run, i, frame))) })).slice(1);
  const name = runs[0].bodies[0].name;
  return { kind: 'velocity', title: `Velocity relative to ${name}`, note: `of the bodies’ origins, components along the axes of ${name}`, choices: [
    { name: 'size', unit: 'm/s', build: curves((v) => Math.hypot(...v)) },
    ...XYZ.map((axis, k) => ({ name: axis, unit: 'm/s', build: curves((v) => v[k]) })) ] };
}

function points() {
  const curves = (pick) => (run) => run.points.map((point) => ({ name: `${point.name} from ${bodyName(run, point.seen_from)}`, colour: point.body,
    values: pick(run, point), marks: [] }));
  return { title: 'Points', note: 'in the axes of what they are seen from', choices: [
    { name: 'distance', unit: 'm', build: curves((run, point) => norm(run, point.column)) },
    ...XYZ.map((axis, k) => ({ name: axis, unit: 'm', build: curves((run, point) => run.column(point.column + k)) })) ] };
}

function loads(torque) {
  return { title: torque ? 'Torques applied' : 'Thrusts and forces', note: 'sizes, those that act at some time', choices: [{ name: 'all', unit: torque ? 'N m' : 'N',
    build: (run) => run.loads.filter((load) => load.torque === torque && !isSilent(run, load.column, 1)).map((load) => {
      const scale = Math.hypot(...load.direction);
      return { name: load.name, colour: load.body, values: run.column(load.column).map((value) => value * scale), marks: [] };
    }) }] };
}

// Of springs between points. A pusher's stroke ends where it has its free length.
function springs() {
  const curves = (pick) => (run) => run.springs.map((spring, i) => ({ name: spring.name, colour: i, values: pick(run, spring), marks: [] }));
  const stroke = (run, { column, push_only: pushes, free_length: free }) => {
    const lengths = run.column(column + 1), scales = run.column(column + 2);
    return map(run.count, (i) => (scales[i] === 0 || (pushes && lengths[i] >= free) ? NaN : lengths[i] - lengths[0]));
  };
  return { title: 'Springs', note: 'forces on the follower, a push is positive; strokes from the start, while they act', choices: [
    { name: 'force', unit: 'N', build: curves((run, spring) => run.column(spring.column)) },
    { name: 'stroke', unit: 'm', build: curves(stroke) },
    { name: 'length', unit: 'm', build: curves((run, spring) => run.column(spring.column + 1)) } ] };
}

// Pushers, stops and cords: forces while they act.
function oneSided(runs) {
  const curves = (angle, pick) => (run) => run.one_sided.flatMap((force, i) => (
    force.angle !== angle || isSilent(run, force.column, 1) ? [] : [{ name: force.name, colour: i, values: pick(run, force), marks: [] }]));
  const force = (run, { column }) => run.column(column);
  const travel = (run, { column }) => {
    const places = run.column(column + 1), scales = run.column(column + 2), depths = run.column(column + 3);
    return map(run.count, (i) => (scales[i] !== 0 && depths[i] > 0 ? places[i] : NaN));
  };
  const wound = (run) => run.one_sided.flatMap(({ name, drum, column }, i) => {
    const scales = run.column(column + 2), angles = run.column(column + 5);
    return drum === null ? [] : [{ name, colour: i, values: map(run.count, (k) => (scales[k] !== 0 ? angles[k] : NaN)), marks: [] }];
  });
  const choices = [
    { name: 'force', unit: 'N', build: curves(false, force) }, { name: 'place', unit: 'm', build: curves(false, travel) },
    { name: 'moment', unit: 'N m', build: curves(true, force) }, { name: 'angle', unit: 'rad', build: curves(true, travel) },
    { name: 'wound', unit: 'rad', build: wound } ];
  return { title: 'Pushers, stops and cords', note: 'along their coordinate on the follower; places while they act',
    choices: choices.filter((choice) => runs.some((run) => choice.build(run).length > 0)) };
}

// Of the contacts that close at some time.
function contacts() {
  const curves = (column) => (run) => run.contact_curves.flatMap((contact, i) => (
    isSilent(run, contact.column, 1) ? [] : [{ name: contact.name, colour: i, values: run.column(contact.column + column), marks: [] }]));
  return { title: 'Contacts', note: 'sums over the pairs of shapes of each contact that touches; depth: of the deepest pair', choices: [
    { name: 'normal force', unit: 'N', build: curves(0) }, { name: 'friction', unit: 'N', build: curves(1) },
    { name: 'depth', unit: 'm', build: curves(2) }, { name: 'slip speed', unit: 'm/s', build: curves(3) } ] };
}

// Generalised coordinates of bodies that bend, if there are any.
function modal() {
  return { title: 'Modal coordinates', note: 'of flexible bodies, mass-normalised', choices: [{ name: 'all', unit: 'kg½ m',
    build: (run) => run.bodies.flatMap((body, i) => Array.from({ length: body.modal ?? 0 }, (_, k) => ({
      name: `${body.name} ${k + 1}`, colour: i + 8 * k, values: run.column(body.modal_column + k), marks: [] }))) }] };
}

// One choice per unit, of what is not the same all the time.
function byUnit(title, note, runs, list) {
  const units = [...new Set(runs.flatMap((run) => list(run).map((curve) => curve.unit)))];
  return { title, note, choices: units.map((unit) => ({ name: unit, unit, build: (run) => list(run).filter((curve) => curve.unit === unit)
    .map((curve, i) => ({ name: curve.name, colour: i + 1, values: run.column(curve.column), marks: [] })) })) };
}

const changingChannels = (run) => run.channels.filter((channel) => !run.isConstant(channel.column));
const ownSensors = (run) => run.sensors.filter((sensor) => !DUPLICATED.has(sensor.kind)).flatMap((sensor) => (
  Array.from({ length: sensor.width }, (_, k) => ({ unit: sensor.unit, column: sensor.column + k,
    name: sensor.width > 1 ? `${sensor.name}.${XYZ[k] ?? k}` : sensor.name }))));

// Components that flight software had otherwise than they were measured, each beside the one measured.
const receivedSensors = (run) => run.received.flatMap((sensor, i) => Array.from({ length: sensor.width }, (_, k) => {
  const measured = run.sensors[i].column + k, received = sensor.column + k, name = sensor.width > 1 ? `${sensor.name}.${XYZ[k] ?? k}` : sensor.name;
  const differs = run.column(measured).some((value, at) => value !== run.column(received)[at]);
  return differs ? [{ unit: sensor.unit, column: received, name: `${name} as received` }, { unit: sensor.unit, column: measured, name: `${name} as measured` }] : [];
}).flat());

// Quantities that requirements judge, each in its interval: also displacements, angles, speeds and components that have no plot of their own.
function requirements(runs) {
  const ids = [...new Set(runs.flatMap((run) => run.verdict.map((item) => item.id)))];
  const build = (id) => (run) => {
    const item = run.verdict.find((entry) => entry.id === id), place = run.requirements.find((entry) => entry.id === id);
    if (!item || !place || !run.column(place.column).some(Number.isFinite)) return [];
    return [{ name: item.quantity, colour: 1, values: run.column(place.column), marks: item.evaluated ? [{ t: item.t, value: item.value }] : [] }];
  };
  const choices = ids.map((id) => ({ name: id, unit: runs.flatMap((run) => run.verdict).find((item) => item.id === id).unit || '1', build: build(id) }));
  return { kind: 'requirement', title: 'Quantities required', note: 'each in its interval, with its limits; the triangle marks the value that counts',
    choices: choices.filter((choice) => runs.some((run) => choice.build(run).length > 0)) };
}

export function buildQuantities(runs) {
  const all = [
    requirements(runs), clearances(runs), points(), reactions(0, 'N', 'Reaction forces'), reactions(3, 'N m', 'Reaction moments'),
    { kind: 'rate', ...vectors('Angular rates', 'body axes', 'deg/s', BODY.w, DEG) }, relative(runs), relativeVelocity(runs), modal(), loads(false), loads(true), springs(), oneSided(runs), contacts(),
    { kind: 'sensor', ...byUnit('Sensors', 'as measured; positions, rates and reactions have plots of their own', runs, ownSensors) },
    byUnit('Sensors as received', 'by flight software: stuck, biased, delayed or dropped by faults; the values measured beside them', runs, receivedSensors),
    byUnit('Commands', 'channels that change, as the steps read them', runs, changingChannels),
  ];
  return all.filter((group) => runs.some((run) => group.choices.some((choice) => choice.build(run).length > 0)));
}
