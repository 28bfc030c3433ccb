"""Each figure shows the numbers that it was given, in the units that its axes name, and the names beside them."""

from functools import cache

import numpy as np
import pytest

import rbfound as rb
from rbfound import theory
from rbfound.identification import circle_fit, fit_residues, stabilisation, stable_poles
from rbfound.measurement import hammer, mode_indicator
from rbfound.thesis import bearings, foundation, rotor

plt = pytest.importorskip("matplotlib.pyplot", reason="figures need matplotlib: pip install 'rbfound[plots]'")
plots = rb.plots

LINES = np.arange(20.0, 501.0, 1.0)
X = np.linspace(1.0, 2.0, 5)
Z = (1 + X) * np.exp(1j * X)  # an answer with a size and a phase
SPEEDS = rb.from_rpm(np.linspace(0.0, 9000.0, 7))


@cache
def frf():
    # four modes far from each other, each largest at another seat
    shapes = 0.1 * (np.eye(4) + 0.3 * np.ones((4, 4)))
    return rb.modal_foundation(shapes, 2 * np.pi * np.array([120, 200, 290, 380]), [0.02] * 4).frf(LINES)


@cache
def machine():
    return rb.mount(rotor(), bearings(), on=foundation())


@cache
def modes():
    return machine().at(0.0).modes().above(1.0)


@cache
def diagram():
    return rb.campbell(machine(), SPEEDS, count=6)


@cache
def chart():
    return stabilisation(frf(), range(2, 8))


@cache
def blows():
    return hammer(foundation(), rb.measurement.Sensors(), block=1.0, averages=1, seed=1)


@cache
def fit():
    return circle_fit(LINES, frf().H[:, 0, 0], near=120)


def own(curves):
    """The branches of a Campbell diagram, as they are drawn."""
    return [(rb.rpm(curves.speeds), branch) for branch in curves.frequency.T]


def sizes(f, H):
    return [(f, np.abs(h)) for h in np.reshape(H, (len(f), -1)).T]


def poles_on(poles):
    return rb.hertz(np.abs(poles)), -100 * poles.real / np.abs(poles)


# Of each figure: what it is called with, curves (x, y) that it must have, and words that must stand in it.
FIGURES = {
    "receptances": lambda: ([{"a": (X, Z)}], {}, [(X, abs(Z)), (X, np.degrees(np.angle(Z)))], ["a"]),
    "driving_point_set": lambda: ([frf(), "y1"], {}, sizes(LINES, frf().H[:, :, 1]), ["x2 from y1"]),
    "frf_matrix": lambda: ([{"one": frf()}], {}, sizes(LINES, frf().H), ["y2 from x1", "one"]),
    "frf_kinds": lambda: ([frf()], {}, sizes(LINES, frf().H), ["x1 from y1", "direct"]),
    "half_power": lambda: (
        [X, abs(Z), {"a": theory.Peak(frequency=1.5, height=2.0, low=1.2, high=1.8)}],
        {},
        [(X, abs(Z)), ([1.2, 1.8], [2 / np.sqrt(2)] * 2), ([1.5], [2.0])],
        ["a"],
    ),
    "circle": lambda: ([{"a": Z}], {}, [(Z.real, Z.imag)], ["a"]),
    "over_time": lambda: ([X, {"a": Z.real}], {}, [(X, Z.real)], ["a"]),
    "indicator": lambda: (
        [frf(), rb.pick_peaks(frf(), near=[120])],
        {},
        [(LINES, mode_indicator(frf())[:, 0])],
        ["singular value 1", f"{rb.pick_peaks(frf(), near=[120]).frequency[0]:.0f}"],
    ),
    "matrices": lambda: ([foundation()], {}, [], [f"{foundation().M[0, 0]:.3g}", "y2"]),
    "campbell": lambda: ([diagram()], {}, [*own(diagram()), (rb.rpm(SPEEDS), rb.hertz(SPEEDS))], ["speed of rotation"]),
    "campbells": lambda: ([{"one": diagram(), "two": diagram()}], {}, own(diagram()), ["one", "two"]),
    "campbell_bands": lambda: (
        [
            diagram(),
            rb.identification.ErrorBars(diagram().poles, 0.1 * np.abs(diagram().poles), 0 * diagram().frequency),
        ],
        {"magnified": 3},
        own(diagram()),
        ["two deviations, 3 times"],
    ),
    "errors_in_bars": lambda: ([[10, 20], [[1.0, -3.0]]], {}, [([0], [1.0]), ([1], [-3.0])], ["10", "20"]),
    "beside_reference": lambda: ([X, Z, {"a": 1.1 * Z}], {}, [(X, abs(Z)), (X, 1.1 * abs(Z)), (X, 10 + 0 * X)], ["a"]),
    "passivity": lambda: ([X, {"a": Z.real}], {}, [(X, 100 * Z.real)], ["a"]),
    "price": lambda: ([["a", "b"], [0.0, 2.0], [1.0, 3.0]], {}, [([1.0, 3.0], [0.01, 2.0])], ["a", "b"]),
    "parts": lambda: (
        [LINES, frf().H[:, 0, 0], fit()],
        {},
        [([fit().natural_frequency] * 2, [0, 1])],
        ["fitted circle", "half-power points"],
    ),
    "nyquist": lambda: ([LINES, frf().H[:, 0, 0], fit()], {}, [([0], [0])], [f"{rb.hertz(fit().omega):.1f} Hz"]),
    "stabilisation_chart": lambda: (
        [chart(), frf(), stable_poles(chart())[0]],
        {},
        [
            (LINES, mode_indicator(frf())[:, 0]),
            (chart().natural_frequency[chart().stable], chart().order[chart().stable]),
        ],
        ["all three"],
    ),
    "polynomials": lambda: ([X, {"a": [0 * X + 2, 4j * X]}], {}, [(X, 0 * X + 1), (X, X / 2)], ["a", "0", "1"]),
    "conditions": lambda: ([[1, 2], {"a": [1e3, 1e6]}], {}, [([1, 2], [1e3, 1e6])], ["a"]),
    "pole_map": lambda: (
        [modes().poles, {"a": modes().poles[:1]}, (0, 1e6)],
        {"heaviest": 99.0},
        [poles_on(modes().poles), poles_on(modes().poles[:1])],
        ["reference", "a"],
    ),
    "residual_parts": lambda: (
        [fit_residues(frf(), stable_poles(chart())[0]), frf(), "x1", "x2"],
        {},
        [(LINES, abs(frf().H[:, 0, 2]))],
        ["modes in the band", "|H|, x1 from x2  [m/N]"],
    ),
    "ladder": lambda: ([{"a": ([100.0, 2000.0], [0.1, 0.9])}], {}, [([-0.38, 0.38], [100, 100])], ["a"]),
    "rotor": lambda: ([rotor(), bearings()], {}, [([1e3 * z], None) for z in bearings()], ["10 kg"]),
    "rotors": lambda: ([{"a": (rotor(), bearings())}], {}, [([1e3 * z], [-75]) for z in bearings()], ["a"]),
    "mode_shapes": lambda: (
        [machine(), modes()],
        {"which": [1]},
        [(machine().mesh.z, None), (list(bearings()), None)],
        [f"{modes().frequency[1]:.1f} Hz, damping {100 * modes().damping[1]:.2f} %"],
    ),
    "spread": lambda: ([[[100.0, 200.0]], {"a": [150.0]}], {}, [([150, 150], [0, 1])], ["a", "1 roundings"]),
    "unbalance": lambda: ([{"a": (SPEEDS[:5], Z)}], {}, [(rb.rpm(SPEEDS[:5]), 1e6 * abs(Z))], ["a"]),
    "overview": lambda: (
        [frf(), foundation(), rotor(), bearings(), diagram()],
        {},
        [*sizes(LINES, np.diagonal(frf().H, axis1=1, axis2=2)), *own(diagram())],
        ["10 kg", f"{foundation().K[0, 0] / 1e6:.3g}"],
    ),
    "rigid_on_supports": lambda: (
        [theory.RigidRotor(mass=1.0, Id=0.1, Ip=0.05, a=0.4, b=0.2, bearings=tuple(bearings().values()))],
        {},
        [([-0.5, 0.25], [0, 0])],
        ["a", "b", "$k_{x1}$"],
    ),
    "orbits": lambda: ([{"one": {"a": (1.0, -1j)}}], {"scale": 2.0}, [([2.0], [0.0])], ["one", "a"]),
    "amplitude_and_phase": lambda: (
        [{"a": (X, Z)}],
        {"ylabel": "size", "marks": {"here": 1.5}},
        [(X, abs(Z)), (X, np.degrees(X)), ([1.5, 1.5], [0, 1])],
        ["a", "size", "here"],
    ),
    "over_speed": lambda: (
        [{"a": (SPEEDS[:5], Z)}],
        {"ylabel": "force", "marks": {"here": SPEEDS[1]}},
        [(rb.rpm(SPEEDS[:5]), abs(Z)), ([rb.rpm(SPEEDS[1])] * 2, [0, 1])],
        ["a", "force", "here"],
    ),
    "directions": lambda: (
        [["p", "q"], [1.0, 0.1], np.array([[0.0, -1.0], [0.5, 0.1]])],
        {},
        [],
        ["p", "+1.0", "+0.5"],
    ),
    "blow": lambda: ([blows(), "y1"], {}, [(blows().time, blows().response[1, 1, 0])], ["the hammer at y1"]),
    "coherences": lambda: (
        [{"a": (X, Z, X / 2)}],
        {"low": 1.2},
        [(X[1:], abs(Z[1:])), (X[1:], X[1:] / 2)],
        ["a"],
    ),
    "checked": lambda: (
        [frf(), rb.check(frf())],
        {},
        [(LINES, mode_indicator(frf())[:, 0])],
        [f"{f:.0f}" for f in rb.check(frf()).peaks],
    ),
    "section": lambda: ([np.array([[0, 1, 1, 0], [0, 0, 1, 1.0]]), np.arange(4)[:, None]], {}, [], ["z [mm]"]),
    "centre_lines": lambda: ([{"one": (X, [10.0], Z.real[:, None])}], {}, [(X, Z.real)], ["one", "10 Hz"]),
    "moved": lambda: ([[1.0], [3.0], [(1.0, 3.0)], ["k", "l"]], {}, [([-0.3, 0.3], [1, 1])], ["k", "1 → 3"]),
    "cost": lambda: ([[100, 200], [1.0, 2.0], [0.5, 0.1], ["a", "b"]], {}, [([100, 200], [1, 2])], ["a: 0.5 %"]),
    "growth": lambda: ([{"a": {10: 1.0, 100: 100.0}}, "size"], {}, [([10, 100], [1, 100])], ["a: slope 2.0", "size"]),
    "winding": lambda: (
        [1 + 1j * X, np.exp(1j * X), [1 + 1j]],
        {},
        [(rb.hertz(1 + 0 * X), rb.hertz(X)), (np.arange(5), (X - 1) / np.pi)],
        ["poles"],
    ),
    "guesses": lambda: ([{"a": [0.0, 0.1]}], {}, [([1, 2], [1e-16, 0.1])], ["a"]),
    "lines_where_needed": lambda: ([X, Z], {}, [(X, abs(Z))], ["5 lines"]),
    "chain_drawing": lambda: ([["m"], ["1", ""]], {}, [([0, 0], None)], ["m", "$k_1$", "$c_1$"]),
    "chain_shapes": lambda: (
        [[[0.5, 0], [1.0, 0]], np.column_stack([Z.real, Z.imag]), [20 * np.pi, 1]],
        {"count": 2},
        [(np.arange(4), [0, 0.5, 1.0, 0]), (np.linspace(0, 3, 5), Z.real)],
        ["mode 1, 10.0 Hz"],
    ),
    "errors": lambda: (
        [X, {"a": [0.0, 0.1, 0.2, 0.3, 0.4]}],
        {"xlabel": "x", "marks": [1.5], "floor": 1.0},
        [(X, [1, 10, 20, 30, 40]), ([1.5, 1.5], [0, 1])],
        ["a", "x"],
    ),
    "errors_for_seconds": lambda: (
        [{"one": {"a": ([7, 8], [1.0, 2.0], [0.1, 0.01])}}],
        {},
        [([1, 2], [10, 1])],
        ["one", "7"],
    ),
    "contributions": lambda: (
        [X, np.outer(Z, np.ones(6)), 20 * np.pi * np.arange(1, 7)],
        {},
        [(X, abs(6 * Z)), (X, abs(Z)), (X, abs(2 * Z))],
        ["mode 4, 40 Hz"],
    ),
    "zeros_and_poles": lambda: ([X, {"a": (Z, [1.5, 9.0])}, [1.2]], {}, [(X, abs(Z)), ([1.5], None)], ["a"]),
    "phasors": lambda: ([{"a": np.array([2.0, 1j])}], {}, [([0, 1], [0, 0]), ([0, 0], [0, 0.5])], ["a", "mass 2"]),
}


def drawn(figure):
    """All curves of a figure, and all that is written in it."""
    curves = [np.asarray(line.get_data(), dtype=float) for ax in figure.axes for line in ax.get_lines()]
    figure.canvas.draw()
    words = {text.get_text() for text in figure.findobj(plt.Text)}
    return curves, words


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_shows_the_numbers_that_it_was_given(name, monkeypatch):
    monkeypatch.setattr(plt, "show", lambda: None)
    args, kwargs, wanted, said = FIGURES[name]()
    getattr(plots, name)(*args, **kwargs)
    curves, words = drawn(plt.gcf())
    plt.close("all")
    assert wanted or said
    for x, y in wanted:
        like = [c for c in curves if len(c[0]) >= len(x) and np.allclose(c[0][: len(x)], x)]
        assert any(y is None or np.allclose(c[1][: len(x)], y) for c in like), (x, y)
    for word in said:
        assert any(word == text for text in words), f"{word} is not among {sorted(words)}"


def test_each_figure_of_the_room_has_its_case_here():
    bodies = {"VIEW", "STYLE", "Body", "body", "body_on", "rotor_body", "solid_body", "turnable", "page", "styled"}
    colours = {name for name in plots.__all__ if isinstance(getattr(plots, name), str)}
    assert set(FIGURES) == set(plots.__all__) - bodies - colours


def test_a_body_is_drawn_with_its_nearest_face_last(monkeypatch):
    monkeypatch.setattr(plt, "show", lambda: None)
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0], [0, 2, 0], [0, 1, 0.0]])
    towards = plots.VIEW[2]
    plots.body(np.vstack([points + towards, points]), np.arange(16).reshape(2, 8))
    (collection,) = plt.gcf().axes[0].collections
    plt.close("all")
    first, last = (path.vertices[:-1] for path in collection.get_paths())
    np.testing.assert_allclose(first, points @ plots.VIEW[:2].T)
    np.testing.assert_allclose(last, (points + towards) @ plots.VIEW[:2].T)
    assert len(collection.get_facecolors()) == 2


def test_the_report_page_has_its_figures_within_and_the_words_of_check():
    report = rb.check(frf())
    page = plots.page(frf(), report, foundation())
    assert page.count('src="data:image/png;base64,') == 3
    assert 'src="http' not in page
    assert str(report).splitlines()[0] in page
