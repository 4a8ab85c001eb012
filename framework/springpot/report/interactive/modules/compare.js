// Data and model side by side: a view, a residual plane below it on the same axis, one cursor and one brush for all.

import { FINGER, h, put } from "./dom.js";
import { capital, percent, pretty } from "./numbers.js";
import { inBrief, lights, modelled, signOf, spotOf } from "./spots.js";
import { claimed } from "./hero.js";
import { Plot, range } from "./plot.js";
import { hint, listen, said } from "./pointing.js";
import { othersOf, planeLines, planeOf, planeSpec, viewLines, viewOf, viewSpec, viewsOf } from "./views.js";
import { DESK, Zoom } from "./zoom.js";

const STEPS = [
  "Open a table of storage and loss against frequency, time signals, or a data set.",
  "Name a model, or none: then any linear passive material is judged.",
  "See where it fails, and by how much more than the noise.",
  `${FINGER.matches ? "Tap" : "Point at"} an effect: the dashed curve shows what it would do. Accept it, and watch the error fall.`,
  "Leave with a report, a script, the numbers; or measure what decides between the rivals.",
];
const NARROW = 500; // px below which a plot is that of a phone
const HEIGHTS = { phone: [200, 120], desk: [300, 150] }; // px of the picture and of the residual below it
const MOST_PLACES = 3; // sentences below the picture: more would leave it no room
const MOST_NOTES = 2;
const WIDE = 560; // px from which a second picture stands beside the first, not below it
const BETWEEN = 8; // px between the two
const SHORT = 220; // px of the picture below which the sentences under it are short
const LEAST = 140; // px between which the picture grows and shrinks with the window
const MOST = 480;

export class Compare {
  // `failing`: where the sentences stand that say where the model fails.
  constructor(parent, app, failing) {
    this.parent = parent;
    this.app = app;
    this.main = new Plot("plot-view", "Data and model");
    this.second = new Plot("plot-second", "Data and model, seen another way");
    this.residual = new Plot("plot-residual", "Residual");
    this.plots = [this.main, this.second, this.residual];
    this.chosen = new Set();
    this.row = null;
    this.hidden = new Set(); // what was taken out of the picture by its entry in the legend
    this.zoom = new Zoom(this.main, () => this.render());
    this.view = h("select", { id: "view", "aria-label": "View", onchange: () => { this.zoom.ends = null; app.look({ view: this.view.value }); } });
    this.other = h("select", { id: "second", "aria-label": "Second view", title: "another view beside it", onchange: () => app.look({ second: this.other.value }) });
    this.plane = h("select", { id: "plane", "aria-label": "Residual plane", onchange: () => app.look({ plane: this.plane.value }) });
    this.column = h("select", { id: "column", "aria-label": "Residual along", title: "what the residual is drawn along", onchange: () => app.look({ column: this.column.value }) });
    this.scales = ["x", "y"].map((axis) => h("button", { type: "button", id: `log-${axis}`, class: "small", title: `logarithmic ${axis} axis`, onclick: () => this.bend(axis) }, `log ${axis}`));
    this.sigmas = h("button", { type: "button", id: "sigmas", class: "small", title: "residual in standard deviations of the noise, or in the plane's own unit", onclick: () => app.look({ sigmas: app.looks.sigmas ? 0 : 1 }) }, "σ");
    this.closer = [["+", "closer (or the wheel)", 1.5], ["−", "farther", 1 / 1.5]].map(([sign, title, factor]) =>
      h("button", { type: "button", class: "small", title, "aria-label": title, onclick: () => this.zoom.by(factor) }, sign));
    this.whole = h("button", { type: "button", id: "whole", class: "small", title: "all of it again (or a double click)", onclick: () => this.zoom.reset() }, "whole");
    this.key = h("div", { id: "key", class: "legend", role: "group", "aria-label": "Legend: press an entry to hide it" });
    this.readout = h("p", { id: "readout", class: "quiet", role: "status" });
    this.places = h("ul", { id: "places", class: "places" });
    this.exclude = h("button", { type: "button", id: "exclude", hidden: true, onclick: () => this.toggle([...this.chosen]),
      onpointerenter: () => { if (app.answer?.previews[this.exclude.textContent]) app.hover(this.exclude.textContent); }, onpointerleave: () => app.hover(null) });
    this.frames = h("div", { class: "plots" }, this.main.svg, this.second.svg, this.residual.svg);
    this.bar = h("div", { class: "bar" }, this.view, this.other, this.plane, this.column, h("span", { class: "group" }, this.sigmas, this.scales), h("span", { class: "group" }, this.closer, this.whole), this.exclude);
    // Beside pictures that stay in sight where the page is scrolled; what the strip above them says too.
    this.now = h("p", { id: "now", "aria-hidden": "true" });
    this.spots = [];
    this.intro = h("ol", { class: "intro" }, ...STEPS.map((step) => h("li", {}, step)));
    put(parent, this.intro, this.bar, this.key, this.now, this.frames, this.readout);
    put(failing, this.places);
    for (const plot of this.plots) listen(plot, this);
    this.residual.means = (place) => this.mean(place);
    new ResizeObserver(() => this.resized()).observe(this.frames);
    const column = parent.closest(".column");
    if (column) new ResizeObserver(() => this.fill()).observe(column);
  }

  resized() {
    const width = Math.floor(this.frames.clientWidth);
    if (width > 0 && width !== this.width) {
      this.width = width;
      this.render();
    }
  }

  render() {
    const { scene, answer, state, looks } = this.app;
    this.intro.hidden = Boolean(scene);
    this.bar.hidden = !scene;
    this.frames.toggleAttribute("data-empty", !scene);
    if (!scene || !state || !this.width) return;
    if (this.drawn !== scene) {
      // What was pointed at or chosen are rows of the data before.
      this.row = null;
      this.chosen = new Set();
      // What has only grown is looked at as before.
      if (!scene.fresh) {
        this.hidden = new Set();
        this.zoom.ends = null;
      }
      put(this.view, Object.entries(viewsOf(scene)).map(([name, view]) => h("option", { value: name }, view.name)),
        this.app.fixed || scene.views ? null : Object.entries(this.app.asked.views).map(([name, view]) => h("option", { value: name }, view.name)));
      put(this.other, h("option", { value: "" }, "One view"), Object.entries(viewsOf(scene)).map(([name, view]) => h("option", { value: name }, `and ${view.name}`)));
      put(this.plane,
        Object.keys(scene.planes).map((name) => h("option", { value: name }, capital(scene.planes[name].name))),
        h("option", { value: "none" }, "No residuals"));
      put(this.column, [["", scene.axis.column], ...othersOf(scene)].map(([name, text]) => h("option", { value: name }, text)));
      this.column.hidden = Boolean(scene.views);
    }
    this.drawn = scene;
    const excluded = new Set(state.excluded);
    const plane = planeOf(scene, looks.plane);
    this.plane.value = plane;
    this.column.value = othersOf(scene).some(([name]) => name === looks.column) ? looks.column : "";
    this.plane.title = scene.planes[plane]?.shows || "";
    const phone = this.width < NARROW;
    const [tall, low] = phone ? HEIGHTS.phone : [this.tall || HEIGHTS.desk[0], HEIGHTS.desk[1]];
    const asked = this.asked;
    for (const option of this.view.options) if (this.app.asked?.views[option.value]) option.disabled = !this.app.asked.can(option.value);
    const view = viewOf(scene, looks.view);
    this.view.value = this.app.asked?.views[looks.view] && !scene.views ? looks.view : view;
    const shown = answer && answer.state.data === state.data ? answer : null;
    const spec = asked ? this.app.asked.spec(asked) : viewSpec(view, scene, excluded, shown?.model, looks.linear);
    this.told(spec);
    this.main.title = (asked ? this.app.asked.views[asked] : viewsOf(scene)[view]).name;
    this.planned(spec);
    this.without(spec);
    this.zoom.limit(spec);
    this.main.draw(spec, this.drawSecond(scene, excluded, shown, tall), tall);
    if (scene.fresh?.size) this.main.arrive(scene.fresh);
    setTimeout(() => scene.fresh?.clear()); // drawn again at once, where the words around it leave less room
    // Residuals are of the sweeps as they were measured, not of what is worked out of them.
    const residual = Boolean(shown) && plane !== "none" && !asked;
    this.residual.svg.toggleAttribute("hidden", !residual);
    if (residual) {
      this.residual.title = `${capital(scene.planes[plane].name)}, residual of ${shown.discovery.diagnosis.model}`;
      const { first, before } = this.app;
      const below = planeSpec(plane, scene, excluded, shown, viewsOf(scene)[view], { sigmas: Boolean(looks.sigmas), first: first || shown, before, column: this.column.value });
      this.without(below);
      if (spec.upright && !this.column.value) below.x = { ...spec.x };
      // What the sign means: along the short axis it would be cut, in a corner it would lie over points.
      below.x.label = `${below.x.label}; Δ = data − model`;
      this.residual.draw(below, this.width, low);
      this.residual.fall();
    }
    const { where = [], notes = [] } = shown?.discovery.diagnosis || {};
    const spots = where.map((place, i) => spotOf(place, shown.spots[i], scene));
    this.spots = [];
    this.meant = null;
    if (spec.told) put(this.places, spec.told.map((text) => this.sentence(text)));
    else put(this.places,
      spots.slice(0, MOST_PLACES).map((spot) => {
        const plain = spot.place.plane === plane || scene.views ? "" : ` (${scene.planes[spot.place.plane].name})`;
        return this.sentence(`${signOf(spot)}${modelled(spot)}${plain}`, spot, `${signOf(spot)}${inBrief(spot)}${plain}`);
      }),
      notes.slice(0, MOST_NOTES).map((note) => this.sentence(pretty(`note: ${note}`))));
    this.places.closest("section").hidden = !this.places.childElementCount;
    this.drawBeside();
    this.preview(this.app.hovered);
    this.point(this.row);
    this.selected(this.chosen);
    // On a phone the pictures stay in sight, and what stands above them goes.
    const section = this.parent.closest("section");
    const top = (element) => element.getBoundingClientRect().top;
    const first = this.now.offsetHeight ? this.now : this.frames;
    section?.style.setProperty("--above", `${Math.round(top(first) - top(section))}px`);
  }

  // Draws another view of the same, where one is asked for, and tells the width that it leaves for the first.
  drawSecond(scene, excluded, shown, tall) {
    const { looks } = this.app;
    const name = looks.second in viewsOf(scene) ? looks.second : "";
    this.other.value = name;
    this.other.hidden = this.width < WIDE && !name;
    this.second.svg.toggleAttribute("hidden", !name);
    this.second.spec = null;
    if (!name) return this.width;
    const width = this.width < WIDE ? this.width : Math.floor((this.width - BETWEEN) / 2);
    const spec = viewSpec(name, scene, excluded, shown?.model, looks.linear);
    this.without(spec);
    this.second.title = viewsOf(scene)[name].name;
    this.second.draw(spec, width, tall);
    return width;
  }

  // `shortly`: where the picture would have too little room beside the whole.
  sentence(text, spot = null, shortly = text) {
    const item = h("li", { title: text, class: spot ? "" : "note",
      onpointerenter: () => this.mean(spot?.place), onpointerleave: () => this.mean(null) },
    shortly === text ? text : [h("span", { class: "wholly" }, text), h("span", { class: "shortly" }, shortly)]);
    if (spot) this.spots.push({ ...spot, item });
    return item;
  }

  // A sentence, its bar and the points that both are about light up together, whichever of them is pointed at.
  mean(place) {
    this.meant = this.spots.find((spot) => spot.place === place) || null;
    this.shine();
  }

  shine() {
    const { row, meant, chosen } = this;
    for (const plot of this.plots) if (plot.spec) plot.point(row, chosen, lights(meant, plot.spec));
    for (const spot of this.spots) {
      const lit = meant ? spot === meant : row !== null && spot.rows.has(row);
      spot.item.classList.toggle("lit", lit);
      this.residual.shaded.get(spot.place)?.classList.toggle("lit", lit);
    }
  }

  // The view that the server has worked out, where one is asked for and is there.
  get asked() {
    const { asked, looks } = this.app;
    return asked?.has(looks.view) ? looks.view : "";
  }

  // The view that is drawn: what is asked for, where there is such a one.
  get viewed() {
    return this.asked || viewOf(this.app.scene, this.app.looks.view);
  }

  // The pictures in which curves of models stand, each with its view.
  pictures() {
    const first = this.asked ? [] : [[this.main, this.viewed]];
    return this.second.spec ? [...first, [this.second, this.other.value]] : first;
  }

  // The buttons beside the picture say what it is like: which axes are logarithmic, whether all of it is seen.
  told(spec) {
    const { looks } = this.app;
    for (const [button, axis] of [[this.scales[0], "x"], [this.scales[1], "y"]]) {
      button.hidden = !spec[axis].canBeLog;
      button.setAttribute("aria-pressed", String(!looks.linear.includes(axis)));
    }
    this.sigmas.setAttribute("aria-pressed", String(Boolean(looks.sigmas)));
    this.whole.hidden = !this.zoom.ends;
  }

  bend(axis) {
    const linear = ["x", "y"].filter((one) => this.app.looks.linear.includes(one) !== (one === axis)).join("");
    this.zoom.ends = null;
    this.app.look({ linear });
  }

  // What was pressed in the legend is not drawn: a kind of a single sweep, or one of several sweeps.
  without(spec) {
    const single = this.app.scene.sweeps.length < 2;
    const shown = ({ part, kind, sweep }) => !this.hidden.has(single ? part || kind : `sweep-${sweep}`);
    spec.points = spec.points.filter(shown);
    spec.cloud = spec.cloud?.filter(shown);
    spec.lines = spec.lines.filter((line) => line.sweep === undefined || (shown(line) && !this.hidden.has("model")));
  }

  press(what) {
    if (!this.hidden.delete(what)) this.hidden.add(what);
    this.render();
  }

  entry(what, look, text) {
    return h("button", { type: "button", class: "swatch", "aria-pressed": String(!this.hidden.has(what)), title: "press to hide or show it", onclick: () => this.press(what) },
      h("span", { class: look }, text[0]), text.slice(1));
  }

  // On a desk all stands on one screen: the picture gets the height that the words around it leave.
  fill() {
    const column = this.parent.closest(".column");
    if (this.app.fixed || !this.main.spec || !matchMedia(DESK).matches || !column?.clientHeight) return;
    const last = [...column.children].filter((section) => !section.hidden).at(-1);
    const room = () => {
      const top = column.getBoundingClientRect().top - column.scrollTop;
      return Math.floor((this.tall || HEIGHTS.desk[0]) + column.clientHeight - (last.getBoundingClientRect().bottom - top));
    };
    this.places.classList.remove("brief");
    this.places.classList.toggle("brief", room() < SHORT);
    const tall = Math.max(LEAST, Math.min(MOST, room()));
    if (tall === this.tall) return;
    this.tall = tall;
    this.render();
  }

  // Where the rivals of the next experiment part, with bands of what would be measured.
  planned(spec) {
    const next = this.app.looks.plan ? this.app.answer?.next : null;
    if (!next?.rivals.length || this.asked || !spec.upright || this.app.scene.axis.column !== "frequency") return;
    const view = viewsOf(this.app.scene)[this.viewed];
    const xs = next.frequency.map((hertz) => hertz * this.app.scene.axis.per_hertz);
    const all = [];
    next.rivals.forEach((rival, number_) => {
      view.parts.forEach(({ kind, at }) => {
        const ys = xs.map((x, i) => at(x, rival.storage[i], rival.loss[i])[1]);
        all.push(...ys);
        spec.lines.push({ xs, ys, kind: `rival rival-${number_} ${kind}`, colour: `var(--rival-${number_})` });
        if (this.viewed !== "storage-loss") return;
        const [low, high] = [-1, 1].map((side) => ys.map((y, i) => y + side * rival.width[i]));
        spec.bands = [...(spec.bands || []), { xs, low, high, kind: `rival-${number_}` }];
      });
    });
    [spec.x.min, spec.x.max] = range([...this.app.scene.x, ...xs], spec.x.log, 0.03);
    spec.stations = next.action.omega.map((omega) => (omega / 2 / Math.PI) * this.app.scene.axis.per_hertz);
    // A moving mass makes K' negative, and a resonance makes it huge: what is measured stays in sight.
    const measured = spec.points.map((point) => point.y);
    const most = Math.max(...measured.map(Math.abs));
    if (all.some((y) => y <= 0)) spec.y.log = false;
    const seen = all.map((y) => Math.max(-1.2 * most, Math.min(1.6 * most, y)));
    [spec.y.min, spec.y.max] = range([...measured, ...seen], spec.y.log, 0.06);
  }

  drawBeside() {
    const { scene, looks, answer, edited, beside } = this.app;
    put(this.now, claimed(this.app));
    const entries = [];
    const view = this.viewed;
    const lines = (name) => [[beside?.model, "beside"], [edited, "edited"]].flatMap(([k, role]) => (k ? viewLines(name, scene, k, role) : []));
    for (const [plot, name] of this.pictures()) plot.extra(lines(name));
    if (this.residual.spec) this.residual.extra(this.leftBy(edited, "edited"));
    const { key } = this.main.spec;
    if (key) {
      put(this.key, key.map(([look, text]) => h("span", { class: `swatch ${look}` }, text)));
      return;
    }
    const single = scene.sweeps.length < 2;
    const { symbol } = scene.words;
    if (scene.views) entries.push(this.entry("storage", "storage", "● measured"));
    else if (single) {
      entries.push(this.entry("storage", "storage", viewsOf(scene)[view]?.parts.length === 1 ? "● data" : `● ${symbol}' data`));
      if (view === "storage-loss") entries.push(this.entry("loss", "loss", `□ ${symbol}'' data`));
    } else {
      entries.push(...scene.sweeps.map((sweep, i) =>
        this.entry(`sweep-${i}`, `sweep-${Math.round((8 * i) / (scene.sweeps.length - 1))}`, `● ${sweep.label}`)));
    }
    const { below } = this.main.spec.y;
    if (below) entries.push(h("span", { class: "quiet" }, `${below} not above zero`));
    if (answer && !this.asked) entries.push(this.entry("model", "", `━ ${answer.discovery.diagnosis.model} (accepted)`));
    if (edited) entries.push(h("span", { class: "swatch edited" }, `┈ edited by hand, ${percent(edited.error)}`));
    if (beside) entries.push(h("span", { class: "swatch beside" }, `─ branch ${beside.branch}: ${beside.discovery.diagnosis.model}`));
    if (looks.plan) {
      for (const [i, rival] of (answer?.next?.rivals || []).entries()) {
        entries.push(h("span", { class: `swatch rival-${i}` }, `${i ? "▒" : "░"} ${rival.effect}, as it would be measured`));
      }
    }
    const longest = Object.keys(answer?.previews || {}).reduce((one, other) => (other.length > one.length ? other : one), "");
    const previewed = (name, className) => h("span", { class: className }, `╌ with ${name} (preview)`);
    const { hovered } = this.app;
    if (longest || hovered) entries.push(h("span", { class: "swatch preview" }, previewed(longest, "room"), hovered ? previewed(hovered) : null));
    put(this.key, entries);
  }

  preview(effect) {
    const { scene, answer, looks } = this.app;
    const k = effect && answer ? answer.previews[effect] : null;
    if (!scene || !this.main.spec) return;
    for (const [plot, name] of this.pictures()) plot.preview(k ? viewLines(name, scene, k, "preview") : []);
    if (this.residual.spec) {
      this.residual.preview(this.leftBy(k, "preview"));
    }
    this.drawBeside();
  }

  // What a curve would leave of the residual, in the plane and the unit that are shown.
  leftBy(k, role) {
    const { scene, answer, looks } = this.app;
    const plane = planeOf(scene, looks.plane);
    // Along a column a line through the points would go up and down at each of its levels.
    if (!k || !answer || plane === "none" || !["", "row"].includes(this.column.value)) return [];
    const widths = looks.sigmas ? answer.model.planes[plane].width : null;
    return planeLines(plane, scene, k, viewsOf(scene)[viewOf(scene, looks.view)], { widths, role, column: this.column.value });
  }

  index(row) {
    return this.app.scene.rows.indexOf(row);
  }

  point(row) {
    const { scene, state } = this.app;
    this.row = row;
    this.shine();
    if (row === null || !scene) {
      if (!scene) return;
      this.readout.textContent = hint(this.app.fixed);
      return;
    }
    const i = this.index(row);
    this.readout.textContent = said(this.app, i, this.viewed) + (state.excluded.includes(row) ? "; left out" : "");
  }

  selected(rows) {
    this.chosen = rows;
    const out = this.app.state ? [...rows].filter((row) => this.app.state.excluded.includes(row)).length : 0;
    this.exclude.hidden = rows.size === 0;
    const all = rows.size > 0 && out === rows.size;
    this.exclude.textContent = `${all ? "Take back" : "Leave out"} ${rows.size} point${rows.size === 1 ? "" : "s"}`;
    this.app.chosen?.choose(rows.size ? { name: this.exclude.textContent, excluded: this.toggled([...rows]) } : null);
    this.shine();
  }

  // Points are greyed and left out, or taken back; never deleted.
  toggle(rows) {
    if (this.app.fixed) return;
    const out = this.toggled(rows);
    this.selected(new Set());
    this.app.leaveOut(out);
  }

  // Rows that are left out with these left out too; back again, where all of them were.
  toggled(rows) {
    const out = new Set(this.app.state.excluded);
    const back = rows.every((row) => out.has(row));
    for (const row of rows) {
      if (back) out.delete(row);
      else out.add(row);
    }
    return [...out].sort((a, b) => a - b);
  }
}
