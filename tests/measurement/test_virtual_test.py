"""The virtual rig: what it measures is the truth but for the flaws that were asked for, each of its exact size."""

from dataclasses import replace

import numpy as np
import pytest

import rbfound as rb
from rbfound.measurement import spectra, virtual_test

PHI = 0.1 * np.array([[1.0, 0.4, 0.2], [0.1, -1.0, 0.5], [0.8, 0.3, -0.9], [0.2, -0.6, -0.7]])
OMEGA, ZETA = rb.from_hertz(np.array([60.0, 130.0, 210.0])), np.array([0.02, 0.015, 0.02])
TRUTH = rb.modal_foundation(PHI, OMEGA, ZETA)
RIG = {"rate": 640.0, "block": 4.0}


def apart(frf, truth, low=20.0):
    """Worst error, relative to the driving points that an entry lies between, above `low` [Hz]."""
    point = np.sqrt(np.abs(np.einsum("nii->ni", truth.H)))
    off = np.abs(frf.H - truth.H) / (point[:, :, None] * point[:, None, :])
    return off[frf.frequency > low].max()


def full(foundation):
    """The same foundation in coordinates in which no matrix is diagonal."""
    T = np.eye(3) + 0.3 * np.arange(9).reshape(3, 3)
    return rb.Foundation(
        T.T @ foundation.M @ T, T.T @ foundation.C @ T, T.T @ foundation.K @ T, foundation.B @ T, foundation.labels
    )


@pytest.mark.parametrize("foundation", [TRUTH, full(TRUTH)], ids=["modal", "full matrices"])
@pytest.mark.parametrize("tool", ["hammer", "burst", "periodic"])
def test_without_flaws_the_rig_measures_the_truth(tool, foundation):
    blocks = (
        virtual_test.hammer(foundation, **RIG) if tool == "hammer" else virtual_test.shaker(foundation, tool, **RIG)
    )
    frf = spectra(blocks).h1()
    # the filters ring for 1e-8 of a blow; accelerances at 20 Hz are a hundredth of those at 200
    assert apart(frf, TRUTH.frf(frf.frequency)) < 1e-5


def test_a_random_force_without_end_leaks_and_the_more_the_shorter_its_blocks():
    errors = []
    for block in (0.5, 1.0, 4.0):
        S = spectra(virtual_test.shaker(TRUTH, "random", rate=640.0, block=block, averages=60), hann=True)
        errors.append(apart(S.h1(), TRUTH.frf(S.frequency)))
        assert S.coherence().min() < 0.98
    assert errors[0] > errors[1] > errors[2] > 1e-3


def test_a_block_that_ends_before_the_answer_leaks_and_an_exponential_window_heals_it():
    # the slowest mode decays with 7.5 1/s: half a second leaves 2 % of it
    block, decay = 0.5, 10.0
    blocks = virtual_test.hammer(TRUTH, rate=640.0, block=block)
    plain, soft = spectra(blocks).h1(), spectra(blocks, decay=decay).h1()
    truth = TRUTH.frf(plain.frequency)
    M, C, K = TRUTH.M, TRUTH.C, TRUTH.K
    moved = rb.Foundation(M, C + 2 * decay * M, K + decay * C + decay**2 * M, TRUTH.B).frf(plain.frequency)
    assert apart(plain, truth) > 0.02
    assert apart(soft, moved) < 0.05 * apart(plain, truth)


def test_a_flipped_and_a_miscalibrated_sensor_multiply_their_rows():
    sensors = virtual_test.Sensors(gain={"y1": -1.0, "x2": 1.05})
    frf, clean = (spectra(virtual_test.shaker(TRUTH, "periodic", s, **RIG)).h1() for s in (sensors, None))
    np.testing.assert_allclose(frf.H, clean.H * np.array([1, -1, 1.05, 1])[:, None], rtol=1e-9)
    with pytest.raises(ValueError, match=r"gain has 'z1': the seats are x1, y1, x2, y2"):
        virtual_test.hammer(TRUTH, virtual_test.Sensors(gain={"z1": 2.0}), **RIG)


def test_the_mass_of_the_sensors_acts_like_mass_on_the_foundation():
    mass = 3.0
    frf = spectra(virtual_test.hammer(TRUTH, virtual_test.Sensors(mass=mass), **RIG)).h1()
    # another road: the mass in the foundation's own matrices
    heavier = rb.Foundation(TRUTH.M + mass * PHI.T @ PHI, TRUTH.C, TRUTH.K, PHI)
    assert (heavier.modes().frequency < TRUTH.modes().frequency).all()
    assert apart(frf, heavier.frf(frf.frequency)) < 1e-5
    assert apart(frf, TRUTH.frf(frf.frequency)) > 0.1
    assert frf.reciprocity() < 1e-4
    back = virtual_test.with_mass(frf, -mass)
    assert apart(back, TRUTH.frf(frf.frequency)) < 1e-5


def test_a_roving_sensor_makes_h_unsymmetric_and_can_be_taken_away_too():
    mass = 3.0
    frf = spectra(virtual_test.hammer(TRUTH, virtual_test.Sensors(mass=mass, roving=True), **RIG)).h1()
    # row by row, with the mass at that row's bearing alone
    for rows in (slice(0, 2), slice(2, 4)):
        heavier = rb.Foundation(TRUTH.M + mass * PHI[rows].T @ PHI[rows], TRUTH.C, TRUTH.K, PHI)
        lines = frf.frequency > 20
        expected = heavier.frf(frf.frequency).H
        np.testing.assert_allclose(frf.H[lines, rows], expected[lines, rows], atol=1e-4 * np.abs(expected[lines]).max())
    assert frf.reciprocity() > 0.05
    back = virtual_test.with_mass(frf, -mass, roving=True)
    assert apart(back, TRUTH.frf(frf.frequency)) < 1e-5


def test_a_window_is_taken_out_of_a_fit_to_the_last_digit_of_its_poles():
    decay = 6.0
    S = spectra(virtual_test.hammer(TRUTH, virtual_test.Sensors(response_noise=1e-3), **RIG), decay=decay)
    fit = rb.fit_modes(S.h1(), band=(20, 240), errors=S.errors())
    found = rb.identification.without_window(fit, decay)
    np.testing.assert_array_equal(found.Phi, fit.Phi)

    def poles(f):
        return f.omega[f.inside] * (-f.zeta[f.inside] + 1j * np.sqrt(1 - f.zeta[f.inside] ** 2))

    np.testing.assert_allclose(poles(found), poles(fit) + decay, rtol=1e-12)
    np.testing.assert_allclose(found.omega[found.inside], OMEGA, rtol=1e-3)
    np.testing.assert_allclose(found.zeta[found.inside], ZETA, rtol=0.02)
    # the covariance goes along: its Jacobian by differences
    k = int(np.flatnonzero(fit.inside)[1])
    n, m = fit.Phi.size, len(fit.omega)
    for at, name in ((n + k, "omega"), (n + m + k, "zeta")):
        step = 1e-6
        value = getattr(fit, name).copy()
        value[k] *= 1 + step
        ahead = rb.identification.without_window(replace(fit, **{name: value}), decay)
        unit = np.zeros(fit.covariance.shape)
        unit[at, at] = 1.0
        along = rb.identification.without_window(replace(fit, covariance=unit), decay).covariance
        slopes = [np.log(ahead.omega[k] / found.omega[k]) / step, np.log(ahead.zeta[k] / found.zeta[k]) / step]
        np.testing.assert_allclose(along[n + k, n + k], slopes[0] ** 2, rtol=1e-3, atol=1e-9)
        np.testing.assert_allclose(along[n + m + k, n + m + k], slopes[1] ** 2, rtol=1e-3, atol=1e-9)
    with pytest.raises(ValueError, match="the window alone with 50 1/s: no damping would be left"):
        rb.identification.without_window(fit, 50.0)


def test_errors_from_the_coherence_make_a_fit_that_knows_its_noise():
    inside = []
    for seed in range(12):
        S = spectra(virtual_test.hammer(TRUTH, virtual_test.Sensors(response_noise=0.05), seed=seed, **RIG))
        fit = rb.fit_modes(S.h1(), band=(20, 240), errors=S.errors())
        assert fit.inside.sum() == 3
        assert 1 <= fit.noise < 1.1
        assert "times the errors given" in str(fit.foundation())
        inside += list(np.abs(np.log(fit.omega[fit.inside] / OMEGA)) < 2 * fit.deviation[0][fit.inside])
    # 36 intervals of 95 %: fewer than 29 would come once in a thousand
    assert np.sum(inside) >= 29


def test_errors_of_another_shape_or_not_positive_are_refused():
    frf = TRUTH.frf(np.arange(20.0, 240.0))
    with pytest.raises(ValueError, match=r"errors has shape \(3,\): there must be one for each entry of H"):
        rb.fit_modes(frf, errors=np.ones(3))
    errors = np.abs(frf.H)
    errors[5, 1, 2] = 0.0
    with pytest.raises(ValueError, match=r"errors at 25 Hz, response y1 to a force at x2, is 0\.0"):
        rb.fit_modes(frf, errors=errors)


def test_settings_without_sense_are_refused():
    with pytest.raises(ValueError, match="width is 0: it must be positive"):
        virtual_test.hammer(TRUTH, width=0)
    with pytest.raises(ValueError, match="kind is 'sine': a shaker can be random, burst, periodic"):
        virtual_test.shaker(TRUTH, "sine")
    with pytest.raises(ValueError, match="mass is -1"):
        virtual_test.Sensors(mass=-1)
    undamped = rb.modal_foundation(PHI, OMEGA, [0.02, 0.0, 0.02])
    with pytest.raises(ValueError, match="The mode at 130 Hz is not damped"):
        virtual_test.hammer(undamped)


def test_the_same_seed_gives_the_same_measurement():
    sensors = virtual_test.Sensors(force_noise=0.1, response_noise=1e-3)
    one, two, other = (
        virtual_test.shaker(TRUTH, "random", sensors, averages=2, seed=seed, **RIG) for seed in (4, 4, 5)
    )
    np.testing.assert_array_equal(one.response, two.response)
    assert not np.array_equal(one.response, other.response)
