"""The band with a border: the answers of the dense matrices, all of them, or a clear no."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

import rbfound as rb
import rbfound.banded
import rbfound.campbell_diagram
from rbfound.banded import band_of, complete, refined, small_model

DISKS = {0.25: rb.Disk(10.0, 0.02, 0.04), 0.5: rb.Disk(20.0, 0.05, 0.1)}
ROTOR = rb.Rotor(rb.Shaft([1.0], [0.05]), DISKS, element=0.04)
SPEEDS = np.linspace(0.0, 1500.0, 6)
LANES = 40
POLES = np.linspace(-200, 50, LANES) + 1j * np.linspace(0.0, 4000.0, LANES)
AT = np.linspace(-300.0, 1500.0, LANES)


def foundation(zeta=0.02):
    phi = 0.12 * np.random.default_rng(8).standard_normal((4, 5))
    return rb.modal_foundation(phi, rb.from_hertz(np.array([30.0, 55, 80, 120, 160])), np.full(5, zeta))


def mounted(bearing, on=None):
    return rb.mount(ROTOR, {0.0: bearing, 1.0: bearing}, on=on)


def oval():
    """A shaft that is not round: stiffer in y than in x."""
    machine = mounted(rb.Bearing(1e7, 2e7, cxx=1e3, cyy=1e3))
    K, y = machine.K.copy(), np.arange(len(machine.K)) % 4
    K[np.ix_((y == 1) | (y == 2), (y == 1) | (y == 2))] *= 1.3
    return replace(machine, K=K)


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
    "with an oval shaft": oval(),
}


def stiffness(machine, k):
    return POLES[k] ** 2 * machine.M + POLES[k] * (machine.C + AT[k] * machine.G) + machine.K


@pytest.mark.parametrize("name", ["on a foundation", "with cross-coupling, unstable", "with an oval shaft"])
def test_the_motion_and_the_phase_of_each_lane_are_those_of_the_dense_matrix(name):
    machine, rng = MACHINES[name], np.random.default_rng(0)
    force = rng.standard_normal((len(machine.M), LANES)) + 1j * rng.standard_normal((len(machine.M), LANES))
    found = machine.banded.solve(POLES, AT, force)
    for k in range(LANES):
        expected = np.linalg.solve(stiffness(machine, k), force[:, k])
        # both lose the condition number, up to 1e9 here, times rounding
        assert np.abs(found[:, k] - expected).max() < 1e-6 * np.abs(expected).max(), k
    assert machine.banded.misfit(POLES, AT, found, force).max() < 1e-13
    assert machine.banded.misfit(POLES, AT, 1.001 * found, force).min() > 100 * rbfound.banded.ROUNDING
    expected = [np.linalg.slogdet(stiffness(machine, k))[0] for k in range(LANES)]
    np.testing.assert_allclose(machine.banded.turns(POLES, AT), expected, atol=1e-7)


def test_what_is_no_band_or_tied_nearly_everywhere_is_none():
    machine = MACHINES["on a foundation"]
    n = len(machine.mesh.M)
    far = machine.K.copy()
    far[0, 8] = far[8, 0] = 1.0
    assert band_of((machine.M, machine.C, far, machine.G), n) is None
    assert band_of((machine.M, machine.C, machine.K, machine.G), n // 2) is None


# --- the lowest modes ---


def allowed(machine, speed, poles):
    """What the dense matrix's rounding does to an eigenvalue: eps times the largest square; ten of that."""
    every = np.abs(machine.at(speed).modes().poles)
    return 1e-9 + 10 * np.finfo(float).eps * (every.max() / np.abs(poles)) ** 2


@pytest.mark.parametrize("name", MACHINES)
def test_the_modes_of_a_diagram_are_those_of_the_dense_matrix_and_satisfy_the_equation_of_motion(name):
    machine, slow = MACHINES[name], 2 * np.pi
    small = small_model(machine.banded, 144, 24, SPEEDS[-1])
    for speed in SPEEDS:
        guess = small.at(float(speed))
        poles, left, right = linalg.eig(guess.state_matrix()[0], left=True, right=True)
        some = np.flatnonzero(poles.imag > slow)
        some = some[np.argsort(poles.imag[some])][:12]
        r = len(guess.M)
        x, y = small.basis @ right[:r, some], small.basis @ left[r:, some]
        found = refined(machine.banded, poles[some], np.full(12, speed), x, y)
        assert found is not None
        s, modes = machine.at(float(speed)), found[1]
        dense = s.modes().above(1.0).poles[:12]
        # neighbours of one frequency may change places: nearest ones, both ways
        for a, b in ((modes.poles, s.modes().poles), (dense, modes.poles)):
            assert (np.abs(a[:, None] - b).min(axis=1) / np.abs(a) < allowed(machine, speed, a)).all(), speed
        for pole, shape in zip(modes.poles, modes.shapes.T, strict=True):
            parts = [pole**2 * (s.M @ shape), pole * ((s.C + s.G) @ shape), s.K @ shape]
            size = sum(abs(w) * np.abs(A).sum(axis=1).max() for w, A in ((pole**2, s.M), (pole, s.C + s.G), (1, s.K)))
            assert np.abs(sum(parts)).max() < 1e-12 * size * np.abs(shape).max()


@pytest.mark.parametrize("name", ["on a foundation", "heavily damped", "with cross-coupling, unstable"])
def test_a_lost_mode_is_noticed(name):
    machine, speeds = MACHINES[name], np.array([300.0])
    poles = small_model(machine.banded, 144, 20).poles(speeds)
    wanted = np.sort(poles.imag[poles.imag > 6.0])
    assert complete(machine.banded, speeds, poles, 18, speeds)
    for lost in (0, 3, 7, 10):
        keep = np.abs(np.abs(poles.imag) - wanted[lost]) > 1e-6 * wanted[lost]
        assert not complete(machine.banded, speeds, poles[keep][None], 17, speeds)


def test_what_is_not_certain_is_solved_as_dense_matrices(monkeypatch):
    machine = MACHINES["on a foundation"]
    expected = rb.campbell(machine, SPEEDS, count=8)
    for name, never in (("complete", lambda *_: False), ("refined", lambda *_: None)):
        monkeypatch.setattr(rbfound.campbell_diagram, name, never)
        dense = rb.campbell(machine, SPEEDS, count=8)
        np.testing.assert_allclose(dense.poles, expected.poles, rtol=1e-8)
        np.testing.assert_allclose(dense.whirl, expected.whirl, atol=1e-6)
        np.testing.assert_allclose(dense.critical_speeds().speed, expected.critical_speeds().speed, rtol=1e-8)


def test_two_modes_that_are_one_are_solved_as_dense_matrices():
    # kxy = -kyx = (kyy - kxx) / 2: at rest, round but for the bearings, each two modes have one pole and one shape
    machine = mounted(rb.Bearing(1e7, 2e7, kxy=5e6, kyx=-5e6, cxx=1e3, cyy=1e3))
    dense = machine.at(0.0).modes().above(1.0)
    # a double pole moves by the root of a rounding
    np.testing.assert_allclose(rb.campbell(machine, [0.0], count=8).poles[0], dense.poles[:8], rtol=1e-6)


def test_a_pole_that_is_met_to_the_last_bit_gives_its_own_shape():
    # what Newton's method meets where a step ends on the pole itself: with some processors' kernels, not with others
    one = np.diag([2.0, 2.0, 3.0, 5.0])
    machine = band_of((np.eye(4), np.zeros((4, 4)), one, np.zeros((4, 4))), 4)
    x = machine.solve(np.array([1j * np.sqrt(5.0)]), np.zeros(1), np.ones((4, 1), dtype=complex))[:, 0]
    assert np.abs(x[3]) > 1e14 * np.abs(x[:3]).max()


# --- forced responses of a machine ---


def test_the_frf_of_a_machine_is_its_receptance():
    machine = MACHINES["on a foundation"]
    lines = np.linspace(0.0, 400.0, 60)
    places = {"disk": machine.coordinate(0.25, "x"), "end": machine.coordinate(1.0, "y"), "seat": len(machine.M) - 1}
    rows = np.eye(len(machine.M))[list(places.values())]
    frf = machine.frf(lines, places, speed=400.0)
    expected = machine.at(400.0).receptance(lines, rows, rows.T)
    assert frf.labels == ("disk", "end", "seat")
    np.testing.assert_allclose(frf.H, expected, atol=1e-8 * np.abs(expected).max())


def test_a_machine_that_is_no_band_answers_too():
    machine = MACHINES["on a foundation"]
    full = replace(machine, C=machine.C + 1e-3 * np.ones_like(machine.C))
    assert full.banded is None
    k = machine.coordinate(0.25, "x")
    row = np.eye(len(machine.M))[[k]]
    found = full.frf([10.0, 50.0], {"disk": k}).H
    np.testing.assert_allclose(found, full.at(0.0).receptance([10.0, 50.0], row, row.T), rtol=1e-12)


def test_a_speed_that_is_not_finite_is_an_error():
    with pytest.raises(ValueError, match="speed is nan"):
        MACHINES["on a foundation"].frf([1.0], {"end": 0}, speed=np.nan)
