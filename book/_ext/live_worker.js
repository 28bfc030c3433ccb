// Python in a worker of its own: a long computation never stops the page. Its source travels inside the page's script,
// so that it starts from a file as well as from a server.
"use strict";

const GLUE = `
import json
from pathlib import Path
from rbfound import live

running = {}

def told(key, name, thing):
    running[key] = thing
    return live.packed({**thing.values, "saves": list(thing.saves), "opens": name in live.OPENS})

def start(key, name, folder):
    return told(key, name, live.start(name, Path(folder)))

def opened(key, name, folder, fields):
    return told(key, name, live.opened(name, Path(folder), **json.loads(fields)))

def update(key, text):
    return live.packed(running[key].update(json.loads(text)))

def save(key, name):
    return live.packed({"file": running[key].saves[name]()})
`;

let python, glue;
const tell = (message, buffers = []) => postMessage(message, buffers);

// Every file on its way is counted; a book that carries Python itself answers from what it carries.
function count(carried, total) {
  const real = self.fetch.bind(self);
  let loaded = 0;
  self.fetch = async (address, options) => {
    const name = String(address?.url ?? address).split(/[?#]/)[0].split("/").pop();
    if (carried?.[name]) {
      const type = name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
      return new Response(carried[name], { headers: { "content-type": type } });
    }
    const answer = await real(address, options);
    if (!answer.ok || !answer.body) return answer;
    const counter = new TransformStream({
      transform(chunk, controller) {
        loaded += chunk.byteLength;
        tell({ kind: "progress", share: Math.min(loaded / total, 1), text: `Loading Python: ${(loaded / 1e6).toFixed(0)} MB` });
        controller.enqueue(chunk);
      },
    });
    return new Response(answer.body.pipeThrough(counter), { status: answer.status, headers: answer.headers });
  };
}

async function load({ base, total, carried, wheel }) {
  count(carried, total);
  const script = (name) => (carried ? URL.createObjectURL(new Blob([carried[name]], { type: "text/javascript" })) : base + name);
  importScripts(script("pyodide.js"));
  if (carried) importScripts(script("pyodide.asm.js"));
  const troubles = [];
  python = await loadPyodide({ indexURL: base, packages: ["numpy", "scipy"], stderr: (text) => troubles.push(text) });
  tell({ kind: "progress", share: 1, text: "Starting rbfound" });
  python.unpackArchive(wheel, "wheel");
  try {
    python.runPython(GLUE);
  } catch (error) {
    throw new Error([said(error), ...troubles].join(" "));
  }
  glue = (name, ...args) => {
    const call = python.globals.get(name);
    const told = call(...args);
    const [text, buffers] = told.toJs();
    told.destroy();
    call.destroy();
    return { text, buffers };
  };
  const versions = python.runPython(`
import sys, numpy, scipy, rbfound
f"rbfound {rbfound.__version__}, numpy {numpy.__version__}, scipy {scipy.__version__}, Python {sys.version.split()[0]}"`);
  return { versions: `${versions}, Pyodide ${python.version}` };
}

// The last line of a traceback is what a reader can use.
function said(error) {
  const lines = String(error.message ?? error).trim().split("\n");
  return (error.constructor?.name === "PythonError" ? lines[lines.length - 1].replace(/^\w*Error: /, "") : lines.join(" ")).trim();
}

function written(folder, files) {
  python.FS.mkdirTree(folder);
  for (const name of python.FS.readdir(folder)) if (!/^\.+$/.test(name)) python.FS.unlink(`${folder}/${name}`);
  for (const [name, bytes] of files) python.FS.writeFile(`${folder}/${name}`, bytes);
}

const ACTS = {
  load,
  start({ key, name, data }) {
    if (data) python.unpackArchive(data, "zip", { extractDir: `/home/pyodide/data/${name}` });
    return glue("start", key, name, `data/${name}`);
  },
  bring({ wheel }) {
    python.unpackArchive(wheel, "wheel");
    return {};
  },
  open({ key, name, files, fields }) {
    written("/home/pyodide/own", files);
    return glue("opened", key, name, "own", fields);
  },
  update: ({ key, text }) => glue("update", key, text),
  save: ({ key, name }) => glue("save", key, name),
};

onmessage = async ({ data: { id, kind, ...rest } }) => {
  try {
    const answer = await ACTS[kind](rest);
    tell({ kind: "answer", id, answer }, (answer.buffers ?? []).map((values) => values.buffer));
  } catch (error) {
    tell({ kind: "answer", id, error: said(error) });
  }
};
