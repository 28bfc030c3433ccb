"""The rigid rotor on two supports: closed forms against matrices, and the beam rotor made stiff."""

from dataclasses import replace

import numpy as np
import pytest

import rbfound as rb
from rbfound.campbell_diagram import whirl_direction
from rbfound.theory import RigidRotor, conical, isotropic_whirl, rigid_rotor, support_stiffness


def supports(kx: float, ky: float | None = None) -> rb.Bearing:
    return rb.Bearing(kxx=kx, kyy=kx if ky is None else ky)


def rotor(a: float = 0.2, b: float = 0.35, k1: float = 1e7, k2: float = 2e7, ratio: float = 1.0) -> RigidRotor:
    return RigidRotor(60.0, 0.9, 1.2, a, b, (supports(k1, ratio * k1), supports(k2, ratio * k2)))


def undamped(system: rb.System) -> np.ndarray:
    """The natural frequencies [rad/s] of undamped, perhaps gyroscopic, matrices."""
    return np.sort(np.abs(system.modes().poles.imag))


def test_newtons_law_with_the_forces_of_equation_21_gives_the_matrices_of_equation_22() -> None:
    # equation 20 term by term with the forces of 21, for an arbitrary motion
    r, speed = rotor(ratio=0.6), 700.0
    m, Id, Ip, a, b = r.mass, r.Id, r.Ip, r.a, r.b
    x, y, theta, psi = q = np.array([1.1e-3, -0.4e-3, 2.0e-3, 0.7e-3])
    v = np.array([0.3, 0.2, -0.5, 0.8])
    fx1, fx2 = r.bearings[0].kxx * (x - a * psi), r.bearings[1].kxx * (x + b * psi)
    fy1, fy2 = r.bearings[0].kyy * (y + a * theta), r.bearings[1].kyy * (y - b * theta)
    acceleration = np.array(
        [
            (-fx1 - fx2) / m,
            (-fy1 - fy2) / m,
            (-a * fy1 + b * fy2 - Ip * speed * v[3]) / Id,
            (a * fx1 - b * fx2 + Ip * speed * v[2]) / Id,
        ]
    )
    s = r.about_centre(speed)
    np.testing.assert_allclose(s.M @ acceleration + (s.C + s.G) @ v + s.K @ q, 0, atol=1e-9 * np.abs(s.K @ q).max())


def test_the_coefficients_of_equation_23_stand_in_the_matrix_with_the_signs_of_equation_22() -> None:
    r = rotor(ratio=0.6)
    K = r.about_centre(0.0).K
    (kxT, kxC, kxR), (kyT, kyC, kyR) = (
        support_stiffness(*(getattr(bearing, name) for bearing in r.bearings), r.a, r.b) for name in ("kxx", "kyy")
    )
    expected = [[kxT, 0, 0, kxC], [0, kyT, -kyC, 0], [0, -kyC, kyR, 0], [kxC, 0, 0, kxR]]
    np.testing.assert_allclose(K, expected, rtol=1e-13)


def test_the_sign_that_equation_23_prints_makes_the_stiffness_create_energy() -> None:
    # translation and tilting of nearly one frequency, coupled by forces of opposite sign: flutter
    r = RigidRotor(60.0, 3.4, 1.2, 0.2, 0.3, (supports(1e7), supports(1e7)))
    s = r.about_centre(0.0)
    K = s.K.copy()
    K[1, 2] *= -1
    assert np.abs(s.modes().damping).max() < 1e-12
    assert rb.System(s.M, s.C, K).modes().damping.min() < -0.01


def test_a_symmetric_rotor_moves_at_the_root_of_2_k_over_m_and_tilts_by_its_quadratic() -> None:
    k, l, speed = 1e7, 0.25, 800.0
    r = RigidRotor(60.0, 0.9, 1.2, l, l, (supports(k), supports(k)))
    expected = [np.sqrt(2 * k / 60.0)] * 2
    for omega in (
        backward := -np.roots([0.9, -speed * 1.2, -2 * k * l**2]).min(),
        forward := conical(0.9, 1.2, speed, 2 * k * l**2)[1],
    ):
        expected.append(omega)
    assert forward**2 * 0.9 - forward * speed * 1.2 - 2 * k * l**2 == pytest.approx(0, abs=1e-8 * k)
    assert backward**2 * 0.9 + backward * speed * 1.2 - 2 * k * l**2 == pytest.approx(0, abs=1e-8 * k)
    np.testing.assert_allclose(undamped(r.about_centre(speed)), np.sort(expected), rtol=1e-9)


@pytest.mark.parametrize("speed", [0.0, 1e-6, 300.0, 5000.0])
@pytest.mark.parametrize("ratio", [1.0, 0.4])
def test_the_conical_closed_form_is_that_of_the_matrices_on_any_supports(speed: float, ratio: float) -> None:
    l, k = 0.25, 1e7
    r = RigidRotor(60.0, 0.9, 1.2, l, l, (supports(k, ratio * k), supports(k, ratio * k)))
    tilting = rb.System(*(getattr(r.about_centre(speed), name)[2:, 2:] for name in "MCKG"))
    found = conical(0.9, 1.2, speed, 2 * k * l**2, 2 * ratio * k * l**2)
    # a double root, at rest, is found by eig to the square root of its rounding only
    tolerance = 1e-9 if speed > 1 or ratio < 1 else 1e-7
    np.testing.assert_allclose(undamped(tilting), found, rtol=tolerance)


def test_the_split_of_the_conical_mode_is_the_gyroscopic_frequency() -> None:
    # of omega^2 Id - omega speed Ip - k: sum of the signed roots speed Ip / Id, their product -k / Id
    backward, forward = conical(0.9, 1.2, 1000.0, 1.25e6)
    assert forward - backward == pytest.approx(1000.0 * 1.2 / 0.9)
    assert forward * backward == pytest.approx(1.25e6 / 0.9)


@pytest.mark.parametrize("speed", [0.0, 400.0, 4000.0])
def test_the_quartic_gives_the_frequencies_of_the_matrices_and_their_sense(speed: float) -> None:
    r = rotor()
    roots, system = isotropic_whirl(r, speed), r.at(speed)
    modes = system.modes()
    np.testing.assert_allclose(np.abs(roots), modes.poles.imag, rtol=1e-7 if speed == 0 else 1e-9)
    if speed:
        np.testing.assert_allclose(np.sign(roots), whirl_direction(modes, system), atol=1e-6)


def test_both_sets_of_coordinates_are_one_system() -> None:
    r = rotor(ratio=0.5)
    centre, journals = (s.modes() for s in (r.about_centre(900.0), r.at(900.0)))
    np.testing.assert_allclose(centre.poles, journals.poles, rtol=1e-9, atol=1e-6)
    same = rb.mac(r.journals @ centre.shapes, journals.shapes)
    np.testing.assert_allclose(np.diag(same), 1, rtol=1e-9)


def test_supports_that_differ_flatten_the_orbits_and_damping_and_cross_terms_are_kept() -> None:
    s = rotor(ratio=0.5).at(200.0)
    assert np.abs(whirl_direction(s.modes(), s)).max() < 0.9
    one = rb.Bearing(kxx=1e7, kyy=2e7, kxy=1e6, kyx=-1e6, cxx=10.0, cyy=20.0)
    r = RigidRotor(60.0, 0.9, 1.2, 0.2, 0.3, (one, one))
    np.testing.assert_allclose(r.about_centre(0.0).K[:2, :2], 2 * one.K)
    np.testing.assert_allclose(r.about_centre(0.0).C[:2, :2], 2 * one.C)
    np.testing.assert_allclose(np.linalg.eigvals(r.at(0.0).K @ np.linalg.inv(r.at(0.0).M)).real.min() > 0, True)


def test_a_cylinder_with_a_disk_has_the_mass_centre_and_inertias_of_the_handbook() -> None:
    shaft = rb.Shaft([0.5], [0.08], rho=7800.0)
    whole = rb.Rotor(shaft, {0.4: rb.Disk(5.0, Id=0.02, Ip=0.035)})
    bearings = {0.05: supports(1e7), 0.45: supports(1e7)}
    m = 7800.0 * np.pi * 0.04**2 * 0.5
    centre = (m * 0.25 + 5.0 * 0.4) / (m + 5.0)
    Id = m * (3 * 0.04**2 + 0.5**2) / 12 + m * (0.25 - centre) ** 2 + 0.02 + 5.0 * (0.4 - centre) ** 2
    r = rigid_rotor(whole, bearings)
    # the elements carry rigid motions exactly
    np.testing.assert_allclose(
        [r.mass, r.a, r.b, r.Id, r.Ip], [m + 5, centre - 0.05, 0.45 - centre, Id, m * 0.04**2 / 2 + 0.035], rtol=1e-10
    )


@pytest.mark.parametrize("speed", [0.0, 2000.0])
def test_a_rotor_of_beam_elements_made_stiff_becomes_the_rigid_one_with_order_one(speed: float) -> None:
    # compliances in series: what bending adds is in proportion to 1/E
    whole = rb.thesis.rotor()
    bearings = dict.fromkeys(rb.thesis.bearings(), supports(1e8, 0.7e8))
    limit = undamped(rigid_rotor(whole, bearings).at(speed))
    errors = []
    for factor in (100.0, 1000.0, 10000.0):
        stiff = rb.Rotor(replace(whole.shaft, E=factor * whole.shaft.E), whole.disks)
        errors.append(np.abs(undamped(rb.mount(stiff, bearings).at(speed))[:4] / limit - 1))
    np.testing.assert_allclose(np.log10(np.array(errors[:-1]) / errors[1:]), 1.0, atol=0.03)
    assert errors[-1].max() < 2e-4


def test_what_cannot_be_a_rigid_rotor_is_refused() -> None:
    two = (supports(1e7), supports(1e7))
    with pytest.raises(ValueError, match="mass = 0"):
        RigidRotor(0.0, 1.0, 1.0, 0.1, 0.1, two)
    with pytest.raises(ValueError, match=r"Ip = 3 kg m².* 2 Id = 2"):
        RigidRotor(1.0, 1.0, 3.0, 0.1, 0.1, two)
    with pytest.raises(ValueError, match=r"a \+ b = -0\.1 m"):
        RigidRotor(1.0, 1.0, 1.0, 0.1, -0.2, two)
    with pytest.raises(ValueError, match="1 bearings"):
        RigidRotor(1.0, 1.0, 1.0, 0.1, 0.1, two[:1])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="1 bearings"):
        rigid_rotor(rb.thesis.rotor(), {0.1: two[0]})
    with pytest.raises(ValueError, match=r"Bearing 1 has K = .*one positive stiffness"):
        isotropic_whirl(rotor(ratio=0.5), 0.0)
    with pytest.raises(ValueError, match="both must be positive"):
        conical(1.0, 1.0, 0.0, -1.0)
