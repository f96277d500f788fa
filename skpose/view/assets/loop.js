// The part of the time that is played again and again, between two marks on the slider of time.

class Loop {
  from = 0; // ticks, both in it
  to = 0;

  constructor(clock, changed) {
    Object.assign(this, { clock, changed });
    this.clear();
    for (const end of ["from", "to"]) {
      element(end).addEventListener("input", () => (this.set(end, Number(element(end).value)), changed()));
    }
  }

  get isWhole() {
    return this.from === 0 && this.to === this.clock.count - 1;
  }

  /** Put a mark at a tick; one that would come before the other takes it along. */
  set(end, tick) {
    this[end] = Math.max(0, Math.min(this.clock.count - 1, Math.round(tick)));
    if (end === "from") this.to = Math.max(this.from, this.to);
    else this.from = Math.min(this.from, this.to);
    this.show();
  }

  clear() {
    Object.assign(this, { from: 0, to: this.clock.count - 1 });
    this.show();
  }

  /** What comes after the end is at the start; what plays from elsewhere begins at the start. */
  wrap(position) {
    const end = this.to + 1; // the last frame is as long as the others
    if (position >= this.from && position < end) return position;
    return this.from + (position >= end && position < end + 1 ? (position - end) % (end - this.from) : 0);
  }

  show() {
    const last = this.clock.count - 1;
    for (const end of ["from", "to"]) {
      const mark = Object.assign(element(end), { max: last, disabled: last < 1 });
      mark.value = this[end];
      mark.setAttribute("aria-valuetext", `${(this[end] * this.clock.seconds).toFixed(2)} seconds after the start`);
      element("times").style.setProperty(`--${end}`, this[end] / Math.max(last, 1));
    }
    element("times").classList.toggle("whole", this.isWhole);
  }
}
