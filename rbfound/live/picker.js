// The peak picker: FRFs on a canvas, peaks that can be moved, and what follows from them. No library, no network; what
// it shares with the sliders stands before it, in core.js.
//
// Its host computes. It is spoken to through model.get, model.set, model.save_changes and model.on("change:name"), as
// anywidget gives them; any page that supplies these four can be the host. One that has model.send too is sent what has
// changed as a message. The host gives `scene` and `data` once, takes `peaks`, `method` and `stamp`, and answers with
// `result` (which bears the stamp) and `curves`: see rbfound/live/frontend.py.

const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3], [4, 2], [12, 4]];
const NEAR = { mouse: 9, touch: 22, pen: 14 };
const WIDE = { left: 62, right: 14, lane: 46, gap: 12, foot: 34, comb: 62 };
const PATIENCE = 4000, AHEAD = 2;

// Bytes of any kind, as a host may hand them over, as 32-bit floats.
function floats(bytes) {
  if (!bytes || !bytes.byteLength) return new Float32Array(0);
  const { buffer, byteOffset, byteLength } = ArrayBuffer.isView(bytes) ? bytes : new Uint8Array(bytes);
  return new Float32Array(buffer.slice(byteOffset, byteOffset + byteLength));
}

// A notebook that was made a page carries the state of its widgets in it, and no kernel is behind.
const isPrinted = () => document.querySelector('script[type="application/vnd.jupyter.widget-state+json"]') !== null;

// Curves over lines [Hz]: pairs of seats to real and imaginary parts, and whatever is drawn of them, made when asked for.
class Curves {
  constructor(values, count, pairs) {
    this.lines = values.subarray(0, count);
    this.parts = values.subarray(count);
    this.pairs = pairs;
    this.made = new Map();
  }
  has(i, j) { return this.lines.length > 0 && this.pairs(i, j) >= 0; }
  of(i, j, kind) {
    const key = `${i},${j},${kind}`;
    if (!this.made.has(key)) this.made.set(key, this.compute(i, j, kind));
    return this.made.get(key);
  }
  compute(i, j, kind) {
    const n = this.lines.length, from = 2 * n * this.pairs(i, j), p = this.parts, out = new Float32Array(n);
    for (let k = 0; k < n; k++) {
      const re = p[from + 2 * k], im = p[from + 2 * k + 1];
      if (kind === "real") out[k] = re;
      else if (kind === "imaginary") out[k] = im;
      else if (kind === "magnitude") out[k] = Math.hypot(re, im);
      else if (kind === "log") out[k] = Math.log10(Math.max(Math.hypot(re, im), 1e-30));
      else {
        // from -225 to 135 degrees: neither a response in phase nor one against it lies on the seam
        const angle = (Math.atan2(im, re) * 180) / Math.PI;
        out[k] = angle > 135 ? angle - 360 : angle;
      }
    }
    return out;
  }
  // First line at or above a frequency.
  at(frequency) {
    let low = 0, high = this.lines.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.lines[middle] < frequency) low = middle + 1; else high = middle;
    }
    return low;
  }
  value(i, j, kind, frequency) {
    const k = bound(this.at(frequency), 1, this.lines.length - 1), v = this.of(i, j, kind);
    const t = (frequency - this.lines[k - 1]) / (this.lines[k] - this.lines[k - 1]);
    return v[k - 1] + bound(t, 0, 1) * (v[k] - v[k - 1]);
  }
}

class Picker {
  constructor(model, el) {
    this.model = model;
    this.scene = model.get("scene");
    this.seats = this.scene.labels.length;
    const s = this.seats;
    this.data = new Curves(floats(model.get("data")), this.scene.lines, (i, j) => i * s + j);
    [this.first, this.last] = [this.data.lines[0], this.data.lines[this.data.lines.length - 1]];
    this.peaks = model.get("peaks") ?? [];
    this.method = model.get("method");
    this.memory = { ...this.scene.first };
    this.selected = 0;
    this.shown = new Set(this.scene.labels.map((_, k) => k * s + k));
    this.kind = "bode";
    this.logarithmic = { frequency: false, amplitude: true };
    this.range = null;
    this.view = this.whole();
    this.pointers = new Map();
    this.handles = [];
    this.cleanups = [];
    this.asking = new Map();
    this.build(el);
    this.listen();
    this.received();
    this.renderPeaks();
  }

  // ---- the page ----
  build(el) {
    const root = (this.root = make(el, "div", { className: "rbfound-picker" }));
    quiet(root);
    const inner = make(root, "div", { className: "rbp-inner" });
    const bar = make(inner, "div", { className: "rbp-bar" });
    const choice = (text, options, value, change) => {
      const label = make(bar, "label", { textContent: text });
      const select = make(label, "select", {}, { "aria-label": text });
      for (const [key, name] of options) make(select, "option", { value: key, textContent: name });
      select.value = value;
      select.onchange = () => change(select.value);
      return select;
    };
    this.methodChoice = choice("Method", this.scene.methods, this.method, (v) => this.choose(v));
    choice("Show", [["bode", "magnitude, phase"], ["parts", "real, imaginary"]], this.kind, (v) => {
      this.kind = v;
      this.amplitude.disabled = v === "parts";
      this.range = null;
      this.redraw(true);
    });
    choice("Frequency", [["", "linear"], ["log", "logarithmic"]], "", (v) => {
      this.logarithmic.frequency = Boolean(v);
      this.view.low = Math.max(this.view.low, this.lowest());
      this.redraw(true);
    });
    this.amplitude = choice("Amplitude", [["log", "logarithmic"], ["", "linear"]], "log", (v) => {
      this.logarithmic.amplitude = Boolean(v);
      this.range = null;
      this.redraw(true);
    });
    this.buildChoice(bar);
    const main = make(inner, "div", { className: "rbp-main" });
    const left = make(main, "div", { className: "rbp-left" });
    this.plot = make(left, "div", { className: "rbp-plot" });
    this.base = make(this.plot, "canvas", {}, { "aria-hidden": "true" });
    this.front = make(this.plot, "canvas", { tabIndex: 0 }, { role: "img" });
    this.lane = make(this.plot, "div", { className: "rbp-lane" }, { role: "group", "aria-label": "Peaks" });
    this.buildZoom();
    this.alone = isPrinted();
    if (this.alone) this.buildNote(left);
    const legend = make(left, "p", { className: "rbp-legend" });
    for (const [kind, text] of [["data", "data"], ["fit", "picked foundation"], ["peak", "peak"], ["half", "half-power points"]]) {
      make(make(legend, "span", { textContent: ` ${text}` }), "i", { className: `is-${kind}` });
    }
    this.message = make(left, "p", { className: "rbp-message", hidden: true }, { role: "status" });
    this.buildFindings(left);
    this.list = make(left, "div", { className: "rbp-peaks" });
    this.spoken = make(left, "p", { className: "rbp-spoken" }, { "aria-live": "polite" });
    this.buildHelp(left);
    this.side = make(main, "div", { className: "rbp-side" });
    this.below = make(main, "div", { className: "rbp-side rbp-below" });
  }

  buildNote(parent) {
    const note = make(parent, "p", { className: "rbp-message rbp-note",
      textContent: "No Python runs behind this page: peaks can be moved here, but nothing follows them." });
    const live = document.querySelector('a[href$="/live.html"]');
    if (!live) return;
    note.append(" On the page ");
    make(note, "a", { href: live.href, textContent: "Live" });
    note.append(" everything does.");
  }

  // What a check of the data warns of; open where it does.
  buildFindings(parent) {
    const found = this.scene.findings ?? [], many = found.length === 1 ? "1 warning" : `${found.length} warnings`;
    const part = make(parent, "details", { className: `rbp-findings${found.length ? " rbp-message" : ""}`, open: found.length > 0 });
    make(part, "summary", { textContent: `Check of the data: ${found.length ? many : "nothing to warn of"}` });
    const list = make(part, "ul");
    for (const text of [...found, this.scene.size]) make(list, "li", { textContent: text });
  }

  buildChoice(bar) {
    const details = make(bar, "details", { className: "rbp-choice" });
    this.count = make(details, "summary");
    const panel = make(details, "div", { className: "rbp-panel" });
    const table = make(panel, "table"), { labels } = this.scene, s = this.seats;
    make(table, "caption", { textContent: "Response (rows) to a force (columns)" });
    const head = make(make(table, "thead"), "tr"), boxes = [];
    make(head, "td");
    for (const label of labels) make(head, "th", { textContent: label, scope: "col" });
    const body = make(table, "tbody");
    labels.forEach((response, i) => {
      const row = make(body, "tr");
      make(row, "th", { textContent: response, scope: "row" });
      labels.forEach((force, j) => {
        const box = make(make(row, "td"), "input", { type: "checkbox" },
          { "aria-label": `response ${response}, force ${force}` });
        box.onchange = () => { this.shown[box.checked ? "add" : "delete"](i * s + j); this.choiceChanged(); };
        boxes.push(box);
      });
    });
    const row = make(panel, "div", { className: "rbp-row" });
    const preset = (text, keep) => {
      make(row, "button", { type: "button", textContent: text }).onclick = () => {
        this.shown = new Set(boxes.map((_, k) => k).filter((k) => keep(Math.floor(k / s), k % s)));
        this.choiceChanged();
      };
    };
    preset("driving points", (i, j) => i === j);
    preset("of the selected peak", (i, j) => j === this.seatOf(this.selected));
    preset("all", () => true);
    this.choiceChanged = () => {
      boxes.forEach((box, k) => { box.checked = this.shown.has(k); });
      this.count.textContent = `FRFs: ${this.shown.size} of ${s * s}`;
      this.redraw(true);
    };
    details.onkeydown = (event) => {
      if (event.key === "Escape") { details.open = false; this.count.focus(); }
    };
    this.on(document, "pointerdown", (event) => { if (!details.contains(event.target)) details.open = false; });
    this.choiceChanged();
  }

  buildZoom() {
    const box = make(this.plot, "div", { className: "rbp-zoom" });
    const button = (text, name, act) => {
      make(box, "button", { type: "button", textContent: text, title: name }, { "aria-label": name }).onclick = act;
    };
    button("+", "Zoom in", () => this.zoom(1 / 1.5));
    button("−", "Zoom out", () => this.zoom(1.5));
    button("⤢", "Show the whole band", () => this.reset());
  }

  buildHelp(parent) {
    const help = make(parent, "details", { className: "rbp-help" });
    make(help, "summary", { textContent: "Mouse, touch and keys" });
    const list = make(help, "ul");
    for (const text of [
      "Drag a peak's line or its name; a double click puts it on the nearest maximum. Drag the two squares of the selected peak to change its half-power width.",
      "← and → move the selected peak by a line, with Shift by a tenth, Page Up and Page Down by ten; ↑ and ↓ widen and " +
        "narrow it. Tab goes to the next peak. Home puts it on the nearest maximum.",
      "Delete removes a peak, Insert or Enter adds one.",
      "Wheel (once the picture has been clicked), pinch, + and − zoom; with Shift the amplitude. Drag the background to " +
        "pan; double click or 0 shows the whole band.",
    ]) make(list, "li", { textContent: text });
  }

  on(target, name, act, options) {
    target.addEventListener(name, act, options);
    this.cleanups.push(() => target.removeEventListener(name, act, options));
  }

  listen() {
    const { plot, model } = this;
    this.on(plot, "pointerdown", (e) => this.down(e));
    this.on(plot, "pointermove", (e) => this.move(e));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) this.on(plot, name, (e) => this.up(e));
    // a finger on a peak, or two of them, have the picture; one on the background goes up and down with the page
    this.on(plot, "touchmove", (e) => { if (e.cancelable && (this.drag?.pinch || this.drag?.k !== undefined)) e.preventDefault(); },
      { passive: false });
    this.on(plot, "wheel", (e) => this.wheel(e), { passive: false });
    this.on(plot, "dblclick", (e) => this.twice(e));
    this.on(plot, "keydown", (e) => this.key(e));
    const heard = { "change:result": () => this.received(), "change:peaks": () => this.told(), "change:method": () => this.told() };
    for (const [name, act] of Object.entries(heard)) {
      model.on(name, act);
      this.cleanups.push(() => model.off?.(name, act));
    }
    const size = new ResizeObserver(() => this.redraw(true));
    size.observe(plot);
    const themed = theming(this.root, () => { this.colour(); this.redraw(true); });
    this.cleanups.push(() => size.disconnect(), themed, () => clearTimeout(this.timer));
  }

  remove() {
    this.removed = true;
    for (const cleanup of this.cleanups) cleanup();
  }

  // The sheet's colours; before the picker is part of the page there are none.
  colour() {
    const style = getComputedStyle(this.root);
    const known = {};
    this.ink = (name) => (known[name] ||= style.getPropertyValue(`--${name}`).trim());
    this.colours = this.scene.labels.map((_, k) => this.ink(`seat${k % 6}`));
  }

  // ---- the host ----
  // A few questions may be on their way, so that the host need not wait for the picture; of those that would be more,
  // the latest counts. A notebook lets one change of a model through at a time, but messages at once.
  send() {
    if (this.asking.size >= (this.model.send ? AHEAD : 1)) { this.again = true; return; }
    this.again = false;
    const stamp = Math.ceil(Math.random() * 1e9);
    const asked = { peaks: this.peaks.map((p) => ({ ...p })), method: this.method, stamp };
    this.asking.set(stamp, this.moved ?? performance.now());
    for (const [name, value] of Object.entries(asked)) this.model.set(name, value);
    clearTimeout(this.timer);
    try {
      if (this.model.send) this.model.send(asked); else this.model.save_changes();
    } catch {
      // a notebook whose kernel is gone
      this.alone = true;
    }
    if (this.alone) {
      this.asking.clear();
      this.say("No Python runs behind this picture: what is shown belongs to the peaks as they were before.", "stale");
      return;
    }
    this.timer = setTimeout(() => this.waiting(), 300);
  }
  waiting() {
    this.root.setAttribute("aria-busy", "true");
    this.say(this.method === "identify" ? "Fitting all modes…" : "Computing…", "wait");
    this.timer = setTimeout(() => {
      this.say("Python has not answered: what is shown belongs to the peaks as they were before.", "stale");
      this.asking.clear();
    }, this.method === "identify" ? 10 * PATIENCE : PATIENCE);
  }
  received() {
    const result = this.model.get("result");
    if (!result || !Object.keys(result).length) return;
    this.asked = this.asking.get(result.stamp);
    // answers come in order: one that was skipped does not come any more
    for (const stamp of this.asked === undefined ? [] : [...this.asking.keys()]) {
      this.asking.delete(stamp);
      if (stamp === result.stamp) break;
    }
    if (!this.asking.size) clearTimeout(this.timer);
    this.root.removeAttribute("aria-busy");
    this.result = result;
    if (!result.message) {
      this.good = result;
      const values = floats(this.model.get("curves")), s = this.seats;
      const count = values.length / (1 + s * (s + 1));
      this.fit = new Curves(values, count, (i, j) => {
        const [a, b] = i < j ? [i, j] : [j, i];
        return a * s - (a * (a - 1)) / 2 + b - a;
      });
    }
    this.say(result.message, "stale");
    this.fresh = true;
    // at once rather than with the next frame, and the next question before the tables: the hand does not wait
    if (this.again) this.send();
    this.draw();
    this.renderSide();
  }
  // The host has other peaks or another method than this view.
  told() {
    const peaks = this.model.get("peaks") ?? [], method = this.model.get("method");
    if (this.drag || this.asking.size || (same(peaks, this.peaks) && method === this.method)) return;
    [this.peaks, this.method] = [peaks.map((p) => ({ ...p })), method];
    this.methodChoice.value = method;
    this.selected = bound(this.selected, 0, Math.max(peaks.length - 1, 0));
    this.renderPeaks();
  }
  say(text, kind) {
    this.message.hidden = !text;
    this.message.textContent = text;
    this.message.className = `rbp-message is-${kind}`;
    const stale = Boolean(text) && kind === "stale";
    if (stale && this.good) make(this.message, "span", { textContent: " Greyed: the last foundation that could be had." });
    for (const part of [this.side, this.below]) part.classList.toggle("is-stale", stale);
    this.stale = stale;
  }
  choose(method) {
    this.memory[this.method] = this.peaks;
    this.method = method;
    if (method !== "identify") this.peaks = this.memory[method] ?? this.peaks;
    this.selected = 0;
    this.renderPeaks();
    this.send();
  }

  // ---- peaks ----
  found() { return this.method === "identify"; }
  marks() {
    if (!this.found()) return this.peaks;
    return this.good?.method === "identify" ? this.good.peaks : [];
  }
  // Which seat a peak is read at: its own, or the one that the host last found to see it best.
  seatOf(k) {
    const peak = this.marks()[k], { good } = this;
    if (!peak || this.found()) return -1;
    if (this.method === "distinct" && good?.method === "distinct") {
      const column = good.order.indexOf(k);
      if (column >= 0 && good.order.length === this.peaks.length) return this.scene.labels.indexOf(good.peaks[column].seat);
    }
    return this.scene.labels.indexOf(peak.seat);
  }
  reading(seat, frequency) {
    const own = this.scene.readings[seat] ?? [];
    return own.reduce((best, p) =>
      !best || Math.abs(p.frequency - frequency) < Math.abs(best.frequency - frequency) ? p : best, null);
  }
  // Half-power points and level of a peak as they are drawn.
  width(k) {
    const peak = this.marks()[k], seat = this.seatOf(k);
    if (!peak) return null;
    if (seat < 0 || peak.damping !== null && peak.damping !== undefined) {
      const zeta = peak.damping ?? 0, f = peak.frequency;
      const height = seat < 0 ? NaN : this.data.value(seat, seat, "magnitude", f);
      return { low: f * (1 - zeta), high: f * (1 + zeta), height, damping: zeta, read: false };
    }
    const p = this.reading(seat, peak.frequency);
    return p && { ...p, damping: (p.high - p.low) / (2 * p.frequency), read: true };
  }
  name(k) {
    const seat = this.seatOf(k);
    return seat < 0 ? `${k + 1}` : this.scene.labels[seat];
  }
  describe(k) {
    const peak = this.marks()[k], w = this.width(k);
    if (!peak) return "No peak is selected.";
    const damped = w ? `, damping ratio ${number(100 * w.damping, 3)} percent${w.read ? "" : ", set by hand"}` : "";
    return `Peak ${this.name(k)}, ${number(peak.frequency)} hertz${this.found() ? ", found by the fit" : damped}`;
  }
  moveTo(k, frequency) {
    if (this.found() || !this.peaks[k]) return;
    const inside = bound(frequency, Math.max(this.first, 1e-9), this.last);
    if (inside === this.peaks[k].frequency) return;
    this.peaks[k].frequency = inside;
    this.changed(k);
  }
  setDamping(k, damping) {
    if (this.found() || !this.peaks[k]) return;
    this.peaks[k].damping = damping === null ? null : bound(damping, 1e-5, 0.9);
    this.changed(k);
  }
  snap(k) {
    const peak = this.peaks[k], seat = this.seatOf(k);
    const near = peak && this.reading(seat, peak.frequency);
    if (!near || this.found()) return;
    Object.assign(peak, { frequency: near.frequency, damping: null });
    this.changed(k);
  }
  // The question first: the line is drawn while it is on its way.
  changed(k) {
    this.send();
    this.lineMoved ??= this.moved;
    this.speak(k);
    this.redraw();
  }
  // Said once the hand rests: a screen reader would otherwise never come to an end.
  speak(k) {
    clearTimeout(this.speaking);
    this.speaking = setTimeout(() => { this.spoken.textContent = `${this.describe(k)}.`; }, 250);
  }
  select(k, focus) {
    this.selected = k;
    this.updateHandles();
    if (focus) this.handles[k]?.focus({ preventScroll: true });
    this.speak(k);
    this.redraw();
  }
  add() {
    if (this.found()) return this.tell("The fit finds its modes itself: no peak can be added.");
    const labels = this.scene.labels, taken = this.peaks.map((p) => p.seat);
    const missing = this.peaks.length < labels.length ? labels.find((label) => !taken.includes(label)) ?? labels[0] : null;
    if (missing === null) return this.tell("Every seat has its peak: delete one first.");
    // the highest maximum in sight that has no peak yet
    const free = (f) => this.peaks.every((p) => Math.abs(p.frequency / f - 1) > 0.03);
    const [best] = this.scene.readings[labels.indexOf(missing)]
      .filter((p) => p.frequency > this.view.low && p.frequency < this.view.high && free(p.frequency))
      .sort((a, b) => b.height - a.height);
    const frequency = best?.frequency ?? this.frequency((this.box.left + this.box.right) / 2);
    this.peaks.push({ seat: missing, frequency, damping: null });
    this.renderPeaks();
    this.select(this.peaks.length - 1, true);
    this.send();
  }
  delete(k) {
    if (this.found()) return this.tell("The fit finds its modes itself: none can be deleted here.");
    if (!this.peaks[k]) return;
    this.peaks.splice(k, 1);
    this.renderPeaks();
    this.select(bound(k, 0, Math.max(this.peaks.length - 1, 0)), true);
    if (!this.peaks.length) this.front.focus({ preventScroll: true });
    this.send();
  }
  tell(text) { clearTimeout(this.speaking); this.spoken.textContent = text; }

  renderPeaks() {
    const peaks = this.marks(), fixed = this.found();
    this.lane.replaceChildren();
    this.handles = peaks.map((_, k) => {
      const handle = make(this.lane, "div", { className: "rbp-handle", tabIndex: 0 }, {
        role: "slider", "aria-valuemin": this.first, "aria-valuemax": this.last, "aria-orientation": "horizontal",
      });
      if (fixed) handle.setAttribute("aria-readonly", "true");
      handle.onfocus = () => { if (this.selected !== k) this.select(k); };
      return handle;
    });
    this.list.replaceChildren();
    this.rows = fixed ? [] : this.peakTable(peaks);
    this.updateHandles();
    this.redraw();
  }
  peakTable(peaks) {
    const table = make(this.list, "table"), head = make(make(table, "thead"), "tr");
    for (const [text, unit] of [["Peak"], ["Frequency", "Hz"], ["Half power", "Hz"], ["Width", "Hz"], ["Damping", "%"], [""]]) {
      const cell = text ? make(head, "th", { textContent: text, scope: "col" }) : make(head, "td");
      if (unit) make(cell, "small", { textContent: ` [${unit}]` });
    }
    const body = make(table, "tbody");
    const rows = peaks.map((_, k) => {
      const row = make(body, "tr");
      row.onpointerdown = () => { if (this.selected !== k) this.select(k); };
      const name = make(row, "th", { scope: "row" });
      const field = (act) => {
        const input = make(make(row, "td"), "input", { type: "number", step: "any" });
        input.onchange = () => { if (input.value !== "") act(Number(input.value)); };
        input.onfocus = () => { if (this.selected !== k) this.select(k); };
        return input;
      };
      const frequency = field((v) => this.moveTo(k, v));
      const points = make(row, "td"), width = make(row, "td");
      const damping = field((v) => this.setDamping(k, v / 100));
      const acts = make(row, "td", { className: "rbp-acts" });
      const snap = make(acts, "button", { type: "button", textContent: "snap", title: "Put it on the nearest maximum" });
      snap.onclick = () => this.snap(k);
      const gone = make(acts, "button", { type: "button", textContent: "×", title: "Delete" });
      gone.onclick = () => this.delete(k);
      return { row, name, frequency, points, width, damping, snap, gone };
    });
    const foot = make(this.list, "div", { className: "rbp-row" });
    if (peaks.length < this.seats) {
      make(foot, "button", { type: "button", textContent: "Add a peak" }).onclick = () => this.add();
    }
    make(foot, "button", { type: "button", textContent: "Peaks as at first" }).onclick = () => {
      this.peaks = this.scene.first[this.method].map((p) => ({ ...p }));
      this.renderPeaks();
      this.send();
    };
    return rows;
  }

  updateHandles() {
    const peaks = this.marks();
    if (this.handles.length !== peaks.length) return this.renderPeaks();
    peaks.forEach((peak, k) => {
      const handle = this.handles[k], name = this.name(k), seat = this.seatOf(k), on = k === this.selected;
      const text = on && !this.found() && !this.box?.narrow ? `${name}  ${number(peak.frequency)} Hz` : name;
      put(handle, text);
      this.dress(handle, seat, on);
      attribute(handle, "aria-label", `Peak ${name}`);
      attribute(handle, "aria-valuenow", peak.frequency.toFixed(2));
      attribute(handle, "aria-valuetext", this.describe(k));
      const row = this.rows[k];
      if (row) this.updateRow(row, peak, k, name, seat, on);
    });
    attribute(this.front, "aria-label", `Frequency response functions of ${[...this.shown].map((c) => this.pair(c)).join(", ")}` +
      ` from ${number(this.view.low)} to ${number(this.view.high)} hertz. Peaks: ${peaks.map((p, k) =>
        `${this.name(k)} at ${number(p.frequency)} hertz`).join(", ") || "none"}.`);
  }
  updateRow(row, peak, k, name, seat, on) {
    const w = this.width(k), fill = (input, value) => { if (document.activeElement !== input) put(input, value, "value"); };
    this.dress(row.row, seat, on);
    put(row.name, name);
    fill(row.frequency, peak.frequency.toFixed(2));
    attribute(row.frequency, "aria-label", `frequency of peak ${name} in hertz`);
    put(row.points, w ? `${w.low.toFixed(1)} … ${w.high.toFixed(1)}` : "–");
    put(row.width, w ? (w.high - w.low).toFixed(2) : "–");
    fill(row.damping, w ? (100 * w.damping).toPrecision(3) : "");
    attribute(row.damping, "aria-label", `damping ratio of peak ${name} in percent`);
    put(row.damping, w?.read ? "read from the curve" : "set by hand; snap reads it from the curve again", "title");
    row.damping.classList.toggle("is-own", !w?.read);
    attribute(row.snap, "aria-label", `snap peak ${name} to the nearest maximum`);
    attribute(row.gone, "aria-label", `delete peak ${name}`);
  }
  // Colour and stroke of a peak's seat.
  dress(node, seat, on) {
    const own = seat < 0 ? this.ink("ink") : this.colours[seat];
    const style = ["solid", "dashed", "dotted", "double"][Math.max(seat, 0) % 4];
    node.classList.toggle("is-on", on);
    if (node.worn === own + style) return;
    node.worn = own + style;
    node.style.setProperty("--own", own);
    node.style.setProperty("--style", style);
  }
  pair(code) {
    const { labels } = this.scene;
    return `${labels[Math.floor(code / this.seats)]} to ${labels[code % this.seats]}`;
  }

  // ---- what follows from the peaks ----
  // Built when its shape changes; then only what differs is written, as this happens with each move.
  renderSide() {
    const { good } = this;
    if (!good) return;
    const shape = JSON.stringify([good.Phi[0].length, good.fit, good.matrices ? 0 : good.coordinates, good.under.length, good.alone.length]);
    if (shape !== this.shape) {
      this.shape = shape;
      this.fills = [];
      this.buildSide(good);
    }
    for (const fill of this.fills) fill(this.good);
  }
  buildSide(good) {
    const box = document.createDocumentFragment(), below = document.createDocumentFragment();
    this.buildCondition(box);
    if (good.fit) this.buildFit(box, good.fit);
    this.buildMatrix(box, "Φ", "", "1/√kg", ", a column for each peak", good.Phi[0].length, (told) => told.Phi,
      (told) => told.columns.map((c) => c.replace(/ (?=[\d.]+ Hz)/, "\n")));
    if (good.matrices) {
      for (const [name, unit] of [["M", "kg"], ["C", "N s/m"], ["K", "N/m"]]) {
        this.buildMatrix(box, name, "e", unit, "", this.seats, (told) => told.matrices[name], () => this.scene.labels);
      }
    } else {
      const part = this.card(box, "M, C, K");
      make(part, "p", { textContent: `${good.coordinates} modal coordinates: M is the unit matrix, C = diag(2ζω) and ` +
        "K = diag(ω²). Φ shows the modes of the band." });
    }
    if (this.scene.rotor) this.buildFrequencies(below, "Under the rotor at rest", "under", good.under.length);
    this.buildFrequencies(below, "Foundation alone", "alone", good.alone.length);
    this.side.replaceChildren(box);
    this.below.replaceChildren(below);
  }
  // What the fit of all modes is worth: its misfit FRF by FRF, its modes, and apart from them those that are none.
  buildFit(box, { unit, misfit, noise, much, modes, residual, band }) {
    const { labels } = this.scene, part = this.card(box, "Misfit", "rbp-scroll");
    make(part.firstChild, "small", { textContent: ` [${unit}], root mean square of each FRF; noise ${number(noise, 2)}` });
    this.plain(part, ["", ...labels], misfit.map((row, i) => [labels[i], ...row.map((value) => number(value, 2))]),
      (i, j) => misfit[i][j - 1] > much);
    const own = this.card(box, `Modes from ${number(band[0], 3)} to ${number(band[1], 3)} Hz`, "rbp-scroll");
    this.plain(own, ["", "frequency [Hz]", "damping [%]", ""],
      modes.map(([f, zeta, unsure], k) => [`${k + 1}`, f.toFixed(1), number(zeta, 3), unsure ? "unsure" : ""]));
    const many = residual.length === 1 ? "1 residual mode stands" : `${residual.length} residual modes stand`;
    make(own, "p", { textContent: `${many} for what lies outside this band, and ${residual.length === 1 ? "is" : "are"} not listed.` });
  }
  plain(part, names, rows, marked = () => false) {
    const table = make(part, "table", { className: "rbp-plain" }), head = make(make(table, "thead"), "tr");
    for (const name of names) name ? make(head, "th", { textContent: name, scope: "col" }) : make(head, "td");
    const body = make(table, "tbody");
    rows.forEach((cells, i) => {
      const row = make(body, "tr");
      cells.forEach((text, k) => k ? make(row, "td", { textContent: text, className: marked(i, k) ? "is-off" : "" })
        : make(row, "th", { textContent: text, scope: "row" }));
    });
  }
  card(where, title, kind = "") {
    const part = make(where, "section", { className: `rbp-card ${kind}` });
    make(part, "h4", { textContent: title });
    return part;
  }
  buildCondition(box) {
    const part = this.card(box, "cond(Φ)", "rbp-cond"), value = make(part, "strong"), words = make(part, "span");
    const scale = make(part, "div", { className: "rbp-scale" }, { "aria-hidden": "true" }), point = make(scale, "i");
    const ends = make(part, "div", { className: "rbp-ends" }, { "aria-hidden": "true" });
    for (let k = 0; k <= 5; k++) make(ends, "span", { textContent: k ? tenTo(k) : "1" });
    this.fills.push(({ condition: c }) => {
      put(value, number(c, 3));
      put(words, c < 10 ? "the shapes are distinct" : c < 100 ? "the shapes are alike"
        : c < 1000 ? "two columns are nearly one mode" : "one mode twice: M, C, K are made of reading errors");
      point.style.left = `${bound(Math.log10(c) / 5, 0, 1) * 100}%`;
    });
  }
  buildMatrix(box, name, index, unit, note, count, values, columns) {
    const part = this.card(box, name, "rbp-scroll"), head = part.firstChild, long = count > this.seats;
    if (index) make(head, "sub", { textContent: index });
    const small = make(head, "small");
    part.tabIndex = long ? 0 : -1;
    const table = make(part, "table", { className: `rbp-matrix${long ? " is-long" : ""}` }), top = make(make(table, "thead"), "tr");
    make(top, "td");
    const names = Array.from({ length: count }, () => make(top, "th", { scope: "col" }));
    const body = make(table, "tbody");
    const cells = this.scene.labels.map((label) => {
      const row = make(body, "tr");
      make(row, "th", { textContent: label, scope: "row" });
      return names.map(() => make(row, "td"));
    });
    this.fills.push((told) => {
      const rows = values(told), size = Math.max(...rows.flat().map(Math.abs)) || 1;
      const power = size >= 1e4 || size < 1 ? Math.floor(Math.log10(size)) : 0;
      put(small, ` [${power ? `${tenTo(power)} ` : ""}${unit}]${note}`);
      columns(told).forEach((text, j) => put(names[j], text));
      rows.forEach((entries, i) => entries.forEach((entry, j) => {
        const cell = cells[i][j], value = entry / 10 ** power, text = Math.abs(value) < 0.01 ? value.toFixed(4)
          : Math.abs(value) < 1000 ? value.toPrecision(3) : value.toFixed(0);
        put(cell, minus(text));
        put(cell, value < 0 ? "is-minus" : "is-plus", "className");
        const share = `${Math.round((42 * Math.abs(entry)) / size)}%`;
        if (cell.share !== share) cell.style.setProperty("--share", (cell.share = share));
      }));
    });
  }
  buildFrequencies(box, title, key, count) {
    const part = this.card(box, title), compared = Boolean(this.scene.truth);
    make(part.firstChild, "small", { textContent: " [Hz]" });
    const table = make(part, "table", { className: "rbp-frequencies" }), head = make(make(table, "thead"), "tr");
    const names = compared ? ["truth", "picked", "off [%]"] : ["picked"];
    for (const name of names) make(head, "th", { textContent: name, scope: "col" });
    const body = make(table, "tbody");
    const cells = Array.from({ length: count }, () => {
      const row = make(body, "tr");
      return names.map(() => make(row, "td"));
    });
    this.fills.push((told) => told[key].forEach(([truth, found], k) => {
      const own = cells[k], hertz = (f) => (f ? f.toFixed(1) : "–");
      put(own[names.indexOf("picked")], hertz(found));
      if (!compared) return;
      put(own[0], hertz(truth));
      const off = truth && found ? 100 * (found / truth - 1) : null;
      put(own[2], off === null ? (truth ? "missing" : "extra")
        : Math.abs(off) < 0.005 ? "0.00" : minus(`${off < 0 ? "" : "+"}${off.toFixed(2)}`));
      put(own[2], off === null ? "is-word" : Math.abs(off) > 1 ? "is-off" : "", "className");
    }));
  }

  // ---- axes ----
  lowest() { return this.data.lines.find((f) => f > 0); }
  whole() { return { low: this.logarithmic.frequency ? Math.max(this.first, this.lowest()) : this.first, high: this.last }; }
  warp(f) { return this.logarithmic.frequency ? Math.log10(Math.max(f, 1e-9)) : f; }
  unwarp(u) { return this.logarithmic.frequency ? 10 ** u : u; }
  x(f) {
    const { left, right } = this.box, a = this.warp(this.view.low), b = this.warp(this.view.high);
    return left + ((this.warp(f) - a) / (b - a)) * (right - left);
  }
  frequency(x) {
    const { left, right } = this.box, a = this.warp(this.view.low), b = this.warp(this.view.high);
    return this.unwarp(a + ((x - left) / (right - left)) * (b - a));
  }
  look(low, high) {
    const whole = this.whole(), least = 4 * this.scene.step;
    if (high - low < least) return;
    const span = this.warp(high) - this.warp(low), most = this.warp(whole.high) - this.warp(whole.low);
    if (span >= most) this.view = whole;
    else {
      const from = bound(this.warp(low), this.warp(whole.low), this.warp(whole.high) - span);
      this.view = { low: this.unwarp(from), high: this.unwarp(from + span) };
    }
    this.redraw(true);
  }
  zoom(factor, at = (this.box.left + this.box.right) / 2) {
    const middle = this.warp(this.frequency(at)), a = this.warp(this.view.low), b = this.warp(this.view.high);
    this.look(this.unwarp(middle + (a - middle) * factor), this.unwarp(middle + (b - middle) * factor));
  }
  pan(dx) {
    const { left, right } = this.box, a = this.warp(this.view.low), b = this.warp(this.view.high);
    const d = (-dx / (right - left)) * (b - a), whole = this.whole();
    const shift = bound(d, this.warp(whole.low) - a, this.warp(whole.high) - b);
    this.view = { low: this.unwarp(a + shift), high: this.unwarp(b + shift) };
    this.redraw(true);
  }
  reset() {
    [this.view, this.range] = [this.whole(), null];
    this.redraw(true);
  }
  // The amplitude about a height of the upper panel.
  stretch(factor, y) {
    const { upper } = this.box, [a, b] = this.ranges[0];
    const at = b - ((y - upper[0]) / (upper[1] - upper[0])) * (b - a);
    this.range = [at + (a - at) * factor, at + (b - at) * factor];
    this.redraw(true);
  }

  // ---- pointer, wheel, keys ----
  place(event) {
    const box = this.front.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
  hit(x, y, reach) {
    const marks = this.marks();
    let best = null, least = reach;
    marks.forEach((peak, k) => {
      const d = Math.abs(this.x(peak.frequency) - x) - (k === this.selected ? 3 : 0);
      if (d < least) [best, least] = [{ k }, d];
    });
    const grips = this.grips;
    for (const side of grips ? ["low", "high"] : []) {
      const d = Math.hypot(grips[side] - x, grips.y - y);
      if (d < reach + 2 && d < Math.abs(this.x(marks[this.selected].frequency) - x) + 4) best = { k: this.selected, side };
    }
    return best;
  }
  down(event) {
    if (event.button > 0 || event.target.closest("button")) return;
    const [x, y] = this.place(event);
    this.pointers.set(event.pointerId, [x, y]);
    this.plot.setPointerCapture?.(event.pointerId);
    if (this.pointers.size === 2) {
      const xs = [...this.pointers.values()].map((p) => p[0]);
      this.drag = { pinch: xs.map((v) => this.warp(this.frequency(v))) };
      return;
    }
    const tag = event.target.closest(".rbp-handle");
    const hit = tag ? { k: this.handles.indexOf(tag) } : this.hit(x, y, NEAR[event.pointerType] ?? NEAR.mouse);
    if (event.pointerType !== "touch" || hit) event.preventDefault();
    if (!hit) {
      this.drag = { x, y };
      this.front.focus({ preventScroll: true });
      return;
    }
    this.select(hit.k, true);
    if (this.found()) return;
    this.drag = { ...hit, offset: hit.side ? 0 : this.x(this.marks()[hit.k].frequency) - x };
    this.plot.classList.add("is-dragging");
  }
  move(event) {
    const [x, y] = this.place(event), drag = this.drag;
    if (!this.pointers.has(event.pointerId)) {
      if (event.pointerType === "mouse") this.plot.classList.toggle("is-near", Boolean(this.hit(x, y, NEAR.mouse)));
      return;
    }
    const before = this.pointers.get(event.pointerId);
    this.pointers.set(event.pointerId, [x, y]);
    if (!drag) return;
    this.moved = event.timeStamp;
    if (drag.pinch) return this.pinch(drag.pinch);
    if (drag.k === undefined) {
      this.pan(x - before[0]);
      if (this.range) this.slide(y - before[1]);
    } else if (drag.side) {
      const f = this.peaks[drag.k].frequency;
      this.setDamping(drag.k, Math.max(drag.side === "low" ? 1 - this.frequency(x) / f : this.frequency(x) / f - 1, 1e-5));
    } else this.moveTo(drag.k, this.frequency(x + drag.offset));
  }
  pinch([u, v]) {
    const [[x], [z]] = [...this.pointers.values()], { left, right } = this.box;
    if (Math.abs(z - x) < 12) return;
    const rate = (v - u) / (z - x);
    if (rate > 0) this.look(this.unwarp(u + rate * (left - x)), this.unwarp(u + rate * (right - x)));
  }
  slide(dy) {
    const { upper } = this.box, [a, b] = this.range, d = (dy / (upper[1] - upper[0])) * (b - a);
    this.range = [a + d, b + d];
  }
  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    const { drag } = this;
    this.drag = null;
    this.plot.classList.remove("is-dragging");
    if (drag?.pinch && this.pointers.size) [this.drag] = [...this.pointers.values()].map(([x, y]) => ({ x, y }));
  }
  twice(event) {
    if (event.target.closest("button")) return;
    const tag = event.target.closest(".rbp-handle");
    const k = tag ? this.handles.indexOf(tag) : this.hit(...this.place(event), NEAR.mouse)?.k;
    if (k === undefined) this.reset(); else this.snap(k);
  }
  wheel(event) {
    // the page scrolls until the picture has been clicked
    if (!event.ctrlKey && !this.plot.contains(document.activeElement)) return;
    event.preventDefault();
    const [x, y] = this.place(event), turn = event.deltaY || event.deltaX;
    const factor = Math.exp(bound(turn * (event.deltaMode ? 20 : 1), -200, 200) / 400);
    if (event.shiftKey || event.altKey) this.stretch(factor, y); else this.zoom(factor, x);
  }
  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("button")) return;
    const on = event.target.closest(".rbp-handle"), k = on ? this.handles.indexOf(on) : -1;
    const step = this.scene.step * (event.shiftKey ? 0.1 : 1), peak = this.peaks[k], zeta = on && this.width(k)?.damping;
    const moves = { ArrowLeft: -step, ArrowRight: step, PageDown: -10 * step, PageUp: 10 * step };
    const widths = { ArrowUp: event.shiftKey ? 1.01 : 1.05, ArrowDown: 1 / (event.shiftKey ? 1.01 : 1.05) };
    const { key } = event;
    this.moved = event.timeStamp;
    if (key === "Insert" || key === "Enter") this.add();
    else if (key === "+" || key === "=") this.zoom(1 / 1.5, on ? this.x(this.marks()[k].frequency) : undefined);
    else if (key === "-" || key === "_") this.zoom(1.5, on ? this.x(this.marks()[k].frequency) : undefined);
    else if (key === "0") this.reset();
    else if (key === "Escape" && on) this.front.focus();
    else if (on && (key in moves || key in widths || ["Home", "Delete", "Backspace"].includes(key))) {
      if (this.found()) this.tell("The fit finds its modes itself: they cannot be moved.");
      else if (key in moves) this.moveTo(k, peak.frequency + moves[key]);
      else if (key in widths) this.setDamping(k, (zeta || 0.02) * widths[key]);
      else if (key === "Home") this.snap(k);
      else this.delete(k);
    } else if (!on && key in moves) this.pan(key === "ArrowLeft" || key === "PageUp" ? 40 : -40);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // ---- drawing ----
  redraw(all = false) {
    this.all = this.all || all;
    if (this.waitingFrame || this.removed) return;
    this.waitingFrame = requestAnimationFrame(() => {
      this.waitingFrame = 0;
      if (!this.removed) this.draw();
    });
  }
  draw() {
    const width = this.plot.clientWidth;
    if (!width || !this.handles) return;
    this.fitCanvas(width);
    const all = this.all;
    this.all = false;
    if (all) {
      this.colour();
      this.drawBase();
    }
    this.drawFront();
    this.updateHandles();
    this.placeHandles();
    // for those who measure: from the move to its line, and from the move that was asked about to what follows from it
    if (this.lineMoved) this.announce("rbfound-moved", this.lineMoved);
    this.lineMoved = undefined;
    if (this.fresh) this.announce("rbfound-drawn", this.asked);
    this.fresh = false;
  }
  announce(name, since) {
    const detail = { latency: since === undefined ? null : performance.now() - since, result: this.result };
    this.root.dispatchEvent(new CustomEvent(name, { bubbles: true, detail }));
  }
  fitCanvas(width) {
    const unit = Math.min(devicePixelRatio || 1, 3), narrow = width < 520;
    const combed = this.scene.rotor || this.scene.truth ? WIDE.comb : 0;
    const high = Math.round(bound(width * 0.62, 370, 460)) + combed;
    const left = narrow ? 50 : WIDE.left, right = width - (narrow ? 8 : WIDE.right);
    const end = high - WIDE.foot - combed, split = WIDE.lane + Math.round((end - WIDE.lane - WIDE.gap) * 0.64);
    this.box = {
      width, high, left, right, narrow, upper: [WIDE.lane, split], lower: [split + WIDE.gap, end],
      comb: combed ? [high - combed + 18, high - 6] : null,
    };
    this.unit = unit;
    for (const canvas of [this.base, this.front]) if (fitted(canvas, width, high, unit)) this.all = true;
  }
  context(canvas) {
    const context = cleared(canvas, this.box.width, this.box.high, this.unit);
    context.font = `${this.box.narrow ? 11 : 12}px system-ui, sans-serif`;
    return context;
  }
  // What the two panels show: the kind of curve, and how much of it.
  panels() {
    return this.kind === "bode" ? [this.logarithmic.amplitude ? "log" : "magnitude", "phase"] : ["real", "imaginary"];
  }
  pairsShown() {
    return [...this.shown].sort((a, b) => a - b).map((code) => [Math.floor(code / this.seats), code % this.seats]);
  }
  measure(kind) {
    if (kind === "phase") return [-230, 140];
    let low = Infinity, high = -Infinity;
    const from = this.data.at(this.view.low), to = this.data.at(this.view.high);
    for (const [i, j] of this.pairsShown()) {
      const v = this.data.of(i, j, kind);
      for (let k = from; k <= to && k < v.length; k++) {
        if (v[k] < low) low = v[k];
        if (v[k] > high) high = v[k];
      }
    }
    if (!(high > -Infinity)) return kind === "log" ? [-10, -6] : [0, 1];
    if (kind === "log") low = Math.max(low, high - 6);
    if (kind === "magnitude") low = 0;
    const room = 0.06 * (high - low || Math.abs(high) || 1);
    return [kind === "magnitude" ? 0 : low - room, high + room];
  }
  drawBase() {
    const context = this.context(this.base), { left, right, upper, lower } = this.box, kinds = this.panels();
    this.ranges = [this.range ?? this.measure(kinds[0]), this.measure(kinds[1])];
    this.drawFrequencyAxis(context);
    [upper, lower].forEach((panel, k) => {
      this.drawAmplitudeAxis(context, panel, kinds[k], this.ranges[k]);
      this.clip(context, panel);
      for (const [i, j] of this.pairsShown()) {
        context.strokeStyle = this.colours[j];
        context.lineWidth = i === j ? 1.5 : 1;
        context.setLineDash(DASHES[j % DASHES.length]);
        this.trace(context, this.data, i, j, k);
      }
      context.restore();
      context.strokeStyle = this.ink("line");
      context.strokeRect(left + 0.5, panel[0] + 0.5, right - left - 1, panel[1] - panel[0] - 1);
    });
    if (!this.shown.size) this.write(context, "No FRF is chosen.", (left + right) / 2, (upper[0] + upper[1]) / 2, "center");
  }
  clip(context, [top, bottom]) { clipped(context, this.box.left, top, this.box.right, bottom); }
  height(value, panel) {
    const [top, bottom] = panel ? this.box.lower : this.box.upper, [a, b] = this.ranges[panel];
    return bottom - ((value - a) / (b - a)) * (bottom - top);
  }
  // One curve: as it is where lines are few, its extremes in each column of pixels where they are many.
  trace(context, curves, i, j, panel) {
    const kind = this.panels()[panel], v = curves.of(i, j, kind), { lines } = curves, phase = kind === "phase";
    const from = Math.max(curves.at(this.view.low) - 1, 0), to = Math.min(curves.at(this.view.high) + 1, lines.length);
    context.beginPath();
    let column = NaN, low = 0, high = 0, last = 0, lost = true, before = 0;
    const flush = () => { if (high - low > 1) { context.lineTo(column, low); context.lineTo(column, high); } context.lineTo(column, last); };
    for (let k = from; k < to; k++) {
      const at = this.x(lines[k]), y = this.height(v[k], panel), px = Math.round(at * 2) / 2;
      const jump = phase && Math.abs(v[k] - before) > 180;
      before = v[k];
      if (lost || jump) {
        if (!lost) flush();
        context.moveTo(at, y);
        [column, low, high, last, lost] = [px, y, y, y, false];
      } else if (px === column) [low, high, last] = [Math.min(low, y), Math.max(high, y), y];
      else {
        flush();
        [column, low, high, last] = [px, y, y, y];
      }
    }
    if (!lost) flush();
    context.stroke();
  }
  drawFrequencyAxis(context) {
    const { left, right, upper, lower, narrow } = this.box, { low, high } = this.view, bottom = lower[1];
    const marks = this.logarithmic.frequency && high / low > 8
      ? decades(Math.log10(low) - 1, Math.log10(high), 12).flatMap((d) => [1, 2, 5].map((m) => m * 10 ** d)).filter((f) => f >= low && f <= high)
      : ticks(low, high, (right - left) / (narrow ? 64 : 84));
    const step = marks.length > 1 ? marks[1] - marks[0] : 1;
    let end = -Infinity;
    for (const f of marks) {
      const x = Math.round(this.x(f)) + 0.5;
      for (const [a, b] of [upper, lower]) segment(context, this.ink("grid"), x, a, x, b);
      const text = f >= 1 && step >= 1 ? f.toFixed(0) : String(Number(f.toPrecision(6)));
      const wide = context.measureText(text).width;
      if (x - wide / 2 < end + 6) continue;
      this.write(context, text, bound(x, wide / 2, this.box.width - wide / 2), bottom + 10, "center");
      end = x + wide / 2;
    }
    this.write(context, "frequency [Hz]", (left + right) / 2, bottom + 25, "center", "soft");
  }
  drawAmplitudeAxis(context, [top, bottom], kind, [low, high]) {
    const { left, right } = this.box, panel = kind === this.panels()[1] ? 1 : 0, rows = (bottom - top) / 34;
    let marks, power = 0;
    if (kind === "phase") marks = [-180, -90, 0, 90];
    else if (kind === "log") marks = high - low > 1.2 ? decades(low, high, rows) : ticks(low, high, rows);
    else {
      power = Math.floor(Math.log10(Math.max(Math.abs(low), Math.abs(high)) || 1));
      marks = ticks(low / 10 ** power, high / 10 ** power, rows).map((v) => v * 10 ** power);
    }
    for (const v of marks) {
      const y = Math.round(this.height(v, panel)) + 0.5;
      if (y < top + 3 || y > bottom - 1) continue;
      segment(context, this.ink("grid"), left, y, right, y);
      const text = kind === "phase" ? minus(`${v}°`) : kind === "log"
        ? (Math.abs(v - Math.round(v)) < 1e-9 ? tenTo(Math.round(v)) : (10 ** v).toExponential(1).replace("-", "−"))
        : minus(String(Number((v / 10 ** power).toPrecision(3))));
      this.write(context, text, left - 6, y, "right");
    }
    const scale = power ? `${tenTo(power)} ` : "";
    const names = { log: "|H| [m/N]", magnitude: `|H| [${scale}m/N]`, phase: "phase", real: `Re H [${scale}m/N]`, imaginary: `Im H [${scale}m/N]` };
    this.write(context, names[kind], left + 6, top + 10, "left", "soft", true);
  }
  write(context, text, x, y, align, ink = "ink", halo = false) {
    context.textAlign = align;
    context.textBaseline = "middle";
    context.setLineDash([]);
    if (halo) {
      context.lineWidth = 4;
      context.strokeStyle = this.ink("paper");
      context.strokeText(text, x, y);
      context.lineWidth = 1;
    }
    context.fillStyle = ink.startsWith("#") || ink.startsWith("rgb") ? ink : this.ink(ink);
    context.fillText(text, x, y);
  }

  drawFront() {
    const context = this.context(this.front), { upper, lower } = this.box;
    this.grips = this.caption = null;
    [upper, lower].forEach((panel, k) => {
      this.clip(context, panel);
      this.drawFit(context, k);
      if (k === 0 && this.kind === "bode") this.marks().forEach((_, p) => this.drawWidth(context, p));
      context.restore();
    });
    this.marks().forEach((peak, k) => this.drawPeak(context, peak, k));
    this.caption?.();
    this.drawNames(context);
    this.drawComb(context);
  }
  // The picked foundation's FRFs: a broad light band under each thin line of the data.
  drawFit(context, panel) {
    if (!this.fit) return;
    context.lineWidth = 6;
    context.lineCap = "round";
    context.globalAlpha = this.stale ? 0.3 : 0.34;
    context.setLineDash([]);
    for (const [i, j] of this.pairsShown()) {
      if (!this.fit.has(i, j)) continue;
      context.strokeStyle = this.stale ? this.ink("soft") : this.colours[j];
      this.trace(context, this.fit, i, j, panel);
    }
    context.globalAlpha = 1;
    context.lineCap = "butt";
  }
  drawWidth(context, k) {
    const seat = this.seatOf(k), w = this.width(k), on = k === this.selected;
    if (!w || seat < 0) return;
    const [a, b] = [this.x(w.low), this.x(w.high)], { upper } = this.box, colour = this.colours[seat];
    context.globalAlpha = on ? 0.16 : 0.07;
    context.fillStyle = colour;
    context.fillRect(a, upper[0], b - a, upper[1] - upper[0]);
    context.globalAlpha = 1;
    const level = w.height / Math.SQRT2, y = this.height(this.logarithmic.amplitude ? Math.log10(level) : level, 0);
    context.lineWidth = on ? 2 : 1.2;
    segment(context, colour, a, y, b, y);
    for (const x of [a, b]) {
      const r = on ? 5 : 2.6;
      context.beginPath();
      if (on) context.rect(x - r, y - r, 2 * r, 2 * r); else context.arc(x, y, r, 0, 7);
      context.fillStyle = on ? this.ink("paper") : colour;
      context.fill();
      context.stroke();
    }
    if (!on) return;
    this.grips = { low: a, high: b, y };
    this.caption = () => this.writeWidth(context, w, a, b, y);
  }
  writeWidth(context, w, a, b, y) {
    const { upper } = this.box;
    const text = `${number(w.high - w.low, 3)} Hz wide, ζ ${number(100 * w.damping, 3)} %`;
    const wide = context.measureText(text).width, { left, right } = this.box;
    const fits = b + 12 + wide < right;
    const x = fits ? b + 12 : Math.max(a - 12, left + wide + 4), end = fits ? x + wide : x;
    // below the panel's name, and below the buttons where it would come to lie under them
    const at = bound(y, upper[0] + (end > right - 120 ? 50 : 26), upper[1] - 10);
    context.fillStyle = this.ink("paper");
    context.globalAlpha = 0.85;
    context.fillRect((fits ? x : x - wide) - 4, at - 9, wide + 8, 18);
    context.globalAlpha = 1;
    this.write(context, text, x, at, fits ? "left" : "right");
  }
  drawPeak(context, peak, k) {
    const x = this.x(peak.frequency), seat = this.seatOf(k), { left, right, lower } = this.box;
    if (x < left - 0.5 || x > right + 0.5) return;
    const on = k === this.selected;
    context.strokeStyle = seat < 0 ? this.ink("ink") : this.colours[seat];
    context.lineWidth = on ? 2.6 : 1.5;
    context.setLineDash(seat < 0 ? [3, 3] : DASHES[seat % DASHES.length]);
    context.beginPath();
    context.moveTo(x, this.rowOf(k) + 20);
    context.lineTo(x, lower[1]);
    context.stroke();
    context.setLineDash([]);
    const height = seat >= 0 && this.kind === "bode" ? this.data.value(seat, seat, this.panels()[0], peak.frequency) : NaN;
    const y = this.height(height, 0);
    if (!(y > this.box.upper[0] && y < this.box.upper[1])) return;
    context.fillStyle = context.strokeStyle;
    context.beginPath();
    context.arc(x, y, on ? 5 : 3.5, 0, 7);
    context.fill();
  }
  // Which curve is which, at the right end; names that would meet are moved apart.
  drawNames(context) {
    const { upper, right } = this.box, labels = this.scene.labels, kind = this.panels()[0];
    const names = this.pairsShown().map(([i, j]) => ({
      text: i === j ? labels[j] : `${labels[i]}←${labels[j]}`, colour: this.colours[j],
      y: bound(this.height(this.data.value(i, j, kind, this.view.high), 0), upper[0] + 46, upper[1] - 8),
    })).sort((a, b) => a.y - b.y);
    const gap = Math.min(13, (upper[1] - upper[0] - 50) / Math.max(names.length, 1));
    for (let k = 1; k < names.length; k++) names[k].y = Math.max(names[k].y, names[k - 1].y + gap);
    let most = upper[1] - 8;
    for (const name of names.reverse()) {
      name.y = Math.min(name.y, most);
      most = name.y - gap;
      this.write(context, name.text, right - 5, name.y, "right", name.colour, true);
    }
  }
  // Natural frequencies on the same axis: the truth above, the picked foundation below, partners joined.
  drawComb(context) {
    const { comb, left, right } = this.box;
    if (!comb || !this.good) return;
    const rows = this.scene.rotor ? this.good.under : this.good.alone, [top, bottom] = comb, middle = (top + bottom) / 2;
    const truth = Boolean(this.scene.truth);
    context.globalAlpha = this.stale ? 0.4 : 1;
    const what = this.scene.rotor ? "natural frequencies under the rotor" : "natural frequencies of the foundation";
    this.write(context, what, (left + right) / 2, top - 9, "center", "soft");
    if (truth) this.write(context, "truth", left - 6, top + 9, "right");
    this.write(context, "picked", left - 6, truth ? bottom - 9 : middle, "right", "picked");
    this.clip(context, comb);
    context.strokeStyle = this.ink("line");
    context.strokeRect(left + 0.5, top + 0.5, right - left - 1, bottom - top - 1);
    for (const [true_, found] of rows) {
      context.lineWidth = 2;
      if (true_ && truth) segment(context, this.ink("ink"), this.x(true_), top + 3, this.x(true_), middle - 5);
      context.fillStyle = this.ink("picked");
      if (found) {
        const x = this.x(found), y = truth ? middle + 5 : top + 6;
        segment(context, this.ink("picked"), x, y, x, bottom - 3);
        context.fillRect(x - 3, bottom - 8, 6, 6);
      }
      context.lineWidth = 1;
      if (true_ && found) segment(context, this.ink("soft"), this.x(true_), middle - 5, this.x(found), middle + 5);
    }
    context.restore();
    context.globalAlpha = 1;
  }

  // Names of the peaks above their lines, in two rows, so that two peaks in one place can both be had.
  rowOf(k) { return this.tops?.[k] ?? 2; }
  placeHandles() {
    const { left, right } = this.box, ends = [-Infinity, -Infinity], tops = [];
    const order = this.handles.map((_, k) => k).sort((a, b) => this.marks()[a].frequency - this.marks()[b].frequency || a - b);
    for (const k of order) {
      const handle = this.handles[k], x = this.x(this.marks()[k].frequency), away = x < left - 1 || x > right + 1;
      const half = (handle.textContent.length * 7.2 + 16) / 2;
      const at = bound(x, half + 1, this.box.width - half - 1);
      const row = at - half > ends[0] ? 0 : at - half > ends[1] ? 1 : ends[0] <= ends[1] ? 0 : 1;
      if (!away) ends[row] = at + half;
      tops[k] = 2 + 22 * row;
      handle.style.transform = `translate(${Math.round(at)}px, ${tops[k]}px) translateX(-50%)`;
      handle.classList.toggle("is-away", away);
    }
    const moved = !same(tops, this.tops);
    this.tops = tops;
    if (moved) this.redraw();
  }
}

function render({ model, el }) {
  const picker = new Picker(model, el);
  return () => picker.remove();
}
export default { render };
