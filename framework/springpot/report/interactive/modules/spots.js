// Where a model fails: the points that a sentence about it is of.

import { capital, pretty } from "./numbers.js";

const NEAR = 1e-5; // share by which a value may differ that is drawn with six digits

// A place with the rows that it is about, and the part of them, where it is of storage or of loss alone.
export function spotOf(place, { part, levels }, scene) {
  return { place, part: part || undefined, rows: new Set(scene.rows.filter(within(place, levels, scene))) };
}

// What lies too high or too low is the model's; of tests in time and of single points whole sentences are said.
// How it changes along frequency and conditions is told after a comma.
export const modelled = ({ place, part }) => pretty(part ? `the model's ${place.says}` : place.says);
export const inBrief = (spot) => (spot.part ? modelled(spot).split(", ")[0] : modelled(spot));

// As a sentence, in which the name of a test keeps its letters.
export function sentence(spot) {
  const [text, name] = [inBrief(spot), spot.place.condition];
  return `${name && text.startsWith(name) ? text : capital(text)}.`;
}

// The sign of data less model there, as in the picture and beside each point.
export const signOf = ({ place, part }) => (part ? `Δ ${place.size < 0 ? "<" : ">"} 0: ` : "");

function within(place, levels, scene) {
  if (scene.views) {
    return (row, i) => place.plane === "signal" && scene.sweeps[scene.sweep[i]].label === place.condition && scene.x[i] >= place.from && scene.x[i] <= place.to;
  }
  if (!(place.from <= place.to)) return () => false;
  const [from, to] = [place.from, place.to].map((hertz) => hertz * 2 * Math.PI);
  const held = Object.entries(levels).filter(([column]) => scene.conditions?.[column]);
  const near = (value, [low, high]) => value >= low - NEAR * Math.abs(low) && value <= high + NEAR * Math.abs(high);
  return (row, i) => scene.omega[i] >= from * 0.999 && scene.omega[i] <= to * 1.001
    && held.every(([column, ends]) => near(scene.conditions[column][i], ends));
}

// Which of a picture's points light up; where it shows storage and loss as one, both do.
export function lights(spot, spec) {
  if (!spot) return () => false;
  const of = (point) => point.part ?? point.kind;
  const parted = spec.points.some((point) => of(point) === spot.part);
  return (point) => spot.rows.has(point.row) && (!parted || of(point) === spot.part);
}
