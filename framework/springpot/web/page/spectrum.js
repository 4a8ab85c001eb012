// The spectrum of any material: how much of its stiffness relaxes at which rate, as smooth as the data allow.

import { range } from "./plot.js";

const DECADES = 4; // below the peak that are shown
const KEY = [["model", "━ smoothest H that the data allow"], ["of-noise", "▒ 95 % of noise"], ["unmeasured", "▒ not measured"]];

export function spectrumSpec({ rates, density, low, high, seen, unit, says }) {
  const top = Math.max(...high);
  const floor = top / 10 ** DECADES;
  const least = (values) => values.map((value) => Math.max(value, floor / 10));
  const x = { label: "rate r [rad/s]", log: true };
  const y = { label: `H(r) [${unit}]`, log: true, canBeLog: false };
  [x.min, x.max] = [rates[0], rates.at(-1)];
  [y.min, y.max] = range([...density, ...low, ...high].filter((value) => value > floor), true, 0.05);
  const beside = ([from, to]) => ({ xs: [from, to], low: [y.min, y.min], high: [y.max, y.max], kind: "unmeasured" });
  const bands = [beside([x.min, seen[0]]), beside([seen[1], x.max]), { xs: rates, low: least(low), high: least(high), kind: "of-noise" }];
  const lines = [{ xs: rates, ys: least(density), kind: "model storage", colour: "var(--storage)" }];
  return { x, y, points: [], bands, lines, upright: true, key: KEY, told: [says], says };
}
