"""The peak picker in a real JupyterLab: its kernel computes what a hand in the browser asks for."""

import importlib.util
import json
import os
import re
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import launched, missing

import rbfound as rb

ROOT = Path(__file__).resolve().parents[2]
CELLS = [
    "import rbfound as rb\n"
    "from rbfound.live.widgets import peak_picker\n"
    'frf, truth = rb.load_frf("FOLDER/fine"), rb.load_foundation("FOLDER/truth.npz")\n'
    "picker = peak_picker(frf, rb.thesis.rotor(), rb.thesis.bearings(), truth)\n"
    "picker",
    'import json\nprint(json.dumps({"peaks": picker.peaks, "M": picker.foundation.M.tolist()}))',
    "picker.peaks = [160, 480, 626, 344]",
    "from rbfound.plots import rotor_body, turnable\n"
    "machine = rb.mount(rb.thesis.rotor(), rb.thesis.bearings())\n"
    "modes = machine.at(0.0).modes().above(1.0).below(500.0)\n"
    'turnable([rotor_body(rb.thesis.rotor(), machine.mesh.z, modes.shapes)], modes.frequency, "The shaft")',
]
# Where Notebook 7 says that its kernel waits.
IDLE = ".jp-NotebookKernelStatus:not(.jp-NotebookKernelStatus-warn), [data-status=idle]"
# Whatever can have the focus.
FOCUSABLE = ":is(button, select, input, summary, a[href], [tabindex='0']):visible:enabled"

pytestmark = [pytest.mark.book, pytest.mark.slow]


def answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=2) as response:
            return bool(response.status == 200)
    except OSError:
        return False


@contextmanager
def server(folder: Path, program: str) -> Iterator[str]:
    """A Jupyter of some kind, jupyterlab or notebook, with one notebook and nothing of the reader's own settings."""
    source = [cell.replace("FOLDER", (ROOT / "data" / "foundation").as_posix()) for cell in CELLS]
    cells = [
        {"cell_type": "code", "id": f"c{k}", "metadata": {}, "execution_count": None, "outputs": [], "source": text}
        for k, text in enumerate(source)
    ]
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    notebook = {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    (folder / "pick.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    private = {name: str(folder / name) for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "IPYTHONDIR")}
    # as `make lab` has it: small matrices are done sooner by one thread
    quick = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", program, "--no-browser", "--allow-root", "--ip=127.0.0.1", f"--port={port}"]
    command += [f"--ServerApp.root_dir={folder}", "--IdentityProvider.token="]
    command += ["--LabApp.news_url=None", "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
    command += ["--LabApp.extension_manager=readonly"]
    log = (folder / "log.txt").open("w")
    process = subprocess.Popen(command, cwd=folder, env={**os.environ, **private, **quick}, stdout=log, stderr=log)
    try:
        until = time.monotonic() + 60
        while not answers(f"http://127.0.0.1:{port}/api"):
            if time.monotonic() > until or process.poll() is not None:
                pytest.fail(f"{program} did not start:\n" + (folder / "log.txt").read_text(encoding="utf-8"))
            time.sleep(0.2)
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(timeout=30)
        log.close()


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    if not importlib.util.find_spec("jupyterlab") or not importlib.util.find_spec("anywidget"):
        missing("The picker's test in JupyterLab needs jupyterlab and anywidget: make test installs them.")
    with server(tmp_path_factory.mktemp("lab"), "jupyterlab") as url:
        yield f"{url}/lab/tree/pick.ipynb?reset"


class Lab:
    """The notebook, opened, its first cell run."""

    def __init__(self, page: Any, url: str, idle: str) -> None:
        self.page, self.troubles = page, []
        page.on("pageerror", lambda error: self.troubles.append(str(error)))
        page.add_init_script(
            "window.drawn = []; document.addEventListener('rbfound-drawn', e => window.drawn.push(e.detail));"
            "window.moved = []; document.addEventListener('rbfound-moved', e => window.moved.push(e.detail.latency));"
        )
        page.goto(url)
        # what is run before the kernel is there may be lost
        page.locator(idle).first.wait_for(timeout=60_000)
        self.run(0)
        page.wait_for_selector(".rbfound-picker .rbp-handle", timeout=60_000)
        self.handles = page.locator(".rbp-handle")
        self.settle()

    def coloured(self) -> int:
        """How many colours the curves have."""
        return int(
            self.page.locator(".rbp-plot canvas").first.evaluate(
                "c => new Set(new Uint32Array(c.getContext('2d')"
                ".getImageData(0, 0, c.width, c.height).data.buffer)).size"
            )
        )

    def run(self, cell: int) -> None:
        self.page.locator(".jp-CodeCell .jp-InputArea-editor").nth(cell).click(timeout=60_000)
        self.page.keyboard.press("Control+Enter")

    def contents(self) -> list[str]:
        """The kind and the text of each cell."""
        return list(
            self.page.locator(".jp-Notebook .jp-Cell").evaluate_all(
                "cells => cells.map(c => c.className.match(/jp-(Code|Markdown|Raw)Cell/)[1]"
                " + c.querySelector('.jp-InputArea').textContent)"
            )
        )

    def settle(self) -> None:
        """Until nothing has been drawn for a while."""
        self.page.wait_for_function("window.drawn.length > 0", timeout=60_000)
        count = -1
        while count != (count := self.page.evaluate("window.drawn.length")):
            self.page.wait_for_timeout(400)

    def printed(self) -> dict[str, Any]:
        """What the second cell prints when it is run."""
        output = self.page.locator(".jp-CodeCell").nth(1).locator(".jp-OutputArea-output pre")
        before = output.text_content() if output.count() else ""
        self.run(1)
        self.page.wait_for_function(
            "before => { const pre = document.querySelectorAll('.jp-CodeCell')[1]"
            ".querySelector('.jp-OutputArea-output pre'); return pre && pre.textContent !== before; }",
            arg=before,
        )
        return dict(json.loads(output.text_content()))

    def frequencies(self) -> list[float]:
        return [float(handle.get_attribute("aria-valuenow")) for handle in self.handles.all()]

    def Phi(self) -> str:
        return str(self.page.locator(".rbp-matrix").first.inner_text())

    def take(self, k: int) -> tuple[float, float]:
        """Press the mouse on a peak's line, below its name."""
        self.handles.nth(k).scroll_into_view_if_needed()
        box = self.handles.nth(k).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + 150
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        return x, y


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched("The picker's tests in Jupyter") as browser:
        yield browser


@contextmanager
def opened(browser: Any, url: str, idle: str) -> Iterator[Lab]:
    page = browser.new_page(viewport={"width": 1500, "height": 1200})
    page.set_default_timeout(20_000)
    lab = Lab(page, url, idle)
    yield lab
    page.close()
    assert lab.troubles == []


@pytest.fixture(scope="module")
def notebook(browser: Any, lab: str) -> Iterator[Lab]:
    with opened(browser, lab, "text=| Idle") as found:
        yield found


def test_a_drag_in_the_notebook_changes_phi_and_the_next_cell_has_what_was_picked(notebook: Lab) -> None:
    before, Phi = notebook.frequencies(), notebook.Phi()
    assert notebook.coloured() > 100
    x, y = notebook.take(1)
    notebook.page.mouse.move(x + 60, y, steps=8)
    notebook.page.mouse.up()
    notebook.settle()
    after = notebook.frequencies()
    assert after[1] > before[1] + 30
    assert notebook.Phi() != Phi
    printed = notebook.printed()
    np.testing.assert_allclose([peak["frequency"] for peak in printed["peaks"]], after, atol=0.005)
    frf = rb.load_frf(ROOT / "data" / "foundation" / "fine")
    damping = rb.identification.pseudo_modes(frf, [after[0], 344, after[2], after[3]]).zeta
    peaks = rb.Peaks(np.array([peak["frequency"] for peak in printed["peaks"]]), damping)
    np.testing.assert_allclose(printed["M"], rb.pmsm(frf, peaks).M, rtol=1e-6)


def test_keys_move_a_peak_and_leave_the_notebook_alone(notebook: Lab) -> None:
    cells, before = notebook.page.locator(".jp-Cell").count(), notebook.frequencies()
    notebook.handles.nth(0).focus()
    for key in ("ArrowRight", "ArrowRight", "ArrowUp"):
        notebook.page.keyboard.press(key)
    notebook.settle()
    assert notebook.frequencies()[0] == pytest.approx(before[0] + 1.0, abs=0.011)
    assert notebook.handles.nth(0).evaluate("handle => handle === document.activeElement")
    notebook.page.keyboard.press("Delete")
    notebook.settle()
    assert notebook.handles.count() == 3
    notebook.page.get_by_text("x1 has none").wait_for()
    notebook.page.keyboard.press("Insert")
    notebook.settle()
    assert notebook.handles.count() == 4
    assert notebook.page.locator(".jp-Cell").count() == cells


def shortcuts() -> list[str]:
    """What JupyterLab takes for a command to the notebook, of keys that a hand may fall on: letters and digits."""
    import jupyterlab

    found = set()
    for path in (Path(jupyterlab.__file__).parents[4] / "share/jupyter/lab/schemas").rglob("*.json"):
        for told in json.loads(path.read_text(encoding="utf-8")).get("jupyter.lab.shortcuts", []):
            keys = told.get("keys", [])
            if all(re.fullmatch(r"(Shift )?[A-Z0-9]", key) for key in keys):
                found.add(tuple(key.replace(" ", "+") if " " in key else key.lower() for key in keys))
    return [key for keys in sorted(found) for key in keys]


def test_no_letter_typed_on_a_part_of_the_picker_or_the_viewer_is_a_command_to_the_notebook(notebook: Lab) -> None:
    letters_are_no_commands(notebook)


def test_nor_is_it_in_notebook_7(browser: Any, tmp_path: Path) -> None:
    if not importlib.util.find_spec("notebook"):
        pytest.skip("Notebook 7 is not installed: pip install notebook.")
    with server(tmp_path, "notebook") as url, opened(browser, f"{url}/notebooks/pick.ipynb", IDLE) as found:
        letters_are_no_commands(found)


def letters_are_no_commands(notebook: Lab) -> None:
    """Type every letter that is a shortcut on each part that can have the focus."""
    notebook.run(3)
    notebook.page.wait_for_selector(".rbfound-view.is-live canvas")
    keys, before = shortcuts(), notebook.contents()
    assert {"x", "d", "m", "y", "r", "a", "b", "0", "i", "Shift+M"} <= set(keys)
    # the notebook is in its command mode, as it is after a click on an output
    notebook.page.locator(".rbp-choice summary").click()
    for place in (".rbfound-picker", ".rbfound-view"):
        parts = notebook.page.locator(f"{place} {FOCUSABLE}")
        assert parts.count() > 5
        for k in range(parts.count()):
            # an element is kept, as what a key changes may be another number of parts
            part = parts.nth(k).element_handle()
            part.focus()
            for key in keys:
                notebook.page.keyboard.press(key)
            said = part.evaluate("part => part.outerHTML.slice(0, 80)")
            assert notebook.contents() == before, said
            assert notebook.page.locator(".jp-Dialog").count() == 0, said
            part.evaluate("part => part.blur()")
    notebook.page.locator(".rbp-choice summary").click()
    notebook.page.get_by_label("Method", exact=True).select_option("pmsm")
    notebook.settle()


def test_peaks_set_in_a_cell_move_the_lines(notebook: Lab) -> None:
    notebook.run(2)
    notebook.page.wait_for_function("document.querySelectorAll('.rbp-handle')[2].ariaValueNow === '626.00'")
    assert notebook.frequencies() == [160, 480, 626, 344]


def test_while_the_pointer_moves_the_line_follows_and_python_answers_on_the_way(notebook: Lab) -> None:
    steps = 50
    notebook.page.evaluate("window.drawn.length = window.moved.length = 0")
    x, y = notebook.take(2)
    for step in range(1, steps + 1):
        notebook.page.mouse.move(x + step, y)
        notebook.page.evaluate("new Promise(done => requestAnimationFrame(done))")
    notebook.page.mouse.up()
    notebook.settle()
    line, whole = notebook.page.evaluate("[window.moved.length, window.drawn.length]")
    # the line waits for nobody; of what Python makes of it there is a picture on the way, and no two for one move
    assert steps / 2 <= line <= steps + 1
    assert 2 <= whole <= steps + 1
