"""The live page as it is published, in headless Chromium: Python comes from Pyodide's CDN, which a folder stands for.

The files of Pyodide are not part of the project: `make pyodide` fetches them, or RBFOUND_PYODIDE names a folder that
has them.
"""

import json
import re
import shutil
from base64 import b64encode
from collections.abc import Iterator
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import is_local, router, served
from browsing import launched, missing, pyodide_folder
from samples import foundation
from written import table, universal

import rbfound as rb
from rbfound import live

ROOT = Path(__file__).resolve().parents[2]
HTML = ROOT / "_build" / "html"
DATA = ROOT / "data" / "foundation"
CDN = "https://cdn.jsdelivr.net/pyodide/"
# Python is started within these milliseconds, all else within the shorter time.
PATIENCE, SHORTLY = 120_000, 30_000
# CPython and Pyodide have other compilers and another BLAS.
AGREE = 1e-6

pytestmark = [pytest.mark.book, pytest.mark.slow]

# What a live thing holds, its arrays as lists.
HELD = """(root, name) => JSON.stringify(root.rbfound.get(name), (_, value) =>
  ArrayBuffer.isView(value) ? Array.from(value, (v) => Number.isFinite(v) ? v : null) : value)"""
WATCH = """window.latencies = []; window.moved = [];
document.addEventListener("rbfound-moved", (event) => window.moved.push(event.detail.latency));
document.addEventListener("rbfound-drawn", (event) => {
  if (event.detail.latency != null) window.latencies.push(event.detail.latency); });"""

FRAME = "new Promise(done => requestAnimationFrame(done))"

# How far the loading of Python is said to be, each time that it is said.
SHARES = """() => { const place = document.querySelector("#live-peak_picker"); window.shares = [];
  const look = () => { const bar = place.querySelector("progress"); if (bar) window.shares.push(bar.value); };
  new MutationObserver(look).observe(place, { subtree: true, childList: true, characterData: true }); }"""

DROP = """(place, [name, text]) => { const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
  place.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true })); }"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    if not (HTML / "book" / "live.html").is_file():
        missing("The live page's tests need the built book: make book.")
    with launched("The live page's tests") as browser:
        yield browser


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    # the book under a path of its own, as many servers have it
    with served(HTML.parent) as url:
        yield f"{url}/{HTML.name}/book/live.html"


@pytest.fixture(scope="module")
def pyodide() -> Path:
    return pyodide_folder()


class Stage:
    """A page, and all that went wrong on it or was asked of others."""

    def __init__(self, browser: Any, url: str, folder: Path | None, **options: Any) -> None:
        self.troubles: list[str] = []
        self.away: set[str] = set()
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        self.context.route("**/*", router(pyodide=folder))
        self.context.set_default_timeout(SHORTLY)
        self.page = self.context.new_page()
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.context.on("request", lambda request: self.asked(request.url))
        self.page.goto(url, wait_until="load")
        self.page.evaluate(WATCH)

    def asked(self, url: str) -> None:
        """Remember an address that is neither this machine's, nor the CDN of Pyodide, nor that of MathJax."""
        if not is_local(url) and not url.startswith(CDN) and "/mathjax@" not in url:
            self.away.add(url)

    def thing(self, name: str) -> Any:
        """A live thing's element."""
        return self.page.locator(f"#live-{name}")

    def run(self, name: str) -> None:
        """Press its button, and wait until it is ready."""
        self.thing(name).locator(".rbfound-live-run").click()
        self.page.wait_for_selector(f"#live-{name}[data-ready], #live-{name}[data-failed]", timeout=PATIENCE)
        assert self.thing(name).get_attribute("data-failed") is None, self.status(name)

    def status(self, name: str) -> str:
        """What is said below it."""
        return str(self.thing(name).locator("> .rbfound-live-status").inner_text())

    def held(self, name: str, key: str) -> Any:
        """A value of its model."""
        root = self.thing(name).element_handle()
        return json.loads(self.page.evaluate(f"([root, key]) => ({HELD})(root, key)", [root, key]) or "null")

    def settle(self, name: str) -> None:
        """Until the latest change has been answered."""
        self.page.wait_for_function(
            "root => root.rbfound.get('result').stamp === root.rbfound.get('stamp') && !root.rbfound.busy",
            arg=self.thing(name).element_handle(),
        )


@pytest.fixture(scope="module")
def stage(browser: Any, address: str, pyodide: Path) -> Iterator[Stage]:
    stage = Stage(browser, address, pyodide)
    for name in live.THINGS:
        stage.run(name)
    yield stage
    stage.context.close()


def same(found: Any, expected: Any, where: str = "") -> None:
    """Equal to 1e-6 of the largest number of each curve, texts to their last digit but one."""
    if isinstance(expected, dict):
        for key, value in expected.items():
            same(found[key], value, f"{where}/{key}")
    elif isinstance(expected, np.ndarray):
        values = np.array([np.nan if v is None else v for v in found])
        np.testing.assert_allclose(
            values, expected, rtol=AGREE, atol=AGREE * np.nanmax(np.abs(expected)), err_msg=where
        )
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected), where
        for k, (one, other) in enumerate(zip(found, expected, strict=True)):
            same(one, other, f"{where}/{k}")
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=AGREE, abs=1e-12), where
    else:
        assert found == expected, where


def figures(told: Any) -> Any:
    """Of an answer its curves: what is printed is made of the same numbers."""
    return [
        {"title": f["title"], "lines": [{"x": line["x"], "y": line["y"]} for line in f["lines"]]}
        for f in told["figures"]
    ]


@pytest.mark.parametrize("name", [name for name in live.THINGS if name != "peak_picker"])
def test_a_slider_moved_by_keys_gives_what_cpython_gives(stage: Stage, name: str) -> None:
    slider = stage.thing(name).locator("input[type=range]").first
    slider.focus()
    for key in ("ArrowRight", "ArrowRight", "PageDown", "ArrowUp"):
        stage.page.keyboard.press(key)
    stage.settle(name)
    thing = live.start(name, DATA)
    settings = stage.held(name, "settings")
    assert settings != thing.values["settings"]
    expected = thing.update({"settings": settings, "stamp": 0})["result"]
    same(figures(stage.held(name, "result")), figures(expected))
    assert stage.troubles == []


def test_switches_and_choices_work_too(stage: Stage) -> None:
    stage.thing("unbalance").get_by_label("mode 2").uncheck()
    stage.settle("unbalance")
    assert stage.held("unbalance", "settings")["mode1"] is False
    stage.thing("reduction").locator("select[name=masters]").select_option("second")
    stage.settle("reduction")
    assert stage.held("reduction", "settings")["masters"] == "second"
    for name in ("unbalance", "reduction"):
        expected = live.start(name, DATA).update({"settings": stage.held(name, "settings"), "stamp": 0})["result"]
        same(figures(stage.held(name, "result")), figures(expected))


def pressed(stage: Stage, place: Any, part: float = 0.5) -> tuple[float, float]:
    """Where the mouse is, once it has been pressed on a place, at a part of its width."""
    place.scroll_into_view_if_needed()
    box = place.bounding_box()
    x, y = box["x"] + part * box["width"], box["y"] + box["height"] / 2
    stage.page.mouse.move(x, y)
    stage.page.mouse.down()
    return x, y


def test_a_peak_moved_by_mouse_and_by_keys_gives_the_phi_and_the_frequencies_of_cpython(stage: Stage) -> None:
    before = stage.held("peak_picker", "peaks")
    x, y = pressed(stage, stage.thing("peak_picker").locator(".rbp-handle").nth(0))
    for k in range(1, 15):
        stage.page.mouse.move(x + 4 * k, y)
    stage.page.mouse.up()
    stage.page.keyboard.press("ArrowRight")
    stage.settle("peak_picker")
    peaks = stage.held("peak_picker", "peaks")
    assert peaks[0]["frequency"] > before[0]["frequency"] + 5
    thing = live.start("peak_picker", DATA)
    expected = thing.update({"peaks": peaks, "method": stage.held("peak_picker", "method"), "stamp": 0})["result"]
    found = stage.held("peak_picker", "result")
    assert found["message"] == expected["message"] == ""
    for key in ("Phi", "alone", "under", "peaks"):
        same(found[key], expected[key], key)
    assert stage.troubles == []


def dragged(stage: Stage, place: Any, part: float, steps: int, reach: float) -> None:
    """Press the mouse on a place and draw it, one step with each picture of the screen."""
    x, y = pressed(stage, place, part)
    stage.page.evaluate("window.latencies.length = window.moved.length = 0")
    for k in range(1, steps + 1):
        stage.page.mouse.move(x + reach * k / steps, y)
        stage.page.evaluate(FRAME)
    stage.page.mouse.up()


@pytest.mark.parametrize("name", ["oscillator", "campbell", "unbalance"])
def test_curves_follow_the_pointer_and_the_last_of_them_is_where_it_stopped(stage: Stage, name: str) -> None:
    slider, steps = stage.thing(name).locator("input[type=range]").first, 40
    dragged(stage, slider, 0.4, steps, 0.2 * slider.bounding_box()["width"])
    stage.settle(name)
    # drawn on the way, not only in the end, and never more than once for a step
    assert 2 <= stage.page.evaluate("window.latencies.length") <= steps + 1
    told = live.start(name, DATA).update({"settings": stage.held(name, "settings"), "stamp": 0})["result"]
    same(figures(stage.held(name, "result")), figures(told))


def test_a_peak_is_drawn_with_each_move_and_what_follows_from_it_on_the_way(stage: Stage) -> None:
    steps = 40
    dragged(stage, stage.thing("peak_picker").locator(".rbp-handle").nth(1), 0.5, steps, 40.0)
    stage.settle("peak_picker")
    line, whole = stage.page.evaluate("[window.moved.length, window.latencies.length]")
    # the line waits for nobody: as many pictures as moves, but for those that fell into one frame
    assert steps / 2 <= line <= steps + 1
    assert 2 <= whole <= steps + 1


def test_from_a_server_of_this_machine_it_starts_and_says_how_far_it_is(
    browser: Any, pyodide: Path, tmp_path: Path
) -> None:
    # the files come over HTTP as from a CDN; only the address in the book's script is another one
    book = shutil.copytree(HTML, tmp_path / "book")
    (tmp_path / "pyodide").symlink_to(pyodide)
    about = book / "_static" / "live" / "about.js"
    with served(tmp_path) as url:
        about.write_text(re.sub(re.escape(CDN) + r"v[\d.]+/full/", f"{url}/pyodide/", about.read_text()))
        stage = Stage(browser, f"{url}/book/book/live.html", None)
        stage.page.evaluate(SHARES)
        stage.run("peak_picker")
        shares = stage.page.evaluate("window.shares")
        stage.context.close()
    # told in tenths, so that a screen reader comes to an end
    assert shares == sorted(shares)
    assert 5 < len(set(shares)) <= 12
    assert shares[-1] == 1
    assert stage.troubles == []
    assert stage.away == set()


def test_what_was_picked_can_be_taken_away(stage: Stage, tmp_path: Path) -> None:
    with stage.page.expect_download() as download:
        stage.thing("peak_picker").get_by_role("button", name="foundation.npz").click()
    download.value.save_as(tmp_path / "foundation.npz")
    taken = rb.load_foundation(tmp_path / "foundation.npz")
    same(stage.held("peak_picker", "result")["matrices"]["K"], taken.K.tolist())


def test_files_of_the_reader_are_read_and_identified_in_the_page(stage: Stage) -> None:
    own = stage.thing("peak_picker").locator(".rbfound-live-own")
    own.evaluate(DROP, ["measured.csv", b64encode(b"frequency,x1\n1,2\n").decode()])
    stage.page.wait_for_selector(".rbfound-live-own[data-refused]")
    assert "measured.csv" in own.locator(".rbfound-live-status").inner_text()
    own.get_by_label("Choose files").set_input_files(sorted((DATA / "medium").glob("*.txt")))
    stage.page.wait_for_selector(".rbfound-live-own[data-opened]", timeout=PATIENCE)
    expected = live.opened("peak_picker", DATA / "medium").values["result"]
    found = stage.held("peak_picker", "result")
    # the fit stops where it no longer improves, which is elsewhere with another BLAS
    assert len(found["peaks"]) == len(expected["peaks"])
    for one, other in zip(found["peaks"], expected["peaks"], strict=True):
        assert one["frequency"] == pytest.approx(other["frequency"], rel=1e-4)
    # the page judges them: what is wrong with the data, what the fit leaves over, the damping of each mode
    place = stage.thing("peak_picker")
    assert place.locator(".rbp-findings li").count() == len(stage.held("peak_picker", "scene")["findings"]) + 1
    tables = place.locator(".rbp-plain")
    assert tables.nth(0).locator("tbody td").count() == 4 * 4
    assert tables.nth(1).locator("tbody tr").count() == len(found["peaks"])
    # what only Universal Files need has not been asked for
    assert stage.page.locator("script[src*=pyuff]").count() == 0
    own.get_by_role("button", name="Back").click()
    stage.page.wait_for_function(
        "root => root.rbfound.get('method') === 'pmsm'", arg=stage.thing("peak_picker").element_handle()
    )
    assert stage.troubles == []


@pytest.mark.parametrize("kind", ["Universal File in text", "Universal File in binary", "table"])
def test_one_file_is_identified_in_the_page_and_the_foundation_that_is_taken_away_is_that_of_cpython(
    stage: Stage, tmp_path: Path, kind: str
) -> None:
    # six modes in the band and none beyond: the fit ends at the foundation itself, whatever BLAS goes there
    truth = foundation()
    frf, kept, taken = truth.frf(np.arange(20.0, 340.0, 0.5)), tmp_path / "kept.npz", tmp_path / "taken.npz"
    (tmp_path / "own").mkdir()
    path = (
        table(tmp_path / "own" / "rig.csv", frf)
        if kind == "table"
        else universal(tmp_path / "own" / "rig.UFF", frf, binary=int(kind.endswith("binary")))
    )
    own = stage.thing("peak_picker").locator(".rbfound-live-own")
    own.evaluate(DROP, [path.name, b64encode(path.read_bytes()).decode()])
    stage.page.wait_for_selector(".rbfound-live-own[data-opened], .rbfound-live-own[data-refused]", timeout=PATIENCE)
    assert own.get_attribute("data-refused") is None
    expected = live.opened("peak_picker", tmp_path / "own")
    found = stage.held("peak_picker", "result")
    for key in ("Phi", "alone", "peaks"):
        same(found[key], expected.values["result"][key], key)
    with stage.page.expect_download() as download:
        stage.thing("peak_picker").get_by_role("button", name="foundation.npz").click()
    download.value.save_as(taken)
    kept.write_bytes(expected.saves["foundation.npz"]())
    found, expected_foundation = rb.load_foundation(taken), rb.load_foundation(kept)
    for name in "MCKB":
        same(getattr(found, name), getattr(expected_foundation, name), name)
    np.testing.assert_allclose(found.frf([100.0]).H, truth.frf([100.0]).H, rtol=AGREE)
    assert stage.troubles == []


def test_what_a_file_does_not_say_is_asked_for(stage: Stage, tmp_path: Path) -> None:
    path = universal(tmp_path / "rig.unv", foundation().frf(np.arange(20.0, 340.0, 2.0)), unit=("NONE", "NONE"))
    own = stage.thing("peak_picker").locator(".rbfound-live-own")
    content = [path.name, b64encode(path.read_bytes()).decode()]
    own.evaluate(DROP, content)
    stage.page.wait_for_selector(".rbfound-live-own[data-refused]")
    assert "does not say in which unit" in own.locator(".rbfound-live-status").inner_text()
    assert 'the field "Unit"' in own.locator(".rbfound-live-status").inner_text()
    own.get_by_label("Unit").fill("m/N")
    own.evaluate(DROP, content)
    stage.page.wait_for_selector(".rbfound-live-own[data-opened]")
    own.get_by_label("Unit").fill("")


def test_nothing_was_asked_of_anyone_but_the_book_and_the_cdn_of_pyodide(stage: Stage) -> None:
    assert stage.away == set()


def test_the_page_says_which_versions_run(stage: Stage) -> None:
    assert f"rbfound {rb.__version__}" in stage.status("oscillator")
    assert "Pyodide 0.27.7" in stage.status("oscillator")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_narrow_page_with_everything_running_does_not_scroll_sideways(stage: Stage, theme: str) -> None:
    stage.page.set_viewport_size({"width": 390, "height": 844})
    stage.page.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
    stage.page.wait_for_timeout(300)
    wide = stage.page.evaluate("document.scrollingElement.scrollWidth")
    stage.page.set_viewport_size({"width": 1280, "height": 900})
    stage.page.evaluate("document.documentElement.dataset.theme = 'light'")
    assert wide <= 390


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious_in_what_is_running(stage: Stage, theme: str) -> None:
    if not find_spec("axe_playwright_python"):
        missing("This test needs axe-core: pip install axe-playwright-python, or make test.")
    stage.page.add_style_tag(content="*, *::before, *::after { transition: none !important; }")
    stage.page.evaluate("theme => { document.documentElement.dataset.theme = theme; }", theme)
    stage.page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    found = stage.page.evaluate("axe.run(document.querySelector('article'), {resultTypes: ['violations']})")
    stage.page.evaluate("document.documentElement.dataset.theme = 'light'")
    serious = [v for v in found["violations"] if v["impact"] in ("serious", "critical")]
    assert [(v["id"], v["nodes"][0]["target"], v["nodes"][0].get("failureSummary")) for v in serious] == []


def test_it_runs_from_a_file_as_well(browser: Any, pyodide: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(HTML, tmp_path / "book")
    stage = Stage(browser, (copy / "notebooks" / "01_sdof.html").as_uri(), pyodide)
    stage.run("oscillator")
    same(figures(stage.held("oscillator", "result")), figures(live.start("oscillator", DATA).values["result"]))
    stage.context.close()
    assert stage.troubles == []


def test_where_python_cannot_be_had_a_sentence_says_so_and_the_picture_stays(browser: Any, address: str) -> None:
    stage = Stage(browser, address, None)
    stage.thing("oscillator").locator(".rbfound-live-run").click()
    stage.page.wait_for_selector("#live-oscillator[data-failed]")
    assert "Python could not be started here" in stage.status("oscillator")
    assert stage.thing("oscillator").locator("img:visible").count() == 1
    assert stage.thing("oscillator").get_by_role("button", name="Try again").is_enabled()
    stage.context.close()
    assert stage.troubles == []


@pytest.mark.parametrize(("width", "kind"), [(1280, "wide"), (390, "narrow")])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_still_pictures_are_those_of_the_page(
    browser: Any, address: str, width: int, kind: str, theme: str
) -> None:
    context = browser.new_context(viewport={"width": width, "height": 900})
    context.route("**/*", router())
    page = context.new_page()
    page.goto(address)
    page.evaluate("theme => { document.documentElement.dataset.theme = theme; }", theme)
    for name in live.THINGS:
        picture = page.locator(f"#live-{name} img:visible")
        picture.scroll_into_view_if_needed()
        page.wait_for_function("image => image.complete && image.naturalWidth", arg=picture.element_handle())
        assert picture.evaluate("image => image.currentSrc").endswith(f"/{name}-{kind}-{theme}.webp")
        # its letters are as large as the book's: the picture is not drawn smaller than it is meant to be
        assert picture.bounding_box()["width"] > (640 if kind == "wide" else 320)
    context.close()


def test_without_javascript_there_are_pictures_with_their_descriptions(browser: Any, address: str) -> None:
    context = browser.new_context(java_script_enabled=False)
    context.route("**/*", router())
    page = context.new_page()
    page.goto(address)
    for name in live.THINGS:
        picture = page.locator(f"#live-{name} img:visible")
        assert len(picture.get_attribute("alt")) > 80
        assert "JavaScript is off" in page.locator(f"#live-{name}").inner_text()
    assert page.locator(".rbfound-live-run").count() == 0
    context.close()
