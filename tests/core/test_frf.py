"""Frequency response functions."""

import numpy as np
import pytest

import rbfound as rb

FREQUENCY = np.array([10.0, 20.0, 30.0, 45.0])


def some_frf():
    H = np.arange(64).reshape(4, 4, 4) * (1 + 2j)
    return rb.FRF(FREQUENCY, H + H.transpose(0, 2, 1))


def test_the_seats_are_x1_y1_x2_y2_unless_said_otherwise():
    frf = some_frf()
    assert frf.labels == ("x1", "y1", "x2", "y2")
    assert [frf.seat(label) for label in frf.labels] == [0, 1, 2, 3]
    assert rb.FRF(FREQUENCY, np.ones((4, 2, 2)), ["x1", "y1"]).labels == ("x1", "y1")


def test_numbers_are_stored_as_floats_and_complex_numbers():
    frf = rb.FRF([1, 2], np.ones((2, 1, 1), dtype=int), ("x1",))
    assert frf.frequency.dtype == float
    assert frf.H.dtype == complex


def test_a_band_includes_both_its_ends():
    band = some_frf().between(20.0, 30.0)
    np.testing.assert_array_equal(band.frequency, [20.0, 30.0])
    np.testing.assert_array_equal(band.H, some_frf().H[1:3])
    assert band.labels == some_frf().labels


def test_a_band_without_a_line_is_an_error_that_says_what_there_is():
    with pytest.raises(ValueError, match="No line lies between 21 and 29 Hz: the FRFs reach from 10 to 45 Hz"):
        some_frf().between(21, 29)


def test_reciprocity_is_the_worst_difference_of_a_line_over_its_largest_receptance():
    H = np.zeros((2, 2, 2), dtype=complex)
    H[:] = [[4.0, 1.0], [1.0, 2.0]]
    assert rb.FRF([1, 2], H, ("x1", "y1")).reciprocity() == 0.0
    H[1, 0, 1] += 0.3j  # |0.3 i| / 4
    assert rb.FRF([1, 2], H, ("x1", "y1")).reciprocity() == pytest.approx(0.075)


def test_reciprocity_does_not_depend_on_the_unit():
    H = np.random.default_rng(1).standard_normal((4, 2, 2)) + 0j
    frf = rb.FRF(FREQUENCY, H, ("x1", "y1"))
    assert rb.FRF(FREQUENCY, 1e-9 * H, ("x1", "y1")).reciprocity() == pytest.approx(frf.reciprocity(), rel=1e-12)


def test_a_computed_foundation_is_reciprocal_and_a_gyroscopic_system_is_not():
    Phi = np.random.default_rng(2).standard_normal((4, 6))
    omega = np.arange(1, 7) * 200.0
    frf = rb.modal_foundation(Phi, omega, np.full(6, 0.02)).frf(np.arange(5, 200, 5.0))
    assert frf.reciprocity() < 1e-12
    rotor = rb.Rotor(rb.Shaft([0.5], [0.05]), {0.1: rb.Disk(5.0, 0.05, 0.1)})
    picked = np.eye(len(rotor.at(0.0).M))[[0, 1, -4, -3]]
    lines = np.array([60.0, 90.0])
    spinning = rb.FRF(lines, rotor.at(500.0).receptance(lines, picked, picked.T))
    assert spinning.reciprocity() > 1e-3


def test_velocity_and_acceleration_are_i_omega_and_minus_omega_squared_times_displacement():
    frf = some_frf()
    omega = 2 * np.pi * FREQUENCY[:, None, None]
    np.testing.assert_allclose(frf.mobility(), 1j * omega * frf.H, rtol=1e-15)
    np.testing.assert_allclose(frf.accelerance(), -(omega**2) * frf.H, rtol=1e-15)
    assert frf.mobility().shape == frf.accelerance().shape == (4, 4, 4)


def test_the_mobility_of_a_damper_at_resonance_is_one_over_c():
    # m = 1, k = (2 pi 10)^2, c = 3: at 10 Hz only the damper is left, v/f = 1/c, a/f = i omega / c
    omega = 2 * np.pi * 10
    frf = rb.FRF([10.0], rb.System([[1.0]], [[3.0]], [[omega**2]]).receptance(10.0), ("x1",))
    np.testing.assert_allclose(frf.mobility(), 1 / 3, rtol=1e-12)
    np.testing.assert_allclose(frf.accelerance(), 1j * omega / 3, rtol=1e-12)


def test_frequencies_that_do_not_ascend_are_an_error_with_both_numbers():
    with pytest.raises(ValueError, match=r"frequency\[2\] = 20 Hz follows 20 Hz"):
        rb.FRF([10.0, 20.0, 20.0], np.ones((3, 1, 1)), ("x1",))
    with pytest.raises(ValueError, match=r"frequency\[1\] = 5 Hz follows 10 Hz"):
        rb.FRF([10.0, 5.0], np.ones((2, 1, 1)), ("x1",))


@pytest.mark.parametrize("bad", [-1.0, float("nan"), float("inf")])
def test_a_frequency_that_is_negative_or_not_finite_is_an_error(bad):
    with pytest.raises(ValueError, match=rf"frequency\[0\] is {bad}"):
        rb.FRF([bad, 5.0], np.ones((2, 1, 1)), ("x1",))


def test_no_lines_are_an_error():
    with pytest.raises(ValueError, match=r"frequency has shape \(0,\)"):
        rb.FRF([], np.ones((0, 4, 4)))
    with pytest.raises(ValueError, match=r"frequency has shape \(1, 4\)"):
        rb.FRF([FREQUENCY], np.ones((4, 4, 4)))


def test_a_three_by_four_set_is_an_error_with_its_shape():
    with pytest.raises(ValueError, match=r"H has shape \(4, 3, 4\).*must be \(4, 4, 4\)"):
        rb.FRF(FREQUENCY, np.ones((4, 3, 4)))


def test_a_doubled_label_is_an_error():
    with pytest.raises(ValueError, match="x1, x1 are not all different"):
        rb.FRF(FREQUENCY, np.ones((4, 2, 2)), ("x1", "x1"))


def test_a_receptance_that_is_not_finite_is_named_with_its_line_and_seats():
    H = np.ones((4, 4, 4), dtype=complex)
    H[2, 1, 3] = np.nan
    with pytest.raises(ValueError, match="H at 30 Hz, response y1 to a force at y2, is"):
        rb.FRF(FREQUENCY, H)


def test_an_unknown_seat_is_an_error_that_lists_the_known_ones():
    with pytest.raises(ValueError, match="no seat 'z1': the seats are x1, y1, x2, y2"):
        some_frf().seat("z1")


def test_an_frf_cannot_be_changed_by_assignment():
    with pytest.raises(AttributeError):
        some_frf().labels = ("a",)


def test_of_sixteen_frfs_four_are_direct_four_cross_coupling_and_eight_cross_talk():
    frf = rb.FRF([1.0], np.ones((1, 4, 4)))
    kinds = frf.kinds()
    words, counts = np.unique(kinds, return_counts=True)
    assert dict(zip(words.tolist(), counts.tolist(), strict=True)) == {
        "direct": 4,
        "cross-coupling": 4,
        "cross-talk": 8,
    }
    assert (kinds[0, 1], kinds[0, 2], kinds[0, 3]) == ("cross-coupling", "cross-talk", "cross-talk")
    assert (kinds == kinds.T).all()
    # without cross-talk two bearings are left that do not know of each other
    np.testing.assert_array_equal(frf.without("cross-talk").H[0].real, np.kron(np.eye(2), np.ones((2, 2))))
    with pytest.raises(ValueError, match="no 'crosstalk' here"):
        frf.without("crosstalk")


def test_a_relative_error_is_taken_line_by_line():
    truth = np.array([[[3.0, 0], [0, 4]], [[1, 1], [1, 1]]]) * 1j
    np.testing.assert_allclose(rb.relative_error(truth * [[[1.1]], [[1]]], truth), [0.1, 0.0], atol=1e-15)
    np.testing.assert_allclose(rb.relative_error([2.0, 3], [1j, 3]), [np.sqrt(5), 0])
    with pytest.raises(ValueError, match="must be alike"):
        rb.relative_error([1.0], truth)


def test_noise_is_relative_complex_and_the_same_for_the_same_seed():
    frf = rb.FRF(np.arange(1.0, 2001.0), np.full((2000, 4, 4), 3e-9 - 4e-9j))
    e = frf.with_noise(0.02, seed=5).H / frf.H - 1
    # the mean of n squares of unit exponentials has a standard deviation of 1/sqrt(n); six of them are certain
    n = e.size
    assert np.mean(np.abs(e) ** 2) == pytest.approx(0.02**2, rel=6 / np.sqrt(n))
    # as much in one direction as across, and no more with one than with the other
    assert abs(np.mean(e**2)) < 6 * 0.02**2 / np.sqrt(n)
    assert abs(np.mean(e)) < 6 * 0.02 / np.sqrt(n)
    twice = frf.with_noise(0.04, seed=5).H / frf.H - 1
    np.testing.assert_allclose(twice, 2 * e, rtol=0, atol=20 * np.finfo(float).eps)
    other = frf.with_noise(0.02, seed=6).H / frf.H - 1
    assert np.mean(np.abs(other - e) ** 2) == pytest.approx(2 * 0.02**2, rel=6 * np.sqrt(2 / n))
