"""Poly-reference least-squares complex frequency and its stabilisation chart."""

import numpy as np
import pytest

import rbfound as rb

LINES = np.arange(20.0, 1000.25, 0.5)
F_N = np.array([62.0, 150.0, 187.0, 330.0, 480.0, 640.0, 871.0])
ZETA = np.array([0.016, 0.013, 0.0105, 0.01, 0.018, 0.019, 0.016])


def known(f_n=F_N, zeta=ZETA, seats=4):
    labels = tuple(f"s{k}" for k in range(seats))
    Phi = 0.1 * np.random.default_rng(1).standard_normal((seats, len(f_n)))
    return rb.modal_foundation(Phi, 2 * np.pi * np.asarray(f_n), np.broadcast_to(zeta, np.shape(f_n)), labels)


def noisy(frf, level, seed=0):
    """Complex normal errors, independent of one another, of a standard deviation relative to each |H|."""
    e = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j]
    return rb.FRF(frf.frequency, frf.H * (1 + level * e / np.sqrt(2)), frf.labels)


def test_the_stable_poles_of_clean_data_are_the_poles_that_made_them():
    # z maps s exactly, but the numerator in z only nearly: 1e-4 of a frequency is what an order of 20 leaves
    poles, participation = rb.identification.stable_poles(rb.identification.stabilisation(known().frf(LINES)))
    np.testing.assert_allclose(np.abs(poles), 2 * np.pi * F_N, rtol=1e-3)
    np.testing.assert_allclose(-poles.real / np.abs(poles), ZETA, rtol=0.05)
    # H is symmetric: what drives a mode is its own shape
    assert np.diag(rb.mac(known().B, participation.T)).min() > 0.98


@pytest.mark.parametrize("level", [0.01, 0.05])
def test_with_noise_every_pole_that_is_called_stable_is_one_of_the_true_ones(level):
    for seed in range(5):
        poles, _ = rb.identification.stable_poles(
            rb.identification.stabilisation(noisy(known().frf(LINES), level, seed))
        )
        apart = np.abs(np.abs(poles)[:, None] / (2 * np.pi * F_N) - 1).min(axis=1)
        assert apart.max() < 0.01
        assert len(poles) >= 5


def test_the_chart_holds_its_orders_ascending_and_poles_that_lose_energy():
    chart = rb.identification.stabilisation(known().frf(LINES), orders=[12, 8, 10])
    np.testing.assert_array_equal(chart.orders, [8, 10, 12])
    assert (chart.poles.real < 0).all()
    assert (chart.poles.imag > 0).all()
    np.testing.assert_allclose(np.linalg.norm(chart.participation, axis=1), 1)
    assert chart.stable[chart.order == 12].sum() >= 7
    # nothing stands before the lowest order
    assert not chart.stable[chart.order == 8].any()
    assert chart.band == (20.0, 1000.0)


def test_poles_do_not_depend_on_the_unit_of_the_frfs_nor_on_the_order_of_the_seats():
    frf = noisy(known().frf(LINES), 0.01)
    turn = [2, 0, 3, 1]
    other = rb.FRF(LINES, 1000 * frf.H[:, turn][:, :, turn], frf.labels)
    a, b = (rb.identification.stabilisation(x, orders=range(6, 12)) for x in (frf, other))
    np.testing.assert_allclose(a.poles, b.poles, rtol=1e-6)


def test_one_seat_and_six_are_served_too():
    for seats in (1, 2, 6):
        truth = known(F_N[1::2], 0.01, seats)
        poles, _ = rb.identification.stable_poles(rb.identification.stabilisation(truth.frf(LINES)))
        np.testing.assert_allclose(np.abs(poles), 2 * np.pi * F_N[1::2], rtol=1e-3)


def test_a_band_that_holds_no_lines_is_an_error_with_the_reach_of_the_data():
    frf = known().frf(LINES)
    with pytest.raises(ValueError, match=r"from 2000 to 3000 Hz lies outside the FRFs, which reach from 20 to 1000 Hz"):
        rb.identification.stabilisation(frf, band=(2000, 3000))
    with pytest.raises(ValueError, match="from 500 to 100 Hz is none"):
        rb.identification.stabilisation(frf, band=(500, 100))


def test_an_order_that_the_lines_do_not_carry_is_an_error_with_the_highest_that_they_do():
    frf = known().frf(np.arange(20.0, 1000.0, 20.0))
    with pytest.raises(ValueError, match=r"Order 20 is too high: 49 lines from 20 to 980 Hz and 4 seats allow 8"):
        rb.identification.stabilisation(frf, orders=range(4, 21))


@pytest.mark.parametrize("orders", [[5], [0, 4], []])
def test_fewer_than_two_orders_or_an_order_below_one_is_an_error(orders):
    with pytest.raises(ValueError, match=r"give at least two, each at least 1"):
        rb.identification.stabilisation(known().frf(LINES), orders=orders)


def test_no_stable_pole_is_an_error_that_says_how_long_the_longest_cluster_was():
    e = np.random.default_rng(3).standard_normal((500, 4, 4, 2)) @ [1, 1j]
    with pytest.raises(ValueError, match=r"No stable pole between 1 and 500 Hz: the longest cluster holds \d+ of 1"):
        rb.identification.stable_poles(rb.identification.stabilisation(rb.FRF(np.arange(1.0, 501.0), e)), share=0.9)
