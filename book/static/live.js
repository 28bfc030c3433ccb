// Things to play with: until a reader asks for one, a page holds a still picture and a button. Then Python is fetched
// once a page, and computes in a worker. What the reader does stays on the reader's machine.
(() => {
  "use strict";
  const HERE = document.currentScript.src;

  function make(parent, tag, properties = {}, attributes = {}) {
    const made = Object.assign(document.createElement(tag), properties);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    parent?.append(made);
    return made;
  }

  // Scripts rather than fetch: a page opened from a file may load the first, and not the second.
  const scripts = new Map();
  function script(name) {
    if (!scripts.has(name)) {
      scripts.set(name, new Promise((done, failed) => {
        const tag = make(document.head, "script", { src: new URL(`live/${name}.js`, HERE).href });
        tag.onload = () => done();
        tag.onerror = () => { scripts.delete(name); failed(new Error(`${tag.src} cannot be read.`)); };
      }));
    }
    return scripts.get(name);
  }
  const bytes = (text) => {
    const all = atob(text), out = new Uint8Array(all.length);
    for (let k = 0; k < all.length; k++) out[k] = all.charCodeAt(k);
    return out;
  };
  async function fromScript(name) {
    await script(name);
    return globalThis.RBFOUND.files[name];
  }
  async function packed(name) { return bytes(await fromScript(name)); }

  // ---- Python ----
  class Python {
    constructor(progress) {
      this.waiting = new Map();
      this.brought = new Set();
      this.count = 0;
      this.progress = progress;
      this.ready = this.start();
    }
    async start() {
      const about = (this.about = await fromScript("about"));
      let carried = null;
      if (about.carried) {
        carried = {};
        for (const [k, name] of about.carried.entries()) {
          this.progress(k / about.carried.length, `Reading ${name}`);
          carried[name] = await packed(name);
          delete globalThis.RBFOUND.files[name];
        }
      }
      const source = new Blob([about.worker], { type: "text/javascript" });
      this.worker = new Worker(URL.createObjectURL(source));
      this.worker.onmessage = ({ data }) => this.heard(data);
      this.worker.onerror = (event) => this.broken(event.message || "its worker does not start");
      const wheel = await packed("wheel");
      const { versions } = await this.ask("load", { base: about.base, total: about.bytes, carried, wheel });
      this.versions = versions;
      return this;
    }
    ask(kind, values) {
      const id = ++this.count;
      return new Promise((done, failed) => {
        this.waiting.set(id, { done, failed });
        this.worker.postMessage({ id, kind, ...values });
      });
    }
    // A package that only these files need comes with the first of them.
    async bring(names) {
      for (const [reader, suffixes] of Object.entries(this.about.readers)) {
        if (!names.some((name) => suffixes.some((suffix) => name.toLowerCase().endsWith(suffix)))) continue;
        if (this.brought.has(reader)) continue;
        await this.ask("bring", { wheel: await packed(reader) });
        this.brought.add(reader);
      }
    }
    heard({ kind, id, answer, error, share, text }) {
      if (kind === "progress") { this.progress(share, text); return; }
      const { done, failed } = this.waiting.get(id);
      this.waiting.delete(id);
      if (error === undefined) done(answer); else failed(new Error(error));
    }
    broken(text) {
      for (const { failed } of this.waiting.values()) failed(new Error(text));
      this.waiting.clear();
    }
  }
  let python = null;
  const listeners = new Set();
  function running() {
    if (!python) {
      const mine = (python = new Python((share, text) => listeners.forEach((act) => act(share, text))));
      mine.ready.catch(() => { mine.worker?.terminate(); python = null; });
    }
    return python.ready;
  }

  const unpacked = ({ text, buffers }) => JSON.parse(text, (_, value) =>
    value && typeof value === "object" && Number.isInteger(value.buffer) && Object.keys(value).length === 1
      ? buffers[value.buffer] : value);

  // What a front end speaks to, as an anywidget does in JupyterLab. While Python computes, the changes are gathered.
  class Model {
    constructor(ask, values) { Object.assign(this, { ask, state: values, acts: {}, changed: new Set(), busy: false }); }
    get(name) { return this.state[name]; }
    set(name, value) {
      this.state[name] = value;
      this.changed.add(name);
      this.tell(name);
    }
    on(name, act) { (this.acts[name] ??= []).push(act); }
    off(name, act) { this.acts[name] = (this.acts[name] ?? []).filter((other) => act && other !== act); }
    tell(name) { for (const act of this.acts[`change:${name}`] ?? []) act(); }
    async save_changes() {
      if (this.busy || !this.changed.size) return;
      this.busy = true;
      const values = Object.fromEntries([...this.changed].map((name) => [name, this.state[name]]));
      this.changed.clear();
      try {
        const answer = unpacked(await this.ask(values));
        Object.assign(this.state, answer);
        this.busy = false;
        for (const name of Object.keys(answer)) this.tell(name);
      } catch (error) {
        this.failed?.(error);
      } finally {
        this.busy = false;
      }
      this.save_changes();
    }
  }

  const fronts = new Map();
  function front(name) {
    if (!fronts.has(name)) {
      fronts.set(name, fromScript("about").then(async (about) => {
        const { js, css } = about.fronts[name];
        make(document.head, "style", { textContent: css });
        const address = URL.createObjectURL(new Blob([js], { type: "text/javascript" }));
        return (await import(address)).default;
      }));
    }
    return fronts.get(name);
  }

  // The files of a drop, those of a folder among them. The entries are gone once the event is over: asked for at once.
  function dropped(transfer) {
    const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    if (!entries.some((entry) => entry.isDirectory)) return [...transfer.files];
    const one = (entry) => new Promise((done, failed) => entry.file(done, failed));
    const inside = async (folder) => {
      const reader = folder.createReader(), out = [];
      for (;;) {
        const some = await new Promise((done, failed) => reader.readEntries(done, failed));
        if (!some.length) return out;
        out.push(...some.filter((entry) => entry.isFile));
      }
    };
    return Promise.all(entries.map((entry) => (entry.isFile ? [entry] : inside(entry))))
      .then((lists) => Promise.all(lists.flat().map(one)));
  }

  // ---- one thing in the page ----
  let keys = 0;
  class Thing {
    constructor(root) {
      this.root = root;
      this.name = root.dataset.live;
      this.key = `${this.name}-${++keys}`;
      this.bar = root.querySelector(".rbfound-live-bar");
      this.button = make(null, "button", { type: "button", textContent: "Run it here", className: "rbfound-live-run" });
      this.bar.prepend(this.button);
      this.status = make(root, "p", { className: "rbfound-live-status" }, { role: "status" });
      this.button.onclick = () => this.run();
    }
    async run() {
      this.button.disabled = true;
      const started = performance.now();
      this.bar.hidden = true;
      this.say("Loading Python …");
      const bar = make(this.status, "progress", { max: 1 }, { "aria-label": "Loading Python" });
      const words = this.status.firstChild;
      // a screen reader is told every tenth
      let tenth = -1;
      const heard = (share, text) => {
        bar.value = share;
        if (Math.floor(10 * share) === tenth && share < 1) return;
        tenth = Math.floor(10 * share);
        words.textContent = `${text} `;
      };
      listeners.add(heard);
      try {
        const about = await fromScript("about");
        const data = about.data.includes(this.name) ? await packed(`data-${this.name}`) : undefined;
        this.python = await running();
        heard(1, "Computing");
        await this.show(await this.python.ask("start", { key: this.key, name: this.name, data }));
        const seconds = ((performance.now() - started) / 1000).toFixed(1);
        this.say(`Running in this page: ${this.python.versions}. Ready after ${seconds}\u00a0s.`);
        this.root.dataset.ready = seconds;
        // the button is gone: whoever came to it by keys goes on from here
        if (document.activeElement === document.body) {
          this.place.querySelector("input, select, button")?.focus({ preventScroll: true });
        }
      } catch (error) {
        this.say(`Python could not be started here: ${error.message} The picture above stands for it.`, "trouble");
        this.bar.hidden = false;
        this.button.disabled = false;
        this.button.textContent = "Try again";
        this.root.dataset.failed = "";
      } finally {
        listeners.delete(heard);
      }
    }
    say(text, kind = "") {
      this.status.replaceChildren(document.createTextNode(text));
      this.status.className = `rbfound-live-status ${kind}`;
    }
    async show(answer) {
      const values = unpacked(answer);
      const drawn = await front(this.root.dataset.front);
      const model = (this.model = new Model((changed) =>
        this.python.ask("update", { key: this.key, text: JSON.stringify(changed) }).catch((error) => {
          this.say(`Python stopped: ${error.message}`, "trouble");
          throw error;
        }), values));
      this.root.rbfound = model;
      this.remove?.();
      this.place ??= make(null, "div", { className: "rbfound-live-place" });
      this.place.replaceChildren();
      this.root.querySelector(".rbfound-live-still")?.replaceWith(this.place);
      this.remove = await drawn.render({ model, el: this.place });
      this.saves(values.saves);
      if (values.opens && !this.own) this.opens();
    }
    // Results as files: made in the page, so that a download asks nobody.
    saves(names) {
      this.files ??= make(this.root, "p", { className: "rbfound-live-files" });
      this.files.replaceChildren(...(names.length ? ["Take it with you: "] : []));
      for (const name of names) {
        const button = make(this.files, "button", { type: "button", textContent: name });
        button.onclick = async () => {
          try {
            const { file } = unpacked(await this.python.ask("save", { key: this.key, name }));
            const href = URL.createObjectURL(new Blob([file]));
            make(null, "a", { href, download: name }).click();
            setTimeout(() => URL.revokeObjectURL(href), 60000);
          } catch (error) { this.say(error.message, "trouble"); }
        };
      }
    }
    // The reader's own files: read here, sent nowhere.
    opens() {
      const own = (this.own = make(this.root, "div", { className: "rbfound-live-own" }));
      const words = make(own, "p");
      make(words, "strong", { textContent: "Your own FRFs. " });
      words.append("Drop the text files of a set or their folder here, one file for each pair of seats (sixteen for two bearings, named as in " +
        "data/foundation: …x1_from_y1.txt), or one table (.csv) whose heading says x1 from y1 real [m/N] and so on, or one " +
        "Universal File (.uff, .unv) with datasets 58. They are read in this page and stay on this machine.");
      const row = make(own, "p");
      const label = make(row, "label", { textContent: "Choose files" });
      const suffixes = [".txt", ".csv", ...Object.values(this.python.about.readers).flat()];
      const input = make(label, "input", { type: "file", multiple: true, accept: suffixes.join() });
      const fields = {}, more = make(null, "details"), rest = make(null, "p");
      const field = (place, name, text, properties) => {
        fields[name] = make(make(place, "label", { textContent: text }), "input", { type: "text", ...properties });
      };
      field(row, "unit", "Unit, where they do not say it", { size: 8, placeholder: "m/N" });
      const back = make(row, "button", { type: "button", textContent: "Back to the book's FRFs", hidden: true });
      own.append(more);
      make(more, "summary", { textContent: "Files that say less" });
      more.append(rest);
      field(rest, "columns", "Columns, where no heading says it", { size: 34, placeholder: "frequency [Hz], amplitude [mm], phase [deg]" });
      field(rest, "pattern", "Names of the files", { size: 24, placeholder: "H_{response}_{force}.csv" });
      field(rest, "fill", "A missing FRF from its mirror", { type: "checkbox" });
      const said = () => Object.fromEntries(Object.entries(fields).map(([name, input]) =>
        [name, input.type === "checkbox" ? input.checked : input.value.trim()]));
      make(more, "p", { textContent: "A seat is named after its direction, x or y, and the number of its bearing (x1, y1, x2, y2). Files with other " +
        "names come with an index: a text whose heading is “file, response, force”, and a line for each file." });
      const told = make(own, "p", { className: "rbfound-live-status" }, { role: "status" });
      const work = async (text, act, done) => {
        told.className = "rbfound-live-status";
        told.textContent = text;
        own.setAttribute("aria-busy", "true");
        try {
          await this.show(await act());
          told.textContent = done;
          own.dataset.opened = done;
        } catch (error) {
          told.className = "rbfound-live-status trouble";
          told.textContent = `These files could not be used. ${error.message}`;
          own.dataset.refused = error.message;
        } finally { own.removeAttribute("aria-busy"); }
      };
      const take = async (list) => {
        delete own.dataset.opened;
        delete own.dataset.refused;
        await work("Reading the files and fitting all modes …", async () => {
          const files = await Promise.all((await list).map(async (file) =>
            [file.name, new Uint8Array(await file.arrayBuffer())]));
          if (!files.length) throw new Error("There is none among them.");
          await this.python.bring(files.map(([name]) => name));
          return this.python.ask("open", { key: this.key, name: this.name, files, fields: JSON.stringify(said()) });
        }, "What is shown was identified from your files.");
        back.hidden = !own.dataset.opened;
      };
      input.onchange = () => { if (input.files.length) take([...input.files]); input.value = ""; };
      back.onclick = () => work("Back …", () => this.python.ask("start", { key: this.key, name: this.name }), "")
        .then(() => { back.hidden = true; });
      // anywhere on the picture or below it
      this.root.ondragover = (event) => { event.preventDefault(); own.classList.add("is-over"); };
      this.root.ondragleave = (event) => { if (!this.root.contains(event.relatedTarget)) own.classList.remove("is-over"); };
      this.root.ondrop = (event) => {
        event.preventDefault();
        own.classList.remove("is-over");
        take(dropped(event.dataTransfer));
      };
    }
  }

  const start = () => document.querySelectorAll(".rbfound-live").forEach((root) => new Thing(root));
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start); else start();
})();
