// The error, rung by rung, against the noise floor: every rung can be gone back to, left out or branched from.

import { changed, h, put, s } from "./dom.js";
import { number, percent, times } from "./numbers.js";
import { logTicks } from "./plot.js";

const TALL = 150; // px of the picture
const LOW = 122; // on a screen that has few
const LEFT = 60; // px to the frame, more where the ticks are wider
const BESIDE = 22; // of them for the name of the axis
const LETTER = 6.5; // px for a letter of a tick
const BOTTOM = 24;
const LONGEST = 7; // px for a letter of a name below its step
const RIGHT = 12;
const ASIDE = 92; // px to the words of the noise floor where those of the material floor stand in their place

const LOOK = 1600; // ms on each rung of a replay

const SMALL = matchMedia("(max-height: 850px)");
const cut = (name, most) => (name.length > most ? `${name.slice(0, Math.max(1, Math.floor(most) - 1))}…` : name);

export class Ladder {
  constructor(parent, app) {
    this.app = app;
    this.svg = s("svg", { id: "plot-ladder", class: "plot", role: "img" });
    this.branches = h("div", { class: "branches", role: "group", "aria-label": "Branches" });
    this.list = h("ol", { id: "rungs", role: "list", start: "0" });
    this.other = h("div", { id: "beside" });
    this.play = h("button", { type: "button", id: "play", title: "from the first model to the last", onclick: () => this.replay() }, "▶ Play");
    this.scrub = h("input", { type: "range", id: "scrub", min: "0", step: "1", "aria-label": "rung that is shown", oninput: () => app.see(Number(this.scrub.value)) });
    this.film = h("div", { class: "film", hidden: true }, this.play, this.scrub);
    this.frame = h("div", {}, this.svg);
    put(parent, this.frame, this.branches, h("div", { class: "steps" }, this.film, this.list), this.other);
    new ResizeObserver(() => { if (this.frame.clientWidth !== this.width) this.render(); }).observe(this.frame);
  }

  render() {
    this.width = this.frame.clientWidth;
    this.height = SMALL.matches ? LOW : TALL;
    const { answer, history, beside, rung } = this.app;
    const branches = history.branches.map((branch) => branch.name).join("");
    if (!changed(this, answer, beside?.key, beside?.branch, rung, this.width, branches, history.at)) {
      this.preview(this.app.hovered);
      return;
    }
    this.svg.toggleAttribute("hidden", !answer);
    this.film.hidden = !answer || this.app.steps.length < 2;
    this.scrub.max = this.app.steps.length - 1;
    this.scrub.value = this.app.looked ?? rung;
    this.scrub.setAttribute("aria-valuetext", this.app.steps[rung]?.model || "");
    this.renderBranches(history);
    if (!answer || !this.width) {
      put(this.list);
      put(this.other, h("p", { class: "quiet" }, answer ? "" : "The error of each model against the noise floor is drawn here."));
      return;
    }
    put(this.list, this.turned(), this.leftOut(), this.held(), this.app.steps.map((step, i) => this.rung(step, i, i === this.app.rung)));
    put(this.other, beside ? this.besideList(beside) : null);
    this.draw(this.app.steps, beside);
    this.preview(this.app.hovered);
  }

  // From the first rung to the last, each long enough to be looked at; whoever goes to another meanwhile ends it.
  async replay() {
    const last = this.app.steps.length - 1;
    for (let rung = 0; rung <= last; rung += 1) {
      this.app.see(rung);
      await new Promise((done) => { setTimeout(done, LOOK); });
      if (this.app.looked !== rung) return;
    }
  }

  rung(step, i, present) {
    const name = step.accepted || step.model;
    const alike = (step.class || []).filter((other) => other !== step.accepted);
    const label = i ? `+ ${name}` : name;
    const told = percent(step.relative_rms);
    const whole = `${step.model}: ${told}, ${times(step.relative_rms, step.noise_floor)}`;
    return h("li", { class: present ? "last" : "" },
      h("button", { type: "button", id: `rung-${i}`, class: "rung", "aria-current": present ? "step" : null,
        title: present ? `${whole} (the present rung)` : `${whole}; go to this rung`, onclick: () => this.app.goTo(i) },
      h("span", { class: "name" }, label), h("span", { class: "told" }, told)),
      this.app.fixed ? null : h("button", { type: "button", id: `branch-${i}`, class: "small", "aria-label": `branch from ${name}`, title: "another way from here, held beside this one",
        onclick: () => this.app.fork(i) }, "branch"),
      i && !this.app.fixed ? h("button", { type: "button", id: `remove-${i}`, class: "small", "aria-label": `remove ${name}`, title: "leave this effect out, keep the others",
        onclick: () => this.app.remove(i - 1) }, "×") : null,
      alike.length ? h("span", { class: "alike quiet" }, `or ${alike.join(", ")}`) : null);
  }

  // What was turned is no more told by the data themselves.
  turned() {
    const said = this.app.data?.source?.match(/[\w ]+=-[^,]+/);
    return said ? h("li", { id: "turned", title: `opened as ${this.app.data.source}` }, `turned: ${said[0]}`) : null;
  }

  // What is fitted to fewer rows than were measured says so, before its first rung.
  leftOut() {
    const { excluded } = this.app.state;
    if (!excluded.length) return null;
    const rows = excluded.length === 1 ? `row ${excluded[0] + 1}` : `${excluded.length} rows`;
    return h("li", { id: "left-out", title: `left out: rows ${excluded.slice(0, 40).map((row) => row + 1).join(", ")}` }, `without ${rows}`,
      this.app.fixed ? null : h("button", { type: "button", class: "small", "aria-label": `take back ${rows}`, title: "take them back", onclick: () => this.app.leaveOut([]) }, "×"));
  }

  // Parameters that are held are no longer fitted on any rung.
  held() {
    const { fixed } = this.app.state;
    if (!fixed) return null;
    const told = Object.entries(fixed).map(([name, value]) => `${name} = ${number(value)}`).join(", ");
    return h("li", { id: "held" }, `${told} held`,
      this.app.fixed ? null : h("button", { type: "button", class: "small", "aria-label": `release ${told}`, title: "fit them again", onclick: () => this.app.hold(null) }, "×"));
  }

  renderBranches(history) {
    if (!history || history.branches.length < 2) {
      put(this.branches);
      return;
    }
    put(this.branches, history.branches.map((branch, i) => h("span", {},
      h("button", { type: "button", "aria-pressed": String(i === history.at), onclick: () => this.app.select(i) }, `Branch ${branch.name}`),
      h("button", { type: "button", class: "small", "aria-label": `close branch ${branch.name}`, title: "close this branch",
        onclick: () => this.app.drop(i) }, "×"))));
  }

  besideList(beside) {
    return h("div", {}, h("h3", {}, `Branch ${beside.branch}, beside`),
      h("ol", { start: "0" }, ...beside.discovery.steps.map((step, i) => h("li", {},
        h("span", { class: "name" }, i ? `+ ${step.accepted}` : step.model), " ",
        h("span", { class: "told" }, `${percent(step.relative_rms)} (${times(step.relative_rms, step.noise_floor)})`)))));
  }

  // Ticks with as many digits as tell them apart.
  ticks(low, high) {
    const ticks = logTicks(low, high);
    const words = [1, 2, 3].map((digits) => ticks.map((tick) => percent(tick, digits)));
    return [ticks, words.find((told) => new Set(told).size === told.length) || words.at(-1)];
  }

  draw(steps, beside) {
    const others = beside ? beside.discovery.steps : [];
    const count = Math.max(steps.length, others.length) + (this.app.hovered ? 1 : 0);
    const all = [...steps, ...others].flatMap((step) => [step.relative_rms, step.noise_floor, step.material_floor]).filter((value) => value > 0);
    const [low, high] = [Math.min(...all) / 1.6, Math.max(...all) * 1.5];
    const width = this.width;
    const [ticks, told] = this.ticks(low, high);
    const left = Math.max(LEFT, BESIDE + LETTER * Math.max(...told.map((word) => word.length)));
    this.x = (i) => left + ((i + 0.5) * (width - left - RIGHT)) / Math.max(count, 2);
    this.y = (error) => 8 + ((Math.log(high) - Math.log(error)) / (Math.log(high) - Math.log(low))) * (this.height - BOTTOM - 8);
    const bottom = this.height - BOTTOM;
    const half = (this.x(1) - this.x(0)) / 2;
    this.half = half;
    const parts = [s("title", {}, `Error of each rung: ${steps.map((step) => percent(step.relative_rms)).join(", ")}; noise floor ${percent(steps.at(-1).noise_floor)}`)];
    ticks.forEach((tick, i) => {
      parts.push(s("line", { class: "grid", x1: left, x2: width - RIGHT, y1: this.y(tick), y2: this.y(tick) }));
      parts.push(s("text", { class: "tick", x: left - 5, y: this.y(tick) + 4, "text-anchor": "end" }, told[i]));
    });
    steps.forEach((step, i) => {
      const top = this.y(step.noise_floor);
      const right = i === steps.length - 1 ? width - RIGHT : this.x(i) + half;
      parts.push(s("rect", { class: "floor", x: this.x(i) - half, width: right - this.x(i) + half, y: top, height: Math.max(bottom - top, 0) },
        s("title", {}, `noise floor ${percent(step.noise_floor)}: the error that noise alone leaves`)));
      const at = this.y(step.material_floor);
      parts.push(s("line", { class: "material", x1: this.x(i) - half, x2: right, y1: at, y2: at },
        s("title", {}, `material floor ${percent(step.material_floor)}: the least error of any linear passive material`)));
      const name = i ? `+ ${step.accepted}` : step.model;
      parts.push(s("text", { class: "tick", x: this.x(i), y: this.height - 8, "text-anchor": "middle" }, cut(name, (2 * half) / LONGEST)));
    });
    const middle = (8 + bottom) / 2;
    parts.push(s("text", { class: "label", x: 11, y: middle, "text-anchor": "middle", transform: `rotate(-90 11 ${middle})` }, this.app.scene.views ? "error" : `error of ${this.app.answer.of}`));
    // No error lies below the material floor: under its line there is room, unless the other words stand there. Where
    // that line would strike them through, both stand above it.
    const dashes = this.y(steps[0].material_floor);
    const under = dashes + 14 < bottom;
    parts.push(s("text", { class: "tick", x: left + (under ? 3 : ASIDE), y: under ? bottom - 3 : dashes - 4 }, "noise floor"));
    parts.push(s("text", { class: "tick", x: left + 3, y: dashes + (dashes + 28 < bottom ? 12 : -4) }, "material floor"));
    parts.push(...this.stairs(others, "beside"), ...this.stairs(steps, "accepted"));
    this.ghost = s("g", { class: "ghost" });
    this.svg.setAttribute("viewBox", `0 0 ${width} ${this.height}`);
    this.svg.setAttribute("width", width);
    this.svg.setAttribute("height", this.height);
    this.svg.setAttribute("aria-label", parts[0].textContent);
    this.svg.replaceChildren(...parts, this.ghost);
    this.fall(steps);
  }

  stairs(steps, kind) {
    if (!steps.length) return [];
    const d = steps.map((step, i) => `${i ? "L" : "M"}${this.x(i) - this.half} ${this.y(step.relative_rms)}H${this.x(i) + this.half}`).join("");
    return [s("path", { class: `stairs ${kind}`, d }), ...steps.map((step, i) =>
      s("circle", { class: `rung-mark ${kind}${kind === "accepted" && i === this.app.rung ? " here" : ""}`, cx: this.x(i), cy: this.y(step.relative_rms), r: 5, "data-rung": i,
        onclick: () => { if (kind === "accepted") this.app.goTo(i); } },
      s("title", {}, `${step.model}: error ${percent(step.relative_rms)}, ${times(step.relative_rms, step.noise_floor)}`)))];
  }

  // The newest rung falls from the height of the one before.
  fall(steps) {
    const key = steps.map((step) => step.model).join("|");
    const grown = this.shown && key.startsWith(`${this.shown}|`);
    this.shown = key;
    if (!grown || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    const marks = this.svg.querySelectorAll(".rung-mark.accepted");
    const last = marks[marks.length - 1];
    const rise = this.y(steps.at(-2).relative_rms) - this.y(steps.at(-1).relative_rms);
    last.animate([{ transform: `translateY(${rise}px)` }, { transform: "none" }], { duration: 500, easing: "ease-in" });
  }

  // Above a mark, or below it where there is no room.
  besideMark(x, y, text) {
    return s("text", { class: "label", x, y: y > 26 ? y - 9 : y + 17, "text-anchor": "middle" }, text);
  }

  preview(effect) {
    const { answer, steps, rung } = this.app;
    if (!answer || !this.ghost) return;
    const { edited } = this.app;
    const preview = effect ? answer.previews[effect] : edited;
    if (!preview || !Number.isFinite(preview.error)) {
      this.ghost.replaceChildren();
      return;
    }
    const at = Math.min(this.x(rung + 1), this.width - RIGHT - 6);
    const y = Math.max(6, Math.min(this.height - BOTTOM, this.y(preview.error)));
    const edge = this.x(rung) + this.half;
    this.ghost.replaceChildren(
      s("path", { class: "stairs preview", d: `M${edge} ${this.y(steps[rung].relative_rms)}V${y}H${this.width - RIGHT}` }),
      s("circle", { class: "rung-mark preview", cx: at, cy: y, r: 5 }),
      this.besideMark(at, y, percent(preview.error, 2)));
  }
}
