// One computation at a time: told while it runs, ended by a newer one or by hand.

import { byId } from "./dom.js";

const TICK = 100; // ms between updates of the clock that a person watches: tenths of a second are shown

export class Work {
  constructor(changed) {
    this.changed = changed; // called when one has begun; who began it shows its end
    this.name = null; // of what runs
  }

  // { found }, or { refused: why }; nothing of both where it was ended before its answer came.
  async run(name, action) {
    this.end();
    const control = new AbortController();
    this.control = control;
    this.name = name;
    const begun = performance.now();
    let stage = "computing";
    const told = () => { byId("stage").textContent = `${stage}, ${((performance.now() - begun) / 1000).toFixed(1)} s`; };
    this.clock = setInterval(told, TICK);
    byId("work").hidden = false;
    document.body.setAttribute("aria-busy", "true");
    told();
    this.changed();
    const how = { signal: control.signal, told: (text) => { stage = text; told(); } };
    try {
      const found = await action(how);
      if (control.signal.aborted) return {};
      this.end();
      return { found };
    } catch (error) {
      // What was ended from here has nothing to say any more, whatever it fails with.
      if (control.signal.aborted) return {};
      this.end();
      return { refused: error.message };
    }
  }

  end() {
    if (!this.control) return;
    const { control } = this;
    this.control = null;
    this.name = null;
    clearInterval(this.clock);
    control.abort();
    byId("work").hidden = true;
    document.body.removeAttribute("aria-busy");
  }
}
