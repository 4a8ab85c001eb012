// The sweeps laid over one another by their factors, against reduced frequency.

import { withInterval } from "./numbers.js";
import { range } from "./plot.js";

export function masterSpec(scene, master, excluded) {
  const factors = new Map(master.curve.levels.map((level) => [level.value, level]));
  const points = scene.rows.flatMap((row, i) => {
    const here = scene.conditions[master.column][i];
    const nearest = [...factors.keys()].reduce((a, b) => (Math.abs(b - here) < Math.abs(a - here) ? b : a));
    const { a, b = 1 } = factors.get(nearest);
    const colour = `var(--sweep-${Math.round((8 * scene.sweep[i]) / Math.max(1, scene.sweeps.length - 1))})`;
    const x = (scene.omega[i] / 2 / Math.PI) * scene.words.per_hertz * a;
    const out = excluded.includes(row);
    return [{ x, y: scene.storage[i] / b, kind: "storage", row, colour, out, sweep: scene.sweep[i] }, { x, y: scene.loss[i] / b, kind: "loss", row, colour, out, sweep: scene.sweep[i] }];
  });
  const { symbol, clock } = scene.words;
  const x = { label: `reduced frequency a ${clock === "Hz" ? "f" : "ω"} [${clock}]`, log: true };
  const y = { label: `${symbol}'/b, ${symbol}''/b [${scene.units.stiffness}]`, log: true };
  [x.min, x.max] = range(points.map((point) => point.x), true, 0.03);
  [y.min, y.max] = range(points.map((point) => point.y), true, 0.1);
  return { x, y, points, lines: [], upright: true, told: factorsOf(master) };
}

const plain = (value) => Number(value.toPrecision(4));

// The factor of each level in words; what the sweeps do not tell is said so.
function factorsOf({ column, curve }) {
  const unit = column === "temperature" ? "°C" : curve.unit;
  const factor = ({ value, a, a_low: low, a_high: high, determined }) => {
    const [told, interval] = withInterval(a, low, high);
    return `${plain(value)} ${unit}: a = ${told} ${interval}${determined ? "" : ", not determined"}`;
  };
  return [`Shift factors to ${plain(curve.reference)} ${unit}, with 95 % intervals:`, ...curve.levels.map(factor)];
}
