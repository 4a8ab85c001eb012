// A cause that was only foretold is fitted once it is pointed at for a while.

import * as api from "./api.js";
import { pretty } from "./numbers.js";

const DWELL = 300; // ms: a pointer that passes asks for nothing

export class Pointed {
  constructor(app) {
    this.app = app;
    this.asked = new WeakSet(); // candidates that were fitted, or cannot be
  }

  at(effect) {
    clearTimeout(this.clock);
    const { answer, waiting } = this.app;
    const candidate = answer?.discovery.diagnosis.candidates.find((one) => one.effect === effect);
    if (!candidate || waiting || answer.previews[effect]?.refitted || this.asked.has(candidate)) return;
    this.clock = setTimeout(() => this.fit(answer, candidate), DWELL);
  }

  async fit(answer, candidate) {
    const { app } = this;
    const { effect } = candidate;
    const { standing } = app;
    this.asked.add(candidate);
    let found;
    try {
      found = await api.ask("trial", { state: { ...standing, accepted: [...standing.accepted, effect] } });
    } catch { return; } // it is told when it is taken
    answer.previews[effect] = found;
    candidate.error_after = found.error;
    const own = found.sizes.find((size) => size.startsWith(`${effect}.`));
    if (own) candidate.shown = pretty(own.slice(effect.length + 1).replace(/ \[[^\]]*\]/, ""));
    if (answer !== app.answer) return;
    app.missing.fitted(candidate);
    if (app.hovered === effect) app.hover(effect);
  }
}
