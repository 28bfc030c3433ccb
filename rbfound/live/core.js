// What the pictures of the page share: elements, numbers, ticks, the theme. It is put before picker.js or sliders.js, as
// one module: see `rbfound.live.script`.

const SUPER = "⁰¹²³⁴⁵⁶⁷⁸⁹";

const bound = (x, low, high) => Math.min(Math.max(x, low), high);
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

function make(parent, tag, properties = {}, attributes = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent?.append(made);
  return made;
}

// A text, or what else is said of an element, written where it differs: what is written is laid out again.
function put(node, value, name = "textContent") {
  if (node[name] !== value) node[name] = value;
}
function attribute(node, name, value) {
  if (node.getAttribute(name) !== value) node.setAttribute(name, value);
}

// JupyterLab's own keys (d d deletes the cell, m makes it text) stay out of what has the focus here. It looks for the
// attribute from the focused element upwards, and takes a key whose binding fits an element that it meets before:
// ":focus" fits the first, which has to bear the attribute itself.
function quiet(root) {
  root.addEventListener("focusin", ({ target }) => target.setAttribute("data-lm-suppress-shortcuts", "true"));
}

const tenTo = (n) => `10${String(n).replace("-", "⁻").replace(/\d/g, (d) => SUPER[d])}`;
const minus = (text) => text.replace(/^-(?=[\d.])/, "−");
function number(value, digits = 4, largest = 1e6) {
  if (value === null || value === undefined || !isFinite(value)) return "–";
  if (value === 0) return "0";
  value = Number(value.toPrecision(digits));
  const size = Math.abs(value);
  if (size >= 1e-3 && size < largest) return minus(value.toFixed(Math.max(digits - 1 - Math.floor(Math.log10(size)), 0)));
  const [a, b] = value.toExponential(digits - 1).split("e");
  return `${minus(a)}·${tenTo(Number(b))}`;
}

function isDark() {
  const theme = document.documentElement.dataset.theme || document.body.dataset.theme;
  if (theme) return theme === "dark";
  const lab = document.body.dataset.jpThemeLight;
  return lab ? lab === "false" : matchMedia("(prefers-color-scheme: dark)").matches;
}

// Follow the page's theme, now and whenever it changes; returns what ends that.
function theming(root, act) {
  const themed = () => { root.classList.toggle("is-dark", isDark()); act(); };
  const watch = new MutationObserver(themed), system = matchMedia("(prefers-color-scheme: dark)");
  for (const node of [document.documentElement, document.body]) {
    watch.observe(node, { attributeFilter: ["data-theme", "data-jp-theme-light"] });
  }
  system.addEventListener("change", themed);
  themed();
  return () => { watch.disconnect(); system.removeEventListener("change", themed); };
}

// A canvas of so many of the page's pixels, sharp on this screen; true where it had to be made anew.
function fitted(canvas, width, height, sharp) {
  const across = Math.round(width * sharp), down = Math.round(height * sharp);
  if (canvas.width === across && canvas.height === down) return false;
  Object.assign(canvas, { width: across, height: down });
  canvas.style.height = `${height}px`;
  return true;
}
function cleared(canvas, width, height, sharp) {
  const context = canvas.getContext("2d");
  context.setTransform(sharp, 0, 0, sharp, 0, 0);
  context.clearRect(0, 0, width, height);
  context.lineJoin = "round";
  return context;
}
function segment(context, colour, a, b, c, d) {
  context.strokeStyle = colour;
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(a, b);
  context.lineTo(c, d);
  context.stroke();
}
function clipped(context, left, top, right, bottom) {
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
}

// The step between round numbers, about so many of them; the numbers; and whole powers of ten, at most so many.
function stepped(low, high, count) {
  const raw = (high - low) / Math.max(count, 1), size = 10 ** Math.floor(Math.log10(raw));
  return size * [1, 2, 5, 10].find((s) => s * size >= raw * 0.999);
}
function ticks(low, high, count) {
  const step = stepped(low, high, count), out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(k * step);
  return out;
}
function decades(low, high, most) {
  const first = Math.ceil(low - 1e-9), last = Math.floor(high + 1e-9);
  const every = Math.max(1, Math.ceil((last - first + 1) / most));
  return Array.from({ length: Math.max(Math.floor((last - first) / every) + 1, 0) }, (_, k) => first + k * every);
}
