// What each view shows of K, the usual ones of rheology, and the residuals in the planes that the server tells.
//
// K is held as { storage: [...], loss: [...] }, in the unit of the data, at the rows or along the curves of the scene.

import { range, turned } from "./plot.js";

const SMALL = 0.1; // share of the sizes below which an axis that is bent around zero is linear
const FAR = 12; // standard deviations beyond which residuals are drawn on such an axis
const ROOM = 1.15; // of a residual's axis beyond its largest point
const NOISE = 3; // standard deviations up to which it is linear

const degrees = (storage, loss) => (Math.atan2(loss, storage) * 180) / Math.PI;

const along = (scene) => ({ label: scene.axis.label, log: scene.axis.logarithmic });
const upright = { upright: true, x: along };

export const VIEWS = {
  "storage-loss": {
    name: "Storage and loss",
    ...upright,
    y: (scene) => ({ label: `${scene.words.symbol}' and ${scene.words.symbol}'' [${scene.units.stiffness}]`, log: true }),
    parts: [
      { kind: "storage", at: (x, storage) => [x, storage] },
      { kind: "loss", at: (x, storage, loss) => [x, loss] },
    ],
  },
  phase: {
    name: "Phase",
    ...upright,
    y: () => ({ label: "phase δ [°]", log: false }),
    parts: [{ kind: "storage", at: (x, storage, loss) => [x, degrees(storage, loss)] }],
  },
  "cole-cole": {
    name: "Cole-Cole",
    x: (scene) => ({ label: `${scene.words.symbol}' [${scene.units.stiffness}]`, log: false }),
    y: (scene) => ({ label: `${scene.words.symbol}'' [${scene.units.stiffness}]`, log: false }),
    parts: [{ kind: "storage", at: (x, storage, loss) => [storage, loss] }],
  },
  "van-gurp-palmen": {
    name: "van Gurp-Palmen",
    x: (scene) => ({ label: `${scene.words.magnitude} [${scene.units.stiffness}]`, log: true }),
    y: () => ({ label: "phase δ [°]", log: false }),
    parts: [{ kind: "storage", at: (x, storage, loss) => [Math.hypot(storage, loss), degrees(storage, loss)] }],
  },
};

// The views of these data: those that the server tells, of columns against each other, or the usual ones of rheology.
export function viewsOf(scene) {
  if (!scene.views) return VIEWS;
  scene.made ||= Object.fromEntries(Object.entries(scene.views).map(([id, view]) => [id, told(view)]));
  return scene.made;
}

// A view of one of several tests; what is not of it is not drawn.
function told({ name, x, y, parts, test, along: axis, residual }) {
  const place = x.column === "moved" ? (at, moved) => moved : (at) => at;
  return { name, test, residual, along: axis, upright: x.column === "x", x: () => ({ label: x.label, log: x.log }), y: () => ({ label: y.label, log: y.log }),
    parts: parts.map((kind) => ({ kind, at: (at, storage, loss, moved) => [place(at, moved), kind === "loss" ? loss : storage] })) };
}

const shows = ({ test }, sweep) => test === undefined || test === sweep;

// The view to show: the one that is asked for, if these data have it, else their first.
export const viewOf = (scene, name) => (name in viewsOf(scene) ? name : Object.keys(viewsOf(scene))[0]);

// Colour of a sweep, dark to light on white and the reverse on black; storage and loss where there is one sweep.
export function colourOf(scene, sweep, kind) {
  const count = scene.sweeps.length;
  if (count < 2) return `var(--${kind})`;
  return `var(--sweep-${Math.round((8 * sweep) / (count - 1))})`;
}

// What residuals can be drawn along besides the axis of the data: the order in which these stand, or a column of theirs.
export function othersOf(scene) {
  if (scene.views) return [];
  return [["row", "row of the file"], ...Object.keys(scene.conditions || {}).filter((name) => name !== scene.axis.column).map((name) => [name, name])];
}

function placedAlong(scene, view, column) {
  const [, label] = othersOf(scene).find(([name]) => name === column) || [];
  if (!label) return { axis: view.along ? { label: view.along.label, log: view.along.log } : along(scene), places: scene.x };
  const places = column === "row" ? scene.rows.map((row) => row + 1) : scene.conditions[column];
  return { axis: { label, log: false }, places };
}

// Points of the data and lines of the model in one view.
export function viewSpec(name, scene, excluded, model, plain = "") {
  const view = viewsOf(scene)[name];
  const points = [];
  scene.rows.forEach((row, i) => {
    if (!shows(view, scene.sweep[i])) return;
    for (const { kind, at: place } of view.parts) {
      const [x, y] = place(scene.x[i], scene.storage[i], scene.loss[i], scene.moved?.[i]);
      const colour = colourOf(scene, scene.sweep[i], kind);
      points.push({ x, y, kind, row, colour, sweep: scene.sweep[i], out: excluded.has(row) });
    }
  });
  const cloud = cloudOf(scene, view);
  const lines = model ? viewLines(name, scene, model, "model") : [];
  const [x, y] = [view.x(scene), view.y(scene)];
  bounded(x, points.map((point) => point.x), view.upright ? 0.03 : 0.06, plain.includes("x"));
  bounded(y, points.map((point) => point.y), 0.12, plain.includes("y"));
  return { x, y, points, cloud, lines, upright: Boolean(view.upright), says: `${points.length} points` };
}

// Points that are drawn and cannot be pointed at, of data that have very many.
function cloudOf(scene, view) {
  const { x = [], storage, loss, sweep } = scene.cloud || {};
  return x.flatMap((along, i) => view.parts.map(({ kind, at: place }) => {
    const [across, up] = place(along, storage[i], loss[i]);
    return { x: across, y: up, kind, colour: colourOf(scene, sweep[i], kind), sweep: sweep[i] };
  }));
}

// The ends of an axis. A logarithmic one on which something is zero or negative is bent around zero: nothing measured is
// out of sight. `plain`: linear on request.
function bounded(axis, values, room, plain) {
  axis.canBeLog = axis.log;
  axis.log &&= !plain;
  const below = values.filter((value) => value <= 0).length;
  if (axis.log && below) {
    const sizes = values.map(Math.abs).filter((size) => size > 0).sort((a, b) => a - b);
    axis.bend = sizes[Math.floor(sizes.length * SMALL)] || 1;
    axis.log = false;
    axis.below = below;
  }
  const { forth, back } = turned(axis);
  const [low, high] = axis.bend ? range(values.map(forth), false, room).map(back) : range(values, axis.log, room);
  Object.assign(axis, { min: low, max: high });
}

export function viewLines(name, scene, k, role) {
  const view = viewsOf(scene)[name];
  return scene.grids.flatMap((grid, sweep) => (!shows(view, sweep) ? [] :
    view.parts.map(({ kind, at: place }) => {
      const curve = k.curves[sweep];
      const pairs = grid.x.map((x, i) => place(x, curve.storage[i], curve.loss[i], grid.moved?.[i]));
      return {
        xs: pairs.map((pair) => pair[0]),
        ys: pairs.map((pair) => pair[1]),
        kind: `${role} ${kind}`,
        part: kind,
        sweep,
        colour: role === "model" ? colourOf(scene, sweep, kind) : `var(--${role})`,
      };
    })));
}

// Data less model in a plane, as the server tells it: real part filled, imaginary part open, with bands of one and three
// standard deviations. `sigmas`: in units of these, between ends that the first rung fixes, so that what falls is seen to
// fall; `before`: the answer of the rung before, whose residual stays as a shadow.
export function planeSpec(name, scene, excluded, answer, view, { sigmas = false, first = answer, before = null, column = "" } = {}) {
  const { axis: x, places } = placedAlong(scene, view, column);
  const pointsOf = (...what) => residuals(scene, view, places, excluded, ...what);
  const residual = measuredBy(answer.model.planes[name], sigmas);
  const points = before ? pointsOf(measuredBy(before.model.planes[name], sigmas), "ghost") : [];
  points.push(...pointsOf(residual));
  const widths = residual.width.map((w, i) => ({ x: places[i], w: w ?? 0, sweep: scene.sweep[i] })).filter(({ sweep }) => shows(view, sweep));
  [x.min, x.max] = range(widths.map((one) => one.x), x.log, 0.03);
  const widest = widths.map(({ w }) => 3 * w).sort((a, b) => a - b)[Math.floor(widths.length / 2)] || 0;
  const fixed = sigmas ? pointsOf(measuredBy(first.model.planes[name], true)) : points;
  const used = fixed.filter((point) => !point.out).map((point) => Math.abs(point.y)).filter(Number.isFinite);
  const most = Math.max(widest, ...used, 1e-300);
  const label = view.residual || scene.planes[name].label;
  const y = { label: sigmas ? `${label.split(" [")[0]} / σ` : label, log: false };
  if (sigmas && most > FAR) y.bend = NOISE;
  const { forth, back } = turned(y);
  y.max = back(ROOM * forth(most));
  y.min = -y.max;
  const here = scene.views ? ({ plane, condition }) => plane === name && condition === scene.sweeps[view.test].label : () => scene.axis.column === "frequency";
  const shades = answer.discovery.diagnosis.where
    .filter((place) => places === scene.x && here(place) && place.from <= place.to)
    .slice(0, 3)
    .map((place) => ({ from: place.from * scene.axis.per_hertz, to: place.to * scene.axis.per_hertz, says: place.says, place }));
  const bands = [3, 1].map((times) => band(widths, times));
  return { x, y, points, bands, shades, lines: [{ xs: [x.min, x.max], ys: [0, 0], kind: "zero" }], upright: true };
}

// A residual as it is, or each part of it over its standard deviation.
function measuredBy({ storage, loss, width }, sigmas) {
  if (!sigmas) return { storage, loss, width };
  const over = (values) => values.map((value, i) => (value === null || !width[i] ? null : value / width[i]));
  return { storage: over(storage), loss: over(loss), width: width.map(() => 1) };
}

function residuals(scene, view, places, excluded, residual, shadow = "") {
  return scene.rows.flatMap((row, i) => (!shows(view, scene.sweep[i]) ? [] : ["storage", "loss"]).map((kind) => ({
    x: places[i], y: residual[kind][i] ?? NaN, kind: shadow ? `${kind} ${shadow}` : kind, part: kind,
    row: shadow ? null : row, colour: colourOf(scene, scene.sweep[i], kind), sweep: scene.sweep[i], out: !shadow && excluded.has(row),
  })));
}

// One sweep has a band that follows its noise; of several, that of the typical point.
function band(widths, sigmas) {
  const kind = `sigma-${sigmas}`;
  const sorted = [...widths].sort((a, b) => a.x - b.x);
  const several = new Set(widths.map((one) => one.sweep)).size > 1;
  const typical = [...widths].map((one) => one.w).sort((a, b) => a - b)[Math.floor(widths.length / 2)];
  const high = sorted.map((one) => sigmas * (several ? typical : one.w));
  return { kind, xs: sorted.map((one) => one.x), high, low: high.map((value) => -value) };
}

// What a candidate would leave of the residual, as lines through points of each sweep; over `widths` where those are given.
export function planeLines(name, scene, k, view, { widths = null, role = "preview", column = "" } = {}) {
  const { places } = placedAlong(scene, view, column);
  const lines = scene.sweeps.flatMap(() => ["storage", "loss"].map((kind) => ({ xs: [], ys: [], kind: `residual ${role} ${kind}`, colour: `var(--${role})` })));
  scene.thin.forEach((i, at) => {
    const both = [k.planes[name].storage[at], k.planes[name].loss[at]];
    if (!shows(view, scene.sweep[i])) return;
    both.forEach((y, part) => {
      if (y === null) return;
      const line = lines[2 * scene.sweep[i] + part];
      line.xs.push(places[i]);
      line.ys.push(widths ? y / widths[i] : y);
    });
  });
  return lines.filter((line) => line.xs.length);
}

const PLAIN = { view: "storage-loss", plane: "", plan: 0, sigmas: 1, linear: "", column: "", second: "" };

// What is looked at, as a session or an earlier page left it: what is not known here, perhaps of a later version, is
// as at the beginning. Which views and planes there are the data say.
export function looksOf(given = {}) {
  const view = typeof given.view === "string" ? given.view : PLAIN.view;
  const plane = typeof given.plane === "string" ? given.plane : PLAIN.plane;
  const linear = ["x", "y", "xy"].includes(given.linear) ? given.linear : PLAIN.linear;
  const sigmas = given.sigmas === undefined ? PLAIN.sigmas : Number(Boolean(given.sigmas));
  const column = typeof given.column === "string" ? given.column : PLAIN.column;
  const second = typeof given.second === "string" ? given.second : PLAIN.second;
  return { view, plane, plan: given.plan ? 1 : 0, sigmas, linear, column, second };
}

// The plane to show: the one that is asked for, if there is such a one, else the first.
export function planeOf(scene, name) {
  return name in scene.planes || name === "none" ? name : Object.keys(scene.planes)[0];
}
