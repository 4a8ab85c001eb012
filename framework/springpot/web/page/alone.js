// The page without a server: every rung and every preview is in the file; nothing can be computed anew.

import { byId, h } from "./dom.js";
import { Compare } from "./compare.js";
import { Ladder } from "./ladder.js";
import { Missing } from "./missing.js";
import { withInterval } from "./numbers.js";

const WHY = "this file shows what was found; open its data with 'springpot workbench' to accept effects";

class Alone {
  constructor({ scene, answers, command }) {
    Object.assign(this, { scene, answers, command, fixed: WHY, hovered: null, edited: null, beside: null, busy: null });
    this.rung = answers.length - 1;
    this.looks = { view: "storage-loss", plane: "stiffness", plan: 0 };
    this.history = { branches: [] };
    const panel = (id, title) => h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title), h("div", { id: `${id}-body` }));
    this.verdict = h("p", { id: "verdict" });
    this.parameters = h("div", { id: "parameters" });
    byId("bench").append(
      h("div", { class: "column left" }, h("section", {}, h("h1", {}, scene.name), h("p", {}, `${scene.count} points`), this.verdict), panel("model", "Model")),
      h("div", { class: "column middle" }, panel("compare", "Compare")),
      h("div", { class: "column right" }, panel("ladder", "Ladder"), panel("missing", "Missing")));
    byId("model-body").append(this.parameters, h("p", { class: "quiet" }, "The same on the command line:"), h("pre", { tabindex: "0" }, command));
    this.panels = [
      (this.compare = new Compare(byId("compare-body"), this)),
      (this.ladder = new Ladder(byId("ladder-body"), this)),
      (this.missing = new Missing(byId("missing-body"), this)),
    ];
    this.render();
  }

  get answer() { return this.answers[this.rung]; }

  get state() { return this.answer.state; }

  render() {
    const { diagnosis } = this.answer.discovery;
    this.verdict.textContent = `${diagnosis.model}: ${diagnosis.verdict}. ${diagnosis.says}.`;
    this.parameters.replaceChildren(h("dl", {}, ...this.answer.parameters.flatMap((parameter) => [
      h("dt", {}, parameter.name),
      h("dd", {}, `${withInterval(parameter.value, parameter.low, parameter.high).join(" ")} ${parameter.unit}`)])),
    h("p", {}, ...this.answers.map((answer, i) => h("button", { type: "button", "aria-pressed": String(i === this.rung), onclick: () => this.goTo(i) },
      i ? `+ ${answer.state.accepted[i - 1]}` : answer.discovery.steps[0].model))));
    for (const panel of this.panels) panel.render();
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
    for (const panel of [this.compare, this.ladder]) panel.preview(effect);
    this.missing.show(effect);
  }
}

export const shown = new Alone(JSON.parse(byId("told").textContent));
