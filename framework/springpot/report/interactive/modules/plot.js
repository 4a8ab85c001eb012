// A pair of axes as SVG: everything in it is an element that can be styled, printed, read aloud and tested.

import { s } from "./dom.js";

const LEFT = 62;
const RIGHT = 10;
const TOP = 10;
const BOTTOM = 38;
const WORD = 34; // px for the number of a tick along
const LINE = 13; // px for one line of them
const FALL = 500; // ms
const DRIFT = 900; // ms
const MANY = 600; // points from which they are drawn as a cloud
const CELL = 2; // px of its cells
const DENSE = [1, 2, 4, 9]; // points in a cell from which it is darker

export function niceTicks(low, high, most = 6) {
  const rough = (high - low) / most || 1;
  const size = 10 ** Math.floor(Math.log10(rough));
  const step = size * ([1, 2, 5, 10].find((factor) => factor * size >= rough) || 10);
  const ticks = [];
  for (let tick = Math.ceil(low / step) * step; tick <= high + step * 1e-9; tick += step) {
    ticks.push(Math.abs(tick) < step * 1e-9 ? 0 : tick);
  }
  return ticks;
}

export function logTicks(low, high) {
  const decades = Math.log10(high / low);
  const factors = decades < 1.2 ? [1, 2, 3, 5] : decades < 4 ? [1, 3] : [1];
  const step = Math.max(1, Math.ceil(decades / 7));
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += step) {
    for (const factor of factors) {
      const tick = factor * 10 ** power;
      if (tick >= low * 0.999 && tick <= high * 1.001) ticks.push(tick);
    }
  }
  return ticks.length > 1 ? ticks : niceTicks(low, high);
}

// How an axis turns a value into a length, and back. `bend`: linear up to this size and logarithmic beyond, on both sides
// of zero, so that what is negative is seen too.
export function turned({ log, bend }) {
  if (bend) return { forth: (value) => Math.asinh(value / bend), back: (length) => bend * Math.sinh(length) };
  if (log) return { forth: Math.log, back: Math.exp };
  return { forth: (value) => value, back: (length) => length };
}

function bentTicks({ min, max, bend }) {
  const last = Math.max(Math.abs(min), Math.abs(max));
  const sizes = [];
  // So many that they stand apart: of many decades some are passed over.
  const decades = Math.log10(last / bend);
  for (let size = 10 ** Math.floor(Math.log10(bend)); size <= last * 1.001; size *= 10 ** Math.ceil(decades / 3)) sizes.push(size, ...(decades < 1.8 ? [3 * size] : []));
  return [...sizes.map((size) => -size).reverse(), 0, ...sizes].filter((tick) => (tick === 0 || Math.abs(tick) >= bend) && tick >= min && tick <= max);
}

// Outwards from zero, those whose words do not overlap.
function apart(ticks, at, least) {
  const kept = ticks.includes(0) ? [0] : [];
  const ends = [kept[0], kept[0]];
  for (const tick of [...ticks].sort((a, b) => Math.abs(a) - Math.abs(b))) {
    const side = Number(tick > 0);
    if (ends[side] !== undefined && Math.abs(at(tick) - at(ends[side])) < least) continue;
    ends[side] = tick;
    kept.push(tick);
  }
  return kept;
}

const short = (value) => {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(0) : String(Number(value.toPrecision(3)));
};

// The ends of an axis: all values with a little room.
export function range(values, log, pad = 0.06) {
  const there = values.filter((value) => Number.isFinite(value) && (!log || value > 0));
  if (!there.length) return log ? [1, 10] : [0, 1];
  let low = Math.min(...there);
  let high = Math.max(...there);
  if (log) {
    const room = Math.max((high / low) ** pad, 1.05);
    return [low / room, high * room];
  }
  if (low === high) [low, high] = [low - 1, high + 1];
  const room = pad * (high - low);
  return [low - room, high + room];
}

export class Plot {
  constructor(id, title) {
    this.id = id;
    this.title = title;
    this.svg = s("svg", { id, class: "plot", tabindex: "0", role: "application", "aria-roledescription": "plot" });
    this.marks = [];
    this.shaded = new Map(); // places by what is drawn of them
    this.means = () => {}; // called with the place whose bar is pointed at
  }

  // Axes, shaded places, bands, lines and points; see views.js for what a spec holds.
  draw(spec, width, height) {
    Object.assign(this, { spec, width, height });
    const { svg } = this;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("width", width);
    svg.setAttribute("height", height);
    svg.setAttribute("aria-label", `${this.title}: ${spec.y.label} against ${spec.x.label}. ${spec.says || ""}`);
    this.x = this.scale(spec.x, LEFT, width - RIGHT);
    this.y = this.scale(spec.y, height - BOTTOM, TOP);
    const clip = `${this.id}-clip`;
    const inside = { "clip-path": `url(#${clip})` };
    this.previewLayer = s("g", { class: "preview-layer" });
    this.extraLayer = s("g", { class: "extra-layer" });
    this.cursorLayer = s("g", { class: "cursor-layer" });
    this.shaded = new Map();
    this.small = spec.points.length > MANY;
    this.marks = spec.points.map((point) => (this.small && !point.out ? null : this.mark(point)));
    const cloud = this.small ? this.cloud([...spec.points.filter((point) => !point.out), ...(spec.cloud || [])]) : [];
    const box = { x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: height - TOP - BOTTOM };
    svg.replaceChildren(
      s("title", {}, this.title),
      s("defs", {}, s("clipPath", { id: clip }, s("rect", box))),
      s("g", { class: "axes" }, ...this.axes(spec)),
      s("g", inside,
        ...(spec.shades || []).map((shade, lane) => this.shade(shade, lane)),
        ...(spec.bands || []).map((band) => this.band(band)),
        ...(spec.lines || []).map((line) => this.line(line)),
        this.extraLayer, ...(spec.stations || []).map((x) => this.station(x)), s("g", { class: "points" }, ...cloud, ...this.marks.filter(Boolean)),
        this.previewLayer, this.cursorLayer),
    );
  }

  scale(axis, from, to) {
    const { forth } = turned(axis);
    const low = forth(axis.min);
    const factor = (to - from) / (forth(axis.max) - low);
    return (value) => from + (forth(value) - low) * factor;
  }

  // Where a pointer is, as shares of the picture's width and height from its lower left.
  share(event) {
    const box = this.svg.getBoundingClientRect();
    const px = ((event.clientX - box.left) / box.width) * this.width;
    const py = ((event.clientY - box.top) / box.height) * this.height;
    return [(px - LEFT) / (this.width - LEFT - RIGHT), (this.height - BOTTOM - py) / (this.height - TOP - BOTTOM)];
  }

  axes({ x, y }) {
    const { width, height } = this;
    const parts = [s("rect", { class: "frame", x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: height - TOP - BOTTOM })];
    const ticks = (axis, most, at, least) => {
      if (axis.bend) return apart(bentTicks(axis), at, least);
      return axis.log ? logTicks(axis.min, axis.max) : niceTicks(axis.min, axis.max, most);
    };
    for (const tick of ticks(x, width / 90, this.x, WORD)) {
      const at = this.x(tick);
      parts.push(s("line", { class: "grid", x1: at, x2: at, y1: TOP, y2: height - BOTTOM }));
      parts.push(s("text", { class: "tick", x: at, y: height - BOTTOM + 14, "text-anchor": "middle" }, short(tick)));
    }
    for (const tick of ticks(y, height / 30, this.y, LINE)) {
      const at = this.y(tick);
      parts.push(s("line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: at, y2: at }));
      parts.push(s("text", { class: "tick", x: LEFT - 5, y: at + 4, "text-anchor": "end" }, short(tick)));
    }
    const middle = (TOP + height - BOTTOM) / 2;
    parts.push(s("text", { class: "label", x: (LEFT + width - RIGHT) / 2, y: height - 6, "text-anchor": "middle" }, x.label));
    parts.push(s("text", { class: "label", x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, y.label));
    return parts;
  }

  path(xs, ys) {
    let d = "";
    let pen = "M";
    for (let i = 0; i < xs.length; i += 1) {
      const at = this.y(ys[i]);
      const along = this.x(xs[i]);
      if (ys[i] === null || !Number.isFinite(at) || !Number.isFinite(along)) {
        pen = "M";
        continue;
      }
      // Far outside, browsers draw wrongly rather than nothing.
      d += `${pen}${along.toFixed(1)} ${Math.max(-1e4, Math.min(1e4, at)).toFixed(1)}`;
      pen = "L";
    }
    return d;
  }

  line({ xs, ys, kind, colour }) {
    return s("path", { class: `line ${kind}`, d: this.path(xs, ys), fill: "none", stroke: colour });
  }

  mark({ x, y, kind, part = kind, row, colour, out }) {
    const [cx, cy] = [this.x(x), this.y(y)];
    if (!Number.isFinite(cx) || !Number.isFinite(cy)) return null;
    const common = { "data-row": row, class: `mark ${kind}${out ? " out" : ""}` };
    if (out) return s("path", { ...common, d: `M${cx - 3} ${cy - 3}l6 6m0 -6l-6 6` });
    const half = 3;
    if (part === "loss") return s("rect", { ...common, x: cx - half, y: cy - half, width: 2 * half, height: 2 * half, stroke: colour });
    return s("circle", { ...common, cx, cy, r: 1.13 * half, fill: colour });
  }

  // Cells of the picture, the darker the more points lie in them.
  cloud(points) {
    const kinds = new Map();
    for (const { x, y, kind, colour } of points) {
      const [across, down] = [Math.round(this.x(x) / CELL), Math.round(this.y(y) / CELL)];
      if (!Number.isFinite(across) || !Number.isFinite(down)) continue;
      const key = `${kind}|${colour}`;
      if (!kinds.has(key)) kinds.set(key, new Map());
      const cells = kinds.get(key);
      const cell = `M${across * CELL - CELL / 2} ${down * CELL}h${CELL}`;
      cells.set(cell, (cells.get(cell) || 0) + 1);
    }
    return [...kinds].flatMap(([key, cells]) => {
      const [kind, stroke] = key.split("|");
      const layers = DENSE.map(() => "");
      for (const [cell, count] of cells) layers[DENSE.findLastIndex((least) => count >= least)] += cell;
      return layers.map((d, level) => (d ? s("path", { class: `cloud dense-${level} ${kind}`, d, stroke }) : null)).filter(Boolean);
    });
  }

  // The worst place over the whole height, the others as bars at the foot, one above the other.
  shade({ from, to, says, place }, lane) {
    const left = Math.max(LEFT, Math.min(this.x(from), this.x(to)) - 3);
    const right = Math.min(this.width - RIGHT, Math.max(this.x(from), this.x(to)) + 3);
    if (!(right > left)) return s("g", {});
    const bottom = this.height - BOTTOM;
    const pointed = { onpointerenter: () => this.means(place), onpointerleave: () => this.means(null) };
    const bar = { ...pointed, class: "shade bar", x: left, width: right - left, y: bottom - 7 * (lane + 1), height: 5 };
    const whole = { class: "shade", x: left, width: right - left, y: TOP, height: bottom - TOP };
    const drawn = s("g", {}, lane ? null : s("rect", whole, s("title", {}, says)), s("rect", bar, s("title", {}, says)));
    this.shaded.set(place, drawn);
    return drawn;
  }

  // Where to measure.
  station(x) {
    const [at, foot] = [this.x(x), this.height - BOTTOM];
    return s("path", { class: "station", d: `M${at} ${foot - 8}l-4 8h8Z` });
  }

  band({ xs, low, high, kind }) {
    const forth = this.path(xs, high);
    const back = this.path([...xs].reverse(), [...low].reverse()).replace("M", "L");
    return s("path", { class: `band ${kind}`, d: forth ? `${forth}${back}Z` : "" });
  }

  // The points move to where they are from where they were, on the same axes: what falls is seen to fall.
  fall() {
    const { spec, marks, stood } = this;
    const places = new Map();
    spec.points.forEach(({ row, part, y }, i) => { if (marks[i] && row !== null) places.set(`${row} ${part}`, this.y(y)); });
    const axes = [this.width, this.height, spec.y.min, spec.y.max, spec.y.label].join();
    this.stood = { places, axes };
    if (stood?.axes !== axes || this.small || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    spec.points.forEach(({ row, part }, i) => {
      const key = `${row} ${part}`;
      const rise = stood.places.get(key) - places.get(key);
      if (rise) marks[i].animate([{ transform: `translateY(${rise}px)` }, { transform: "none" }], { duration: FALL, easing: "ease-in" });
    });
  }

  // Points of rows that are new come in from above.
  arrive(rows) {
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    this.spec.points.forEach(({ row }, i) => {
      if (this.marks[i] && rows.has(row)) this.marks[i].animate([{ transform: "translateY(-40px)", opacity: 0 }, { transform: "none", opacity: 1 }], { duration: DRIFT, easing: "ease-out" });
    });
  }

  // What would be: drawn without touching anything else, so that it costs a frame and leaves no trace.
  preview(lines) {
    this.previewLayer.replaceChildren(...lines.map((line) => this.line({ ...line, kind: `preview ${line.kind}` })));
  }

  extra(lines) {
    this.extraLayer.replaceChildren(...lines.map((line) => this.line(line)));
  }

  // A ring around the points of one row, of those that are selected, and of those that light up.
  point(row, chosen, lit = () => false) {
    const rings = [];
    this.spec.points.forEach((point) => {
      const here = row !== null && point.row === row;
      if (!(here || chosen.has(point.row) || (point.row !== null && lit(point))) || !Number.isFinite(this.x(point.x) + this.y(point.y))) return;
      rings.push(s("circle", { class: here ? "ring" : "ring chosen", cx: this.x(point.x), cy: this.y(point.y), r: 7 }));
      if (here && this.spec.upright) {
        const at = this.x(point.x);
        rings.push(s("line", { class: "cursor", x1: at, x2: at, y1: TOP, y2: this.height - BOTTOM }));
      }
    });
    this.cursorLayer.replaceChildren(...rings);
  }

  // The drawn row nearest to a place in the picture.
  nearest(px, py, reach = Infinity) {
    let best = null;
    let least = reach;
    for (const point of this.spec.points) {
      if (point.row === null) continue; // a shadow of what was
      const [dx, dy] = [this.x(point.x) - px, this.y(point.y) - py];
      const far = this.spec.upright && reach === Infinity ? Math.abs(dx) + 0.01 * Math.abs(dy) : Math.hypot(dx, dy);
      if (far < least) [best, least] = [point.row, far];
    }
    return best;
  }

  rowsWithin(x0, y0, x1, y1) {
    const inside = (value, one, other) => value >= Math.min(one, other) && value <= Math.max(one, other);
    return this.spec.points
      .filter((point) => point.row !== null && inside(this.x(point.x), x0, x1) && (this.spec.upright || inside(this.y(point.y), y0, y1)))
      .map((point) => point.row);
  }
}

const KEPT = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-opacity", "opacity",
  "font-family", "font-size", "font-weight", "text-anchor"];

// The picture with its style inside, for those who open it elsewhere.
export function standalone(svg) {
  const copy = svg.cloneNode(true);
  const here = [svg, ...svg.querySelectorAll("*")];
  [copy, ...copy.querySelectorAll("*")].forEach((element, i) => {
    const style = getComputedStyle(here[i]);
    for (const name of KEPT) element.setAttribute(name, style.getPropertyValue(name));
    for (const name of ["tabindex", "role", "aria-roledescription", "class", "data-row"]) element.removeAttribute(name);
  });
  copy.querySelectorAll("title").forEach((title) => ["fill", "stroke"].forEach((name) => title.removeAttribute(name)));
  const { width, height } = svg.viewBox.baseVal;
  const paper = s("rect", { width, height, fill: getComputedStyle(document.body).backgroundColor });
  copy.insertBefore(paper, copy.firstChild);
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(copy)}\n`;
}

// The same as pixels, twice as many as on the screen.
export async function asPng(svg) {
  const { width, height } = svg.viewBox.baseVal;
  const image = new Image(width, height);
  const url = URL.createObjectURL(new Blob([standalone(svg)], { type: "image/svg+xml" }));
  image.src = url;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(url);
  return new Promise((done) => { canvas.toBlob(done, "image/png"); });
}

