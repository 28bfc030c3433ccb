// Draws the mode shapes of every .rbfound-view that is not drawn yet. No library: each pixel of a plain canvas keeps
// the face that is nearest to the viewer, and edges are drawn over it where no face hides them.
(() => {
  "use strict";
  const SHARP = 0.8, PERIOD = 1600, STEP = Math.PI / 36;
  const SHADES = 48, LIGHTS = 16, GLASS = 0.35;
  // An edge is drawn in pieces of so many pixels; it may lie so far behind a face and is still in sight.
  const PIECE = 5, NEARLY = 0.015;
  const REDUCED = matchMedia("(prefers-reduced-motion: reduce)").matches;

  const decode = (text, Kind) => new Kind(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const bound = (x, low, high) => Math.min(Math.max(x, low), high);
  const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

  function element(parent, tag, properties = {}, attributes = {}) {
    const made = Object.assign(document.createElement(tag), properties);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    parent.append(made);
    return made;
  }

  function isDark() {
    const theme = document.documentElement.dataset.theme;
    return theme ? theme === "dark" : document.body.dataset.jpThemeLight === "false";
  }

  // What stays the same whatever is drawn: normals, and the edges with the faces on both sides of them.
  function prepare(body) {
    const points = Float32Array.from(decode(body.points, Int16Array), (v) => v / 32767);
    const faces = decode(body.faces, Uint16Array);
    const count = faces.length / 4;
    const normals = new Float32Array(3 * count);
    const edgeOf = new Uint32Array(4 * count);
    const ends = [], owners = [], known = new Map();
    for (let f = 0; f < count; f++) {
      const [a, b, c, d] = faces.subarray(4 * f, 4 * f + 4);
      const p = [0, 1, 2].map((k) => points[3 * c + k] - points[3 * a + k]);
      const q = [0, 1, 2].map((k) => points[3 * d + k] - points[3 * b + k]);
      const n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
      normals.set(n.map((v) => v / (Math.hypot(...n) || 1)), 3 * f);
      for (let k = 0; k < 4; k++) {
        const from = faces[4 * f + k], to = faces[4 * f + ((k + 1) % 4)];
        const key = Math.min(from, to) * 65536 + Math.max(from, to);
        let edge = known.get(key);
        if (edge === undefined) {
          known.set(key, (edge = owners.length / 2));
          ends.push(from, to);
          owners.push(f, f);
        } else owners[2 * edge + 1] = f;
        edgeOf[4 * f + k] = edge;
      }
    }
    const sharp = Uint8Array.from({ length: owners.length / 2 }, (_, e) => {
      const a = 3 * owners[2 * e], b = 3 * owners[2 * e + 1];
      return normals[a] * normals[b] + normals[a + 1] * normals[b + 1] + normals[a + 2] * normals[b + 2] < SHARP;
    });
    const shapes = body.shapes.map((shape) => {
      const values = (text) => text && Float32Array.from(decode(text, Int8Array), (v) => (v / 127) * shape.size);
      const real = values(shape.real), imag = values(shape.imag);
      const motion = new Float32Array(points.length / 3);
      for (let i = 0; i < points.length; i += 3) {
        let square = real[i] ** 2 + real[i + 1] ** 2 + real[i + 2] ** 2;
        if (imag) square += imag[i] ** 2 + imag[i + 1] ** 2 + imag[i + 2] ** 2;
        motion[i / 3] = Math.min(Math.sqrt(square), 1) * (SHADES - 1) + 0.5;
      }
      return { real, imag, motion };
    });
    return {
      ...body, points, faces, count, normals, edgeOf, sharp, shapes, ends: Uint16Array.from(ends),
      owners: Uint32Array.from(owners), screen: new Float32Array(points.length), front: new Uint8Array(count),
    };
  }

  // Colours of a body as pixels: SHADES steps of motion times LIGHTS steps of light.
  function palette(body, dark) {
    const [low, high] = body.ramp[dark ? 1 : 0].map(rgb);
    return Uint32Array.from({ length: SHADES * LIGHTS }, (_, k) => {
      const motion = Math.floor(k / LIGHTS) / (SHADES - 1), light = 0.72 + (0.28 * (k % LIGHTS)) / (LIGHTS - 1);
      const [r, g, b] = low.map((v, i) => Math.round(light * (v + motion * (high[i] - v))));
      return (255 << 24) | (b << 16) | (g << 8) | r;
    });
  }

  // A picture in the making: for each pixel the colour and the depth of what is nearest.
  class Layer {
    constructor(width, height) {
      Object.assign(this, { width, height });
      this.depth = new Float32Array(width * height);
      this.pixels = new Uint32Array(width * height);
    }
    clear() {
      this.depth.fill(-1e9);
      this.pixels.fill(0);
    }

    // The triangle of points i, j, k: p holds x, y, depth of each, m its motion; `light` is one of LIGHTS.
    triangle(p, m, i, j, k, colours, light) {
      const x0 = p[3 * i], y0 = p[3 * i + 1], z0 = p[3 * i + 2];
      const x1 = p[3 * j], y1 = p[3 * j + 1], x2 = p[3 * k], y2 = p[3 * k + 1];
      const area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
      if (!(Math.abs(area) > 1e-9)) return;
      const slope = (b, c) => [(b * (y2 - y0) - c * (y1 - y0)) / area, (c * (x1 - x0) - b * (x2 - x0)) / area];
      const [zx, zy] = slope(p[3 * j + 2] - z0, p[3 * k + 2] - z0), [mx, my] = slope(m[j] - m[i], m[k] - m[i]);
      const { width, height, depth, pixels } = this;
      const top = Math.max(Math.ceil(Math.min(y0, y1, y2) - 0.5), 0);
      const bottom = Math.min(Math.ceil(Math.max(y0, y1, y2) - 0.5), height);
      for (let row = top; row < bottom; row++) {
        const y = row + 0.5;
        let left = 1e9, right = -1e9;
        if (y0 <= y !== y1 <= y) left = right = x0 + ((y - y0) / (y1 - y0)) * (x1 - x0);
        if (y1 <= y !== y2 <= y) {
          const x = x1 + ((y - y1) / (y2 - y1)) * (x2 - x1);
          left = Math.min(left, x);
          right = Math.max(right, x);
        }
        if (y2 <= y !== y0 <= y) {
          const x = x2 + ((y - y2) / (y0 - y2)) * (x0 - x2);
          left = Math.min(left, x);
          right = Math.max(right, x);
        }
        const from = Math.max(Math.ceil(left - 0.5), 0), to = Math.min(Math.ceil(right - 0.5), width);
        let z = z0 + zx * (from + 0.5 - x0) + zy * (y - y0), v = m[i] + mx * (from + 0.5 - x0) + my * (y - y0);
        for (let at = row * width + from, end = row * width + to; at < end; at++, z += zx, v += mx) {
          if (z <= depth[at]) continue;
          depth[at] = z;
          pixels[at] = colours[(v < 0 ? 0 : v >= SHADES ? SHADES - 1 : v | 0) * LIGHTS + light];
        }
      }
    }

    // Whether a point is in sight, or so near the rim of what hides it that its edge should be drawn.
    sees(x, y, z) {
      for (let k = 0; k < 5; k++) {
        const column = (x + (k === 1) * 1.5 - (k === 2) * 1.5) | 0, row = (y + (k === 3) * 1.5 - (k === 4) * 1.5) | 0;
        if (column < 0 || row < 0 || column >= this.width || row >= this.height) return true;
        if (z + NEARLY >= this.depth[row * this.width + column]) return true;
      }
      return false;
    }

    // Lay a layer of glass over this one.
    cover(glass) {
      const { depth, pixels } = this, keep = Math.round(256 * (1 - GLASS)), add = 256 - keep;
      const empty = Math.round(255 * GLASS) << 24;
      for (let i = 0; i < pixels.length; i++) {
        const over = glass.pixels[i], under = pixels[i];
        if (!over || glass.depth[i] <= depth[i]) continue;
        if (!under) {
          pixels[i] = (over & 0xffffff) | empty;
          continue;
        }
        // red and blue at once, then green
        const rb = (((under & 0xff00ff) * keep + (over & 0xff00ff) * add) >>> 8) & 0xff00ff;
        const g = (((under & 0xff00) * keep + (over & 0xff00) * add) >>> 8) & 0xff00;
        pixels[i] = (255 << 24) | rb | g;
      }
    }
  }

  class View {
    constructor(figure) {
      this.figure = figure;
      this.data = JSON.parse(figure.querySelector("script[type='application/json']").textContent);
      this.bodies = this.data.bodies.map(prepare);
      this.home = { turn: this.data.turn, tilt: this.data.tilt, zoom: 1, right: 0, up: 0 };
      Object.assign(this, this.home, { mode: 0, exaggeration: 1, phase: 0, playing: !REDUCED, seen: false });
      this.sheer = this.bodies.some((body) => body.sheer);
      this.extent = this.extents();
      this.build();
      this.listen();
      this.select(0);
    }

    build() {
      const live = element(this.figure, "div", { className: "rbfound-live" });
      const bar = element(live, "div", { className: "rbfound-bar" });
      const label = (text) => element(bar, "label", { textContent: text });
      const button = (text, name, act, group = bar) =>
        element(group, "button", { type: "button", textContent: text, onclick: act }, name ? { "aria-label": name } : {});
      if (this.data.labels.length > 1) {
        this.choice = element(label("Mode"), "select", {
          onchange: () => this.select(this.choice.selectedIndex),
        }, { "aria-label": "Mode" });
        for (const text of this.data.labels) element(this.choice, "option", { textContent: text });
      }
      this.play = button("Play", "", () => this.setPlaying(!this.playing));
      this.play.className = "rbfound-play";
      this.slider = element(label("Motion"), "input", {
        type: "range", min: 0, max: 3, step: 0.05, value: 1,
        oninput: () => { this.exaggeration = Number(this.slider.value); this.redraw(); },
      }, { "aria-label": "Motion: how large it is drawn" });
      if (this.sheer) {
        const glass = button("See through", "", () => {
          this.sheer = !this.sheer;
          glass.setAttribute("aria-pressed", this.sheer);
          this.redraw();
        });
        glass.setAttribute("aria-pressed", "true");
      }
      const zoom = element(bar, "span", { className: "rbfound-push" });
      button("−", "Zoom out", () => this.magnify(1 / 1.25), zoom);
      button("+", "Zoom in", () => this.magnify(1.25), zoom);
      button("Reset", "Reset the view", () => { Object.assign(this, this.home); this.redraw(); }, zoom);
      this.canvas = element(live, "canvas", { tabIndex: 0 }, { role: "img" });
      this.context = this.canvas.getContext("2d");
      const key = element(live, "div", { className: "rbfound-bar rbfound-key" });
      this.swatches = this.bodies.map((body) => {
        const line = element(key, "label");
        line.append(`${body.name}: at rest `);
        const swatch = element(line, "i");
        line.append(" moves most");
        return swatch;
      });
      const rest = element(key, "label");
      element(rest, "i", { className: "rbfound-rest" });
      rest.append("undeformed");
      element(key, "span", {
        textContent: "Drag it or use the arrow keys to turn it, with Shift to move it; + and − zoom.",
      });
      this.figure.classList.add("is-live");
    }

    listen() {
      // JupyterLab's own keys (d d deletes the cell) stay out of it: what has the focus has to bear this itself
      this.figure.addEventListener("focusin", ({ target }) => target.setAttribute("data-lm-suppress-shortcuts", "true"));
      const canvas = this.canvas, pointers = new Map();
      canvas.onpointerdown = (event) => {
        pointers.set(event.pointerId, event);
        canvas.setPointerCapture(event.pointerId);
      };
      canvas.onpointerup = canvas.onpointercancel = (event) => pointers.delete(event.pointerId);
      canvas.onpointermove = (event) => {
        const before = pointers.get(event.pointerId);
        if (!before) return;
        const spread = () => {
          const [a, b] = [...pointers.values()];
          return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        };
        const apart = pointers.size === 2 && spread();
        pointers.set(event.pointerId, event);
        const x = event.clientX - before.clientX, y = event.clientY - before.clientY;
        if (apart) this.magnify(spread() / apart);
        else if (event.shiftKey) this.shift(x, -y);
        else this.rotate(x / 120, y / 120);
      };
      // a page must scroll past the picture: the wheel is its own only once it has been clicked
      canvas.addEventListener("wheel", (event) => {
        if (document.activeElement !== canvas && !event.ctrlKey) return;
        event.preventDefault();
        this.magnify(Math.exp(-bound(event.deltaY, -100, 100) / 400));
      }, { passive: false });
      canvas.onkeydown = (event) => {
        const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        if (way) event.shiftKey ? this.shift(20 * way[0], -20 * way[1]) : this.rotate(STEP * way[0], STEP * way[1]);
        else if (event.key === "+" || event.key === "=") this.magnify(1.1);
        else if (event.key === "-" || event.key === "_") this.magnify(1 / 1.1);
        else if (event.key === " ") this.setPlaying(!this.playing);
        else return;
        event.preventDefault();
      };
      const themed = () => { this.colours = null; this.redraw(); };
      new MutationObserver(themed).observe(document.documentElement, { attributeFilter: ["data-theme"] });
      new MutationObserver(themed).observe(document.body, { attributeFilter: ["data-jp-theme-light"] });
      new ResizeObserver(() => this.redraw()).observe(this.canvas);
      // what is out of sight does not move: a page may hold many
      new IntersectionObserver(([entry]) => { this.seen = entry.isIntersecting; this.run(); }).observe(canvas);
    }

    rotate(right, down) {
      this.turn += right;
      this.tilt = bound(this.tilt + down, -Math.PI / 2, Math.PI / 2);
      this.redraw();
    }
    shift(right, up) { this.right += right; this.up += up; this.redraw(); }
    magnify(factor) { this.zoom = bound(this.zoom * factor, 0.4, 12); this.redraw(); }

    select(mode) {
      this.mode = mode;
      this.canvas.setAttribute("aria-label",
        `${this.data.title}, mode ${this.data.labels[mode]}. ` +
        "Arrow keys turn the picture, plus and minus zoom, the space bar sets it moving or stops it.");
      this.setPlaying(this.playing);
    }
    setPlaying(playing) {
      this.playing = playing;
      this.play.textContent = playing ? "Pause" : "Play";
      this.redraw();
      this.run();
    }
    run() {
      if (this.timer || !this.playing || !this.seen) return;
      let before;
      const tick = (now) => {
        this.timer = 0;
        if (!this.playing || !this.seen || !this.figure.isConnected) return;
        this.phase += (2 * Math.PI * Math.min(now - (before ?? now), 100)) / PERIOD;
        before = now;
        this.draw();
        this.timer = requestAnimationFrame(tick);
      };
      this.timer = requestAnimationFrame(tick);
    }
    redraw() {
      if (this.timer || this.waiting) return;
      this.waiting = requestAnimationFrame(() => { this.waiting = 0; this.draw(); });
    }

    // Match the canvas to the page: its size, the screen's pixels, the theme. All that is drawn is in pixels.
    fit() {
      const { wide, high } = this.extent, canvas = this.canvas;
      const width = canvas.clientWidth || 640, height = Math.round(bound((width * high) / wide, 280, 480));
      const unit = Math.min(devicePixelRatio || 1, 2);
      const across = Math.round(width * unit), down = Math.round(height * unit);
      if (canvas.width !== across || canvas.height !== down || !this.image) {
        canvas.style.height = `${height}px`;
        Object.assign(canvas, { width: across, height: down });
        this.layers = [new Layer(across, down), new Layer(across, down)];
        this.image = new ImageData(new Uint8ClampedArray(this.layers[0].pixels.buffer), across, down);
        this.unit = unit;
      }
      if (!this.colours) {
        const dark = isDark(), style = getComputedStyle(this.figure);
        this.colours = this.bodies.map((body) => palette(body, dark));
        this.ink = (name) => style.getPropertyValue(`--${name}`).trim();
        this.swatches.forEach((swatch, k) => {
          swatch.style.background = `linear-gradient(90deg, ${this.bodies[k].ramp[dark ? 1 : 0].join()})`;
        });
      }
    }

    // Rows right, up and towards the viewer.
    rows({ turn, tilt }) {
      const [s, c] = [Math.sin(turn), Math.cos(turn)], [st, ct] = [Math.sin(tilt), Math.cos(tilt)];
      return [c, 0, s, st * s, ct, -st * c, -ct * s, st, ct * c];
    }
    // Half the width and height that the bodies take as they are seen first, with room for their motion.
    extents() {
      const r = this.rows(this.home);
      let wide = 0, high = 0;
      for (const { points } of this.bodies) {
        for (let i = 0; i < points.length; i += 3) {
          wide = Math.max(wide, Math.abs(r[0] * points[i] + r[2] * points[i + 2]));
          high = Math.max(high, Math.abs(r[3] * points[i] + r[4] * points[i + 1] + r[5] * points[i + 2]));
        }
      }
      return { wide: wide + 0.2, high: high + 0.25 };
    }
    camera() {
      const { wide, high } = this.extent, { width, height } = this.canvas;
      const scale = 0.5 * Math.min(width / wide, height / high) * this.zoom;
      const x = width / 2 + this.right * this.unit, y = 0.52 * height - this.up * this.unit;
      return { rows: this.rows(this), scale, x, y };
    }

    // Where the points of a body that is moved by `size` are on the screen, how near, and which faces look this way.
    project(body, camera, size) {
      const { rows: r, scale, x: x0, y: y0 } = camera, { points, faces, front, screen } = body;
      const { real, imag } = body.shapes[this.mode];
      const c = size * Math.cos(this.phase), s = imag ? size * Math.sin(this.phase) : 0;
      for (let i = 0; i < points.length; i += 3) {
        let x = points[i] + c * real[i], y = points[i + 1] + c * real[i + 1], z = points[i + 2] + c * real[i + 2];
        if (s) { x -= s * imag[i]; y -= s * imag[i + 1]; z -= s * imag[i + 2]; }
        screen[i] = x0 + scale * (r[0] * x + r[1] * y + r[2] * z);
        screen[i + 1] = y0 - scale * (r[3] * x + r[4] * y + r[5] * z);
        screen[i + 2] = r[6] * x + r[7] * y + r[8] * z;
      }
      for (let f = 0; f < body.count; f++) {
        const a = 3 * faces[4 * f], b = 3 * faces[4 * f + 1], e = 3 * faces[4 * f + 2], d = 3 * faces[4 * f + 3];
        front[f] = (screen[e] - screen[a]) * (screen[d + 1] - screen[b + 1])
          < (screen[e + 1] - screen[a + 1]) * (screen[d] - screen[b]) ? 1 : 0;
      }
    }

    isDrawn(body, edge) {
      const a = body.front[body.owners[2 * edge]], b = body.front[body.owners[2 * edge + 1]];
      return a !== b || (a && body.sharp[edge]);
    }

    draw() {
      this.fit();
      const camera = this.camera(), context = this.context, [near, glass] = this.layers;
      const size = 2 * this.data.exaggeration * this.exaggeration;
      this.layers.forEach((layer) => layer.clear());
      const isGlass = (body) => this.sheer && body.sheer;
      this.bodies.forEach((body, k) => {
        this.project(body, camera, size);
        this.fill(isGlass(body) ? glass : near, body, this.colours[k], camera.rows);
      });
      const full = new Path2D(), thin = new Path2D(), rest = new Path2D();
      for (const body of this.bodies) this.edges(near, body, isGlass(body) ? thin : full);
      const labels = this.bodies.map((body) =>
        Object.entries(body.marks).map(([text, p]) => [text, body.screen[3 * p], body.screen[3 * p + 1]]));
      for (const body of this.bodies) {
        this.project(body, camera, 0);
        this.edges(near, body, rest);
      }
      if (this.sheer) near.cover(glass);
      context.putImageData(this.image, 0, 0);
      context.lineJoin = context.lineCap = "round";
      this.stroke(rest, 1, "rest", [4, 4]);
      this.stroke(thin, 0.9, "thin");
      this.stroke(full, 0.9, "edge");
      this.drawLabels(labels.flat());
      this.drawAxes(camera.rows);
    }

    stroke(path, width, ink, dashes = []) {
      const context = this.context;
      context.lineWidth = width * this.unit;
      context.strokeStyle = this.ink(ink);
      context.setLineDash(dashes.map((dash) => dash * this.unit));
      context.stroke(path);
    }

    // The faces in sight, lit from beside the viewer.
    fill(layer, body, colours, r) {
      const { faces, screen, normals, front } = body, { motion } = body.shapes[this.mode];
      const [lx, ly, lz] = this.data.light;
      const [x, y, z] = [0, 1, 2].map((k) => lx * r[k] + ly * r[3 + k] + lz * r[6 + k]);
      for (let f = 0; f < body.count; f++) {
        if (!front[f]) continue;
        const [a, b, c, d] = [faces[4 * f], faces[4 * f + 1], faces[4 * f + 2], faces[4 * f + 3]];
        const glow = bound(normals[3 * f] * x + normals[3 * f + 1] * y + normals[3 * f + 2] * z, 0, 1);
        const light = Math.round(glow * (LIGHTS - 1));
        layer.triangle(screen, motion, a, b, c, colours, light);
        layer.triangle(screen, motion, a, c, d, colours, light);
      }
    }

    // Put the edges that a draughtsman would draw on a path, as far as the layer does not hide them.
    edges(layer, body, path) {
      const { screen: p, ends } = body;
      for (let e = 0; e < body.sharp.length; e++) {
        if (!this.isDrawn(body, e)) continue;
        const a = 3 * ends[2 * e], b = 3 * ends[2 * e + 1];
        const x = p[b] - p[a], y = p[b + 1] - p[a + 1], z = p[b + 2] - p[a + 2];
        const pieces = Math.ceil(Math.hypot(x, y) / (PIECE * this.unit)) || 1;
        let down = false;
        for (let k = 0; k < pieces; k++) {
          const t = (k + 0.5) / pieces, end = (k + 1) / pieces;
          const seen = layer.sees(p[a] + t * x, p[a + 1] + t * y, p[a + 2] + t * z);
          if (seen && !down) path.moveTo(p[a] + (k / pieces) * x, p[a + 1] + (k / pieces) * y);
          if (seen) path.lineTo(p[a] + end * x, p[a + 1] + end * y);
          down = seen;
        }
      }
    }

    write(text, x, y) {
      const context = this.context;
      context.font = `600 ${12.5 * this.unit}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.lineWidth = 4 * this.unit;
      context.strokeStyle = this.ink("paper");
      context.strokeText(text, x, y);
      context.fillStyle = this.ink("ink");
      context.fillText(text, x, y);
    }

    // A dot that moves with the body, and its name above on a leader; names that would meet stand one over the other.
    drawLabels(labels) {
      const context = this.context, u = this.unit, taken = [];
      for (const [text, x, y] of labels) {
        const half = 4 * u * text.length;
        let top = y - 30 * u;
        while (taken.some((t) => Math.abs(t.x - x) < t.half + half && Math.abs(t.top - top) < 17 * u)) top -= 4 * u;
        taken.push({ x, top, half });
        const path = new Path2D();
        path.moveTo(x, y);
        path.lineTo(x, top + 8 * u);
        this.stroke(path, 1, "ink");
        context.fillStyle = this.ink("ink");
        context.beginPath();
        context.arc(x, y, 3.5 * u, 0, 7);
        context.fill();
      }
      labels.forEach(([text, x], k) => this.write(text, x, taken[k].top));
    }

    drawAxes(r) {
      const u = this.unit, x = 40 * u, y = this.canvas.height - 40 * u;
      ["X", "Y", "Z"].forEach((name, k) => {
        const [dx, dy] = [24 * u * r[k], -24 * u * r[3 + k]], path = new Path2D();
        path.moveTo(x, y);
        path.lineTo(x + dx, y + dy);
        this.stroke(path, 1.6, "ink");
        this.write(name, x + 1.4 * dx, y + 1.4 * dy);
      });
    }
  }

  for (const figure of document.querySelectorAll(".rbfound-view:not(.is-live)")) {
    if (figure.querySelector("script[type='application/json']")) new View(figure);
  }
})();
