// Sliders beside curves. No library, no network; what they share with the picker stands before them, in core.js.
//
// The host computes. It is spoken to through model.get, model.set, model.save_changes and model.on("change:name"), as
// anywidget gives them. It gives `controls` and `settings` once, takes `settings` and `stamp`, and answers with `result`,
// which bears the stamp and tells figures and tables: see rbfound/live/sketch.py.

const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 2], [14, 4]];
const STYLES = DASHES.length, STEPS = 200, LARGEST = 1e5;

// An axis in pixels: from, to; its ticks at round numbers or at powers of ten.
class Axis {
  constructor(told, values, from, to) {
    this.told = told;
    this.log = told.log;
    let low = told.low ?? Infinity, high = told.high ?? -Infinity;
    const loose = [told.low === null, told.high === null];
    if (loose[0] || loose[1]) {
      for (const row of values) {
        for (const v of row) {
          if (!isFinite(v) || (this.log && v <= 0)) continue;
          if (loose[0] && v < low) low = v;
          if (loose[1] && v > high) high = v;
        }
      }
    }
    if (!(low < high)) [low, high] = isFinite(low) && isFinite(high) ? [low - 1, high + 1] : [this.log ? 0.1 : 0, 1];
    [low, high] = [this.value(low), this.value(high)];
    if (this.log) [low, high] = [loose[0] ? Math.floor(low) : low, loose[1] ? Math.ceil(high) : high];
    else {
      const room = 0.06 * (high - low);
      [low, high] = [loose[0] ? low - room : low, loose[1] ? high + room : high];
    }
    this.set(low, high, from, to);
  }
  set(low, high, from, to) { Object.assign(this, { low, high, from, to, scale: (to - from) / (high - low) }); }
  value(v) { return this.log ? Math.log10(v) : v; }
  at(v) { return this.from + (this.value(v) - this.low) * this.scale; }
  ticks(count) {
    const { low, high } = this, out = [];
    const raw = (high - low) / Math.max(count, 1);
    if (this.log && raw > 0.3) {
      const every = Math.max(1, Math.ceil(raw));
      for (let k = Math.ceil(low - 1e-9); k <= high + 1e-9; k += every) out.push([10 ** k, tenTo(k)]);
      return out;
    }
    const step = stepped(low, high, count);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return ticks(low, high, count).map((v) =>
      this.log ? [10 ** v, number(10 ** v, 2, LARGEST)] : [v, minus(v.toFixed(Math.min(decimals, 8)))]);
  }
}

class Plot {
  constructor(parent) {
    this.root = make(parent, "figure", { className: "rbs-plot" });
    this.caption = make(this.root, "figcaption");
    this.canvas = make(this.root, "canvas", {}, { role: "img" });
    this.legend = make(this.root, "p", { className: "rbs-legend" });
  }
  draw(told, ink) {
    const { canvas } = this, width = canvas.clientWidth;
    if (!width) return;
    this.root.classList.toggle("is-wide", Boolean(told.wide));
    const height = told.wide ? bound(Math.round(width * 0.55), 300, 440) : told.equal ? Math.min(Math.round(width * 0.8), 360) : bound(Math.round(width * 0.58), 190, 300);
    const sharp = window.devicePixelRatio || 1;
    fitted(canvas, width, height, sharp);
    const context = cleared(canvas, width, height, sharp);
    this.frame(told, width, height);
    this.grid(context, told, ink);
    this.curves(context, told, ink);
    this.name(told, ink);
  }
  frame(told, width, height) {
    const box = (this.box = { left: 58, right: width - 12, top: 8, bottom: height - 38 });
    const x = (this.x = new Axis(told.x, told.lines.map((l) => l.x), box.left, box.right));
    const y = (this.y = new Axis(told.y, told.lines.map((l) => l.y), box.bottom, box.top));
    if (!told.equal) return;
    const scale = Math.min(x.scale, -y.scale);
    for (const [axis, sign] of [[x, 1], [y, -1]]) {
      const middle = (axis.low + axis.high) / 2, half = Math.abs(axis.to - axis.from) / scale / 2;
      axis.set(middle - half, middle + half, axis.from, axis.to);
    }
  }
  grid(context, told, ink) {
    const { left, right, top, bottom } = this.box;
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 1;
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const [value, text] of this.x.ticks((right - left) / 48)) {
      const at = Math.round(this.x.at(value)) + 0.5;
      segment(context, ink("grid"), at, top, at, bottom);
      context.fillStyle = ink("soft");
      context.fillText(text, bound(at, left, right - 8), bottom + 5);
    }
    context.fillText(told.x.label, (left + right) / 2, bottom + 21);
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const [value, text] of this.y.ticks((bottom - top) / 36)) {
      const at = Math.round(this.y.at(value)) + 0.5;
      segment(context, ink("grid"), left, at, right, at);
      context.fillStyle = ink("soft");
      context.fillText(text, left - 6, bound(at, top + 5, bottom - 4));
    }
    context.save();
    context.translate(11, (top + bottom) / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(told.y.label, 0, 0);
    context.restore();
    context.strokeStyle = ink("line");
    context.strokeRect(left + 0.5, top + 0.5, right - left - 1, bottom - top - 1);
  }
  curves(context, told, ink) {
    const { left, right, top, bottom } = this.box;
    clipped(context, left, top, right, bottom);
    for (const line of told.lines) {
      context.strokeStyle = ink(`style${line.style % STYLES}`);
      context.lineWidth = line.thin ? 1.2 : 2.2;
      context.setLineDash(DASHES[line.style % STYLES]);
      context.beginPath();
      let pen = false;
      for (let k = 0; k < line.x.length; k++) {
        const x = this.x.at(line.x[k]), y = this.y.at(line.y[k]);
        if (isNaN(x) || isNaN(y)) { pen = false; continue; }
        if (pen) context.lineTo(x, bound(y, -1e4, 1e4)); else context.moveTo(x, bound(y, -1e4, 1e4));
        pen = true;
      }
      context.stroke();
    }
    context.setLineDash([]);
    context.textBaseline = "bottom";
    for (const mark of told.marks) {
      const x = this.x.at(mark.x), y = this.y.at(mark.y);
      context.fillStyle = ink("paper");
      context.strokeStyle = ink(`style${mark.style % STYLES}`);
      context.lineWidth = 2;
      context.beginPath();
      context.arc(x, y, 4.5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
      if (!mark.label) continue;
      const wide = context.measureText(mark.label).width;
      context.textAlign = x + wide + 12 > right ? "right" : "left";
      context.fillStyle = ink("ink");
      context.fillText(mark.label, x + (context.textAlign === "right" ? -8 : 8), Math.max(y - 4, top + 14));
    }
    context.restore();
  }
  // What the picture says, for those who see it and for those who do not.
  name(told, ink) {
    const named = [...new Map(told.lines.filter((l) => l.label).map((l) => [l.label, l])).values()];
    const marks = told.marks.filter((m) => m.label).map((m) => `${m.label} at ${number(m.x, 3, LARGEST)}, ${number(m.y, 3, LARGEST)}`);
    const curves = named.length ? ` of ${named.map((l) => l.label).join(", ")}` : "";
    const text = `${told.title}${curves}: ${told.y.label} over ${told.x.label}. ${marks.join("; ")}`;
    this.canvas.setAttribute("aria-label", text);
    const key = JSON.stringify([told.title, named.map((l) => [l.label, l.style, l.thin]), ink("ink")]);
    if (key === this.key) return;
    this.key = key;
    this.caption.textContent = told.title;
    this.legend.replaceChildren();
    for (const line of named) {
      const item = make(this.legend, "span");
      const sample = make(item, "canvas", { width: 56, height: 12 }, { "aria-hidden": "true" }).getContext("2d");
      sample.scale(2, 2);
      sample.strokeStyle = ink(`style${line.style % STYLES}`);
      sample.lineWidth = line.thin ? 1.2 : 2.2;
      sample.setLineDash(DASHES[line.style % STYLES]);
      sample.beginPath();
      sample.moveTo(0, 3);
      sample.lineTo(28, 3);
      sample.stroke();
      item.append(line.label);
    }
  }
}

class Sliders {
  constructor(model, el) {
    this.model = model;
    this.settings = { ...model.get("settings") };
    this.root = make(el, "div", { className: "rbfound-sliders" });
    const inner = make(this.root, "div", { className: "rbs-inner" });
    this.inputs = make(inner, "div", { className: "rbs-inputs" });
    for (const control of model.get("controls")) this[control.kind](control);
    this.message = make(inner, "p", { className: "rbs-message", hidden: true }, { role: "status" });
    this.figures = make(inner, "div", { className: "rbs-figures" });
    this.tables = make(this.figures, "div", { className: "rbs-tables" });
    this.plots = [];
    this.busy = false;
    this.watch();
    this.received();
  }
  slider(told) {
    const label = make(this.inputs, "label", { className: "rbs-slider" });
    const head = make(label, "span", { textContent: told.label });
    const shown = make(head, "output");
    const [low, high] = told.log ? [Math.log10(told.low), Math.log10(told.high)] : [told.low, told.high];
    const step = told.step ?? (high - low) / STEPS;
    const input = make(label, "input", { type: "range" }, { min: low, max: high, step: told.log ? "any" : step, name: told.name });
    input.value = told.log ? Math.log10(this.settings[told.name]) : this.settings[told.name];
    const show = () => {
      const value = this.settings[told.name];
      const text = `${Number.isInteger(told.step) ? value.toFixed(0) : number(value, 3, LARGEST)} ${told.unit}`.trim();
      shown.textContent = text;
      input.setAttribute("aria-valuetext", text);
    };
    input.oninput = (event) => {
      this.settings[told.name] = told.log ? 10 ** Number(input.value) : Number(input.value);
      show();
      this.send(event);
    };
    // with the step "any" a browser's own arrow keys take one whole decade
    input.onkeydown = (event) => {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[event.key];
      if (!steps) return;
      event.preventDefault();
      input.value = Number(input.value) + steps * step;
      input.oninput(event);
    };
    show();
  }
  switch(told) {
    const label = make(this.inputs, "label", { className: "rbs-switch" });
    const input = make(label, "input", { type: "checkbox", checked: this.settings[told.name] }, { name: told.name });
    label.append(told.label);
    input.onchange = (event) => { this.settings[told.name] = input.checked; this.send(event); };
  }
  choice(told) {
    const label = make(this.inputs, "label", { className: "rbs-choice" });
    make(label, "span", { textContent: told.label });
    const select = make(label, "select", {}, { name: told.name });
    for (const [value, text] of told.options) make(select, "option", { value, textContent: text });
    select.value = this.settings[told.name];
    select.onchange = (event) => { this.settings[told.name] = select.value; this.send(event); };
  }
  // The latest setting wins: while the host is busy, only the last of the others is kept.
  send(event) {
    this.asked ??= event.timeStamp;
    if (this.busy) { this.again = true; return; }
    this.busy = Math.ceil(Math.random() * 1e9);
    this.since = this.asked;
    this.asked = undefined;
    this.again = false;
    this.model.set("settings", { ...this.settings });
    this.model.set("stamp", this.busy);
    this.model.save_changes();
  }
  received() {
    const result = this.model.get("result");
    if (!result?.figures && !result?.message) return;
    const answered = result.stamp === this.busy;
    if (answered) this.busy = false;
    this.message.hidden = !result.message;
    this.message.textContent = result.message ?? "";
    if (result.figures) this.result = result;
    this.redraw();
    this.fill();
    const latency = answered ? performance.now() - this.since : null;
    this.root.dispatchEvent(new CustomEvent("rbfound-drawn", { bubbles: true, detail: { latency } }));
    if (this.again) this.send({ timeStamp: performance.now() });
  }
  redraw() {
    const told = this.result?.figures ?? [];
    while (this.plots.length < told.length) {
      this.plots.push(new Plot(this.figures));
      this.figures.append(this.tables);
    }
    this.style ??= getComputedStyle(this.root);
    const known = {};
    const ink = (name) => (known[name] ??= this.style.getPropertyValue(`--${name}`).trim());
    told.forEach((one, k) => this.plots[k].draw(one, ink));
  }
  fill() {
    const told = this.result?.tables ?? [];
    const shape = JSON.stringify(told.map((t) => [t.caption, Object.entries(t.columns).map(([n, c]) => [n, c.length])]));
    if (shape !== this.shape) {
      this.shape = shape;
      this.cells = [];
      this.tables.replaceChildren();
      for (const { caption, columns } of told) {
        const names = Object.keys(columns), table = make(make(this.tables, "div", { className: "rbs-scroll" }), "table");
        make(table, "caption", { textContent: caption });
        if (names.some((name) => name.trim())) {
          const row = make(make(table, "thead"), "tr");
          for (const name of names) make(row, "th", { textContent: name }, { scope: "col" });
        }
        const body = make(table, "tbody"), count = Math.max(...names.map((name) => columns[name].length), 0);
        for (let k = 0; k < count; k++) {
          const row = make(body, "tr");
          names.forEach((name, n) => {
            const cell = n ? make(row, "td") : make(row, "th", {}, { scope: "row" });
            this.cells.push([cell, (all) => all[told.findIndex((t) => t.caption === caption)].columns[name][k] ?? ""]);
          });
        }
      }
    }
    for (const [cell, text] of this.cells ?? []) {
      const now = minus(text(told));
      if (cell.textContent !== now) cell.textContent = now;
    }
  }
  watch() {
    const heard = () => this.received();
    this.model.on("change:result", heard);
    const size = new ResizeObserver(() => this.redraw());
    size.observe(this.figures);
    const themed = theming(this.root, () => this.redraw());
    this.remove = () => {
      this.model.off?.("change:result", heard);
      size.disconnect();
      themed();
    };
  }
}

function render({ model, el }) {
  const sliders = new Sliders(model, el);
  return () => sliders.remove();
}
export default { render };
