"""The peak picker in a plain page: Chromium draws it, Python answers it, and no notebook stands between.

The page is a host as small as a host can be: get, set, save_changes and on. What it is asked it passes on to
`rbfound.live.frontend.answer`, as a kernel or a worker would.
"""

import json
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import launched

import rbfound as rb
from rbfound import thesis
from rbfound.live import bench_of, script, sheet
from rbfound.live.bench import Bench
from rbfound.live.frontend import answer, scene
from rbfound.live.picking import picked

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"

pytestmark = pytest.mark.book

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
// as a notebook does, the picker is made first and put into the page later
const made = document.createElement("div");
window.picker = new Picker(model, made);
setTimeout(() => document.getElementById("here").append(made), 50);
window.remove = () => window.picker.remove();
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
    js = script("picker").replace("export default", "window.exported =")
    return PAGE % {"css": sheet("picker"), "js": js, "state": json.dumps(state)}


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched("The picker's tests") as browser:
        yield browser


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
        self.session = self.context.new_cdp_session(self.page)
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
        self.page.wait_for_function(
            "window.latencies.length && window.model.get('result').stamp === model.get('stamp')"
        )
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

    def drag(self, k: int, dx: float, dy: float = 150.0) -> None:
        """Take the line of a peak below its name, and move it."""
        x, y = self.middle(k)
        self.page.mouse.move(x, y + dy)
        self.page.mouse.down()
        self.page.mouse.move(x + dx, y + dy, steps=6)
        self.page.mouse.up()
        self.settle()


@pytest.fixture
def stage(browser: Any, bench: Bench, tmp_path: Path) -> Iterator[Stage]:
    stage = Stage(browser, bench, tmp_path)
    yield stage
    stage.context.close()
    assert stage.troubles == []


def matches(stage: Stage, method: str = "pmsm") -> None:
    """What the page has been told is what its peaks give."""
    found, told = picked(stage.bench, stage.peaks(), method), stage.result()
    assert told["message"] == ""
    np.testing.assert_allclose(told["Phi"], found.Phi, rtol=1e-12)
    np.testing.assert_allclose(told["matrices"]["K"], found.foundation.K, rtol=1e-12)


def test_dragging_a_line_moves_its_peak_and_what_follows_from_it(stage: Stage) -> None:
    before, picture = stage.peaks(), stage.picture()
    stage.drag(1, 60.0)
    after = stage.peaks()
    assert after[1]["frequency"] > before[1]["frequency"] + 30
    assert [after[k] for k in (0, 2, 3)] == [before[k] for k in (0, 2, 3)]
    assert stage.picture() != picture
    matches(stage)
    shown = stage.page.locator(".rbp-matrix").first.locator("tbody td").all_text_contents()
    Phi = picked(stage.bench, after).Phi
    # three digits, four decimals where the entry is small
    numbers = [float(text.replace("−", "-")) / 100 for text in shown]
    assert "10⁻²" in stage.page.locator(".rbp-card h4").nth(1).text_content()
    np.testing.assert_allclose(numbers, Phi.ravel(), rtol=5.1e-3, atol=5.1e-7)


def test_every_seat_has_its_own_colour_on_the_picture(stage: Stage) -> None:
    colours = stage.page.evaluate("picker.colours")
    assert len(set(colours)) == 4
    base = stage.page.locator(".rbp-plot canvas").first
    pixels = """canvas => {
      const p = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data, seen = {};
      for (let k = 0; k < p.length; k += 4) {
        const hex = "#" + [0, 1, 2].map((i) => p[k + i].toString(16).padStart(2, "0")).join("");
        if (p[k + 3] === 255) seen[hex] = (seen[hex] ?? 0) + 1;
      }
      return seen;
    }"""
    stage.settle()
    seen = base.evaluate(pixels)
    assert all(seen.get(colour, 0) > 20 for colour in colours), {colour: seen.get(colour) for colour in colours}


def test_a_line_follows_the_pointer_to_the_pixel(stage: Stage) -> None:
    x, _ = stage.middle(3)
    stage.drag(3, -80.0)
    # its name is centred above the line and rounded to a pixel
    assert abs(stage.middle(3)[0] - (x - 80.0)) <= 1.01


def test_the_squares_change_the_damping(stage: Stage) -> None:
    stage.handles.nth(3).focus()
    for _ in range(7):
        stage.page.keyboard.press("+")
    stage.settle()
    before = stage.peaks()[3]
    grips = stage.page.evaluate("window.picker.grips")
    box = stage.canvas.bounding_box()
    stage.page.mouse.move(box["x"] + grips["high"], box["y"] + grips["y"])
    stage.page.mouse.down()
    stage.page.mouse.move(box["x"] + grips["high"] + 25, box["y"] + grips["y"], steps=4)
    stage.page.mouse.up()
    stage.settle()
    after = stage.peaks()[3]
    assert before["damping"] is None
    assert after["damping"] > 0.0199
    assert after["frequency"] == before["frequency"]
    matches(stage)


@pytest.mark.parametrize(
    ("key", "step"),
    [("ArrowRight", 0.5), ("ArrowLeft", -0.5), ("Shift+ArrowRight", 0.05), ("PageUp", 5.0), ("Shift+PageDown", -0.5)],
)
def test_keys_move_the_peak_by_lines_of_the_data(stage: Stage, key: str, step: float) -> None:
    before = stage.peaks()[0]["frequency"]
    stage.handles.nth(0).focus()
    stage.page.keyboard.press(key)
    stage.settle()
    assert stage.peaks()[0]["frequency"] == pytest.approx(before + step, abs=1e-9)
    assert stage.page.evaluate("scrollY") == 0
    matches(stage)


def test_up_and_down_widen_and_narrow_and_home_reads_the_curve_again(stage: Stage) -> None:
    stage.handles.nth(0).focus()
    stage.page.keyboard.press("ArrowUp")
    stage.settle()
    read = picked(stage.bench, stage.page.evaluate("model.get('scene').first.pmsm")).peaks.damping[0]
    assert stage.peaks()[0]["damping"] == pytest.approx(1.05 * read, rel=1e-9)
    stage.page.keyboard.press("ArrowRight")
    stage.page.keyboard.press("Home")
    stage.settle()
    assert stage.peaks()[0] == stage.page.evaluate("model.get('scene').first.pmsm[0]")


def test_a_whole_drag_is_undone_and_made_again_and_so_is_what_was_deleted(stage: Stage) -> None:
    first = stage.peaks()
    stage.drag(1, 60.0)
    dragged = stage.peaks()
    stage.page.keyboard.press("Delete")
    stage.settle()
    for key, expected in (
        ("z", dragged),
        ("z", first),
        ("y", dragged),
        ("Shift+Z", dragged[:1] + dragged[2:]),
        ("z", dragged),
    ):
        stage.page.keyboard.press(f"Control+{key}")
        stage.settle()
        assert stage.peaks() == expected
    stage.page.get_by_role("button", name="Undo").click()
    stage.page.get_by_role("button", name="Undo").click()
    stage.settle()
    assert stage.peaks() == first
    assert stage.page.locator("[aria-live=polite]").text_content() == "There is nothing to undo."
    matches(stage)


@pytest.mark.parametrize("method", ["pmsm", "distinct", "identify"])
def test_the_lines_of_python_that_can_be_copied_give_the_foundation_that_is_shown(stage: Stage, method: str) -> None:
    stage.page.get_by_label("Method", exact=True).select_option(method)
    stage.settle()
    code = stage.page.evaluate("picker.python()").replace('"data"', repr(str(DATA / "fine")))
    made: dict[str, Any] = {}
    exec(code, made)
    shown = picked(stage.bench, stage.peaks(), method).foundation
    np.testing.assert_allclose(made["foundation"].K, shown.K, rtol=1e-12)


def test_tab_goes_from_peak_to_peak_and_each_says_what_it_is(stage: Stage) -> None:
    stage.handles.nth(0).focus()
    seen = []
    for _ in range(4):
        seen.append(stage.page.evaluate("document.activeElement.getAttribute('aria-valuetext')"))
        stage.page.keyboard.press("Tab")
    assert [text.split(",")[0] for text in seen] == ["Peak x1", "Peak y1", "Peak x2", "Peak y2"]
    assert seen[0] == "Peak x1, 159.6 hertz, damping ratio 2.00 percent"
    handle = stage.handles.nth(0)
    handle.focus()
    assert handle.get_attribute("role") == "slider"
    assert handle.evaluate("h => h.matches(':focus-visible') && getComputedStyle(h).outlineStyle") == "solid"
    stage.page.keyboard.press("ArrowRight")
    stage.page.wait_for_timeout(400)
    assert stage.page.locator("[aria-live=polite]").text_content().startswith("Peak x1, 160.1 hertz")


def test_delete_takes_a_peak_away_calmly_and_insert_brings_one_back(stage: Stage) -> None:
    stage.handles.nth(2).focus()
    stage.page.keyboard.press("Delete")
    stage.settle()
    assert len(stage.peaks()) == 3
    message = stage.page.get_by_role("status")
    assert "x2 has none" in message.text_content()
    assert stage.page.locator(".rbp-side.is-stale").count() == 2
    assert stage.page.locator(".rbp-matrix").count() == 4
    stage.page.keyboard.press("Insert")
    stage.settle()
    assert sorted(peak["seat"] for peak in stage.peaks()) == ["x1", "x2", "y1", "y2"]
    assert not message.is_visible()
    assert stage.page.locator(".rbp-side.is-stale").count() == 0
    matches(stage)
    stage.page.keyboard.press("Enter")
    assert "Every seat has its peak" in stage.page.locator("[aria-live=polite]").text_content()


def test_frequency_and_damping_can_be_typed(stage: Stage) -> None:
    stage.page.get_by_label("frequency of peak y1 in hertz").fill("279")
    stage.page.keyboard.press("Enter")
    stage.page.get_by_label("damping ratio of peak y1 in percent").fill("3")
    stage.page.keyboard.press("Enter")
    stage.settle()
    assert stage.peaks()[1] == {"seat": "y1", "frequency": 279, "damping": 0.03}
    matches(stage)


def test_a_method_chosen_brings_its_peaks_and_identify_needs_none(stage: Stage) -> None:
    method = stage.page.get_by_label("Method", exact=True)
    method.select_option(label="PMSM, distinct modes")
    stage.settle()
    matches(stage, "distinct")
    assert stage.result()["condition"] < 2
    method.select_option("identify")
    stage.settle()
    assert stage.handles.count() == len(stage.bench.fit.natural_frequency[stage.bench.fit.inside])
    before = stage.result()
    stage.handles.nth(0).focus()
    stage.page.keyboard.press("ArrowRight")
    stage.settle()
    assert stage.result() == before
    method.select_option("pmsm")
    stage.settle()
    assert stage.handles.count() == 4
    matches(stage)


def test_the_wheel_zooms_once_the_picture_has_been_clicked_and_a_double_click_shows_all(stage: Stage) -> None:
    box, before = stage.canvas.bounding_box(), stage.picture()
    x, y = box["x"] + 600, box["y"] + 120
    stage.page.mouse.move(x, y)
    stage.page.mouse.wheel(0, -100)
    assert stage.picture() == before
    stage.page.mouse.click(x, y)
    clicked = stage.picture()
    stage.page.mouse.wheel(0, -300)
    stage.page.wait_for_timeout(100)
    assert stage.picture() != clicked
    low, high = stage.page.evaluate("[picker.view.low, picker.view.high]")
    assert 0.5 < low < high < 1000
    stage.page.mouse.down()
    stage.page.mouse.move(x + 40, y, steps=3)
    stage.page.mouse.up()
    stage.settle()
    assert stage.page.evaluate("picker.view.low") < low
    stage.page.mouse.dblclick(x + 40, y)
    stage.page.wait_for_timeout(100)
    assert stage.page.evaluate("[picker.view.low, picker.view.high]") == [0.5, 1000]


def test_other_curves_and_other_axes_are_other_pictures(stage: Stage) -> None:
    pictures = [stage.picture()]
    for label, value in (("Amplitude", ""), ("Frequency", "log"), ("Show", "parts")):
        stage.page.get_by_label(label, exact=True).select_option(value)
        pictures.append(stage.picture())
    assert stage.page.get_by_label("Amplitude", exact=True).is_disabled()
    stage.page.locator(".rbp-choice summary").click()
    stage.page.get_by_label("response x2, force y1").check()
    pictures.append(stage.picture())
    stage.page.get_by_role("button", name="all", exact=True).click()
    assert stage.page.locator(".rbp-choice summary").text_content() == "FRFs: 16 of 16"
    pictures.append(stage.picture())
    assert len(set(pictures)) == len(pictures)


def test_the_page_goes_on_from_what_its_host_sets(stage: Stage, bench: Bench) -> None:
    peaks = [
        {"seat": s, "frequency": f, "damping": None}
        for s, f in zip(bench.frf.labels, (150, 350, 151, 349), strict=True)
    ]
    stage.page.evaluate("peaks => { model.set('peaks', peaks); model.save_changes(); }", peaks)
    stage.settle()
    assert stage.handles.nth(1).get_attribute("aria-valuenow") == "350.00"
    assert stage.peaks() == peaks


def test_the_theme_of_the_page_is_followed(stage: Stage) -> None:
    before = stage.picture()
    stage.page.evaluate("document.documentElement.dataset.theme = 'dark'")
    assert stage.picture() != before
    stage.page.evaluate("document.documentElement.dataset.theme = 'light'")
    assert stage.picture() == before
    stage.page.evaluate("delete document.documentElement.dataset.theme")
    stage.page.emulate_media(color_scheme="dark")
    assert stage.picture() != before
    stage.page.evaluate("document.body.dataset.jpThemeLight = 'true'")
    assert stage.picture() == before


def test_a_dark_book_shows_no_pale_frame(stage: Stage) -> None:
    # the book's theme as it stands in a built page
    stage.page.add_style_tag(
        content="html[data-theme=dark] .bd-content div.cell_output .widget-subarea { background: #ccc; padding: 8px }"
    )
    stage.page.evaluate("""() => {
        document.documentElement.dataset.theme = "dark";
        const here = document.getElementById("here"), classes = ["widget-subarea", "cell_output", "bd-content"];
        let inner = here.firstChild;
        for (const name of classes) {
            const outer = Object.assign(document.createElement("div"), { className: name });
            inner.replaceWith(outer);
            outer.append(inner);
            inner = outer;
        }
    }""")
    area = stage.page.locator(".widget-subarea")
    found = area.evaluate("area => [getComputedStyle(area).backgroundColor, getComputedStyle(area).paddingTop]")
    assert found == ["rgba(0, 0, 0, 0)", "0px"]


def test_a_removed_picker_leaves_no_ear_behind(stage: Stage) -> None:
    stage.page.evaluate("window.remove()")
    stage.page.evaluate("model.set('result', {...model.get('result'), stamp: 1})")
    stage.page.evaluate("document.documentElement.dataset.theme = 'dark'")
    stage.page.wait_for_timeout(100)


def test_a_host_that_does_not_answer_is_said(browser: Any, bench: Bench, tmp_path: Path) -> None:
    stage = Stage(browser, bench, tmp_path)
    stage.page.evaluate("model.save_changes = () => {}")
    stage.handles.nth(0).focus()
    stage.page.keyboard.press("ArrowRight")
    stage.page.get_by_text("Python has not answered").wait_for()
    stage.context.close()


def test_a_notebook_that_was_made_a_page_says_at_once_where_the_peaks_can_be_moved(stage: Stage) -> None:
    # what is in such a page: the state of its widgets, and a manager that answers nothing
    stage.page.evaluate("""() => {
        window.remove();
        document.querySelector(".rbfound-picker").parentElement.remove();
        const type = "application/vnd.jupyter.widget-state+json";
        document.head.append(Object.assign(document.createElement("script"), { type }));
        document.body.append(Object.assign(document.createElement("a"), { href: "book/live.html" }));
        model.save_changes = () => {};
        exported.render({ model, el: document.getElementById("here") });
    }""")
    note = stage.page.locator(".rbp-note")
    note.wait_for()
    assert "No Python runs behind this page" in note.text_content()
    assert note.get_by_role("link", name="Live").get_attribute("href").endswith("/book/live.html")
    assert stage.page.get_by_role("status").count() == 0
    stage.handles.nth(0).focus()
    stage.page.keyboard.press("PageUp")
    # sooner than "Computing…" would stand there
    stage.page.wait_for_timeout(100)
    assert "belongs to the peaks as they were before" in stage.page.get_by_role("status").text_content()
    stage.page.wait_for_timeout(400)
    assert stage.page.get_by_text("Computing").count() == 0


def test_where_no_python_runs_a_line_can_be_moved_and_it_is_said(stage: Stage) -> None:
    stage.page.evaluate("() => { model.send = () => { throw new TypeError('comm.send is not a function'); }; }")
    before = stage.handles.nth(0).get_attribute("aria-valuenow")
    stage.handles.nth(0).focus()
    stage.page.keyboard.press("PageUp")
    stage.page.wait_for_timeout(100)
    assert float(stage.handles.nth(0).get_attribute("aria-valuenow")) == pytest.approx(float(before) + 5, abs=0.011)
    assert "No Python runs behind this picture" in stage.page.get_by_role("status").text_content()
    assert stage.page.locator(".rbp-side.is-stale").count() == 2


def test_of_a_host_that_takes_messages_two_are_asked_at_once_and_then_the_latest(stage: Stage) -> None:
    stage.page.evaluate("() => { window.sent = []; model.send = (asked) => window.sent.push(asked); }")
    stage.handles.nth(0).focus()
    for _ in range(5):
        stage.page.keyboard.press("ArrowRight")
    first = stage.page.evaluate("sent.map(asked => asked.peaks[0].frequency)")
    assert np.diff(first) == pytest.approx([0.5])
    result = stage.result()
    stage.page.evaluate("told => model.set('result', {...told, stamp: sent[1].stamp})", result)
    last = stage.page.evaluate("sent.map(asked => asked.peaks[0].frequency)")
    # the answer to the second tells that none to the first will come
    assert last == [*first, pytest.approx(first[0] + 2.0)]
    stage.page.evaluate("told => model.set('result', {...told, stamp: sent[2].stamp})", result)
    assert stage.page.evaluate("picker.asking.size") == 0


@pytest.fixture
def phone(browser: Any, bench: Bench, tmp_path: Path) -> Iterator[Stage]:
    screen = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2}
    stage = Stage(browser, bench, tmp_path, **screen, has_touch=True, is_mobile=True)
    yield stage
    stage.context.close()
    assert stage.troubles == []


def touch(stage: Stage, kind: str, *points: tuple[float, float]) -> None:
    """Fingers, as Chromium's own protocol sends them."""
    stage.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in points]})


def test_a_finger_drags_a_peak_and_two_fingers_zoom(phone: Stage) -> None:
    assert phone.page.evaluate("document.scrollingElement.scrollWidth") <= 390
    before = phone.peaks()[3]["frequency"]
    phone.page.get_by_label("Method", exact=True).select_option("distinct")
    phone.settle()
    before = phone.peaks()[3]["frequency"]
    x, y = phone.middle(3)
    touch(phone, "touchStart", (x + 6, y + 100))
    for k in range(1, 6):
        touch(phone, "touchMove", (x + 6 + 8 * k, y + 100))
    touch(phone, "touchEnd")
    phone.settle()
    assert phone.peaks()[3]["frequency"] > before + 50
    x, y = phone.middle(0)
    touch(phone, "touchStart", (x + 60, y + 200), (x + 160, y + 200))
    for k in range(1, 6):
        touch(phone, "touchMove", (x + 60 - 6 * k, y + 200), (x + 160 + 6 * k, y + 200))
    touch(phone, "touchEnd")
    phone.page.wait_for_timeout(100)
    low, high = phone.page.evaluate("[picker.view.low, picker.view.high]")
    # the fingers end 1.6 times as far apart
    assert (high - low) == pytest.approx(999.5 / 1.6, rel=0.02)


def swipe(stage: Stage, x: float, y: float, dx: float, dy: float) -> None:
    """One finger, ten steps."""
    touch(stage, "touchStart", (x, y))
    for k in range(1, 11):
        touch(stage, "touchMove", (x + dx * k / 10, y + dy * k / 10))
        stage.page.wait_for_timeout(16)
    touch(stage, "touchEnd")
    # a page that was thrown comes to rest
    stage.page.wait_for_timeout(500)
    stage.settle()


def test_a_finger_scrolls_the_page_unless_it_holds_a_peak(phone: Stage) -> None:
    def scrolled() -> float:
        return float(phone.page.evaluate("scrollY"))

    peaks, view = phone.peaks(), phone.page.evaluate("picker.view")
    below = phone.page.locator(".rbp-legend").bounding_box()
    box = phone.canvas.bounding_box()
    for x, y in ((200.0, below["y"] + 10), (330.0, box["y"] + 200)):
        swipe(phone, x, y, 0, -150)
        assert scrolled() > 80
        phone.page.evaluate("scrollTo(0, 0)")
    assert phone.peaks() == peaks
    assert phone.page.evaluate("picker.view") == view
    # on a line and on a name, and not quite level
    hertz = phone.page.evaluate("999.5 / (picker.box.right - picker.box.left)")
    for down in (120.0, 0.0):
        x, y = phone.middle(3)
        before = phone.peaks()[3]["frequency"]
        swipe(phone, x, y + down, 60, 70)
        assert phone.peaks()[3]["frequency"] == pytest.approx(before + 60 * hertz, abs=5)
        assert scrolled() == 0
    # sideways on the background the band is moved, once it is not all there
    for _ in range(2):
        phone.page.locator(".rbp-zoom button").first.tap()
    view = phone.page.evaluate("picker.view")
    swipe(phone, 330.0, box["y"] + 280, -60, 0)
    assert phone.page.evaluate("picker.view.low") > view["low"] + 20
    for _ in range(2):
        phone.page.touchscreen.tap(330, box["y"] + 280)
    phone.page.wait_for_timeout(400)
    assert phone.page.evaluate("[picker.view.low, picker.view.high]") == [0.5, 1000]
    assert phone.page.evaluate("visualViewport.scale") == 1


def test_a_tap_chooses_a_peak_and_a_double_tap_puts_it_on_its_maximum(phone: Stage) -> None:
    x, y = phone.middle(1)
    phone.page.touchscreen.tap(x + 3, y + 150)
    phone.settle()
    chosen = phone.page.evaluate("picker.selected")
    assert chosen in (1, 3)
    swipe(phone, x, y + 150, 20, 0)
    moved = phone.peaks()[chosen]["frequency"]
    x, y = phone.middle(chosen)
    for _ in range(2):
        phone.page.touchscreen.tap(x, y + 150)
    phone.settle()
    snapped = phone.peaks()[chosen]["frequency"]
    assert abs(snapped - moved) > 20
    assert min(abs(p.frequency - snapped) for p in phone.bench.readings[chosen]) < 1e-9


def test_the_picture_has_the_pixels_of_the_screen(phone: Stage) -> None:
    width, shown = phone.canvas.evaluate("c => [c.width, c.getBoundingClientRect().width]")
    assert width == pytest.approx(2 * shown, abs=1)
    phone.page.set_viewport_size({"width": 700, "height": 800})
    phone.page.wait_for_timeout(150)
    width, wider = phone.canvas.evaluate("c => [c.width, c.getBoundingClientRect().width]")
    assert wider > shown + 250
    assert width == pytest.approx(2 * wider, abs=1)
