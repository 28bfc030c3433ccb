"""A rotor and a foundation in few coordinates, against the same in all of theirs."""

from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound import thesis
from rbfound.theory import mount_reduced, reduced_foundation, reduced_rotor, round_rotor

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
    rotor, light = reduced_rotor(thesis.rotor(), PLACES, 2000.0), reduced_foundation(truth, 1000.0)
    whole = rb.mount(thesis.rotor(), bearings(k, c), on=truth if flexible else None)
    few = mount_reduced(rotor, bearings(k, c), light if flexible else None)
    assert len(few.system.M) < len(whole.M) / 2
    expected, found = (machine.at(speed).modes().above(1.0).below(600.0).poles for machine in (whole, few))
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_an_unbalance_moves_the_tip_as_it_does_in_the_whole_machine(truth: rb.Foundation) -> None:
    few = mount_reduced(
        reduced_rotor(thesis.rotor(), PLACES, 2000.0), bearings(1e8, 1e4), reduced_foundation(truth, 1000.0)
    )
    whole = rb.mount(thesis.rotor(), bearings(1e8, 1e4), on=truth)
    speeds = np.linspace(100.0, 2500.0, 40)
    expected = rb.unbalance_response(whole, speeds, {1.0: 1e-3})
    q = few.unbalance(speeds, 1.0, 1e-3)
    for direction, row in zip("xy", few.rotor.rows(1.0), strict=True):
        found = q[:, : len(row)] @ row
        np.testing.assert_allclose(found, expected[:, whole.coordinate(1.0, direction)], rtol=1e-4)


def test_the_modes_below_the_limit_stay_as_they_are_and_the_static_answer_is_exact(truth: rb.Foundation) -> None:
    light = reduced_foundation(truth, 1000.0)
    own = int((np.sqrt(np.diag(truth.K)) < rb.from_hertz(1000.0)).sum())
    assert own < len(light.M) < len(truth.M)
    np.testing.assert_allclose(light.modes().poles[:own], truth.modes().poles[:own], rtol=1e-9)
    np.testing.assert_allclose(np.abs(light.B[:, :own]), np.abs(truth.B[:, :own]), atol=1e-9 * np.abs(truth.B).max())
    static = [f.B @ np.linalg.solve(f.K, f.B.T) for f in (truth, light)]
    np.testing.assert_allclose(static[1], static[0], rtol=1e-10, atol=1e-12 * np.abs(static[0]).max())


def test_any_foundation_is_reduced_and_one_below_the_limit_only_changes_its_coordinates() -> None:
    printed = thesis.foundation()
    same = reduced_foundation(printed, 1000.0)
    lines = np.array([50.0, 200.0])
    np.testing.assert_allclose(same.frf(lines).H, printed.frf(lines).H, rtol=1e-9)


def test_a_disk_that_turns_is_felt_by_the_reduced_rotor_at_speed() -> None:
    rotor = rb.Rotor(rb.Shaft([0.2, 1.0, 0.3], [0.06, 0.08, 0.05]), {1.5: rb.Disk(40, 0.6, 1.2)}, 0.1)
    few = mount_reduced(reduced_rotor(rotor, [0.2, 1.2], 1000.0, blocks=2), bearings_at(0.2, 1.2), None)
    whole = rb.mount(rotor, bearings_at(0.2, 1.2))
    expected, found = (m.at(2000.0).modes().above(1.0).below(500.0).poles for m in (whole, few))
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def bearings_at(*places: float) -> dict[float, rb.Bearing]:
    return {z: rb.Bearing(kxx=1e8, kyy=1e8, cxx=1e4, cyy=1e4) for z in places}


def test_the_seats_of_both_planes_stand_in_the_order_x1_y1_x2_y2() -> None:
    rows = np.array([[3.0, 4.0], [5.0, 6.0]])
    rotor = round_rotor(np.array([1.0, 2.0]), rows, np.zeros((2, 2)), [0.1, 0.2])
    np.testing.assert_array_equal(rotor.body.B, [[3, 4, 0, 0], [0, 0, 3, 4], [5, 6, 0, 0], [0, 0, 5, 6]])
    assert rotor.body.labels == ("x1", "y1", "x2", "y2")
    np.testing.assert_array_equal(rotor.rows(0.2), [[5, 6, 0, 0], [0, 0, 5, 6]])
