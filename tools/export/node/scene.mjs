// Shapes of a body as primitives of foxglove.SceneEntity, in the body's axes.
import qh from 'quickhull3d';

const COLOURS = ['#4c78a8', '#f58518', '#54a24b', '#e45756', '#72b7b2', '#eeca3b', '#b279a2', '#9d755d'];

function getColour(index) {
  const text = COLOURS[index % COLOURS.length];
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
  return { r, g, b, a: 1 };
}

const SIDES = 48;  // of what is turned about an axis
const PLANE = 10;  // m, radius of the disc that is drawn of a half-space

const toVector = ([x, y, z]) => ({ x, y, z });
const toQuaternion = ([w, x, y, z]) => ({ x, y, z, w });
const NO_TURN = { x: 0, y: 0, z: 0, w: 1 };

// The rotation that takes z to the direction from → to.
function turnFromZ(from, to) {
  const d = to.map((value, i) => value - from[i]);
  const length = Math.hypot(...d);
  if (length === 0) return { length, q: NO_TURN };
  const [x, y, z] = d.map((value) => value / length);
  if (z < -1 + 1e-12) return { length, q: { x: 1, y: 0, z: 0, w: 0 } };
  const norm = Math.sqrt(2 * (1 + z));
  return { length, q: { x: -y / norm, y: x / norm, z: 0, w: norm / 2 } };
}

function addRod(entity, shape, color, topScale, bottomScale = 1, radius = shape.radius) {
  const { length, q } = turnFromZ(shape.from, shape.to);
  const centre = shape.from.map((value, i) => (value + shape.to[i]) / 2);
  entity.cylinders.push({
    pose: { position: toVector(centre), orientation: q },
    size: { x: 2 * radius, y: 2 * radius, z: length }, bottom_scale: bottomScale, top_scale: topScale, color,
  });
}

function addBall(entity, centre, radius, color) {
  entity.spheres.push({
    pose: { position: toVector(centre), orientation: NO_TURN }, size: { x: 2 * radius, y: 2 * radius, z: 2 * radius }, color,
  });
}

function addFrustum(entity, shape, color) {
  const widest = Math.max(shape.radius, shape.end_radius);
  addRod(entity, shape, color, shape.end_radius / widest, shape.radius / widest, widest);
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scale = (a, s) => a.map((value) => value * s);
const add = (...vectors) => [0, 1, 2].map((i) => vectors.reduce((sum, v) => sum + v[i], 0));
const unit = (a) => scale(a, 1 / Math.hypot(...a));
const across = (axis) => unit(cross(axis, axis.map((value) => (Math.abs(value) < 0.6 ? 1 : 0))));

// A profile turned about the axis, seen from both sides; of a half the 180° around its side.
function addWall(entity, shape, color) {
  const axis = unit(add(shape.to, scale(shape.from, -1)));
  const side = shape.half ? unit(add(shape.half, scale(axis, -shape.half.reduce((sum, value, i) => sum + value * axis[i], 0)))) : across(axis);
  const third = cross(axis, side), turn = shape.half ? Math.PI : 2 * Math.PI;
  const at = ([z, r], k) => {
    const angle = -turn / 2 + turn * k / SIDES;
    return add(shape.from, scale(axis, z), scale(side, r * Math.cos(angle)), scale(third, r * Math.sin(angle)));
  };
  const triangles = [];
  for (let i = 0; i + 1 < shape.profile.length; i += 1) {
    for (let k = 0; k < SIDES; k += 1) {
      const [a, b, c, d] = [at(shape.profile[i], k), at(shape.profile[i], k + 1), at(shape.profile[i + 1], k + 1), at(shape.profile[i + 1], k)];
      triangles.push(a, b, c, a, c, d, c, b, a, d, c, a);
    }
  }
  addTriangles(entity, triangles, color);
}

// Of the plane a disc around the given point.
function addPlane(entity, shape, color) {
  const normal = unit(shape.normal), x = across(normal), y = cross(normal, x);
  const at = (k) => add(shape.point, scale(x, PLANE * Math.cos(2 * Math.PI * k / SIDES)), scale(y, PLANE * Math.sin(2 * Math.PI * k / SIDES)));
  addTriangles(entity, Array.from({ length: SIDES }, (_, k) => [shape.point, at(k), at(k + 1)]).flat(), color);
}

function addHull(entity, points, color) {
  addTriangles(entity, qh(points).flat().map((i) => points[i]), color);
}

function addTriangles(entity, points, color) {
  const triangles = points.map(toVector);
  entity.triangles.push({
    pose: { position: toVector([0, 0, 0]), orientation: NO_TURN }, points: triangles, color, colors: [], indices: [],
  });
}

// A body without a shape is a ball of `small` metres, so that it is seen.
export function buildEntity(body, index, small) {
  const color = getColour(index);
  const entity = {
    timestamp: { sec: 0, nsec: 0 }, frame_id: body.name, id: body.name, lifetime: { sec: 0, nsec: 0 }, frame_locked: true,
    metadata: [{ key: 'mass', value: `${body.mass} kg` }],
    arrows: [], cubes: [], spheres: [], cylinders: [], lines: [], triangles: [], texts: [], models: [],
  };
  for (const shape of body.shapes) {
    if (shape.kind === 'sphere') addBall(entity, shape.centre, shape.radius, color);
    if (shape.kind === 'cylinder') addRod(entity, shape, color, 1);
    if (shape.kind === 'cone') addRod(entity, shape, color, 0);
    if (shape.kind === 'capsule') {
      addRod(entity, shape, color, 1);
      addBall(entity, shape.from, shape.radius, color);
      addBall(entity, shape.to, shape.radius, color);
    }
    if (shape.kind === 'box') {
      entity.cubes.push({
        pose: { position: toVector(shape.centre), orientation: toQuaternion(shape.attitude) }, size: toVector(shape.size), color,
      });
    }
    if (shape.kind === 'frustum') addFrustum(entity, shape, color);
    if (shape.kind === 'hollow') addWall(entity, shape, color);
    if (shape.kind === 'half_space') addPlane(entity, shape, color);
    if (shape.kind === 'hull') addHull(entity, shape.points, color);
  }
  if (body.shapes.length === 0) addBall(entity, [0, 0, 0], small, color);
  return entity;
}

// What stands still, if anything does.
export const buildGround = (shapes) => (shapes.length === 0 ? [] : [{ ...buildEntity({ name: 'world', mass: 0, shapes }, 7, 0), id: 'ground', metadata: [] }]);

export function buildTransform(name, body, timestamp) {
  return {
    timestamp, parent_frame_id: 'world', child_frame_id: name, translation: toVector(body.p), rotation: toQuaternion(body.q),
  };
}
