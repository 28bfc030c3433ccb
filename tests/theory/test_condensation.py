"""A rotor and a foundation in few coordinates, against the same in all of theirs."""

from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound import thesis
from rbfound.theory import light_foundation, light_mount, light_rotor
from rbfound.theory.condensation import condensed

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"
PLACES = [0.045, 0.85, 1.0]


@pytest.fixture(scope="module")
def truth() -> rb.Foundation:
    return rb.load_foundation(DATA / "truth.npz")


def bearings(k: float, c: float) -> dict[float, rb.Bearing]:
    return {z: rb.Bearing(kxx=k, kyy=k, cxx=c, cyy=c) for z in PLACES[:2]}


# half the limit of the foundation's modes; what is left out there is of the order of (f / limit)^4 of a small part
@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize(("k", "c"), [(1e8, 1e4), (1e9, 1e3), (1e7, 1e3)])
@pytest.mark.parametrize("speed", [0.0, 2000.0])
def test_poles_are_those_of_the_whole_machine(
    truth: rb.Foundation, flexible: bool, k: float, c: float, speed: float
) -> None:
    rotor, light = light_rotor(thesis.rotor(), PLACES, 2000.0), light_foundation(truth, 1000.0)
    whole = rb.mount(thesis.rotor(), bearings(k, c), on=truth if flexible else None)
    few = light_mount(rotor, bearings(k, c), light if flexible else None)
    assert len(few.M) < len(whole.M) / 2
    expected, found = (machine.at(speed).modes().above(1.0).below(600.0).poles for machine in (whole, few))
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_an_unbalance_moves_the_tip_as_it_does_in_the_whole_machine(truth: rb.Foundation) -> None:
    few = light_mount(light_rotor(thesis.rotor(), PLACES, 2000.0), bearings(1e8, 1e4), light_foundation(truth, 1000.0))
    whole = rb.mount(thesis.rotor(), bearings(1e8, 1e4), on=truth)
    speeds = np.linspace(100.0, 2500.0, 40)
    expected = rb.unbalance_response(whole, speeds, {1.0: 1e-3})
    q = few.unbalance(speeds, 1.0, 1e-3)
    for direction, row in zip("xy", few.rows[1.0], strict=True):
        found = q[:, : len(row)] @ row
        np.testing.assert_allclose(found, expected[:, whole.coordinate(1.0, direction)], rtol=1e-4)


def test_the_modes_below_the_limit_stay_as_they_are_and_the_static_answer_is_exact(truth: rb.Foundation) -> None:
    light = light_foundation(truth, 1000.0)
    own = np.sqrt(np.diag(truth.K)) < rb.radians(1000.0)
    np.testing.assert_array_equal(np.diag(light.K)[: own.sum()], np.diag(truth.K)[own])
    np.testing.assert_array_equal(light.B[:, : own.sum()], truth.B[:, own])
    static = [f.B @ np.linalg.solve(f.K, f.B.T) for f in (truth, light)]
    np.testing.assert_allclose(static[1], static[0], rtol=1e-10, atol=1e-12 * np.abs(static[0]).max())


def test_a_coordinate_that_is_held_still_is_as_if_it_were_not_there(truth: rb.Foundation) -> None:
    rotor, light = light_rotor(thesis.rotor(), PLACES, 2000.0), light_foundation(truth, 1000.0)
    kept = [j for j in range(len(light.M)) if j != 2]
    fewer = [A[np.ix_(kept, kept)] for A in (light.M, light.C, light.K)]
    without = rb.Foundation(*fewer, light.B[:, kept], light.labels)
    one = light_mount(rotor, bearings(1e8, 1e4), light, kept)
    other = light_mount(rotor, bearings(1e8, 1e4), without)
    for name in "MCKG":
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_limit_above_all_modes_is_refused() -> None:
    squared = np.array([1.0, 4.0, 9.0])
    with pytest.raises(ValueError, match="no mode lies above"):
        condensed(squared, np.ones((1, 3)), 1e3)


def test_only_a_modal_foundation_is_made_light() -> None:
    with pytest.raises(ValueError, match="modal coordinates"):
        light_foundation(thesis.foundation(), 1000.0)
