"""Peaks that are moved: what follows from them, what a front end is told, and what does not follow."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

import rbfound as rb
from rbfound import thesis
from rbfound.live import bench_of
from rbfound.live.bench import Bench, thinned
from rbfound.live.frontend import answer, paired, scene
from rbfound.live.picking import first_picks, picked, picks_of
from rbfound.machine import couple
from rbfound.theory import reduced_rotor

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"
# The chapter on PMSM: one X and one Y mode read twice, and four distinct modes.
TWICE, DISTINCT = [160.0, 344.0, 160.0, 344.0], [160.0, 480.0, 626.0, 344.0]


@pytest.fixture(scope="module")
def truth() -> rb.Foundation:
    return rb.load_foundation(DATA / "truth.npz")


@pytest.fixture(scope="module")
def bench(truth: rb.Foundation) -> Bench:
    return bench_of(rb.load_frf(DATA / "fine"), thesis.rotor(), thesis.bearings(), truth)


@pytest.fixture(scope="module")
def coarse() -> Bench:
    return bench_of(rb.load_frf(DATA / "coarse"), thesis.rotor(), thesis.bearings())


def machine(foundation: rb.Foundation, top: float) -> np.ndarray:
    """The road without a reduced rotor."""
    return rb.mount(thesis.rotor(), thesis.bearings(), on=foundation).at(0.0).modes().above(1.0).below(top).frequency


def test_the_reduced_rotor_gives_the_frequencies_of_the_whole_one(bench: Bench, truth: rb.Foundation) -> None:
    # what is left out lies above the band, and its first two terms are kept: 1e-6 is a hundred times what is found
    assert bench.journals is not None
    assert len(bench.journals.M) <= 20
    np.testing.assert_allclose(bench.true_frequencies[1], machine(truth, 1000.0), rtol=1e-6)
    for peaks in (TWICE, DISTINCT):
        found = picked(bench, peaks)
        np.testing.assert_allclose(found.under, machine(found.foundation, 1000.0), rtol=1e-6)
        np.testing.assert_allclose(found.alone, found.foundation.modes().frequency, rtol=1e-12)


def test_the_higher_the_limit_of_the_reduced_rotor_the_smaller_its_error(truth: rb.Foundation) -> None:
    whole, places = machine(truth, 1000.0), sorted(thesis.bearings())
    errors = []
    for limit in (500.0, 1000.0, 4000.0):
        journals = reduced_rotor(thesis.rotor(), places, limit, blocks=2).body
        modes = couple(journals, list(thesis.bearings().values()), truth).modes()
        errors.append(np.abs(modes.above(1.0).below(1000.0).frequency / whole - 1).max())
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-9


@pytest.mark.parametrize("peaks", [TWICE, DISTINCT])
def test_the_picker_does_what_pmsm_does_with_the_same_peaks(bench: Bench, peaks: list[float]) -> None:
    found = picked(bench, peaks)
    same = rb.pmsm(bench.frf, rb.Peaks(found.peaks.frequency, found.peaks.damping))
    for name in "MCK":
        np.testing.assert_array_equal(getattr(found.foundation, name), getattr(same, name))
    # left to itself pmsm goes to the maximum next to each frequency and reads the same damping there
    modes = rb.identification.pseudo_modes(bench.frf, peaks)
    np.testing.assert_allclose(found.peaks.damping, modes.zeta, rtol=1e-12)
    np.testing.assert_array_equal(found.peaks.frequency, peaks)


def test_the_first_peaks_are_those_of_the_chapter(bench: Bench) -> None:
    for method, near in (("pmsm", TWICE), ("distinct", DISTINCT)):
        found = picked(bench, first_picks(bench, method), method)
        modes = rb.identification.pseudo_modes(bench.frf, near)
        np.testing.assert_allclose(found.peaks.frequency, rb.hertz(modes.omega), rtol=1e-12)
        np.testing.assert_allclose(found.Phi, modes.Phi, rtol=1e-9)
    assert first_picks(bench, "distinct")[0]["damping"] is None


def test_distinct_modes_go_to_the_seats_that_see_them_best_whatever_their_order(bench: Bench) -> None:
    frequencies = [344.0, 626.0, 160.0, 480.0]
    picks = [{"seat": "x1", "frequency": f} for f in frequencies]
    found = picked(bench, picks, "distinct")
    lines = [int(np.abs(bench.frf.frequency - f).argmin()) for f in frequencies]
    seen = np.log(-np.einsum("nii->ni", bench.frf.H[lines]).imag)
    _, seats = linear_sum_assignment(-seen)
    assert found.order == tuple(np.argsort(seats))
    np.testing.assert_array_equal(found.peaks.frequency, [160.0, 480.0, 626.0, 344.0])
    turned = picked(bench, picks[::-1], "distinct")
    np.testing.assert_array_equal(turned.Phi, found.Phi)


def many_seats(count: int) -> tuple[Bench, np.ndarray]:
    """FRFs of a foundation whose modes each move mainly one seat, and which seat that is, by frequency."""
    order = np.random.default_rng(count).permutation(count)
    Phi = 0.05 * np.ones((count, count))
    Phi[order, np.arange(count)] = 1.0
    labels = tuple(f"{axis}{k + 1}" for k in range(count // 2) for axis in "xy")
    omega, zeta = rb.from_hertz(100 + 40 * np.arange(count)), np.full(count, 0.01)
    foundation = rb.foundation.modal_foundation(Phi, omega, zeta, labels)
    return bench_of(foundation.frf(np.arange(60.0, 140 + 40 * count, 0.5))), order


@pytest.mark.parametrize("count", [10, 16])
def test_of_many_seats_each_has_the_mode_that_moves_it_in_the_order_of_the_frequencies(count: int) -> None:
    # there are 16! = 2e13 assignments: nothing that tries them all comes to an end
    many, order = many_seats(count)
    picks = [{"seat": "x1", "frequency": f} for f in 100 + 40.0 * np.arange(count)]
    assert picked(many, picks, "distinct").order == tuple(np.argsort(order))


@pytest.mark.parametrize("count", [4, 10])
def test_equally_good_seats_are_chosen_alike_whatever_rounding_does(count: int) -> None:
    # every seat sees every peak alike: rounding alone would choose
    rng, frequency = np.random.default_rng(1), np.arange(60.0, 140.0, 0.5)
    labels = tuple(f"{axis}{k + 1}" for k in range(count // 2) for axis in "xy")
    H = np.tile(-1j * 1e-7 * (np.eye(count) + 0.5), (len(frequency), 1, 1))
    picks = [{"seat": "x1", "frequency": f, "damping": 0.01} for f in 70.0 + np.arange(count)[::-1]]
    for _ in range(20):
        noisy = H * (1 + 1e-13 * rng.standard_normal(H.shape))
        alike = bench_of(rb.FRF(frequency, noisy, labels))
        assert picked(alike, picks, "distinct").order == tuple(range(count))[::-1]


def test_a_peak_stays_where_it_is_put_and_keeps_the_damping_that_it_is_given(bench: Bench) -> None:
    picks = picks_of(bench, TWICE)
    picks[1] = {"seat": "y1", "frequency": 300.0, "damping": 0.05}
    found = picked(bench, picks)
    assert found.peaks.frequency[1] == 300.0
    assert found.peaks.damping[1] == 0.05
    picks[1]["damping"] = None
    # 279 Hz is the nearest maximum of y1
    near = rb.identification.pseudo_modes(bench.frf, [160, 279, 160, 344])
    assert picked(bench, picks).peaks.damping[1] == pytest.approx(near.zeta[1], rel=1e-12)


def test_identify_in_the_picker_is_identify(coarse: Bench) -> None:
    found, same = picked(coarse, [], "identify"), rb.identify(coarse.frf)
    np.testing.assert_allclose(found.foundation.K, same.K, rtol=1e-9)
    np.testing.assert_allclose(found.foundation.B, same.B, rtol=1e-6, atol=1e-9)
    assert ((found.peaks.frequency > 25) & (found.peaks.frequency < 500)).all()
    assert found.Phi.shape == (4, len(found.peaks))


def test_modes_of_the_band_are_listed_and_residual_modes_are_not_among_them(coarse: Bench) -> None:
    found, told, _ = answer(coarse, [], "identify")
    assert found is not None
    fit, said = coarse.fit, told["fit"]
    own = fit.inside
    assert len(said["modes"]) + len(said["residual"]) == len(fit.omega) > len(said["modes"])
    np.testing.assert_allclose([mode[0] for mode in said["modes"]], fit.natural_frequency[own])
    np.testing.assert_allclose([mode[1] for mode in said["modes"]], 100 * fit.zeta[own])
    np.testing.assert_allclose(said["misfit"], 100 * fit.misfit)
    # the damped frequencies of the foundation, without those of residual modes
    every = found.foundation.modes().frequency
    nearest = np.abs(every[:, None] - found.alone).min(axis=0)
    assert len(found.alone) == own.sum()
    assert (nearest < 1e-6 * found.alone).all()
    assert answer(coarse, [150.0, 350.0, 151.0, 348.0])[1]["fit"] is None


@pytest.mark.parametrize(("peaks", "method"), [(TWICE, "pmsm"), (DISTINCT, "distinct"), ([], "identify")])
def test_the_sum_of_the_modes_is_the_solved_frf(coarse: Bench, peaks: list[float], method: str) -> None:
    frequency = np.array([10.0, 155.0, 344.0, 470.0])
    near = [150.0, 350.0, 151.0, 348.0] if method == "pmsm" else [150.0, 275.0, 350.0, 475.0] if peaks else []
    found = picked(coarse, near, method)
    solved = found.foundation.frf(frequency).H
    # solving loses digits with the condition of M and K, at most cond(Phi)^2 * eps
    atol = max(1e-12, 10 * found.condition**2 * np.finfo(float).eps) * np.abs(solved).max()
    np.testing.assert_allclose(found.receptance(frequency), solved, atol=atol)


def test_a_seat_without_a_peak_or_with_two_is_said(bench: Bench) -> None:
    picks = picks_of(bench, TWICE)
    with pytest.raises(ValueError, match=r"Every seat needs one peak, 4 in all: y2 has none\."):
        picked(bench, picks[:3])
    with pytest.raises(ValueError, match="x1 has 2, at 160 Hz and 170 Hz"):
        picked(bench, [*picks, {"seat": "x1", "frequency": 170.0}])
    with pytest.raises(ValueError, match="3 peaks are given"):
        picked(bench, picks[:3], "distinct")
    with pytest.raises(ValueError, match="no seat 'z1'"):
        picked(bench, [{"seat": "z1", "frequency": 100.0}])
    with pytest.raises(ValueError, match="2 frequencies are given"):
        picked(bench, [100.0, 200.0])
    with pytest.raises(ValueError, match="no method 'guess'"):
        picked(bench, picks, "guess")


def test_a_bench_refuses_what_does_not_belong_together(bench: Bench, truth: rb.Foundation) -> None:
    frf, rotor, bearings = bench.frf, thesis.rotor(), thesis.bearings()
    with pytest.raises(ValueError, match="give both, or neither"):
        bench_of(frf, rotor)
    with pytest.raises(ValueError, match="1 bearings need 2 seats"):
        bench_of(frf, rotor, dict(list(bearings.items())[:1]))
    with pytest.raises(ValueError, match="The reference model has the seats a, b, c, d"):
        bench_of(frf, truth=replace(truth, labels=("a", "b", "c", "d")))
    with pytest.raises(ValueError, match="2 lines show no peak"):
        bench_of(rb.FRF(frf.frequency[:2], frf.H[:2]))


def test_an_answer_is_the_picked_foundation_in_plain_numbers(bench: Bench) -> None:
    found, told, curves = answer(bench, DISTINCT)
    assert found is not None
    told = json.loads(json.dumps(told, allow_nan=False))
    assert told["message"] == ""
    np.testing.assert_array_equal(told["Phi"], found.Phi)
    for name in "MCK":
        np.testing.assert_array_equal(told["matrices"][name], getattr(found.foundation, name))
    values = np.frombuffer(curves, "<f4")
    count = len(values) // 21
    lines, parts = values[:count].astype(float), values[count:].view("<c8").reshape(10, count)
    H = found.receptance(lines)
    # 32-bit lines near a peak: 6e-8 of the frequency is 3e-6 of a half-width, of the response too
    for row, (i, j) in zip(parts, zip(*np.triu_indices(4), strict=True), strict=True):
        np.testing.assert_allclose(row, H[:, i, j], rtol=1e-5, atol=1e-5 * np.abs(H[:, i, j]).max())
    # each of the four peaks is met within a fiftieth of its half-width
    assert all(np.abs(lines - f).min() < 0.02 * 0.02 * f for f in found.peaks.frequency)


def test_a_scene_holds_the_data_and_where_it_has_peaks(bench: Bench) -> None:
    told, curves = scene(bench)
    told = json.loads(json.dumps(told, allow_nan=False))
    values, n = np.frombuffer(curves, "<f4"), told["lines"]
    np.testing.assert_array_equal(values[:n], bench.frf.frequency.astype("<f4"))
    H = values[n:].view("<c8").reshape(4, 4, n)
    np.testing.assert_array_equal(H, np.moveaxis(bench.frf.H, 0, -1).astype("<c8"))
    near = [min(own, key=lambda p: abs(p["frequency"] - 344)) for own in told["readings"][1::2]]
    for reading, zeta in zip(near, rb.identification.pseudo_modes(bench.frf, TWICE).zeta[1::2], strict=True):
        assert (reading["high"] - reading["low"]) / 2 / reading["frequency"] == pytest.approx(zeta, rel=1e-12)
    assert set(told["first"]) == {"pmsm", "distinct", "identify"}


def test_a_driving_point_that_gives_energy_away_is_a_sentence_and_no_picture(bench: Bench) -> None:
    H = bench.frf.H.copy()
    H[:, 1] *= -1
    found, told, curves = answer(bench_of(rb.FRF(bench.frf.frequency, H)), TWICE)
    assert found is None
    assert curves == b""
    assert "The driving point y1 has a positive imaginary part at 344 Hz" in told["message"]


def test_a_singular_phi_is_a_sentence(bench: Bench) -> None:
    H = bench.frf.H.copy()
    H[:, 2], H[:, :, 2] = H[:, 0], H[:, :, 0]
    H[:, 2, 2] = H[:, 0, 0]
    _, told, _ = answer(bench_of(rb.FRF(bench.frf.frequency, H)), TWICE)
    assert "Phi is singular" in told["message"]


def test_data_without_any_peak_have_no_first_peaks_and_say_why() -> None:
    frequency = np.linspace(10, 20, 11)
    flat = bench_of(rb.FRF(frequency, np.tile((1e-6 - 1e-8j) * np.eye(4), (11, 1, 1))))
    names, _ = scene(flat)
    assert names["first"] == {"pmsm": [], "distinct": [], "identify": []}
    with pytest.raises(ValueError, match="x1 has no peak with half-power points"):
        first_picks(flat, "pmsm")
    with pytest.raises(ValueError, match="do not show 4 peaks"):
        first_picks(flat, "distinct")
    with pytest.raises(ValueError, match="give its peak a damping ratio"):
        picked(flat, [12.0, 13.0, 14.0, 15.0])


def test_thinned_lines_keep_the_largest_and_the_smallest_response(bench: Bench) -> None:
    few = thinned(bench.frf, 100)
    assert len(few.frequency) <= 100
    sizes = [np.linalg.norm(frf.H, axis=(1, 2)) for frf in (few, bench.frf)]
    assert sizes[0].max() == sizes[1].max()
    assert sizes[0].min() == sizes[1].min()
    assert thinned(bench.frf, 10_000) is bench.frf


def test_frequencies_are_paired_nearest_first_and_strangers_stand_alone() -> None:
    assert paired([100, 200, 300], [101, 102, 290, 400]) == [
        (100, 101),
        (None, 102),
        (200, None),
        (300, 290),
        (None, 400),
    ]
    assert paired([], [5.0]) == [(None, 5.0)]
