// What part of a plot is looked at: by wheel, two fingers, Shift and a drag, keys and buttons. Both pictures share what lies along.
//
// All steps are made in what an axis shows: on a logarithmic one a decade stays as wide as a decade.

import { turned } from "./plot.js";

const STEP = 1.3; // of one turn of the wheel, or one press of a key
const PAN = 0.1; // of the width, for one press of a key
export const DESK = "(min-width: 1201px)"; // where the page itself need not be scrolled
const KEYS = { "+": [STEP], "=": [STEP], "-": [1 / STEP] };
const ARROWS = { ArrowLeft: [-PAN, 0], ArrowRight: [PAN, 0], ArrowUp: [0, PAN], ArrowDown: [0, -PAN] };

export class Zoom {
  constructor(plot, redraw) {
    this.plot = plot;
    this.redraw = redraw;
    this.ends = null;
    this.fingers = new Map();
    this.grip = null; // where a mouse holds the picture, to move it
    const { svg } = plot;
    svg.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    svg.addEventListener("pointerdown", (event) => { if (event.pointerType === "touch") this.fingers.set(event.pointerId, this.at(event)); });
    svg.addEventListener("pointerdown", (event) => this.seize(event));
    svg.addEventListener("pointermove", (event) => { this.pinch(event); this.drag(event); });
    for (const name of ["pointerup", "pointercancel", "pointerleave"]) svg.addEventListener(name, (event) => { this.fingers.delete(event.pointerId); this.grip = null; });
    svg.addEventListener("dblclick", () => this.reset());
  }

  get pinching() { return this.fingers.size > 1; }

  // Ends of the axes as they are looked at; those of the whole where nothing was moved.
  limit(spec, along = false) {
    if (!this.ends) return;
    [spec.x.min, spec.x.max] = this.ends.x;
    if (!along) [spec.y.min, spec.y.max] = this.ends.y;
  }

  // Closer by a factor around a place, given as shares of width and height from the lower left.
  by(factor, across = 0.5, up = 0.5) {
    this.change((low, high, share) => {
      const about = low + (high - low) * share;
      return [about + (low - about) / factor, about + (high - about) / factor];
    }, across, up);
  }

  shift(across, up) {
    this.change((low, high, share) => [low + (high - low) * share, high + (high - low) * share], across, up);
  }

  change(moved, across, up) {
    const { spec } = this.plot;
    if (!spec) return;
    const ends = (axis, share) => {
      const { forth, back } = turned(axis);
      return moved(forth(axis.min), forth(axis.max), share).map(back);
    };
    const next = { x: ends(spec.x, across), y: ends(spec.y, up) };
    if (![...next.x, ...next.y].every(Number.isFinite)) return;
    this.ends = next;
    this.redraw();
  }

  reset() {
    if (!this.ends) return;
    this.ends = null;
    this.redraw();
  }

  // Whether a key was one of these.
  key(event) {
    if (event.key in KEYS) this.by(...KEYS[event.key]);
    else if (event.key === "0") this.reset();
    else if (event.altKey && event.key in ARROWS) this.shift(...ARROWS[event.key]);
    else return false;
    return true;
  }

  at(event) {
    return this.plot.share(event);
  }

  wheel(event) {
    // Where a page is longer than the screen its wheel scrolls it, unless Ctrl says otherwise.
    if (!event.ctrlKey && !matchMedia(DESK).matches) return;
    event.preventDefault();
    this.by(event.deltaY < 0 ? STEP : 1 / STEP, ...this.at(event));
  }

  seize(event) {
    if (!event.shiftKey || event.button !== 0 || event.pointerType === "touch") return;
    this.grip = this.at(event);
    this.plot.svg.setPointerCapture(event.pointerId);
  }

  drag(event) {
    if (!this.grip) return;
    const [before, after] = [this.grip, this.at(event)];
    this.shift(before[0] - after[0], before[1] - after[1]);
    this.grip = after;
  }

  pinch(event) {
    if (!this.fingers.has(event.pointerId) || !this.pinching) return;
    const apart = () => {
      const [one, other] = [...this.fingers.values()];
      return { far: Math.hypot(one[0] - other[0], one[1] - other[1]), mid: [(one[0] + other[0]) / 2, (one[1] + other[1]) / 2] };
    };
    const before = apart();
    this.fingers.set(event.pointerId, this.at(event));
    const after = apart();
    if (before.far > 0 && after.far > 0) this.by(after.far / before.far, ...before.mid);
    this.shift(before.mid[0] - after.mid[0], before.mid[1] - after.mid[1]);
  }
}
