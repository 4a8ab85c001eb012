// A folder that is watched: rows drift in as its files grow, the rivals' odds move, the ladder stays.

import * as api from "./api.js";
import { byId, h, put, s } from "./dom.js";
import { probability } from "./numbers.js";
import { keyOf } from "./wants.js";

const PULSE = 1000; // ms between looks at the folder
const TALL = 74; // px of the picture of the odds
const ASIDE = 165; // px for the names beside it
const RIVALS = 3; // that are drawn; of more the names would not stand apart
const LEAST = 0.02; // chance below which an effect is no rival

export class Watch {
  constructor(app, parent) {
    this.app = app;
    this.parent = parent;
    this.line = byId("watched");
    this.trail = []; // the odds after each growth
    this.waits = [];
    this.files = [];
    this.fault = "";
  }

  begin(saved) {
    Object.assign(this, saved);
    this.clock = setInterval(() => this.look(), PULSE);
    this.look();
  }

  // Whether what is open is what the folder held last: whoever opens other data watches no more until he is back.
  get live() { return (this.app.state?.data || "") === this.data; }

  get watching() { return Boolean(this.folder) && this.live; }

  async look() {
    const { app } = this;
    if (this.looking || document.hidden || app.reading || app.question) return;
    this.looking = true;
    try {
      this.base ??= app.state?.data || ""; // what the files join
      this.data ??= this.base;
      if (this.live) await this.ask();
    } catch (error) {
      this.fault = error.message;
    } finally {
      this.looking = false;
      this.render();
    }
  }

  async ask() {
    const { base, data, signature } = this;
    const found = await api.ask("watch", { known: signature, base, before: data });
    if (!found.folder) {
      clearInterval(this.clock);
      return;
    }
    this.folder = found.folder;
    this.fault = "";
    if (found.files) Object.assign(this, { files: found.files, waits: found.waits, signature: found.signature });
    if (found.digest) this.next = found;
    if (this.next && this.live && !this.app.busy) await this.bring(this.next);
  }

  // What has grown is shown with its answer: until that is there the page stays as it was.
  async bring(next) {
    const { app } = this;
    if (app.state) {
      const state = () => ({ ...app.state, data: next.digest, excluded: app.state.excluded.map((row) => next.rows[row]).filter((row) => row !== null) });
      const asked = state();
      if (!app.answers.has(keyOf(asked))) app.answers.set(keyOf(asked), await api.ask("answer", { state: asked }));
      if (app.busy || !this.live || keyOf(state()) !== keyOf(asked)) return; // a step was made meanwhile: at the next look
    }
    this.next = null;
    this.data = next.digest;
    app.grown(next);
  }

  // The data that are open are what the files join from now on.
  join() {
    this.base = this.data = this.app.state?.data || "";
    this.signature = "";
    this.look();
  }

  render() {
    if (!this.folder) return;
    this.line.hidden = false;
    const says = this.live ? `Watching ${this.folder}: ${this.held()}` : `${this.folder} is not watched: other data are open. `;
    const waiting = this.live ? [this.fault, ...this.waits].filter(Boolean).slice(0, 3) : [];
    const told = [says, ...waiting].join("; waits: ");
    if (told === this.told && this.drawn === this.app.answer) return;
    this.told = told;
    this.drawn = this.app.answer;
    document.body.classList.toggle("watching", this.live);
    put(this.line, document.createTextNode(told),
      this.live ? null : h("button", { type: "button", class: "small", id: "join-watched", onclick: () => this.join() }, "Add its files to these"));
    this.odds();
  }

  held() {
    if (!this.files.length) return "nothing to read in it yet";
    return `${this.app.data?.scene.count || 0} points, ${this.files.length} file${this.files.length === 1 ? "" : "s"}`;
  }

  // The chances of the rivals against the number of points, as far as the ladder is the same.
  odds() {
    const { answer, scene } = this.app;
    if (!answer || !this.live || this.app.waiting) return;
    const { diagnosis } = answer.discovery;
    if (this.of !== diagnosis.model) this.trail = [];
    this.of = diagnosis.model;
    const chances = Object.fromEntries(diagnosis.candidates.map((one) => [one.effect, one.probability]));
    if (this.trail.at(-1)?.data !== this.data) this.trail.push({ data: this.data, count: scene.count, chances });
    const [kind, says] = decision(diagnosis, answer.proposed);
    put(this.parent, this.picture(diagnosis.candidates), h("p", { id: "decided", class: kind }, says));
  }

  picture(candidates) {
    const most = (name) => Math.max(...this.trail.map(({ chances }) => chances[name] || 0));
    const rivals = candidates.filter((one) => most(one.effect) > LEAST).slice(0, RIVALS);
    if (!rivals.length) return null;
    const width = this.parent.clientWidth;
    const [first, last] = [this.trail[0].count, this.trail.at(-1).count];
    const x = (count) => 2 + ((count - first) / Math.max(last - first, 1)) * (width - ASIDE - 8);
    const y = (chance) => 4 + (1 - chance) * (TALL - 8);
    const says = rivals.map((one) => `${one.effect} ${probability(one.probability)}`).join(", ");
    const svg = s("svg", { id: "odds", class: "plot", width, height: TALL, viewBox: `0 0 ${width} ${TALL}`, role: "img", "aria-label": `Chances of the rivals from ${first} to ${last} points, now ${says}` });
    for (const chance of [0, 1]) svg.append(s("line", { class: "grid", x1: 0, x2: width - ASIDE, y1: y(chance), y2: y(chance) }));
    // Names stand apart, also where the chances do not.
    const sorted = rivals.map((one, i) => ({ ...one, i })).sort((a, b) => b.probability - a.probability);
    let foot = 0;
    for (const { effect, probability: chance, i } of sorted) {
      foot = Math.max(foot + 15, Math.min(y(chance) + 4, TALL - 4 - 15 * (sorted.length - 1 - sorted.findIndex((one) => one.i === i))));
      const path = this.trail.map(({ count, chances }, step) => `${step ? "L" : "M"}${x(count).toFixed(1)} ${y(chances[effect] || 0).toFixed(1)}`).join("");
      svg.append(s("path", { class: `line odds-${i}`, d: path }), s("circle", { class: `odds-${i}`, cx: x(last), cy: y(chance), r: 4 }),
        s("text", { class: "label", x: width - ASIDE + 10, y: foot }, `${probability(chance)} ${effect}`, s("title", {}, effect)));
    }
    return svg;
  }
}

// Whether what was measured decides; what to measure else stands below.
function decision({ verdict, leading, model }, next) {
  if (next?.separates.length) return ["open", "Measure here next:"];
  if (verdict === "adequate") return ["decided", `Decided: ${model} explains all that was measured.`];
  if (verdict === "effect-missing" && leading.length === 1) return ["decided", `Decided: ${leading[0]} is missing.`];
  return ["open", next ? "Not decided. Measure here next:" : "Not decided."];
}
