// Views that the server works out when somebody looks at them.

import { masterSpec } from "./master.js";
import { spectrumSpec } from "./spectrum.js";
import { keyOf, ofModel, rowsOf } from "./wants.js";

const shifts = ({ data }) => Boolean(data?.levels.some(({ column }) => column === "temperature" || column === "amplitude"));
const free = ({ state }) => Boolean(state) && /^(material\b|$)/.test(state.model);

export class Asked {
  constructor(app) {
    this.app = app;
    this.found = new Map(); // by view, with what it is of
    // `of`: what it depends on; `can`: whether these data and this model have it; `draw`: how it is drawn.
    this.views = {
      "master-curve": { name: "Master curve", task: "mastercurve", can: shifts, of: rowsOf, state: (state) => ofModel(state, ""), draw: (found) => masterSpec(app.scene, found, app.state.excluded) },
      spectrum: { name: "Spectrum", task: "spectrum", can: free, of: keyOf, state: (state) => state, draw: spectrumSpec },
    };
  }

  can(name) { return this.views[name].can(this.app); }

  // Whether it is there, of the data that are shown.
  has(name) { return name in this.views && this.found.get(name)?.of === this.views[name].of(this.app.state); }

  spec(name) { return this.views[name].draw(this.found.get(name)); }

  // What is still to be asked for, if anything.
  want(ask) {
    const { looks, state } = this.app;
    const view = this.views[looks.view];
    if (!view || !this.can(looks.view) || this.has(looks.view)) return null;
    const [name, of] = [looks.view, view.of(state)];
    return {
      name: `${name} ${of}`,
      ask: (how) => ask(view.task, { state: view.state(state) }, how),
      take: (found) => this.found.set(name, { ...found, of }),
      leave: () => { looks.view = "storage-loss"; },
    };
  }
}
