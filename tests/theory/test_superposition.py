"""Chains of masses (equations 4-6), and receptances out of modes (equations 34-49, 54-55) against their matrices."""

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


def test_two_masses_give_the_matrices_of_equation_6() -> None:
    system = rb.theory.chain([2.0, 3.0], [10.0, 20.0, 40.0], [1.0, 2.0, 4.0])
    np.testing.assert_array_equal(system.M, [[2, 0], [0, 3]])
    np.testing.assert_array_equal(system.C, [[3, -2], [-2, 6]])
    np.testing.assert_array_equal(system.K, [[30, -20], [-20, 60]])


def test_the_matrices_give_the_forces_of_newtons_law_mass_by_mass() -> None:
    # equations 4 and 5 with the wall springs pulling back: (5) is printed with +k3 x2 and +c3 x2'
    rng = np.random.default_rng(1)
    m, k, c, x, v = (rng.uniform(1, 9, size) for size in (5, 6, 6, 5, 5))
    system = rb.theory.chain(m, k, c)
    wall_to_wall = lambda u: np.concatenate([[0.0], u, [0.0]])  # noqa: E731
    pull = k * np.diff(wall_to_wall(x)) + c * np.diff(wall_to_wall(v))
    np.testing.assert_allclose(-(system.K @ x + system.C @ v), np.diff(pull), rtol=1e-13)


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_equal_masses_between_walls_have_the_frequencies_of_the_closed_form(n: int) -> None:
    # omega_r = 2 sqrt(k/m) sin(r pi / (2 (n + 1))), shapes sin(i r pi / (n + 1)) with norm sqrt(2 / (m (n + 1)))
    m, k = 3.0, 7e4
    system = rb.theory.chain([m] * n, [k] * (n + 1))
    omega, Phi = rb.theory.normal_modes(system.M, system.K)
    r = np.arange(1, n + 1)
    np.testing.assert_allclose(omega, 2 * np.sqrt(k / m) * np.sin(r * np.pi / (2 * (n + 1))), rtol=1e-12)
    expected = np.sqrt(2 / (m * (n + 1))) * np.sin(np.outer(r, r) * np.pi / (n + 1))
    np.testing.assert_allclose(np.abs(np.sum(m * Phi * expected, axis=0)), 1.0, rtol=1e-10)


def test_a_chain_without_walls_floats_and_one_with_one_wall_has_the_quarter_waves() -> None:
    m, k, n = 2.0, 5e3, 6
    free, fixed = rb.theory.chain([m] * n, [0, *[k] * (n - 1), 0]), rb.theory.chain([m] * n, [*[k] * n, 0])
    r = np.arange(n)
    omega = rb.theory.normal_modes(free.M, free.K)[0]
    # the rigid motion is the root of rounding: sqrt(eps) of the largest
    np.testing.assert_allclose(omega, 2 * np.sqrt(k / m) * np.sin(r * np.pi / (2 * n)), atol=1e-6 * omega[-1])
    quarter = 2 * np.sqrt(k / m) * np.sin((2 * r + 1) * np.pi / (2 * (2 * n + 1)))
    np.testing.assert_allclose(rb.theory.normal_modes(fixed.M, fixed.K)[0], quarter, rtol=1e-12)


def test_what_does_not_fit_together_is_said() -> None:
    with pytest.raises(ValueError, match=r"2 springs for 2 masses: it must be 3"):
        rb.theory.chain([1, 1], [1, 1])
    with pytest.raises(ValueError, match=r"2 dampers for 2 masses"):
        rb.theory.chain([1, 1], [1, 1, 1], [0, 0])
    with pytest.raises(ValueError, match=r"masses hold 0 kg"):
        rb.theory.chain([1, 0], [1, 1, 1])
    with pytest.raises(ValueError, match=r"springs hold -1"):
        rb.theory.chain([1, 1], [1, -1, 1])
