// The model: typed, searched or ranked; its parameters, which can be moved, fixed and bounded by hand.

import { byId, enable, h, put, usable } from "./dom.js";
import { number, pretty, withInterval } from "./numbers.js";

const REACH = 1; // decades on each side of the fitted value that a slider covers
const STEPS = 200;

export class ModelPanel {
  constructor(parent, app) {
    this.app = app;
    this.input = h("input", { id: "expression", list: "expressions", autocomplete: "off", spellcheck: "false",
      placeholder: "material", "aria-describedby": "expression-says", oninput: () => this.complete() });
    this.given = h("input", { id: "given", autocomplete: "off", spellcheck: "false", placeholder: "--own k:batch --tie 'k2 = 2*k1'",
      title: "as on the command line: --own NAMES:COLUMN, --share NAMES, --tie TIE, --population COLUMN" });
    this.options = h("datalist", { id: "expressions" });
    this.judge = h("button", { id: "judge" }, "Judge this model");
    this.search = h("input", { id: "search", type: "search", placeholder: "search models ( / )", oninput: () => this.filter() });
    this.models = h("ul", { class: "models", id: "models" });
    this.rank = h("button", { type: "button", id: "rank", title: "fit every installed model and rank them", onclick: () => app.rankModels() }, "Rank models");
    this.ranked = h("div", { id: "ranked" });
    this.table = h("div", { id: "parameters" });
    put(parent,
      h("form", { onsubmit: (event) => { event.preventDefault(); app.judge(this.input.value.trim(), this.given.value.trim()); } },
        h("label", { for: "expression" }, "Expression"), this.input, this.options,
        (this.about = h("p", { id: "expression-says", class: "quiet" })),
        (this.shared = h("details", { id: "shared" }, h("summary", {}, "Own, shared, tied"), h("label", { for: "given" }, "Parameters"), this.given)),
        h("p", { class: "bar" }, this.judge, this.rank)),
      h("details", { id: "all-models", ontoggle: () => this.list() }, h("summary", {}, "All models"), h("label", { for: "search", class: "hidden" }, "Search models"), this.search, this.models),
      this.ranked, this.table);
  }

  // What can stand behind the last +.
  complete() {
    const { installed } = this.app;
    if (!installed) return;
    const parts = this.input.value.split("+");
    const before = parts.slice(0, -1).map((part) => part.trim());
    const names = before.length ? installed.effects.map((effect) => effect.name) : installed.models.map((model) => model.name);
    put(this.options, names.map((name) => h("option", { value: [...before, name].join(" + ") })));
  }

  filter() {
    const wanted = this.search.value.toLowerCase();
    for (const item of this.models.children) item.hidden = !item.dataset.text.includes(wanted);
  }

  // The drawings of all models cost more than the rest of the page: they are made when somebody looks for them.
  list() {
    const { installed } = this.app;
    if (!installed || !byId("all-models").open || this.models.childElementCount) return;
    put(this.models, installed.models.map((model) => h("li", { "data-text": [model.name, ...model.aliases, model.summary].join(" ").toLowerCase() },
      h("button", { type: "button", onclick: () => this.app.judge(model.name.replace(/-N$/, "-3")) },
        h("span", { class: "name" }, model.name),
        h("img", { alt: "", src: `data:image/svg+xml,${encodeURIComponent(model.svg)}` }),
        h("span", { class: "quiet" }, model.summary)))));
  }

  openSearch() {
    byId("all-models").open = true;
    this.list();
    this.search.focus();
  }

  render() {
    const { app } = this;
    let why = "";
    if (!app.data) why = "open data first";
    else if (app.busy) why = "wait for the computation, or cancel it";
    enable(this.rank, why);
    this.renderExpression();
    this.renderRanked();
    if (this.drawn !== app.answer) this.renderParameters();
    this.drawn = app.answer;
    this.renderButtons();
  }

  // What a person types stays until the page goes on to another model than the one that it showed.
  renderExpression() {
    const { named, state } = this.app;
    const model = named ?? state?.model ?? "";
    if (model !== this.shown && document.activeElement !== this.input) this.input.value = model;
    this.shown = model;
    const options = state?.options ?? "";
    if (options !== this.given.shown && document.activeElement !== this.given) this.given.value = options;
    this.given.shown = options;
    if (options) this.shared.open = true;
    let says = "";
    if (named !== null) says = `${named || "material"} is judged as soon as there are data.`;
    else if (!model) says = "Left empty, any linear passive material is judged.";
    this.about.textContent = says;
    this.about.classList.toggle("hidden", !says);
  }

  // A text that was refused stands where it can be mended, though the page goes back to the model before.
  keepText() {
    this.shown = this.app.state.model;
    this.given.shown = this.app.state.options ?? "";
  }

  renderRanked() {
    const { others, state } = this.app;
    put(this.ranked, state && others ? h("p", {}, `${others.ranking?.says || `best: ${others.best}`}. They stand among the causes.`) : null);
  }

  renderParameters() {
    const { answer } = this.app;
    this.hands = new Map();
    this.app.hands.forget();
    if (!answer || answer.discovery.verdict === "sought") {
      put(this.table);
      return;
    }
    const movable = answer.parameters.length && answer.state.model !== "" && answer.state.model !== "material" && !answer.state.options;
    const rows = answer.parameters.map((parameter) => this.row(parameter, movable));
    this.told = h("p", { id: "edited-says", class: "quiet", role: "status" });
    this.fit = h("button", { type: "button", id: "fit", onclick: () => { if (usable(this.fit)) this.app.hands.fit(this.asked()); } }, "Fit within these");
    this.reset = h("button", { type: "button", id: "reset", onclick: () => { if (usable(this.reset)) this.renderParameters(); } }, "Back to the fit");
    put(this.table, h("h3", {}, "Parameters"),
      answer.parameters.length ? h("div", { class: "parameters" }, ...rows)
        : h("p", { class: "quiet" }, "A material is a whole spectrum: it has no parameters to move."),
      movable ? h("p", {}, this.fit, " ", this.reset) : null, this.told, correlations(answer.parameters),
      answer.reference ? h("p", { class: "quiet" }, answer.reference) : null);
    this.renderButtons();
  }

  renderButtons() {
    if (!this.fit) return;
    const edited = [...this.hands.values()].some((hand) => hand.touched);
    let why = "";
    if (!edited) why = "move, fix or bound a parameter first";
    else if (this.app.busy) why = "wait for the computation, or cancel it";
    enable(this.fit, why);
    enable(this.reset, edited ? "" : "nothing was edited: this is the fit");
  }

  row(parameter, movable) {
    const [value, interval] = withInterval(parameter.value, parameter.low, parameter.high);
    const hand = { value: parameter.value, fitted: parameter.value, fixed: false, lower: null, upper: null, touched: false };
    this.hands.set(parameter.name, hand);
    const told = h("span", { class: "told", title: "fitted value and its 95 % interval" }, pretty(`${value} ${interval} ${parameter.unit === "-" ? "" : parameter.unit}`));
    const name = h("span", { class: "name" }, parameter.name);
    const head = h("div", { class: "head" }, name, told);
    if (!movable) return h("div", { class: "parameter" }, head);
    const box = h("input", { type: "number", step: "any", value, "aria-label": `${parameter.name} in ${parameter.unit}`,
      onchange: () => this.place(parameter, Number(box.value), "box") });
    const slider = h("input", { type: "range", min: -STEPS, max: STEPS, value: 0, "aria-label": `move ${parameter.name}`,
      oninput: () => this.place(parameter, this.placed(parameter, Number(slider.value)), "slider") });
    const fix = h("input", { type: "checkbox", onchange: () => { hand.fixed = fix.checked; this.touched(hand); } });
    const bound = (side) => h("input", { type: "number", step: "any", placeholder: `${side}: ${number(parameter[side])}`, "aria-label": `${side} bound of ${parameter.name}`,
      onchange: (event) => { hand[side] = event.target.value === "" ? null : Number(event.target.value); this.touched(hand); } });
    Object.assign(hand, { box, slider });
    return h("div", { class: "parameter" }, head, slider, box,
      h("details", { class: "bounds" }, h("summary", {}, "limits"), bound("lower"), bound("upper"), h("label", { class: "check" }, fix, " fix")));
  }

  placed({ value, scale, lower, upper }, place) {
    if (scale === "log") return value * 10 ** ((REACH * place) / STEPS);
    const reach = place < 0 ? value - Math.max(lower ?? -Infinity, value - Math.abs(value) - 1e-12) : Math.min(upper ?? Infinity, value + Math.abs(value) + 1e-12) - value;
    return value + (reach * place) / STEPS;
  }

  // What a hand has put elsewhere than the fit: values by name.
  moved() {
    return Object.fromEntries([...this.hands].filter(([, hand]) => hand.touched && hand.value !== hand.fitted).map(([name, { value }]) => [name, value]));
  }

  // The same as a card of a cause.
  movedAs(effect, { error }) {
    const label = Object.entries(this.moved()).map(([name, value]) => `${name} = ${number(value)}`).join(", ");
    return label ? { effect, label: `hold ${label}`, says: "what was moved is held where it stands, and all else is fitted", shown: "by hand", error_after: error } : null;
  }

  place(parameter, value, by) {
    const hand = this.hands.get(parameter.name);
    if (!Number.isFinite(value)) return;
    hand.value = value;
    if (by === "slider") hand.box.value = Number(value.toPrecision(4));
    this.touched(hand);
    this.app.hands.draw(this.asked());
  }

  touched(hand) {
    hand.touched = true;
    this.renderButtons();
  }

  asked() {
    return Object.fromEntries([...this.hands].map(([name, { value, fixed, lower, upper }]) => [name, { value, fixed, lower, upper }]));
  }

  // The values of a fit by hand.
  take(values) {
    for (const [name, hand] of this.hands) {
      hand.value = values[name];
      if (hand.box) hand.box.value = Number(values[name].toPrecision(5));
    }
  }

  says(text) {
    if (this.told) this.told.textContent = text;
  }
}

// How parameters move together: of two that do, the data fix a combination better than either.
function correlations(parameters) {
  if (!parameters.some(({ correlated }) => Object.keys(correlated).length)) return null;
  const cell = (row, column) => {
    const r = row.correlated[column.name];
    if (r === undefined) return h("td", {}, row === column ? "1" : "–");
    const told = h("td", { class: r < 0 ? "falls" : "grows" }, pretty(r.toFixed(2)));
    told.style.setProperty("--share", `${Math.round(30 * Math.abs(r))}%`);
    return told;
  };
  const name = (scope) => (parameter) => h("th", { scope }, parameter.name);
  const rows = parameters.map((row) => h("tr", {}, name("row")(row), ...parameters.map((column) => cell(row, column))));
  return h("details", { id: "correlations" }, h("summary", {}, "Correlations"),
    h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "correlations of the parameters" },
      h("table", {}, h("thead", {}, h("tr", {}, h("td"), ...parameters.map(name("col")))), h("tbody", {}, ...rows))));
}
