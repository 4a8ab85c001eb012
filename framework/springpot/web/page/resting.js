// What is worked out while nobody waits: other models, ranked by a worker that stands back for all others.

import * as api from "./api.js";
import { rankingOf, rowsOf, withoutModel } from "./wants.js";

const REST = 3000; // ms that an answer is looked at before it begins

export class Resting {
  constructor(app) {
    this.app = app;
    this.of = null; // the rows that it is of
    this.found = null; // what came while a cause was pointed at
  }

  // Called when a person has arrived somewhere: of the same rows it goes on.
  settle() {
    const { app } = this;
    const of = app.state && !app.waiting && !app.watch.watching ? rowsOf(app.state) : null;
    this.bring();
    if (of === this.of) return;
    clearTimeout(this.clock);
    this.control?.abort();
    this.of = of;
    this.found = null;
    if (of && app.ranking?.of !== of && !app.left.has(rankingOf(of))) this.clock = setTimeout(() => this.rank(of), REST);
  }

  async rank(of) {
    const { app } = this;
    const control = new AbortController();
    this.control = control;
    try {
      const found = await api.ask("ranking", { state: withoutModel(app.state), quiet: true }, control);
      if (!control.signal.aborted) this.found = { ...found, of };
    } catch { return; } // whoever asks for it is told why
    this.bring();
  }

  // Cards are not laid under a pointer.
  bring() {
    const { app, found } = this;
    if (!found || app.hovered !== null) return;
    this.found = null;
    if (app.ranking?.of === found.of) return;
    app.ranking = found;
    app.render();
  }
}
