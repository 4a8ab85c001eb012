// What a measured point says, and how a pointer, a finger or the keys reach it.

import { FINGER } from "./dom.js";
import { number } from "./numbers.js";

const REACH = 24; // px within which a finger means a point
const HELD = 500; // ms after which it has stayed

// What a hand can do with the picture.
export function hint(fixed) {
  const [read, out, move] = FINGER.matches ? ["Tap a point to read it", "hold to leave it out", "pinch to come closer"]
    : ["Point to read", "click to leave out", "Shift and drag to move"];
  return `${fixed ? read : `${read}, ${out}, drag for several`}; ${move}.`;
}

// The i-th row and what is left of it, in a view.
export function said(app, i, viewed) {
  const { scene, answer } = app;
  if (scene.views) return saidInTime(app, i, viewed);
  const { stiffness } = scene.units;
  const { clock, per_hertz, symbol } = scene.words;
  let says = `${number((scene.omega[i] / 2 / Math.PI) * per_hertz, 3)} ${clock}: ${symbol}' ${number(scene.storage[i])}, ${symbol}'' ${number(scene.loss[i])} ${stiffness}`;
  if (answer) {
    const [storage, loss] = [answer.model.points.storage[i], answer.model.points.loss[i]];
    const off = (data, model, sd) => `${data >= model ? "+" : "−"}${number(Math.abs(data - model) / sd, 2)} σ`;
    says += `; model ${number(storage)}, ${number(loss)}; data − model ${off(scene.storage[i], storage, answer.noise.storage[i])}, `;
    says += off(scene.loss[i], loss, answer.noise.loss[i]);
  }
  return says;
}

function saidInTime({ scene, answer }, i, viewed) {
  const { x, y } = scene.views[viewed];
  const [name, unit] = y.label.split(" [");
  let says = `${x.label.replace(/ \[.*/, "")} ${number(x.column === "moved" ? scene.moved[i] : scene.x[i])}: ${name} ${number(scene.storage[i])} ${unit.slice(0, -1)}`;
  if (answer) {
    const model = answer.model.points.storage[i];
    const off = (scene.storage[i] - model) / answer.noise.storage[i];
    says += `; model ${number(model)}; data − model ${off < 0 ? "−" : "+"}${number(Math.abs(off), 2)} σ`;
  }
  return says;
}

// A pointer reads the points of a plot and chooses them, a finger that stays leaves one out, and keys do both.
export function listen(plot, picture) {
  const place = (event) => {
    const box = plot.svg.getBoundingClientRect();
    return [((event.clientX - box.left) / box.width) * plot.width, ((event.clientY - box.top) / box.height) * plot.height];
  };
  let from = null;
  let held = null; // a finger reads a point at once, and leaves it out when it stays
  const release = () => { clearTimeout(held); held = null; };
  plot.svg.addEventListener("pointermove", (event) => {
    if (!plot.spec) return;
    const to = place(event);
    if (!from || Math.hypot(to[0] - from[0], to[1] - from[1]) > 6) release();
    if (from && Math.hypot(to[0] - from[0], to[1] - from[1]) > 6) {
      picture.selected(new Set(plot.rowsWithin(...from, ...to)));
    } else if (!from) picture.point(plot.nearest(...to));
  });
  plot.svg.addEventListener("pointerdown", (event) => {
    release();
    // A second finger pinches, and Shift moves the picture: neither chooses.
    from = event.button === 0 && event.isPrimary && !picture.zoom.grip ? place(event) : null;
    if (event.pointerType !== "touch" || !from || !plot.spec) return;
    const row = plot.nearest(...from, REACH);
    held = setTimeout(() => { from = null; if (row !== null) picture.toggle([row]); }, HELD);
  });
  plot.svg.addEventListener("pointerup", (event) => {
    const to = place(event);
    if (from && Math.hypot(to[0] - from[0], to[1] - from[1]) <= 6 && plot.spec) {
      const touch = event.pointerType === "touch";
      const row = plot.nearest(...to, touch ? REACH : 10);
      if (touch) picture.point(row);
      else if (row !== null) picture.toggle([row]);
      else picture.selected(new Set());
    }
    from = null;
    release();
  });
  plot.svg.addEventListener("pointerleave", (event) => { if (!from && event.pointerType !== "touch") picture.point(null); });
  plot.svg.addEventListener("pointercancel", () => { from = null; release(); });
  plot.svg.addEventListener("keydown", (event) => key(event, picture));
}

function key(event, picture) {
  if (picture.zoom.key(event)) {
    event.preventDefault();
    return;
  }
  const rows = [...picture.app.scene.rows].sort((a, b) => picture.app.scene.x[picture.index(a)] - picture.app.scene.x[picture.index(b)]);
  const here = rows.indexOf(picture.row);
  const steps = { ArrowRight: 1, ArrowLeft: -1 };
  if (event.key in steps) {
    const next = rows[Math.max(0, Math.min(rows.length - 1, here + steps[event.key]))];
    if (event.shiftKey) picture.selected(new Set([...picture.chosen, picture.row ?? next, next]));
    picture.point(next);
  } else if (event.key === " " && (picture.chosen.size || picture.row !== null)) {
    picture.toggle(picture.chosen.size ? [...picture.chosen] : [picture.row]);
  } else if (event.key === "Escape") picture.selected(new Set());
  else return;
  event.preventDefault();
}
