// Parameters moved by hand: the curve follows, and a fit within what was set.

import * as api from "./api.js";
import { percent } from "./numbers.js";

const FIT = "fit by hand";

export class Hands {
  constructor(app) {
    this.app = app;
    this.wanted = null; // the newest position that is not drawn yet
    this.moves = 0; // counts what makes a curve that is still on its way one of the past
  }

  // The parameters were made anew: what is on its way belongs to those before.
  forget() {
    this.moves += 1;
    this.wanted = null;
    this.app.setEdited(null);
  }

  // The newest position of a slider wins; those between are never asked for.
  async draw(hands) {
    const { app } = this;
    if (app.work.name === FIT) app.work.end(); // it began from where the slider no longer stands
    this.wanted = hands;
    if (this.drawing) return;
    this.drawing = true;
    while (this.wanted) {
      const { moves, wanted } = this;
      this.wanted = null;
      try {
        const found = await api.ask("curve", { state: app.answer.state, hands: wanted });
        if (moves === this.moves) this.show(found, "edited");
      } catch (error) {
        if (moves === this.moves) app.model.says(error.message);
      }
    }
    this.drawing = false;
  }

  async fit(hands) {
    const { app } = this;
    this.moves += 1;
    this.wanted = null;
    const { state } = app.answer;
    const { found, refused } = await app.work.run(FIT, (how) => api.ask("held", { state, hands }, how));
    if (refused) app.model.says(refused);
    if (found) {
      app.model.take(found.values);
      this.show(found, "fitted within these");
    }
    app.render();
    app.pursue();
  }

  show(found, word) {
    this.app.setEdited(found);
    this.app.model.says(`${word}: error ${percent(found.error)}`);
  }
}
