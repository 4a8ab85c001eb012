// The claim at a glance: the number that falls, where the model fails, what would explain it, and one button.

import { changed, enable, h, put } from "./dom.js";
import { capital, number, percent, pretty, times } from "./numbers.js";
import { sentence, spotOf } from "./spots.js";

// The name under which parameters that were moved are a cause like others.
export const BY_HAND = "by hand";
const ERROR = "error: root mean square of |K − K_model| / |K| over all points, K being what was measured; noise floor: the error that noise alone leaves";
const EMPTY = "See where a model fails, and which physical effect is missing from it.";
const UNANSWERED = "These data have no answer yet: see what is said above.";

// What the answer would add, if it names anything: the likeliest of the class that it leads with.
export function proposed(diagnosis) {
  const { leading, candidates } = diagnosis;
  return candidates.find((candidate) => candidate.effect === leading[0]) || null;
}

// One sentence of what the answer is, above the picture.
export function verdict({ discovery }) {
  const { diagnosis } = discovery;
  const word = discovery.verdict === "sought" ? "" : `${discovery.verdict}; `;
  // Where it fails is said beside it.
  return `${diagnosis.model}: ${word}${pretty(diagnosis.says.replace(`; ${diagnosis.where[0]?.says}`, ""))}.`;
}

// The error in brief, and what is pointed at or moved by hand would make of it.
export function claimed({ answer, edited, hovered }) {
  if (!answer) return null;
  const { noise_floor: floor, relative_rms: now } = answer.discovery.diagnosis.error;
  const told = (error) => times(error, floor) || percent(error, 2);
  const preview = hovered !== BY_HAND && answer.previews[hovered];
  const next = preview || edited;
  return [h("span", { class: "big" }, next ? told(now).replace(" floor", "") : told(now)),
    next ? h("span", { class: `big ${preview ? "preview" : "edited"}` }, ` → ${told(next.error)}`) : null,
    next ? ` ${preview ? `with ${hovered}` : BY_HAND}` : null];
}

export class Hero {
  constructor(parent, app) {
    this.app = app;
    this.big = h("p", { id: "number", title: ERROR });
    this.says = h("p", { id: "verdict" });
    this.place = h("p", { id: "fails" });
    this.add = h("button", { type: "button", id: "add", class: "primary", onclick: () => app.accept(this.effect),
      onpointerenter: () => app.hover(this.effect), onpointerleave: () => app.hover(null) });
    this.parent = parent;
    put(parent, this.big, h("div", { class: "claim" }, this.place, this.says, this.add));
  }

  render() {
    const { answer, scene, waiting } = this.app;
    enable(this.add, waiting ? "wait for the computation, or cancel it" : "");
    const refused = this.app.refused || this.app.unanswered;
    const { edited, laws } = this.app;
    if (!changed(this, answer, scene, refused, laws, edited)) return;
    const diagnosis = answer?.discovery.diagnosis;
    this.big.hidden = !answer;
    this.parent.classList.toggle("alone", !answer);
    this.says.textContent = answer ? verdict(answer) : withoutAnswer(scene, refused);
    this.says.className = answer ? `verdict ${answer.discovery.verdict}` : "quiet";
    this.place.textContent = "";
    const found = turnOf(answer) || lawOf(answer, laws) || (diagnosis ? proposed(diagnosis) : null);
    this.effect = found?.effect || null;
    this.add.hidden = Boolean(this.app.fixed) || !found;
    if (!answer) return;
    // What is moved by hand is told while it moves.
    this.count({ ...diagnosis.error, relative_rms: edited?.error ?? diagnosis.error.relative_rms }, answer.of);
    this.big.className = edited ? "edited" : answer.discovery.verdict;
    if (diagnosis.where.length) this.place.textContent = sentence(spotOf(diagnosis.where[0], answer.spots[0], scene));
    if (diagnosis.verdict === "effect-missing" && found?.parameters) this.place.textContent += ` ${explained(found)}`;
    this.place.title = this.place.textContent;
    if (found) this.add.textContent = `${found.label || `Add ${found.effect.split(" =")[0]}`} → ${fallTo(found, diagnosis.error)}`;
  }

  // In units of the noise floor, as this is what decides; the size in per cent below it.
  count(error, of) {
    const ratio = error.noise_floor > 0 ? error.relative_rms / error.noise_floor : NaN;
    const told = Number.isFinite(ratio) ? [`${number(ratio, 2)} ×`, "the noise floor"] : [percent(error.relative_rms, 2), ""];
    put(this.big, h("span", { class: "big" }, told[0]), h("span", {}, told[1]),
      h("span", { class: "quiet" }, `${percent(error.relative_rms)} of ${error.test || of}`));
  }
}

// Of a channel that counts the other way every other answer is wrong.
function turnOf(answer) {
  const turn = answer?.actions.find(({ turns }) => turns?.length);
  return turn ? { effect: turn.name, label: `Turn ${turn.turns.join(" and ")}`, error_after: answer.previews[turn.name].error } : null;
}

// A law that was found comes before effects that only help.
function lawOf(answer, laws) {
  if (!answer || !laws || laws.invention.verdict === "none") return null;
  return { effect: laws.texts[0], error_after: answer.previews[laws.texts[0]].error };
}

function withoutAnswer(scene, refused) {
  if (!scene) return EMPTY;
  return refused ? UNANSWERED : "";
}

// Its first parameter is its size: "Inertia (m = 0.60 kg) would explain it."
function explained({ effect, parameters }) {
  const [size] = Object.entries(parameters);
  const told = size ? ` (${size[0]} = ${pretty(`${number(size[1].value, 2)} ${size[1].unit}`)})` : "";
  return `${capital(effect)}${told} would explain it.`;
}

function fallTo(candidate, error) {
  const after = candidate.error_after ?? candidate.predicted_error;
  return times(after, error.noise_floor) || percent(after, 2);
}
