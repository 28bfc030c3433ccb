"""One resonance by its circle (Kennedy and Pancu 1947; Kasa 1976, DOI 10.1109/TIM.1976.6312298; Taubin 1991)."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import rbfound as rb
from rbfound.identification import circle_fit, modal_constants
from rbfound.identification.circle import kasa, taubin
from rbfound.theory import sdof

M, F_N, ZETA = 2.0, 100.3, 0.02
K = M * rb.from_hertz(F_N) ** 2
C = 2 * ZETA * np.sqrt(K * M)
LINES = np.arange(0.5, 400.0, 0.5)
H = sdof.receptance(LINES, M, C, K)


def arc(angles, rng=None, noise=0.0, centre=3.0 - 2.0j, radius=1.5):
    z = centre + radius * np.exp(1j * np.asarray(angles))
    if rng is not None:
        z = z + noise * (rng.standard_normal(z.shape) + 1j * rng.standard_normal(z.shape))
    return z


# --- a circle through points ---


@pytest.mark.parametrize("through", [kasa, taubin])
def test_points_on_a_circle_give_it_back(through):
    # three points define it, an arc of 40 degrees is enough without noise; the size of the numbers does not matter
    for angles in ([0.1, 2.0, 4.0], np.linspace(0.3, 1.0, 9), np.linspace(0.0, 6.2, 50)):
        for scale in (1e-9, 1.0, 1e6):
            centre, radius = through(scale * arc(angles))
            assert centre == pytest.approx(scale * (3.0 - 2.0j), rel=1e-10)
            assert radius == pytest.approx(scale * 1.5, rel=1e-10)


def test_the_fits_solve_the_problems_that_their_papers_pose():
    # two roads: the objective functions themselves, with a general minimiser's condition that no step lowers them
    rng = np.random.default_rng(3)
    z = arc(np.linspace(0.0, 2.0, 30), rng, 0.05)

    def deviation(c, r):
        return np.abs(z - c) ** 2 - r**2

    def kasas(c, r):
        return np.sum(deviation(c, r) ** 2)

    def taubins(c, r):
        # mean squared gradient of |z - c|^2 - r^2 is 4 mean |z - c|^2
        return np.sum(deviation(c, r) ** 2) / np.sum(4 * np.abs(z - c) ** 2)

    for through, objective in ((kasa, kasas), (taubin, taubins)):
        centre, radius = through(z)
        least = objective(centre, radius)
        for step in (1e-4, -1e-4, 1e-4j, -1e-4j):
            assert objective(centre + step, radius) > least
        for step in (1e-4, -1e-4):
            assert objective(centre, radius + step) > least


def test_noise_on_a_short_arc_makes_kasas_circle_too_small_and_taubins_hardly():
    # 60 degrees of arc, noise a thirtieth of the radius on either component, 400 seeds
    rng = np.random.default_rng(11)
    clouds = [arc(np.linspace(0, 1.05, 60), rng, 0.05) for _ in range(400)]
    radii = np.array([[through(z)[1] for through in (kasa, taubin)] for z in clouds])
    bias, doubt = radii.mean(axis=0) / 1.5 - 1, radii.std(axis=0) / 1.5 / np.sqrt(400)
    assert bias[0] < -10 * doubt[0]
    assert abs(bias[1]) < abs(bias[0]) / 4


@pytest.mark.parametrize("through", [kasa, taubin])
def test_fewer_than_three_points_or_one_point_thrice_is_an_error(through):
    with pytest.raises(ValueError, match="2 points are given: a circle needs three"):
        through([0.0, 1.0j])
    with pytest.raises(ValueError, match="All points are one"):
        through([1.0 + 1j] * 5)


def test_a_straight_line_is_no_circle():
    with pytest.raises(ValueError, match="lie on a straight line"):
        taubin(np.array([0.0, 1.0, 2.0, 4.0]) * (1 + 2j))


# --- one mode ---


@pytest.mark.parametrize("through", [kasa, taubin])
def test_one_viscous_mode_comes_back_exactly(through):
    fit = circle_fit(LINES, H, 100, through=through)
    assert fit.natural_frequency == pytest.approx(F_N, rel=1e-11)
    assert fit.damping == pytest.approx(ZETA, rel=1e-11)
    assert fit.constant == pytest.approx(1 / M, rel=1e-11)
    # the diameter is 1/c on the real axis: at resonance the damper alone holds the mass
    assert fit.radius == pytest.approx(1 / (2 * C), rel=1e-11)
    assert fit.centre == pytest.approx(1 / (2 * C), rel=1e-11)
    assert abs(fit.remainder) < 1e-11 / C
    assert fit.scatter < 1e-12
    assert fit.spread < 1e-10


@settings(max_examples=40)
@given(
    zeta=st.floats(0.002, 0.2),
    f_n=st.floats(60.0, 200.0),
    constant=st.complex_numbers(min_magnitude=0.01, max_magnitude=100.0),
    share=st.complex_numbers(max_magnitude=2.0),
)
def test_neither_a_constant_remainder_nor_the_phase_of_a_mode_matters(zeta, f_n, constant, share):
    # mobility = mode with a complex constant + anything that is constant: the circle is shifted and turned, no more
    omega = rb.from_hertz(LINES)
    mode = constant / (rb.from_hertz(f_n) ** 2 - omega**2 + 2j * zeta * rb.from_hertz(f_n) * omega)
    diameter = abs(constant) / (2 * zeta * rb.from_hertz(f_n))
    fit = circle_fit(
        LINES, mode + share * diameter / (1j * omega), band=(f_n * (1 - 3 * zeta) - 2, f_n * (1 + 3 * zeta) + 2)
    )
    assert fit.natural_frequency == pytest.approx(f_n, rel=1e-8)
    assert fit.damping == pytest.approx(zeta, rel=1e-7)
    assert fit.constant == pytest.approx(constant, rel=1e-7)
    assert fit.remainder == pytest.approx(share * diameter, rel=1e-6, abs=1e-6 * diameter)


def test_the_receptance_of_a_viscous_mode_is_no_circle():
    # 10 % damping, two half-power widths to either side: a third of a per cent off, where the mobility is exact
    heavy = sdof.receptance(LINES, M, 5 * C, K)
    near = (LINES > 60) & (LINES < 140)
    centre, radius = taubin(heavy[near])
    assert np.abs(np.abs(heavy[near] - centre) / radius - 1).max() > 0.002
    assert circle_fit(LINES, heavy, 100).scatter < 1e-12


def test_lines_as_far_apart_as_three_half_power_widths_are_enough_for_one_mode():
    # half-power width 4 Hz: lines every 12 Hz, five of them; half-power reading is lost there
    coarse = np.arange(4.0, 400.0, 12.0)
    fit = circle_fit(coarse, sdof.receptance(coarse, M, C, K), 100)
    assert fit.lines[1] - fit.lines[0] == 5
    assert fit.natural_frequency == pytest.approx(F_N, rel=1e-9)
    assert fit.damping == pytest.approx(ZETA, rel=1e-9)


def test_the_residue_is_that_of_the_pole():
    # partial fractions of 1 / (m (s - pole)(s - conj pole)): 1 / (m (pole - conj pole))
    pole = sdof.poles(M, C, K)[0]
    fit = circle_fit(LINES, H, 100)
    assert fit.residue == pytest.approx(1 / (M * (pole - np.conj(pole))), rel=1e-10)


def test_the_half_power_points_lie_a_quarter_of_the_circle_from_resonance():
    fit = circle_fit(LINES, H, 100)
    low, high = fit.half_power
    assert high - low == pytest.approx(2 * ZETA * F_N, rel=1e-10)
    # there the mobility of one mode has fallen to 1/sqrt(2) of 1/c, 45 degrees before and behind
    for f, phase in ((low, 45), (high, -45)):
        Y = 1j * rb.from_hertz(f) * sdof.receptance(f, M, C, K)
        np.testing.assert_allclose(Y, np.exp(1j * np.radians(phase)) / (np.sqrt(2) * C), rtol=1e-9)


def test_the_fitted_mobility_is_the_data_on_the_lines_that_were_used():
    fit = circle_fit(LINES, H, 100)
    used = slice(*fit.lines)
    np.testing.assert_allclose(fit.mobility(LINES[used]), 1j * rb.from_hertz(LINES[used]) * H[used], rtol=1e-9)


# --- which lines ---


def test_the_lines_reach_as_many_half_power_widths_to_either_side_as_width_says():
    # 4 Hz a width, the peak on the line 100.5: the flank that falls first decides, half a line early at the most
    for width in (0.75, 1.0, 2.0):
        first, last = circle_fit(LINES, H, 100, width=width).lines
        assert LINES[last - 1] - LINES[first] == pytest.approx(8 * width, abs=4 * 0.5 * width + 0.5)


def test_the_lines_end_at_the_valley_before_another_peak():
    two = H + sdof.receptance(LINES, M, C, M * rb.from_hertz(107.0) ** 2)
    first, last = circle_fit(LINES, two, 100).lines
    between = (LINES > 100) & (LINES < 107)
    valley = LINES[between][np.abs(two[between]).argmin()]
    assert LINES[last - 1] == valley
    assert LINES[first] < 97.5


def test_the_nearest_peak_is_taken_and_the_ripples_of_noise_are_not():
    rng = np.random.default_rng(0)
    two = H + sdof.receptance(LINES, M, 2 * C, 4 * K)  # the other at 200.6 Hz
    for near, f in ((95, F_N), (108, F_N), (190, 2 * F_N), (215, 2 * F_N)):
        noisy = two * (1 + 0.05 * (rng.standard_normal(len(H)) + 1j * rng.standard_normal(len(H))) / np.sqrt(2))
        # frequency to a tenth of the half-width of 2 %
        assert circle_fit(LINES, noisy, near).natural_frequency == pytest.approx(f, rel=2e-3)


def test_a_circle_with_noise_tells_so_and_is_right_on_average():
    # 1 % of noise, 16 lines: the angles are as sure as the distances; 60 seeds
    rng = np.random.default_rng(5)
    noise = 0.01 * (rng.standard_normal((60, len(H))) + 1j * rng.standard_normal((60, len(H)))) / np.sqrt(2)
    fits = [circle_fit(LINES, H * (1 + n), 100) for n in noise]
    damping = np.array([fit.damping for fit in fits])
    frequency = np.array([fit.natural_frequency for fit in fits])
    # one real component of the noise is 0.7 % of |Y|, 1 to 1.4 % of a radius on most of the arc
    assert 0.005 < np.median([fit.scatter for fit in fits]) < 0.015
    assert np.median([fit.spread for fit in fits]) > 0.005
    # bias below three standard errors; one reading within 3 % of damping and 0.03 % of frequency
    for value, exact, worst in ((damping, ZETA, 0.03), (frequency, F_N, 3e-4)):
        assert abs(value.mean() - exact) < 3 * value.std() / np.sqrt(60)
        assert np.abs(value / exact - 1).max() < worst


def test_a_neighbour_shows_in_the_scatter():
    clean = circle_fit(LINES, H, 100)
    two = H + sdof.receptance(LINES, M, C, M * rb.from_hertz(112.0) ** 2)
    assert circle_fit(LINES, two, 100).scatter > 1e-3 > 1e6 * clean.scatter


def test_a_remainder_that_grows_along_the_lines_is_taken_out_with_slope():
    # a mode and receptance and mobility remainders of any phase, each a share of the peak; wide, so that they matter
    omega = rb.from_hertz(LINES)
    other = 0.05 * np.abs(H).max() * (1 + 0.5j) + 0.03 / C * 1j / (1j * omega)
    plain, without = (circle_fit(LINES, H + other, 100, width=1.5, slope=slope) for slope in (False, True))
    errors = [abs(fit.damping / ZETA - 1) for fit in (plain, without)]
    # the rounds end with changes of 1e-5 that halve each time
    assert errors[1] < 1e-4 < 4e-3 < errors[0]
    assert without.constant == pytest.approx(1 / M, rel=1e-4)
    assert without.natural_frequency == pytest.approx(F_N, rel=1e-5)
    # i w R = i omega R + i omega R (w - omega) / omega
    expected = 1j * without.omega * 0.05 * np.abs(H).max() * (1 + 0.5j)
    # small beside the mode: less sure than the damping
    assert without.slope == pytest.approx(expected, rel=1e-2)
    used = slice(*without.lines)
    np.testing.assert_allclose(without.mobility(LINES[used]), (1j * omega * (H + other))[used], rtol=1e-4)


def test_the_slope_saves_most_of_the_bias_on_the_foundation():
    truth = rb.modal_foundation(np.full((4, 4), 0.1), rb.from_hertz([160.0, 280.0, 344.0, 480.0]), np.full(4, 0.02))
    frf = truth.frf(LINES)
    for near in (160, 280, 344):
        plain, without = (circle_fit(LINES, frf.H[:, 0, 0], near, slope=slope) for slope in (False, True))
        assert abs(without.damping / 0.02 - 1) < 0.1 * abs(plain.damping / 0.02 - 1)
        assert abs(without.damping / 0.02 - 1) < 2e-3
        # the constants of the column are as good
        constants = modal_constants(LINES, frf.H[:, :, 0], without)
        np.testing.assert_allclose(constants, 0.01, rtol=1e-2)


# --- FRFs that share a mode ---


def test_modal_constants_of_a_column_are_the_products_of_the_shape():
    phi = np.array([[0.2], [0.001], [-0.1], [0.05]])
    frf = rb.modal_foundation(phi, [rb.from_hertz(F_N)], [ZETA]).frf(LINES)
    fit = circle_fit(LINES, frf.H[:, 0, 0], 100)
    np.testing.assert_allclose(
        modal_constants(LINES, frf.H[:, :, 0], fit), phi[:, 0] * phi[0, 0], rtol=1e-9, atol=1e-13
    )
    assert modal_constants(LINES, frf.H, fit).shape == (4, 4)


# --- errors ---


def test_near_or_band_and_not_both():
    for wrong in ({}, {"near": 100.0, "band": (90.0, 110.0)}):
        with pytest.raises(ValueError, match=r"either near=.*or band="):
            circle_fit(LINES, H, **wrong)


def test_no_peak_where_one_is_asked_for_is_an_error_that_names_the_frf():
    with pytest.raises(ValueError, match=r"the FRF x1: no peak within 15% of 250 Hz stands 25% above"):
        circle_fit(LINES, H, 250, name="the FRF x1")


def test_a_peak_that_does_not_fall_to_half_power_is_an_error():
    cut = (LINES > 99) & (LINES < 101.5)
    with pytest.raises(ValueError, match=r"no peak within 15% of 100 Hz stands"):
        circle_fit(LINES[cut], H[cut], 100)
    # 28 % above the valley beside it, and the valley is as far down as it goes on either side
    floor = np.maximum(np.abs(H) / np.abs(H).max(), 0.75)
    with pytest.raises(ValueError, match=r"the peak at 100\.5 Hz does not fall to half power on either side"):
        circle_fit(LINES, floor, 100)


def test_too_few_lines_are_an_error_with_their_number():
    with pytest.raises(
        ValueError, match=r"Only 3 lines lie between 99\.5 and 100\.5 Hz: a circle and its angles need 5"
    ):
        circle_fit(LINES, H, band=(99.5, 100.5))
    with pytest.raises(ValueError, match="Only 0 lines"):
        circle_fit(LINES, H, band=(500, 600))


def test_lines_beside_the_resonance_are_an_error():
    with pytest.raises(ValueError, match="these lines show no resonance"):
        circle_fit(LINES, H, band=(150, 170))


def test_a_width_of_nothing_and_a_matrix_are_errors():
    with pytest.raises(ValueError, match="width is 0 half-power widths"):
        circle_fit(LINES, H, 100, width=0)
    with pytest.raises(ValueError, match=r"frequency has shape \(799,\) and H \(799, 2\)"):
        circle_fit(LINES, np.column_stack([H, H]), 100)


def test_a_line_at_zero_hertz_is_left_alone():
    lines = np.arange(0.0, 40.0, 0.5)
    low = sdof.receptance(lines, 1.0, 2 * 0.3 * rb.from_hertz(8.0), rb.from_hertz(8.0) ** 2)
    assert circle_fit(lines, low, 7).damping == pytest.approx(0.3, rel=1e-9)
    assert circle_fit(lines, low, band=(0, 20)).lines[0] == 1
