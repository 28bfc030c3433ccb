"""Mode indicator and peak picking."""

import numpy as np
import pytest
from scipy import signal

import rbfound as rb
from rbfound.measurement import nearest_peak, prominence
from rbfound.theory import sdof

LINES = np.arange(1.0, 500.5, 0.5)


def uncoupled(f_n, zeta, size=None):
    """Four oscillators, one a seat: H is diagonal, its singular values are the |H_jj|."""
    size = np.ones(4) if size is None else size
    return rb.modal_foundation(np.diag(size), 2 * np.pi * np.array(f_n), np.array(zeta))


F_N, ZETA = (100.0, 200.0, 300.0, 400.0), (0.01, 0.02, 0.02, 0.03)


def test_the_mode_indicator_of_uncoupled_seats_is_their_sorted_receptances():
    frf = uncoupled(F_N, ZETA).frf(LINES)
    expected = np.sort(np.abs(np.einsum("fjj->fj", frf.H)), axis=1)[:, ::-1]
    np.testing.assert_allclose(rb.measurement.mode_indicator(frf), expected, rtol=1e-12)


def test_the_mode_indicator_does_not_depend_on_the_axes_of_the_seats():
    # singular values are invariant to a rotation of the seats' axes
    frf = rb.modal_foundation(np.random.default_rng(1).standard_normal((4, 4)), 2 * np.pi * np.array(F_N), ZETA).frf(
        LINES
    )
    turn = np.kron(np.eye(2), [[0.6, -0.8], [0.8, 0.6]])
    turned = rb.FRF(LINES, turn @ frf.H @ turn.T)
    np.testing.assert_allclose(
        rb.measurement.mode_indicator(turned), rb.measurement.mode_indicator(frf), rtol=1e-10, atol=1e-20
    )


def test_a_second_indicator_peaks_where_two_modes_share_one_place():
    # x1 and y1 both at 150 Hz with different shapes: two singular values peak there, the third does not
    sigma = rb.measurement.mode_indicator(uncoupled((150.0, 150.0, 300.0, 400.0), (0.02,) * 4).frf(LINES))
    there = np.flatnonzero(LINES == 150.0)[0]
    for k, peaks_there in enumerate([True, True, False]):
        near = [abs(line - there) <= 1 for line in sdof.local_maxima(sigma[:, k])]
        assert any(near) == peaks_there


def test_all_peaks_of_distinct_modes_are_found_with_frequency_and_damping():
    # diagonal H, modes far apart: each peak is that of one oscillator, f_n sqrt(1 - 2 zeta^2), and at 0.5 Hz lines the
    # interpolated half-power damping is zeta (1 + 2 zeta^2): closed form in test_sdof.py
    peaks = rb.pick_peaks(uncoupled(F_N, ZETA).frf(LINES), count=4)
    assert len(peaks) == 4
    zeta = np.array(ZETA)
    np.testing.assert_allclose(peaks.frequency, np.array(F_N) * np.sqrt(1 - 2 * zeta**2), rtol=1e-9)
    np.testing.assert_allclose(peaks.damping, zeta, rtol=3 * zeta.max() ** 2)


def test_without_interpolation_a_peak_is_a_line():
    frf = uncoupled(F_N, ZETA).frf(np.arange(0.0, 501.0, 7.0))
    assert set(rb.pick_peaks(frf, count=4, interpolate=False).frequency) <= set(frf.frequency)
    assert not set(rb.pick_peaks(frf, count=4).frequency) & set(frf.frequency)


def test_the_most_prominent_peaks_are_taken_and_given_in_ascending_order():
    # prominence of log |H|: 1 % stands out more than 2 % than 8 %, wherever it is
    frf = uncoupled((100.0, 200.0, 300.0, 400.0), (0.08, 0.02, 0.08, 0.01)).frf(LINES)
    np.testing.assert_allclose(rb.pick_peaks(frf, count=1).frequency, [400], rtol=1e-3)
    np.testing.assert_allclose(rb.pick_peaks(frf, count=2).frequency, [200, 400], rtol=1e-3)


def test_the_unit_of_the_receptance_moves_no_peak():
    frf = uncoupled(F_N, ZETA).frf(LINES)
    scaled = rb.pick_peaks(rb.FRF(LINES, 1e3 * frf.H), count=3)
    np.testing.assert_allclose(scaled.frequency, rb.pick_peaks(frf, count=3).frequency, rtol=1e-10)
    np.testing.assert_allclose(scaled.damping, rb.pick_peaks(frf, count=3).damping, rtol=1e-8)


def test_the_peak_nearest_to_each_wish_is_given_in_ascending_order():
    peaks = rb.pick_peaks(uncoupled(F_N, ZETA).frf(LINES), near=[310, 95])
    np.testing.assert_allclose(peaks.frequency, [100, 300], rtol=1e-3)


def test_a_wish_more_than_15_percent_off_is_an_error_that_tells_the_nearest_peak():
    frf = uncoupled(F_N, ZETA).frf(LINES)
    assert len(rb.pick_peaks(frf, near=[117.0])) == 1  # 14.5 % below
    with pytest.raises(ValueError, match="no peak within 15% of 130 Hz: the nearest one is at 100 Hz"):
        rb.pick_peaks(frf, near=[130.0])
    with pytest.raises(ValueError, match="no peak within 15% of nan Hz"):
        rb.pick_peaks(frf, near=[float("nan")])


@pytest.mark.parametrize("count", [0, 5, -1])
def test_more_peaks_than_there_are_or_none_are_an_error_with_both_numbers(count):
    with pytest.raises(ValueError, match=rf"count is {count}: the first mode indicator has 4 peaks"):
        rb.pick_peaks(uncoupled(F_N, ZETA).frf(LINES), count=count)


def test_either_a_count_or_a_list_of_wishes_must_be_given():
    frf = uncoupled(F_N, ZETA).frf(LINES)
    for wishes in ({}, {"count": 2, "near": [100.0]}):
        with pytest.raises(ValueError, match=r"either count=.* or near="):
            rb.pick_peaks(frf, **wishes)


def test_a_band_without_a_peak_is_an_error_with_its_ends():
    frf = uncoupled(F_N, ZETA).frf(LINES).between(110, 120)
    with pytest.raises(ValueError, match="the curve has no peak between 110 and 120 Hz"):
        rb.pick_peaks(frf, near=[115.0])


def test_a_named_curve_bears_its_name_in_the_error():
    with pytest.raises(ValueError, match="the driving point y2 has no peak between 1 and 3 Hz"):
        nearest_peak([1.0, 2.0, 3.0], [3.0, 2.0, 1.0], 2.0, name="the driving point y2")


def test_a_peak_whose_neighbour_hides_its_flank_has_no_damping():
    # opposite shapes at two seats 22 Hz apart with 6 %: the valley is at 0.73 of the lower peak; see test_sdof.py
    lines = np.arange(1.0, 400.0)
    H = np.zeros((len(lines), 1, 1), dtype=complex)
    for sign, f_n in ((1, 100.0), (-1, 122.0)):
        omega = 2 * np.pi * f_n
        H[:, 0, 0] += sign * sdof.receptance(lines, 1.0, 2 * 0.06 * omega, omega**2)
    peaks = rb.pick_peaks(rb.FRF(lines, H, ("x1",)), count=2)
    assert np.isnan(peaks.damping[0])


def test_prominence_is_the_height_over_the_higher_valley():
    # from 5: the valley to the left is 1, to the right 0; from 4: left 2 (there the curve rises above 4), right 0
    np.testing.assert_allclose(prominence([1.0, 5.0, 2.0, 4.0, 0.0], np.array([1, 3])), [4.0, 2.0])


def test_prominence_is_that_of_scipy():
    curve = np.random.default_rng(5).standard_normal(300)
    lines = sdof.local_maxima(curve)
    np.testing.assert_allclose(prominence(curve, lines), signal.peak_prominences(curve, lines)[0], rtol=1e-12)


def test_one_damping_ratio_serves_all_peaks():
    peaks = rb.Peaks([150.0, 350.0], 0.02)
    np.testing.assert_array_equal(peaks.damping, [0.02, 0.02])
    assert len(peaks) == 2
    assert len(rb.Peaks(150.0, 0.02)) == 1


def test_a_line_filled_with_zeros_does_not_disturb_the_peaks():
    # many measured sets have nothing at 0 Hz
    frf = uncoupled(F_N, ZETA).frf(LINES)
    padded = rb.FRF(np.concatenate([[0.0], LINES]), np.concatenate([np.zeros((1, 4, 4)), frf.H]))
    np.testing.assert_allclose(rb.pick_peaks(padded, count=4).frequency, rb.pick_peaks(frf, count=4).frequency)


def test_noise_on_the_lines_does_not_hide_a_peak_or_its_width():
    # 1 % of complex noise on 0.5 Hz lines: the peak's line may be off by a few, the width by a few per cent
    frf = uncoupled(F_N, ZETA).frf(np.arange(0.5, 1000, 0.5))
    rng = np.random.default_rng(7)
    noise = rng.standard_normal(frf.H.shape) + 1j * rng.standard_normal(frf.H.shape)
    noisy = rb.FRF(frf.frequency, frf.H * (1 + 0.01 * noise / np.sqrt(2)))
    modes = rb.identification.pseudo_modes(noisy, list(np.broadcast_to(F_N, 4)))
    np.testing.assert_allclose(rb.hertz(modes.omega), F_N, rtol=0.01)
    np.testing.assert_allclose(modes.zeta, ZETA, rtol=0.2)
