// The second page: studies that race optimisers, how far they are, and their tables.

import { ask } from "./api.js";
import { download, h, put } from "./dom.js";
import { Plot } from "./plot.js";

const AGAIN = 2000; // ms between looks at what is running
const COLOURS = 9; // lines told apart by colour, the best ones; the others are grey
const [WIDTH, HEIGHT] = [620, 300];

export class Race {
  constructor(parent) {
    this.parent = parent;
    this.opened = [];
    this.list = h("div", { id: "studies", class: "scroll", tabindex: "0", role: "group", "aria-label": "Studies", "aria-live": "polite" });
    this.report = h("div", { id: "study" });
    put(parent, h("section", { "aria-labelledby": "race-title" }, h("h2", { id: "race-title" }, "Studies in results/"), this.list), this.report);
  }

  show() {
    this.hide();
    this.look();
    this.timer = setInterval(() => this.look(), AGAIN);
  }

  hide() {
    clearInterval(this.timer);
  }

  async look() {
    let found;
    try {
      ({ studies: found } = await ask("race", {}));
    } catch (error) {
      put(this.list, h("p", { class: "error" }, error.message));
      return;
    }
    const key = JSON.stringify(found);
    if (key === this.key) return;
    this.key = key;
    if (!found.length) {
      put(this.list, h("p", { class: "quiet" }, "There is no study here yet: springpot run STUDY.py starts one; this page then shows how far it is."));
      return;
    }
    put(this.list, h("table", {}, h("thead", {}, h("tr", {}, ...["study", "cells", "trials done", "failed", "started", "", "", ""].map((word) => h("th", { scope: "col" }, word)))),
      h("tbody", {}, ...found.map((study) => h("tr", {}, h("th", { scope: "row" }, study.name),
        ...(study.says ? [h("td", { colspan: "7" }, study.says)] : this.row(study)))))));
    if (this.opened.length) this.open(this.opened);
  }

  row(study) {
    const done = h("td", {}, `${study.done} of ${study.total} `,
      h("progress", { max: study.total, value: study.done, "aria-label": `trials of ${study.name} done` }));
    const button = (name, action) => h("td", {}, h("button", { type: "button", onclick: action }, name));
    return [h("td", {}, study.cells), done, h("td", {}, study.failed), h("td", {}, study.started),
      button(`Tables of ${study.name}`, () => this.open([study.name])),
      button(`Put ${study.name} beside`, () => this.open([...this.opened.slice(0, 1), study.name])),
      button(`Report of ${study.name} (HTML)`, () => this.take(study.name))];
  }

  // The whole report, with its figures, as one file.
  async take(name) {
    try {
      const found = await ask("race", { name, report: true });
      put(this.report, download(found.name, found.text, "text/html"));
    } catch (error) {
      put(this.report, h("p", { class: "error" }, error.message));
    }
  }

  // One study, or two side by side.
  async open(names) {
    this.opened = [...new Set(names)];
    const wanted = this.opened;
    if (!this.report.childElementCount) put(this.report, h("p", { class: "quiet", role: "status" }, "reading the tables"));
    try {
      const found = await Promise.all(wanted.map((name) => ask("race", { name })));
      if (this.opened !== wanted) return; // others were opened meanwhile
      this.report.classList.toggle("beside", found.length > 1);
      const names = [...new Set(found.flatMap(({ attained: { shares } }) => Object.keys(shares)))];
      put(this.report, found.map((study) => h("div", {}, found.length > 1 ? h("h2", {}, study.name) : null,
        attained(study, names), ...study.tables.filter((table) => table.rows.length).map(sortable))));
    } catch (error) {
      put(this.report, h("p", { class: "error" }, error.message));
    }
  }
}

// A table that a click on a column's name sorts: up, then down.
function sortable({ title, columns, rows, note }) {
  const body = h("tbody");
  const fill = (order) => put(body, ...order.map((row) => h("tr", {}, ...row.map((cell) => h("td", {}, cell)))));
  const heads = columns.map((name, i) => {
    const head = h("th", { scope: "col" }, h("button", { type: "button", class: "sort", onclick: () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((each) => each.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const ordered = [...rows].sort((one, other) => compared(one[i], other[i]));
      fill(down ? ordered.reverse() : ordered);
    } }, name));
    return head;
  });
  fill(rows);
  return h("section", {}, h("h2", {}, title),
    h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": title },
      h("table", {}, h("thead", {}, h("tr", {}, ...heads)), body)),
    note ? h("p", { class: "quiet" }, note) : null);
}

const numeral = (cell) => (cell.startsWith("inf") ? Infinity : parseFloat(cell));

// Numbers by size, words by the alphabet, and words behind numbers.
function compared(one, other) {
  const [a, b] = [numeral(one), numeral(other)];
  if (Number.isNaN(a) && Number.isNaN(b)) return one.localeCompare(other);
  if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) ? 1 : -1;
  return a === b ? 0 : a - b;
}

// Accuracy against evaluations; pointing at a name draws its line over the others. `all`: who has a colour, the same in
// each study.
function attained({ name, attained: { evaluations, shares } }, all) {
  const names = Object.keys(shares);
  if (!names.length) return null;
  const plot = new Plot(`plot-attained-${name}`, "Share of trials and targets reached");
  const colourOf = (i) => (i < COLOURS ? `var(--sweep-${Math.round((i * (COLOURS - 1)) / Math.max(1, Math.min(all.length, COLOURS) - 1))})` : "var(--quiet)");
  const lines = names.map((who) => ({ xs: evaluations, ys: shares[who], kind: "model", colour: colourOf(all.indexOf(who)) }));
  const x = { label: "evaluations", log: true, min: Math.max(1, evaluations[0]), max: 1.1 * evaluations.at(-1) };
  plot.draw({ x, y: { label: "share reached", min: 0, max: 1 }, points: [], lines }, WIDTH, HEIGHT);
  const entry = (who, i) => {
    const [show, hide] = [() => plot.preview([lines[i]]), () => plot.preview([])];
    const button = h("button", { type: "button", class: "racer", onpointerenter: show, onfocus: show, onpointerleave: hide, onblur: hide },
      `${who} ${(100 * shares[who].at(-1)).toFixed(0)} %`);
    button.style.borderLeftColor = lines[i].colour; // by hand: the page allows no style attribute
    return h("li", {}, button);
  };
  return h("section", {}, h("h2", {}, "Accuracy against evaluations"),
    h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "Accuracy against evaluations" }, plot.svg), h("ul", { class: "racers" }, ...names.map(entry)));
}
