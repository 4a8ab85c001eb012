// Points that are chosen in the picture are a cause like others: it is seen what is left without them.

import * as api from "./api.js";
import { byId } from "./dom.js";

const SHELF = "Points that are chosen";

export class Chosen {
  constructor(app) {
    this.app = app;
    this.asked = null; // what the choice would do: its name, and the rows that would be out
  }

  // The newest choice wins; those between are never tried.
  async choose(asked) {
    const { app } = this;
    if (String(asked?.excluded) === String(this.asked?.excluded) && this.of === app.answer) return;
    this.asked = asked;
    this.of = app.answer;
    app.missing.propose(SHELF, null);
    if (this.trying) return;
    this.trying = true;
    for (let tried = null; this.asked !== tried;) {
      tried = this.asked;
      if (tried) await this.attempt(tried);
    }
    this.trying = false;
  }

  async attempt(asked) {
    const { app } = this;
    const { answer } = app;
    if (!answer || app.waiting) return;
    try {
      answer.previews[asked.name] = await api.ask("trial", { state: { ...app.state, excluded: asked.excluded } });
    } catch { return; } // it is told when it is taken
    if (this.asked !== asked || answer !== app.answer) return;
    app.missing.propose(SHELF, { effect: asked.name, label: asked.name, says: "every fit is made anew of the points that are used then", shown: "the error of those", error_after: answer.previews[asked.name].error });
    if (byId("exclude").matches(":hover")) app.hover(asked.name);
  }
}
