"""Mode shapes in the page: the numbers that go into it, and what a browser makes of them.

The pages are written here, with the real script: no built book is needed.
"""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import launched

import rbfound as rb
from rbfound.plots import Body, rotor_body
from rbfound.thesis import bearings, rotor

viewer = pytest.importorskip("rbfound.plots.viewer", reason="pictures need matplotlib: pip install 'rbfound[plots]'")

ROOT = Path(__file__).resolve().parents[2]


def shaft(which: list[int]) -> tuple[Body, np.ndarray]:
    """Modes of the rotor in its bearings, and their frequencies [Hz]."""
    machine = rb.mount(rotor(), bearings())
    modes = machine.at(0.0).modes().above(1.0)
    body = rotor_body(rotor(), machine.mesh.z, modes.shapes[:, which], list(bearings()))
    return body, modes.frequency[which]


def decoded(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(b64decode(text), kind)


def test_points_faces_and_shapes_come_back_from_the_page_to_the_last_bit_they_have() -> None:
    (body,) = viewer.normalised([shaft([0, 2, 4])[0]])
    (sent,) = viewer.encoded([body], ["1", "2", "3"])["bodies"]
    half, centre = np.ptp(body.points, axis=0).max() / 2, (body.points.max(axis=0) + body.points.min(axis=0)) / 2
    points = decoded(sent["points"], "<i2").reshape(-1, 3) / 32767 * half + centre
    np.testing.assert_allclose(points, body.points, atol=half / 32767 / 2 * 1.01)
    np.testing.assert_array_equal(decoded(sent["faces"], "<u2").reshape(-1, 4), body.faces)
    for shape, wanted in zip(sent["shapes"], body.shapes, strict=True):
        got = decoded(shape["real"], "i1").reshape(-1, 3) / 127 * shape["size"]
        np.testing.assert_allclose(got, wanted.real, atol=shape["size"] / 127 / 2 * 1.01)
    assert sent["marks"] == dict(body.marks)


def test_what_moves_more_is_darker_in_both_themes() -> None:
    for themes in viewer.RAMPS:
        for little, much in themes:
            light = [np.dot(viewer.to_rgb(colour), [0.2126, 0.7152, 0.0722]) for colour in (little, much)]
            # a difference that a grey printer shows, too
            assert light[0] > light[1] + 0.3


def test_an_imaginary_part_is_sent_where_there_is_one() -> None:
    shape = np.array([[1.0, 1.0j, 0.0], [0.5, 0.0, 0.0]])
    sent = viewer.displacements(shape)
    np.testing.assert_allclose(decoded(sent["imag"], "i1").reshape(-1, 3) / 127 * sent["size"], shape.imag, atol=0.004)
    assert set(viewer.displacements(shape.real)) == {"size", "real"}


def test_the_largest_displacement_of_all_bodies_together_is_one_and_at_its_largest_now() -> None:
    first, _ = shaft([0, 2])
    turned = replace(first, shapes=3j * first.shapes)
    second = replace(first, shapes=0.5 * turned.shapes, name="half")
    bodies = viewer.normalised([turned, second])
    for k in range(2):
        sizes = [np.linalg.norm(body.shapes[k].real, axis=1).max() for body in bodies]
        np.testing.assert_allclose(sizes, [1.0, 0.5], rtol=1e-12)


def test_a_circling_point_stays_complex_and_a_mode_almost_in_step_does_not() -> None:
    body, _ = shaft([0])
    circle = replace(body, shapes=np.tile([1.0, -1.0j, 0.0], (1, len(body.points), 1)))
    (out,) = viewer.normalised([circle])
    np.testing.assert_allclose(np.linalg.norm(out.shapes[0].imag, axis=1), 1.0)
    flat = np.tile([1.0, 0.01j, 0.0], (1, len(body.points), 1))
    (out,) = viewer.normalised([replace(body, shapes=flat)])
    assert not np.any(np.imag(out.shapes))


def test_what_cannot_be_shown_is_refused_in_a_sentence() -> None:
    body, frequency = shaft([0, 2])
    with pytest.raises(ValueError, match="1 frequencies and 2 shapes"):
        viewer.turnable([body], frequency[:1], "Rotor")
    with pytest.raises(ValueError, match="rotor 2, other 1"):
        viewer.normalised([body, replace(body, shapes=body.shapes[:1], name="other")])
    with pytest.raises(ValueError, match="no body"):
        viewer.normalised([])
    with pytest.raises(ValueError, match="Nothing moves in shape 2"):
        viewer.normalised([replace(body, shapes=body.shapes * [[[1.0]], [[0.0]]])])
    more = np.zeros((65536, 3))
    many = replace(body, points=np.vstack([body.points, more]), shapes=np.vstack([body.shapes[0], more])[None])
    with pytest.raises(ValueError, match="a page takes 65535"):
        viewer.encoded([many], ["1"])


def test_the_text_says_what_is_shown_and_the_page_asks_nothing_of_the_network() -> None:
    body, frequency = shaft([0, 2])
    shown = viewer.turnable([body], frequency, "A rotor </script> & its bearings")
    assert repr(shown) == "A rotor </script> & its bearings (rotor): modes 1: 185.4 Hz, 2: 225.6 Hz."
    html = shown._repr_html_()
    assert html.count("</script>") == 2
    assert "A rotor &lt;/script&gt; &amp; its" in html
    assert not re.search(r"https?:|href|fetch\(|XMLHttp|@import|url\(", html)
    assert [source[:23] for source in re.findall(r'src="([^"]+)"', html)] == ["data:image/webp;base64,"]
    data = json.loads(re.search(r'<script type="application/json">(.+?)</script>', html, re.DOTALL)[1])
    assert data["title"] == "A rotor </script> & its bearings"
    assert data["labels"] == ["1: 185.4 Hz", "2: 225.6 Hz"]


def test_the_still_picture_shows_every_mode() -> None:
    body, _ = shaft([0, 2, 4])
    bodies = viewer.normalised([body])
    one, three = (viewer.still([replace(bodies[0], shapes=bodies[0].shapes[:n])], ["1", "2", "3"][:n]) for n in (1, 3))
    assert one[:4] == b"RIFF"
    assert one[8:12] == b"WEBP"
    assert one != three


@pytest.mark.slow
@pytest.mark.skipif(not importlib.util.find_spec("nbval"), reason="needs nbval: make test installs it")
@pytest.mark.parametrize(("text", "passes"), [("rotor (rotor): modes 1: 185.4 Hz.", True), ("rotor: 1 Hz.", False)])
def test_nbval_compares_the_text_of_a_picture_and_takes_its_html_as_it_is(
    text: str, passes: bool, tmp_path: Path
) -> None:
    source = [
        "from rbfound import mount, plots, thesis\n",
        "from rbfound.plots.surfaces import rotor_body\n",
        "machine = thesis.model('c')\n",
        "modes = machine.at(0.0).modes().above(1.0)\n",
        "body = rotor_body(thesis.rotor(), machine.mesh.z, modes.shapes[:, :1])\n",
        "plots.turnable([body], modes.frequency[:1], 'rotor')",
    ]
    output = {"output_type": "execute_result", "execution_count": 1, "data": {"text/plain": [text]}, "metadata": {}}
    cell = {"cell_type": "code", "execution_count": 1, "id": "a", "metadata": {}, "source": source, "outputs": [output]}
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    notebook = {"cells": [cell], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "turn.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    shutil.copy(ROOT / "notebooks" / "conftest.py", tmp_path)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--nbval", "turn.ipynb"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (run.returncode == 0) == passes, run.stdout + run.stderr


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with the same view twice, the first one of glass."""
    body, frequency = shaft([0, 2])
    views = [viewer.turnable([replace(body, sheer=sheer)], frequency, "Rotor").html for sheer in (True, False)]
    path = tmp_path_factory.mktemp("viewer") / "page.html"
    path.write_text(f'<!doctype html><html lang="en"><meta charset="utf-8"><body>{"".join(views)}', encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched("The viewer's tests") as browser:
        yield browser


class Stage:
    """The first view of the page, and all that went wrong."""

    def __init__(self, browser: Any, path: Path, motion: str = "reduce", **options: Any) -> None:
        self.troubles: list[str] = []
        self.context = browser.new_context(viewport={"width": 800, "height": 900}, reduced_motion=motion, **options)
        self.context.set_default_timeout(10_000)
        self.page = self.context.new_page()
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("console", lambda message: self.troubles.append(message.text))
        self.page.on("request", lambda request: self.troubles.extend(self.away(request.url)))
        self.page.goto(path.as_uri())
        self.view = self.page.locator(".rbfound-view").first
        self.canvas = self.view.locator("canvas")

    @staticmethod
    def away(url: str) -> list[str]:
        return [] if url.startswith(("file:", "data:")) else [url]

    def picture(self) -> str:
        """The canvas's pixels, once what was asked for has been drawn."""
        self.page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return str(self.canvas.evaluate("canvas => canvas.toDataURL()"))

    def button(self, name: str) -> Any:
        return self.view.get_by_role("button", name=name, exact=True)


@pytest.fixture
def stage(browser: Any, page_file: Path) -> Iterator[Stage]:
    stage = Stage(browser, page_file)
    yield stage
    stage.context.close()
    assert stage.troubles == []


def test_each_view_of_a_page_is_drawn_once(stage: Stage) -> None:
    assert stage.page.locator("canvas").count() == 2
    colours = "c => new Set(new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size"
    stage.picture()
    assert stage.canvas.evaluate(colours) > 20


def test_dragging_turns_the_picture_and_reset_brings_it_back(stage: Stage) -> None:
    before = stage.picture()
    box = stage.canvas.bounding_box()
    stage.page.mouse.move(box["x"] + 300, box["y"] + 100)
    assert stage.picture() == before
    stage.page.mouse.down()
    stage.page.mouse.move(box["x"] + 360, box["y"] + 120, steps=3)
    stage.page.mouse.up()
    after = stage.picture()
    assert after != before
    stage.page.mouse.move(box["x"] + 100, box["y"] + 120)
    assert stage.picture() == after
    stage.button("Reset the view").click()
    assert stage.picture() == before


@pytest.mark.parametrize("key", ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Shift+ArrowLeft", "Shift+ArrowUp"])
def test_arrow_keys_turn_the_picture_or_move_it_and_leave_the_page_where_it_is(stage: Stage, key: str) -> None:
    before = stage.picture()
    stage.canvas.press(key)
    assert stage.picture() != before
    assert stage.page.evaluate("scrollY") == 0


def test_plus_minus_and_buttons_zoom(stage: Stage) -> None:
    pictures = [stage.picture()]
    stage.canvas.focus()
    for act in (
        lambda: stage.page.keyboard.press("+"),
        lambda: stage.button("Zoom in").click(),
        lambda: stage.button("Zoom out").click(),
        lambda: stage.canvas.press("-"),
    ):
        act()
        pictures.append(stage.picture())
    assert len(set(pictures[:3])) == 3


def test_the_wheel_scrolls_the_page_until_the_picture_has_been_clicked(stage: Stage) -> None:
    before = stage.picture()
    stage.canvas.hover()
    stage.page.mouse.wheel(0, 60)
    assert stage.picture() == before
    stage.canvas.click()
    stage.page.mouse.wheel(0, 60)
    stage.page.wait_for_timeout(100)
    assert stage.picture() != before


def test_play_sets_it_moving_and_pause_stops_it(stage: Stage) -> None:
    still = stage.picture()
    assert stage.picture() == still
    stage.button("Play").click()
    stage.page.wait_for_timeout(150)
    moving = stage.picture()
    stage.page.wait_for_timeout(150)
    assert len({still, moving, stage.picture()}) == 3
    stage.button("Pause").click()
    stopped = stage.picture()
    stage.page.wait_for_timeout(150)
    assert stage.picture() == stopped
    stage.canvas.press(" ")
    assert stage.button("Pause").count() == 1


def test_it_moves_by_itself_only_for_those_who_did_not_ask_for_less_motion(browser: Any, page_file: Path) -> None:
    for motion, name in (("reduce", "Play"), ("no-preference", "Pause")):
        stage = Stage(browser, page_file, motion)
        assert stage.button(name).count() == 1
        stage.context.close()


def test_another_mode_another_motion_and_an_opaque_body_are_other_pictures(stage: Stage) -> None:
    pictures = [stage.picture()]
    stage.view.get_by_role("combobox", name="Mode", exact=True).select_option(index=1)
    pictures.append(stage.picture())
    assert "mode 2: 225.6 Hz" in stage.canvas.get_attribute("aria-label")
    stage.view.get_by_role("slider").fill("2")
    pictures.append(stage.picture())
    assert stage.button("See through").get_attribute("aria-pressed") == "true"
    stage.button("See through").click()
    assert stage.button("See through").get_attribute("aria-pressed") == "false"
    pictures.append(stage.picture())
    assert len(set(pictures)) == 4


def test_the_theme_of_the_page_is_followed(stage: Stage) -> None:
    before = stage.picture()
    stage.page.evaluate("document.documentElement.dataset.theme = 'dark'")
    assert stage.picture() != before
    stage.page.evaluate("document.documentElement.dataset.theme = 'light'")
    assert stage.picture() == before


def test_all_controls_have_names_and_the_picture_can_be_reached_by_keyboard_and_shows_it(stage: Stage) -> None:
    assert stage.canvas.get_attribute("role") == "img"
    assert stage.canvas.get_attribute("aria-label").startswith("Rotor, mode 1: 185.4 Hz.")
    names = stage.view.locator("button").evaluate_all("all => all.map(b => b.ariaLabel || b.textContent)")
    assert names == ["Play", "See through", "Zoom out", "Zoom in", "Reset the view"]
    for _ in range(8):
        stage.page.keyboard.press("Tab")
        if stage.canvas.evaluate("canvas => canvas === document.activeElement"):
            break
    assert stage.canvas.evaluate("canvas => getComputedStyle(canvas).outlineStyle") == "solid"


def test_the_still_picture_stands_in_on_paper_and_without_scripts(browser: Any, page_file: Path, stage: Stage) -> None:
    still = stage.view.locator("img")
    assert not still.is_visible()
    stage.page.emulate_media(media="print")
    assert still.is_visible()
    assert not stage.canvas.is_visible()
    plain = Stage(browser, page_file, java_script_enabled=False)
    assert plain.view.locator("img").is_visible()
    assert plain.view.locator("button").count() == 0
    plain.context.close()


def test_a_narrow_page_does_not_scroll_sideways(stage: Stage) -> None:
    stage.page.set_viewport_size({"width": 320, "height": 700})
    stage.picture()
    assert stage.page.evaluate("document.scrollingElement.scrollWidth") <= 320
