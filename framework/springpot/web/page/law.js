// A law of one's own, previewed while it is typed, and laws that are sought.

import * as api from "./api.js";
import { enable, h, put, usable } from "./dom.js";
import { percent, pretty } from "./numbers.js";

const SHELF = "A law of your own";
const EXAMPLE = "my-mass = parallel: -m*omega^2";
const LANGUAGE = "NAME = PLANE: FORMULA. parallel adds a stiffness, series a compliance, chain a factor, shift one of the frequency. Known are omega, f, i, s, X (amplitude), T and columns of the data; whatever else is named is a parameter.";

export class Law {
  constructor(parent, app) {
    this.app = app;
    this.wanted = null; // the newest text that was not tried yet
    this.input = h("input", { id: "law", autocomplete: "off", spellcheck: "false", placeholder: EXAMPLE, title: LANGUAGE, "aria-describedby": "law-says",
      oninput: () => this.typed(), onfocus: () => this.typed(), onblur: () => this.app.hover(null) });
    this.add = h("button", { id: "add-law" }, "Add law");
    this.says = h("p", { id: "law-says", class: "quiet", role: "status" });
    this.find = h("button", { type: "button", id: "find-law", title: "seek what is missing as a formula, over frequency and all columns that were varied", onclick: () => { if (usable(this.find)) app.findLaws(); } }, "Find a law");
    this.form = h("form", { onsubmit: (event) => { event.preventDefault(); this.take(); } },
      h("label", { for: "law" }, "A law of your own"), h("div", { class: "law" }, this.input, this.add, this.find));
    put(parent, this.form, this.says);
    // The box loses its focus when the button is pressed; what was typed is still previewed.
    this.add.addEventListener("pointerdown", (event) => event.preventDefault());
  }

  render() {
    const { answer, laws, busy, waiting, data } = this.app;
    this.form.hidden = !data;
    let why = "";
    if (!answer) why = "there is no answer yet";
    else if (busy || waiting) why = "wait for the computation, or cancel it";
    if (data?.scene.views) why = "laws are sought in sweeps: type one here, or add a sweep of this specimen";
    enable(this.find, laws ? "they stand above" : why);
    this.find.hidden = !answer || !["unexplained", "inconclusive"].includes(answer.discovery.verdict);
    if (this.of !== answer) this.forget();
    this.of = answer;
    this.enable();
  }

  // What is on its way belongs to the answer before.
  forget() {
    this.tried = null;
    this.wanted = null;
    this.app.missing.propose(SHELF, null);
    if (this.input.value) this.says.textContent = "";
  }

  enable() {
    let why = "type a law first";
    if (this.app.waiting) why = "wait for the computation, or cancel it";
    else if (this.tried) why = "";
    enable(this.add, why);
  }

  take() {
    if (!this.tried || !usable(this.add)) return;
    const { law } = this.tried;
    this.input.value = "";
    this.app.accept(law);
  }

  // The newest text wins; those between are never tried.
  async typed() {
    this.wanted = this.input.value.trim();
    this.tried = null;
    this.enable();
    if (this.trying || this.app.waiting || !this.app.answer) return;
    this.trying = true;
    while (this.wanted !== null) await this.attempt();
    this.trying = false;
  }

  async attempt() {
    const { answer } = this.app;
    const text = this.wanted;
    this.wanted = null;
    let says = "";
    if (text) {
      try {
        const found = await api.ask("trial", { state: answer.state, law: text });
        if (answer !== this.app.answer) return;
        const [law] = found.accept;
        this.tried = { law, found };
        answer.previews[law] = found;
        says = `${percent(answer.discovery.diagnosis.error.relative_rms)} → ${percent(found.error)} with ${found.sizes.join("; ")}. ${found.says}.`;
      } catch (error) {
        says = error.message;
      }
    }
    if (this.wanted !== null) return;
    this.says.textContent = pretty(says);
    this.app.missing.propose(SHELF, this.tried && { effect: this.tried.law, label: this.tried.law, says: this.tried.found.says, shown: pretty(this.tried.found.sizes[0] || ""), error_after: this.tried.found.error });
    this.app.hover(this.tried ? this.tried.law : null);
    this.enable();
  }
}
