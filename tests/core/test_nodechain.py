"""The chain of nodes: the same answers as the dense matrices, and a clear no where it is none."""

from dataclasses import replace

import numpy as np
import pytest

import rbfound as rb
from rbfound.elimination import ROUNDING, solve, turns
from rbfound.roundshaft import chain_of

ROTOR = rb.Rotor(
    rb.Shaft([0.5, 0.3], [0.05, 0.04]), {0.25: rb.Disk(10.0, 0.02, 0.04), 0.8: rb.Disk(4.0, 0.02, 0.03)}, element=0.04
)
BEARING = rb.Bearing(1e7, 2e7, kxy=1e6, kyx=-5e5, cxx=1e3, cyy=2e3, cxy=50.0)
PLACES = (0.0, 0.5)
LANES = 40
POLES = np.linspace(-200, 50, LANES) + 1j * np.linspace(0.0, 4000.0, LANES)
SPEEDS = np.linspace(-300.0, 1500.0, LANES)


def foundation():
    phi = 0.12 * np.random.default_rng(8).standard_normal((4, 5))
    return rb.modal_foundation(phi, rb.radians(np.array([30.0, 55, 80, 120, 160])), np.full(5, 0.02))


MACHINES = {
    "on rigid ground": lambda: rb.mount(ROTOR, dict.fromkeys(PLACES, BEARING)),
    "on a foundation": lambda: rb.mount(ROTOR, dict.fromkeys(PLACES, BEARING), on=foundation()),
    "beside a foundation, untied": lambda: rb.mount(ROTOR, {}, on=foundation()),
    "with a spring on a slope": lambda: with_slope_spring(),
}


def with_slope_spring():
    machine = rb.mount(ROTOR, dict.fromkeys(PLACES, BEARING))
    K = machine.K.copy()
    K[6, 6] += 1e5
    return replace(machine, K=K)


def dynamic_stiffness(machine, k):
    return POLES[k] ** 2 * machine.M + POLES[k] * (machine.C + SPEEDS[k] * machine.G) + machine.K


@pytest.mark.parametrize("name", MACHINES)
def test_the_motion_of_each_lane_is_that_of_the_dense_matrix(name):
    machine = MACHINES[name]()
    rng = np.random.default_rng(0)
    force = rng.standard_normal((len(machine.M), LANES)) + 1j * rng.standard_normal((len(machine.M), LANES))
    chain = machine.chain
    motion = solve(chain, POLES, SPEEDS, *chain.motion(force))
    found = chain.vector(*motion)
    for k in range(LANES):
        expected = np.linalg.solve(dynamic_stiffness(machine, k), force[:, k])
        # both roads lose the condition number, up to 1e9 here, times rounding
        assert np.abs(found[:, k] - expected).max() < 1e-6 * np.abs(expected).max(), k
    assert chain.misfit(POLES, SPEEDS, motion, chain.motion(force)).max() < 1e-13


@pytest.mark.parametrize("name", MACHINES)
def test_stiffness_and_its_slope_times_a_motion_are_the_dense_products(name):
    machine = MACHINES[name]()
    x = np.random.default_rng(1).standard_normal((len(machine.M), LANES)) + 0j
    chain = machine.chain
    force = chain.vector(*chain.stiffness(POLES, SPEEDS, *chain.motion(x)))
    slope = chain.vector(*chain.slope_of_stiffness(POLES, SPEEDS, *chain.motion(x)))
    for k in range(LANES):
        D = dynamic_stiffness(machine, k)
        dense = (2 * POLES[k] * machine.M + machine.C + SPEEDS[k] * machine.G) @ x[:, k]
        np.testing.assert_allclose(force[:, k], D @ x[:, k], atol=1e-13 * np.abs(D).max())
        np.testing.assert_allclose(slope[:, k], dense, atol=1e-12 * np.abs(dense).max())


@pytest.mark.parametrize("name", MACHINES)
def test_the_phase_of_the_determinant_is_that_of_the_dense_matrix(name):
    machine = MACHINES[name]()
    expected = [np.linalg.slogdet(dynamic_stiffness(machine, k))[0] for k in range(LANES)]
    np.testing.assert_allclose(turns(machine.chain, POLES, SPEEDS), expected, atol=1e-7)


def test_a_vector_becomes_a_motion_and_a_vector_again():
    machine = MACHINES["on a foundation"]()
    x = np.random.default_rng(2).standard_normal((len(machine.M), 3)) * (1 + 2j)
    np.testing.assert_allclose(machine.chain.vector(*machine.chain.motion(x)), x, rtol=1e-14)


def test_the_misfit_of_a_wrong_motion_is_large():
    machine = MACHINES["on a foundation"]()
    chain = machine.chain
    force = chain.motion(np.ones((len(machine.M), LANES), dtype=complex))
    wrong = [1.001 * part for part in solve(chain, POLES, SPEEDS, *force)]
    # a part of 1e-3, of the smallest response to a force beside |D| |x|
    assert chain.misfit(POLES, SPEEDS, wrong, force).min() > 100 * ROUNDING


@pytest.mark.parametrize(("matrix", "entry"), [("M", (0, 0)), ("M", (0, 1)), ("K", (2, 12)), ("G", (2, 3))])
def test_a_shaft_that_is_not_round_or_no_chain_is_none(matrix, entry):
    mesh = rb.mount(ROTOR, {}).mesh
    shaft = {name: getattr(mesh, name).copy() for name in "MKG"}
    row, column = entry
    shaft[matrix][row, column] *= 1.001
    shaft[matrix][row, column] += 1e-3 * np.abs(shaft[matrix]).max()
    zero = np.zeros_like(mesh.M)
    assert chain_of(mesh.M, zero, mesh.K, mesh.G, (mesh.M, mesh.K, mesh.G)) is not None
    assert chain_of(shaft["M"], zero, shaft["K"], shaft["G"], tuple(shaft.values())) is None


def test_ties_nearly_everywhere_are_no_chain():
    machine = rb.mount(ROTOR, dict.fromkeys(PLACES, BEARING))
    assert replace(machine, C=0.1 * machine.K).chain is None


# --- forced responses of a machine ---


def test_the_frf_of_a_machine_is_its_receptance():
    machine = MACHINES["on a foundation"]()
    lines = np.linspace(0.0, 400.0, 60)
    places = {"disk": machine.coordinate(0.25, "x"), "end": machine.coordinate(0.8, "y"), "seat": len(machine.M) - 1}
    rows = np.eye(len(machine.M))[list(places.values())]
    frf = machine.frf(lines, places, speed=400.0)
    expected = machine.at(400.0).receptance(lines, rows, rows.T)
    assert frf.labels == ("disk", "end", "seat")
    np.testing.assert_allclose(frf.H, expected, atol=1e-8 * np.abs(expected).max())


def test_a_machine_that_is_no_chain_answers_too():
    machine = replace(MACHINES["on a foundation"](), C=1e-6 * MACHINES["on a foundation"]().K)
    assert machine.chain is None
    k = machine.coordinate(0.25, "x")
    row = np.eye(len(machine.M))[[k]]
    found = machine.frf([10.0, 50.0], {"disk": k}).H
    np.testing.assert_allclose(found, machine.at(0.0).receptance([10.0, 50.0], row, row.T), rtol=1e-12)


def test_a_speed_that_is_not_finite_is_an_error():
    with pytest.raises(ValueError, match="speed is nan"):
        MACHINES["on rigid ground"]().frf([1.0], {"end": 0}, speed=np.nan)
