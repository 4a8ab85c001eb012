// The ranked effects: pointing previews what each would do, from what is already in the page; a click accepts.

import { changed, enable, h, put, usable } from "./dom.js";
import { number, percent, probability, times, withInterval } from "./numbers.js";

const SHELVES = { explains: "explains it", helps: "helps", "ruled-out": "ruled out" };
const ORDER = Object.keys(SHELVES);

export class Missing {
  constructor(parent, app) {
    this.app = app;
    this.active = null;
    this.list = h("ul", {
      id: "effects", role: "listbox", tabindex: "0", "aria-labelledby": "missing-title",
      onkeydown: (event) => this.key(event),
      onpointerleave: () => this.app.hover(this.active),
      onblur: () => this.choose(null),
    });
    this.details = h("div", { id: "effect-details", class: "details", "aria-live": "polite" });
    this.accept = h("button", { type: "button", id: "accept", class: "primary", onclick: () => this.take(this.active) }, "Accept effect");
    this.says = h("p", { class: "quiet" });
    this.folded = true;
    this.fold = h("button", { type: "button", id: "ruled-out", class: "quiet", onclick: () => this.unfold(!this.folded) });
    put(parent, this.says, this.list, this.fold, this.accept, this.details);
    // The list loses its focus when the button is pressed; what was chosen stays until then.
    this.accept.addEventListener("pointerdown", (event) => event.preventDefault());
    this.accept.addEventListener("keydown", (event) => { if (event.key === "Escape") this.choose(null); });
  }

  render() {
    const { answer } = this.app;
    if (!changed(this, answer)) {
      this.show(this.app.hovered);
      return;
    }
    const diagnosis = answer?.discovery.diagnosis;
    this.active = null;
    this.candidates = diagnosis ? inClasses(diagnosis.candidates) : [];
    this.says.textContent = diagnosis ? sentence(diagnosis, this.app.fixed) : "Effects are ranked here as soon as there are data.";
    put(this.list, this.candidates.map((candidate, i) => this.option(candidate, i, diagnosis.error.noise_floor)));
    this.unfold(true);
    this.accept.hidden = Boolean(this.app.fixed) || this.candidates.length === 0;
    this.show(this.app.hovered);
  }

  // One line names what is ruled out as a cause; pressed, it opens their rows.
  unfold(folded) {
    this.folded = folded;
    const out = this.candidates.filter((candidate) => candidate.shelf === "ruled-out").map((candidate) => candidate.effect);
    for (const option of this.list.children) option.hidden = folded && out.includes(option.dataset.effect);
    this.list.hidden = this.visible().length === 0;
    this.fold.hidden = out.length === 0;
    this.fold.setAttribute("aria-expanded", String(!folded));
    this.fold.textContent = `${out.length} ruled out, as the error stays: ${out.join(", ")}`;
    if (out.includes(this.active)) this.choose(null);
  }

  visible() {
    return this.candidates.map((candidate) => candidate.effect).filter((_, i) => !this.list.children[i].hidden);
  }

  option(candidate, i, floor) {
    const group = candidate.class.length > 1;
    const before = this.candidates[i - 1]?.class.includes(candidate.effect);
    const after = this.candidates[i + 1]?.class.includes(candidate.effect);
    const bracket = group ? `bracket${before ? "" : " first"}${after ? "" : " last"}` : "";
    const after_ = candidate.error_after;
    return h("li", {
      id: `effect-${candidate.effect}`, role: "option", "aria-selected": "false", class: bracket,
      "data-effect": candidate.effect,
      onpointerenter: (event) => { if (event.pointerType !== "touch") this.app.hover(candidate.effect); },
      onclick: (event) => this.clicked(event, candidate.effect),
    },
    h("span", { class: "name" }, candidate.effect),
    h("span", { class: `word ${candidate.shelf}`, title: "what it does for the misfit: what helps lowers the error, and is no proof" }, SHELVES[candidate.shelf]),
    h("span", { class: "chance", title: `probability ${number(candidate.probability)} that it is among what is missing` }, probability(candidate.probability)),
    h("span", { class: "fall", title: after_ === null ? "not fitted by itself" : `error with it: ${percent(after_)} of |K|, ${times(after_, floor)}` }, `→ ${percent(after_, 2)}`));
  }

  // A mouse has seen the preview before it clicks; a finger has not, so its first tap only shows it.
  clicked(event, effect) {
    if (event.pointerType === "touch") this.choose(effect);
    else this.take(effect);
  }

  key(event) {
    const names = this.visible();
    const here = names.indexOf(this.active);
    const to = { ArrowDown: here + 1, ArrowUp: here < 0 ? 0 : here - 1, Home: 0, End: names.length - 1 }[event.key];
    if (to !== undefined) this.choose(names[Math.max(0, Math.min(names.length - 1, to))]);
    else if (event.key === "Enter" || event.key === " ") this.take(this.active);
    else if (event.key === "Escape") this.choose(null);
    else return;
    event.preventDefault();
  }

  choose(effect) {
    this.active = effect;
    this.app.hover(effect);
  }

  take(effect) {
    if (effect && !this.app.fixed && usable(this.accept)) this.app.accept(effect);
  }

  // Called for every preview, wherever it comes from.
  show(effect) {
    for (const option of this.list.children) {
      const here = option.dataset.effect === effect;
      option.setAttribute("aria-selected", String(here));
      if (here) this.list.setAttribute("aria-activedescendant", option.id);
    }
    if (!effect) this.list.removeAttribute("aria-activedescendant");
    else if (effect === this.active) document.getElementById(`effect-${effect}`)?.scrollIntoView({ block: "nearest" });
    this.describe(effect);
  }

  describe(effect) {
    const diagnosis = this.app.answer?.discovery.diagnosis;
    const candidate = this.candidates?.find((one) => one.effect === effect);
    let why = "point at an effect first";
    if (this.app.waiting) why = "wait for the computation, or cancel it";
    else if (candidate) why = "";
    enable(this.accept, why);
    if (!candidate) {
      const hint = "Point at an effect, or go through them with the arrow keys: the dashed curve shows what it would do.";
      put(this.details, h("p", { class: "quiet" }, this.candidates?.length ? hint : ""));
      return;
    }
    const preview = this.app.answer.previews[effect];
    const floor = diagnosis.error.noise_floor;
    const others = candidate.class.filter((name) => name !== effect);
    put(this.details,
      h("p", {}, candidate.says),
      h("dl", {},
        ...row("size", Object.entries(candidate.parameters).map(([name, value]) => {
          const [told, interval] = withInterval(value.value, value.low, value.high);
          return `${name} = ${told} ${interval} ${value.unit}`;
        }).join("; ") || "not fitted: it stands too far behind"),
        ...row("error", preview ? `${percent(diagnosis.error.relative_rms)} → ${percent(preview.error)} (${times(preview.error, floor)})${preview.refitted ? "" : ", by the scan alone"}` : "no preview: it was not fitted alone"),
        ...row("evidence", `probability ${probability(candidate.probability)}, ΔBIC ${number(candidate.delta_bic, 3)}`),
        ...row("cannot be told from", others.join(", ") || "nothing: it has its own curve"),
        ...(candidate.verdict === "missing" ? [] : row("would have been seen", `from ${percent(candidate.bound, 2)} of |K| on`))));
  }
}

const MEANS = {
  size: "its parameters with their 95 % intervals",
  error: "root mean square of |K_model - K| / |K| before and after it joins, K being what was measured; the noise floor is what noise alone leaves",
  evidence: "probability that it is among what is missing; drop of the Bayesian information criterion when it joins, above 6 clear, above 10 decisive",
  "cannot be told from": "effects that change these data alike",
  "would have been seen": "relative change of K above which the effect would have been seen",
};
const row = (term, text) => [h("dt", { title: MEANS[term] }, term), h("dd", { title: MEANS[term] }, text)];

function sentence(diagnosis, fixed) {
  if (diagnosis.verdict === "adequate") return "Nothing is missing: what is left is noise. These were tried.";
  if (diagnosis.verdict === "unexplained") return "No known effect explains what is left. These were tried.";
  if (diagnosis.verdict === "inconclusive") return "These data cannot decide. These were tried.";
  return fixed ? "Point at one to see what it would do." : "Point to preview, click to accept.";
}

// Members of a class stand below one another, where the likeliest of them stands.
function inClasses(candidates) {
  const left = [...candidates];
  const ordered = [];
  while (left.length) {
    const first = left.shift();
    ordered.push(first);
    for (const name of first.class) {
      const i = left.findIndex((candidate) => candidate.effect === name);
      if (i >= 0) ordered.push(...left.splice(i, 1));
    }
  }
  // The sort keeps the order within a shelf.
  return ordered.sort((one, other) => ORDER.indexOf(one.shelf) - ORDER.indexOf(other.shelf));
}
