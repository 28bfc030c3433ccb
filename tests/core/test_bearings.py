"""Any number of bearings: from files through identification to the machine and out again, 2n x 2n FRFs for n."""

import numpy as np
import pytest
from solver_files import DEGREES, assembled, read_ansys, read_bulk

import rbfound as rb
from rbfound.files import dmig, matrix27


def truth(bearings):
    """A block on springs with as many seats as the bearings have, some of whose modes lie in the band."""
    labels = tuple(f"{axis}{k + 1}" for k in range(bearings) for axis in "xy")
    rng = np.random.default_rng(bearings)
    modes = 3 + bearings
    return rb.modal_foundation(
        0.1 * rng.standard_normal((2 * bearings, modes)),
        rb.from_hertz(np.linspace(60.0, 420.0, modes)),
        np.full(modes, 0.02),
        labels,
    )


def machine_on(foundation, bearings):
    """A shaft on n bearings, and a disk at its end."""
    places = 0.3 * np.arange(bearings)
    rotor = rb.Rotor(
        rb.Shaft([places[-1] + 0.3], [0.05]), {float(places[-1]) + 0.3: rb.Disk(3.0, 0.01, 0.02)}, element=0.15
    )
    # one bearing alone has to hold the shaft's tilt by nothing: the machine is then free to swing
    return rb.mount(rotor, {float(z): rb.Bearing(5e6, 5e6, cxx=1e3, cyy=1e3) for z in places}, on=foundation)


@pytest.mark.parametrize(
    ("bearings", "ending"), [(1, ""), (2, ""), (4, ""), (4, ".mat"), pytest.param(8, ".npz", marks=pytest.mark.slow)]
)
def test_files_become_a_foundation_and_a_machine_whatever_the_number_of_bearings(bearings, ending, tmp_path):
    known = truth(bearings)
    rb.save_frf(known.frf(np.arange(20.0, 500.0, 1.0)), tmp_path / f"set{ending}")
    frf = rb.load_frf(tmp_path / f"set{ending}")
    assert frf.H.shape == (480, 2 * bearings, 2 * bearings)
    assert rb.check(frf).nonreciprocity < 1e-8
    found = rb.identify(frf)
    for kind in ("json", "npz", "mat"):
        rb.save_foundation(found, tmp_path / f"found.{kind}")
        back = rb.load_foundation(tmp_path / f"found.{kind}")
        assert back.labels == known.labels
        for name in "MCKB":
            np.testing.assert_array_equal(getattr(back, name), getattr(found, name))
    # all modes lie in the band and the files have nine digits: what is lost is the rounding and where the fit stops
    machines = [machine_on(body, bearings) for body in (back, known)]
    ours, theirs = (machine.at(rb.from_rpm(3000)).modes().above(5.0) for machine in machines)
    inside = rb.hertz(theirs.poles.imag) < 400
    assert inside.sum() >= 4
    for pole in theirs.poles[inside]:
        assert np.abs(ours.poles - pole).min() < 1e-4 * abs(pole)
    speeds = rb.from_rpm(np.linspace(0.0, 6000.0, 7))
    of_ours, of_theirs = (rb.campbell(machine, speeds, 6) for machine in machines)
    np.testing.assert_allclose(of_ours.frequency, of_theirs.frequency, rtol=1e-4)


@pytest.mark.parametrize("bearings", [1, 2, 4, 8])
def test_exports_tie_every_bearing_to_its_own_node(bearings):
    known = truth(bearings)
    nodes = [10 * (k + 1) for k in range(bearings)]
    matrices, ties, _ = read_ansys(matrix27(known, nodes))
    free = [(9001 + k // 6, DEGREES[k % 6]) for k in range(len(known.M))]
    seats = [(node, axis) for node in nodes for axis in ("UX", "UY")]
    for option, name in ((2, "M"), (4, "K"), (5, "C")):
        A, B = assembled(matrices[option], ties, free, seats)
        np.testing.assert_array_equal(A, getattr(known, name))
        np.testing.assert_array_equal(B, known.B)
    _, ties, _ = read_bulk(dmig(known, nodes))
    assert [tie[0][0] for tie in ties] == [(node, component) for node in nodes for component in (1, 2)]
    B = [[value for _, value in tie[1:]] for tie in ties]
    np.testing.assert_allclose(B, known.B, rtol=5.1e-10)


def test_a_bearing_takes_one_number_each_and_says_what_to_do_for_one_that_depends_on_speed():
    for value in ([1e6, 2e6], lambda speed: 1e6):
        with pytest.raises(ValueError, match=r"kxx is .* depend on speed"):
            rb.Bearing(kxx=value)
    with pytest.raises(ValueError, match=r"E is .* one number for all segments"):
        rb.Shaft([0.5, 0.5], [0.05, 0.06], E=[2e11, 1e11])


class OnOil:
    """A rotor in bearings whose damping falls with the speed: at rest they have none."""

    rotor = rb.Rotor(rb.Shaft([0.6], [0.1]), {0.2: rb.Disk(30.0, 0.3, 0.5)})

    def mounted(self, speed):
        film = rb.Bearing(kxx=1e7, kyy=2e7, cxx=1e6 / speed, cyy=2e6 / speed)
        return rb.mount(self.rotor, {0.0: film, 0.6: film})

    def at(self, speed):
        return self.mounted(speed).at(speed)

    def coordinate(self, z, direction):
        return self.mounted(1.0).coordinate(z, direction)


def test_a_machine_without_coefficients_at_rest_answers_at_its_speeds():
    speeds = np.array([100.0, 300.0])
    found = rb.unbalance_response(OnOil(), speeds, {0.2: 1e-4})
    for row, speed in zip(found, speeds, strict=True):
        np.testing.assert_allclose(
            row, rb.unbalance_response(OnOil().mounted(speed), [speed], {0.2: 1e-4})[0], rtol=1e-8, atol=1e-20
        )
    assert rb.unbalance_response(OnOil(), [], {}).shape[0] == 0


def test_the_critical_speeds_in_a_film_are_those_of_a_fine_count():
    speeds = np.linspace(20.0, 2000.0, 8)
    critical = rb.campbell(OnOil(), speeds).critical_speeds()
    fine = np.linspace(20.0, 2000.0, 200)
    above = np.array([(OnOil().at(s).modes().poles.imag > s).sum() for s in fine], dtype=int)
    assert len(critical.speed) == np.abs(np.diff(above)).sum() > 0
