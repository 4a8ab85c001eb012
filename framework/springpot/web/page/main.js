// The page: what is open, what was accepted, what is being computed; each panel draws its part of it.

import * as api from "./api.js";
import { Compare, verdict } from "./compare.js";
import { Data, listenForDrops, openDialog } from "./data.js";
import { byId, download, enable, usable } from "./dom.js";
import { History } from "./history.js";
import { Ladder } from "./ladder.js";
import { leaveDialog } from "./leave.js";
import { Missing } from "./missing.js";
import { ModelPanel } from "./model.js";
import { Next } from "./next.js";
import { percent } from "./numbers.js";
import { range } from "./plot.js";
import { Race } from "./race.js";

const SAVED = "springpot-session";
const PULSE = 5000; // ms between looks whether the server is still there
const LOOKS = { view: "storage-loss", plane: "stiffness", plan: 0 };

const ERROR = "error: root mean square of |K - K_model| / |K_model| over all points; noise floor: the error that noise alone leaves";

class App {
  constructor() {
    this.known = new Map(); // data by digest
    this.answers = new Map(); // answers by state
    this.history = new History();
    this.looks = { ...LOOKS };
    this.hovered = null;
    this.edited = null;
    this.busy = null;
    this.panels = [
      (this.data_ = new Data(byId("data-body"), this)),
      (this.model = new ModelPanel(byId("model-body"), this)),
      (this.compare = new Compare(byId("compare-body"), this)),
      (this.ladder = new Ladder(byId("ladder-body"), this)),
      (this.missing = new Missing(byId("missing-body"), this)),
      (this.next = new Next(byId("next-body"), this)),
    ];
    this.race = new Race(byId("race"));
  }

  get state() { return this.history.state; }

  get data() { return this.state ? this.known.get(this.state.data) : null; }

  get scene() { return this.data?.scene || null; }

  // The answer to the present state; while it is being computed, the last one that there was.
  get answer() {
    if (!this.state) return null;
    const found = this.answers.get(JSON.stringify(this.state));
    if (found) this.last = found;
    return this.last?.state.data === this.state.data ? this.last : null;
  }

  get steps() { return this.answer?.discovery.steps || []; }

  get rung() { return this.steps.length - 1; }

  get beside() {
    const branch = this.history.beside;
    if (!branch) return null;
    const state = branch.states[branch.at];
    const found = this.answers.get(JSON.stringify(state));
    return found && state.data === this.state.data ? { ...found, branch: branch.name } : null;
  }

  get stem() {
    const name = (this.data?.source || "data").split(/[\\/]/).pop();
    return name.replace(/[?#@].*$/, "").replace(/\.\w+$/, "") || "data";
  }

  render() {
    const { answer, data } = this;
    byId("data-name").textContent = data ? data.scene.name : "";
    document.title = data ? `${data.scene.name} – springpot workbench` : "springpot workbench";
    document.body.classList.toggle("empty", !data);
    byId("refused").hidden = !this.refused;
    byId("refused").textContent = this.refused || "";
    let word = "Open data to see where a model fails and what is missing from it.";
    if (data) word = this.refused ? "These data have no answer yet: see what is said above." : "";
    byId("verdict").textContent = answer ? verdict(answer) : word;
    byId("verdict").title = answer ? ERROR : "";
    byId("verdict").className = answer ? `verdict ${answer.discovery.verdict}` : "quiet";
    enable(byId("undo"), this.history.canUndo ? "" : "there is nothing to undo");
    enable(byId("redo"), this.history.canRedo ? "" : "there is nothing to redo");
    enable(byId("leave"), answer ? "" : "there is nothing to leave with yet");
    // Panels make their elements anew: what had the focus has it still.
    const focused = document.activeElement?.id;
    for (const panel of this.panels) panel.render();
    this.compare.fill();
    if (focused && document.activeElement === document.body) byId(focused)?.focus();
  }

  save() {
    const session = { ...this.history.toJSON(), view: this.looks };
    sessionStorage.setItem(SAVED, JSON.stringify(session));
  }

  // ---- data -------------------------------------------------------------------------------------------------

  // `said`: what was answered to the reader's questions, such as "storage=kPa" or "#2".
  async openFile(name, bytes, said = [], onto = false) {
    this.question = null;
    const query = { name, choice: choiceOf(said), ...(onto && this.state ? { onto: this.state.data } : {}) };
    const found = await this.compute((how) => api.upload(bytes, query, how));
    if (found?.question) this.ask({ ...found.question, name, bytes, said, onto });
    else if (found) this.opened(found, onto);
  }

  ask(question) {
    this.question = question;
    this.render();
    byId("question").querySelector("select").focus();
  }

  // Several files are one test: time signals of one frequency each, or one sweep each.
  async openFiles(files, join) {
    if (files.length === 1) {
      await this.openFile(files[0].name, await files[0].arrayBuffer(), [], join);
      return;
    }
    let onto = join ? this.state.data : "";
    let found = null;
    for (const { name, bytes } of await Promise.all(files.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })))) {
      const query = { name, ...(onto ? { onto } : {}) };
      found = await this.compute((how) => api.upload(bytes, query, how));
      if (found?.question) this.refused = `${found.question.says} (open it alone to be asked)`;
      if (!found || found.question) {
        this.render();
        return;
      }
      onto = found.digest;
    }
    this.opened(found, join);
  }

  async openSet(name) {
    const found = await this.compute((how) => api.upload(new Uint8Array(), { dataset: name }, how));
    if (found) this.opened(found);
  }

  openMore() {
    openDialog(this);
    const join = byId("open-dialog").querySelector("input[type=checkbox]");
    if (join) join.checked = true;
  }

  // The model and what was accepted stay when further data join; other data begin a ladder of their own.
  async opened(found, onto = false) {
    this.question = null;
    this.known.set(found.digest, found);
    if (found.session) {
      this.history = new History(found.session);
      this.look({ ...LOOKS, ...found.session.view }, false);
    } else {
      const before = this.state || { model: this.startModel || "", accepted: [], seed: 0 };
      const excluded = onto && this.state ? this.state.excluded : [];
      this.history.push({ ...before, data: found.digest, accepted: onto ? before.accepted : [], excluded });
    }
    this.ranking = null;
    this.master = null;
    await this.arrive();
  }

  leaveOut(excluded) {
    this.step({ ...this.state, excluded });
  }

  // ---- the ladder -------------------------------------------------------------------------------------------

  judge(model) {
    if (this.data) this.step({ ...this.state, model, accepted: [] });
  }

  accept(effect) { this.step({ ...this.state, accepted: [...this.state.accepted, effect] }); }

  goTo(rung) { this.step({ ...this.state, accepted: this.state.accepted.slice(0, rung) }); }

  remove(i) { this.step({ ...this.state, accepted: this.state.accepted.filter((_, j) => j !== i) }); }

  step(state) {
    this.history.push(state);
    this.arrive();
  }

  undo() { this.history.undo(); this.arrive(); }

  redo() { this.history.redo(); this.arrive(); }

  fork(rung) { this.history.fork(rung); this.arrive(); }

  select(i) { this.history.at = i; this.arrive(); }

  drop(i) { this.history.drop(i); this.arrive(); }

  // Show the present state: at once if its answer is here, else after asking for it.
  async arrive() {
    this.hovered = null;
    this.refused = "";
    this.save();
    const { state } = this;
    if (!state) return;
    if (!this.known.has(state.data)) {
      const found = await this.compute((how) => api.ask("again", { state }, how));
      if (!found) return;
      this.known.set(found.digest, found);
    }
    const key = JSON.stringify(state);
    this.render();
    if (this.answers.has(key)) {
      this.busy?.abort();
      return;
    }
    const found = await this.compute((how) => api.ask("answer", { state }, how));
    if (!found) {
      this.retreat(state);
      return;
    }
    this.answers.set(key, found);
    this.render();
    if (this.history.beside) this.fetchBeside();
    if (this.looks.view === "master-curve") this.look({});
  }

  // A model or effect that was refused is not where one is; data that were opened are, also without an answer.
  retreat(state) {
    if (!this.refused || this.state !== state || !this.history.canUndo) return;
    this.history.undo();
    if (this.state.data !== state.data || !this.answers.has(JSON.stringify(this.state))) this.history.redo();
    this.save();
    this.render();
  }

  async fetchBeside() {
    const branch = this.history.beside;
    const state = branch?.states[branch.at];
    if (!state || this.answers.has(JSON.stringify(state)) || !this.known.has(state.data)) return;
    const found = await this.compute((how) => api.ask("answer", { state }, how));
    if (found) {
      this.answers.set(JSON.stringify(state), found);
      this.render();
    }
  }

  // One computation at a time: a newer one takes the place of an older one, which is ended.
  async compute(action) {
    this.busy?.abort();
    const control = new AbortController();
    this.busy = control;
    this.refused = "";
    const begun = performance.now();
    let stage = "computing";
    const told = () => { byId("stage").textContent = `${stage}, ${((performance.now() - begun) / 1000).toFixed(1)} s`; };
    const clock = setInterval(told, 100);
    byId("work").hidden = false;
    document.body.setAttribute("aria-busy", "true");
    told();
    this.render();
    try {
      return await action({ signal: control.signal, told: (text) => { stage = text; told(); } });
    } catch (error) {
      if (error.name !== "AbortError") this.refused = error.message;
      return null;
    } finally {
      clearInterval(clock);
      if (this.busy === control) {
        this.busy = null;
        byId("work").hidden = true;
        document.body.removeAttribute("aria-busy");
        this.render();
      }
    }
  }

  // What was not computed is not where one is: the page goes back to the last state with an answer.
  cancel() {
    this.busy?.abort();
    if (this.history.canUndo && !this.answers.has(JSON.stringify(this.state))) this.undo();
  }

  // ---- previews and looks -----------------------------------------------------------------------------------

  hover(effect) {
    this.hovered = effect;
    this.compare.preview(effect);
    this.ladder.preview(effect);
    this.missing.show(effect);
  }

  async look(change, save = true) {
    Object.assign(this.looks, change);
    if (save) this.save();
    if (this.looks.view === "master-curve" && this.state && this.master?.of !== JSON.stringify(this.state)) {
      const { state } = this;
      const found = await this.compute((how) => api.ask("mastercurve", { state: { ...state, model: "", accepted: [] } }, how));
      if (!found) {
        const { refused } = this;
        this.looks.view = "storage-loss";
        this.refused = refused;
      } else this.master = { ...found, of: JSON.stringify(state), data: state.data };
    }
    this.render();
  }

  get hasMaster() { return Boolean(this.master) && this.master.data === this.state?.data; }

  // The sweeps laid over one another by their factors, against reduced frequency.
  masterSpec() {
    const { scene, master } = this;
    const factors = new Map(master.curve.levels.map((level) => [level.value, level]));
    const points = scene.rows.flatMap((row, i) => {
      const here = scene.conditions[master.column][i];
      const nearest = [...factors.keys()].reduce((a, b) => (Math.abs(b - here) < Math.abs(a - here) ? b : a));
      const { a, b = 1 } = factors.get(nearest);
      const colour = `var(--sweep-${Math.round((8 * scene.sweep[i]) / Math.max(1, scene.sweeps.length - 1))})`;
      const x = (scene.omega[i] / 2 / Math.PI) * a;
      const out = this.state.excluded.includes(row);
      return [{ x, y: scene.storage[i] / b, kind: "storage", row, colour, out }, { x, y: scene.loss[i] / b, kind: "loss", row, colour, out }];
    });
    const x = { label: "reduced frequency a f [Hz]", log: true };
    const y = { label: `K'/b, K''/b [${scene.units.stiffness}]`, log: true };
    [x.min, x.max] = range(points.map((point) => point.x), true, 0.03);
    [y.min, y.max] = range(points.map((point) => point.y), true, 0.1);
    return { x, y, points, lines: [], upright: true };
  }

  // ---- parameters by hand -----------------------------------------------------------------------------------

  setEdited(edited) {
    this.edited = edited;
    if (this.compare.main.spec && this.scene) this.compare.drawBeside();
  }

  // The newest position of a slider wins; those between are never asked for.
  async drawByHand(hands) {
    this.wanted = hands;
    if (this.drawing) return;
    this.drawing = true;
    try {
      while (this.wanted) {
        const asked = this.wanted;
        this.wanted = null;
        const found = await api.ask("curve", { state: this.answer.state, hands: asked });
        this.setEdited(found);
        this.model.says(`edited: error ${percent(found.error)}`);
      }
    } catch (error) {
      this.model.says(error.message);
    } finally {
      this.drawing = false;
    }
  }

  async fitByHand(hands) {
    const { answer } = this;
    const found = await this.compute((how) => api.ask("held", { state: answer.state, hands }, how));
    if (!found) return;
    this.model.take(found.values);
    this.setEdited(found);
    this.model.says(`fitted within these: error ${percent(found.error)}`);
  }

  async rankModels() {
    if (!usable(this.model.rank)) return;
    const found = await this.compute((how) => api.ask("ranking", { state: { ...this.state, model: "", accepted: [] } }, how));
    if (found) {
      this.ranking = found;
      this.render();
    }
  }

  // ---- leaving ----------------------------------------------------------------------------------------------

  textOf(kind) {
    return api.ask("leave", { state: this.state, kind });
  }

  // The file's name, and a link where the browser wants one more click.
  async leaveWith(kind, type = "text/csv") {
    const { name, text } = await this.fileOf(kind);
    return { name, link: download(name, text, type) };
  }

  async fileOf(kind) {
    if (kind === "json") return { name: `${this.stem}.json`, text: JSON.stringify(this.answer.discovery, null, 2) };
    if (kind !== "session") return this.textOf(kind);
    const { text, source, joined } = this.data;
    const session = { schema: "springpot.session/1", data: { source, joined, text }, ...this.sessionOfTheseData(), view: this.looks };
    return { name: `${this.stem}-session.json`, text: JSON.stringify(session) };
  }

  // Of the history only what was done with the data that are open: a session file holds one set.
  sessionOfTheseData() {
    const { data } = this.state;
    const branches = this.history.branches.map((branch) => {
      const states = branch.states.filter((state) => state.data === data);
      const at = states.indexOf(branch.states[branch.at]);
      return { ...branch, states, at: at < 0 ? states.length - 1 : at };
    });
    return { branches: branches.filter((branch) => branch.states.length), branch: this.history.at };
  }

  // ---- begin ------------------------------------------------------------------------------------------------

  async begin() {
    this.render();
    const saved = sessionStorage.getItem(SAVED);
    api.installed().then((found) => {
      this.installed = found;
      this.model.complete();
      this.model.list();
      this.render();
    }).catch((error) => { this.refused = error.message; this.render(); });
    if (saved) {
      const session = JSON.parse(saved);
      this.history = new History(session);
      Object.assign(this.looks, session.view);
      if (this.state) {
        await this.arrive();
        return;
      }
    }
    const given = await this.compute(() => api.start());
    this.startModel = given?.model || "";
    this.model.input.value = this.startModel;
    if (given?.data?.error) {
      this.refused = given.data.error;
      this.render();
    } else if (given?.data?.result.question) {
      const { name, content } = given.data.result.question;
      const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
      this.ask({ ...given.data.result.question, name, bytes, said: [], onto: false });
    } else if (given?.data) await this.opened(given.data.result);
  }
}

// As a user types it behind the name of a file: #PART?COLUMN=UNIT,COLUMN=UNIT.
function choiceOf(said) {
  const parts = said.filter((piece) => piece.startsWith("#"));
  const columns = said.filter((piece) => !piece.startsWith("#"));
  return parts.join("") + (columns.length ? `?${columns.join(",")}` : "");
}

function listen(app) {
  const on = (id, action) => byId(id).addEventListener("click", (event) => { if (usable(event.currentTarget)) action(); });
  on("undo", () => app.undo());
  on("redo", () => app.redo());
  on("open-data", () => openDialog(app));
  on("leave", () => leaveDialog(app));
  on("cancel", () => app.cancel());
  on("theme", () => {
    const dark = getComputedStyle(document.documentElement).colorScheme === "dark";
    document.documentElement.dataset.theme = dark ? "light" : "dark";
    localStorage.setItem("springpot-theme", document.documentElement.dataset.theme);
  });
  const show = (race) => {
    byId("bench").hidden = race;
    byId("race").hidden = !race;
    byId("tab-bench").setAttribute("aria-pressed", String(!race));
    byId("tab-race").setAttribute("aria-pressed", String(race));
    if (race) app.race.show();
    else app.race.hide();
  };
  on("tab-bench", () => show(false));
  on("tab-race", () => show(true));
  document.addEventListener("keydown", (event) => {
    const typing = /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName) && event.target.type !== "range" && event.target.type !== "checkbox";
    if (typing) return;
    const key = event.key.toLowerCase();
    if ((event.ctrlKey || event.metaKey) && key === "z") {
      if (event.shiftKey) app.redo();
      else app.undo();
    } else if ((event.ctrlKey || event.metaKey) && key === "y") app.redo();
    else if (event.key === "/") app.model.openSearch();
    else return;
    event.preventDefault();
  });
  const lost = byId("lost");
  document.addEventListener("lost", () => {
    lost.hidden = false;
    lost.textContent = "The server has gone; what is on the page stays. Start 'springpot workbench' again to go on.";
  });
  setInterval(() => { if (!document.hidden) api.alive().then(() => { lost.hidden = true; }).catch(() => {}); }, PULSE);
  listenForDrops(app);
}

api.takeToken();
const theme = localStorage.getItem("springpot-theme");
if (theme) document.documentElement.dataset.theme = theme;
const app = new App();
listen(app);
app.begin();
