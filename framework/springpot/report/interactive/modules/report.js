// The panels of a report: every rung and every preview is in the file; nothing can be computed anew.

import { byId, h } from "./dom.js";
import { Compare, verdict } from "./compare.js";
import { Ladder } from "./ladder.js";
import { Missing } from "./missing.js";
import { withInterval } from "./numbers.js";
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
    this.verdict = h("p", { id: "verdict" });
    this.parameters = h("dl", { id: "parameters" });
    byId("bench").append(
      h("div", { class: "column" }, panel("compare", "Compare")),
      h("div", { class: "column" }, panel("ladder", "Ladder"), panel("missing", "Missing"), panel("model", "Model")));
    byId("compare-body").before(this.verdict);
    byId("model-body").append(this.parameters);
    this.panels = [
      (this.compare = new Compare(byId("compare-body"), this)),
      (this.ladder = new Ladder(byId("ladder-body"), this)),
      (this.missing = new Missing(byId("missing-body"), this)),
    ];
    this.render();
  }

  get answer() { return this.answers[this.rung]; }

  get steps() { return this.answers.at(-1).discovery.steps; }

  render() {
    this.verdict.textContent = verdict(this.answer);
    this.parameters.replaceChildren(...this.answer.parameters.flatMap((parameter) => {
      const [value, interval] = withInterval(parameter.value, parameter.low, parameter.high);
      return [h("dt", {}, parameter.name), h("dd", {}, `${value} ${interval} ${parameter.unit}`)];
    }));
    for (const each of this.panels) each.render();
  }

  goTo(rung) {
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
