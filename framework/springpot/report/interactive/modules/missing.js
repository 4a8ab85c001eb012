// What may be missing, as cards on three shelves: pointing previews what each would do, from what is already in the page;
// a click accepts.

import { FINGER, changed, enable, h, put } from "./dom.js";
import { number, percent, pretty, probability, times, withInterval } from "./numbers.js";
import { sparkline } from "./spark.js";

const SHELVES = [
  ["explains", "Explains it"],
  ["helps", "Helps, but is no proof"],
  ["ruled-out", "Ruled out"],
];
const FOLDED = "ruled-out";
const LEAST = 0.001; // chance that is worth a word
const GAP = 6; // px below a card

export class Missing {
  constructor(parent, app) {
    this.app = app;
    this.active = null;
    this.folded = true;
    this.own = new Map(); // by title
    this.list = h("div", {
      id: "effects", role: "listbox", tabindex: "0", "aria-labelledby": "missing-title",
      onkeydown: (event) => this.key(event),
      onpointerleave: () => this.app.hover(this.active),
      onblur: () => this.choose(null),
    });
    this.details = h("div", { id: "effect-details", class: "details", tabindex: "0", role: "region", "aria-label": "What is pointed at", "aria-live": "polite" });
    this.accept = h("button", { type: "button", id: "accept", class: "primary", onclick: () => this.take(this.active) }, "Accept effect");
    this.fold = h("button", { type: "button", id: "fold", class: "small", onclick: () => this.unfold(!this.folded) });
    this.more = h("button", { type: "button", id: "more-effects", class: "small", title: "further down the list", onclick: () => this.goOn() });
    this.says = h("p", { class: "quiet" });
    put(parent, this.says, this.list, h("div", { class: "bar" }, this.accept, this.fold, this.more), this.details);
    this.list.addEventListener("scroll", () => this.edges());
    new ResizeObserver(() => this.fit()).observe(parent);
    // The list loses its focus when the button is pressed; what was chosen stays until then.
    this.accept.addEventListener("pointerdown", (event) => event.preventDefault());
    this.accept.addEventListener("keydown", (event) => { if (event.key === "Escape") this.choose(null); });
  }

  render() {
    const { answer, laws, others } = this.app;
    if (!changed(this, answer, laws, others)) {
      this.show(this.app.hovered);
      return;
    }
    const diagnosis = answer?.discovery.diagnosis;
    this.active = null;
    if (this.of !== answer) this.own.clear();
    this.of = answer;
    const accepted = diagnosis?.model.split(" + ") || [];
    // What is there already is a cause no more, unless a second one of it was fitted.
    this.candidates = (diagnosis?.candidates || []).filter((one) => one.error_after !== null || !accepted.includes(one.effect));
    this.others = othersOf(this.app);
    this.says.title = laws ? pretty(laws.invention.says) : "";
    this.says.textContent = diagnosis ? sentence(diagnosis, this.app.fixed, laws?.invention) : "Effects are ranked here as soon as there are data.";
    this.shelves = SHELVES.map(([name, title]) => [name, title, cardsOf(this.candidates.filter((one) => one.shelf === name))])
      .filter(([, , cards]) => cards.length);
    put(this.list, this.shelves.map(([name, title, cards]) =>
      h("div", { role: "group", class: "shelf", "aria-label": title, "data-title": title, "data-shelf": name },
        cards.map((card) => this.card(card, diagnosis)))));
    // Laws that were asked for stand first; what is folded last.
    const shelf = (title) => h("div", { role: "group", class: "shelf", "aria-label": title, "data-title": title },
      this.others.filter((one) => one.shelf === title).map((one) => this.card([one], diagnosis)));
    if (laws) this.list.prepend(shelf(titleOf(laws)));
    for (const title of [SO_FAR, ON_DATA, INSTEAD]) if (this.others.some((one) => one.shelf === title)) this.list.append(shelf(title));
    const ruledOut = this.list.querySelector(`[data-shelf="${FOLDED}"]`);
    if (ruledOut) this.list.append(ruledOut);
    const none = this.candidates.length + this.others.length === 0;
    this.list.hidden = none;
    this.accept.hidden = Boolean(this.app.fixed) || none;
    this.unfold(this.folded);
    for (const title of this.own.keys()) this.place(title);
    this.fit();
    this.show(this.app.hovered);
  }

  // The list ends where a card does: none is cut at its foot, and what stands below moves for no pointer.
  fit() {
    const { list } = this;
    list.style.maxHeight = "";
    const [top, room] = [list.getBoundingClientRect().top - list.scrollTop, list.clientHeight];
    // Beside one another they are swiped through, and each is there in its full height.
    const column = getComputedStyle(list).display !== "flex";
    this.more.hidden = !column;
    if (column && list.scrollHeight > room + 1) {
      const feet = this.cards.map((card) => card.getBoundingClientRect().bottom - top + GAP);
      const most = Math.max(0, ...feet.filter((foot) => foot <= room));
      if (most) list.style.maxHeight = `${Math.ceil(most)}px`;
    }
    this.edges();
  }

  get cards() {
    return [...this.list.querySelectorAll(".shelf:not([hidden]) .card")];
  }

  // How many are further down; what is scrolled under an edge fades there.
  edges() {
    const { list } = this;
    const box = list.getBoundingClientRect();
    const cut = (edge) => this.cards.some((card) => { const { top, bottom } = card.getBoundingClientRect(); return top < edge - 1 && bottom > edge + 1; });
    list.classList.toggle("cut-above", list.scrollTop > 1 && cut(box.top));
    list.classList.toggle("cut-below", cut(box.bottom));
    const below = this.shown.filter((option) => option.getBoundingClientRect().bottom > box.bottom + 1).length;
    this.more.textContent = `${below} more ↓`;
    this.more.classList.toggle("none", below === 0);
  }

  // What stood first below the foot stands first.
  goOn() {
    const { list } = this;
    const box = list.getBoundingClientRect();
    const next = this.cards.find((card) => card.getBoundingClientRect().bottom > box.bottom + 1);
    const shelf = next?.parentElement.firstElementChild === next ? next.parentElement : next;
    if (shelf) list.scrollBy({ top: shelf.getBoundingClientRect().top - box.top });
  }

  // What a person asks about is a cause as well, one of each kind: parameters that were moved, a law, points that are chosen.
  propose(title, one) {
    if (!one && !this.own.has(title)) return;
    this.own.delete(title);
    if (one) this.own.set(title, { ...one, class: [], shelf: title });
    this.list.querySelector(`[data-title="${title}"]`)?.remove();
    if (one) this.place(title);
    else this.fit();
  }

  // Below the causes: what a hand is about to choose stays where it is.
  place(title) {
    const shelf = h("div", { role: "group", class: "shelf", "aria-label": title, "data-title": title }, this.card([this.own.get(title)], this.app.answer.discovery.diagnosis));
    this.list.insertBefore(shelf, this.list.querySelector(`[data-shelf="${FOLDED}"]`));
    this.list.hidden = false;
    this.accept.hidden = false;
    this.unfold(this.folded);
  }

  // What is ruled out is one line until somebody asks; where nothing else is there, all of it is shown.
  unfold(folded) {
    this.folded = folded;
    const shelf = this.list.querySelector(`[data-shelf="${FOLDED}"]`);
    const alone = this.list.childElementCount === 1;
    if (shelf) shelf.hidden = folded && !alone;
    this.fold.hidden = !shelf || alone;
    const out = this.candidates.filter((candidate) => candidate.shelf === FOLDED).map((candidate) => candidate.effect);
    this.fold.textContent = `${folded ? "Show" : "Hide"} ${out.length} ruled out`;
    this.fold.title = `the error stays with them: ${out.join(", ")}`;
    this.fold.setAttribute("aria-expanded", String(!folded));
    this.fit();
  }

  // Effects that these data cannot tell apart are one card: what is left with them, each with its size, and what decides.
  card(members, diagnosis) {
    const names = members.map((candidate) => candidate.effect);
    const plan = diagnosis.next_experiment;
    const decides = members.length > 1 && plan?.separates.length && plan.separates.every((name) => names.includes(name));
    return h("div", { class: "card", role: "presentation" },
      sparkline(this.app.scene, this.app.answer, names[0], this.app.looks.plane),
      members.map((candidate) => this.option(candidate, diagnosis.error.noise_floor)),
      decides ? h("p", { class: "quiet", role: "presentation" }, `told apart by the next experiment (${number(plan.expected_separation_sigma, 2)} σ)`) : null);
  }

  option(candidate, floor) {
    // Of tests in time nearly fitted effects tell an error too.
    const after = candidate.error_beside ?? candidate.error_after ?? (this.app.scene.views ? candidate.predicted_error : null);
    const [beside, leads] = this.beside(candidate);
    const size = Object.entries(candidate.parameters || {}).slice(0, 1).map(([name, value]) => `${name} = ${number(value.value, 3)} ${value.unit === "-" ? "" : pretty(value.unit)}`);
    return h("div", {
      id: idOf(candidate.effect), role: "option", "aria-selected": "false", class: "option",
      "data-effect": candidate.effect,
      onpointerenter: (event) => { if (event.pointerType !== "touch") this.app.hover(candidate.effect); },
      onclick: (event) => this.clicked(event, candidate.effect),
    },
    h("span", { class: "name", title: candidate.effect }, candidate.label || candidate.effect),
    h("span", { class: "fall", title: after === null ? "not fitted by itself" : `error with ${leads}it: ${percent(after)} of ${this.app.answer.discovery.diagnosis.error.test || this.app.answer.of}, ${times(after, floor)}` }, `→ ${percent(after, 2)}${beside}`),
    h("span", { class: "size", title: candidate.says }, candidate.shown || size[0] || "not fitted"),
    !(candidate.probability >= LEAST) ? null : h("span", { class: `word ${candidate.verdict}`, title: "probability that it is among what is missing" }, `chance ${probability(candidate.probability)}`));
  }

  // What was only foretold has its own error and size now.
  fitted(candidate) {
    const option = document.getElementById(idOf(candidate.effect));
    option?.replaceWith(this.option(candidate, this.app.answer.discovery.diagnosis.error.noise_floor));
  }

  // What only shows beside the effect that leads is told so: by itself it lowers nothing.
  beside({ error_beside: error }) {
    return error == null ? ["", ""] : [" beside", `${this.app.answer.discovery.diagnosis.leading[0]} and `];
  }

  // A mouse has seen the preview before it clicks; a finger has not, so its first tap only shows it.
  clicked(event, effect) {
    if (event.pointerType === "touch") this.choose(effect);
    else this.take(effect);
  }

  // As they stand below one another; what is folded is passed over.
  get shown() {
    return [...this.list.querySelectorAll(".shelf:not([hidden]) [role=option]")];
  }

  key(event) {
    const names = this.shown.map((option) => option.dataset.effect);
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
    if (effect && !this.app.fixed) this.app.accept(effect);
  }

  // Called for every preview, wherever it comes from.
  show(effect) {
    for (const option of this.list.querySelectorAll("[role=option]")) {
      const here = option.dataset.effect === effect;
      option.setAttribute("aria-selected", String(here));
      if (here) this.list.setAttribute("aria-activedescendant", option.id);
    }
    if (!effect) this.list.removeAttribute("aria-activedescendant");
    else if (effect === this.active) document.getElementById(idOf(effect))?.scrollIntoView({ block: "nearest" });
    this.describe(effect);
  }

  // What is pointed at; of nothing, what leads.
  describe(effect) {
    const diagnosis = this.app.answer?.discovery.diagnosis;
    const asked = effect ?? diagnosis?.leading[0];
    const candidate = this.candidates?.find((one) => one.effect === asked);
    const other = [...(this.others || []), ...this.own.values()].find((one) => one.effect === asked);
    let why = `${FINGER.matches ? "tap" : "point at"} an effect first`;
    if (this.app.waiting) why = "wait for the computation, or cancel it";
    else if (effect && (candidate || other)) why = "";
    enable(this.accept, why);
    this.details.classList.toggle("pointed", Boolean(effect && (candidate || other)));
    const named = (says) => h("p", {}, h("b", {}, pretty((candidate || other).label || asked)), `: ${pretty(says)}`);
    if (other) put(this.details, named(other.says), h("dl", {}, ...row("error", this.fallTo(other.error_after))));
    else if (candidate) put(this.details, named(candidate.says), this.facts(candidate));
    else {
      const hint = `${FINGER.matches ? "Tap an effect" : "Point at an effect, or go through them with the arrow keys"}: the dashed curve shows what it would do.`;
      put(this.details, h("p", { class: "quiet" }, this.candidates?.length ? hint : ""));
    }
  }

  fallTo(after) {
    const { relative_rms: now, noise_floor: floor } = this.app.answer.discovery.diagnosis.error;
    return `${percent(now)} → ${percent(after)} (${times(after, floor)})`;
  }

  facts(candidate) {
    const preview = this.app.answer.previews[candidate.effect];
    const others = candidate.class.filter((name) => name !== candidate.effect);
    return h("dl", {},
      ...row("size", Object.entries(candidate.parameters).map(([name, value]) => {
        const [told, interval] = withInterval(value.value, value.low, value.high);
        return pretty(`${name} = ${told} ${interval} ${value.unit === "-" ? "" : value.unit}`);
      }).join("; ") || pretty(candidate.shown || "not fitted: it stands too far behind")),
      ...(candidate.error_beside == null ? [] : row(`with ${this.beside(candidate)[1]}it`, this.fallTo(candidate.error_beside))),
      ...row("error", preview ? `${this.fallTo(preview.error)}${preview.refitted ? "" : ", by the scan alone"}` : "no preview: it was not fitted alone"),
      ...row("evidence", `probability ${probability(candidate.probability)}, ΔBIC ${number(candidate.delta_bic, 3)}`),
      ...(others.length ? row("rivals", others.join(", ")) : []),
      ...(candidate.shelf !== FOLDED || candidate.bound === null ? [] : row("would have been seen", `from ${percent(candidate.bound, 2)} of ${this.app.answer.of} on`)));
  }
}

const idOf = (effect) => `effect-${effect.replace(/[^\w:-]+/g, "-")}`;

const SO_FAR = "Tried so far";
const ON_DATA = "With the data themselves";
const INSTEAD = "Another model";
const titleOf = ({ invention }) => ({ none: "Laws that come nearest", class: "Laws that these data cannot tell apart", law: "The law that is missing" })[invention.verdict];

// What is no effect of the library and yet a hypothesis like one: laws that were found, what can be done with the data,
// other models.
function othersOf({ answer, laws, others }) {
  if (!answer) return [];
  const known = new Set(answer.discovery.diagnosis.candidates.map((candidate) => candidate.effect));
  const acts = answer.actions.filter((action) => !known.has(action.name)).map((action) => ({
    effect: action.name, label: action.label, says: action.says, shown: action.shown || action.accept[0] || (action.turns?.length ? "the other way" : "the error of the others"),
    shelf: answer.discovery.verdict === "sought" ? SO_FAR : ON_DATA }));
  const found = (laws?.texts || []).map((text, i) => {
    const { says, parameters, probability } = laws.invention.laws[i];
    const sizes = Object.entries(parameters).map(([name, value]) => {
      const [told, interval] = withInterval(value.value, value.low, value.high);
      return pretty(`${name} = ${told} ${interval} ${value.unit === "-" ? "" : value.unit}`.trim());
    });
    return { effect: text, label: pretty(text.replace(/^.*?= */, "")), says: `${sizes.join("; ")}; ${says}`, shown: sizes[0], probability, shelf: titleOf(laws) };
  });
  // The present one with an effect more is a cause's own card.
  const { model } = answer.discovery.diagnosis;
  const instead = (others?.actions || []).filter(({ label }) => label !== model && !label.startsWith(`${model} + `))
    .map(({ name, label, says, shown }) => ({ effect: name, label, says, shown, shelf: INSTEAD }));
  return [...found, ...acts, ...instead].map((one) => ({ ...one, class: [], error_after: answer.previews[one.effect].error }));
}

const MEANS = {
  size: "its parameters with their 95 % intervals",
  error: "root mean square of |K − K_model| / |K| before and after it joins, K being what was measured; the noise floor is what noise alone leaves",
  evidence: "probability that it is among what is missing; drop of the Bayesian information criterion when it joins, above 6 clear, above 10 decisive",
  rivals: "effects that change these data alike: nothing here tells them apart",
  "would have been seen": "relative change of K above which the effect would have been seen",
};
const row = (term, text) => [h("dt", { title: MEANS[term] }, term), h("dd", { title: MEANS[term] }, text)];

function sentence(diagnosis, fixed, invention) {
  if (invention) return foundIn(invention);
  if (diagnosis.verdict === "sought") return "They are being sought.";
  if (diagnosis.verdict === "adequate") return "Nothing is missing: what is left is noise. These were tried.";
  if (diagnosis.verdict === "unexplained") return "No known effect explains what is left. These were tried.";
  if (diagnosis.verdict === "inconclusive") return "These data cannot decide. These were tried.";
  if (FINGER.matches) return fixed ? "Tap one to see what it would do." : "Tap one to preview it, then accept it.";
  return fixed ? "Point at one to see what it would do." : "Point to preview, click to accept.";
}

// Beside the cards of the laws: what would tell them apart, or why there is none.
function foundIn({ verdict, says, next_experiment: next }) {
  if (verdict === "none") return pretty(`${says}.`);
  if (next?.separates.length) return pretty(`To tell the two likeliest laws apart: ${next.says}.`);
  return verdict === "law" ? "No other law of the grammar does as well." : "No measurement that is at hand would tell these laws apart.";
}

// Members of a class are one card, where the likeliest of them stands.
function cardsOf(candidates) {
  const left = [...candidates];
  const cards = [];
  while (left.length) {
    const first = left.shift();
    const card = [first];
    for (const name of first.class) {
      const i = left.findIndex((candidate) => candidate.effect === name);
      if (i >= 0) card.push(...left.splice(i, 1));
    }
    cards.push(card);
  }
  return cards;
}
