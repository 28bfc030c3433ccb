"""Windows, averaged spectra, H1, H2 and coherence, against closed forms and against scipy's Welch averages."""

import numpy as np
import pytest
from scipy import signal

from rbfound.foundation import modal_foundation
from rbfound.measurement import USABLE, Blocks, spectra, virtual_test
from rbfound.units import from_hertz

RATE, SAMPLES = 512.0, 256
OMEGA, ZETA = from_hertz(np.array([40.0, 95.0])), np.array([0.02, 0.03])
TRUTH = modal_foundation(0.1 * np.array([[1.0, 0.4], [0.3, -1.0]]), OMEGA, ZETA, ("x1", "y1"))


def noisy(force_noise, response_noise, averages, seed=0):
    sensors = virtual_test.Sensors(force_noise=force_noise, response_noise=response_noise)
    kept = {"rate": RATE, "block": SAMPLES / RATE, "averages": averages, "seed": seed}
    return spectra(virtual_test.shaker(TRUTH, "periodic", sensors, rms=1.0, **kept)), spectra(
        virtual_test.shaker(TRUTH, "periodic", rms=1.0, **kept)
    )


def test_blocks_of_another_shape_and_windows_without_sense_are_refused():
    with pytest.raises(ValueError, match=r"they must be \(2, averages, samples\)"):
        Blocks(RATE, np.zeros((2, 3, 8)), np.zeros((2, 3, 3, 8)), ("x1", "y1"))
    with pytest.raises(ValueError, match="rate is 0 Hz"):
        Blocks(0.0, np.zeros((1, 3, 8)), np.zeros((1, 1, 3, 8)), ("x1",))
    still = Blocks(RATE, np.zeros((1, 3, 8)), np.zeros((1, 1, 3, 8)), ("x1",))
    with pytest.raises(ValueError, match=r"The force at x1 has nothing at 64 Hz"):
        spectra(still)
    with pytest.raises(ValueError, match="decay is -1"):
        spectra(still, decay=-1.0)
    with pytest.raises(ValueError, match="force_window 0 s"):
        spectra(still, force_window=0.0)


def test_lines_go_from_the_first_above_0_hz_to_the_last_that_the_filter_leaves_alone():
    S = noisy(0, 0, 2)[0]
    np.testing.assert_allclose(S.frequency, np.arange(1, int(USABLE * SAMPLES) + 1) * RATE / SAMPLES)


@pytest.mark.parametrize("hann", [False, True])
def test_spectra_are_those_of_scipy(hann):
    rng = np.random.default_rng(1)
    force, response = rng.standard_normal((1, 6, 64)), rng.standard_normal((1, 1, 6, 64))
    S = spectra(Blocks(RATE, force, response, ("x1",)), hann=hann)
    options = {
        "fs": RATE, "window": "hann" if hann else "boxcar", "nperseg": 64, "noverlap": 0, "detrend": False,
    }  # fmt: skip
    f, x = force.ravel(), response.ravel()
    lines = slice(1, 1 + len(S.frequency))
    h1 = (signal.csd(f, x, **options)[1] / signal.welch(f, **options)[1])[lines]
    np.testing.assert_allclose(S.h1().H[:, 0, 0], -h1 / from_hertz(S.frequency) ** 2, rtol=1e-10)
    h2 = (signal.welch(x, **options)[1] / signal.csd(x, f, **options)[1])[lines]
    np.testing.assert_allclose(S.h2().H[:, 0, 0], -h2 / from_hertz(S.frequency) ** 2, rtol=1e-10)
    np.testing.assert_allclose(S.coherence()[:, 0, 0], signal.coherence(f, x, **options)[1][lines], rtol=1e-10)


def test_without_noise_h1_and_h2_are_the_truth_and_the_coherence_is_one():
    S, _ = noisy(0, 0, 3)
    truth = TRUTH.frf(S.frequency).H
    for frf in (S.h1(), S.h2()):
        np.testing.assert_allclose(frf.H, truth, rtol=1e-9)
    np.testing.assert_allclose(S.coherence(), 1, rtol=1e-12)


def test_noise_on_the_response_leaves_h1_right_and_makes_h2_too_large_by_its_part_of_the_power():
    sigma, averages = 5e-3, 400
    S, clean = noisy(0, sigma, averages)
    truth = TRUTH.frf(S.frequency).H
    ratio = SAMPLES * sigma**2 / clean.response
    assert 0.02 < np.median(ratio) < 20
    # complex errors of one part in sqrt(averages) of sqrt(N/S): three standard deviations, and 1 % of lines beyond
    off = np.abs(S.h1().H / truth - 1) / np.sqrt(ratio / averages)
    assert np.mean(off > 3) < 0.01
    assert abs(np.mean((S.h1().H / truth - 1) / np.sqrt(ratio / averages))) < 3 / np.sqrt(off.size)
    # noise over signal, from 400 blocks, is known to some 5 %, the product of X and F to as much again
    np.testing.assert_allclose(np.median(np.abs(S.h2().H / truth) / (1 + ratio)), 1, rtol=0.02)
    np.testing.assert_allclose(np.median(S.coherence() * (1 + ratio)), 1, rtol=0.02)


def test_noise_on_the_force_makes_h1_too_small_by_its_part_of_the_power_and_leaves_h2_right():
    sigma, averages = 0.5, 400
    S, clean = noisy(sigma, 0, averages)
    truth = TRUTH.frf(S.frequency).H
    ratio = SAMPLES * sigma**2 / clean.force[:, None, :]
    np.testing.assert_allclose(np.median(np.abs(S.h1().H / truth) * (1 + ratio)), 1, rtol=0.02)
    np.testing.assert_allclose(np.median(np.abs(S.h2().H / truth)), 1, rtol=0.02)
    np.testing.assert_allclose(np.median(S.coherence() * (1 + ratio)), 1, rtol=0.02)


def test_the_scatter_of_h1_is_what_the_coherence_says():
    # one component of the complex error has the variance (1 - c) / (2 n c) |H|^2
    sigma, averages = 1e-3, 40
    _, clean = noisy(0, sigma, averages)
    c = 1 / (1 + SAMPLES * sigma**2 / clean.response)
    truth = TRUTH.frf(clean.frequency).H
    forty = [noisy(0, sigma, averages, seed)[0] for seed in range(40)]
    errors = np.array([S.h1().H / truth - 1 for S in forty])
    expected = np.sqrt((1 - c) / (2 * averages * c))
    for part in (errors.real, errors.imag):
        # rms over 40 measurements, 4 FRFs and 100 lines: 16000 numbers, of which blocks of one seed share their force
        np.testing.assert_allclose(np.sqrt(np.mean((part / expected) ** 2)), 1, rtol=0.05)
    # and each measurement says so itself, but for the scatter of its coherence
    np.testing.assert_allclose(np.median(forty[0].deviation() / expected), 1, rtol=0.05)
    np.testing.assert_allclose(np.median(forty[0].errors() / (np.sqrt(2) * expected * np.abs(truth))), 1, rtol=0.05)


def test_one_block_has_no_errors_to_tell():
    with pytest.raises(ValueError, match="One block has a coherence of 1"):
        noisy(0, 1e-3, 1)[0].errors()


def test_an_exponential_window_adds_its_decay_to_every_mode_and_nothing_else():
    decay = 9.0
    S = spectra(virtual_test.hammer(TRUTH, rate=RATE, block=4.0), decay=decay)
    M, C, K = TRUTH.M, TRUTH.C, TRUTH.K
    moved = type(TRUTH)(M, C + 2 * decay * M, K + decay * C + decay**2 * M, TRUTH.B, TRUTH.labels)
    np.testing.assert_allclose(moved.modes().poles, TRUTH.modes().poles - decay, rtol=1e-12)
    lines = S.frequency > 10
    # what is cut off the pulse's filter, relative to accelerances that fall with the square of the frequency
    np.testing.assert_allclose(S.h1().H[lines], moved.frf(S.frequency[lines]).H, rtol=1e-4)
    assert S.h1().notes == ("An exponential window added 9 1/s to the decay of every mode.",)


def test_windows_make_neighbouring_lines_alike_by_as_much_as_is_said():
    # complex errors of an average over many lines: their variance tells how many lines are one
    rng = np.random.default_rng(3)
    lines, trials = 100, 300
    for kind, options in (("none", {}), ("hann", {"hann": True}), ("exponential", {"decay": 4 * RATE / SAMPLES})):
        force = np.zeros((1, trials, SAMPLES))
        if kind == "hann":
            force[:] = rng.standard_normal(force.shape)
        else:
            force[..., 5] = 1.0  # so that noise on either side of the blow counts
        response = rng.standard_normal((1, 1, trials, SAMPLES))
        blocks = [Blocks(RATE, force[:, k : k + 1], response[:, :, k : k + 1], ("x1",)) for k in range(trials)]
        found = [spectra(block, **options) for block in blocks]
        cross = np.array([S.cross[:lines, 0, 0] for S in found])
        shared = lines * np.mean(np.abs(cross.mean(axis=1)) ** 2) / np.mean(np.abs(cross) ** 2)
        # what is said holds at the start of the block: five samples on, the window has fallen
        fallen = np.exp(-2 * options.get("decay", 0) * 5 / RATE)
        # a variance from 300 complex numbers is known to 6 %
        assert shared == pytest.approx(fallen * found[0].alike, rel=0.2), kind
