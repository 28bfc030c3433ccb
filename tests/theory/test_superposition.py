"""Receptances out of modes (equations 34-49, 54-55) against the matrices, and where the sum vanishes."""

import numpy as np
import pytest
from scipy import linalg

import rbfound as rb

RNG = np.random.default_rng(7)
N = 6
CHAIN = rb.theory.chain(RNG.uniform(1, 3, N), RNG.uniform(1, 5, N + 1) * 1e5)
OMEGA, PHI = rb.theory.normal_modes(CHAIN.M, CHAIN.K)
LINES = np.linspace(1.0, 130.0, 57)


def proportional(zeta: float) -> rb.System:
    MPhi = CHAIN.M @ PHI
    return rb.System(CHAIN.M, (MPhi * (2 * zeta * OMEGA)) @ MPhi.T, CHAIN.K)


def test_shapes_are_orthogonal_and_mass_normalised() -> None:
    np.testing.assert_allclose(PHI.T @ CHAIN.M @ PHI, np.eye(N), atol=1e-12)
    np.testing.assert_allclose(PHI.T @ CHAIN.K @ PHI, np.diag(OMEGA**2), atol=1e-10 * OMEGA[-1] ** 2)
    largest = PHI[np.abs(PHI).argmax(axis=0), np.arange(N)]
    assert (largest > 0).all()


def test_the_eigenvalue_of_equation_9_is_the_square_of_omega_and_not_its_inverse() -> None:
    values = linalg.eigvals(np.linalg.solve(CHAIN.M, CHAIN.K))
    np.testing.assert_allclose(np.sort(values.real), OMEGA**2, rtol=1e-10)
    for omega in OMEGA:
        # equation 10 with s = i omega
        scaled = (CHAIN.K - omega**2 * CHAIN.M) / np.abs(CHAIN.K).max()
        assert np.linalg.svd(scaled)[1][-1] < 1e-12


@pytest.mark.parametrize("zeta", [0.0, 0.03])
def test_the_sum_of_all_modes_is_the_inverse_of_the_dynamic_stiffness(zeta: float) -> None:
    A = np.einsum("ir,jr->rij", PHI, PHI)
    H = rb.theory.modal_terms(LINES, OMEGA, zeta, A).sum(axis=1)
    expected = proportional(zeta).receptance(LINES)
    # close to an undamped resonance the two roads differ by rounding times its height
    np.testing.assert_allclose(H, expected, atol=1e-10 * np.abs(expected).max(), rtol=0)


def test_one_frf_and_the_matrix_have_the_same_terms() -> None:
    A = np.einsum("ir,jr->rij", PHI, PHI)
    whole = rb.theory.modal_terms(LINES, OMEGA, np.full(N, 0.01), A)
    np.testing.assert_array_equal(whole[:, :, 2, 4], rb.theory.modal_terms(LINES, OMEGA, 0.01, A[:, 2, 4]))
    assert whole.shape == (len(LINES), N, N, N)


def test_complex_modes_give_the_receptance_of_any_viscous_damping() -> None:
    system = rb.theory.chain(np.diag(CHAIN.M), RNG.uniform(1, 5, N + 1) * 1e5, [0, 300.0, 0, 0, 40.0, 0, 0])
    p, psi = rb.theory.residue_shapes(system)
    R = np.einsum("ir,jr->rij", psi, psi)
    expected = system.receptance(LINES)
    np.testing.assert_allclose(
        rb.theory.pole_terms(LINES, p, R).sum(axis=1), expected, atol=1e-10 * np.abs(expected).max()
    )
    # at very high frequency only masses move: what falls with 1 / s cancels
    assert np.abs(R.sum(axis=0).real).max() < 1e-12 * np.abs(R).max()


def test_residues_of_real_modes_are_the_modal_constants_over_2i_times_the_damped_frequency() -> None:
    p, psi = rb.theory.residue_shapes(proportional(0.02))
    damped = OMEGA * np.sqrt(1 - 0.02**2)
    np.testing.assert_allclose(p, -0.02 * OMEGA + 1j * damped, rtol=1e-9)
    R = np.einsum("ir,jr->rij", psi, psi)
    np.testing.assert_allclose(R, np.einsum("ir,jr->rij", PHI, PHI) / (2j * damped)[:, None, None], atol=1e-12)


def test_the_response_vanishes_at_every_antiresonance() -> None:
    for i, j in ((0, 0), (2, 2), (0, 1), (1, 4), (0, 5)):
        A = PHI[i] * PHI[j]
        zeros = rb.theory.antiresonances(OMEGA, A)
        terms = rb.theory.modal_terms(zeros, OMEGA, 0.0, A)
        assert (np.abs(terms.sum(axis=1)) < 1e-9 * np.abs(terms).max(axis=1)).all()


def test_at_a_driving_point_they_are_the_resonances_of_the_system_held_there() -> None:
    for i in range(N):
        rest = np.delete(np.arange(N), i)
        held = rb.hertz(np.sqrt(linalg.eigh(CHAIN.K[np.ix_(rest, rest)], CHAIN.M[np.ix_(rest, rest)])[0]))
        zeros = rb.theory.antiresonances(OMEGA, PHI[i] ** 2)
        np.testing.assert_allclose(zeros, held, rtol=1e-9)
        assert (zeros > rb.hertz(OMEGA[:-1])).all()
        assert (zeros < rb.hertz(OMEGA[1:])).all()


def test_from_end_to_end_of_a_chain_there_is_none() -> None:
    # H_1n is the product of the springs between over a polynomial: it never vanishes
    assert len(rb.theory.antiresonances(OMEGA, PHI[0] * PHI[-1])) == 0


def test_from_mass_i_to_mass_j_there_are_as_many_as_masses_outside() -> None:
    # the numerator of H_ij is the determinant of what lies left of i times that of what lies right of j
    for i, j in ((0, 2), (1, 3), (2, 5)):
        assert len(rb.theory.antiresonances(OMEGA, PHI[i] * PHI[j])) == i + (N - 1 - j)


def test_a_residual_moves_the_zeros_and_a_complete_one_holds_the_static_point() -> None:
    # two modes and a spring in place of the others: the zeros of the sum, found on a fine grid
    A, kept = PHI[0] ** 2, 2
    residual = float(np.sum(A[kept:] / OMEGA[kept:] ** 2))
    zeros = rb.theory.antiresonances(OMEGA[:kept], A[:kept], residual)
    H = rb.theory.modal_terms(zeros, OMEGA[:kept], 0.0, A[:kept])
    assert (np.abs(H.sum(axis=1) + residual) < 1e-9 * np.abs(H).max(axis=1)).all()
    assert len(zeros) == kept
    static = rb.theory.modal_terms([0.0], OMEGA[:kept], 0.0, A[:kept]).sum() + residual
    assert static == pytest.approx(linalg.inv(CHAIN.K)[0, 0], rel=1e-12)


def test_what_a_user_can_get_wrong_is_said() -> None:
    with pytest.raises(ValueError, match="first axis must have 6"):
        rb.theory.modal_terms(LINES, OMEGA, 0.0, PHI[0, :3])
    with pytest.raises(ValueError, match="first axis must have 1"):
        rb.theory.pole_terms(LINES, [-1 + 5j], [1, 2])
    with pytest.raises(ValueError, match="one constant for each mode"):
        rb.theory.antiresonances(OMEGA, PHI[0, :3])
    with pytest.raises(ValueError, match="vanishes at all"):
        rb.theory.antiresonances(OMEGA, 0 * OMEGA)
    with pytest.raises(ValueError, match="K is not symmetric"):
        rb.theory.normal_modes(np.eye(2), [[1, 2], [0, 1]])
    with pytest.raises(ValueError, match="positive definite"):
        rb.theory.normal_modes(np.diag([1.0, 0.0]), np.eye(2))
    with pytest.raises(ValueError, match="do not swing"):
        rb.theory.residue_shapes(rb.theory.chain([1, 1], [1, 1, 1], [50, 50, 50]))
    with pytest.raises(ValueError, match="double pole"):
        rb.theory.residue_shapes(rb.System(np.eye(2), 0.1 * np.eye(2), np.eye(2)))
    with pytest.raises(ValueError, match=r"C \+ G is not symmetric"):
        rb.theory.residue_shapes(
            rb.System(np.eye(2), np.zeros((2, 2)), np.diag([1.0, 2]), np.array([[0, 1.0], [-1, 0]]))
        )
