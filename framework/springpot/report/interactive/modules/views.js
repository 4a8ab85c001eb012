// What each view shows of K: the usual ones of rheology, and the planes in which a missing effect is simplest.
//
// K is held as { storage: [...], loss: [...] }, in the unit of the data, at the rows or along the curves of the scene.

import { range } from "./plot.js";

const degrees = (storage, loss) => (Math.atan2(loss, storage) * 180) / Math.PI;

// Complex arithmetic on pairs.
const minus = ([a, b], [c, d]) => [a - c, b - d];
const over = ([a, b], [c, d]) => {
  const size = c * c + d * d;
  return [(a * c + b * d) / size, (b * c - a * d) / size];
};
const ln = ([a, b]) => [Math.log(Math.hypot(a, b)), Math.atan2(b, a)];

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

export const PLANES = {
  stiffness: {
    name: "Stiffness plane",
    says: "simple here: what is missing in parallel, such as a mass or friction",
    label: (units) => `ΔK [${units.stiffness}]`,
    of: (data, model) => minus(data, model),
    width: (sd) => sd,
  },
  compliance: {
    name: "Compliance plane",
    says: "simple here: what is missing in series, such as a soft mounting",
    label: (units) => `Δ(1/K) [1/(${units.stiffness})]`,
    of: (data, model) => minus(over([1, 0], data), over([1, 0], model)),
    width: (sd, data) => sd / (data[0] ** 2 + data[1] ** 2),
  },
  "log-complex": {
    name: "Log-complex plane",
    says: "simple here: what is missing in the signal chain, such as a delay",
    label: () => "Δ ln K [-, rad]",
    of: (data, model) => ln(over(data, model)),
    width: (sd, data) => sd / Math.hypot(...data),
  },
  shift: {
    name: "Shift plane",
    says: "simple here: what is missing in the frequency scale, such as a temperature",
    label: () => "Δ ln ω [-]",
    of: (data, model, slope) => over(minus(data, model), slope),
    width: (sd, data, slope) => sd / Math.hypot(...slope),
    needsSlope: true,
  },
};

const at = (k, i) => [k.storage[i], k.loss[i]];

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

// Residuals of the model in a plane: real part filled, imaginary part open, with bands of one and three sigma.
export function planeSpec(name, scene, excluded, answer) {
  const plane = PLANES[name];
  const points = [];
  const widths = [];
  scene.rows.forEach((row, i) => {
    const slope = answer.model.slope ? at(answer.model.slope, i) : [1, 0];
    const residual = plane.of(at(scene, i), at(answer.model.points, i), slope);
    const sd = Math.max(answer.noise.storage[i], answer.noise.loss[i]);
    widths.push({ x: scene.x[i], w: plane.width(sd, at(scene, i), slope), sweep: scene.sweep[i] });
    residual.forEach((y, part) => {
      const kind = part ? "loss" : "storage";
      const colour = colourOf(scene, scene.sweep[i], kind);
      points.push({ x: scene.x[i], y, kind, row, colour, out: excluded.has(row) });
    });
  });
  const x = along(scene)("x");
  [x.min, x.max] = range(scene.x, x.log, 0.03);
  const used = points.filter((point) => !point.out).map((point) => point.y);
  const widest = widths.map(({ w }) => 3 * w).sort((a, b) => a - b)[Math.floor(widths.length / 2)] || 0;
  const most = 1.12 * Math.max(widest, ...used.map(Math.abs).filter(Number.isFinite), 1e-300);
  const y = { label: plane.label(scene.units), log: false, min: -most, max: most };
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

// What a candidate would leave of the residual, as lines through the points of each sweep.
export function planeLines(name, scene, k) {
  const plane = PLANES[name];
  if (plane.needsSlope) return [];
  const lines = scene.sweeps.flatMap(() => ["storage", "loss"].map((kind) => ({ xs: [], ys: [], kind: `residual ${kind}`, colour: "var(--preview)" })));
  scene.rows.forEach((row, i) => {
    if (k.points.storage[i] === null || k.points.loss[i] === null) return;
    plane.of(at(scene, i), at(k.points, i)).forEach((y, part) => {
      const line = lines[2 * scene.sweep[i] + part];
      line.xs.push(scene.x[i]);
      line.ys.push(y);
    });
  });
  return lines;
}

const PLAIN = { view: "storage-loss", plane: "stiffness", plan: 0 };

// What is looked at, as a session or an earlier page left it: what is not known here, perhaps of a later version, is
// as at the beginning.
export function looksOf(given = {}) {
  const view = given.view in VIEWS || given.view === "master-curve" ? given.view : PLAIN.view;
  const plane = given.plane in PLANES || given.plane === "none" ? given.plane : PLAIN.plane;
  return { view, plane, plan: given.plan ? 1 : 0 };
}
