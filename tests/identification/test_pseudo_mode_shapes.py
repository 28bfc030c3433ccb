"""The pseudo mode shape method and equivalent matrices (equations 57-64)."""

import warnings

import numpy as np
import pytest
from scipy import linalg

import rbfound as rb

LINES = np.arange(0.0, 600.5, 0.5)

# Four distinct modes, each seen best from another seat, the nearest two 72 % apart; SI: about 44 kg each.
PHI = 0.15 * np.array([[1.0, 0.1, 0.9, 0.15], [0.1, 1.0, -0.1, -0.8], [0.9, -0.1, -1.0, 0.1], [0.15, 0.9, 0.1, 1.0]])
F_N = np.array([90.0, 180.0, 310.0, 450.0])
ZETA = np.array([0.02, 0.015, 0.02, 0.01])


def known():
    return rb.equivalent_matrices(PHI, 2 * np.pi * F_N, ZETA)


FRFS = known().frf(LINES)


def coupled(foundation):
    """Frequencies below 1200 Hz of the rotor of thesis.py on a foundation, at rest."""
    frequency = rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=foundation).at(0.0).modes().above(1.0).frequency
    return frequency[frequency < 1200]


# --- equations 62-64 ---


def test_equivalent_matrices_are_diagonal_in_the_modes_they_were_made_of():
    # equations 62-64 turned round: Phi' M Phi = I, Phi' C Phi = diag(2 zeta omega), Phi' K Phi = diag(omega^2)
    f, omega = known(), 2 * np.pi * F_N
    for matrix, diagonal in ((f.M, np.ones(4)), (f.C, 2 * ZETA * omega), (f.K, omega**2)):
        np.testing.assert_allclose(PHI.T @ matrix @ PHI, np.diag(diagonal), atol=1e-12 * diagonal.max())
    np.testing.assert_array_equal(f.B, np.eye(4))


def test_equivalent_matrices_are_those_of_equations_62_to_64_by_plain_inversion():
    inverse, omega = np.linalg.inv(PHI), 2 * np.pi * F_N
    f = known()
    np.testing.assert_allclose(f.M, inverse.T @ inverse, rtol=1e-11)
    np.testing.assert_allclose(f.C, inverse.T @ np.diag(2 * ZETA * omega) @ inverse, rtol=1e-11)
    np.testing.assert_allclose(f.K, inverse.T @ np.diag(omega**2) @ inverse, rtol=1e-11)


def test_equivalent_matrices_are_symmetric_to_the_last_bit():
    for f in (known(), rb.thesis.unrounded_foundation()):
        for matrix in (f.M, f.C, f.K):
            np.testing.assert_array_equal(matrix, matrix.T)


def test_a_square_modal_foundation_and_its_equivalent_matrices_are_one_thing_to_the_seats():
    # two roads: coordinates q (M = I, B = Phi) and coordinates x = Phi q (B = I)
    modal = rb.modal_foundation(PHI, 2 * np.pi * F_N, ZETA)
    f = LINES[::50]
    np.testing.assert_allclose(known().frf(f).H, modal.frf(f).H, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(known().modes().poles, modal.modes().poles, rtol=1e-10)


def test_a_phi_that_is_not_square_is_sent_to_the_modal_foundation():
    with pytest.raises(ValueError, match=r"Phi is 4 x 7.*modal_foundation\(Phi, omega, zeta\) takes any number"):
        rb.equivalent_matrices(np.ones((4, 7)), np.ones(7), np.full(7, 0.02))


def test_a_phi_with_one_column_twice_is_an_error_with_its_condition_number():
    singular = PHI.copy()
    singular[:, 2] = 2 * singular[:, 0]
    with pytest.raises(
        ValueError, match=r"Phi is singular \(condition number [\d.]+e[\d+]+\): two columns are the same"
    ):
        rb.equivalent_matrices(singular, 2 * np.pi * F_N, ZETA)


@pytest.mark.parametrize("entry", [np.nan, np.inf])
def test_a_phi_that_is_not_finite_is_an_error(entry):
    broken = PHI.copy()
    broken[1, 2] = entry
    with pytest.raises(ValueError, match=f"Phi holds a number that is not finite: {entry}"):
        rb.equivalent_matrices(broken, 2 * np.pi * F_N, ZETA)


def test_distinct_modes_are_noted_with_their_condition_number_and_no_warning():
    text = str(known())
    assert f"cond(Phi) = {np.linalg.cond(PHI):.3g}." in text
    assert "Warning" not in text


def test_nearly_parallel_columns_are_told_in_the_text_and_nowhere_else(capsys):
    # equation 75: columns 1 and 3 are one mode, columns 2 and 4 another; cond = 98.8
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        f = rb.equivalent_matrices(rb.thesis.PHI, rb.thesis.OMEGA, rb.thesis.ZETA)
        text = str(f)
    assert caught == []
    assert capsys.readouterr() == ("", "")
    assert "cond(Phi) = 98.8." in text
    assert "Warning: columns 1 (x1) and 3 (x2) of Phi are nearly parallel (MAC 0.999" in text
    assert "Warning: columns 2 (y1) and 4 (y2) of Phi are nearly parallel (MAC 0.999" in text
    assert text.count("Warning") == 2


def test_notes_of_the_caller_stand_before_those_of_the_fit():
    f = rb.equivalent_matrices(PHI, 2 * np.pi * F_N, ZETA, notes=("Measured in May.",))
    assert f.notes[0] == "Measured in May."
    assert f.notes[1].startswith("cond(Phi)")


# --- equations 57-61 ---


def test_one_mode_gives_its_shape_exactly():
    # A single mode in the FRFs: H_ij = phi_i phi_j / (omega^2 (2 i zeta)) at omega_n, so that equations 57-60 give phi.
    # Peaks at (f_n, zeta) exactly, no reading involved. One seat: a square Phi of one mode.
    phi, omega, zeta = 0.2, 2 * np.pi * 150.0, 0.02
    frf = rb.modal_foundation([[phi]], [omega], [zeta], ("x1",)).frf([149.0, 150.0, 151.0])
    modes = rb.identification.pseudo_modes(frf, rb.Peaks([150.0], [zeta]))
    np.testing.assert_allclose(modes.Phi, [[phi]], rtol=1e-12)
    assert modes.condition == pytest.approx(1.0)


def test_each_column_is_read_from_the_frfs_driven_at_its_seat():
    # equations 57-60 by hand on the line itself: phi_jj = sqrt(Re p_j), phi_ij = Re p_i / phi_jj, p = 2i zeta w^2 H_:j
    frf = FRFS
    peaks = rb.Peaks(F_N, ZETA)
    Phi = rb.identification.pseudo_modes(frf, peaks, interpolate=False).Phi
    for j, (f, zeta) in enumerate(zip(F_N, ZETA, strict=True)):
        line = np.flatnonzero(f == LINES)[0]
        p = -2 * zeta * (2 * np.pi * f) ** 2 * frf.H[line, :, j].imag
        np.testing.assert_allclose(Phi[:, j], p / np.sqrt(p[j]), rtol=1e-12)


def test_pseudo_modes_of_well_separated_modes_are_the_modes():
    # the others' share of the quadrature at a peak is of order zeta_r (omega/omega_r)^2...: well below 1 %
    modes = rb.identification.pseudo_modes(FRFS, [90, 180, 310, 450])
    # a mode has no sign: equation 57 takes the root that makes the driving point positive
    np.testing.assert_allclose(modes.Phi, PHI * np.sign(np.diag(PHI)), rtol=0.01)
    np.testing.assert_allclose(modes.omega, 2 * np.pi * F_N, rtol=2e-3)
    np.testing.assert_allclose(modes.zeta, ZETA, rtol=0.01)
    assert modes.condition == pytest.approx(np.linalg.cond(modes.Phi))


def test_pmsm_gives_the_natural_frequencies_of_a_known_foundation_within_a_fifth_of_a_percent():
    fitted = rb.pmsm(FRFS, [90, 180, 310, 450])
    np.testing.assert_allclose(fitted.modes().frequency, known().modes().frequency, rtol=0.002)
    np.testing.assert_allclose(fitted.modes().damping, known().modes().damping, rtol=0.02)


def test_pmsm_gives_the_coupled_frequencies_of_a_known_foundation_within_a_percent():
    expected = coupled(known())
    assert len(expected) == 12  # eight of the rotor and four of the foundation, mixed
    # the foundation matters: on rigid ground only eight remain, and none of the lowest four is where it was
    rigid = coupled(None)
    assert len(rigid) == 8
    assert np.abs(expected[:4, None] / rigid - 1).min() > 0.008
    np.testing.assert_allclose(coupled(rb.pmsm(FRFS, [90, 180, 310, 450])), expected, rtol=0.01)


def test_interpolation_between_coarse_lines_saves_most_of_the_fit():
    # lines every 5 Hz: half-power widths are 3.6 to 12 Hz; reading lines alone gets the damping wrong
    coarse = known().frf(np.arange(0.0, 600.0, 5.0))
    between = rb.identification.pseudo_modes(coarse, [90, 180, 310, 450])
    lines = rb.identification.pseudo_modes(coarse, [90, 180, 310, 450], interpolate=False)
    np.testing.assert_allclose(between.zeta, ZETA, rtol=0.05)
    assert np.abs(lines.zeta / ZETA - 1).max() > 0.15
    np.testing.assert_allclose(rb.pmsm(coarse, [90, 180, 310, 450]).modes().frequency, F_N, rtol=0.002)


def test_pmsm_says_which_peaks_it_used():
    text = str(rb.pmsm(FRFS, [91, 178, 305, 455]))
    assert "Peaks used: x1 89.96 Hz 2 %, y1 179.9 Hz 1.5 %, x2 310.1 Hz 2 %, y2 450 Hz 0.999 %." in text
    assert "cond(Phi) = 1.32." in text


def test_the_same_peak_from_two_seats_is_warned_of():
    # the thesis's way, [X, Y, X, Y]: each mode twice
    fitted = rb.pmsm(FRFS, [90, 180, 90, 180])
    text = str(fitted)
    assert text.count("nearly parallel") == 2
    assert rb.identification.pseudo_modes(FRFS, [90, 180, 90, 180]).condition > 50


def test_peaks_are_used_as_they_are_on_a_peak_or_not():
    frf = FRFS
    peaks = rb.Peaks(F_N + 3.3, 0.05)
    modes = rb.identification.pseudo_modes(frf, peaks)
    np.testing.assert_allclose(modes.omega, 2 * np.pi * (F_N + 3.3), rtol=1e-14)
    np.testing.assert_array_equal(modes.zeta, np.full(4, 0.05))
    assert "x1 93.3 Hz 5 %" in str(rb.pmsm(frf, peaks))


def test_between_lines_the_frf_of_a_column_is_that_of_the_line_that_is_missing():
    # take every second line away and read there: 1/H_jj and H_ij/H_jj are smooth, so little is lost
    frf = FRFS
    halved = rb.FRF(LINES[::2], frf.H[::2])
    peaks = rb.Peaks(F_N + 0.5, ZETA)  # 90.5 Hz ... were lines, and are not any more
    np.testing.assert_allclose(
        rb.identification.pseudo_modes(halved, peaks).Phi,
        rb.identification.pseudo_modes(frf, peaks).Phi,
        rtol=1e-3,
        atol=1e-5,
    )


def test_the_unit_of_the_frfs_scales_the_matrices_and_leaves_the_frequencies():
    # mm/N taken for m/N: H 1000 times, Phi sqrt(1000) times, M, C, K a thousandth
    frf = FRFS
    one, other = (rb.pmsm(rb.FRF(LINES, s * frf.H), [90, 180, 310, 450]) for s in (1.0, 1000.0))
    for name in "MCK":
        np.testing.assert_allclose(1000 * getattr(other, name), getattr(one, name), rtol=1e-9)
    np.testing.assert_allclose(other.modes().poles, one.modes().poles, rtol=1e-9)
    assert np.abs(coupled(other)[:4] / coupled(one)[:4] - 1).max() > 0.05


def test_a_sensor_the_wrong_way_round_is_an_error_that_names_the_seat():
    # the sensor at x2 flipped: row 3 of H changes sign, and with it the driving point of x2 only
    frf = FRFS
    H = frf.H.copy()
    H[:, 2, :] *= -1
    with pytest.raises(
        ValueError, match=r"driving point x2 has a positive imaginary part at 310\.\d+ Hz.*wrong way round"
    ):
        rb.pmsm(rb.FRF(LINES, H), [90, 180, 310, 450])


@pytest.mark.parametrize("peaks", [[90, 180, 310], [90, 180, 310, 450, 500], []])
def test_another_number_of_peaks_than_seats_is_an_error_with_the_number(peaks):
    with pytest.raises(ValueError, match=rf"{len(peaks)} peaks are given: there must be one a seat, x1, y1, x2, y2"):
        rb.pmsm(FRFS, peaks)
    with pytest.raises(ValueError, match=rf"{len(peaks)} peaks are given"):
        rb.pmsm(FRFS, rb.Peaks(np.array(peaks, dtype=float), 0.02))


def test_no_peak_near_a_wish_is_an_error_that_names_the_driving_point():
    with pytest.raises(
        ValueError, match=r"the driving point y1 has no peak within 15% of 240 Hz: the nearest one is at"
    ):
        rb.pmsm(FRFS, [90, 240, 310, 450])


def test_a_peak_outside_the_band_is_an_error_with_the_band():
    with pytest.raises(ValueError, match="peak for y2 is at 700 Hz: the FRFs reach from 0 to 600 Hz"):
        rb.pmsm(FRFS, rb.Peaks([90.0, 180.0, 310.0, 700.0], 0.02))


@pytest.mark.parametrize("zeta", [0.0, 1.0, -0.01, np.nan])
def test_a_damping_ratio_that_no_peak_can_have_is_an_error(zeta):
    with pytest.raises(ValueError, match=rf"peak for x1 at 90 Hz has the damping ratio {zeta:g}"):
        rb.pmsm(FRFS, rb.Peaks(F_N, [zeta, 0.02, 0.02, 0.02]))


def test_pmsm_serves_one_bearing_and_three():
    for seats in (2, 6):
        labels = tuple(f"{axis}{b + 1}" for b in range(seats // 2) for axis in "xy")
        # Phi near a diagonal: seat j sees mode j best
        Phi = 0.1 * (np.eye(seats) + 0.1 * np.random.default_rng(seats).standard_normal((seats, seats)))
        f_n = 80.0 * 1.6 ** np.arange(seats)
        truth = rb.equivalent_matrices(Phi, 2 * np.pi * f_n, np.full(seats, 0.02), labels)
        fitted = rb.pmsm(truth.frf(np.arange(0.0, 1000.0, 0.5)), f_n)
        assert fitted.labels == labels
        np.testing.assert_allclose(fitted.modes().frequency, truth.modes().frequency, rtol=0.002)
        assert linalg.norm(fitted.M - truth.M) < 0.02 * linalg.norm(truth.M)


def test_the_fit_is_quiet(capsys):
    rb.pmsm(FRFS, [90, 180, 90, 180])
    assert capsys.readouterr() == ("", "")


# --- circles, and complex shapes ---

DASHPOTS = np.diag([3000.0, 0.0, 0.0, 8000.0])  # at x1 and y2: they couple the modes


def coupled_by_damping():
    """The known foundation with two dashpots to ground, and its exact complex Phi, omega and zeta."""
    k = known()
    f = rb.Foundation(k.M, k.C + DASHPOTS, k.K, k.B)
    poles, psi = f.modes().poles, f.modes().shapes
    # scaled so that psi psi' is the residue at the pole: psi' (2 pole M + C) psi = 1
    psi = psi / np.sqrt(np.einsum("ir,ijr,jr->r", psi, 2 * poles * f.M[..., None] + f.C[..., None], psi))
    return f, psi * np.sqrt(2j * poles.imag), np.abs(poles), -poles.real / np.abs(poles)


def test_circles_give_a_known_foundation_with_frequencies_nearer_by_two_orders():
    # the peak is taken for the undamped frequency and stands on the others' flanks; the circle is not so read
    peak, circle = (rb.pmsm(FRFS, [90, 180, 310, 450], method=method) for method in ("peak", "circle"))
    errors = [np.abs(f.modes().frequency / known().modes().frequency - 1).max() for f in (peak, circle)]
    assert errors[1] < 1e-5 < 1e-4 < errors[0]
    np.testing.assert_allclose(
        rb.identification.pseudo_modes(FRFS, [90, 180, 310, 450], method="circle").zeta, ZETA, rtol=0.005
    )
    assert "Circles used: x1 90 Hz 2 %" in str(circle)


def test_circles_read_four_uncoupled_seats_exactly():
    # one mode a driving point: nothing to be confused with
    truth = rb.equivalent_matrices(0.1 * np.eye(4), 2 * np.pi * F_N, ZETA)
    fitted = rb.pmsm(truth.frf(LINES), F_N, method="circle")
    for name in "MCK":
        np.testing.assert_allclose(getattr(fitted, name), getattr(truth, name), rtol=1e-9, atol=1e-9)


def test_circles_stand_noise_that_half_power_points_do_not():
    rng = np.random.default_rng(8)
    noise = 0.05 * (rng.standard_normal(FRFS.H.shape) + 1j * rng.standard_normal(FRFS.H.shape)) / np.sqrt(2)
    noisy = rb.FRF(LINES, FRFS.H * (1 + noise))
    with pytest.raises(ValueError, match="has the damping ratio nan"):
        rb.pmsm(noisy, [90, 180, 310, 450])
    circle = rb.identification.pseudo_modes(noisy, [90, 180, 310, 450], method="circle")
    # 8 to 25 lines a circle: a tenth of the half-width for the frequency, a sixth of the damping
    np.testing.assert_allclose(circle.omega, 2 * np.pi * F_N, rtol=2e-3)
    np.testing.assert_allclose(circle.zeta, ZETA, rtol=0.15)


def test_the_matrices_of_complex_modes_are_those_of_the_system_that_has_them():
    # two roads: M, C, K to complex modes by the eigenvalue problem, and back
    f, Phi, omega, zeta = coupled_by_damping()
    assert np.degrees(np.abs(np.angle(Phi**2))).max() > 20
    again = rb.equivalent_matrices(Phi, omega, zeta)
    for name in "MCK":
        matrix = getattr(f, name)
        np.testing.assert_allclose(getattr(again, name), matrix, atol=1e-11 * np.abs(matrix).max())


def test_a_complex_phi_that_is_real_gives_the_matrices_of_the_real_one():
    complex_ = rb.equivalent_matrices(PHI + 0j, 2 * np.pi * F_N, ZETA)
    for name in "MCK":
        matrix = getattr(known(), name)
        np.testing.assert_allclose(getattr(complex_, name), matrix, atol=1e-12 * np.abs(matrix).max())


def test_complex_shapes_with_errors_still_give_real_symmetric_matrices_with_the_poles_they_came_with():
    _, Phi, omega, zeta = coupled_by_damping()
    rng = np.random.default_rng(2)
    wrong = Phi * (1 + 0.02 * (rng.standard_normal((4, 4)) + 1j * rng.standard_normal((4, 4))))
    f = rb.equivalent_matrices(wrong, omega, zeta)
    assert f.asymmetry() < 1e-14
    np.testing.assert_allclose(f.modes().poles, -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2), rtol=1e-9)
    # and the shapes are the ones given, but for the size of their errors
    turned = f.modes().shapes / f.modes().shapes[0] * wrong[0]
    assert np.abs(turned / wrong - 1).max() < 0.1


def misfit(fitted, frf):
    """Root mean square over the lines from 40 Hz of |H - fitted| / |H|, with Frobenius norms."""
    lines = frf.between(40, 600)
    difference = fitted.frf(lines.frequency).H - lines.H
    return np.sqrt(np.mean((np.linalg.norm(difference, axis=(1, 2)) / np.linalg.norm(lines.H, axis=(1, 2))) ** 2))


def test_complex_shapes_from_circles_pay_where_damping_couples_the_modes_and_cost_nothing_elsewhere():
    coupled_modes = coupled_by_damping()[0].frf(LINES)
    real, complex_ = (
        misfit(rb.pmsm(coupled_modes, [90, 180, 310, 450], method="circle", parts=parts), coupled_modes)
        for parts in ("real", "complex")
    )
    assert complex_ < 0.2 * real
    real, complex_ = (
        misfit(rb.pmsm(FRFS, [90, 180, 310, 450], method="circle", parts=parts), FRFS) for parts in ("real", "complex")
    )
    assert complex_ == pytest.approx(real, rel=0.01)


def test_the_phase_at_a_peak_is_that_of_the_neighbours_and_makes_the_foundation_active():
    # modes are real here: what is complex at a peak is the others' share, and complex shapes made of it are wrong
    real, complex_ = (rb.pmsm(FRFS, [90, 180, 310, 450], parts=parts) for parts in ("real", "complex"))
    assert misfit(complex_, FRFS) > 3 * misfit(real, FRFS)
    assert real.definiteness()["C"] > 0 > complex_.definiteness()["C"]
    assert "C is not positive definite" in " ".join(complex_.notes)
    assert "positive definite" not in " ".join(real.notes)


def test_real_parts_are_the_default_and_the_real_products_of_the_complex_ones():
    real, default, complex_ = (
        rb.identification.pseudo_modes(FRFS, [90, 180, 310, 450], **options)
        for options in ({"parts": "real"}, {}, {"parts": "complex"})
    )
    np.testing.assert_array_equal(real.Phi, default.Phi)
    product = complex_.Phi * np.diag(complex_.Phi)
    np.testing.assert_allclose(real.Phi * np.diag(real.Phi), product.real, rtol=1e-12, atol=1e-15)


def test_other_words_for_method_and_parts_and_what_circles_cannot_take_are_errors():
    with pytest.raises(ValueError, match=r'method is \'ring\': it must be "peak" or "circle"'):
        rb.pmsm(FRFS, [90, 180, 310, 450], method="ring")
    with pytest.raises(ValueError, match=r'parts is \'imaginary\': it must be "real" or "complex"'):
        rb.pmsm(FRFS, [90, 180, 310, 450], parts="imaginary")
    with pytest.raises(ValueError, match=r"give one frequency .* a seat, not Peaks"):
        rb.pmsm(FRFS, rb.Peaks(F_N, ZETA), method="circle")
    with pytest.raises(ValueError, match="interpolate=False has no meaning"):
        rb.pmsm(FRFS, F_N, method="circle", interpolate=False)
    with pytest.raises(ValueError, match="the driving point y1: no peak within 15% of 250 Hz"):
        rb.pmsm(FRFS, [90, 250, 310, 450], method="circle")


def test_shapes_that_no_real_system_can_have_are_an_error():
    with pytest.raises(ValueError, match="Phi is too complex for the modes of a real system"):
        rb.equivalent_matrices(PHI * np.exp(1j * np.pi / 4), 2 * np.pi * F_N, ZETA)
    with pytest.raises(ValueError, match=r"zeta holds 1\.2: a complex shape belongs to a mode that oscillates"):
        rb.equivalent_matrices(PHI + 0j, 2 * np.pi * F_N, [0.02, 1.2, 0.02, 0.02])
