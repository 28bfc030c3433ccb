"""Shafts, disks, bearings and the free rotor."""

import numpy as np
import pytest
from scipy import linalg

import rbfound as rb
from rbfound.beam import element
from rbfound.campbell_diagram import whirl_direction
from rbfound.rotor import assemble

STEPPED = rb.Shaft(length=[0.2, 0.3, 0.1], diameter=[0.05, 0.08, 0.04], inner=[0.0, 0.02, 0.0])


def rigid_motions(mesh):
    """Rigid motions (4 nodes,) of the whole rotor: x, y, tilt in the x plane, tilt in the y plane; spin about none."""
    n, z = len(mesh.z), mesh.z
    one, zero = np.ones(n), np.zeros(n)

    def motion(x, y, theta, psi):
        return np.stack([x, y, theta, psi], axis=1).ravel()

    # small slopes: psi = dx/dz, theta = -dy/dz
    return (
        motion(one, zero, zero, zero),
        motion(zero, one, zero, zero),
        motion(z, zero, zero, one),
        motion(zero, z, -one, zero),
    )


# --- mesh and mass ---


def test_nodes_stand_at_segment_ends_disks_and_bearings_and_no_element_is_too_long():
    mesh = assemble(rb.Rotor(STEPPED, {0.07: rb.Disk(1.0)}, element=0.04), [0.45, 0.6])
    for z in (0.0, 0.07, 0.2, 0.45, 0.5, 0.6):
        assert mesh.z[mesh.node(z)] == pytest.approx(z, abs=1e-12)
    assert np.diff(mesh.z).max() <= 0.04 * (1 + 1e-9)
    assert (np.diff(mesh.z) > 0).all()
    assert (mesh.z[0], mesh.z[-1]) == (0.0, pytest.approx(0.6))


def test_a_segment_of_whole_elements_gets_no_element_more():
    # 0.3 / 0.1 is 2.9999...96 or 3.0000...04 in binary: three elements either way
    assert len(assemble(rb.Rotor(rb.Shaft([0.3, 0.7], [0.1, 0.1]), element=0.1)).z) == 11


def test_a_disk_and_a_bearing_in_one_place_share_one_node():
    # 0.1 + 0.2 and 0.3 differ in the last bit
    plain = assemble(rb.Rotor(rb.Shaft([0.6], [0.05]), {0.3: rb.Disk(1.0)}))
    twice = assemble(rb.Rotor(rb.Shaft([0.6], [0.05]), {0.3: rb.Disk(1.0)}), [0.1 + 0.2])
    np.testing.assert_array_equal(plain.z, twice.z)


def test_a_place_without_a_node_is_an_error_that_tells_the_nearest():
    mesh = assemble(rb.Rotor(rb.Shaft([1.0], [0.1]), element=0.25))
    with pytest.raises(ValueError, match=r"No node stands at 0\.3 m; the nearest one is at 0\.25 m"):
        mesh.node(0.3)


def test_the_mass_of_a_rotor_is_that_of_its_segments_and_disks():
    # pi/4 rho (0.05^2 0.2 + (0.08^2 - 0.02^2) 0.3 + 0.04^2 0.1) + 3
    rotor = rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2), 0.6: rb.Disk(1.0)})
    expected = np.pi / 4 * 7850 * (0.05**2 * 0.2 + (0.08**2 - 0.02**2) * 0.3 + 0.04**2 * 0.1) + 3.0
    assert rotor.mass == pytest.approx(expected, rel=1e-12)
    mesh = assemble(rotor)
    assert len(rigid_motions(mesh)) == 4
    for motion in rigid_motions(mesh)[:2]:
        assert motion @ mesh.M @ motion == pytest.approx(expected, rel=1e-12)


def test_a_tilt_feels_the_moments_of_inertia_of_shaft_and_disk():
    # about z = 0: sum over segments of m z_c^2 + m L^2 / 12 + rho I L, plus disk m z^2 + Id
    rotor = rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)})
    total, start = 2.0 * 0.1**2 + 0.1, 0.0
    for s, L in zip(STEPPED.sections(), STEPPED.length, strict=True):
        m = s.rho * s.area * L
        total += m * ((start + L / 2) ** 2 + L**2 / 12) + s.rho * s.inertia * L
        start += L
    mesh = assemble(rotor)
    for motion in rigid_motions(mesh)[2:]:
        assert motion @ mesh.M @ motion == pytest.approx(total, rel=1e-12)


def test_a_rigid_motion_of_the_rotor_costs_no_energy():
    mesh = assemble(rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)}))
    for motion in rigid_motions(mesh):
        assert np.abs(mesh.K @ motion).max() < 1e-11 * np.abs(mesh.K).max()


def test_mass_and_stiffness_are_symmetric_and_the_gyroscopic_matrix_is_skew():
    mesh = assemble(rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)}))
    for matrix, mirrored in ((mesh.M, mesh.M.T), (mesh.K, mesh.K.T), (mesh.G, -mesh.G.T)):
        np.testing.assert_allclose(matrix, mirrored, atol=1e-14 * np.abs(matrix).max(), rtol=0)


def test_the_gyroscopic_matrix_of_a_tilt_is_the_polar_moment_of_inertia_with_the_sign_of_equation_20():
    # Id theta'' + Ip Omega psi' = ..., Id psi'' - Ip Omega theta' = ...: G[theta, psi] = Ip, G[psi, theta] = -Ip.
    # A unit psi everywhere is the x tilt of rigid_motions, a unit theta everywhere minus its y tilt.
    rotor = rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)})
    mesh = assemble(rotor)
    _, _, psi, minus_theta = rigid_motions(mesh)
    theta = -minus_theta
    polar = 0.2 + sum(2 * s.rho * s.inertia * L for s, L in zip(STEPPED.sections(), STEPPED.length, strict=True))
    assert theta @ mesh.G @ psi == pytest.approx(polar, rel=1e-12)
    assert psi @ mesh.G @ theta == pytest.approx(-polar, rel=1e-12)


def test_one_plane_of_the_rotor_is_the_assembled_beam():
    # x and psi of the mesh are w and slope of beam.element, y and -theta those of the other plane
    mesh = assemble(rb.Rotor(rb.Shaft([0.4], [0.05]), element=0.2))
    part = element(0.2, rb.Shaft([0.4], [0.05]).sections()[0])
    beam = np.zeros((6, 6))
    beam[:4, :4] += part.M
    beam[2:, 2:] += part.M
    x, sign = np.array([0, 3, 4, 7, 8, 11]), np.array([1, -1, 1, -1, 1, -1])
    y = np.array([1, 2, 5, 6, 9, 10])
    np.testing.assert_allclose(mesh.M[np.ix_(x, x)], beam, rtol=1e-14)
    np.testing.assert_allclose(mesh.M[np.ix_(y, y)], beam * np.outer(sign, sign), rtol=1e-14)
    assert not mesh.M[np.ix_(x, y)].any()


def test_a_free_shaft_bends_at_euler_and_bernoullis_frequency():
    # x = 4.73004, omega = x^2 sqrt(EI / (rho A L^4)); L/d = 200: shear and rotary inertia take 1e-4, 40 elements less
    shaft = rb.Shaft([2.0], [0.01])
    s = shaft.sections()[0]
    frequency = rb.Rotor(shaft).at(0.0).modes().frequency
    expected = 4.730040744862704**2 * np.sqrt(s.E * s.inertia / (s.rho * s.area * 2.0**4)) / (2 * np.pi)
    np.testing.assert_array_equal(frequency[:4], 0.0)
    np.testing.assert_allclose(frequency[4:6], expected, rtol=3e-4)


def test_a_finer_mesh_changes_little():
    # fourth order: 50 mm elements of the rotor of thesis.py against 20 mm ones, first two bending modes
    coarse, fine = (
        rb.Rotor(rb.thesis.rotor().shaft, rb.thesis.rotor().disks, element=h).at(0.0).modes().above(1.0).frequency[:4]
        for h in (0.05, 0.02)
    )
    np.testing.assert_allclose(coarse, fine, rtol=1e-3)
    assert (coarse >= fine * (1 - 1e-9)).all()


def test_gyroscopics_act_only_when_the_rotor_spins():
    rotor = rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)})
    assert not rotor.at(0.0).G.any()
    np.testing.assert_allclose(rotor.at(-30.0).G, -rotor.at(30.0).G)
    np.testing.assert_allclose(rotor.at(60.0).G, 2 * rotor.at(30.0).G)


# --- the gyroscopic split ---


def rigid_rotor(Id, Ip, mass=20.0):
    """A short stiff shaft with a disk in its middle; m, Id, Ip of both together about the middle."""
    # E so high that the shaft gives way 1e-7 as much as bearings of 1e6 N/m do: a^3 / 3EI + a / (kappa G A) = 2e-13 m/N
    shaft = rb.Shaft([0.3], [0.2], E=1e14)
    s = shaft.sections()[0]
    m = s.rho * s.area * 0.3
    # a cylinder: m (r^2 / 4 + L^2 / 12) about a diameter, m r^2 / 2 about its axis
    whole = (mass + m, Id + m * (0.1**2 / 4 + 0.3**2 / 12), Ip + m * 0.1**2 / 2)
    return rb.Rotor(shaft, {0.15: rb.Disk(mass, Id, Ip)}), *whole


@pytest.mark.parametrize(("Id", "Ip"), [(0.5, 0.2), (0.5, 0.9)])
@pytest.mark.parametrize("speed", [0.0, 300.0, 2000.0])
def test_a_rigid_rotor_in_two_bearings_has_the_frequencies_of_its_four_equations(Id, Ip, speed):
    # Equations 20 to 24 for isotropic bearings k1 at distance a below, k2 at b above the disk. In z = x + i y and
    # s = psi - i theta, with exp(i lambda t), positive lambda forward:
    #   (kT - m lambda^2) (kR - Id lambda^2 + Ip Omega lambda) - kC^2 = 0
    #   kT = k1 + k2,  kC = -a k1 + b k2,  kR = a^2 k1 + b^2 k2
    rotor, m, Id, Ip = rigid_rotor(Id, Ip)
    k1, k2, a, b = 2e6, 4e6, 0.15, 0.10
    machine = rb.mount(rotor, {0.0: rb.Bearing(kxx=k1, kyy=k1), 0.25: rb.Bearing(kxx=k2, kyy=k2)})
    kT, kC, kR = k1 + k2, -a * k1 + b * k2, a**2 * k1 + b**2 * k2
    shift, tilt = np.polynomial.Polynomial([kT, 0, -m]), np.polynomial.Polynomial([kR, Ip * speed, -Id])
    roots = (shift * tilt - kC**2).roots().real
    order = np.argsort(np.abs(roots))
    modes = machine.at(speed).modes()
    np.testing.assert_allclose(modes.poles.imag[:4], np.abs(roots[order]), rtol=1e-5)
    if speed > 0:
        np.testing.assert_allclose(whirl_direction(modes, machine.at(speed))[:4], np.sign(roots[order]), atol=1e-5)


def test_spin_lifts_the_forward_tilt_and_lowers_the_backward_one_by_the_closed_form():
    # symmetric bearings: Id lambda^2 - Ip Omega lambda - kR = 0,
    # lambda = (Ip Omega +- sqrt((Ip Omega)^2 + 4 Id kR)) / (2 Id)
    rotor, _, Id, Ip = rigid_rotor(0.5, 0.9)
    bearing = rb.Bearing(kxx=4e6, kyy=4e6)
    machine = rb.mount(rotor, {0.0: bearing, 0.3: bearing})
    kR = 2 * 0.15**2 * 4e6
    forward, backward = [], []
    for speed in (0.0, 200.0, 800.0):
        root = np.sqrt((Ip * speed) ** 2 + 4 * Id * kR)
        expected = [(root - Ip * speed) / (2 * Id), (root + Ip * speed) / (2 * Id)]
        poles = machine.at(speed).modes().poles.imag[:4]
        found = [poles[np.abs(poles - e).argmin()] for e in expected]
        np.testing.assert_allclose(found, expected, rtol=2e-6)
        backward.append(found[0])
        forward.append(found[1])
    assert forward[0] < forward[1] < forward[2]
    assert backward[0] > backward[1] > backward[2]


def test_spinning_the_other_way_turns_the_whirl_round():
    rotor, *_ = rigid_rotor(0.5, 0.9)
    machine = rb.mount(rotor, {0.0: rb.Bearing(kxx=4e6, kyy=4e6), 0.3: rb.Bearing(kxx=5e6, kyy=5e6)})
    one, other = machine.at(500.0), machine.at(-500.0)
    # the fastest pole is some 1e5 times larger: eps * 1e5^2 of rounding
    np.testing.assert_allclose(one.modes().poles[:4], other.modes().poles[:4], rtol=1e-6)
    np.testing.assert_allclose(
        whirl_direction(one.modes(), one)[:4], -whirl_direction(other.modes(), other)[:4], atol=1e-6
    )


def test_a_spinning_free_rotor_keeps_its_bending_modes_energy():
    # no damping anywhere: every pole on the imaginary axis
    modes = rb.Rotor(STEPPED, {0.1: rb.Disk(2.0, 0.1, 0.2)}).at(900.0).modes()
    assert np.abs(modes.damping).max() < 1e-7


# --- bad input ---


@pytest.mark.parametrize(
    ("length", "diameter", "message"),
    [
        ([], [], "0 lengths and 0 diameters"),
        ([1.0, 1.0], [0.1], "2 lengths and 1 diameters"),
        ([1.0, 0.0], [0.1, 0.1], "Segment 2 is 0 m long"),
        ([-1.0], [0.1], "Segment 1 is -1 m long"),
        ([float("nan")], [0.1], "Segment 1 is nan m long"),
        ([1.0], [0.0], "diameter 0 m"),
    ],
)
def test_an_impossible_shaft_is_an_error_with_the_number(length, diameter, message):
    with pytest.raises(ValueError, match=message):
        rb.Shaft(length, diameter)


def test_another_number_of_inner_diameters_than_segments_is_an_error_that_says_so():
    with pytest.raises(ValueError, match="inner"):
        rb.Shaft([1.0], [0.1], inner=[0.01, 0.02])


@pytest.mark.parametrize("name", ["mass", "Id", "Ip"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_an_impossible_disk_is_an_error_with_the_number(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value:g}"):
        rb.Disk(**({"mass": 1.0} | {name: value}))


def test_a_bearing_coefficient_that_is_not_finite_is_an_error():
    with pytest.raises(ValueError, match="kxy = nan"):
        rb.Bearing(kxy=float("nan"))


def test_bearing_coefficients_have_their_places_in_the_matrices():
    bearing = rb.Bearing(1, 2, 3, 4, 5, 6, 7, 8)
    np.testing.assert_array_equal(bearing.K, [[1, 3], [4, 2]])
    np.testing.assert_array_equal(bearing.C, [[5, 7], [8, 6]])


@pytest.mark.parametrize("z", [-0.01, 0.61, float("nan")])
def test_a_disk_beside_the_shaft_is_an_error_with_both_numbers(z):
    with pytest.raises(ValueError, match=rf"A disk stands at {z:g} m: the shaft reaches from 0 to 0\.6 m"):
        rb.Rotor(STEPPED, {z: rb.Disk(1.0)})


@pytest.mark.parametrize("size", [0.0, -0.1, float("nan"), float("inf")])
def test_a_longest_element_that_is_no_length_is_an_error(size):
    with pytest.raises(ValueError, match=f"element = {size:g} m"):
        rb.Rotor(STEPPED, element=size)


def test_a_disk_without_inertia_is_a_point_mass():
    mesh, bare = assemble(rb.Rotor(STEPPED, {0.6: rb.Disk(10.0)})), assemble(rb.Rotor(STEPPED))
    added = mesh.M - bare.M
    np.testing.assert_allclose(np.diag(added)[-4:], [10, 10, 0, 0], atol=1e-12)
    assert linalg.norm(added) == pytest.approx(np.sqrt(200))


def test_a_disk_with_more_polar_inertia_than_a_thin_one_is_refused():
    with pytest.raises(ValueError, match=r"Ip = 0\.05 kg m\^2 is more than twice Id = 0\.02 kg m\^2"):
        rb.Disk(2.0, 0.02, 0.05)
    # printed to two digits, a thin disk's moments may be twice but for rounding
    assert rb.Disk(2.0, 0.052, 0.105).Ip == 0.105


def test_a_bearing_is_alike_in_both_directions_unless_told_otherwise():
    assert rb.Bearing(kxx=2e7, cxx=3e3) == rb.Bearing(kxx=2e7, kyy=2e7, cxx=3e3, cyy=3e3)
    held_in_x = rb.Bearing(kxx=2e7, kyy=0.0)
    assert (held_in_x.kyy, held_in_x.cyy) == (0.0, 0.0)


@pytest.mark.parametrize("nodes", [5, 40])
@pytest.mark.parametrize(
    "bearings", [{}, {0.3: rb.Bearing(kxx=1e7)}, {0.0: rb.Bearing(1e7, 0.0), 1.0: rb.Bearing(1e7, 0.0)}]
)
def test_what_is_free_to_move_has_no_receptance_at_0_hz(nodes, bearings):
    machine = rb.mount(rb.Rotor(rb.Shaft([1.0], [0.05]), {0.5: rb.Disk(30)}, element=1 / nodes), bearings)
    at = {"y": machine.coordinate(0.0, "y")}
    with pytest.raises(ValueError, match="singular at 0 Hz"):
        machine.frf([0.0, 1.0], at)
    # the lower the frequency, the farther inertia alone lets it go
    low, high = (np.abs(machine.frf([f], at).H[0, 0, 0]) for f in (0.1, 1.0))
    assert low == pytest.approx(100 * high, rel=1e-2)


@pytest.mark.parametrize("nodes", [5, 40, 400])
@pytest.mark.parametrize("k", [1e3, 1e6, 1e9, 1e12])
def test_what_is_held_has_a_static_receptance_however_soft_or_stiff_its_bearings(nodes, k):
    bearing = rb.Bearing(kxx=k)
    machine = rb.mount(rb.Rotor(rb.Shaft([1.0], [0.05]), element=1 / nodes), {0.0: bearing, 1.0: bearing})
    H = machine.frf([0.0], {"x": machine.coordinate(0.0, "x")}).H[0, 0, 0]
    # all of a force at one end is on the bearing there
    assert pytest.approx(1 / k, rel=1e-3) == H
