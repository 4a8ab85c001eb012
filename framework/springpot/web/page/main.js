// The page: what is open, what was accepted, what is being computed; each panel draws its part of it.

import * as api from "./api.js";
import { Asked } from "./asked.js";
import { Chosen } from "./chosen.js";
import { Pointed } from "./pointed.js";
import { Compare } from "./compare.js";
import { Data, choiceOf, listenForDrops, openDialog } from "./data.js";
import { byId, download, enable, usable } from "./dom.js";
import { Hands } from "./hands.js";
import { BY_HAND, Hero } from "./hero.js";
import { History } from "./history.js";
import { Ladder } from "./ladder.js";
import { Law } from "./law.js";
import { leaveDialog } from "./leave.js";
import { Missing } from "./missing.js";
import { ModelPanel } from "./model.js";
import { Next } from "./next.js";
import { Race } from "./race.js";
import { Resting } from "./resting.js";
import { looksOf } from "./views.js";
import { Watch } from "./watch.js";
import { answerTo, heldWith, keyOf, lacking, ofModel, rowsOf, textOf } from "./wants.js";
import { Work } from "./work.js";

const SAVED = "springpot-session";
const PULSE = 5000; // ms between looks whether the server is still there
const READING = "reading"; // the work that brings data: no step ends it
const BEGINNING = { model: "", accepted: [], seed: 0 };
const MOVED = "Moved by hand";
const WAIT = "wait for the computation, or cancel it";
const CANCELLED = "the computation was cancelled: 'Judge this model' begins it again";

class App {
  constructor() {
    this.known = new Map(); // data by digest
    this.answers = new Map(); // answers by state
    this.left = new Map(); // what was refused or cancelled, and why: it is not asked for again before the next step
    this.history = new History();
    this.looks = looksOf();
    this.hovered = null;
    this.looked = null; // the rung that is looked at, where it is not the last
    this.edited = null;
    this.named = null; // a model that waits for data
    this.refused = "";
    this.work = new Work(() => this.render());
    this.hands = new Hands(this);
    this.asked = new Asked(this);
    this.chosen = new Chosen(this);
    this.pointed = new Pointed(this);
    this.panels = [
      (this.hero = new Hero(byId("hero-body"), this)),
      new Data(byId("data-body"), this),
      (this.model = new ModelPanel(byId("model-body"), this)),
      (this.compare = new Compare(byId("compare-body"), this, byId("failing-body"))),
      (this.ladder = new Ladder(byId("ladder-body"), this)),
      (this.missing = new Missing(byId("missing-body"), this)),
      (this.law = new Law(byId("law-body"), this)),
      new Next(byId("next-body"), this),
    ];
    this.race = new Race(byId("race"));
    this.watch = new Watch(this, byId("odds-body"));
    this.resting = new Resting(this);
  }

  get state() { return this.history.state; }

  get data() { return this.state ? this.known.get(this.state.data) : null; }

  get scene() { return this.data?.scene || null; }

  // What is drawn: the answer of the rung that is looked at, as soon as it is here.
  get answer() { return this.looking || this.whole; }

  get looking() { return this.looked === null ? null : this.answerOf(this.looked); }

  // Where what is drawn stands.
  get standing() { return this.looking ? this.upTo(this.looked) : this.state; }

  // The answer to the present state; while it is being computed, the last one that there was.
  get whole() {
    if (!this.state) return null;
    const found = this.answers.get(keyOf(this.state));
    if (found) this.last = found;
    if (this.last?.state.data === this.state.data) return this.last;
    return this.busy && this.early?.of === this.state ? this.early.found : null;
  }

  // How far the model lies from new data, while what it may lack is sought.
  async glance() {
    const { state } = this;
    if (this.early?.of === state || this.whole || !this.scene || state.accepted.length) return;
    const early = { of: state, found: null, tried: new Map() };
    this.early = early;
    try {
      early.look = await api.ask("first", { state });
    } catch { return; } // the whole answer tells why
    this.soon(early);
  }

  // Causes as they are tried, before all of them are weighed; once more where the noise has become smaller.
  tried(state, action, preview) {
    if (this.early?.of !== state) return;
    this.early.tried.set(action.name, { action, preview });
    this.soon(this.early);
  }

  // Many may come at once: they are drawn together.
  soon(early) {
    if (!early.look || early.drawing) return;
    early.drawing = requestAnimationFrame(() => {
      early.drawing = 0;
      const tried = [...early.tried.values()];
      early.found = { ...early.look, actions: tried.map(({ action }) => action), previews: Object.fromEntries(tried.map(({ action, preview }) => [action.name, preview])) };
      if (this.early === early && this.state === early.of && this.waiting) this.render();
    });
  }

  // Whether what is drawn is of another state than the one a person asked for.
  get waiting() { return Boolean(this.state) && !this.answers.has(keyOf(this.state)); }

  // Why there is no answer to it and none on its way; a later message may have taken the place of this one.
  get unanswered() {
    if (!this.waiting || this.busy) return "";
    const { data } = this.state;
    return this.left.get(answerTo(this.state)) || this.left.get(textOf(data)) || "";
  }

  get reading() { return this.work.name === READING; }

  get busy() { return this.work.name !== null; }

  get steps() { return this.whole?.discovery.steps || []; }

  get rung() { return this.looking ? this.looked : this.steps.length - 1; }

  // The answers of the foot of this ladder and of the rung before, where they are here.
  get first() { return this.answerOf(0); }

  get before() { return this.rung > 0 ? this.answerOf(this.rung - 1) : null; }

  answerOf(rung) { return this.whole ? this.answers.get(keyOf(this.upTo(rung))) || null : null; }

  get beside() {
    const branch = this.history.beside;
    if (!branch) return null;
    const state = branch.states[branch.at];
    const found = this.answers.get(keyOf(state));
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
    const refused = this.refused || this.unanswered;
    byId("refused").hidden = !refused;
    byId("refused").textContent = refused;
    enable(byId("undo"), this.history.canUndo || this.reading ? "" : "there is nothing to undo");
    enable(byId("redo"), this.history.canRedo ? "" : "there is nothing to redo");
    let why = "";
    if (!answer) why = "there is nothing to leave with yet";
    else if (this.waiting) why = WAIT;
    enable(byId("leave"), why);
    if (answer && this.others) Object.assign(answer.previews, this.others.previews);
    // Panels make their elements anew: what had the focus has it still.
    const focused = document.activeElement?.id;
    for (const panel of this.panels) panel.render();
    this.watch.render();
    this.compare.fill();
    if (focused && document.activeElement === document.body) byId(focused)?.focus();
  }

  save() {
    const { base, data } = this.watch;
    const session = { ...this.history.toJSON(), view: this.looks, watch: { base, data } };
    api.memory.setItem(SAVED, JSON.stringify(session));
  }

  // ---- data -------------------------------------------------------------------------------------------------

  // Several files are one test: time signals of one frequency each, or one sweep each. `said`: what was answered to
  // the reader's questions, such as "storage=kPa" or "#2".
  openFiles(files, join = false, said = []) {
    const onto = join && this.state ? this.state.data : "";
    return this.read(async (how) => {
      let found = null;
      let last = onto;
      for (const file of files) {
        const bytes = await file.arrayBuffer();
        const query = { name: file.name, choice: choiceOf(said), ...(last ? { onto: last } : {}) };
        found = await api.upload(bytes, query, how);
        if (found.question && files.length > 1) throw new api.Failed(`${found.question.says} (open it alone to be asked)`);
        if (found.question) return { question: { ...found.question, file, said, join } };
        last = found.digest;
      }
      return found;
    }, onto);
  }

  // The same data, a channel of which counts the other way: what was accepted and left out stays.
  turn() {
    const state = this.standing;
    return this.read((how) => api.ask("turned", { state }, how), state.data);
  }

  openSet(name) {
    return this.read((how) => api.upload(new Uint8Array(), { dataset: name }, how));
  }

  openExample(set, model) {
    this.named = model;
    return this.openSet(set);
  }

  // A step that is made meanwhile neither ends the reading nor is undone by it.
  async read(action, onto = "") {
    this.question = null;
    this.refused = "";
    const { found, refused } = await this.work.run(READING, action);
    if (!found && !refused) return; // ended: by newer data, which go on from here, or by hand
    if (found?.digest) this.opened(found, onto);
    else this.notOpened(refused, found?.question);
  }

  opened(found, onto) {
    this.known.set(found.digest, found);
    if (found.session) {
      this.history = new History(found.session);
      this.looks = looksOf(found.session.view);
      if (this.named !== null) this.history.push(this.judging(this.named));
    } else this.history.push(this.stateOn(found.digest, onto));
    this.named = null;
    this.arrive();
  }

  // Data that are watched have more rows than before: all ladders go on with these.
  grown(found) {
    const before = this.state?.data;
    if (!before) {
      this.opened(found);
      return;
    }
    const old = new Set(found.rows);
    found.scene.fresh = new Set([...Array(found.scene.count).keys()].filter((row) => !old.has(row)));
    this.known.set(found.digest, found);
    this.history.moved(before, found.digest, found.rows);
    for (const [key, answer] of this.answers) if (answer.state.data === before) this.answers.delete(key);
    this.known.delete(before);
    this.arrive();
  }

  // The model and what was accepted stay when further data join; other data begin a ladder of their own.
  stateOn(data, onto) {
    const before = this.state || BEGINNING;
    const excluded = onto && before.data === onto ? before.excluded : [];
    const state = { ...(onto ? before : ofModel(before, before.model)), data, excluded };
    return this.named === null ? state : ofModel(state, this.named);
  }

  // What waited for these data is for those that are open, if any are.
  notOpened(refused = "", question = null) {
    if (this.data && this.named !== null) this.judge(this.named);
    this.refused = refused;
    this.question = question;
    this.render();
    if (question) byId("question").querySelector("select").focus();
    this.pursue();
  }

  openMore() {
    openDialog(this);
    const join = byId("open-dialog").querySelector("input[type=checkbox]");
    if (join) join.checked = true;
  }

  leaveOut(excluded) {
    this.step({ ...this.state, excluded });
  }

  // ---- the ladder -------------------------------------------------------------------------------------------

  // A model that is named before there are data, or while they are read, is judged as soon as they are here.
  judge(model, options = "") {
    this.named = null;
    if (this.data && !this.reading) {
      this.step({ ...this.judging(model), ...(options && { options }) });
      return;
    }
    this.named = model;
    this.render();
  }

  judging(model) { return ofModel(this.state, model); }

  // Parameters by name, in printed units, to be held where they are; of nothing all are fitted again.
  hold(values) {
    const { fixed, ...state } = values ? this.standing : this.state;
    this.step(values ? { ...state, fixed: { ...fixed, ...values } } : state);
  }

  // An effect by its name, a law by its text, or what can be done with the data.
  accept(name) {
    if (this.waiting) return;
    if (name === BY_HAND) {
      this.hold(this.model.moved());
      return;
    }
    if (name === this.chosen.asked?.name) {
      this.compare.toggle([...this.compare.chosen]);
      return;
    }
    const actions = [...this.answer.actions, ...(this.others?.actions || [])];
    const { accept, exclude, model, turns } = actions.find((action) => action.name === name) || { accept: [name], exclude: [] };
    if (turns?.length) {
      this.turn();
      return;
    }
    if (model !== undefined) {
      this.step({ ...ofModel(this.standing, model), accepted: accept });
      return;
    }
    const { accepted, excluded } = this.standing;
    const out = new Set(excluded);
    // Rows of an action count among those that are used.
    const used = exclude.length ? [...Array(this.scene.count).keys()].filter((row) => !out.has(row)) : [];
    const rows = [...excluded, ...exclude.map((i) => used[i])].sort((a, b) => a - b);
    this.step({ ...this.standing, accepted: [...accepted, ...accept], excluded: rows });
  }

  // Other models, where they were ranked for the rows that are used; they are hypotheses like the causes.
  get others() { return this.ranking && this.ranking.of === rowsOf(this.standing) ? this.ranking : null; }

  // The laws that were found for the present state, if they were sought.
  get laws() { return this.state && this.found?.of === keyOf(this.standing) ? this.found : null; }

  findLaws() {
    this.refused = "";
    this.toFind = keyOf(this.state);
    this.pursue();
  }

  // A rung is one of the ladder that is drawn, which may still be that of the state before.
  upTo(rung) {
    const { model, accepted } = this.whole.state;
    return heldWith({ ...this.state, model, accepted: accepted.slice(0, rung) });
  }

  goTo(rung) { this.step(this.upTo(rung)); }

  // A rung is looked at: nothing that was accepted is left for it.
  see(rung) {
    this.looked = rung < this.steps.length - 1 ? rung : null;
    this.hovered = null;
    this.render();
    this.pursue();
  }

  remove(i) {
    const whole = this.upTo(this.steps.length - 1);
    this.step(heldWith({ ...whole, accepted: whole.accepted.filter((_, j) => j !== i) }));
  }

  step(state) {
    this.history.push(state);
    this.arrive();
  }

  // While data are read, that is what was done last.
  undo() {
    if (this.reading) {
      this.cancel();
      return;
    }
    this.history.undo();
    this.arrive();
  }

  redo() { this.history.redo(); this.arrive(); }

  fork(rung) { this.history.fork(this.upTo(rung)); this.arrive(); }

  select(i) { this.history.at = i; this.arrive(); }

  drop(i) { this.history.drop(i); this.arrive(); }

  // Show the present state: at once if its answer is here, else after asking for it.
  arrive() {
    this.hovered = null;
    this.looked = null;
    this.refused = "";
    this.left.clear();
    this.save();
    if (!this.reading && this.work.name !== lacking(this)?.name) this.work.end();
    this.render();
    this.pursue();
  }

  // Ask for what is lacking, until nothing is; whoever else computes calls this when it has ended.
  async pursue() {
    if (this.pursuing || this.busy) return;
    this.pursuing = true;
    try {
      for (let want = lacking(this); want && !this.busy; want = lacking(this)) {
        if (want.name === answerTo(this.state)) this.glance();
        const { found, refused } = await this.work.run(want.name, want.ask);
        if (found) want.take(found);
        if (refused) this.leave(want, refused);
      }
    } finally {
      this.pursuing = false;
      this.render();
      this.resting.settle();
    }
  }

  leave(want, refused) {
    this.left.set(want.name, refused || CANCELLED);
    this.refused = refused;
    want.leave?.();
  }

  // A model or effect that was refused is not where one is; data that were opened are, also without an answer.
  retreat(state) {
    if (this.state !== state || !this.history.canUndo) return;
    this.history.undo();
    if (this.state.data !== state.data || this.waiting) this.history.redo();
    else this.model.keepText();
    this.save();
  }

  // What was not computed is not where one is: the page goes back to the last state with an answer.
  cancel() {
    const { reading } = this;
    const want = lacking(this);
    const answering = this.waiting && this.work.name === want?.name;
    if (want && this.work.name === want.name) this.leave(want, "");
    this.work.end();
    if (reading) this.notOpened();
    else if (answering && this.waiting && this.history.canUndo) this.undo();
    else this.render();
    this.pursue();
  }

  // ---- previews and looks -----------------------------------------------------------------------------------

  hover(effect) {
    this.hovered = effect;
    this.compare.preview(effect);
    this.ladder.preview(effect);
    this.missing.show(effect);
    this.pointed.at(effect);
    this.resting.bring();
  }

  look(change) {
    Object.assign(this.looks, change);
    this.save();
    this.render();
    this.pursue();
  }

  setEdited(edited) {
    this.edited = edited;
    if (edited) this.answer.previews[BY_HAND] = edited;
    this.missing.propose(MOVED, edited && this.model.movedAs(BY_HAND, edited));
    if (this.compare.main.spec && this.scene) this.compare.drawBeside();
    this.hero.render();
    this.ladder.preview(this.hovered);
  }

  rankModels() {
    if (!usable(this.model.rank)) return;
    this.refused = "";
    this.toRank = rowsOf(this.state);
    this.pursue();
  }

  // ---- leaving ----------------------------------------------------------------------------------------------

  textOf(kind) {
    return api.ask("leave", { state: this.state, kind });
  }

  // The file's name, and a link where the browser wants one more click.
  async leaveWith(kind, type = "text/csv") {
    const { name, text, base64 } = await this.fileOf(kind);
    const content = base64 ? bytesOf(base64) : text;
    return { name, link: download(name, new Blob([content], { type })) };
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

  // A server that was started anew knows nothing of these data: they are sent again, with all their branches.
  async resume() {
    this.refused = "";
    this.left.clear();
    if (!this.data) {
      await this.begin();
      return;
    }
    const { name, text } = await this.fileOf("session");
    await this.read((how) => api.upload(new TextEncoder().encode(text), { name }, how));
  }

  // ---- begin ------------------------------------------------------------------------------------------------

  async begin() {
    this.render();
    const saved = api.memory.getItem(SAVED);
    api.installed().then((found) => {
      this.installed = found;
      this.model.complete();
      this.model.list();
      this.render();
    }).catch((error) => { this.refused = error.message; this.render(); });
    if (saved) {
      const session = JSON.parse(saved);
      this.history = new History(session);
      this.looks = looksOf(session.view);
      if (this.state) {
        this.arrive();
        this.watch.begin(session.watch);
        return;
      }
    }
    await this.read(async () => {
      const given = await api.start();
      // What a person has named or opened meanwhile comes before what was given on the command line.
      if (this.named === null && !this.state && given.model) this.named = given.model;
      if (given.data?.error) throw new api.Failed(given.data.error);
      const found = given.data?.result || {};
      if (!found.question) return found;
      const { name, content } = found.question;
      return { question: { ...found.question, file: new File([bytesOf(content)], name), said: [], join: false } };
    });
    this.watch.begin({});
  }
}

const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

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
    if (typing || document.querySelector("dialog[open]")) return;
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
    lost.textContent = "The server has gone; what is on the page stays. To go on, start 'springpot workbench' again and open its address here; on another port, save a session first.";
  });
  setInterval(() => { if (!document.hidden) api.alive().then(() => { lost.hidden = true; }).catch(() => {}); }, PULSE);
  // The address of a server that was started anew, opened in this tab, differs from the old one behind # alone.
  window.addEventListener("hashchange", () => {
    if (!api.takeToken()) return;
    lost.hidden = true;
    app.resume();
  });
  listenForDrops(app);
}

api.takeToken();
const theme = localStorage.getItem("springpot-theme");
if (theme) document.documentElement.dataset.theme = theme;
const app = new App();
listen(app);
app.begin();
