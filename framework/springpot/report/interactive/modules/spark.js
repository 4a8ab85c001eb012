// What an effect would leave of the residual, small enough for its card: in standard deviations, the band of noise behind it.

import { s } from "./dom.js";
import { planeOf } from "./views.js";

const WIDTH = 84;
const HEIGHT = 26;
const BAND = 3; // standard deviations between which noise stays
const MOST = 30; // of the scale's end, which is compressed towards it: a card shows whether the band is reached

const place = (sigmas) => HEIGHT / 2 - (Math.asinh(sigmas) / Math.asinh(MOST)) * (HEIGHT / 2 - 1);

export function sparkline(scene, answer, effect, wanted) {
  const plane = planeOf(scene, wanted);
  const after = answer.previews[effect]?.planes[plane];
  const svg = s("svg", { class: "spark", width: WIDTH, height: HEIGHT, viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "aria-hidden": "true" });
  if (!after) return svg;
  const { width } = answer.model.planes[plane];
  const [top, bottom] = [place(BAND), place(-BAND)];
  svg.append(s("rect", { class: "band", x: 0, y: top, width: WIDTH, height: bottom - top }));
  scene.thin.forEach((row, at) => {
    const x = 2 + ((WIDTH - 4) * at) / Math.max(scene.thin.length - 1, 1);
    for (const kind of ["storage", "loss"]) {
      if (after[kind][at] === null) continue;
      const sigmas = Math.max(-MOST, Math.min(MOST, after[kind][at] / width[row]));
      if (Number.isFinite(sigmas)) svg.append(s("circle", { class: `mark ${kind}`, cx: x.toFixed(1), cy: place(sigmas).toFixed(1), r: 1.2 }));
    }
  });
  return svg;
}
