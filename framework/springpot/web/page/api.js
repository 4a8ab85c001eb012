// Requests to the engine behind this page: a stream of lines, of which the last is the answer.

const TOKEN = "springpot-token";

// What the page asks by, and what outlives a reload: the server and the tab, or what a notebook puts in their place.
const host = window.springpot || {
  memory: sessionStorage,
  ask(path, options) {
    const headers = { "X-Springpot-Token": sessionStorage.getItem(TOKEN) || "" };
    return fetch(path, { ...options, headers, cache: "no-store" });
  },
};
export const { memory } = host;

// The token came behind # in the address; it is kept for a reload of this tab and taken off the address.
export function takeToken() {
  const found = /token=([\w-]+)/.exec(location.hash);
  if (!found) return false;
  sessionStorage.setItem(TOKEN, found[1]);
  history.replaceState(null, "", location.pathname);
  return true;
}

export class Failed extends Error {}

async function request(path, options = {}) {
  let response;
  try {
    response = await host.ask(path, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    document.dispatchEvent(new CustomEvent("lost"));
    throw new Failed("the server has gone");
  }
  if (!response.ok) {
    const text = await response.text();
    let says = text.trim();
    try {
      says = JSON.parse(text).error;
    } catch { /* plain text is said as it is */ }
    throw new Failed(says || `the server answers ${response.status}`);
  }
  return response;
}

async function lines(response, told) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  let last = null;
  for (;;) {
    let part;
    try {
      part = await reader.read();
    } catch (error) {
      if (error.name === "AbortError") throw error;
      document.dispatchEvent(new CustomEvent("lost"));
      throw new Failed("the server has gone");
    }
    if (part.done) break;
    rest += part.value;
    const whole = rest.split("\n");
    rest = whole.pop();
    for (const line of whole) {
      const said = JSON.parse(line);
      if (said.stage) told?.(said.stage, said);
      else if (!said.beat) last = said;
    }
  }
  if (last === null) throw new Failed("the computation ended without an answer");
  if (last.error) throw new Failed(last.error);
  return last.result;
}

export async function ask(task, body, { told, signal } = {}) {
  const options = { method: "POST", body: JSON.stringify(body), signal };
  return lines(await request(`/api/${task}`, options), told);
}

export async function upload(bytes, query, { told, signal } = {}) {
  const path = `/api/data?${new URLSearchParams(query)}`;
  return lines(await request(path, { method: "POST", body: bytes, signal }), told);
}

export const installed = async () => lines(await request("/api/library"));
export const start = async () => (await request("/api/start")).json();
export const alive = async () => request("/page/icon.svg");
