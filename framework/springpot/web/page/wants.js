// What the page still lacks of where a person is, the most wanted first.
//
// Nothing remembers what was to be asked for next: it follows from the state alone, each time that a computation has
// ended. So nothing that is clicked, dropped or named while one runs is lost to it.

import * as api from "./api.js";

export const keyOf = (state) => JSON.stringify(state);

// The rows that are used: what does not depend on a model is the same for all states of the same rows.
export const rowsOf = ({ data, excluded, seed }) => JSON.stringify([data, excluded, seed]);

// Names under which what is wanted is known while it runs, and after it was refused.
export const textOf = (data) => `data ${data}`;
export const answerTo = (state) => `answer ${keyOf(state)}`;
export const rankingOf = (rows) => `ranking ${rows}`;

// Another model has other parameters: nothing of it is held or tied.
export const ofModel = ({ fixed, options, ...state }, model) => ({ ...state, model, accepted: [] });
// What is held of an effect is held as long as it is there.
export function heldWith({ fixed = {}, ...state }) {
  const there = (name) => !name.includes(".") || state.accepted.some((effect) => name.startsWith(`${effect.split(" =")[0]}.`));
  const kept = Object.entries(fixed).filter(([name]) => there(name));
  return kept.length ? { ...state, fixed: Object.fromEntries(kept) } : state;
}
export const withoutModel = (state) => ofModel(state, "");

// Each is named, asks, keeps what came, and is left alone when it was refused or cancelled.
export function lacking(app) {
  const { state } = app;
  if (!state) return null;
  if (!app.known.has(state.data)) return wanted(app, theData(app, state));
  const wants = [theAnswer(app, state), theRungLookedAt(app), app.asked.want(api.ask), theRanking(app, state), theLaws(app, state), theOneBeside(app)];
  return wants.find((want) => wanted(app, want)) || null;
}

const wanted = (app, want) => (want && !app.left.has(want.name) ? want : null);

function theData(app, state) {
  return {
    name: textOf(state.data),
    ask: (how) => api.ask("again", { state }, how),
    take: (found) => app.known.set(found.digest, found),
  };
}

function theAnswer(app, state) {
  const key = keyOf(state);
  if (app.answers.has(key)) return null;
  return {
    name: answerTo(state),
    ask: ({ signal, told }) => api.ask("answer", { state }, { signal, told: (stage, { action, preview }) => {
      told(stage);
      if (action) app.tried(state, action, preview);
    } }),
    take: (found) => app.answers.set(key, found),
    leave: () => app.retreat(state),
  };
}

function theRungLookedAt(app) {
  const want = app.looked === null ? null : theAnswer(app, app.upTo(app.looked));
  return want && { ...want, leave: () => { app.looked = null; } };
}

function theRanking(app, state) {
  const of = rowsOf(state);
  if (app.toRank !== of || app.ranking?.of === of) return null;
  return {
    name: rankingOf(of),
    ask: (how) => api.ask("ranking", { state: withoutModel(state) }, how),
    take: (found) => { app.ranking = { ...found, of }; },
    leave: () => { app.toRank = null; },
  };
}

function theLaws(app, state) {
  const of = keyOf(state);
  if (app.toFind !== of || app.found?.of === of) return null;
  return {
    name: `laws ${of}`,
    ask: (how) => api.ask("laws", { state }, how),
    take: ({ invention, laws, previews }) => {
      Object.assign(app.answers.get(of).previews, previews);
      app.found = { of, invention, texts: laws };
    },
    leave: () => { app.toFind = null; },
  };
}

function theOneBeside(app) {
  const branch = app.history.beside;
  const state = branch?.states[branch.at];
  if (!state || !app.known.has(state.data)) return null;
  const want = theAnswer(app, state);
  return want && { ...want, leave: null };
}
