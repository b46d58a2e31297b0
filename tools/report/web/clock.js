// The time that everything on the page shows, and the player that moves it.
export class Clock {
  constructor(first, last) {
    Object.assign(this, { first, last, t: first, speed: 1, playing: false });
    this.listeners = [];
  }

  listen(listener) { this.listeners.push(listener); }

  set(t) {
    this.t = Math.min(Math.max(t, this.first), this.last);
    for (const listener of this.listeners) listener(this.t);
  }

  play(wanted = !this.playing) {
    if (wanted === this.playing) return;
    this.playing = wanted;
    if (wanted && this.t >= this.last) this.set(this.first);
    let before = null;
    const frame = (now) => {
      if (!this.playing) return;
      const t = this.t + (before === null ? 0 : (now - before) * 1e-3 * this.speed);
      before = now;
      if (t >= this.last) this.playing = false;
      this.set(t);
      if (this.playing) requestAnimationFrame(frame);
    };
    if (wanted) requestAnimationFrame(frame);
    this.set(this.t);
  }
}
