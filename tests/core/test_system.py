"""Second-order systems: damped modes, receptance, MAC."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial
from scipy import linalg

import rbfound as rb

ZERO3 = np.zeros((3, 3))
CHAIN = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])  # three masses, two springs, no wall


def any_system(n, gyroscopic=True, seed=7):
    """Positive definite M and K, a C of a few percent, a skew G: everything full."""
    rng = np.random.default_rng(seed)

    def definite():
        A = rng.standard_normal((n, n))
        return A @ A.T + n * np.eye(n)

    skew = rng.standard_normal((n, n))
    M, K = definite(), 1e4 * definite()
    return rb.System(M, 0.5 * definite(), K, (20.0 if gyroscopic else 0.0) * (skew - skew.T))


def upper(poles):
    """Poles with Im > 0, ascending."""
    return np.sort_complex(poles[poles.imag > 1e-9])[np.argsort(np.sort_complex(poles[poles.imag > 1e-9]).imag)]


def test_the_poles_of_two_masses_are_the_roots_of_their_characteristic_polynomial():
    # ground - (k1, c1) - m1 - (k2, c2) - m2:
    # (m1 s^2 + (c1 + c2) s + k1 + k2)(m2 s^2 + c2 s + k2) - (c2 s + k2)^2 = 0
    m1, m2, c1, c2, k1, k2 = 3.0, 1.2, 4.0, 2.5, 5e3, 2e3
    roots = (
        Polynomial([k1 + k2, c1 + c2, m1]) * Polynomial([k2, c2, m2]) - Polynomial([k2, c2]) * Polynomial([k2, c2])
    ).roots()
    modes = rb.System(
        np.diag([m1, m2]), np.array([[c1 + c2, -c2], [-c2, c2]]), np.array([[k1 + k2, -k2], [-k2, k2]])
    ).modes()
    # a quartic with simple roots: both roads are good to some 1e-13 of the largest root
    np.testing.assert_allclose(modes.poles, upper(roots), rtol=1e-11)
    np.testing.assert_allclose(modes.frequency, upper(roots).imag / (2 * np.pi), rtol=1e-11)
    np.testing.assert_allclose(modes.damping, -upper(roots).real / np.abs(upper(roots)), rtol=1e-9)


def test_proportional_damping_gives_the_ratio_of_its_closed_form():
    # C = a M + b K  =>  zeta = a / (2 omega) + b omega / 2, omega from the undamped problem (scipy.linalg.eigh)
    a, b = 3.0, 2e-4
    base = any_system(5)
    omega = np.sqrt(linalg.eigvalsh(base.K, base.M))
    modes = rb.System(base.M, a * base.M + b * base.K, base.K).modes()
    zeta = a / (2 * omega) + b * omega / 2
    np.testing.assert_allclose(modes.damping, zeta, rtol=1e-9)
    np.testing.assert_allclose(modes.frequency, omega * np.sqrt(1 - zeta**2) / (2 * np.pi), rtol=1e-10)


@pytest.mark.parametrize("gyroscopic", [False, True])
@pytest.mark.parametrize("n", [1, 4, 9])
def test_the_modes_are_those_of_the_generalised_first_order_pencil(n, gyroscopic):
    # another formulation: [0 I; -K -(C+G)] z = lambda [I 0; 0 M] z by the QZ algorithm, M never factored
    s = any_system(n, gyroscopic, seed=n)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-s.K, -(s.C + s.G)]])
    E = linalg.block_diag(np.eye(n), s.M)
    poles = upper(linalg.eigvals(A, E))
    modes = s.modes()
    assert len(modes.poles) == n
    np.testing.assert_allclose(modes.poles, poles, atol=1e-9 * np.abs(poles).max(), rtol=0)


def test_a_mode_shape_solves_the_quadratic_eigenvalue_problem():
    s = any_system(6)
    modes = s.modes()
    assert len(modes.poles) == 6
    for pole, shape in zip(modes.poles, modes.shapes.T, strict=True):
        terms = [pole**2 * s.M @ shape, pole * (s.C + s.G) @ shape, s.K @ shape]
        assert np.linalg.norm(sum(terms)) < 1e-10 * max(np.linalg.norm(term) for term in terms)


def test_the_largest_entry_of_a_mode_shape_is_one():
    shapes = any_system(6).modes().shapes
    np.testing.assert_allclose(np.abs(shapes).max(axis=0), 1.0, rtol=1e-12)
    np.testing.assert_allclose(shapes[np.abs(shapes).argmax(axis=0), np.arange(6)], 1.0, rtol=1e-12)


def test_modes_ascend_in_frequency_and_keep_their_own_damping():
    # three oscillators, two with one damped frequency: omega_d = omega sqrt(1 - zeta^2)
    omega, zeta = np.array([10.0, 10.0, 5.0]), np.array([0.2, 0.1, 0.3])
    omega[0] = 10.0 * np.sqrt(1 - 0.1**2) / np.sqrt(1 - 0.2**2)
    modes = rb.System(np.eye(3), np.diag(2 * zeta * omega), np.diag(omega**2)).modes()
    np.testing.assert_allclose(modes.poles.imag, [5 * np.sqrt(1 - 0.09), *[10 * np.sqrt(0.99)] * 2], rtol=1e-12)
    np.testing.assert_allclose([modes.damping[0], *sorted(modes.damping[1:])], [0.3, 0.1, 0.2], rtol=1e-12)


def test_a_rigid_body_mode_is_an_exact_zero_and_counted_once():
    # a free chain 1 - 1 - 1 kg with k = 1: omega^2 = 0, 1, 3
    modes = rb.System(np.eye(3), ZERO3, CHAIN).modes()
    assert len(modes.poles) == 3
    assert modes.poles[0] == 0
    assert modes.frequency[0] == 0
    assert modes.damping[0] == 0
    np.testing.assert_allclose(modes.poles.imag[1:], [1.0, np.sqrt(3.0)], rtol=1e-12)
    np.testing.assert_allclose(modes.shapes[:, 0], 1.0, rtol=1e-6)


def test_a_free_shaft_has_four_rigid_body_modes():
    # a shift and a tilt in each of two planes
    modes = rb.Rotor(rb.Shaft([1.0], [0.1])).at(0.0).modes()
    assert (modes.poles == 0).sum() == 4
    assert modes.frequency[4] > 100


def test_a_rigid_body_mode_held_by_a_damper_alone_is_a_zero_and_a_decay():
    # m x'' + c x' = 0: lambda = 0 and -c/m
    poles = rb.System([[2.0]], [[6.0]], [[0.0]]).modes().poles
    assert sorted(poles.real) == pytest.approx([-3.0, 0.0], abs=1e-12)
    assert (poles == 0).sum() == 1


def test_every_rigid_body_mode_held_by_a_damper_alone_keeps_its_zero():
    # two masses, each on a damper and no spring: lambda = 0, -1 and 0, -2: "a rigid-body mode is one zero"
    poles = rb.System(np.eye(2), np.diag([1.0, 2.0]), np.zeros((2, 2))).modes().poles
    np.testing.assert_allclose(np.sort(poles.real), [-2.0, -1.0, 0.0, 0.0], atol=1e-12)


def test_the_shapes_of_rigid_body_modes_span_the_rigid_motions():
    # four shapes, linearly independent, none of which K feels; eigenvectors of a defective zero come in equal pairs
    for speed in (0.0, 500.0):
        system = rb.Rotor(rb.Shaft([1.0], [0.02]), element=0.02).at(speed)
        modes = system.modes()
        rigid = modes.shapes[:, modes.poles == 0]
        assert rigid.shape[1] == 4
        rigid = rigid / np.linalg.norm(rigid, axis=0)
        assert np.linalg.svd(rigid, compute_uv=False)[-1] > 1e-3
        assert np.abs(system.K @ rigid).max() < 1e-6 * np.abs(system.K).max()


def test_both_poles_of_an_overdamped_mode_stand_alone_at_no_frequency():
    # s^2 + 5 s + 4 = (s + 1)(s + 4), beside an oscillator of 3 rad/s
    modes = rb.System(np.eye(2), np.diag([5.0, 0.0]), np.diag([4.0, 9.0])).modes()
    np.testing.assert_allclose(np.sort(modes.poles.real[:2]), [-4.0, -1.0], rtol=1e-12)
    np.testing.assert_allclose(modes.frequency, [0.0, 0.0, 3.0 / (2 * np.pi)], rtol=1e-12)
    np.testing.assert_allclose(modes.damping[:2], 1.0)


def test_modes_above_a_frequency_leave_rigid_and_overdamped_ones_out():
    modes = rb.System(np.eye(3), np.diag([5.0, 0.0, 0.0]), np.diag([4.0, 900.0, 0.0])).modes()
    kept = modes.above(1.0)
    # all at frequency 0: the rigid one first (damping 0), then the two poles of the overdamped one (damping 1)
    np.testing.assert_allclose(modes.damping, [0.0, 1.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(kept.frequency, [30 / (2 * np.pi)])
    assert kept.shapes.shape == (3, 1)
    assert abs(kept.shapes[1, 0]) == 1


def test_gyroscopic_forces_take_no_energy():
    # with C = 0 and K > 0 every pole lies on the imaginary axis, whatever G
    s = any_system(6)
    modes = rb.System(s.M, np.zeros((6, 6)), s.K, 50 * s.G).modes()
    assert len(modes.poles) == 6
    assert np.abs(modes.damping).max() < 1e-10


def test_a_negative_damper_gives_a_negative_damping_ratio():
    # zeta = c / (2 sqrt(k m)) = -0.1
    assert rb.System([[1.0]], [[-0.4]], [[4.0]]).modes().damping == pytest.approx([-0.1], rel=1e-12)


def test_a_common_factor_of_all_matrices_changes_no_mode():
    s = any_system(4)
    scaled = rb.System(1e7 * s.M, 1e7 * s.C, 1e7 * s.K, 1e7 * s.G)
    np.testing.assert_allclose(scaled.modes().poles, s.modes().poles, rtol=1e-10)


def test_no_coordinates_have_no_modes():
    empty = np.zeros((0, 0))
    modes = rb.System(empty, empty, empty).modes()
    assert modes.frequency.shape == (0,)
    assert modes.shapes.shape == (0, 0)


def test_the_receptance_is_the_sum_over_the_modes():
    # proportional damping: H = sum phi phi^T / (omega_r^2 - omega^2 + 2 i zeta omega_r omega), phi^T M phi = 1
    base = any_system(5)
    C = 2e-4 * base.K
    values, Phi = linalg.eigh(base.K, base.M)
    omega_r = np.sqrt(values)
    zeta = 1e-4 * omega_r
    frequency = np.array([0.0, 3.0, 11.7, 40.0])
    omega = 2 * np.pi * frequency[:, None]
    weights = 1 / (values - omega**2 + 2j * zeta * omega_r * omega)
    expected = np.einsum("ir,fr,jr->fij", Phi, weights, Phi)
    H = rb.System(base.M, C, base.K).receptance(frequency)
    np.testing.assert_allclose(H, expected, atol=1e-12 * np.abs(expected).max())


def test_a_gyroscopic_receptance_obeys_its_equation_of_motion():
    s = any_system(5)
    frequency = 4.2
    omega = 2 * np.pi * frequency
    H = s.receptance(frequency)
    assert H.shape == (1, 5, 5)
    np.testing.assert_allclose((s.K - omega**2 * s.M + 1j * omega * (s.C + s.G)) @ H[0], np.eye(5), atol=1e-11)
    assert np.abs(H[0] - H[0].T).max() > 1e-3 * np.abs(H).max()  # spin breaks reciprocity


def test_outputs_and_inputs_pick_rows_and_columns_of_the_receptance():
    s = any_system(5)
    frequency = [1.0, 2.0]
    whole = s.receptance(frequency)
    outputs, inputs = np.eye(5)[[3, 1]], np.eye(5)[:, [0]] * 2.0
    picked = s.receptance(frequency, outputs, inputs)
    assert picked.shape == (2, 2, 1)
    np.testing.assert_allclose(picked, 2 * whole[:, [3, 1]][:, :, [0]], rtol=1e-10)


def test_a_receptance_at_an_undamped_resonance_is_an_error_with_its_frequency():
    with pytest.raises(ValueError, match=r"singular at 0 Hz.*rigid-body"):
        rb.System([[1.0]], [[0.0]], [[0.0]]).receptance([0.0])


def test_a_matrix_of_another_size_is_named_with_its_shape():
    with pytest.raises(ValueError, match=r"C has shape \(3, 3\)"):
        rb.System(np.eye(2), ZERO3, np.eye(2))
    with pytest.raises(ValueError, match=r"M has shape \(2, 3\)"):
        rb.System(np.ones((2, 3)), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match=r"M has shape \(\)"):
        rb.System(1.0, 0.0, 1.0)


def test_an_entry_that_is_not_finite_is_named_with_its_place():
    K = np.eye(2)
    K[1, 0] = np.nan
    with pytest.raises(ValueError, match=r"K\[1, 0\] is nan"):
        rb.System(np.eye(2), np.zeros((2, 2)), K)
    with pytest.raises(ValueError, match=r"G\[0, 1\] is inf"):
        rb.System(np.eye(2), np.zeros((2, 2)), np.eye(2), np.array([[0.0, np.inf], [0.0, 0.0]]))


def test_a_mass_matrix_that_is_not_symmetric_is_an_error():
    with pytest.raises(ValueError, match="M is not symmetric"):
        rb.System(np.array([[1.0, 0.2], [0.0, 1.0]]), np.zeros((2, 2)), np.eye(2)).modes()


def test_a_massless_coordinate_is_an_error_that_says_how_small_the_eigenvalue_is():
    with pytest.raises(ValueError, match=r"not positive definite: its smallest eigenvalue is 0.*largest entry 4"):
        rb.System(np.diag([4.0, 0.0]), np.zeros((2, 2)), np.eye(2)).modes()


def test_a_negative_mass_is_an_error():
    with pytest.raises(ValueError, match="smallest eigenvalue is -1"):
        rb.System(np.diag([4.0, -1.0]), np.zeros((2, 2)), np.eye(2)).modes()


def test_a_system_keeps_the_arrays_that_it_was_given_unchanged():
    M, C, K = np.eye(2), np.zeros((2, 2)), np.diag([1.0, 4.0])
    rb.System(M, C, K).modes()
    np.testing.assert_array_equal(M, np.eye(2))
    np.testing.assert_array_equal(K, np.diag([1.0, 4.0]))


entries = st.floats(min_value=-10, max_value=10).map(lambda x: round(x, 3))


@settings(max_examples=60)
@given(arrays(float, (4, 3), elements=entries), st.floats(0.1, 10), st.floats(0, 6.28))
def test_the_mac_lies_between_0_and_1_and_ignores_length_and_phase(A, size, phase):
    # Cauchy-Schwarz; a complex factor of a column cancels
    once, again = rb.mac(A, A), rb.mac(A, size * np.exp(1j * phase) * A)
    assert once.shape == (3, 3)
    assert (once >= 0).all()
    assert (once <= 1 + 1e-12).all()
    np.testing.assert_allclose(once, again, atol=1e-12)
    present = np.abs(A).max(axis=0) > 0
    np.testing.assert_allclose(np.diag(once)[present], 1.0, rtol=1e-12)


def test_the_mac_is_the_squared_cosine_of_real_shapes():
    # 30 degrees apart: cos^2 = 3/4; 90 degrees: 0; a shape of zeros is like none
    A = np.array([[1.0], [0.0]])
    B = np.array([[np.cos(np.pi / 6), 0.0, 0.0], [np.sin(np.pi / 6), 1.0, 0.0]])
    np.testing.assert_allclose(rb.mac(A, B), [[0.75, 0.0, 0.0]], atol=1e-15)
