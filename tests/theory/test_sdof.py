"""One degree of freedom and half-power points."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from rbfound.theory import sdof


def oscillator(f_n, zeta, m=2.0):
    """m, c, k of a natural frequency [Hz] and a damping ratio."""
    omega = 2 * np.pi * f_n
    return m, 2 * zeta * omega * m, omega**2 * m


def curve(lines, f_n, zeta):
    return np.abs(sdof.receptance(lines, *oscillator(f_n, zeta)))


def peak_of(lines, a, interpolate=True):
    return sdof.half_power(lines, a, int(np.argmax(a)), interpolate)


def half_power_points(f_n, zeta):
    """Where |H| is 1/sqrt(2) of its own peak.

    With q = (f/f_n)^2:  1/|kH|^2 = (1 - q)^2 + 4 zeta^2 q, least at q = 1 - 2 zeta^2 with 4 zeta^2 (1 - zeta^2);
    twice that gives q = 1 - 2 zeta^2 -+ 2 zeta sqrt(1 - zeta^2).
    """
    middle, half = 1 - 2 * zeta**2, 2 * zeta * np.sqrt(1 - zeta**2)
    return f_n * np.sqrt(middle - half), f_n * np.sqrt(middle), f_n * np.sqrt(middle + half)


def test_omega_and_zeta_are_those_of_equations_1_to_3():
    # k/m = 400 => omega = 20; c / (2 m omega) = 8 / (2 * 2 * 20) = 0.1
    assert sdof.natural(2.0, 8.0, 800.0) == pytest.approx((20.0, 0.1), rel=1e-15)


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.7, 1.0, 2.5])
def test_the_poles_are_the_roots_of_the_quadratic(zeta):
    m, c, k = oscillator(3.0, zeta)
    poles = sdof.poles(m, c, k)
    np.testing.assert_allclose(poles[0] + poles[1], -c / m, atol=1e-12 * np.abs(poles).max())
    np.testing.assert_allclose(poles[0] * poles[1], k / m, rtol=1e-12)


def test_the_imaginary_part_of_a_pole_is_the_damped_frequency():
    m, c, k = oscillator(150.0, 0.12)
    # 150 sqrt(1 - 0.12^2) = 148.916...
    assert sdof.poles(m, c, k)[0].imag / (2 * np.pi) == pytest.approx(150 * np.sqrt(1 - 0.0144), rel=1e-12)


@pytest.mark.parametrize("bad", [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 0.0), (float("nan"), 1.0, 1.0)])
def test_a_mass_or_spring_that_is_not_positive_is_an_error_with_the_numbers(bad):
    with pytest.raises(ValueError, match=rf"m = {bad[0]:g} kg, c = {bad[1]:g} N s/m, k = {bad[2]:g} N/m"):
        sdof.natural(*bad)


def test_the_receptance_is_compliance_at_rest_a_damper_at_resonance_and_a_mass_far_above():
    m, c, k = oscillator(10.0, 0.05)
    omega = 2 * np.pi * 10.0
    assert sdof.receptance(0.0, m, c, k) == pytest.approx(1 / k)
    assert sdof.receptance(10.0, m, c, k) == pytest.approx(1 / (1j * omega * c), rel=1e-12)
    far = 1e5
    assert sdof.receptance(far, m, c, k) == pytest.approx(-1 / (m * (2 * np.pi * far) ** 2), rel=1e-4)


def test_free_vibration_below_critical_damping_is_a_decaying_cosine_and_sine():
    # x = exp(-zeta omega t) (x0 cos omega_d t + (v0 + zeta omega x0) / omega_d sin omega_d t)
    m, c, k = oscillator(2.0, 0.1)
    omega, t = 4 * np.pi, np.linspace(0, 2, 50)
    x0, v0, omega_d = 0.01, -0.2, 4 * np.pi * np.sqrt(1 - 0.01)
    expected = np.exp(-0.1 * omega * t) * (
        x0 * np.cos(omega_d * t) + (v0 + 0.1 * omega * x0) / omega_d * np.sin(omega_d * t)
    )
    np.testing.assert_allclose(sdof.free_vibration(t, m, c, k, x0, v0), expected, atol=1e-15)


def test_free_vibration_at_critical_damping_is_the_double_root():
    # m = 1, k = 4, c = 4: omega = 2, zeta = 1 to the last bit; x = (x0 + (v0 + 2 x0) t) exp(-2 t)
    t = np.linspace(0, 3, 31)
    expected = (0.5 + (1.0 + 2 * 0.5) * t) * np.exp(-2 * t)
    np.testing.assert_allclose(sdof.free_vibration(t, 1.0, 4.0, 4.0, 0.5, 1.0), expected, rtol=1e-12)
    # and its neighbours do not jump: d x / d zeta is of order one
    near = sdof.free_vibration(t, 1.0, 4.0 * (1 + 1e-9), 4.0, 0.5, 1.0)
    np.testing.assert_allclose(near, expected, atol=1e-8)


def test_free_vibration_above_critical_damping_is_two_decays():
    # s^2 + 5 s + 4: roots -1, -4; x0 = 1, v0 = 0: x = (4 exp(-t) - exp(-4 t)) / 3
    t = np.linspace(0, 5, 21)
    expected = (4 * np.exp(-t) - np.exp(-4 * t)) / 3
    np.testing.assert_allclose(sdof.free_vibration(t, 1.0, 5.0, 4.0, 1.0), expected, rtol=1e-12)


@settings(max_examples=60)
@given(st.floats(0.002, 0.3), st.floats(20.0, 200.0))
def test_interpolated_half_power_points_of_one_degree_of_freedom_are_exact(zeta, f_n):
    # 1/|H|^2 is a parabola in f^2: three lines determine it, wherever they lie
    lines = np.arange(0.5, 3 * f_n, f_n / 9.3)
    low, top, high = half_power_points(f_n, zeta)
    peak = peak_of(lines, curve(lines, f_n, zeta))
    assert (peak.low, peak.frequency, peak.high) == pytest.approx((low, top, high), rel=1e-7)
    assert peak.damping == pytest.approx((high - low) / (2 * top), rel=1e-6)
    # peak height 1 / (2 k zeta sqrt(1 - zeta^2))
    k = oscillator(f_n, zeta)[2]
    assert peak.height == pytest.approx(1 / (2 * k * zeta * np.sqrt(1 - zeta**2)), rel=1e-6)


def test_twenty_coarse_steps_hide_nothing_of_one_degree_of_freedom_when_interpolated():
    # lines every 25 Hz, half-power width 6 Hz: f_peak = f_n sqrt(1 - 2 zeta^2)
    lines = np.arange(0, 501, 25.0)
    peak = peak_of(lines, curve(lines, 158.0, 0.02))
    assert peak.frequency == pytest.approx(158.0 * np.sqrt(1 - 2 * 0.02**2), rel=1e-10)
    low, top, high = half_power_points(158.0, 0.02)
    assert peak.damping == pytest.approx((high - low) / (2 * top), rel=1e-9)
    # the half-power ratio itself is zeta (1 + 2 zeta^2 + ...), by expanding the closed form
    assert peak.damping == pytest.approx(0.02 * (1 + 2 * 0.02**2), rel=10 * 0.02**4)


def test_a_straight_reading_of_coarse_lines_gives_their_spacing_not_the_damping():
    # Lines every 25 Hz, one on 150 Hz = f_n, zeta = 2 %. The neighbours lie below 1/sqrt(2) of the peak line, so the
    # crossings are on the two straight lines beside it: 25 (1 - 1/sqrt(2)) / (1 - a/a0) Hz away, a/a0 in closed form.
    zeta, step = 0.02, 25.0
    lines = np.arange(0, 501, step)
    peak = peak_of(lines, curve(lines, 150.0, zeta), interpolate=False)

    def ratio(f):
        q = (f / 150.0) ** 2
        return 2 * zeta / np.sqrt((1 - q) ** 2 + 4 * zeta**2 * q)

    away = [step * (1 - 1 / np.sqrt(2)) / (1 - ratio(150.0 + side * step)) for side in (-1, 1)]
    assert peak.frequency == 150.0
    assert (peak.low, peak.high) == pytest.approx((150.0 - away[0], 150.0 + away[1]), rel=1e-12)
    assert peak.damping == pytest.approx(sum(away) / 300.0, rel=1e-12)
    assert peak.damping > 2.5 * zeta  # 5.5 % read from 2 %


@pytest.mark.parametrize("step", [1.0, 0.1, 0.01])
def test_a_straight_reading_of_dense_lines_tends_to_the_half_power_damping(step):
    # Chords of a smooth curve and a peak up to half a line off: relative errors (step / half width)^2 of the level,
    # and step / 2 / 150 Hz of the frequency that equation 33 divides by. The half width is zeta * 150 = 3 Hz.
    low, top, high = half_power_points(150.0, 0.02)
    lines = np.arange(130, 170, step)
    read = peak_of(lines, curve(lines, 150.0, 0.02), interpolate=False)
    assert read.damping == pytest.approx((high - low) / (2 * top), rel=(step / 3) ** 2 + step / 300)


@pytest.mark.parametrize("interpolate", [True, False])
def test_a_peak_that_does_not_fall_to_half_power_has_no_damping(interpolate):
    # two modes of 6 % at 100 and 122 Hz that move in opposite directions: between them they add, and the valley stays
    # above 1/sqrt(2)
    lines = np.arange(1.0, 400.0)
    a = np.abs(sdof.receptance(lines, *oscillator(100.0, 0.06)) - sdof.receptance(lines, *oscillator(122.0, 0.06)))
    k, other = (int(line) for line in sdof.local_maxima(a))
    assert a[k] / np.sqrt(2) < a[k:other].min() < 0.99 * a[k]
    peak = sdof.half_power(lines, a, k, interpolate)
    assert np.isfinite(peak.low)
    assert np.isnan(peak.high)
    assert np.isnan(peak.damping)


@pytest.mark.parametrize("interpolate", [True, False])
def test_a_half_power_point_beyond_the_last_line_is_nan(interpolate):
    # for zeta = 0.5 the static compliance is 0.87 of the peak: nothing lies at half power below
    lines = np.arange(0.0, 200.0, 2.0)
    peak = peak_of(lines, curve(lines, 100.0, 0.5), interpolate)
    assert np.isnan(peak.low)
    assert np.isfinite(peak.high)
    assert np.isnan(peak.damping)


def test_a_line_that_is_no_maximum_is_an_error_with_its_number():
    with pytest.raises(ValueError, match="Line 1 of 4 is not a local maximum"):
        sdof.half_power([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 1.0], 1)
    for end in (0, 3):
        with pytest.raises(ValueError, match=f"Line {end} of 4"):
            sdof.half_power([1.0, 2.0, 3.0, 4.0], [9.0, 2.0, 3.0, 9.0], end)


def test_local_maxima_leave_the_ends_out_and_count_a_plateau_once():
    np.testing.assert_array_equal(sdof.local_maxima([5, 1, 3, 2, 4, 4, 1, 9]), [2, 4])
    assert len(sdof.local_maxima([1.0, 2.0])) == 0
    assert len(sdof.local_maxima([])) == 0


def test_a_line_without_any_response_does_not_disturb_the_peak():
    # many measured sets have a line at 0 Hz that is filled with zeros
    lines = np.arange(0.0, 300.0, 5.0)
    a = curve(lines, 150.0, 0.02)
    a[0] = 0.0
    low, top, high = half_power_points(150.0, 0.02)
    assert peak_of(lines, a).damping == pytest.approx((high - low) / (2 * top), rel=1e-9)


def test_a_disturbed_peak_whose_parabola_dips_below_zero_is_read_on_its_line():
    # 1/a^2 = 1, 0.01, 4 at f^2 = 1, 2, 3: the parabola's vertex lies below zero
    f = np.sqrt([1.0, 2.0, 3.0])
    peak = sdof.half_power(f, np.array([1.0, 0.01, 4.0]) ** -0.5, 1)
    assert peak.frequency == pytest.approx(np.sqrt(2.0))
    assert peak.height == pytest.approx(10.0)
    assert peak.low < peak.frequency < peak.high


def test_the_damping_of_a_peak_is_equation_33():
    assert sdof.Peak(100.0, 1.0, 97.0, 105.0).damping == pytest.approx(0.04)
