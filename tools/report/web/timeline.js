// The player, the slider with its marks, the list of events, and the joints' modes at the time shown.
import { digits, el, fixed, select } from './dom.js';
import { ROWS } from './run.js';

const KINDS = {
  event: ['●', 'event of the model'], fault: ['▲', 'fault'], overrun: ['■', 'overrun'], notice: ['◆', 'flight software'],
  accuracy: ['◇', 'not resolved by the step'],
};
const SPEEDS = [0.01, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const SAME_TIME = 1e-9;  // of the run's length: the rounding of a click on an event

export class Timeline {
  constructor(runs, clock) {
    this.runs = runs;
    this.clock = clock;
    this.places = Math.max(3, Math.min(6, Math.ceil(-Math.log10(runs[0].dt))));
    this.entries = runs.flatMap((run) => run.timeline()).sort((a, b) => a.t - b.t);
    this.node = el('div', { class: 'timeline' }, this.buildPlayer(), el('div', { class: 'lists' }, this.buildEvents(), this.buildJoints()));
    clock.listen((t) => this.update(t));
    document.addEventListener('keydown', (event) => this.press(event));
    // A button that was clicked does not keep the focus: the space bar goes on playing.
    document.addEventListener('mousedown', (event) => { if (event.target.closest?.('button')) event.preventDefault(); });
  }

  share(t) { return (t - this.clock.first) / (this.clock.last - this.clock.first || 1); }

  buildPlayer() {
    const { clock } = this;
    this.button = el('button', { class: 'play', 'aria-label': 'play or pause', title: 'play or pause (space)', onclick: () => clock.play() }, '▶');
    this.slider = el('input', { type: 'range', min: 0, max: 1, step: 'any', value: 0, 'aria-label': 'time', class: 'time',
      oninput: () => { clock.play(false); clock.set(clock.first + Number(this.slider.value) * (clock.last - clock.first)); } });
    this.readout = el('output', { class: 'readout' });
    const marks = el('div', { class: 'marks' }, this.entries.map((entry) => {
      const mark = el('button', { class: `mark ${entry.kind}`, tabindex: -1, title: `${digits(entry.t, 8)} s  ${entry.name} ${entry.subject}`,
        onclick: () => this.jump(entry.t) });
      mark.style.left = `${100 * this.share(entry.t)}%`;
      return mark;
    }));
    return el('div', { class: 'player' }, this.button, el('div', { class: 'track' }, marks, this.slider), this.readout,
      select('speed', SPEEDS.map((speed) => [speed, `${speed} ×`]), 1, (value) => { clock.speed = Number(value); }));
  }

  buildEvents() {
    const two = this.runs.length > 1;
    this.rows = this.entries.map((entry) => el('button', { class: `row ${entry.kind}`, onclick: () => this.jump(entry.t) },
      el('span', { class: 'kind', title: KINDS[entry.kind][1] }, KINDS[entry.kind][0]),
      two ? el('span', { class: `letter ${entry.run.label}` }, entry.run.label) : null,
      el('span', { class: 'when' }, fixed(entry.t, 6)), el('span', { class: 'what' }, entry.name), el('span', { class: 'who' }, entry.subject)));
    return el('div', { class: 'list' }, el('h2', {}, 'Events', el('small', {}, ' s; click to go there')),
      el('div', { class: 'events' }, this.rows.length ? this.rows : el('p', {}, 'none')));
  }

  buildJoints() {
    if (this.runs[0].joints.length === 0) return null;
    this.modes = this.runs.flatMap((run) => run.joints.map((joint) => {
      const mode = el('td', {}), force = el('td', { class: 'number' }), moment = el('td', { class: 'number' });
      return { run, joint, mode, force, moment };
    }));
    const two = this.runs.length > 1;
    return el('div', { class: 'list' }, el('h2', {}, 'Joints', el('small', {}, ' at the time shown')),
      el('div', { class: 'scroll tall' }, el('table', {},
        el('thead', {}, el('tr', {}, ['joint', 'mode', '|F|, N', '|M|, N m'].map((text) => el('th', {}, text)))),
        el('tbody', {}, this.modes.map(({ run, joint, mode, force, moment }) => (
          el('tr', {}, el('td', {}, two ? el('span', { class: `letter ${run.label}` }, run.label) : null, joint.name), mode, force, moment)))))));
  }

  jump(t) {
    this.clock.play(false);
    this.clock.set(t);
  }

  update(t) {
    this.slider.value = this.share(t);
    this.button.textContent = this.clock.playing ? '❚❚' : '▶';
    this.readout.textContent = `${fixed(t, this.places)} s`;
    const near = SAME_TIME * (this.clock.last - this.clock.first);
    this.rows.forEach((row, i) => row.classList.toggle('past', this.entries[i].t <= t + near));
    for (const { run, joint, mode, force, moment } of this.modes ?? []) {
      const place = run.find(t);
      const lambda = ROWS.map((_, row) => run.at(joint.column + 1 + row, place));
      const current = run.mode(joint, place);
      mode.textContent = current.name;
      mode.classList.toggle('free', current.rows === 0);
      force.textContent = digits(Math.hypot(...lambda.slice(0, 3)), 4);
      moment.textContent = digits(Math.hypot(...lambda.slice(3)), 4);
    }
  }

  // Space plays; arrows go by sample, with shift by event; Home and End.
  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const inField = event.target.closest?.('select, input:not(.time):not([type=checkbox])');
    if (inField || (event.key === ' ' && event.target.closest?.('button, summary'))) return;
    const { clock } = this;
    const near = SAME_TIME * (clock.last - clock.first);
    const step = (times, direction) => (direction > 0 ? times.find((t) => t > clock.t + near) : times.findLast((t) => t < clock.t - near));
    const actions = {
      ' ': () => clock.play(),
      Home: () => this.jump(clock.first),
      End: () => this.jump(clock.last),
      ArrowRight: () => this.jump(step(event.shiftKey ? this.entries.map((entry) => entry.t) : Array.from(this.runs[0].time), 1) ?? clock.last),
      ArrowLeft: () => this.jump(step(event.shiftKey ? this.entries.map((entry) => entry.t) : Array.from(this.runs[0].time), -1) ?? clock.first),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  }
}
