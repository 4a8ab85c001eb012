// What to measure next: where the rivals part, the plan as a table, and new data to break the tie.

import { h, put } from "./dom.js";
import { number, pretty } from "./numbers.js";

// Why nothing is proposed.
function nothing({ discovery }, scene) {
  const rivals = discovery.diagnosis.leading;
  if (!scene.views || rivals.length < 2) return "Nothing is open that another measurement would decide.";
  return `These tests do not tell ${rivals.join(", ")} apart, and no test is known that would.`;
}

export class Next {
  constructor(parent, app) {
    this.parent = parent;
    this.app = app;
  }

  render() {
    const { answer, looks } = this.app;
    const proposed = answer?.proposed;
    if (answer?.discovery.verdict === "sought") {
      put(this.parent);
      return;
    }
    if (!proposed) {
      put(this.parent, h("p", { class: "quiet" }, answer ? nothing(answer, this.app.scene) : "What to measure next is told here."));
      return;
    }
    if (!proposed.separates.length && !this.app.scene.views) {
      put(this.parent, h("p", {}, pretty(proposed.says)),
        h("p", { class: "bar" }, h("button", { type: "button", id: "plan", onclick: () => this.app.leaveWith("plan") }, "Plan as CSV")));
      return;
    }
    const open = answer.discovery.diagnosis.next_experiment ? null
      : h("p", { id: "still-open" }, `What was accepted is one of ${proposed.separates.join(" and ")} still, until this is measured:`);
    const again = this.app.watch?.watching ? null : h("button", { type: "button", onclick: () => this.app.openMore() }, "Add its data");
    // A further test in time is told in words; what is to be filled in is a table of frequencies.
    if (this.app.scene.views) {
      put(this.parent, open, h("p", {}, pretty(proposed.says)), h("p", { class: "bar" }, again));
      return;
    }
    const drawable = answer.next?.rivals.length === 2;
    const box = h("input", { type: "checkbox", id: "show-plan", checked: Boolean(looks.plan), disabled: !drawable,
      onchange: () => this.app.look({ plan: box.checked ? 1 : 0 }) });
    put(this.parent, open,
      h("p", { title: `${proposed.separates.join(" and ")} part by ${number(proposed.expected_separation_sigma, 2)} standard deviations of the noise` }, pretty(proposed.says)),
      h("p", { class: "bar" },
        h("label", { class: "check" }, box, drawable ? " draw both rivals" : " rivals cannot be drawn for another specimen"),
        h("button", { type: "button", id: "plan", onclick: () => this.app.leaveWith("plan") }, "Plan as CSV"),
        again));
  }
}
