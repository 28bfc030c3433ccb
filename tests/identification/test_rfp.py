"""Rational fraction polynomials, the bases they are written in, and partial fractions (equations 66-74)."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound.identification import fit_fraction, orthogonal_basis, power_basis
from rbfound.theory import expanded, partial_fractions, ratio

DATA = Path(__file__).parents[2] / "data" / "foundation"
LINES = np.arange(20.0, 1000.25, 1.0)
F_N = np.array([62.0, 150.0, 187.0, 330.0, 480.0, 640.0, 871.0])
ZETA = np.array([0.016, 0.013, 0.0105, 0.01, 0.018, 0.019, 0.016])
PHI = 0.1 * np.random.default_rng(1).standard_normal((4, 7))
CLASSIC = {"relative": False, "leading": True, "iterations": 0}


def known(modes=7):
    """The first few of seven real modes that are known."""
    return rb.modal_foundation(PHI[:, :modes], rb.from_hertz(F_N[:modes]), ZETA[:modes])


def poles_of(modes=7):
    """-zeta omega + i omega sqrt(1 - zeta^2), written out once more."""
    return rb.from_hertz(F_N[:modes]) * (-ZETA[:modes] + 1j * np.sqrt(1 - ZETA[:modes] ** 2))


def noisy(frf, level, seed=0):
    """Complex normal errors, independent of one another, of a standard deviation relative to each |H|."""
    e = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j]
    return rb.FRF(frf.frequency, frf.H * (1 + level * e / np.sqrt(2)), frf.labels)


def upper(roots):
    """One of each pair, ascending."""
    roots = roots[roots.imag > 0]
    return roots[np.argsort(np.abs(roots))]


# The bases


@pytest.mark.parametrize("degree", [4, 16, 30])
def test_the_polynomials_are_orthonormal_on_the_lines_under_their_weight(degree):
    x = LINES / LINES[-1]
    for weight in (np.ones_like(x), np.sum(np.abs(known().frf(LINES).H) ** 2, axis=(1, 2)) * 1e12):
        P = orthogonal_basis(x, weight, degree).values(1j * x)
        gram = ((P.conj() * weight) @ P.T).real
        # thirty steps of a recurrence, each with its rounding
        np.testing.assert_allclose(gram, np.eye(degree + 1), atol=1e-9)


def test_each_polynomial_is_of_its_degree_and_even_or_odd_as_that_is():
    x = LINES / LINES[-1]
    basis = orthogonal_basis(x, 1 + x, 7)
    s = np.array([0.3j, 0.2 + 0.1j])
    at, mirrored = basis.values(s), basis.values(-s)
    np.testing.assert_allclose(mirrored, (-1.0) ** np.arange(8)[:, None] * at, rtol=1e-12)
    # real coefficients: the conjugate at the conjugate
    np.testing.assert_allclose(basis.values(s.conj()), at.conj(), rtol=1e-12)
    far = basis.values([1e6, 2e6])
    np.testing.assert_allclose(far[:, 1] / far[:, 0], 2.0 ** np.arange(8), rtol=1e-9)


def test_the_power_basis_holds_powers():
    s = np.array([0.5 + 0.1j, 2.0])
    np.testing.assert_allclose(power_basis(4).values(s), s ** np.arange(5)[:, None], rtol=1e-15)


def test_the_roots_from_the_comrade_matrix_are_those_that_the_polynomial_was_made_of():
    x = np.linspace(0.1, 1, 200)
    wanted = np.array([-0.01 + 0.3j, -0.02 + 0.8j, -0.4 + 0.1j])
    wanted = np.concatenate([wanted, wanted.conj()])
    for basis in (power_basis(6), orthogonal_basis(x, 1 / x, 6)):
        # coefficients by interpolation: the polynomial is known at seven points
        points = np.exp(2j * np.pi * np.arange(7) / 7)
        values = np.prod(points[:, None] - wanted, axis=1)
        c = np.linalg.solve(basis.values(points).T, values)
        np.testing.assert_allclose(c.imag, 0, atol=1e-12 * np.abs(c).max())
        found = basis.roots(c.real)
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(wanted), rtol=1e-10)


def test_too_few_lines_for_the_degree_are_an_error():
    with pytest.raises(ValueError, match="3 lines cannot tell 9 polynomials apart"):
        orthogonal_basis([0.1, 0.2, 0.3], np.ones(3), 8)


# The fit


@pytest.mark.parametrize("way", [CLASSIC, {"iterations": 0}, {}])
def test_exact_rational_data_come_back_as_well_as_the_condition_number_allows(way):
    fit = fit_fraction(known().frf(LINES), 7, extra=0, **way)
    # QR is backward stable: rounding times the condition number, times the root of some hundred columns
    rounding = 10 * fit.condition * np.finfo(float).eps
    assert rounding < 1e-7
    np.testing.assert_allclose(upper(fit.poles), poles_of(), rtol=rounding)
    elsewhere = np.array([33.3, 150.0, 777.7])
    expected = known().frf(elsewhere).H
    # at resonance H = 1 / (2 zeta ...): a shift of a pole counts 1 / (2 zeta) times
    atol = rounding / (2 * ZETA.min()) * np.abs(expected).max()
    np.testing.assert_allclose(fit.frf(elsewhere).H, expected, rtol=0, atol=atol)


def test_exact_data_come_back_as_a_foundation_to_1e_8():
    made = rb.identification.rational_fraction(known().frf(LINES), 7, extra=0)
    expected = known().frf(LINES).H
    np.testing.assert_allclose(made.frf(LINES).H, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("modes", [1, 2, 4])
def test_at_low_order_both_bases_give_the_same_poles(modes):
    frf = noisy(known(5).frf(LINES), 0.01)
    a, b = (fit_fraction(frf, modes, extra=0, basis=basis, **CLASSIC) for basis in ("power", "orthogonal"))
    # a condition number of 1e4 costs four digits of sixteen
    np.testing.assert_allclose(np.sort_complex(a.poles), np.sort_complex(b.poles), rtol=1e-9)


def test_the_condition_number_grows_with_each_mode_in_powers_and_not_in_orthogonal_polynomials():
    frf = noisy(known().frf(LINES), 0.01)
    power, orthogonal = (
        [fit_fraction(frf, m, extra=0, basis=basis, **CLASSIC).condition for m in (2, 4, 6, 8, 10)]
        for basis in ("power", "orthogonal")
    )
    # about a factor of ten a mode; 1e10 is where the normal equations, with its square, hold no digit
    assert all(b > 20 * a for a, b in pairwise(power))
    assert power[-1] > 1e9
    # at 1 % of noise the data themselves tell N from H D by about that much
    assert max(orthogonal) < 1e3


def test_the_condition_number_is_that_of_the_matrix_written_out():
    frf = known(2).frf(LINES[::50])
    one = rb.FRF(frf.frequency, frf.H[:, :1, :1], ("x1",))
    fit = fit_fraction(one, 2, extra=0, basis="power", **CLASSIC)
    s = 1j * frf.frequency[:, None] / frf.frequency[-1]
    H = one.H[:, :, 0] / np.abs(one.H).max()
    columns = np.hstack([s ** np.arange(7), -H * s ** np.arange(4)])
    written = np.linalg.cond(np.vstack([columns.real, columns.imag]))
    assert fit.condition == pytest.approx(written, rel=1e-6)


def test_noise_pulls_the_poles_when_one_coefficient_measures_d_and_not_when_all_do():
    # equation error once, relative noise of 2 %, mean of four seeds: measured 13 % and 0.08 % of a frequency
    frfs = [noisy(known(2).frf(np.arange(20.0, 400.0, 0.5)), 0.02, seed) for seed in range(4)]
    apart = {}
    for leading in (True, False):
        fits = [fit_fraction(frf, 2, extra=0, iterations=0, leading=leading) for frf in frfs]
        nearest = [[np.abs(fit.poles - pole).min() / abs(pole) for pole in poles_of(2)] for fit in fits]
        apart[leading] = np.mean(nearest, axis=0).max()
    assert apart[True] > 0.05
    assert apart[False] < 0.01


def test_iterated_weights_bring_two_modes_within_a_ten_thousandth_at_2_per_cent_noise():
    # 760 lines of 16 FRFs: what a maximum-likelihood fit could do is about 1e-5
    frf = noisy(known(2).frf(np.arange(20.0, 400.0, 0.5)), 0.02)
    fit = fit_fraction(frf, 2, extra=0)
    np.testing.assert_allclose(np.abs(upper(fit.poles)), np.abs(poles_of(2)), rtol=1e-4)
    assert 1 < fit.iterations <= 11


def test_the_solid_foundation_at_1_per_cent_noise_is_met_within_a_tenth_of_a_per_cent():
    data = rb.load_frf(DATA / "fine")
    truth = rb.load_foundation(DATA / "truth.npz").modes().below(1000)
    for seed in range(2):
        found = rb.identification.rational_fraction(noisy(data, 0.01, seed), 8, band=(20, 1000)).modes().below(1000)
        # the two modes at 760 and 762 Hz are nearer than they are wide: measured 0.08 %, and 2 % of damping
        np.testing.assert_allclose(found.frequency, truth.frequency, rtol=2e-3)
        np.testing.assert_allclose(found.damping, truth.damping, rtol=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_whatever_the_noise_the_foundation_is_reciprocal_and_passive(seed):
    made = rb.identification.rational_fraction(noisy(known().frf(LINES[::10]), 0.3, seed), 5)
    assert made.asymmetry() == 0
    assert min(made.definiteness().values()) >= 0
    H = made.frf(np.geomspace(0.1, 1e5, 100)).H
    worst = np.linalg.eigvalsh(H.imag)[:, -1]
    assert (worst <= 1e-12 * np.abs(H).max(axis=(1, 2))).all()


def test_roots_that_are_no_modes_are_dropped_and_named():
    made = rb.identification.rational_fraction(noisy(known(3).frf(LINES), 0.01), 3, extra=3)
    assert len(made.modes().below(1000).poles) == 3
    np.testing.assert_allclose(made.modes().below(1000).frequency, F_N[:3], rtol=2e-3)
    assert "3 + 3 modes" in made.notes[0]
    assert "dropped: none" not in made.notes[0]


def test_the_unit_of_the_data_does_not_move_the_poles():
    frf = noisy(known().frf(LINES), 0.01)
    # a power of two: every number on the way is the same but for its exponent
    a, b = (fit_fraction(rb.FRF(LINES, k * frf.H), 7).poles for k in (1, 1024))
    np.testing.assert_allclose(a, b, rtol=1e-12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"modes": 0}, "modes is 0"),
        ({"modes": 2, "extra": -1}, "extra -1"),
        ({"modes": 2, "basis": "legendre"}, r"basis is 'legendre': it must be \"orthogonal\" or \"power\""),
        ({"modes": 500}, r"981 lines are too few for 500 \+ 2 modes: 1006 are the least"),
        ({"modes": 2, "band": (2000, 3000)}, "lies outside the FRFs"),
    ],
)
def test_what_cannot_be_fitted_is_an_error_that_says_so(wrong, message):
    with pytest.raises(ValueError, match=message):
        rb.identification.rational_fraction(known().frf(LINES), **wrong)


def test_frfs_that_are_zero_are_an_error():
    with pytest.raises(ValueError, match="nothing moves"):
        rb.identification.rational_fraction(rb.FRF(LINES, np.zeros((len(LINES), 4, 4))), 2)


# Partial fractions

A = np.einsum("ir,jr->rij", PHI, PHI)
OMEGA = rb.from_hertz(F_N)


def test_equations_66_67_and_74_are_one_function():
    expected = known().frf(LINES).H
    np.testing.assert_allclose(
        expanded(A, OMEGA, ZETA).receptance(LINES), expected, rtol=0, atol=1e-13 * np.abs(expected).max()
    )
    # in units of s in which omega is about one
    unit = rb.from_hertz(500.0)
    N, D = ratio(A / unit**2, OMEGA / unit, ZETA)
    s = 1j * rb.from_hertz(LINES) / unit
    straight = np.polynomial.polynomial.polyval(s, N) / np.polynomial.polynomial.polyval(s, D)
    np.testing.assert_allclose(np.moveaxis(straight, -1, 0), expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_a_ratio_of_polynomials_comes_apart_into_the_modes_that_it_was_made_of():
    unit = rb.from_hertz(500.0)
    parts = partial_fractions(*ratio(A, OMEGA / unit, ZETA))
    b1, b0, c, k = parts.blocks()
    # fourteen roots through power coefficients: five digits are lost
    np.testing.assert_allclose(np.sqrt(k) * unit, OMEGA, rtol=1e-9)
    np.testing.assert_allclose(c / (2 * np.sqrt(k)), ZETA, rtol=1e-7)
    np.testing.assert_allclose(b0, A, atol=1e-8 * np.abs(A).max())
    np.testing.assert_allclose(b1, 0, atol=1e-8 * np.abs(A).max())
    direct = expanded(A, OMEGA / unit, ZETA)
    np.testing.assert_allclose(parts.D, direct.D, rtol=1e-8)
    np.testing.assert_allclose(parts.B, direct.B, atol=1e-8 * np.abs(direct.B).max())


def test_equation_71_as_printed_is_not_the_mode_and_as_corrected_it_is():
    omega, zeta, s = 1000.0, 0.02, 900j
    mode = 1 / (omega**2 + 2 * zeta * omega * s + s**2)
    damped = omega * np.sqrt(1 - zeta**2)
    d, a = zeta * omega + 1j * damped, 1j / (2 * damped)
    assert a / (s + d) - a / (s + np.conj(d)) == pytest.approx(mode, rel=1e-12)
    assert abs(a / (s + d) + a / (s + d) - mode) > 0.5 * abs(mode)


def test_free_motions_stand_apart_as_1_over_s_squared():
    parts = expanded(A[:3], OMEGA[:3], ZETA[:3], free=A[4])
    unit = rb.from_hertz(100.0)
    N, D = ratio(A[:3], OMEGA[:3] / unit, ZETA[:3])
    # A4 / s^2 + N / D over s^2 D
    over = np.zeros((len(N) + 2, 4, 4))
    over[2:] += N
    over += np.multiply.outer(D, A[4])
    again = partial_fractions(over, np.concatenate([[0, 0], D]))
    np.testing.assert_allclose(again.A, A[4], rtol=1e-10)
    f = np.array([10.0, 61.0, 300.0])
    np.testing.assert_allclose(again.receptance(rb.hertz(f / 100)) / unit**2, parts.receptance(f), rtol=1e-7)


def test_a_numerator_of_higher_degree_leaves_a_polynomial():
    # (s^3 + 2) / (s^2 + s + 1) = s - 1 + 3 / (s^2 + s + 1)
    parts = partial_fractions([2, 0, 0, 1], [1, 1, 1])
    np.testing.assert_allclose(parts.whole, [-1, 1], rtol=1e-14)
    b1, b0, c, k = parts.blocks()
    np.testing.assert_allclose([b1[0], b0[0], c[0], k[0]], [0, 3, 1, 1], atol=1e-14)
    s = 1j * rb.from_hertz(0.1)
    assert parts.receptance(0.1)[0] == pytest.approx((s**3 + 2) / (s**2 + s + 1), rel=1e-13)


def test_two_real_roots_make_a_real_block():
    # 1 / ((s + 1)(s + 3))
    b1, b0, c, k = partial_fractions([1], [3, 4, 1]).blocks()
    np.testing.assert_allclose([b1[0], b0[0], c[0], k[0]], [0, 1, 4, 3], atol=1e-14)


def test_a_fitted_fraction_in_powers_of_s_comes_apart_too():
    fit = fit_fraction(known(3).frf(LINES), 3, extra=0, basis="power")
    parts = partial_fractions(fit.c, fit.d)
    np.testing.assert_allclose(upper(-parts.D) * fit.scale, poles_of(3), rtol=1e-8)
    f = np.array([50.0, 155.0, 600.0])
    expected = known(3).frf(f).H
    found = parts.receptance(f / fit.scale)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("N", "D", "message"),
    [
        ([1], [1, 2], "needs three at least"),
        ([1], [1, 2, 0], "last must not be zero"),
        ([1], [1, 2, 1], "double root at -1"),
        ([1], [0, 1, 1], "1 roots at zero"),
        ([1], [1, 3, 3.5, 1.7], "real roots"),
        ([1, 5], [0, 0, 2, 1, 1], "a term in 1 / s"),
    ],
)
def test_a_ratio_that_has_no_such_fractions_is_an_error(N, D, message):
    with pytest.raises(ValueError, match=message):
        partial_fractions(N, D)


def test_modes_that_do_not_swing_and_shapes_that_disagree_are_errors():
    with pytest.raises(ValueError, match=r"largest damping ratio is 1\.2"):
        expanded([1.0], [100.0], [1.2])
    with pytest.raises(ValueError, match="first axes must agree"):
        expanded([1.0, 2.0], [100.0], [0.1])
