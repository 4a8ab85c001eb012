// The second page: studies that race optimisers, how far they are, and their tables.

import { ask } from "./api.js";
import { download, h, put } from "./dom.js";

const AGAIN = 2000; // ms between looks at what is running

export class Race {
  constructor(parent) {
    this.parent = parent;
    this.list = h("div", { id: "studies", "aria-live": "polite" });
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
    put(this.list, h("table", {}, h("thead", {}, h("tr", {}, ...["study", "cells", "trials done", "failed", "started", "", ""].map((word) => h("th", { scope: "col" }, word)))),
      h("tbody", {}, ...found.map((study) => h("tr", {}, h("th", { scope: "row" }, study.name),
        ...(study.says ? [h("td", { colspan: "6" }, study.says)] : this.row(study)))))));
    if (this.opened) this.open(this.opened);
  }

  row(study) {
    const done = h("td", {}, `${study.done} of ${study.total} `,
      h("progress", { max: study.total, value: study.done, "aria-label": `trials of ${study.name} done` }));
    return [h("td", {}, study.cells), done, h("td", {}, study.failed), h("td", {}, study.started),
      h("td", {}, h("button", { type: "button", onclick: () => this.open(study.name) }, `Tables of ${study.name}`)),
      h("td", {}, h("button", { type: "button", onclick: () => this.take(study.name) }, `Report of ${study.name} (HTML)`))];
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

  async open(name) {
    this.opened = name;
    try {
      const { tables } = await ask("race", { name });
      if (this.opened !== name) return; // another was opened meanwhile
      put(this.report, tables.filter((table) => table.rows.length).map((table) => h("section", {}, h("h2", {}, table.title),
        h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": table.title },
          h("table", {}, h("thead", {}, h("tr", {}, ...table.columns.map((word) => h("th", { scope: "col" }, word)))),
            h("tbody", {}, ...table.rows.map((row) => h("tr", {}, ...row.map((cell) => h("td", {}, cell))))))),
        table.note ? h("p", { class: "quiet" }, table.note) : null)));
    } catch (error) {
      put(this.report, h("p", { class: "error" }, error.message));
    }
  }
}
