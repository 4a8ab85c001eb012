// The panels of a report: every rung and every preview is in the file; nothing can be computed anew.

import { byId, h } from "./dom.js";
import { Compare } from "./compare.js";
import { Hero } from "./hero.js";
import { Ladder } from "./ladder.js";
import { Missing } from "./missing.js";
import { pretty, withInterval } from "./numbers.js";
import { looksOf } from "./views.js";

const LOOK = 1600; // ms on each rung of a replay

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
    const replay = h("button", { type: "button", id: "play", hidden: rungs.length < 2, onclick: () => this.play() }, "▶ Play from the first model");
    byId("bench").append(
      h("section", { id: "hero", "aria-label": "The error, and what would lower it" },
        h("div", { id: "hero-body" }), h("div", { id: "ladder" }, h("div", { id: "ladder-body" }), replay)),
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

  goTo(rung) {
    this.turn = 0;
    this.show(rung);
  }

  show(rung) {
    this.rung = rung;
    this.hovered = null;
    this.render();
  }

  // From the first rung to the last, each long enough to be looked at.
  async play() {
    const turn = (this.turn || 0) + 1;
    this.turn = turn; // whoever goes to a rung meanwhile ends it
    for (let rung = 0; rung < this.answers.length && this.turn === turn; rung += 1) {
      this.show(rung);
      await new Promise((done) => { setTimeout(done, LOOK); });
    }
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
