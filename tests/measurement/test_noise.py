"""How large the noise is: what neighbouring lines tell, and when they are believed."""

import numpy as np
import pytest
from samples import BAND, LINES, known, noisy

import rbfound as rb
from rbfound.measurement import averaging as averaging_module, beside_neighbours, own_errors, virtual_test


def white(shape, seed=0):
    return np.random.default_rng(seed).standard_normal((*shape, 2)) @ [1, 1j] / np.sqrt(2)


@pytest.mark.parametrize("reach", [1, 2, 3])
@pytest.mark.parametrize("lines", [np.arange(200.0), np.cumsum(1 + 0.5 * np.sin(np.arange(200.0)))])
def test_polynomials_leave_nothing_and_noise_its_variance(lines, reach):
    curve = np.polynomial.Polynomial(np.arange(1, 2 * reach + 1) / 100.0 ** np.arange(2 * reach))(lines)
    assert beside_neighbours(lines, curve[:, None] + 0j, reach).max() < 1e-18 * np.abs(curve).max() ** 2
    square = beside_neighbours(lines, curve[:, None] + 0.1 * white((200, 50)), reach)
    assert square.shape == (200 - 2 * reach, 50)
    # ten thousand numbers, neighbours not independent: to some per cent
    assert square.mean() == pytest.approx(0.01, rel=0.05)
    assert np.median(square) == pytest.approx(0.01 * np.log(2), rel=0.05)


@pytest.mark.parametrize("level", [0.002, 0.01, 0.05, 0.3])
@pytest.mark.parametrize("zeta", [0.002, 0.015])
def test_noise_in_proportion_to_the_receptance_is_left_to_be_that(level, zeta):
    truth = known(zeta=zeta)
    for seed in range(3):
        frf = noisy(truth.frf(LINES), level, seed).between(*BAND)
        assert own_errors(frf.frequency, frf.H) is None


@pytest.mark.parametrize("step", [0.5, 5.0, 25.0])
def test_clean_and_coarse_data_have_no_noise_to_be_told(step):
    frf = known().frf(np.arange(20.0, 1000.0, step))
    assert own_errors(frf.frequency, frf.H) is None


def test_the_noise_of_accelerations_is_told_line_by_line():
    # an acceleration's noise is the same everywhere: that of the receptance falls with the square of the frequency
    frf = known().frf(LINES).between(*BAND)
    sigma = 2e-3 * np.median(np.abs(frf.H) * frf.frequency[:, None, None] ** 2)
    true = (sigma / frf.frequency**2)[:, None, None] * np.ones(frf.H.shape)
    told = own_errors(frf.frequency, frf.H + true * white(frf.H.shape))
    # forty lines tell a standard deviation to some 13 %; a sharp peak among them adds to it, and 20 Hz is an end
    ratio = told / true
    assert np.median(ratio) == pytest.approx(1.0, rel=0.1)
    assert ((ratio > 0.6) & (ratio < 1.6)).mean() > 0.9


def test_a_measured_set_needs_no_word_about_its_noise():
    # accelerometers with noise of their own, five blows: the noise is 0.3 % of |H| on peaks, all of it at 30 Hz
    truth = rb.modal_foundation(
        0.1 * np.random.default_rng(1).standard_normal((4, 3)),
        rb.from_hertz(np.array([120.0, 210.0, 330.0])),
        [0.02] * 3,
    )
    for seed in range(3):
        S = averaging_module.spectra(
            virtual_test.hammer(truth, virtual_test.Sensors(response_noise=0.05), rate=1024.0, block=2.0, seed=seed)
        )
        fit = rb.fit_modes(S.h1(), band=(20, 400))
        # below 30 Hz noise is larger than |H|: what may be found there besides is unsure, and says so
        sure = fit.inside & ~fit.unsure
        np.testing.assert_allclose(fit.natural_frequency[sure], [120, 210, 330], rtol=2e-3)
        assert fit.told is not None
        assert any("not in proportion to |H|" in note for note in fit.foundation().notes)
        # as with the errors that the coherence tells: both know each mode as well as they say
        other = rb.fit_modes(S.h1(), band=(20, 400), errors=S.errors())
        also = other.inside & ~other.unsure
        apart = np.abs(fit.omega[sure] / other.omega[also] - 1)
        assert (apart < 3 * np.hypot(fit.deviation[0][sure], other.deviation[0][also])).all()


@pytest.mark.slow  # with the wrong errors, noise is searched for modes for some seconds
def test_who_says_that_it_is_in_proportion_is_believed():
    frf = known([100.0, 250.0]).frf(np.arange(20.0, 400.0))
    sigma = 2e-3 * np.median(np.abs(frf.H))
    data = rb.FRF(frf.frequency, frf.H + sigma * white(frf.H.shape))
    assert own_errors(data.frequency, data.H) is not None
    assert rb.fit_modes(data, relative=True, modes=None).errors is None
