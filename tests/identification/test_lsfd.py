"""Residues at known poles, what lies outside the band, and the foundation that they make."""

from pathlib import Path

import numpy as np
import pytest

import rbfound as rb

DATA = Path(__file__).parents[2] / "data" / "foundation"
LINES = np.arange(20.0, 1000.25, 1.0)
F_N = np.array([62.0, 150.0, 187.0, 330.0, 480.0, 640.0, 871.0])
ZETA = np.array([0.016, 0.013, 0.0105, 0.01, 0.018, 0.019, 0.016])
PHI = 0.1 * np.random.default_rng(1).standard_normal((4, 9))


def known(f_n=F_N, zeta=ZETA):
    """Real modes that are known, with as many columns of PHI as there are frequencies."""
    return rb.modal_foundation(PHI[:, : len(f_n)], rb.from_hertz(f_n), np.broadcast_to(zeta, np.shape(f_n)))


def noisy(frf, level, seed=0):
    """Complex normal errors, independent of one another, of a standard deviation relative to each |H|."""
    e = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j]
    return rb.FRF(frf.frequency, frf.H * (1 + level * e / np.sqrt(2)), frf.labels)


def poles_of(f_n=F_N, zeta=ZETA):
    """-zeta omega + i omega sqrt(1 - zeta^2), written out once more."""
    return rb.from_hertz(f_n) * (-np.asarray(zeta) + 1j * np.sqrt(1 - np.asarray(zeta) ** 2))


def passive_everywhere(foundation):
    """Im H is negative semidefinite at every frequency, and nothing is asymmetric."""
    H = foundation.frf(np.geomspace(0.1, 1e5, 200)).H
    size = np.abs(H).max(axis=(1, 2))
    worst = np.linalg.eigvalsh(H.imag)[:, -1]
    return foundation.asymmetry() == 0 and (worst <= 1e-12 * size).all()


def test_exact_data_of_known_poles_give_the_residues_of_their_modes():
    # linear least squares of a consistent system: only rounding is left
    fit = rb.identification.fit_residues(known().frf(LINES), poles_of())
    for r, pole in enumerate(poles_of()):
        expected = np.outer(PHI[:, r], PHI[:, r])
        np.testing.assert_allclose(2j * pole.imag * fit.R[r], expected, atol=1e-10 * np.abs(expected).max())
    assert fit.misfit.max() < 1e-8
    np.testing.assert_allclose(fit.modal_constants, 2j * poles_of().imag[:, None, None] * fit.R)


def test_exact_data_come_back_as_a_foundation_to_1e_8():
    made = rb.identification.fit_residues(known().frf(LINES), poles_of()).foundation()
    elsewhere = np.array([1.0, 77.3, 555.5, 990.0])
    expected = known().frf(elsewhere).H
    np.testing.assert_allclose(made.frf(elsewhere).H, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_the_three_parts_of_a_sum_are_told_apart():
    # H = modes - L/w^2 + U + V w^2, put together here by hand
    rng = np.random.default_rng(4)
    L, U, V = (scale * (A + A.T) for scale, A in zip((1e-3, 1e-8, 1e-17), rng.standard_normal((3, 4, 4)), strict=True))
    w = rb.from_hertz(LINES)[:, None, None]
    fit = rb.identification.fit_residues(rb.FRF(LINES, known().frf(LINES).H - L / w**2 + U + V * w**2), poles_of())
    # each is one of seventeen columns; 1e-6 leaves room for how like the others they are
    for found, expected in ((fit.lower, L), (fit.upper[0], U), (fit.upper[1], V)):
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_a_static_remainder_is_what_a_mode_far_above_gives():
    f_n = np.array([150.0, 480.0, 20000.0])
    fit = rb.identification.fit_residues(known(f_n, 0.01).frf(LINES), poles_of(f_n[:2], [0.01, 0.01]), upper=1)
    spring = np.outer(PHI[:, 2], PHI[:, 2]) / rb.from_hertz(20000.0) ** 2
    # (1000 / 20000)^2 = 0.25 % is how far a constant is from such a mode
    np.testing.assert_allclose(fit.upper[0], spring, atol=5e-3 * np.abs(spring).max())


def test_two_terms_find_the_one_mode_above_the_band():
    f_n = np.array([150.0, 480.0, 2500.0])
    made = rb.identification.fit_residues(
        known(f_n, 0.01).frf(LINES), poles_of(f_n[:2], [0.01, 0.01]), upper=3
    ).foundation()
    # of the pseudo-modes, the one that gives way most; the others are what a series of three terms leaves
    own = np.sqrt(np.diag(made.K))
    give = np.where(own > rb.from_hertz(1000), np.linalg.norm(made.B, axis=0) / own, 0)
    # the series runs in (f / 2500)^2, up to 0.16: its second coefficient is good to about 0.16^2
    assert abs(rb.hertz(own[give.argmax()]) / 2500 - 1) < 0.03
    # as good as three terms of that series
    np.testing.assert_allclose(made.frf(LINES).H, known(f_n, 0.01).frf(LINES).H, atol=2e-3 * np.abs(PHI).max() ** 2)


def test_modes_below_the_band_come_back_as_masses():
    f_n = np.array([5.0, 7.0, 150.0, 480.0])
    truth, poles = known(f_n, 0.01), poles_of(f_n[2:], [0.01, 0.01])
    fit = rb.identification.fit_residues(truth.frf(LINES), poles, band=(50, 1000))
    expected = PHI[:, :2] @ PHI[:, :2].T
    # (7 / 50)^2 = 2 % is what a free mass lacks of such modes at the band's lower edge
    np.testing.assert_allclose(fit.lower, expected, atol=0.03 * np.abs(expected).max())
    made = fit.foundation()
    low = made.modes().below(50)
    assert len(low.poles) == 2
    near = np.arange(60.0, 1000.0)
    error = np.abs(made.frf(near).H - truth.frf(near).H) / np.abs(truth.frf(near).H).max(axis=(1, 2))[:, None, None]
    assert error.max() < 0.05


def test_a_foundation_with_nothing_below_the_band_gets_no_mode_there():
    for level in (0.0, 0.05):
        made = rb.identification.fit_residues(noisy(known().frf(LINES), level), poles_of()).foundation()
        assert made.modes().frequency.min() > 60


@pytest.mark.parametrize("seed", range(5))
def test_whatever_the_noise_the_foundation_is_reciprocal_and_passive(seed):
    wild = noisy(known().frf(LINES[::20]), 0.5, seed)
    made = rb.identification.fit_residues(wild, poles_of()).foundation()
    assert passive_everywhere(made)
    assert made.definiteness()["M"] > 0
    assert min(made.definiteness().values()) >= 0


def test_the_residues_are_symmetric_though_the_data_are_not():
    fit = rb.identification.fit_residues(noisy(known().frf(LINES), 0.1), poles_of())
    for A in (*fit.R, fit.lower, *fit.upper):
        np.testing.assert_array_equal(A, A.T)
    assert fit.frf(LINES).reciprocity() == 0


def test_the_misfit_of_each_frf_is_the_noise_that_was_put_on_it():
    # 981 lines: the root mean square of noise has a standard deviation of 1 / (2 sqrt(981)) = 1.6 %; of each off the
    # diagonal both H_ij and H_ji count
    fit = rb.identification.fit_residues(noisy(known().frf(LINES), 0.03), poles_of())
    np.testing.assert_allclose(fit.misfit, 0.03, rtol=0.1)
    absolute = rb.identification.fit_residues(known().frf(LINES), poles_of(), relative=False)
    assert absolute.misfit.max() < 1e-10 * np.abs(known().frf(LINES).H).max()


def test_a_complex_mode_is_fitted_as_it_is_and_cut_with_a_note():
    turned = np.exp(0.2j) * np.outer(PHI[:, 0], PHI[:, 0])
    w, pole = rb.from_hertz(LINES), poles_of()[3]
    R = turned / (2j * pole.imag)
    H = R / (1j * w - pole)[:, None, None] + R.conj() / (1j * w - pole.conj())[:, None, None]
    fit = rb.identification.fit_residues(rb.FRF(LINES, H), [pole])
    np.testing.assert_allclose(fit.modal_constants[0], turned, atol=1e-9 * np.abs(turned).max())
    made = fit.foundation()
    # of exp(0.2 i) the sine is cut, 19.9 %
    assert "imaginary part was cut, at the most 20 % of one (330 Hz)" in " ".join(made.notes)
    np.testing.assert_allclose(np.abs(made.B[:, 0]), np.abs(PHI[:, 0]) * np.sqrt(np.cos(0.2)), rtol=1e-6)


def test_a_pole_whose_driving_points_give_energy_is_dropped_with_a_warning():
    # the second of three modes with its sign turned
    one, two, three = (
        rb.modal_foundation(PHI[:, [r]], rb.from_hertz(F_N[[r]]), ZETA[[r]]).frf(LINES).H for r in range(3)
    )
    fit = rb.identification.fit_residues(rb.FRF(LINES, one - two + three), poles_of(F_N[:3], ZETA[:3]))
    made = fit.foundation()
    assert "the pole at 150 Hz was dropped" in " ".join(made.notes)
    np.testing.assert_allclose(made.modes().below(1000).frequency, (F_N * np.sqrt(1 - ZETA**2))[[0, 2]], rtol=1e-9)
    assert passive_everywhere(made)


def test_data_with_their_sign_turned_are_an_error_that_names_the_cause():
    frf = known().frf(LINES)
    with pytest.raises(ValueError, match=r"None of the 7 residues is one of a real mode.*wrong way round"):
        rb.identification.fit_residues(rb.FRF(LINES, -frf.H), poles_of()).foundation()


def test_lscf_finds_known_modes_and_their_shapes():
    made = rb.identification.lscf(known().frf(LINES))
    inside = made.modes().below(1000)
    np.testing.assert_allclose(inside.frequency, F_N * np.sqrt(1 - ZETA**2), rtol=1e-3)
    np.testing.assert_allclose(inside.damping, ZETA, rtol=0.05)
    error = np.abs(made.frf(LINES).H - known().frf(LINES).H)
    # a peak is as wrong as its damping
    assert error.max() < 0.05 * np.abs(known().frf(LINES).H).max()
    assert passive_everywhere(made)


def test_lscf_of_the_solid_foundation_is_within_a_tenth_of_a_per_cent_at_1_per_cent_noise():
    data = rb.load_frf(DATA / "fine")
    truth = rb.load_foundation(DATA / "truth.npz").modes().below(1000)
    made = rb.identification.lscf(noisy(data, 0.01), band=(20, 1000))
    found = made.modes().below(1000)
    np.testing.assert_allclose(found.frequency, truth.frequency, rtol=1e-3)
    # the sway at 160 Hz is high in few lines: measured 5 %
    np.testing.assert_allclose(found.damping, truth.damping, rtol=0.08)


def test_a_hundred_lines_are_enough_for_all_eight_modes_and_twenty_are_not():
    truth = rb.load_foundation(DATA / "truth.npz").modes().below(1000)
    found = rb.identification.lscf(rb.load_frf(DATA / "medium")).modes().below(1000)
    np.testing.assert_allclose(found.frequency, truth.frequency, rtol=1e-3)
    with pytest.raises(ValueError, match=r"No stable pole between 25 and 500 Hz.*finer lines"):
        rb.identification.lscf(rb.load_frf(DATA / "coarse"))


def test_the_unit_of_the_data_is_the_unit_of_the_fit():
    frf = noisy(known().frf(LINES), 0.02)
    a, b = (rb.identification.fit_residues(rb.FRF(LINES, k * frf.H), poles_of()) for k in (1, 1000))
    np.testing.assert_allclose(b.R, 1000 * a.R, rtol=1e-7, atol=1e-9 * np.abs(b.R).max())
    np.testing.assert_allclose(a.misfit, b.misfit, rtol=1e-9)


@pytest.mark.parametrize(
    ("poles", "message"),
    [
        ([1 + 100j], r"One pole is 1\+100j rad/s: give one of each pair"),
        ([-1 - 100j], "with Re < 0 and Im > 0"),
        ([], "at least one finite"),
        ([-1 + 100j, -1 + 100j], "is given twice"),
        ([np.nan], "at least one finite"),
    ],
)
def test_a_pole_that_is_none_is_an_error(poles, message):
    with pytest.raises(ValueError, match=message):
        rb.identification.fit_residues(known().frf(LINES), poles)


def test_too_few_lines_and_a_negative_number_of_terms_are_errors():
    with pytest.raises(ValueError, match=r"5 lines from 20 to 24 Hz cannot tell 17 numbers of each FRF: 9 lines"):
        rb.identification.fit_residues(known().frf(LINES[:5]), poles_of())
    with pytest.raises(ValueError, match="upper is -1"):
        rb.identification.fit_residues(known().frf(LINES), poles_of(), upper=-1)
