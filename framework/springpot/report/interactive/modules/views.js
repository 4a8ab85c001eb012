// What each view shows of K, the usual ones of rheology, and the residuals in the planes that the server tells.
//
// K is held as { storage: [...], loss: [...] }, in the unit of the data, at the rows or along the curves of the scene.

import { range } from "./plot.js";

const degrees = (storage, loss) => (Math.atan2(loss, storage) * 180) / Math.PI;

const along = (scene) => (label) => ({ label: scene.axis.label, log: scene.axis.logarithmic, of: label });
const upright = { upright: true, x: (scene) => along(scene)("x") };

export const VIEWS = {
  "storage-loss": {
    name: "Storage and loss",
    ...upright,
    y: (scene) => ({ label: `K' and K'' [${scene.units.stiffness}]`, log: true }),
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
    x: (scene) => ({ label: `K' [${scene.units.stiffness}]`, log: false }),
    y: (scene) => ({ label: `K'' [${scene.units.stiffness}]`, log: false }),
    parts: [{ kind: "storage", at: (x, storage, loss) => [storage, loss] }],
  },
  "van-gurp-palmen": {
    name: "van Gurp-Palmen",
    x: (scene) => ({ label: `|K| [${scene.units.stiffness}]`, log: true }),
    y: () => ({ label: "phase δ [°]", log: false }),
    parts: [{ kind: "storage", at: (x, storage, loss) => [Math.hypot(storage, loss), degrees(storage, loss)] }],
  },
};

// Colour of a sweep, dark to light on white and the reverse on black; storage and loss where there is one sweep.
export function colourOf(scene, sweep, kind) {
  const count = scene.sweeps.length;
  if (count < 2) return `var(--${kind})`;
  return `var(--sweep-${Math.round((8 * sweep) / (count - 1))})`;
}

// Points of the data and lines of the model in one view.
export function viewSpec(name, scene, excluded, model) {
  const view = VIEWS[name];
  const points = [];
  scene.rows.forEach((row, i) => {
    for (const { kind, at: place } of view.parts) {
      const [x, y] = place(scene.x[i], scene.storage[i], scene.loss[i]);
      const colour = colourOf(scene, scene.sweep[i], kind);
      points.push({ x, y, kind, row, colour, out: excluded.has(row) });
    }
  });
  const lines = model ? viewLines(name, scene, model, "model") : [];
  const [x, y] = [view.x(scene), view.y(scene)];
  [x.min, x.max] = range(points.map((point) => point.x), x.log, view.upright ? 0.03 : 0.06);
  [y.min, y.max] = range(points.map((point) => point.y), y.log, 0.12);
  return { x, y, points, lines, upright: Boolean(view.upright), says: `${points.length} points` };
}

export function viewLines(name, scene, k, role) {
  const view = VIEWS[name];
  return scene.grids.flatMap((grid, sweep) =>
    view.parts.map(({ kind, at: place }) => {
      const curve = k.curves[sweep];
      const pairs = grid.x.map((x, i) => place(x, curve.storage[i], curve.loss[i]));
      return {
        xs: pairs.map((pair) => pair[0]),
        ys: pairs.map((pair) => pair[1]),
        kind: `${role} ${kind}`,
        colour: role === "model" ? colourOf(scene, sweep, kind) : `var(--${role})`,
      };
    }));
}

// Residuals of the model in a plane, as the server tells them: real part filled, imaginary part open, with bands of
// one and three sigma.
export function planeSpec(name, scene, excluded, answer) {
  const residual = answer.model.planes[name];
  const points = [];
  scene.rows.forEach((row, i) => {
    for (const kind of ["storage", "loss"]) {
      const colour = colourOf(scene, scene.sweep[i], kind);
      points.push({ x: scene.x[i], y: residual[kind][i] ?? NaN, kind, row, colour, out: excluded.has(row) });
    }
  });
  const widths = residual.width.map((w, i) => ({ x: scene.x[i], w: w ?? 0, sweep: scene.sweep[i] }));
  const x = along(scene)("x");
  [x.min, x.max] = range(scene.x, x.log, 0.03);
  const used = points.filter((point) => !point.out).map((point) => point.y);
  const widest = widths.map(({ w }) => 3 * w).sort((a, b) => a - b)[Math.floor(widths.length / 2)] || 0;
  const most = 1.12 * Math.max(widest, ...used.map(Math.abs).filter(Number.isFinite), 1e-300);
  const y = { label: scene.planes[name].label, log: false, min: -most, max: most };
  const shades = answer.discovery.diagnosis.where
    .filter((place) => scene.axis.column === "frequency" && place.from <= place.to)
    .slice(0, 3)
    .map((place) => ({ from: place.from * scene.axis.per_hertz, to: place.to * scene.axis.per_hertz, says: place.says }));
  const bands = [3, 1].map((sigmas) => band(widths, sigmas));
  return { x, y, points, bands, shades, lines: [{ xs: [x.min, x.max], ys: [0, 0], kind: "zero" }], upright: true };
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

// What a candidate would leave of the residual, as lines through points of each sweep.
export function planeLines(name, scene, k) {
  const lines = scene.sweeps.flatMap(() => ["storage", "loss"].map((kind) => ({ xs: [], ys: [], kind: `residual ${kind}`, colour: "var(--preview)" })));
  scene.thin.forEach((i, at) => {
    const both = [k.planes[name].storage[at], k.planes[name].loss[at]];
    if (both.includes(null)) return;
    both.forEach((y, part) => {
      const line = lines[2 * scene.sweep[i] + part];
      line.xs.push(scene.x[i]);
      line.ys.push(y);
    });
  });
  return lines;
}

const PLAIN = { view: "storage-loss", plane: "", plan: 0 };

// What is looked at, as a session or an earlier page left it: what is not known here, perhaps of a later version, is
// as at the beginning. Which planes there are the data say.
export function looksOf(given = {}) {
  const view = given.view in VIEWS || given.view === "master-curve" ? given.view : PLAIN.view;
  const plane = typeof given.plane === "string" ? given.plane : PLAIN.plane;
  return { view, plane, plan: given.plan ? 1 : 0 };
}

// The plane to show: the one that is asked for, if there is such a one, else the first.
export function planeOf(scene, name) {
  return name in scene.planes || name === "none" ? name : Object.keys(scene.planes)[0];
}
