"""The report on a set of FRFs: each flaw is put in and must be named; a sound set must be called sound."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.measurement import averaging as averaging_module, virtual_test
from rbfound.measurement.quality import _noise

F = np.arange(5.0, 400.0, 0.5)
OMEGA, ZETA = rb.from_hertz(np.array([60.0, 130.0, 250.0])), np.array([0.02, 0.02, 0.015])


def sound_foundation(omega=OMEGA, zeta=ZETA):
    # bouncing along Y, along X and rocking along X, and a little of each other
    phi = 0.1 * (np.array([[0, 1, 0.8], [1, 0, 0], [0, 1, -0.8], [1, 0, 0]]) + 0.1 * np.arange(12).reshape(4, 3) % 0.7)
    return rb.modal_foundation(phi, omega, zeta)


def sound(f=F, omega=OMEGA, zeta=ZETA):
    return sound_foundation(omega, zeta).frf(f)


def with_H(frf, H):
    return rb.FRF(frf.frequency, H, frf.labels, frf.notes)


def test_a_sound_set_is_called_sound_and_its_peaks_are_counted():
    report = rb.check(sound())
    assert report.warnings == ()
    assert str(report).endswith("Nothing to warn of.")
    np.testing.assert_allclose(report.peaks, [60, 130, 250], rtol=2e-3)
    # the half-power width of the mode indicator feels the neighbours; the third peak stands on the tails of two
    np.testing.assert_allclose(report.damping, ZETA, rtol=0.3)
    np.testing.assert_allclose(report.resolution, 2 * report.damping * report.peaks / 0.5)
    assert report.reaches_static
    assert (report.static > 0).all()
    assert not report.double.any()
    assert report.gaps == ()
    assert (report.lines, report.low, report.high, report.spacing) == (790, 5.0, 399.5, 0.5)


@pytest.mark.parametrize("noise", [0.003, 0.01, 0.05])
def test_the_noise_is_estimated_within_a_fifth(noise):
    # the median of 786 lines scatters by some 5 %, the curvature beside the peaks adds its own
    frf, rng = sound(), np.random.default_rng(1)
    error = (rng.standard_normal(frf.H.shape) + 1j * rng.standard_normal(frf.H.shape)) / np.sqrt(2)
    report = rb.check(with_H(frf, frf.H * (1 + noise * error)))
    np.testing.assert_allclose(report.noise, noise, rtol=0.2)


def test_a_flipped_sensor_is_named():
    frf = sound()
    H = frf.H.copy()
    H[:, 2] *= -1
    report = rb.check(with_H(frf, H))
    assert report.gaining[2] > 0.99
    assert (report.gaining[[0, 1, 3]] == 0).all()
    assert any("driving point at x2 gives energy away on 100% of the lines" in line for line in report.warnings)


def test_a_driving_point_measured_beside_its_force_is_named():
    frf = sound()
    H = frf.H.copy()
    H[:, 2, 2] = H[:, 2, 0]  # a transfer FRF in place of the driving point: bouncing and rocking differ in sign
    assert 0.01 < np.mean(H[:, 2, 2].imag > 0) < 0.99
    report = rb.check(with_H(frf, H))
    assert 0.01 < report.gaining[2] < 0.99
    assert any("driving point at x2" in line for line in report.warnings)


def test_the_worst_reciprocity_is_named_with_its_place():
    frf = sound()
    H = frf.H.copy()
    H[310, 3, 0] += 0.5 * np.abs(H[310]).max()
    report = rb.check(with_H(frf, H))
    assert sorted(report.nonreciprocal_at[:2]) == ["x1", "y2"]
    assert report.nonreciprocal_at[2] == F[310]
    assert report.nonreciprocity == pytest.approx(0.5, rel=0.02)
    assert any("differ by" in line for line in report.warnings)
    assert report.nonreciprocity == pytest.approx(with_H(frf, H).reciprocity())


def test_a_gap_and_a_grid_too_coarse_for_the_damping_are_named():
    report = rb.check(sound(F[(F < 180) | (F > 185)]))
    assert report.gaps == ((179.5, 185.5),)
    assert any("No line lies between 179.5 and 185.5 Hz" in line for line in report.warnings)
    coarse = rb.check(sound(np.arange(5.0, 400.0, 1.0), zeta=np.array([0.02, 0.02, 0.004])))
    assert [f for f, lines in zip(coarse.peaks, coarse.resolution, strict=True) if lines < 4] == pytest.approx(
        [60, 250], rel=5e-3
    )
    assert any("half-power width of the peak at 250" in line for line in coarse.warnings)


def test_evenly_growing_spacing_is_no_gap():
    assert rb.check(sound(np.geomspace(5, 400, 900))).gaps == ()


def test_two_modes_at_one_place_are_seen():
    report = rb.check(sound(omega=OMEGA[[1, 1, 2]] * [1, 1.002, 1]))
    assert report.double.tolist() == [True, False]


def test_a_band_that_begins_above_the_first_peak_has_no_static_limit():
    report = rb.check(sound().between(100, 399))
    assert not report.reaches_static
    assert any("the static stiffness is not in the data" in line for line in report.warnings)


def test_notes_of_the_data_are_in_the_report_and_few_lines_are_refused():
    frf = rb.FRF(F, sound().H, notes=("Filled by reciprocity, not measured: x1 from y2.",))
    assert "not measured: x1 from y2." in str(rb.check(frf))
    with pytest.raises(ValueError, match="have 4 lines"):
        rb.check(sound(F[:4]))


@pytest.fixture(scope="module")
def hammered():
    """A sound set as a hammer and accelerometers measure it, from 1 Hz: below 20 Hz there is nothing but noise."""
    sensors = virtual_test.Sensors(force_noise=0.2, response_noise=3e-3)
    return averaging_module.spectra(
        virtual_test.hammer(sound_foundation(), sensors, rate=1280.0, block=1.0, seed=26)
    ).h1()


def test_noise_of_sensors_is_no_flaw_of_signs_reciprocity_or_modes(hammered):
    report = rb.check(hammered)
    # on the lowest lines receptances differ by more than their size, and driving points have the wrong sign
    assert hammered.reciprocity() > 0.5
    assert np.mean(np.einsum("nii->ni", hammered.H).imag > 0) > 0.01
    assert report.nonreciprocity == 0
    assert report.gaining.max() < 0.005
    np.testing.assert_allclose(report.peaks, [60, 130, 250], rtol=0.01)
    assert np.isnan(report.static).all()
    # a hammer's lines, 1 Hz apart, are too few for the first peak and no other warning is due
    assert [line for line in report.warnings if "half-power width" not in line] == []


def test_within_noise_what_is_wrong_is_still_named(hammered):
    H = hammered.H.copy()
    H[:, 2] *= -1
    H[:, 0, 3] *= 1.5
    report = rb.check(with_H(hammered, H))
    assert any("driving point at x2 gives energy away" in line for line in report.warnings)
    assert report.gaining[[0, 1, 3]].max() < 0.005
    assert report.nonreciprocity > 0.5


def test_the_noise_of_each_line_is_that_of_its_surroundings():
    # errors that fall with the square of the frequency: by a hundred from the first line to where the first peak begins
    frf, rng = sound(), np.random.default_rng(2)
    size = 1e-8 / frf.frequency**2
    error = (rng.standard_normal(frf.H.shape) + 1j * rng.standard_normal(frf.H.shape)) / np.sqrt(2)
    local, _ = _noise(with_H(frf, frf.H + size[:, None, None] * error))
    ratio = (local / size[:, None, None])[F < 50]
    # the median of 15 moduli scatters by some 25 %
    assert 0.9 < np.median(ratio) < 1.15
    assert np.mean((ratio > 0.5) & (ratio < 2)) > 0.99


def test_flat_and_empty_curves_get_a_report_too():
    nothing = rb.check(rb.FRF(F, np.zeros((len(F), 4, 4))))
    assert any("No peak stands out" in line for line in nothing.warnings)
    assert (nothing.noise == 0).all()


def test_the_foundation_of_this_book_is_reported(request):
    report = rb.check(rb.load_frf(request.config.rootpath / "data" / "foundation" / "fine"))
    assert report.nonreciprocity < 1e-6
    assert (report.gaining == 0).all()


def test_the_figure_marks_what_the_report_found():
    pytest.importorskip("matplotlib", reason="figures need matplotlib: pip install 'rbfound[plots]'")
    quality = pytest.importorskip("rbfound.plots.quality")
    frf = sound(F[(F < 180) | (F > 185)], zeta=np.array([0.02, 0.02, 0.002]))
    H = frf.H.copy()
    H[:, 2] *= -1
    flawed = with_H(frf, H)
    report = rb.check(flawed)
    indicator, reciprocity, noise, signs, resolution = quality.check_figure(flawed, report).axes
    named = [text.get_text() for text in indicator.get_legend().get_texts()]
    assert {"one mode", "too few lines for its damping", "no lines", "static limit"} <= set(named)
    assert "200 % of the largest" in reciprocity.get_title(loc="left")
    assert len(noise.texts) == 16
    assert [text.get_text() for text in signs.texts if "%" in text.get_text()] == ["0%", "0%", "100%", "0%"]
    few = [bar for bar in resolution.patches if bar.get_height() < 4]
    assert len(few) == int((report.resolution < 4).sum()) > 0
    assert len({bar.get_facecolor() for bar in resolution.patches}) == 2


def test_what_noise_was_integrated_to_on_the_first_line_is_no_static_limit():
    # one mode at 120 Hz from accelerations with noise, and at 0 Hz a number of no meaning
    f = np.arange(400.0)
    w = 2 * np.pi * f
    r = np.random.default_rng(0)
    noise = 3e-6 * (r.normal(size=400) + 1j * r.normal(size=400)) / np.maximum(w, 0.1) ** 2
    H = 1 / ((2 * np.pi * 120) ** 2 - w**2 + 2j * 0.02 * 2 * np.pi * 120 * w)
    assert rb.check(rb.FRF(f, H[:, None, None], labels=("x1",))).static == pytest.approx(H[0].real)
    H = H + noise
    H[0] = 0.77
    assert np.isnan(rb.check(rb.FRF(f, H[:, None, None], labels=("x1",))).static).all()


def test_a_band_narrower_than_a_resonance_is_not_said_to_hold_none():
    f = np.arange(748.0, 774.0, 0.1)
    H = 1 / (760.0**2 - f**2 + 2j * 0.02 * 760 * f)
    said = rb.check(rb.FRF(f, H[:, None, None], labels=("x1",))).warnings
    assert any("narrower than one, which a fit of modes may find" in line for line in said)
