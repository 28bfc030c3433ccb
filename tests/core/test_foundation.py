"""Foundations: interface, modes, FRFs, checks."""

import numpy as np
import pytest
from scipy import linalg

import rbfound as rb

RNG = np.random.default_rng(11)
PHI = 0.2 * RNG.standard_normal((4, 7))
OMEGA = 2 * np.pi * np.array([60.0, 110.0, 160.0, 220.0, 300.0, 410.0, 520.0])
ZETA = np.array([0.01, 0.02, 0.02, 0.03, 0.01, 0.02, 0.02])


def test_a_modal_foundation_has_unit_masses_and_the_shapes_as_its_interface():
    foundation = rb.modal_foundation(PHI, OMEGA, ZETA)
    np.testing.assert_array_equal(foundation.M, np.eye(7))
    np.testing.assert_allclose(foundation.C, np.diag(2 * ZETA * OMEGA))
    np.testing.assert_allclose(foundation.K, np.diag(OMEGA**2))
    np.testing.assert_array_equal(foundation.B, PHI)
    assert foundation.labels == ("x1", "y1", "x2", "y2")


def test_the_modes_of_a_modal_foundation_are_those_it_was_made_of():
    foundation = rb.modal_foundation(PHI, OMEGA, ZETA)
    modes = foundation.modes()
    np.testing.assert_allclose(modes.frequency, OMEGA * np.sqrt(1 - ZETA**2) / (2 * np.pi), rtol=1e-12)
    np.testing.assert_allclose(modes.damping, ZETA, rtol=1e-10)
    np.testing.assert_allclose(np.diag(rb.mac(foundation.B @ modes.shapes, PHI)), 1.0, rtol=1e-10)


def test_the_frf_of_a_modal_foundation_is_the_sum_over_its_modes():
    # equation 54: H_ij = sum phi_ir phi_jr / (omega_r^2 - omega^2 + 2 i zeta_r omega_r omega)
    f = np.array([0.0, 33.0, 160.0, 480.0])
    omega = 2 * np.pi * f[:, None]
    weights = 1 / (OMEGA**2 - omega**2 + 2j * ZETA * OMEGA * omega)
    expected = np.einsum("ir,fr,jr->fij", PHI, weights, PHI)
    frf = rb.modal_foundation(PHI, OMEGA, ZETA).frf(f)
    np.testing.assert_array_equal(frf.frequency, f)
    np.testing.assert_allclose(frf.H, expected, rtol=1e-10, atol=1e-14 * np.abs(expected).max())


def test_coordinates_are_the_foundations_own_business():
    # q = T p: M -> T' M T, B -> B T; what the seats feel stays. kappa(T) is of order 10: 1e-9 is safe
    one = rb.modal_foundation(PHI, OMEGA, ZETA)
    T = RNG.standard_normal((7, 7)) + 4 * np.eye(7)
    other = rb.Foundation(T.T @ one.M @ T, T.T @ one.C @ T, T.T @ one.K @ T, one.B @ T)
    f = np.array([10.0, 150.0, 333.0])
    np.testing.assert_allclose(other.frf(f).H, one.frf(f).H, rtol=1e-9, atol=1e-9 * np.abs(one.frf(f).H).max())
    np.testing.assert_allclose(other.modes().poles, one.modes().poles, rtol=1e-9)


def test_a_single_frequency_gives_a_single_line():
    assert rb.modal_foundation(PHI, OMEGA, ZETA).frf(50.0).H.shape == (1, 4, 4)


def test_a_foundation_prints_its_modes_and_all_its_notes():
    text = str(rb.modal_foundation(PHI[:, :1], OMEGA[:1], ZETA[:1], notes=("From a drawing.", "Beware of the bolts.")))
    assert "1 coordinates at the seats x1, y1, x2, y2" in text
    assert "60.00" in text
    assert "1.000" in text  # damping in percent
    assert text.endswith("From a drawing.\nBeware of the bolts.")


def test_asymmetry_is_the_worst_difference_over_the_largest_entry():
    K = np.array([[4.0, 1.0], [1.4, 2.0]])
    foundation = rb.Foundation(np.eye(2), np.zeros((2, 2)), K, np.eye(2), ("x1", "y1"))
    assert foundation.asymmetry() == pytest.approx(0.1)
    assert rb.modal_foundation(PHI, OMEGA, ZETA).asymmetry() == 0.0


def test_definiteness_is_the_smallest_over_the_largest_eigenvalue():
    # eigenvalues of [[1, 2], [2, 1]]: 3 and -1
    foundation = rb.Foundation(
        np.diag([2.0, 1.0]), np.zeros((2, 2)), np.array([[1.0, 2.0], [2.0, 1.0]]), np.eye(2), ("x1", "y1")
    )
    assert foundation.definiteness() == pytest.approx({"M": 0.5, "C": 0.0, "K": -1 / 3})


def test_a_passive_foundation_takes_energy_at_every_line():
    # the imaginary part of a passive, reciprocal receptance is negative semidefinite for any force
    H = rb.modal_foundation(PHI, OMEGA, ZETA).frf(np.arange(5.0, 600.0, 5.0)).H
    assert max(linalg.eigvalsh(h.imag).max() for h in H) < 1e-12 * np.abs(H).max()


def test_the_printed_matrices_are_symmetric_and_barely_definite():
    # cond(Phi) = 99: the eigenvalues of M = Phi^-T Phi^-1 span its square
    foundation = rb.thesis.foundation()
    assert foundation.asymmetry() == 0.0
    assert 0 < foundation.definiteness()["M"] < 1e-3


def test_an_interface_of_another_shape_is_an_error_that_says_the_right_one():
    with pytest.raises(ValueError, match=r"B has shape \(3, 2\): with 4 seats and 2 coordinates it must be \(4, 2\)"):
        rb.Foundation(np.eye(2), np.eye(2), np.eye(2), np.ones((3, 2)))


def test_an_interface_that_is_not_finite_is_named_with_its_place():
    B = np.ones((2, 2))
    B[1, 0] = np.inf
    with pytest.raises(ValueError, match=r"B\[1, 0\] is inf"):
        rb.Foundation(np.eye(2), np.eye(2), np.eye(2), B, ("x1", "y1"))


def test_a_matrix_that_is_not_finite_is_named_with_its_place():
    with pytest.raises(ValueError, match=r"K\[0, 0\] is nan"):
        rb.Foundation(np.eye(1), np.eye(1), [[np.nan]], np.eye(1), ("x1",))


@pytest.mark.parametrize(
    ("Phi", "omega", "zeta", "message"),
    [
        (PHI[:3], OMEGA, ZETA, r"Phi has shape \(3, 7\).*needs 4 rows"),
        (PHI[0], OMEGA, ZETA, r"Phi has shape \(7,\)"),
        (PHI, OMEGA[:6], ZETA, r"omega has shape \(6,\).*must be \(7,\)"),
        (PHI, OMEGA, 0.02, r"zeta has shape \(1,\)"),
        (PHI, -OMEGA, ZETA, r"omega holds -3267.*must be positive"),
        (PHI, OMEGA, -ZETA, r"zeta holds -0.03.*damping ratios are >= 0"),
        (PHI * np.nan, OMEGA, ZETA, "Phi holds a number that is not finite: nan"),
        (PHI, OMEGA * np.inf, ZETA, "omega holds a number that is not finite: inf"),
    ],
)
def test_modes_that_make_no_foundation_are_errors_with_the_number(Phi, omega, zeta, message):
    with pytest.raises(ValueError, match=message):
        rb.modal_foundation(Phi, omega, zeta)
