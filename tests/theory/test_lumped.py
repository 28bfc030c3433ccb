"""Chains of masses (equations 4-6) against Newton's law mass by mass and the closed form of equal masses."""

import numpy as np
import pytest

import rbfound as rb


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
