"""Repeated and closely spaced modes, drawn at random: each is found once, whatever rounding does.

Every foundation with an axis or a plane of symmetry has them. What is promised without noise is FINEST, the part of |H|
at which the search ends.
"""

import numpy as np
import pytest

import rbfound as rb
from rbfound.identification.model_order import FINEST
from rbfound.identification.plscf import groups_of

LINES = np.arange(20.0, 400.5, 1.0)
LABELS = ("x1", "y1", "x2", "y2")


def drawn(seed, seats, alike, others, split=0.0):
    """A foundation with some modes that are alike but for `split`, a part of their frequency, and others anywhere."""
    rng = np.random.default_rng(seed)
    f = np.append(rng.uniform(60, 300) * (1 + split * np.arange(alike)), rng.uniform(40, 380, others))
    zeta = np.append(np.full(alike, 10 ** rng.uniform(-2.5, -1.3)), 10 ** rng.uniform(-2.5, -1.3, others))
    # shapes of modes that are alike are orthogonal: of others no data could tell how many there are
    like = np.linalg.qr(rng.standard_normal((seats, seats)))[0][:, :alike]
    Phi = 0.1 * np.hstack([like, rng.standard_normal((seats, others))])
    return rb.modal_foundation(Phi, rb.from_hertz(f), zeta, LABELS[:seats])


def noisy(H, level, seed):
    e = np.random.default_rng([seed, 1]).standard_normal((*H.shape, 2)) @ [1, 1j]
    return H * (1 + level * e / np.sqrt(2))


def fitted(H, seats):
    """Frequencies [Hz] in the band, ascending, and the fitted FRFs."""
    fit = rb.fit_modes(rb.FRF(LINES, H, LABELS[:seats]))
    return np.sort(fit.natural_frequency[fit.inside]), fit.foundation().frf(LINES).H


def off(H, true):
    """The largest error, as a part of the largest receptance."""
    return np.abs(H - true).max() / np.abs(true).max()


@pytest.mark.parametrize("split", [0.0, 1e-9, 1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize(
    ("seats", "alike", "others"), [(2, 2, 0), (2, 2, 2), (3, 3, 1), (4, 2, 4), (4, 3, 3), (4, 4, 1)]
)
def test_modes_that_are_alike_are_found_once_each(seats, alike, others, split):
    for seed in range(3):
        body = drawn([seed, seats, alike], seats, alike, others, split)
        true = body.frf(LINES).H
        frequency, H = fitted(true, seats)
        assert len(frequency) == alike + others, seed
        np.testing.assert_allclose(frequency, np.sort(rb.hertz(np.abs(body.modes().poles))), rtol=FINEST)
        assert off(H, true) < FINEST


@pytest.mark.parametrize(("seats", "alike", "others"), [(2, 2, 0), (4, 2, 2), (4, 3, 1)])
def test_rounding_decides_nothing(seats, alike, others):
    """Fifty draws of data that differ in the last digits: the same modes each time."""
    true = drawn([5, seats, alike], seats, alike, others).frf(LINES).H
    rng = np.random.default_rng(0)
    first = fitted(true, seats)[0]
    assert len(first) == alike + others
    for _ in range(50):
        near = true * (1 + 1e-13 * rng.standard_normal(true.shape))
        np.testing.assert_allclose(fitted(near, seats)[0], first, rtol=1e-6)


@pytest.mark.parametrize("level", [1e-3, 1e-2])
def test_in_noise_none_goes_astray_and_few_are_one_too_many(level):
    """Two of twenty may have another number of modes; the FRFs are right in all, to three times the noise."""
    other = 0
    for seed in range(20):
        body = drawn(seed, 4, 2 + seed % 2, 3, split=(0.0, 1e-4, 1e-2)[seed % 3])
        true = body.frf(LINES).H
        frequency, H = fitted(noisy(true, level, seed), 4)
        other += len(frequency) != 5 + seed % 2
        assert off(H, true) < 3 * level, seed
    assert other <= 2


def test_poles_are_grouped_by_their_distance_in_dampings():
    poles = np.array([-1 + 100j, -1 + 100.2j, -1 + 100.4j, -1 + 102j, -0.1 + 50j, -0.1 + 50.2j])
    assert [group.tolist() for group in groups_of(poles)] == [[4], [5], [0, 1, 2], [3]]
    assert groups_of(poles[:0]) == []
