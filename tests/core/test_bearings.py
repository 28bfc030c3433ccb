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
        rb.radians(np.linspace(60.0, 420.0, modes)),
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
