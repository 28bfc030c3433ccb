"""The solid of revolution: rigid motions, beam theory where it holds, convergence, gyroscopics."""

import numpy as np
import pytest

import rbfound as rb

pytest.importorskip("skfem", reason="The solid rotor needs scikit-fem: pip install 'rbfound[solid]'.")

from rbfound.solid import cone_angle, gyroscopic, natural_modes, ritz_modes, section_mesh, solid_rotor
from rbfound.theory import mount_reduced, round_rotor

SLENDER = rb.Shaft([1.2], [0.03])
BODY = rb.thesis.rotor(0.0)


def frequencies(rotor, count=6, size=0.01, seats=()):
    return rb.hertz(natural_modes(solid_rotor(rotor, seats, size), count, shift=-100.0)[0])


def test_a_plane_of_a_free_rotor_has_two_zero_frequencies():
    # translation and tilt; sqrt(eps) of the fastest mode (some 1e6 Hz) would be 0.01 Hz, inverse iteration does better
    assert frequencies(BODY)[:2] == pytest.approx(0.0, abs=0.05)
    assert frequencies(BODY)[2] > 100


def test_the_mass_is_that_of_the_cylinders():
    # S = 1 everywhere is a translation: rho times the volume, by pi d^2 / 4
    for rotor in (BODY, rb.Rotor(SLENDER)):
        assert solid_rotor(rotor, []).mass == pytest.approx(rotor.mass, rel=1e-12)


def test_a_tilt_weighs_what_rigid_cylinders_weigh():
    # S = z, W = -r: about z = 0 a cylinder has m (L^2/3 + d^2/16)
    shaft = rb.Shaft([0.4], [0.2])
    solid = solid_rotor(rb.Rotor(shaft), [], 0.02)
    z, r = solid.mesh.doflocs
    tilt = np.concatenate([z, 0 * z, -r])
    mass = shaft.rho * np.pi * 0.01 * 0.4
    assert tilt @ (solid.M @ tilt) == pytest.approx(mass * (0.4**2 / 3 + 0.2**2 / 16), rel=1e-10)
    assert np.abs(solid.K @ tilt).max() < 1e-9 * np.abs(solid.K).max()


def test_a_slender_shaft_bends_as_the_beam_does():
    # Timoshenko's theory is right to the order (d/L)^4 here: 0.1 % for d/L = 1/40 and two half waves
    beam = rb.Rotor(SLENDER, element=0.02).at(0).modes().above(1).frequency[[0, 2, 4]]
    np.testing.assert_allclose(frequencies(rb.Rotor(SLENDER), 5)[2:], beam, rtol=1e-3)


def test_a_thick_cylinder_converges_with_the_fourth_power_of_the_edge():
    # no re-entrant corner: quadratic elements give frequencies of order 4; 3.5 leaves room for the coarsest mesh
    thick = rb.Rotor(rb.Shaft([0.4], [0.16]))
    f = [frequencies(thick, 3, size)[2] for size in (0.08, 0.04, 0.02, 0.01)]
    steps = -np.diff(f)
    assert (steps > 0).all()
    assert np.log2(steps[1] / steps[2]) > 3.5


def test_the_stepped_rotor_is_converged_within_one_percent():
    # the re-entrant corners are singular, of the order of the edge itself: halving again moves at most as much again
    at_10, at_5 = frequencies(BODY, 4, 0.01)[2:], frequencies(BODY, 4, 0.005)[2:]
    assert (np.abs(at_10 / at_5 - 1) < 0.005).all()


def test_the_mean_over_a_section_follows_rigid_motions():
    solid = solid_rotor(BODY, [0.045, 0.85])
    z, r = solid.mesh.doflocs
    np.testing.assert_allclose(solid.B @ np.concatenate([1 + 2 * z, 0 * z, -2 * r]), [1.09, 2.7], rtol=1e-12)


def test_a_point_mass_at_the_tip_adds_to_the_translation():
    assert solid_rotor(rb.thesis.rotor(), []).mass == pytest.approx(rb.thesis.rotor().mass, rel=1e-12)


def test_the_gyroscopic_matrix_of_a_rigid_tilt_is_the_polar_inertia():
    # Ip = m d^2 / 8 of a cylinder
    shaft = rb.Shaft([0.05], [0.4])
    solid = solid_rotor(rb.Rotor(shaft), [], 0.02)
    z, r = solid.mesh.doflocs
    tilt = np.concatenate([z, 0 * z, -r])
    assert tilt @ (gyroscopic(solid, shaft) @ tilt) == pytest.approx(solid.mass * 0.4**2 / 8, rel=1e-10)


def test_both_planes_split_at_speed_as_the_beam_does():
    # the split of the first free pair at 30000 rev/min; both theories agree on it within the 1 % of their frequencies
    speed = rb.from_rpm(30000)
    solid = solid_rotor(BODY, [0.045, 0.85])
    omega, Phi = ritz_modes(solid, 8, 2, -100.0)
    g = Phi.T @ (gyroscopic(solid, BODY.shaft) @ Phi)
    solids = mount_reduced(round_rotor(omega, solid.B @ Phi, g, [0.045, 0.85]), {}, None)
    split = [machine.at(speed).modes().above(400).frequency[:4] for machine in (solids, BODY)]
    np.testing.assert_allclose(np.diff(split[0])[[0, 2]], np.diff(split[1])[[0, 2]], rtol=0.03)


def test_the_mesh_fills_the_drawing_and_no_more():
    mesh = section_mesh(BODY.shaft, [0.045], 0.01)
    corners = mesh.p[:, mesh.t]
    area = np.ptp(corners[0], axis=0) * np.ptp(corners[1], axis=0)
    half = np.sum(np.array(BODY.shaft.length) * np.array(BODY.shaft.diameter) / 2)
    assert area.sum() == pytest.approx(half, rel=1e-12)
    assert np.isclose(mesh.p[0], 0.045).any()


def test_the_cone_of_a_step_depends_on_the_ratio_of_the_diameters_alone():
    # the same drawing at half the scale, with half the elements' size: the same numbers but for the beam's elements
    assert cone_angle(0.04, 0.1, 0.01) == pytest.approx(cone_angle(0.02, 0.05, 0.005), abs=0.2)
    assert 20 < cone_angle(0.04, 0.1, 0.01) < 45
    with pytest.raises(ValueError, match="0 < thin < thick"):
        cone_angle(0.1, 0.04)


def test_what_cannot_be_meshed_is_refused():
    with pytest.raises(ValueError, match="hollow"):
        solid_rotor(rb.Rotor(rb.Shaft([1.0], [0.1], inner=0.05)), [])
    with pytest.raises(ValueError, match="moments of inertia"):
        solid_rotor(rb.Rotor(SLENDER, {0.6: rb.Disk(1.0, Id=0.1, Ip=0.2)}), [])
    with pytest.raises(ValueError, match=r"2 m.*reaches from 0 to 1\.2 m"):
        solid_rotor(rb.Rotor(SLENDER), [2.0])
