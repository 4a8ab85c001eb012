// Where a model fails: the points that a sentence about it is of.

const NEAR = 0.006; // share by which a value may differ that is told with three digits

// What "at 40 degC and above" or "at amplitudes of 0.1 to 0.4 mm" says of the level of a point.
function levels(condition) {
  return [...condition.matchAll(/\bat (an amplitude of |amplitudes of )?(-?[\d.e+-]+)(?: to (-?[\d.e+-]+))?[^,]*?(and below|and above)?(?:,|$)/g)]
    .map(([, amplitude, first, second = first, open]) => {
      const [low, high] = [Number(first), Number(second)];
      const slack = NEAR * Math.max(Math.abs(low), Math.abs(high));
      return {
        column: amplitude ? "amplitude" : "temperature",
        low: open === "and below" ? -Infinity : low - slack,
        high: open === "and above" ? Infinity : high + slack,
      };
    });
}

// A place with the rows that it is about, and the part of them, where it is of storage or of loss alone.
export function spotOf(place, scene) {
  const part = scene.views ? undefined : /^(storage|loss)\b/.exec(place.says)?.[1];
  return { place, part, rows: new Set(scene.rows.filter(within(place, scene))) };
}

function within(place, scene) {
  if (scene.views) {
    return (row, i) => place.plane === "signal" && scene.sweeps[scene.sweep[i]].label === place.condition && scene.x[i] >= place.from && scene.x[i] <= place.to;
  }
  if (!(place.from <= place.to)) return () => false;
  const [from, to] = [place.from, place.to].map((hertz) => hertz * 2 * Math.PI);
  const held = levels(place.condition).filter(({ column }) => scene.conditions?.[column]);
  return (row, i) => scene.omega[i] >= from * 0.999 && scene.omega[i] <= to * 1.001
    && held.every(({ column, low, high }) => scene.conditions[column][i] >= low && scene.conditions[column][i] <= high);
}

// Which of a picture's points light up; where it shows storage and loss as one, both do.
export function lights(spot, spec) {
  if (!spot) return () => false;
  const of = (point) => point.part ?? point.kind;
  const parted = spec.points.some((point) => of(point) === spot.part);
  return (point) => spot.rows.has(point.row) && (!parted || of(point) === spot.part);
}
