// Elements from plain text: nothing that comes from data is ever read as HTML.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else element.setAttribute(name, value);
  }
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === "") continue;
    element.append(child.nodeType ? child : document.createTextNode(String(child)));
  }
  return element;
}

export function h(name, attributes, ...children) {
  return fill(document.createElement(name), attributes, children);
}

export function s(name, attributes, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

export function put(parent, ...children) {
  const kept = children.flat().filter((child) => child !== null && child !== undefined);
  parent.replaceChildren(...kept);
  return parent;
}

export const FINGER = matchMedia("(pointer: coarse)"); // no mouse that points before it clicks

export const byId = (id) => document.getElementById(id);

// Whether what a panel is made from is other than it was. Elements that are made anew under a pressed finger or button
// never see its click: a panel is made anew only when it must be.
export function changed(panel, ...parts) {
  const same = panel.madeFrom?.length === parts.length && parts.every((part, i) => part === panel.madeFrom[i]);
  panel.madeFrom = parts;
  return !same;
}

// A button that cannot be used says why, to the pointer and to a screen reader.
export function enable(button, why) {
  button.setAttribute("aria-disabled", why ? "true" : "false");
  if (!button.dataset.title) button.dataset.title = button.title || "-";
  const usual = button.dataset.title === "-" ? "" : button.dataset.title;
  button.title = why || usual;
}

export const usable = (button) => button.getAttribute("aria-disabled") !== "true";

// Saves a file at once. What took longer than a browser remembers the click for (some seconds) it may refuse to save:
// then the link itself is given back, to be clicked once more.
export function download(name, content, type) {
  const blob = content instanceof Blob ? content : new Blob([content], { type: type || "text/plain" });
  const link = h("a", { href: URL.createObjectURL(blob), download: name }, `Save ${name}`);
  if (navigator.userActivation && !navigator.userActivation.isActive) return link;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  return null;
}
