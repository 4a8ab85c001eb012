// Everything on the page leaves as a file.

import { byId, download, enable, h, put, usable } from "./dom.js";
import { asPng, standalone } from "./plot.js";

const FILES = [
  ["report", "Report (HTML)", "this page for a colleague: every rung with its previews, without a server", "text/html"],
  ["replay", "Replay (GIF)", "the error falling, for a talk or a message", "image/gif"],
  ["json", "Answer (JSON)", "schema springpot.discovery/2", "application/json"],
  ["curves", "Curves (CSV)", "data, model and every candidate, units in the header", "text/csv"],
  ["data", "Data as used (CSV)", "without what was left out", "text/csv"],
  ["plan", "Plan of the next experiment (CSV)", "to be filled in", "text/csv"],
  ["script", "Python script", "gives the same numbers", "text/x-python"],
  ["command", "Command line", "gives the same answer", "text/plain"],
  ["session", "Session", "springpot workbench FILE.json opens it again", "application/json"],
];
const COPIED = new Set(["script", "command"]);
const PLOTS = [["plot-view", "view"], ["plot-second", "second"], ["plot-residual", "residual"], ["plot-ladder", "ladder"]];

export function leaveDialog(app) {
  const dialog = byId("leave-dialog");
  const says = h("p", { class: "error", role: "alert" });
  const shown = h("pre", { id: "command-line", tabindex: "0" });
  const done = h("p", { class: "quiet", role: "status", id: "done" });
  // Why a file cannot be had: a button that only fails when it is pressed keeps that to itself.
  const lacks = (kind) => (kind === "plan" && !app.answer.proposed ? "no further measurement is proposed here" : "");
  const leaving = (kind, name, type) => {
    const button = h("button", { type: "button", "data-leave": kind, onclick: () => { if (usable(button)) away(() => app.leaveWith(kind, type)); } }, name);
    enable(button, lacks(kind));
    return button;
  };
  const away = async (action) => {
    says.textContent = "";
    done.textContent = "";
    try {
      const { name, link } = await action();
      put(done, link || document.createTextNode(`${name} is saved.`));
      link?.focus();
    } catch (error) {
      says.textContent = error.message;
    }
  };
  const saved = (name, content, type) => ({ name, link: download(name, content, type) });
  const copy = (kind, what) => h("button", { type: "button", "data-copy": kind, "aria-label": `copy the ${what}`, onclick: async () => {
    try {
      await navigator.clipboard.writeText((await app.textOf(kind)).text);
      done.textContent = `The ${what} is on the clipboard.`;
    } catch (error) {
      says.textContent = error.message;
    }
  } }, "Copy");
  const files = FILES.map(([kind, name, what, type]) => h("li", {},
    leaving(kind, name, type), " ",
    COPIED.has(kind) ? copy(kind, name.toLowerCase()) : null, ` ${what}`));
  const plots = PLOTS.filter(([id]) => byId(id) && !byId(id).hasAttribute("hidden") && byId(id).childElementCount).map(([id, name]) => h("li", {}, `${name}: `,
    h("button", { type: "button", "data-leave": `${id}-svg`, onclick: () => away(() => saved(`${app.stem}-${name}.svg`, standalone(byId(id)), "image/svg+xml")) }, `${name} as SVG`), " ",
    h("button", { type: "button", "data-leave": `${id}-png`, onclick: () => away(async () => saved(`${app.stem}-${name}.png`, await asPng(byId(id)))) }, `${name} as PNG`)));
  put(dialog, h("h2", { id: "leave-title" }, "Leave with it"), h("ul", { class: "files" }, ...files),
    h("h3", {}, "Plots"), h("ul", { class: "files" }, ...plots), h("h3", {}, "The same on the command line"), shown, done, says,
    h("p", {}, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
  dialog.showModal();
  app.textOf("command").then(({ text }) => { shown.textContent = text; }, (error) => { says.textContent = error.message; });
}
