"""The rotor through its bearings on its foundation (equation 65)."""

import numpy as np
import pytest
from samples import BEARINGS, LEFT, RIGHT, ROTOR, spread_modes
from scipy import linalg

import rbfound as rb
from rbfound.rotor import assemble


def frequencies(machine, count=8, speed=0.0):
    return machine.at(speed).modes().above(1.0).frequency[:count]


def test_equation_65_by_hand_for_a_foundation_in_the_seats_own_coordinates():
    # [M_R, 0; 0, M_F], [C_R + C_B, -C_B; -C_B, C_B + C_F], the same for K: a rotor of one element, two bearings at its
    # ends, so that the rotor's bearing coordinates are 0, 1, 4, 5 of 8
    rotor = rb.Rotor(rb.Shaft([0.4], [0.06]), element=0.4)
    truth = rb.equivalent_matrices(
        0.1 * np.eye(4) + 0.01, 2 * np.pi * np.array([50.0, 80, 120, 170]), np.array([0.01, 0.02, 0.03, 0.04])
    )
    machine = rb.mount(rotor, {0.0: LEFT, 0.4: RIGHT}, on=truth)
    mesh = assemble(rotor)
    at, seat = np.array([0, 1, 4, 5]), np.array([8, 9, 10, 11])
    for name, R in (("M", mesh.M), ("C", np.zeros((8, 8))), ("K", mesh.K)):
        F = getattr(truth, name)
        expected = np.zeros((12, 12))
        expected[:8, :8] = R
        expected[8:, 8:] = F
        if name != "M":
            B = linalg.block_diag(getattr(LEFT, name), getattr(RIGHT, name))
            expected[np.ix_(at, at)] += B
            expected[np.ix_(at, seat)] -= B
            expected[np.ix_(seat, at)] -= B
            expected[np.ix_(seat, seat)] += B
        np.testing.assert_allclose(getattr(machine, name), expected, atol=1e-12 * np.abs(expected).max(), rtol=0)
    np.testing.assert_allclose(machine.G[:8, :8], mesh.G)
    assert not machine.G[8:].any()
    assert not machine.G[:, 8:].any()


def test_rigid_ground_adds_the_bearings_to_their_nodes_and_nothing_else():
    machine = rb.mount(ROTOR, BEARINGS)
    mesh = machine.mesh
    K, C = mesh.K.copy(), np.zeros_like(mesh.K)
    for z, bearing in BEARINGS.items():
        at = np.ix_(*[[4 * mesh.node(z), 4 * mesh.node(z) + 1]] * 2)
        K[at] += bearing.K
        C[at] += bearing.C
    np.testing.assert_allclose(machine.K, K, atol=1e-12 * K.max(), rtol=0)
    np.testing.assert_allclose(machine.C, C, atol=1e-12 * C.max(), rtol=0)
    np.testing.assert_array_equal(machine.M, mesh.M)


@pytest.mark.parametrize("speed", [0.0, 400.0])
def test_mixed_coordinates_and_impedance_coupling_give_one_receptance(speed):
    # Another formulation, by substructures. R: receptance of the free rotor at the bearings, F: of the foundation at
    # its seats, Z = K_B + i omega C_B, g: a force on the rotor. The bearings carry f = Z (x_R - x_F), and
    #   x_R = R (g - f),  x_F = F f   =>   f = (I + Z (R + F))^-1 Z R g
    truth = spread_modes()
    machine = rb.mount(ROTOR, BEARINGS, on=truth)
    n = len(machine.mesh.M)
    pick = np.zeros((4, n))
    pick[range(4), [machine.coordinate(z, d) for z in BEARINGS for d in "xy"]] = 1.0
    whole = np.hstack([pick, np.zeros((4, len(truth.M)))])
    below = np.hstack([np.zeros((4, n)), truth.B])
    lines = np.array([7.0, 42.0, 100.0, 163.0, 251.0, 388.0, 700.0])
    R = ROTOR.at(speed).receptance(lines, pick, pick.T)
    F = truth.frf(lines).H
    above_H = machine.at(speed).receptance(lines, whole, whole.T)
    below_H = machine.at(speed).receptance(lines, below, whole.T)
    for k, f in enumerate(lines):
        Z = linalg.block_diag(*[b.K + 2j * np.pi * f * b.C for b in BEARINGS.values()])
        force = np.linalg.solve(np.eye(4) + Z @ (R[k] + F[k]), Z @ R[k])
        for got, expected in ((above_H[k], R[k] - R[k] @ force), (below_H[k], F[k] @ force)):
            np.testing.assert_allclose(got, expected, atol=1e-9 * np.abs(expected).max(), rtol=0)


def test_two_roads_to_one_foundation_give_one_machine():
    # modal coordinates q and seat coordinates x = Phi q describe the same foundation
    Phi = 0.1 * np.eye(4) + 0.02 * np.random.default_rng(0).standard_normal((4, 4))
    modes = (Phi, 2 * np.pi * np.array([60.0, 100.0, 150.0, 200.0]), np.full(4, 0.02))
    machines = [rb.mount(ROTOR, BEARINGS, on=way(*modes)) for way in (rb.modal_foundation, rb.equivalent_matrices)]
    one, other = (machine.at(100.0).modes().above(1.0) for machine in machines)
    np.testing.assert_allclose(one.poles[:12], other.poles[:12], rtol=1e-8)


def stiff(factor):
    """A foundation of 5 kg seats on springs of 1e9 N/m times a factor, coupled to each other."""
    K = 1e9 * np.array([[2, -0.5, 0, 0], [-0.5, 2, 0, -0.3], [0, 0, 1.5, 0], [0, -0.3, 0, 1.2]])
    return rb.Foundation(5 * np.eye(4), np.zeros((4, 4)), factor * K, np.eye(4))


def test_a_very_stiff_foundation_tends_to_rigid_ground_with_the_first_order():
    # its compliance acts in series with the bearings': a perturbation of first order in 1 / stiffness.
    # Undamped symmetric bearings, so that each frequency is a smooth function of it.
    bearings = {z: rb.Bearing(kxx=3e7, kyy=4e7) for z in BEARINGS}
    rigid = frequencies(rb.mount(ROTOR, bearings))
    factors = np.array([1e2, 1e3, 1e4])
    errors = np.array([np.abs(frequencies(rb.mount(ROTOR, bearings, on=stiff(s))) / rigid - 1) for s in factors])
    order = np.log10(errors[:-1] / errors[1:])
    np.testing.assert_allclose(order, 1.0, atol=0.01)


def test_a_massless_foundation_is_a_spring_in_series_with_each_bearing():
    # two roads: k = k_B k_F / (k_B + k_F) on rigid ground. The seats' mass of 1e-4 kg has its mode beyond 1e5 Hz
    k_B, k_F = 3e7, np.array([1e7, 5e7, 2e7, 8e7])
    light = rb.Foundation(1e-4 * np.eye(4), np.zeros((4, 4)), np.diag(k_F), np.eye(4))
    series = k_B * k_F / (k_B + k_F)
    coupled = rb.mount(ROTOR, {z: rb.Bearing(kxx=k_B, kyy=k_B) for z in BEARINGS}, on=light)
    grounded = rb.mount(
        ROTOR, {z: rb.Bearing(kxx=series[2 * i], kyy=series[2 * i + 1]) for i, z in enumerate(BEARINGS)}
    )
    np.testing.assert_allclose(frequencies(coupled, speed=200.0), frequencies(grounded, speed=200.0), rtol=1e-5)


def test_untied_rotor_and_foundation_keep_both_sets_of_frequencies():
    truth = spread_modes()
    machine = rb.mount(ROTOR, {}, on=truth)
    free = ROTOR.at(300.0).modes().above(1.0).frequency
    both = np.sort(np.concatenate([free, truth.modes().frequency]))
    found = machine.at(300.0).modes()
    assert (found.poles == 0).sum() == (ROTOR.at(300.0).modes().poles == 0).sum()
    np.testing.assert_allclose(found.above(1.0).frequency, both, rtol=1e-7)


def test_a_free_rotor_is_what_is_left_without_bearings_and_foundation():
    machine = rb.mount(ROTOR, {})
    np.testing.assert_array_equal(machine.at(100.0).K, ROTOR.at(100.0).K)
    np.testing.assert_array_equal(machine.at(100.0).G, ROTOR.at(100.0).G)


def test_the_foundations_share_of_the_energy_is_none_all_or_between():
    truth = spread_modes(modes=2)
    untied = rb.mount(ROTOR, {}, on=truth)
    modes = untied.at(0.0).modes().above(1.0)
    share = untied.foundation_share(modes)
    own = [int(np.abs(modes.frequency - f).argmin()) for f in truth.modes().frequency]
    np.testing.assert_allclose(share[own], 1.0, atol=1e-9)
    np.testing.assert_allclose(np.delete(share, own), 0.0, atol=1e-9)
    tied = rb.mount(ROTOR, BEARINGS, on=truth)
    share = tied.foundation_share(tied.at(0.0).modes().above(1.0))
    assert ((share >= 0) & (share <= 1)).all()
    assert ((share > 0.01) & (share < 0.99)).any()


@pytest.mark.parametrize("places", [(0.35,), (0.1, 0.6), (0.0, 0.1, 0.6, 0.7)])
def test_one_two_and_four_bearings_stand_on_two_seats_each_in_ascending_order(places):
    # the static force through bearing k pushes its own seats: K q = B' f with all seats' reactions
    truth = spread_modes(2 * len(places))
    bearings = {z: rb.Bearing(kxx=1e7 * (k + 1), kyy=2e7 * (k + 1)) for k, z in enumerate(places)}
    machine = rb.mount(ROTOR, dict(reversed(bearings.items())), on=truth)
    assert list(machine.bearings) == list(places)
    n = len(machine.mesh.M)
    state = np.random.default_rng(1).standard_normal(n + len(truth.M))
    reaction = []
    for k, z in enumerate(places):
        for i, d in enumerate("xy"):
            gap = state[machine.coordinate(z, d)] - (truth.B @ state[n:])[2 * k + i]
            reaction.append((bearings[z].kxx, bearings[z].kyy)[i] * gap)
    below = (machine.K @ state)[n:]
    np.testing.assert_allclose(below, truth.K @ state[n:] - truth.B.T @ reaction, rtol=1e-9)
    assert len(machine.at(0.0).modes().above(1.0).poles) > 8


@pytest.mark.parametrize(("places", "seats"), [((0.1,), 4), ((0.1, 0.6), 2), ((0.1, 0.3, 0.6), 4)])
def test_another_number_of_seats_than_bearings_need_is_an_error_with_both_numbers(places, seats):
    message = rf"{len(places)} bearings need {2 * len(places)} seats, .*the foundation has {seats} \(x1, y1"
    with pytest.raises(ValueError, match=message):
        rb.mount(ROTOR, dict.fromkeys(places, RIGHT), on=spread_modes(seats))


@pytest.mark.parametrize("z", [-0.1, 0.9, float("nan")])
def test_a_bearing_beside_the_shaft_is_an_error_with_both_numbers(z):
    with pytest.raises(ValueError, match=rf"A bearing stands at {z:g} m: the shaft reaches from 0 to 0\.8 m"):
        rb.mount(ROTOR, {z: RIGHT})


def test_a_coordinate_is_found_by_place_and_direction():
    machine = rb.mount(ROTOR, BEARINGS)
    node = int(np.flatnonzero(np.isclose(machine.mesh.z, 0.6))[0])
    assert machine.coordinate(0.6, "x") == 4 * node
    assert machine.coordinate(0.6, "y") == 4 * node + 1
    with pytest.raises(ValueError, match=r"direction is 'z': it must be \"x\" or \"y\""):
        machine.coordinate(0.6, "z")
    with pytest.raises(ValueError, match=r"No node stands at 0\.77 m"):
        machine.coordinate(0.77, "x")


def test_mounting_leaves_rotor_and_foundation_unchanged():
    truth = spread_modes()
    before = [matrix.copy() for matrix in (truth.M, truth.C, truth.K, truth.B)]
    rb.mount(ROTOR, BEARINGS, on=truth)
    for matrix, old in zip((truth.M, truth.C, truth.K, truth.B), before, strict=True):
        np.testing.assert_array_equal(matrix, old)
