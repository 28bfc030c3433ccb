"""The lowest modes of a chain: those of the dense matrix, all of them, or a clear no."""

from dataclasses import replace

import numpy as np
import pytest

import rbfound as rb
import rbfound.lowest
from rbfound.elimination import _held
from rbfound.lowest import complete, lowest_modes, small_model

DISKS = {0.25: rb.Disk(10.0, 0.02, 0.04), 0.5: rb.Disk(20.0, 0.05, 0.1)}
ROTOR = rb.Rotor(rb.Shaft([1.0], [0.05]), DISKS, element=0.04)
SPEEDS = np.linspace(0.0, 1500.0, 6)


def foundation(zeta=0.02):
    phi = 0.12 * np.random.default_rng(8).standard_normal((4, 5))
    return rb.modal_foundation(phi, rb.radians(np.array([30.0, 55, 80, 120, 160])), np.full(5, zeta))


def mounted(bearing, on=None):
    return rb.mount(ROTOR, {0.0: bearing, 1.0: bearing}, on=on)


MACHINES = {
    "round, lightly damped": mounted(rb.Bearing(1e7, 1e7, cxx=1e3, cyy=1e3)),
    "round, undamped": mounted(rb.Bearing(1e7, 1e7)),
    "nearly round": mounted(rb.Bearing(1e7, 1.0001e7, cxx=100.0, cyy=100.0)),
    "with cross-coupling, unstable": mounted(rb.Bearing(1e7, 2e7, kxy=4e6, kyx=-4e6, cxx=1e3, cyy=1e3)),
    "heavily damped": mounted(rb.Bearing(1e6, 3e6, cxx=3e4, cyy=5e4)),
    "on a foundation": mounted(rb.Bearing(1e8, 1e8, cxx=1e4, cyy=1e4), foundation()),
    "in one soft bearing": rb.mount(ROTOR, {0.5: rb.Bearing(1e5, 1e5, cxx=10.0, cyy=10.0)}, on=None),
    "with a disk that hardly tilts": rb.mount(
        rb.Rotor(rb.Shaft([0.6, 0.4], [0.05, 0.05]), {1.0: rb.Disk(8.0, 0.5, 1.0)}, element=0.04),
        {0.0: rb.Bearing(3e7, 3e7), 0.6: rb.Bearing(3e7, 3e7)},
    ),
}


def allowed(machine, speed, poles):
    """What the dense matrix's rounding does to an eigenvalue: eps times the largest square; ten of that."""
    every = np.abs(machine.at(speed).modes().poles)
    return 1e-9 + 10 * np.finfo(float).eps * (every.max() / np.abs(poles)) ** 2


@pytest.mark.parametrize("name", MACHINES)
def test_the_lowest_modes_are_those_of_the_dense_matrix(name):
    machine = MACHINES[name]
    found = lowest_modes(machine.chain, SPEEDS, 16, 1.0)
    assert found is not None
    for speed, modes in zip(SPEEDS, found, strict=True):
        dense = machine.at(float(speed)).modes().above(1.0)
        assert modes.poles.shape == (16,)
        # neighbours of one frequency may change places: nearest ones, both ways, over what was asked for
        for a, b in ((modes.poles[:12], dense.poles), (dense.poles[:12], modes.poles)):
            off = np.abs(a[:, None] - b).min(axis=1) / np.abs(a)
            assert (off < allowed(machine, speed, a)).all(), (speed, off.max())


@pytest.mark.parametrize("name", MACHINES)
def test_each_mode_satisfies_the_equation_of_motion(name):
    machine = MACHINES[name]
    for speed, modes in zip(SPEEDS, lowest_modes(machine.chain, SPEEDS, 16, 1.0), strict=True):
        s = machine.at(float(speed))
        for pole, x in zip(modes.poles, modes.shapes.T, strict=True):
            parts = [pole**2 * (s.M @ x), pole * ((s.C + s.G) @ x), s.K @ x]
            size = sum(abs(w) * np.abs(A).sum(axis=1).max() for w, A in ((pole**2, s.M), (pole, s.C + s.G), (1, s.K)))
            assert np.abs(sum(parts)).max() < 1e-12 * size
            assert np.abs(x).max() == pytest.approx(1)


def counted(machine, lost):
    """Whether the count agrees when the small model does not show one of its conjugate pairs."""
    speeds = np.array([300.0])
    small = small_model(machine.chain, 72, 60)
    poles, _ = small.modes(speeds)
    rank = np.argsort(np.where(poles[0].imag > 6.0, poles[0].imag, np.inf))[:18]
    wanted = poles[0, rank]
    if lost is not None:
        gone = wanted[lost]
        keep = (np.abs(poles[0] - gone) > 1e-6 * abs(gone)) & (np.abs(poles[0] - gone.conj()) > 1e-6 * abs(gone))
        poles, wanted = poles[:, keep], np.delete(wanted, lost)
    return complete(machine.chain, speeds, poles, wanted[None])


@pytest.mark.parametrize("name", ["on a foundation", "heavily damped", "with cross-coupling, unstable"])
def test_a_lost_mode_is_noticed(name):
    assert counted(MACHINES[name], None)
    for lost in (0, 3, 7, 10):
        assert not counted(MACHINES[name], lost)


def test_what_is_not_certain_takes_the_long_road(monkeypatch):
    machine = MACHINES["on a foundation"]
    expected = rb.campbell(machine, SPEEDS, count=8)
    monkeypatch.setattr(rbfound.lowest, "complete", lambda *_: False)
    assert lowest_modes(machine.chain, SPEEDS, 16, 1.0) is None
    long = rb.campbell(machine, SPEEDS, count=8)
    np.testing.assert_allclose(long.poles, expected.poles, rtol=1e-8)
    np.testing.assert_allclose(long.whirl, expected.whirl, atol=1e-6)
    np.testing.assert_allclose(long.critical_speeds().speed, expected.critical_speeds().speed, rtol=1e-8)


def test_two_modes_that_are_one_take_the_long_road():
    # kxy = -kyx = (kyy - kxx) / 2: at rest, round but for the bearings, each two modes have one pole and one shape
    machine = mounted(rb.Bearing(1e7, 2e7, kxy=5e6, kyx=-5e6, cxx=1e3, cyy=1e3))
    assert lowest_modes(machine.chain, np.zeros(1), 16, 1.0) is None
    dense = machine.at(0.0).modes().above(1.0)
    np.testing.assert_allclose(rb.campbell(machine, [0.0], count=8).poles[0], dense.poles[:8], rtol=1e-12)


def test_a_misfit_or_a_mode_found_twice_is_no_answer(monkeypatch):
    chain = MACHINES["on a foundation"].chain
    monkeypatch.setattr(rbfound.lowest, "ROUNDING", 1e-25)
    assert lowest_modes(chain, SPEEDS, 16, 1.0) is None
    monkeypatch.undo()
    monkeypatch.setattr(rbfound.lowest, "_repeated", lambda _: True)
    assert lowest_modes(chain, SPEEDS, 16, 1.0) is None


def test_more_modes_than_the_machine_has_are_no_answer():
    few = rb.mount(
        rb.Rotor(rb.Shaft([1.0], [0.05]), element=0.2), {0.0: rb.Bearing(1e7, 1e7), 1.0: rb.Bearing(1e7, 1e7)}
    )
    chain = few.chain
    assert chain is None or lowest_modes(chain, SPEEDS, 100, 1.0) is None


def test_a_machine_of_other_matrices_is_followed_as_it_is():
    machine = MACHINES["on a foundation"]
    heavy = replace(machine, M=machine.M + np.diag([5.0, 5.0, 0, 0] + [0.0] * (len(machine.M) - 4)))
    found = lowest_modes(heavy.chain, SPEEDS, 12, 1.0)
    dense = heavy.at(float(SPEEDS[-1])).modes().above(1.0).poles[:10]
    np.testing.assert_allclose(np.sort(found[-1].poles.imag)[:10], np.sort(dense.imag), rtol=1e-8)


def test_a_matrix_that_is_singular_to_the_last_bit_gives_its_own_shape_and_leaves_the_other_lanes_alone():
    # what Newton's method meets where a step ends on the pole itself: with some processors' kernels, not with others
    singular, good = np.array([[1.0, 1.0], [1.0, 1.0]]), np.array([[2.0, 1.0], [0.0, 4.0]])
    b = np.array([[1.0], [0.0]])
    one, other = _held(np.array([singular, good], dtype=complex), np.array([b, b], dtype=complex))
    np.testing.assert_allclose(one[1] / one[0], -1, rtol=1e-12)
    assert np.abs(one).min() > 1e14
    np.testing.assert_array_equal(other, [[0.5], [0.0]])
