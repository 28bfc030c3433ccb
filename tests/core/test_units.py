"""Hertz, revolutions per minute and radians per second."""

import numpy as np
from hypothesis import given, settings, strategies as st

import rbfound as rb

values = st.floats(min_value=-1e6, max_value=1e6)


def test_one_turn_a_second_is_one_hertz_and_sixty_revolutions_a_minute():
    # one turn is 2 pi rad, a minute has 60 s
    assert rb.hertz(2 * np.pi) == 1.0
    assert rb.from_hertz(1.0) == 2 * np.pi
    assert rb.rpm(2 * np.pi) == 60.0
    assert rb.from_rpm(60.0) == 2 * np.pi


def test_a_grid_speed_of_3000_revolutions_a_minute_is_100_pi():
    np.testing.assert_allclose(rb.from_rpm(3000), 100 * np.pi, rtol=1e-15)
    np.testing.assert_allclose(rb.hertz(rb.from_rpm(3000)), 50.0, rtol=1e-15)


@settings(max_examples=100)
@given(values)
def test_there_and_back_gives_the_same_number(value):
    # two roundings there, two back, each of half a unit in the last place
    np.testing.assert_allclose(rb.from_hertz(rb.hertz(value)), value, rtol=1e-15, atol=1e-300)
    np.testing.assert_allclose(rb.from_rpm(rb.rpm(value)), value, rtol=1e-15, atol=1e-300)


def test_lists_and_integer_arrays_come_back_as_arrays_of_the_same_shape():
    np.testing.assert_allclose(rb.from_hertz([1, 2, 3]), 2 * np.pi * np.array([1.0, 2.0, 3.0]))
    assert rb.hertz(np.ones((2, 3), dtype=int)).shape == (2, 3)
    assert rb.rpm([]).shape == (0,)


def test_a_scalar_comes_back_as_a_scalar():
    for convert in (rb.hertz, rb.from_hertz, rb.rpm, rb.from_rpm):
        assert np.ndim(convert(3)) == 0
        assert isinstance(convert(3), float)
