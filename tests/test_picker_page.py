"""The peak picker in a plain page: Chromium draws it, Python answers it, and no notebook stands between.

The page is a host as small as a host can be: get, set, save_changes and on. What it is asked it passes on to
`rbfound.frontend.answer`, as a kernel or a worker would.
"""

import importlib.util
import json
import os
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import FLAGS, chromium

import rbfound as rb
from rbfound import thesis
from rbfound.bench import Bench, bench_of
from rbfound.frontend import answer, scene
from rbfound.picking import first_picks, picked

PACKAGE = Path(rb.__file__).parent
DATA = Path(__file__).resolve().parent.parent / "data" / "foundation"

PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>picker</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>%(css)s
body { margin: 8px; background: #fff; } html[data-theme=dark] body { background: #0d1014; }</style>
<main id="here"></main><p><a href="#end">after</a></p>
<script type="module">%(js)s
const state = %(state)s, acts = {}, bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const tell = (name) => (acts[`change:${name}`] ?? []).forEach((act) => act());
state.data = bytes(state.data);
const model = window.model = {
  get: (name) => state[name],
  set: (name, value) => { state[name] = value; tell(name); },
  on: (name, act) => (acts[name] ??= []).push(act),
  off: (name, act) => { acts[name] = acts[name].filter((other) => other !== act); },
  async save_changes() {
    const stamp = state.stamp, asked = JSON.stringify([state.peaks, state.method]);
    const [result, curves] = await window.ask(asked);
    state.curves = bytes(curves);
    model.set("result", { ...result, stamp });
  },
};
window.latencies = [];
document.addEventListener("rbfound-drawn", (event) => window.latencies.push(event.detail.latency));
window.remove = render({ model, el: document.getElementById("here") });
model.save_changes();
</script></html>"""


def page_of(bench: Bench, method: str = "pmsm") -> str:
    """A page with a picker."""
    names, curves = scene(bench)
    state = {
        "scene": names,
        "data": b64encode(curves).decode(),
        "peaks": names["first"][method],
        "method": method,
        "stamp": 0,
        "result": {},
        "curves": "",
    }
    js = (PACKAGE / "picker.js").read_text(encoding="utf-8").replace("export default", "window.exported =")
    css = (PACKAGE / "picker.css").read_text(encoding="utf-8")
    return PAGE % {"css": css, "js": js, "state": json.dumps(state)}


def missing(sentence: str) -> None:
    """Skip, with what to do about it; in CI a skip would hide a broken page, so there it fails."""
    if os.environ.get("RBFOUND_REQUIRE_BROWSER"):
        pytest.fail(sentence)
    pytest.skip(sentence)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    executable = chromium()
    if executable is None:
        missing("The picker's tests need Chromium: install it (Debian, Ubuntu: apt-get install chromium).")
    if not importlib.util.find_spec("playwright"):
        missing("The picker's tests need playwright: make test installs it.")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def bench() -> Bench:
    truth = rb.load_foundation(DATA / "truth.npz")
    return bench_of(rb.load_frf(DATA / "fine"), thesis.rotor(), thesis.bearings(), truth)


class Stage:
    """A page with a picker, and all that went wrong."""

    def __init__(self, browser: Any, bench: Bench, folder: Path, method: str = "pmsm", **options: Any) -> None:
        self.bench, self.troubles = bench, []
        path = folder / "page.html"
        path.write_text(page_of(bench, method), encoding="utf-8")
        options = {"viewport": {"width": 1280, "height": 1000}, **options}
        self.context = browser.new_context(**options)
        self.context.set_default_timeout(10_000)
        self.page = self.context.new_page()
        self.page.expose_function("ask", self.ask)
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("console", lambda message: self.troubles.append(message.text))
        self.page.on("request", lambda request: self.troubles.extend(self.away(request.url)))
        self.page.goto(path.as_uri())
        self.settle()
        self.canvas = self.page.locator(".rbp-plot canvas").last
        self.handles = self.page.locator(".rbp-handle")

    def ask(self, asked: str) -> list[Any]:
        peaks, method = json.loads(asked)
        _, told, curves = answer(self.bench, peaks, method)
        return [told, b64encode(curves).decode()]

    @staticmethod
    def away(url: str) -> list[str]:
        return [] if url.startswith(("file:", "data:", "blob:")) else [url]

    def settle(self) -> None:
        """Until the last move has been answered and drawn."""
        self.page.wait_for_function("window.latencies.length && window.model.get('result').stamp === model.get('stamp')")
        self.page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def peaks(self) -> list[dict[str, Any]]:
        return list(self.page.evaluate("model.get('peaks')"))

    def result(self) -> dict[str, Any]:
        return dict(self.page.evaluate("model.get('result')"))

    def picture(self) -> str:
        self.settle()
        return str(self.canvas.evaluate("canvas => canvas.toDataURL()"))

    def middle(self, k: int) -> tuple[float, float]:
        box = self.handles.nth(k).bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
