// The panels of a report: every rung and every preview is in the file; nothing can be computed anew.

import { byId, h } from "./dom.js";
import { Compare } from "./compare.js";
import { Hero } from "./hero.js";
import { Ladder } from "./ladder.js";
import { Missing } from "./missing.js";
import { pretty, withInterval } from "./numbers.js";
import { looksOf } from "./views.js";

class Report {
  constructor({ scene, rungs, excluded }) {
    this.scene = scene;
    // The panels ask for the state of what they draw; of a report there is but one.
    this.state = { data: "", excluded };
    this.answers = rungs.map((rung) => ({ ...rung, state: this.state }));
    this.rung = rungs.length - 1;
    this.fixed = true;
    this.hovered = null;
    this.edited = null;
    this.beside = null;
    this.busy = null;
    this.looks = looksOf();
    this.history = { branches: [] };
    this.parameters = h("dl", { id: "parameters" });
    byId("bench").append(
      h("section", { id: "hero", "aria-label": "The error, and what would lower it" },
        h("div", { id: "hero-body" }), h("div", { id: "ladder" }, h("div", { id: "ladder-body" }))),
      h("div", { class: "column" }, panel("compare", "Data and model"), panel("failing", "Where it fails")),
      h("div", { class: "column" }, panel("missing", "What may be missing"), panel("model", "Model")));
    byId("model-body").append(this.parameters);
    this.panels = [
      new Hero(byId("hero-body"), this),
      (this.compare = new Compare(byId("compare-body"), this, byId("failing-body"))),
      (this.ladder = new Ladder(byId("ladder-body"), this)),
      (this.missing = new Missing(byId("missing-body"), this)),
    ];
    this.render();
  }

  get answer() { return this.answers[this.rung]; }

  get first() { return this.answers[0]; }

  get before() { return this.answers[this.rung - 1] || null; }

  get steps() { return this.answers.at(-1).discovery.steps; }

  render() {
    this.parameters.replaceChildren(...this.answer.parameters.flatMap((parameter) => {
      const [value, interval] = withInterval(parameter.value, parameter.low, parameter.high);
      return [h("dt", {}, parameter.name), h("dd", {}, pretty(`${value} ${interval} ${parameter.unit === "-" ? "" : parameter.unit}`))];
    }));
    for (const each of this.panels) each.render();
  }

  // To look at a rung is all that can be done with it here.
  get looked() { return this.rung; }

  goTo(rung) { this.see(rung); }

  see(rung) {
    this.rung = rung;
    this.hovered = null;
    this.render();
  }

  look(change) {
    Object.assign(this.looks, change);
    this.render();
  }

  hover(effect) {
    this.hovered = effect;
    for (const each of [this.compare, this.ladder]) each.preview(effect);
    this.missing.show(effect);
  }
}

function panel(id, title) {
  const body = h("div", { id: `${id}-body` });
  return h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title), body);
}

export const shown = new Report(JSON.parse(byId("given").textContent));
