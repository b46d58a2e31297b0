// Shape of a body, in its axes: a mesh and its edges.
import * as THREE from 'three';
import { ConvexGeometry } from 'three/addons/geometries/ConvexGeometry.js';

// Round shapes have so many sides; an edge is drawn where faces meet at more degrees than `sharp`. Of an outline all
// sides are seen.
const SOLID = { sides: 40, sharp: 30 };
const OUTLINE = { sides: 12, sharp: 10 };
const PLANE = 10;  // m, radius of the disc that is drawn of a half-space

function vector([x, y, z]) { return new THREE.Vector3(x, y, z); }
export function quaternion([w, x, y, z]) { return new THREE.Quaternion(x, y, z, w); }

// three.js has its shapes with an axis along y, centred.
function alongAxis(geometry, from, to) {
  const axis = vector(to).sub(vector(from)).normalize();
  geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis));
  return geometry.translate(...[0, 1, 2].map((k) => (from[k] + to[k]) / 2));
}

// Of the plane a disc around the given point.
function buildPlane(shape, sides) {
  const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), vector(shape.normal).normalize());
  return new THREE.CircleGeometry(PLANE, sides).applyQuaternion(turn).translate(...shape.point);
}

// A profile turned about the axis; of a half the 180° around its side. three.js turns about y, from z on.
function buildWall(shape, sides) {
  const axis = vector(shape.to).sub(vector(shape.from)).normalize();
  const side = shape.half ? vector(shape.half) : new THREE.Vector3(...[0, 1, 2].map((k) => (Math.abs(axis.getComponent(k)) < 0.6 ? 1 : 0)));
  side.addScaledVector(axis, -side.dot(axis)).normalize();
  const points = shape.profile.map(([z, r]) => new THREE.Vector2(r, z));
  const lathe = shape.half ? new THREE.LatheGeometry(points, sides / 2, -Math.PI / 2, Math.PI) : new THREE.LatheGeometry(points, sides);
  return lathe.applyMatrix4(new THREE.Matrix4().makeBasis(new THREE.Vector3().crossVectors(axis, side), axis, side)).translate(...shape.from);
}

// Flat facets: corners are not shared.
function buildMesh(shape) {
  const geometry = new THREE.BufferGeometry();
  const corners = shape.triangles.flatMap((triangle) => triangle.flatMap((corner) => shape.vertices[corner]));
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
  geometry.computeVertexNormals();
  return geometry;
}

function buildGeometry(shape, sides) {
  const length = shape.from && shape.to ? vector(shape.to).distanceTo(vector(shape.from)) : 0;
  const thin = Math.max(shape.radius ?? 0, 0.01 * length);  // a capsule of radius 0 is a segment
  switch (shape.kind) {
    case 'sphere': return new THREE.SphereGeometry(shape.radius, sides, sides / 2).translate(...shape.centre);
    case 'capsule': return alongAxis(new THREE.CapsuleGeometry(thin, length, sides / 4, sides), shape.from, shape.to);
    case 'cylinder': return alongAxis(new THREE.CylinderGeometry(shape.radius, shape.radius, length, sides), shape.from, shape.to);
    case 'cone': return alongAxis(new THREE.ConeGeometry(shape.radius, length, sides), shape.from, shape.to);
    case 'frustum': return alongAxis(new THREE.CylinderGeometry(shape.end_radius, shape.radius, length, sides), shape.from, shape.to);
    case 'box': return new THREE.BoxGeometry(...shape.size).applyQuaternion(quaternion(shape.attitude)).translate(...shape.centre);
    case 'half_space': return buildPlane(shape, sides);
    case 'hollow': return buildWall(shape, sides);
    case 'mesh': return buildMesh(shape);
    default: return new ConvexGeometry(shape.points.map(vector));
  }
}

// A group in body axes. `style`: 'solid', 'assumed' (no shape was given) or 'ghost' (of the second run).
export function buildBody(body, style) {
  const group = new THREE.Group();
  const open = body.shapes.some((shape) => ['hollow', 'half_space', 'mesh'].includes(shape.kind));
  const material = style === 'solid'
    ? new THREE.MeshStandardMaterial({ roughness: 0.75, metalness: 0.05, side: open ? THREE.DoubleSide : THREE.FrontSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })
    : new THREE.MeshBasicMaterial({ transparent: true, opacity: style === 'ghost' ? 0.15 : 0.25, depthWrite: false });
  const lines = new THREE.LineBasicMaterial({ transparent: true, opacity: style === 'solid' ? 0.55 : 0.9 });
  const { sides, sharp } = style === 'ghost' ? OUTLINE : SOLID;
  for (const shape of body.shapes) {
    const geometry = buildGeometry(shape, sides);
    group.add(new THREE.Mesh(geometry, material), new THREE.LineSegments(new THREE.EdgesGeometry(geometry, sharp), lines));
  }
  group.userData.paint = (colour) => {
    material.color.set(colour);
    lines.color.set(colour);
    if (style === 'solid') lines.color.multiplyScalar(0.45);
  };
  return group;
}

// Distance from the body's origin to its farthest point.
export function calcReach(group) {
  let reach = 0;
  group.traverse((node) => {
    if (!node.isMesh) return;
    node.geometry.computeBoundingSphere();
    const { center, radius } = node.geometry.boundingSphere;
    reach = Math.max(reach, center.length() + radius);
  });
  return reach;
}

// An arrow that set() lays from a point along a vector; `towards`: it ends at the point.
export class Arrow {
  constructor(towards) {
    this.towards = towards;
    this.material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.92 });
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0), this.material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(1, 1, 16).translate(0, -0.5, 0), this.material);
    this.group = new THREE.Group();
    this.group.add(this.shaft, this.head);
    this.group.renderOrder = 2;
    for (const part of [this.shaft, this.head]) part.renderOrder = 2;
  }

  // `thickness`: radius of the shaft, in the unit of the point.
  set(point, force, thickness) {
    const length = force.length();
    this.group.visible = length > thickness;
    if (!this.group.visible) return;
    this.group.position.copy(point);
    if (this.towards) this.group.position.sub(force);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.clone().divideScalar(length));
    const head = Math.min(7 * thickness, 0.6 * length);
    this.shaft.scale.set(thickness, length - head, thickness);
    this.head.position.set(0, length, 0);
    this.head.scale.set(head * 0.4, head, head * 0.4);
  }
}
