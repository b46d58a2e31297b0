// Shapes of a body as primitives of foxglove.SceneEntity, in the body's axes.
import qh from 'quickhull3d';

const COLOURS = ['#4c78a8', '#f58518', '#54a24b', '#e45756', '#72b7b2', '#eeca3b', '#b279a2', '#9d755d'];

function getColour(index) {
  const text = COLOURS[index % COLOURS.length];
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
  return { r, g, b, a: 1 };
}

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

function addRod(entity, shape, color, topScale) {
  const { length, q } = turnFromZ(shape.from, shape.to);
  const centre = shape.from.map((value, i) => (value + shape.to[i]) / 2);
  entity.cylinders.push({
    pose: { position: toVector(centre), orientation: q },
    size: { x: 2 * shape.radius, y: 2 * shape.radius, z: length }, bottom_scale: 1, top_scale: topScale, color,
  });
}

function addBall(entity, centre, radius, color) {
  entity.spheres.push({
    pose: { position: toVector(centre), orientation: NO_TURN }, size: { x: 2 * radius, y: 2 * radius, z: 2 * radius }, color,
  });
}

function addHull(entity, points, color) {
  const triangles = qh(points).flat().map((i) => toVector(points[i]));
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
    if (shape.kind === 'hull') addHull(entity, shape.points, color);
  }
  if (body.shapes.length === 0) addBall(entity, [0, 0, 0], small, color);
  return entity;
}

export function buildTransform(name, body, timestamp) {
  return {
    timestamp, parent_frame_id: 'world', child_frame_id: name, translation: toVector(body.p), rotation: toQuaternion(body.q),
  };
}
