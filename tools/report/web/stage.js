// The picture: canvas, camera, names, what to show, and the player.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { colour, css } from './colours.js';
import { checkbox, digits, el, select } from './dom.js';
import { GROUND } from './run.js';
import { Actors } from './scene.js';

const NEAR = 1.5;  // reaches of the largest body from the view's origin: farther away, bodies may be out of view
const MOST_NAMED = 12;  // bodies; of more, names hide each other until asked for
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

// The axis of W that is nearest to upwards; z without gravity.
function chooseUp(gravity) {
  const largest = Math.max(...gravity.map(Math.abs));
  if (largest === 0) return '+z';
  const k = gravity.findIndex((value) => Math.abs(value) === largest);
  return (gravity[k] < 0 ? '+' : '-') + 'xyz'[k];
}

function niceNumber(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 5, 10].find((step) => step * power >= value * 0.999);
}

export class Stage {
  constructor(runs, clock) {
    this.runs = runs;
    this.clock = clock;
    this.follow = { body: 0, turn: false };
    this.up = chooseUp(runs[0].gravity);
    this.arrowScale = 1;
    this.show = { names: runs[0].bodies.length <= MOST_NAMED, grid: true };
    this.canvas = el('canvas', { tabindex: 0, 'aria-label': 'bodies in motion' });
    this.names = el('div', { class: 'names' });
    this.legend = el('div', { class: 'hint' });
    this.view = el('div', { class: 'view' }, this.canvas, this.names, this.legend);
    this.node = el('div', { class: 'stage' }, this.view, this.buildControls());
    try {
      this.buildScene();
    } catch (error) {
      this.renderer = null;
      this.view.replaceChildren(el('p', { class: 'banner' },
        'This browser gives no WebGL, so the picture is missing; everything else is here.'));
      return;
    }
    new ResizeObserver(() => this.resize()).observe(this.view);
    clock.listen(() => this.request());
    this.paint();
  }

  buildScene() {
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 1, 1000);
    this.actors = this.runs.map((run, i) => new Actors(run, i > 0));
    this.light = new THREE.DirectionalLight(0xffffff, 2.4);
    this.ambient = new THREE.HemisphereLight(0xffffff, 0x555a66, 1.6);
    this.scene.add(this.light, this.ambient, ...this.actors.map((actors) => actors.group));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.request());
    this.reach = Math.max(...this.actors.map((actors) => actors.reach));
    this.labels = this.runs[0].bodies.map((body) => this.names.appendChild(el('span', {}, el('b', {}, body.name))));
    this.buildTriad();
    this.updateActors();
    this.frameAll();
  }

  buildControls() {
    const { runs } = this;
    const bodies = runs[0].bodies.map((body, i) => [i, body.name]);
    const change = (apply) => (value) => { apply(value); this.request(); };
    const toggle = (name, key) => checkbox(name, true, change((on) => {
      for (const actors of this.actors ?? []) actors.show[key] = on;
    }));
    const hasForces = runs[0].joints.length + runs[0].loads.length > 0;
    return el('div', { class: 'controls' },
      select('follow', [...bodies, [GROUND, 'nothing (W)']], 0, change((value) => { this.follow.body = Number(value); })),
      select('axes', [['fixed', 'of W'], ['turn', 'of the body']], 'fixed', change((value) => { this.follow.turn = value === 'turn'; })),
      select('up', ['+x', '-x', '+y', '-y', '+z', '-z'].map((axis) => [axis, axis.replace('-', '−')]), this.up,
        change((value) => { this.up = value; this.frameAll(); })),
      el('span', { class: 'field' }, 'view from', ['x', 'y', 'z'].map((axis) => (
        el('button', { title: `from ${axis} towards the origin`, onclick: () => this.look(new THREE.Vector3(...AXES[axis])) }, axis)))),
      el('button', { title: 'everything into view', onclick: () => this.frameAll() }, 'fit'),
      hasForces ? toggle('reactions', 'reactions') : null,
      hasForces ? toggle('loads', 'loads') : null,
      runs[0].points.length ? toggle('paths', 'paths') : null,
      checkbox('names', this.show.names, change((on) => { this.show.names = on; })),
      checkbox('grid', true, change((on) => { this.show.grid = on; })),
      hasForces ? el('label', { class: 'field', title: 'length of the arrows' }, 'arrows',
        el('input', { type: 'range', min: -2, max: 3, step: 0.1, value: 0, class: 'short',
          oninput: change((event) => { this.arrowScale = 10 ** Number(event.target.value); }) })) : null);
  }

  get upVector() { return new THREE.Vector3(...AXES[this.up[1]]).multiplyScalar(this.up[0] === '-' ? -1 : 1); }

  // From a little above and beside.
  frameAll(times) {
    if (!this.renderer) return;
    const up = this.upVector;
    const side = Math.abs(up.z) > 0.5 ? new THREE.Vector3(-0.35, -1, 0) : new THREE.Vector3(0.35, 0, 1).applyAxisAngle(up, Math.abs(up.x) > 0.5 ? 0.9 : -0.5);
    this.look(side.normalize().addScaledVector(up, 0.42).normalize(), times);
  }

  look(from, times = [this.clock.t]) {
    if (!this.renderer) return;
    const box = this.calcBox(times);
    const centre = box.getCenter(new THREE.Vector3());
    const up = this.upVector;
    this.camera.up.copy(up);
    if (Math.abs(from.dot(up)) > 0.999) from = from.clone().add(new THREE.Vector3(...(Math.abs(up.x) > 0.5 ? [0, 1e-3, 0] : [1e-3, 0, 0])));
    this.camera.position.copy(centre).addScaledVector(from, 1.15 * this.calcDistance(box, centre, from, up));
    this.camera.near = this.reach * 1e-2;
    this.camera.far = this.reach * 1e4;
    this.camera.updateProjectionMatrix();
    this.controls.object.up.copy(up);
    this.controls.target.copy(centre);
    this.controls.update();
    this.buildGrid();
    this.request();
  }

  // Bodies to show at these times, without those that are far away by then.
  calcBox(times) {
    const near = new THREE.Vector3().setScalar(NEAR * this.reach);
    const box = new THREE.Box3();
    for (const t of times) {
      this.updateActors(t);
      for (const actors of this.actors) box.union(actors.calcBox().intersect(new THREE.Box3(near.clone().negate(), near)));
    }
    return box;
  }

  // From which every corner of the box is in view.
  calcDistance(box, centre, from, up) {
    const right = new THREE.Vector3().crossVectors(up, from).normalize();
    const top = new THREE.Vector3().crossVectors(from, right);
    const half = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    let distance = 0;
    for (const [x, y, z] of [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1, i & 2, i & 4].map((high, k) => (high ? box.max : box.min).getComponent(k)))) {
      const corner = new THREE.Vector3(x, y, z).sub(centre);
      const across = Math.abs(corner.dot(right)) / (half * this.camera.aspect), upwards = Math.abs(corner.dot(top)) / half;
      distance = Math.max(distance, corner.dot(from) + Math.max(across, upwards));
    }
    return distance;
  }

  // A grid through the origin of the view, normal to upwards, that says how large things are.
  buildGrid() {
    if (this.grid) this.scene.remove(this.grid);
    this.cell = niceNumber(this.reach / 4);
    this.grid = new THREE.GridHelper(this.cell * 30, 30, 0x888888, 0x888888);
    this.grid.material.transparent = true;
    this.grid.material.opacity = 0.16;
    this.grid.material.depthWrite = false;
    this.grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), this.upVector);
    this.scene.add(this.grid);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.view;
    if (!this.renderer || width === 0) return;
    const first = this.width === undefined;
    this.width = width;
    if (this.renderer.getPixelRatio() !== devicePixelRatio) this.renderer.setPixelRatio(devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (first) this.frameAll([0, 0.3, 0.6].map((share) => this.clock.first + share * (this.clock.last - this.clock.first)));
    this.draw();
  }

  paint() {
    if (!this.renderer) return;
    this.renderer.setClearColor(css('--ground'));
    for (const actors of this.actors) actors.paint();
    this.labels.forEach((label, i) => { label.style.color = colour(i); });
    this.request();
  }

  request() {
    if (!this.renderer || this.requested) return;
    this.requested = true;
    requestAnimationFrame(() => { this.requested = false; this.draw(); });
  }

  updateActors(t = this.clock.t) {
    const perNewton = this.arrowScale / this.actors[0].unit;
    for (const actors of this.actors) actors.update(t, this.follow, perNewton, 0.008 * this.reach);
  }

  draw() {
    if (!this.renderer || this.width === undefined) return;
    this.updateActors();
    this.grid.visible = this.show.grid;
    this.light.position.copy(this.camera.position).addScaledVector(this.upVector, this.reach).addScaledVector(
      new THREE.Vector3().crossVectors(this.upVector, this.camera.position).normalize(), this.reach);
    this.light.target.position.copy(this.controls.target);
    this.light.target.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    this.placeNames();
    this.writeLegend();
  }

  placeNames() {
    const put = (node, point, shown) => {
      const at = point.project(this.camera);
      const visible = shown && Math.abs(at.x) < 1.1 && Math.abs(at.y) < 1.1 && at.z < 1;
      node.style.display = visible ? '' : 'none';
      if (visible) node.style.transform = `translate(${(at.x + 1) / 2 * this.width}px, ${(1 - at.y) / 2 * this.view.clientHeight}px)`;
    };
    const { group, poses } = this.actors[0];
    group.updateMatrixWorld();
    this.labels.forEach((label, i) => put(label, poses[i].p.clone().applyMatrix4(group.matrixWorld), this.show.names));
    this.turnTriad(group.quaternion);
  }

  // W's axes, in a corner.
  buildTriad() {
    const svg = (tag) => document.createElementNS('http://www.w3.org/2000/svg', tag);
    const box = svg('svg');
    box.setAttribute('viewBox', '-40 -40 80 80');
    box.setAttribute('class', 'triad');
    this.triad = ['x', 'y', 'z'].map((axis) => {
      const line = box.appendChild(svg('line')), letter = box.appendChild(svg('text'));
      letter.textContent = axis;
      return { axis, line, letter };
    });
    this.names.append(box);
  }

  turnTriad(attitude) {
    const toCamera = this.camera.quaternion.clone().invert();
    for (const { axis, line, letter } of this.triad) {
      const end = new THREE.Vector3(...AXES[axis]).applyQuaternion(attitude).applyQuaternion(toCamera);
      line.setAttribute('x2', 26 * end.x);
      line.setAttribute('y2', -26 * end.y);
      letter.setAttribute('x', 34 * end.x);
      letter.setAttribute('y', -34 * end.y);
    }
  }

  writeLegend() {
    const followed = this.follow.body === GROUND ? 'W' : this.runs[0].bodies[this.follow.body].name;
    const axes = this.follow.body !== GROUND && this.follow.turn ? followed : 'W (inertial)';
    const unit = this.actors[0].unit / this.arrowScale * this.cell;
    const parts = [`origin: ${followed}`, `axes: ${axes}`, `grid ${digits(this.cell)} m`];
    if (this.runs[0].joints.length + this.runs[0].loads.length) parts.push(`arrows: one grid cell = ${unit >= 1e3 ? `${digits(unit / 1e3, 3)} kN` : `${digits(unit, 3)} N`}`);
    if (this.runs[0].bodies.some((body) => body.assumed && body.shapes.length)) parts.push('see-through: no shape given, a box of that mass and inertia');
    if (this.runs.length > 1) parts.push('outlines: run B');
    this.legend.textContent = parts.join(' · ');
  }
}
