"""What can be played with in a page, asked as a page would ask it."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from written import table, universal

import rbfound as rb
from rbfound import live, thesis
from rbfound.frf import SEATS
from rbfound.live import figure, line
from rbfound.live.frontend import answer, scene
from rbfound.live.sketch import slider

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "data" / "foundation"


def result(name: str, **settings: Any) -> Any:
    thing = live.start(name, DATA)
    settings = {**thing.values["settings"], **settings}
    told = thing.update({"settings": settings, "stamp": 7})["result"]
    assert told["stamp"] == 7
    return told


def numbers(told: Any, caption: str, column: str) -> list[float]:
    (table,) = [table for table in told["tables"] if table["caption"].startswith(caption)]
    return [float(text) for text in table["columns"][column] if text != "-"]


def curve(told: Any, title: str, label: str) -> tuple[np.ndarray, np.ndarray]:
    (lines,) = [f["lines"] for f in told["figures"] if f["title"].startswith(title)]
    (found,) = [one for one in lines if one["label"] == label]
    return found["x"], found["y"]


@pytest.mark.parametrize("name", live.THINGS)
def test_what_a_thing_begins_with_can_be_sent_to_a_page_and_comes_back(name: str) -> None:
    values = live.start(name, DATA).values
    text, buffers = live.packed(values)

    def put_back(value: dict[str, Any]) -> Any:
        return buffers[value["buffer"]] if list(value) == ["buffer"] else value

    back = json.loads(text, object_hook=put_back)
    assert set(back) == set(values)
    if name != "peak_picker":
        for sent, got in zip(values["result"]["figures"], back["result"]["figures"], strict=True):
            for one, other in zip(sent["lines"], got["lines"], strict=True):
                np.testing.assert_array_equal(one["y"], other["y"])


def test_what_json_cannot_hold_is_refused() -> None:
    with pytest.raises(TypeError, match="set cannot be sent"):
        live.packed({"a": {1, 2}})
    with pytest.raises(ValueError, match="JSON"):
        live.packed({"a": float("nan")})


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match=r"'oscilator'.*oscillator, campbell"):
        live.start("oscilator", DATA)
    with pytest.raises(ValueError, match="oscillator takes no files: peak_picker does"):
        live.opened("oscillator", DATA)


def test_figures_and_sliders_refuse_what_cannot_be_drawn() -> None:
    with pytest.raises(ValueError, match=r"shape \(2,\), y \(3,\)"):
        line("a", [1, 2], [1, 2, 3])
    with pytest.raises(ValueError, match="5 does not lie between 1 and 2"):
        slider("m", "mass", "kg", 1, 2, 5)
    assert figure("f", {}, {}, [], [{"x": np.nan, "y": 1.0}])["marks"] == []


# the half-power reading takes the peak for the natural frequency: an error of the order of zeta^2
@pytest.mark.parametrize("c", [200.0, 870.0, 4000.0])
def test_the_oscillators_damping_is_read_back_from_its_half_power_points(c: float) -> None:
    told = result("oscillator", c=c)
    omega, zeta = rb.theory.sdof.natural(23.0, c, 20.6e6)
    rows = told["tables"][0]["columns"]
    read = dict(zip(rows[""], rows[" "], strict=True))
    assert float(read["natural frequency [Hz]"]) == pytest.approx(rb.hertz(omega), rel=5e-4)
    assert float(read["ζ from them [%]"]) == pytest.approx(100 * zeta, rel=5e-4 + 3 * zeta**2)


def test_the_oscillators_circle_is_its_receptance_and_is_round() -> None:
    told = result("oscillator", m=30.0)
    real, imag = curve(told, "Circle", "")
    f, size = curve(told, "Magnitude", "")
    np.testing.assert_allclose(1e-6 * np.hypot(real, imag), size, rtol=1e-12)
    np.testing.assert_allclose(size, np.abs(rb.theory.sdof.receptance(f, 30.0, 870.0, 20.6e6)), rtol=1e-12)
    # no corner: the pieces of the circle are short beside its diameter
    assert np.hypot(np.diff(real), np.diff(imag)).max() < 0.06 * np.ptp(imag)


def test_a_peak_beyond_the_band_or_none_at_all_is_told_as_a_dash() -> None:
    for settings in ({"m": 5.0, "k": 1e8}, {"c": 20000.0, "k": 1e6, "m": 5.0}):
        told = result("oscillator", **settings)
        assert "-" in told["tables"][0]["columns"][" "]


def test_forward_whirl_is_red_and_backward_blue_as_in_the_figures_of_the_book() -> None:
    sheet = live.sheet(live.front("campbell"))
    colours = {int(k): bytes.fromhex(c) for k, c in re.findall(r"--style(\d): #([0-9a-f]{6})", sheet.split("}")[0])}
    lines = {line["label"]: line["style"] for line in result("campbell")["figures"][0]["lines"]}
    red, _, blue = colours[lines["forward whirl"]]
    assert red > 2 * blue
    red, _, blue = colours[lines["backward whirl"]]
    assert blue > 2 * red


@pytest.mark.parametrize("flexible", [False, True])
def test_campbell_shows_the_frequencies_and_critical_speeds_of_the_whole_machine(flexible: bool) -> None:
    told = result("campbell", k=5e7, c=5e3, speed=12000.0, foundation=flexible)
    seats = {z: rb.Bearing(kxx=5e7, kyy=5e7, cxx=5e3, cyy=5e3) for z in thesis.bearings()}
    truth = rb.load_foundation(DATA / "truth.npz")
    machine = rb.mount(thesis.rotor(), seats, on=truth if flexible else None)
    modes = machine.at(float(rb.from_rpm(12000.0))).modes().above(1.0).below(600.0)
    found = numbers(told, "At 12000 rev/min", "frequency [Hz]")[: len(modes.poles)]
    # four digits are printed
    np.testing.assert_allclose(found, modes.frequency, rtol=6e-4)
    damping = numbers(told, "At 12000 rev/min", "damping [%]")[: len(modes.poles)]
    np.testing.assert_allclose(damping, 100 * modes.damping, rtol=2e-3)
    if not flexible:
        return
    critical = rb.campbell(machine, rb.from_rpm(np.linspace(0, 30000, 11)), count=12).critical_speeds()
    np.testing.assert_allclose(numbers(told, "Critical", "speed [rev/min]"), rb.rpm(critical.speed), rtol=6e-4)


def test_the_unbalance_response_is_that_of_the_whole_machine() -> None:
    told = result("unbalance")
    machine = rb.mount(thesis.rotor(), thesis.bearings(), on=rb.load_foundation(DATA / "truth.npz"))
    speeds, x = curve(told, "Tip", "x")
    expected = rb.unbalance_response(machine, rb.from_rpm(speeds[::20]), {1.0: 1e-3})
    np.testing.assert_allclose(1e-6 * x[::20], np.abs(expected[:, machine.coordinate(1.0, "x")]), rtol=1e-4)


def test_with_all_modes_held_the_foundation_still_yields_a_little_and_no_more() -> None:
    names = [c["name"] for c in live.start("unbalance", DATA).values["controls"] if c["kind"] == "switch"]
    told = result("unbalance", **dict.fromkeys(names, False))
    ground, held = (curve(told, "Tip", name)[1] for name in ("rigid ground", "x"))
    free = curve(result("unbalance"), "Tip", "x")[1]
    assert np.abs(held[:60] / ground[:60] - 1).max() < 0.3 * np.abs(free[:60] / ground[:60] - 1).max()


def test_modes_of_the_rest_can_only_make_a_reduction_better() -> None:
    errors = []
    for modes in (0, 2, 4, 8):
        told = result("reduction", masters="tip", modes=modes)
        errors.append(numbers(told, "Undamped", "error [%]")[:3])
    # Rayleigh: a subspace gives frequencies that are too high, a larger one lower ones
    assert np.min(errors) > -1e-9
    assert np.all(np.diff(errors, axis=0) <= 1e-9)


def test_guyan_is_exact_at_standstill_and_more_masters_are_better() -> None:
    ends = []
    for masters in ("bearings", "tip", "fourth", "second"):
        f, error = curve(result("reduction", masters=masters, modes=0), "Error", "reduced")
        ends.append(error[f < 500].max())
    assert ends == sorted(ends, reverse=True)
    f, error = curve(result("reduction", masters="tip", modes=0), "Error", "reduced")
    # stiffness and inertia felt at the masters are exact, what is left grows with the fourth power of the frequency
    assert error[1] / error[0] == pytest.approx((f[1] / f[0]) ** 4, rel=0.05)


def test_the_whole_receptance_of_the_reduction_is_that_of_the_machine() -> None:
    f, whole = curve(result("reduction"), "Receptance", "whole")
    machine = thesis.model("c")
    row = np.eye(len(machine.M))[[machine.coordinate(1.0, "x")]]
    expected = machine.at(0.0).receptance(f[::30], row, row.T)[:, 0, 0]
    np.testing.assert_allclose(whole[::30], np.abs(expected), rtol=1e-8)


def test_the_picker_answers_as_in_a_notebook_and_gives_its_foundation_away(tmp_path: Path) -> None:
    thing = live.start("peak_picker", DATA)
    assert thing.values["result"]["message"] == ""
    peaks = [{"seat": seat, "frequency": f} for seat, f in zip(SEATS, (160, 480, 626, 344), strict=True)]
    told = thing.update({"peaks": peaks, "method": "pmsm", "stamp": 3})["result"]
    assert told["stamp"] == 3
    frf = rb.load_frf(DATA / "fine")
    np.testing.assert_allclose(told["Phi"], answer(live.bench_of(frf), peaks, "pmsm")[1]["Phi"], rtol=1e-12)
    (tmp_path / "foundation.npz").write_bytes(thing.saves["foundation.npz"]())
    back = rb.load_foundation(tmp_path / "foundation.npz")
    np.testing.assert_allclose(back.M, told["matrices"]["M"], rtol=1e-12)
    text = thing.saves["foundation.txt"]().decode()
    table = np.loadtxt(text.splitlines())
    np.testing.assert_array_equal(table, np.vstack([back.M, back.C, back.K, back.B]))
    heading, *rows = thing.saves["peaks.csv"]().decode().splitlines()
    assert heading == "seat,frequency [Hz],damping ratio"
    assert [row.split(",")[0] for row in rows] == list(SEATS)
    read = [[float(value) for value in row.split(",")[1:]] for row in rows]
    assert read == [[peak["frequency"], peak["damping"]] for peak in told["peaks"]]
    thing.update({"peaks": peaks[:2], "method": "pmsm", "stamp": 4})
    with pytest.raises(ValueError, match="give no foundation"):
        thing.saves["foundation.npz"]()


@pytest.mark.slow
def test_a_readers_own_files_are_identified(tmp_path: Path) -> None:
    shutil.copytree(DATA / "medium", tmp_path / "own")
    values = live.opened("peak_picker", tmp_path / "own").values
    assert values["method"] == "identify"
    assert values["result"]["message"] == ""
    assert not values["scene"]["rotor"]
    found = [peak["frequency"] for peak in values["result"]["peaks"]]
    assert min(abs(f / 159.7 - 1) for f in found) < 1e-2


@pytest.mark.slow
def test_one_table_of_a_reader_is_identified_too(tmp_path: Path) -> None:
    table(tmp_path / "measured.csv", rb.load_frf(DATA / "medium"))
    found = [peak["frequency"] for peak in live.opened("peak_picker", tmp_path).values["result"]["peaks"]]
    assert min(abs(f / 159.7 - 1) for f in found) < 1e-2


def test_a_unit_that_a_file_does_not_say_can_be_given(tmp_path: Path) -> None:
    frf = rb.load_frf(DATA / "fine").between(100, 400)
    universal(tmp_path / "rig.uff", rb.FRF(frf.frequency, 1e3 * frf.H, frf.labels), unit=("NONE", "NONE"))
    # in the words of the page, which has a field where Python has an argument
    with pytest.raises(ValueError, match=r'does not say in which unit.*the field "Unit" ') as error:
        live.opened("peak_picker", tmp_path, columns="")
    assert "unit=" not in str(error.value)
    said = np.frombuffer(live.opened("peak_picker", tmp_path, unit="mm/N").values["data"], "<f4")
    parts = frf.H.transpose(1, 2, 0).ravel()
    np.testing.assert_allclose(said[len(frf.frequency) :].view("<c8"), parts, rtol=1e-6)


def test_a_missing_frf_is_taken_from_its_mirror_where_the_page_is_told_so(tmp_path: Path) -> None:
    shutil.copytree(DATA / "coarse", tmp_path / "own")
    (lost,) = (tmp_path / "own").glob("*x1_from_y1*")
    lost.unlink()
    with pytest.raises(ValueError, match='The box "A missing FRF from its mirror" takes H_ij for a missing H_ji'):
        live.opened("peak_picker", tmp_path / "own")
    filled = live.opened("peak_picker", tmp_path / "own", fill=True).values["scene"]
    assert filled["labels"] == list(SEATS)


def test_what_is_wrong_with_a_readers_files_is_said_beside_what_was_made_of_them() -> None:
    frf = rb.load_frf(DATA / "medium")
    sound = live.bench_of(frf)
    assert scene(sound)[0]["findings"] == list(rb.check(frf).warnings)
    # the seats' own stiffness, where a wrong unit shows
    assert f"{1 / np.abs(frf.H[0, 1, 1]):.3g} N/m" in scene(sound)[0]["size"]
    flipped = live.bench_of(rb.FRF(frf.frequency, frf.H * np.array([[1], [-1], [1], [1]]), frf.labels))
    assert any("driving point at y1 gives energy away" in warning for warning in scene(flipped)[0]["findings"])


def test_files_that_are_no_frfs_are_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "measured.csv").write_text("1,2,3\n")
    with pytest.raises(ValueError, match=r"measured\.csv"):
        live.opened("peak_picker", tmp_path)


def test_all_that_the_page_asks_the_room_for_is_on_its_face() -> None:
    worker = (ROOT / "book" / "_ext" / "live_worker.js").read_text(encoding="utf-8")
    asked = set(re.findall(r"\blive\.(\w+)", worker))
    assert "start" in asked
    assert asked <= set(live.__all__)
