"""Transmitted forces: closed forms of one spring, sines and cosines against complex numbers, a rotor's balance."""

from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound.solid import brick, elastic_solid, momentum, natural_modes, ritz_modes
from rbfound.theory import ground_forces, seat_forces, seat_momentum, sine_cosine_amplitude, sine_cosine_matrix

FOLDER = Path(__file__).parents[2] / "data" / "foundation"
SWEEP = rb.from_rpm(np.linspace(1000.0, 30000.0, 7))


def swept(machine: rb.Machine) -> np.ndarray:
    return rb.unbalance_response(machine, SWEEP, {1.0: 1e-3, 0.09: 2e-4j})


def inertia(machine: rb.Machine, x: np.ndarray) -> np.ndarray:
    """Rate of change of the rotor's momentum along X and Y, negative, from its own mass matrix: (speeds, 2)."""
    mesh = machine.mesh
    along = np.zeros((2, len(mesh.M)))
    along[[0, 1], :] = [np.isin(np.arange(len(mesh.M)), plane) for plane in mesh.planes]
    return SWEEP[:, None] ** 2 * (x[:, : len(mesh.M)] @ mesh.M @ along.T)


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.7])
def test_every_damper_gives_one_at_root_two_times_the_natural_frequency(zeta: float) -> None:
    m, k = 3.0, 4e5
    omega = np.sqrt(k / m)
    T = rb.theory.sdof.transmissibility(rb.hertz(np.sqrt(2) * omega), m, 2 * zeta * m * omega, k)
    assert abs(T) == pytest.approx(1.0, rel=1e-12)


def test_transmissibility_is_what_the_textbook_prints_of_it() -> None:
    m, c, k = 3.0, 250.0, 4e5
    f = np.linspace(1.0, 300.0, 50)
    r, zeta = rb.from_hertz(f) / np.sqrt(k / m), c / (2 * np.sqrt(k * m))
    T = rb.theory.sdof.transmissibility(f, m, c, k)
    size = np.sqrt((1 + (2 * zeta * r) ** 2) / ((1 - r**2) ** 2 + (2 * zeta * r) ** 2))
    lag = np.arctan2(2 * zeta * r**3, 1 - r**2 + (2 * zeta * r) ** 2)
    np.testing.assert_allclose(np.abs(T), size, rtol=1e-12)
    np.testing.assert_allclose(-np.angle(T), lag, rtol=1e-10)


def test_transmissibility_is_the_force_of_a_system_and_the_motion_of_a_shaken_ground() -> None:
    m, c, k = 3.0, 250.0, 4e5
    f = np.array([20.0, 58.0, 200.0])
    omega = rb.from_hertz(f)
    x = rb.System([[m]], [[c]], [[k]]).receptance(f)[:, 0, 0]
    np.testing.assert_allclose((k + 1j * omega * c) * x, rb.theory.sdof.transmissibility(f, m, c, k), rtol=1e-12)
    # the ground shaken with unit displacement under a mass: the lower of two masses, whatever it weighs
    heavy = rb.System(np.diag([m, 10.0]), c * np.array([[1, -1], [-1, 1]]), k * np.array([[1, -1], [-1, 1]]))
    H = heavy.receptance(f)
    np.testing.assert_allclose(H[:, 0, 1] / H[:, 1, 1], rb.theory.sdof.transmissibility(f, m, c, k), rtol=1e-10)


def test_sines_and_cosines_say_what_complex_numbers_say() -> None:
    omega, k, c, m = 350.0, (4e5, 7e5), (250.0, 90.0), 3.0
    A1, A2, B1, B2 = parts = np.array([1e-3, -2e-3, 0.5e-3, 0.7e-3])
    # A1 sin + A2 cos = Re((A2 - i A1) e^(i omega t)), B1 cos + B2 sin = Re((B1 - i B2) e^(i omega t))
    amplitudes = np.array([A2 - 1j * A1, B1 - 1j * B2])
    for mass in (0.0, m):
        force = (np.array(k) - mass * omega**2 + 1j * omega * np.array(c)) * amplitudes
        told = sine_cosine_matrix(omega, k, c, mass) @ parts
        np.testing.assert_allclose(told, [-force[0].imag, force[0].real, force[1].real, -force[1].imag], rtol=1e-12)
        np.testing.assert_allclose(sine_cosine_amplitude(told), np.abs(force), rtol=1e-12)


def test_equations_29_and_30_together_are_the_transmissibility() -> None:
    m, c, k, f = 3.0, 250.0, 4e5, 70.0
    omega = rb.from_hertz(f)
    needed, below = (sine_cosine_matrix(omega, (k, k), (c, c), mass) for mass in (m, 0.0))
    reached = sine_cosine_amplitude(below @ np.linalg.solve(needed, [1.0, 0, 1.0, 0]))
    np.testing.assert_allclose(reached, abs(rb.theory.sdof.transmissibility(f, m, c, k)), rtol=1e-12)


def test_on_rigid_ground_the_bearings_carry_what_the_rotor_s_inertia_leaves_over() -> None:
    machine = rb.thesis.model("c")
    x = swept(machine)
    u = 1e-3 + 2e-4j
    applied = SWEEP[:, None] ** 2 * np.array([u, -1j * u])
    through = ground_forces(machine, SWEEP, x)
    # Newton for the whole rotor: the unbalance is in balance with inertia and bearings
    size = np.abs(applied).max()
    np.testing.assert_allclose(through, applied + inertia(machine, x), atol=1e-8 * size)


@pytest.mark.parametrize("name", ["printed", "solid"])
def test_the_forces_of_the_bearings_are_those_that_move_the_foundation(name: str) -> None:
    foundation = rb.thesis.foundation() if name == "printed" else rb.load_foundation(FOLDER / "truth.npz")
    machine = rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=foundation)
    x = swept(machine)
    forces = seat_forces(machine, SWEEP, x)
    q = x[:, len(machine.mesh.M) :]
    moved = np.array(
        [foundation.system().solve(float(w), foundation.B.T @ f) for w, f in zip(SWEEP, forces, strict=True)]
    )
    # the printed Ke is nearly singular: two coordinates in phase have nearly no stiffness
    np.testing.assert_allclose(q, moved, atol=1e-7 * np.abs(q).max())


def test_with_the_seats_for_coordinates_the_ground_gets_k_x_and_c_v_of_equation_30() -> None:
    machine = rb.thesis.model("f")
    x = swept(machine)
    seats = x[:, len(machine.mesh.M) :]
    K, C = rb.thesis.KE, rb.thesis.CE
    below = seats @ K.T + 1j * SWEEP[:, None] * (seats @ C.T)
    expected = np.stack([below[:, 0::2].sum(axis=1), below[:, 1::2].sum(axis=1)], axis=1)
    np.testing.assert_allclose(ground_forces(machine, SWEEP, x), expected, atol=1e-8 * np.abs(expected).max())


def test_one_bearing_mass_on_springs_is_the_transmissibility_of_that_mass() -> None:
    # a foundation of two separate masses: each seat a single degree of freedom
    m, c, k = 50.0, 2e3, 3e7
    foundation = rb.Foundation(m * np.eye(4), c * np.eye(4), k * np.eye(4), np.eye(4))
    machine = rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=foundation)
    x = swept(machine)
    forces = seat_forces(machine, SWEEP, x)
    expected = np.stack([forces[:, 0::2].sum(axis=1), forces[:, 1::2].sum(axis=1)], axis=1)
    expected = expected * rb.theory.sdof.transmissibility(rb.hertz(SWEEP), m, c, k)[:, None]
    np.testing.assert_allclose(ground_forces(machine, SWEEP, x), expected, atol=1e-8 * np.abs(expected).max())


def test_momentum_of_all_rigid_motions_is_the_whole_mass() -> None:
    solid = elastic_solid([brick((0.1, 0.2, 0.4), (2, 2, 3))])
    rows = momentum(solid, natural_modes(solid, 6, shift=-100.0)[1])
    # a translation is a sum of rigid modes of unit mass: the squares of its parts are the mass it has
    np.testing.assert_allclose(rows @ rows.T, solid.mass * np.eye(2), atol=1e-6 * solid.mass)


def test_on_an_elastic_bed_the_momentum_says_what_the_springs_of_the_bed_say() -> None:
    def underside(places: np.ndarray) -> np.ndarray:
        return np.abs(places[1]) < 1e-9

    def top(places: np.ndarray) -> np.ndarray:
        return np.abs(places[1] - 0.2) < 1e-9

    bed = (underside, (3e9, 5e9, 3e9))
    solid = elastic_solid([brick((0.3, 0.2, 0.4), (2, 2, 2))], bores=[top], beds=[bed])
    _, Phi = ritz_modes(solid, 6, 2)
    # a rigid translation strains the bed only, so along @ K is the bed's force
    along = np.kron(np.eye(3)[:2], np.ones(solid.mesh.doflocs.shape[1]))
    bedding = along @ (solid.K @ Phi)
    omega = rb.from_hertz(150.0)
    f = np.array([1.0, 0.3])
    squares = np.einsum("ij,ij->j", Phi, solid.K @ Phi)
    q = (Phi.T @ solid.B.T @ f) / (squares - omega**2)
    by_bed = bedding @ q
    by_momentum = f + omega**2 * momentum(solid, Phi) @ q
    # exact for natural modes; a Ritz basis of two blocks leaves the rest of the static answer's inertia
    np.testing.assert_allclose(by_momentum, by_bed, rtol=1e-4)


def test_what_the_seats_do_not_tell_is_asked_for() -> None:
    truth = rb.load_foundation(FOLDER / "truth.npz")
    machine = rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=truth)
    x = swept(machine)
    with pytest.raises(ValueError, match=r"28 coordinates and 4 seats.*Give `momentum`"):
        ground_forces(machine, SWEEP, x)
    with pytest.raises(ValueError, match=r"momentum has shape \(2, 3\): for 28 coordinates it is \(2, 28\)"):
        ground_forces(machine, SWEEP, x, np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"response has shape \(6, \d+\): with 7 speeds"):
        seat_forces(machine, SWEEP, x[:-1])


def test_other_coordinates_of_the_same_square_foundation_carry_the_same_momentum() -> None:
    turn = np.random.default_rng(3).normal(size=(4, 4))
    plain = rb.thesis.foundation()
    other = rb.Foundation(*(turn.T @ getattr(plain, name) @ turn for name in "MCK"), turn)
    np.testing.assert_allclose(seat_momentum(other), seat_momentum(plain) @ turn, rtol=1e-8, atol=1e-8)
