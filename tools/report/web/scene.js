// The bodies of one run in motion, with forces and paths, as a group in the axes of W whose origin moves with the view.
import * as THREE from 'three';
import { colour } from './colours.js';
import { GROUND } from './run.js';
import { Arrow, buildBody, calcReach, quaternion } from './shapes.js';

const vector = (v) => new THREE.Vector3(v[0], v[1], v[2]);
const GROUND_COLOUR = '#8a8a8a';
const CORD_POINTS = 130;  // of a cord on a drum, its end the last

export class Actors {
  // `ghost`: the second run, drawn as an outline without forces.
  constructor(run, ghost) {
    this.run = run;
    this.ghost = ghost;
    this.group = new THREE.Group();
    this.bodies = run.bodies.map((body) => buildBody(body, ghost ? 'ghost' : body.assumed ? 'assumed' : 'solid'));
    this.reach = Math.max(...this.bodies.map(calcReach));
    this.group.add(...this.bodies);
    this.fixed = run.ground_shapes.length > 0 ? buildBody({ shapes: run.ground_shapes }, ghost ? 'ghost' : 'solid') : null;
    if (this.fixed) this.group.add(this.fixed);
    this.show = { reactions: true, loads: true, paths: true };
    this.reactions = ghost ? [] : run.joints.map(() => new Arrow(false));
    this.loads = ghost ? [] : run.loads.map(() => new Arrow(true));
    for (const arrow of [...this.reactions, ...this.loads]) this.group.add(arrow.group);
    this.springs = ghost ? [] : run.springs.map(() => this.addLine(2));
    this.pushers = ghost ? [] : run.one_sided.filter((force) => force.between !== null).map((force) => ({ force, line: this.addLine(force.drum ? CORD_POINTS : 2) }));
    this.paths = run.points.map((point) => this.addPath(point));
    this.unit = this.calcUnit();
  }

  addLine(points) {
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * points), 3));
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ transparent: true }));
    line.frustumCulled = false;
    this.group.add(line);
    return line;
  }

  // The whole path faintly, the part up to now strongly, in the axes of what it is seen from.
  addPath(point) {
    const { run } = this;
    const positions = new Float32Array(3 * run.count);
    for (let k = 0; k < 3; k += 1) run.column(point.column + k).forEach((value, i) => { positions[3 * i + k] = value; });
    const whole = this.addLine(0), past = this.addLine(0);
    for (const line of [whole, past]) line.geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    whole.material.opacity = 0.35;
    const dot = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial({ depthTest: false, transparent: true }));
    dot.renderOrder = 3;
    const group = new THREE.Group().add(whole, past, dot);
    this.group.add(group);
    return { point, group, whole, past, dot };
  }

  // Newtons that an arrow as long as half the reach stands for: the largest of the run. Reactions and loads share it.
  calcUnit() {
    const { run } = this;
    let largest = 0;
    for (const joint of run.joints) {
      largest = Math.max(largest, Math.hypot(...joint.peaks.slice(0, 3).map((peak) => peak.value)));
    }
    for (const load of run.loads.filter((item) => !item.torque)) {
      const length = Math.hypot(...load.direction);
      for (const value of run.column(load.column)) largest = Math.max(largest, Math.abs(value) * length);
    }
    return largest > 0 ? largest / (0.5 * this.reach) : 1;
  }

  paint() {
    const reaction = colour(2), load = colour(6);
    this.bodies.forEach((body, i) => body.userData.paint(colour(i)));
    this.fixed?.userData.paint(GROUND_COLOUR);
    for (const arrow of this.reactions) arrow.material.color.set(reaction);
    for (const arrow of this.loads) arrow.material.color.set(load);
    for (const line of [...this.springs, ...this.pushers.map((pusher) => pusher.line)]) line.material.color.set(colour(5));
    for (const { point, whole, past, dot } of this.paths) {
      for (const part of [whole, past, dot]) part.material.color.set(colour(point.body));
    }
  }

  // Position of the view's origin relative to the run's first body, and its rotation.
  calcView(place, follow) {
    if (follow.body === GROUND) return { p: this.run.origin(place).map((value) => -value), q: [1, 0, 0, 0] };
    const pose = this.run.pose(follow.body, place);
    return { p: pose.p, q: follow.turn ? pose.q : [1, 0, 0, 0] };
  }

  // `metresPerNewton`, `thickness` (radius, m): of the arrows.
  update(t, follow, metresPerNewton, thickness) {
    const { run } = this;
    const place = run.find(t);
    const view = this.calcView(place, follow);
    const back = quaternion(view.q).invert();
    this.group.quaternion.copy(back);
    this.group.position.set(0, 0, 0);
    this.poses = run.bodies.map((_, i) => {
      const { p, q } = run.pose(i, place);
      return { p: vector(p.map((value, k) => value - view.p[k])), q: quaternion(q) };
    });
    this.bodies.forEach((body, i) => {
      body.position.copy(this.poses[i].p);
      body.quaternion.copy(this.poses[i].q);
    });
    const ground = vector(run.origin(place).map((value, k) => -value - view.p[k]));  // W's origin, seen from the view's
    this.ground = { p: ground, q: new THREE.Quaternion() };
    this.fixed?.position.copy(ground);
    this.reactions.forEach((arrow, i) => this.updateReaction(arrow, run.joints[i], place, metresPerNewton, thickness));
    this.loads.forEach((arrow, i) => this.updateLoad(arrow, run.loads[i], place, metresPerNewton, thickness));
    this.springs.forEach((line, i) => this.updateSpring(line, run.springs[i], place));
    for (const { force, line } of this.pushers) this.updatePusher(line, force, place);
    for (const path of this.paths) this.updatePath(path, place, thickness);
  }

  getPose(body) { return body === GROUND ? this.ground : this.poses[body]; }

  toView(body, point) {
    const { p, q } = this.getPose(body);
    return vector(point).applyQuaternion(q).add(p);
  }

  // The base's force on the follower, at the follower's point.
  updateReaction(arrow, joint, place, metresPerNewton, thickness) {
    const force = new THREE.Vector3();
    for (let row = 0; row < 3; row += 1) {
      force.addScaledVector(vector(joint.axes[row]), this.run.at(joint.column + 1 + row, place));
    }
    force.applyQuaternion(this.getPose(joint.base).q).multiplyScalar(metresPerNewton);
    arrow.set(this.toView(joint.follower, joint.point_follower), force, thickness);
    arrow.group.visible &&= this.show.reactions;
  }

  updateLoad(arrow, load, place, metresPerNewton, thickness) {
    const force = vector(load.direction).multiplyScalar(load.torque ? 0 : this.run.at(load.column, place) * metresPerNewton);
    if (!load.world) force.applyQuaternion(this.getPose(load.body).q);
    arrow.set(this.toView(load.body, load.point), force, thickness);
    arrow.group.visible &&= this.show.loads;
  }

  // Drawn while it can act: switched on, and of a pusher within its stroke.
  updateSpring(line, spring, place) {
    line.visible = this.run.at(spring.column + 2, place, true) !== 0
      && !(spring.push_only && this.run.at(spring.column + 1, place) >= spring.free_length);
    this.putLine(line, spring);
  }

  // A pusher, stop or cord between two points is drawn while it acts; a cord with a drum while it is on.
  updatePusher(line, force, place) {
    line.visible = this.run.at(force.column + 2, place, true) !== 0 && (force.drum !== null || this.run.at(force.column + 3, place, true) > 0);
    if (force.drum) this.putCord(line, force, place);
    else this.putLine(line, force.between);
  }

  // Along the drum from the anchor to where the cord leaves it, rising as a helix, and on to its end.
  putCord(line, { between: { base, follower, point_follower: to }, drum: { centre, axes, radius }, column }, place) {
    const wound = this.run.at(column + 5, place) * Math.sign(this.run.at(column + 4, place));
    const middle = this.toView(base, centre), end = this.toView(follower, to);
    const [x, y, z] = axes.map((axis) => vector(axis).applyQuaternion(this.getPose(base).q));
    const on = (angle, height) => middle.clone().addScaledVector(x, radius * Math.cos(angle)).addScaledVector(y, radius * Math.sin(angle)).addScaledVector(z, height);
    const height = end.clone().sub(middle).dot(z);
    const arc = radius * Math.abs(wound), straight = end.clone().addScaledVector(z, -height).distanceTo(on(wound, 0));
    const points = line.geometry.getAttribute('position');
    for (let i = 0; i < CORD_POINTS - 1; i += 1) {
      const part = i / (CORD_POINTS - 2);
      points.setXYZ(i, ...on(wound * part, arc + straight > 0 ? height * part * arc / (arc + straight) : 0));
    }
    points.setXYZ(CORD_POINTS - 1, ...end);
    points.needsUpdate = true;
  }

  putLine(line, { base, follower, point_base: from, point_follower: to }) {
    const ends = line.geometry.getAttribute('position');
    ends.setXYZ(0, ...this.toView(base, from));
    ends.setXYZ(1, ...this.toView(follower, to));
    ends.needsUpdate = true;
  }

  updatePath({ point, group, past, dot }, place, thickness) {
    const { p, q } = this.getPose(point.seen_from);
    group.visible = this.show.paths;
    group.position.copy(p);
    group.quaternion.copy(q);
    past.geometry.setDrawRange(0, place.index + 1);
    dot.position.set(...this.run.vector(point.column, place));
    dot.scale.setScalar(2 * thickness);
  }

  // Corners of what is to be seen, in the axes of the view: for framing it.
  calcBox() {
    const box = new THREE.Box3();
    this.group.updateMatrixWorld(true);
    for (const body of this.bodies) box.expandByObject(body, true);
    return box;
  }
}
