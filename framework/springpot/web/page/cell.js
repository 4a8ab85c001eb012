// The page in a cell of a notebook: a document of its own within the cell, which asks its engine by the notebook's
// channel to the kernel and keeps its session in the widget, where Python reads it.

const IMPORTED = /from "\.\/([\w.]+)"/g;

// Modules by addresses of their own: a notebook serves none of the page's files.
function addressed(files) {
  const known = new Map();
  const addressOf = (name) => {
    if (!known.has(name)) {
      const text = files[name].replace(IMPORTED, (_, other) => `from "${addressOf(other)}"`);
      known.set(name, URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    }
    return known.get(name);
  };
  return { addressOf, forget: () => known.forEach((address) => URL.revokeObjectURL(address)) };
}

// As fetch answers; a request that is given up is told to the kernel, which then ends what nobody awaits.
function asking(model) {
  const waiting = new Map();
  const own = Math.random().toString(36); // several views of one widget hear each other's answers
  let count = 0;
  const heard = (said, buffers) => waiting.get(said.id)?.(said, buffers);
  model.on("msg:custom", heard);

  async function ask(path, { method = "GET", body, signal } = {}) {
    const bytes = new Uint8Array(await new Response(body).arrayBuffer());
    count += 1;
    const id = `${own}-${count}`;
    let stream;
    const parts = new ReadableStream({ start(control) { stream = control; } });
    return new Promise((resolve, reject) => {
      const leave = () => {
        waiting.delete(id);
        model.send({ id, gone: true });
        const error = new DOMException("given up", "AbortError");
        stream.error(error);
        reject(error);
      };
      if (signal?.aborted) {
        leave();
        return;
      }
      signal?.addEventListener("abort", leave);
      waiting.set(id, (said, buffers) => {
        if (said.status) resolve(new Response(parts, { status: said.status }));
        for (const part of buffers || []) stream.enqueue(new Uint8Array(part.buffer ?? part));
        if (!said.end) return;
        waiting.delete(id);
        signal?.removeEventListener("abort", leave);
        stream.close();
      });
      model.send({ id, method, path }, undefined, [bytes]);
    });
  }

  return { ask, end: () => model.off("msg:custom", heard) };
}

function memoryOf(model) {
  return {
    getItem: () => model.get("session") || null,
    setItem(name, text) {
      model.set("session", text);
      model.save_changes();
    },
  };
}

function render({ model, el }) {
  const { addressOf, forget } = addressed(model.get("files"));
  const { ask, end } = asking(model);
  const frame = document.createElement("iframe");
  frame.title = "springpot workbench";
  frame.srcdoc = model.get("page");
  frame.style.cssText = `width: 100%; height: ${model.get("height")}px; border: 0;`;
  frame.addEventListener("load", () => {
    frame.contentWindow.springpot = { ask, memory: memoryOf(model) };
    const inside = frame.contentDocument;
    const script = inside.createElement("script");
    script.type = "module";
    script.src = addressOf("main.js");
    inside.head.append(script);
  });
  el.append(frame);
  return () => {
    end();
    forget();
  };
}

export default { render };
