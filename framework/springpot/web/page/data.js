// Data: dropped, chosen, pasted or registered; what was understood of them; what a reader must be told.

import { byId, h, put } from "./dom.js";
import { number } from "./numbers.js";

// How each kind of question is put; the kinds are those of springpot.measurement.Question.
const ASKED = {
  unit: (about) => `the unit of ${about} is `,
  meaning: (about) => `${about} is `,
  column: (about) => `${about} is the column `,
  base: () => "logarithms are to base ",
  constant: (about) => `${about} in all rows is `,
  part: () => "open the part ",
};

const MOST_ANSWERS = 12; // that are read at a glance
const USUAL = new Set(["Pa", "kPa", "MPa", "GPa", "N/m", "N/mm", "kN/m", "kN/mm", "lbf/in"]);

// Sets that every installation has, each an answered page by one click: a mass and a delay that hide, a polymer whose times
// go with the temperature, and a material of more parts than its model has.
const EXAMPLES = [
  ["artificial-hidden", "fractional-maxwell", "A damper with something hidden"],
  ["nist-srm2491", "", "A polymer at six temperatures"],
  ["artificial-fractional-zener-noise1", "kelvin", "A model that is too simple"],
];

function examples(app) {
  return h("div", { class: "examples" }, h("p", {}, h("b", {}, "Try one")), EXAMPLES.map(([set, model, says]) =>
    h("button", { type: "button", class: "primary", "data-example": set, onclick: () => app.openExample(set, model) }, says)));
}

// Columns whose units are asked for with the same answers are asked for at once: storage and loss have one.
function together(asked) {
  const found = [];
  for (const one of asked) {
    const units = one.answers.map(({ answer }) => answer).join();
    const same = one.kind === "unit" && found.find((other) => other.kind === "unit" && other.units === units);
    if (!same) found.push({ ...one, units, answers: one.answers.map((answer) => ({ ...answer })) });
    else {
      same.about += ` and ${one.about}`;
      same.answers.forEach((answer, i) => { answer.said += `,${one.answers[i].said}`; });
    }
  }
  return found;
}

// The usual answers first; of many the others stand apart.
function choices(answers) {
  const option = ({ answer, said }) => h("option", { value: said }, answer);
  if (answers.length <= MOST_ANSWERS) return answers.map(option);
  const usual = answers.filter(({ answer }) => USUAL.has(answer));
  return [h("option", { value: "" }, "choose…"), h("optgroup", { label: "usual" }, usual.map(option)),
    h("optgroup", { label: "all others" }, answers.filter((one) => !usual.includes(one)).map(option))];
}

// As a user types it behind the name of a file: #PART?COLUMN=UNIT,COLUMN=UNIT.
export function choiceOf(said) {
  const parts = said.filter((piece) => piece.startsWith("#"));
  const columns = said.filter((piece) => !piece.startsWith("#"));
  return parts.join("") + (columns.length ? `?${columns.join(",")}` : "");
}

// Where data come from; in the page while it is empty, and in a dialog later.
function dropZone(app, done, place) {
  const id = (name) => `${name}-${place}`;
  const file = h("input", { type: "file", multiple: true, id: id("file"), class: "file", onchange: () => open([...file.files]) });
  const paste = h("textarea", { id: id("paste"), rows: "4", spellcheck: "false", placeholder: "frequency [Hz],storage [kN/m],loss [kN/m]\n1,102.8,73.2\n…" });
  const sets = h("select", { id: id("dataset"), class: "datasets" });
  listSets(sets, app.installed);
  const join = app.state ? h("label", { class: "check" }, h("input", { type: "checkbox", id: id("join") }), " add to the data that are open (a further experiment)") : null;
  const joining = () => Boolean(join?.querySelector("input").checked);
  const open = async (files) => {
    if (!files.length) return;
    done();
    await app.openFiles(files, joining());
  };
  return h("div", { class: "drop-zone", "data-drop": "" },
    h("p", {}, h("b", {}, "Drop a file here"), ", or"),
    h("p", {}, h("label", { for: id("file") }, "choose a file "), file),
    h("p", {}, h("label", { for: id("dataset") }, "or a data set "), sets,
      h("button", { type: "button", onclick: () => { if (sets.value) { done(); app.openSet(sets.value); } } }, "Open set")),
    h("p", {}, h("label", { for: id("paste") }, "or paste a table, with units in its header"), paste,
      h("button", { type: "button", onclick: () => {
        if (!paste.value.trim()) return;
        done();
        app.openFiles([new File([paste.value], "pasted.csv")], joining());
      } }, "Open table")),
    join);
}

function listSets(select, library) {
  const known = library?.datasets || [];
  if (select.length === known.length + 1) return;
  put(select, h("option", { value: "" }, "choose…"),
    known.map((set) => h("option", { value: set.name, disabled: Boolean(set.unavailable), title: set.unavailable || set.summary }, set.name)));
}

export function listenForDrops(app) {
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dragging");
  });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) document.body.classList.remove("dragging"); });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dragging");
    const files = [...event.dataTransfer.files];
    if (!files.length) return;
    byId("open-dialog").close();
    if (app.state && !/\.json$/i.test(files[0].name)) askWhere(app, files);
    else app.openFiles(files, false);
  });
}

// A second file either takes the place of the first or joins it; nobody but the user can know.
function askWhere(app, files) {
  const dialog = byId("open-dialog");
  const open = (onto) => {
    dialog.close();
    app.openFiles(files, onto);
  };
  put(dialog, h("h2", { id: "open-title" }, `Open ${files.map((file) => file.name).join(", ")}`),
    h("p", {}, h("button", { type: "button", class: "primary", onclick: () => open(false) }, "Open instead"), " ",
      h("button", { type: "button", id: "add-data", onclick: () => open(true) }, "Add to the data"), " ",
      h("button", { type: "button", onclick: () => dialog.close() }, "Leave it")));
  dialog.showModal();
}

export function openDialog(app) {
  const dialog = byId("open-dialog");
  put(dialog, h("h2", { id: "open-title" }, "Open data"), dropZone(app, () => dialog.close(), "more"),
    h("p", {}, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
  dialog.showModal();
}

// The ends of a column as they were written: 48, not 48.00.
const plainly = (value) => (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3 ? number(value) : String(Number(value.toPrecision(4))));

export class Data {
  constructor(parent, app) {
    this.parent = parent;
    this.app = app;
    this.zone = h("div", {}, examples(app), dropZone(app, () => {}, "first"));
  }

  render() {
    const { app } = this;
    for (const select of [this.zone.querySelector(".datasets"), ...document.querySelectorAll("dialog .datasets")]) listSets(select, app.installed);
    const parts = [];
    if (app.question) parts.push(this.asking(app.question));
    if (app.data) parts.push(...this.understood(app.data));
    else parts.push(this.zone); // the same one each time: what stands in it is not lost
    put(this.parent, parts);
  }

  // The same form each time: what was chosen in it is not lost.
  asking(question) {
    if (this.asked !== question) this.shownForm = this.form(question);
    this.asked = question;
    return this.shownForm;
  }

  // An open question of the reader: each thing that it cannot know, with the answers that it takes, the usual first.
  form(question) {
    const fields = together(question.asked).map((asked, i) => h("p", {},
      h("label", { for: `asked-${i}` }, ASKED[asked.kind](asked.about)),
      h("select", { id: `asked-${i}`, required: true }, choices(asked.answers))));
    return h("form", { class: "question", id: "question", onsubmit: (event) => {
      event.preventDefault();
      const said = [...event.target.querySelectorAll("select")].map((select) => select.value);
      this.app.openFiles([question.file], question.join, [...question.said, ...said]);
    } }, h("p", {}, question.says.split("; if ")[0]), ...fields, h("button", { class: "primary" }, "Open with these"));
  }

  understood(data) {
    const { state } = this.app;
    const out = state.excluded.length;
    const rows = data.columns.map((column) => h("tr", {}, h("th", { scope: "row" }, column.name),
      h("td", { title: `least ${column.name}` }, plainly(column.from)), h("td", { title: `largest ${column.name}` }, plainly(column.to)), h("td", {}, column.unit)));
    const sweeps = data.scene.sweeps.length;
    const facts = [`${data.scene.count} point${data.scene.count === 1 ? "" : "s"}`, `${sweeps} ${data.scene.words.each}${sweeps === 1 ? "" : "s"}`,
      data.repeats > 1 ? `${data.repeats} repeats` : "", data.deviations ? "standard deviations given" : ""];
    const shown = data.scene.rows.length;
    if (shown < data.scene.count) facts.push(`${shown} of them can be pointed at`);
    return [
      h("p", { id: "facts", title: "rows of the table; sweeps are rows of one temperature, amplitude and step" }, facts.filter(Boolean).join(", "), out ? h("span", {}, `; ${out} left out `,
        h("button", { type: "button", id: "take-back", onclick: () => this.app.leaveOut([]) }, "Take back all")) : ""),
      h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "What was understood of the data" },
        h("table", {}, h("thead", {}, h("tr", {}, ...["column", "from", "to", "unit"].map((word) => h("th", { scope: "col" }, word)))), h("tbody", {}, ...rows))),
      this.chosen(data),
      this.notes(data),
    ];
  }

  // Rows chosen by temperature, amplitude or step: what is not ticked is left out.
  chosen(data) {
    const groups = [...data.levels, ...data.runs.filter((run) => data.levels.every((level) => level.rows.join() !== run.rows.join()))];
    if (!groups.length) return null;
    const out = new Set(this.app.state.excluded);
    const open = (event) => { this.choosing = event.target.open; };
    return h("details", { open: this.choosing, ontoggle: open }, h("summary", { id: "choose-rows" }, "Choose rows"), ...groups.map((group, i) => {
      const left = group.rows.filter((row) => out.has(row)).length;
      const box = h("input", { type: "checkbox", id: `rows-${i}`, checked: left < group.rows.length, onchange: () => {
        const next = new Set(this.app.state.excluded);
        for (const row of group.rows) if (box.checked) next.delete(row); else next.add(row);
        this.app.leaveOut([...next].sort((a, b) => a - b));
      } });
      return h("label", { class: "check" }, box, ` ${group.name} (${group.rows.length})`);
    }));
  }

  notes(data) {
    const entries = Object.entries(data.provenance);
    const parts = data.parts.length > 1 ? [["parts", data.parts.map((part) => `#${part.number} ${part.name}`).join(", ")]] : [];
    if (!entries.length && !parts.length) return null;
    return h("details", {}, h("summary", {}, "Where they come from"),
      h("dl", {}, ...[...parts, ...entries].flatMap(([key, value]) => [h("dt", {}, key), h("dd", {}, value)])));
  }
}
