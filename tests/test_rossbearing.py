"""The element of ROSS: ROSS' frequencies of the coupled machine are ours. Needs ross-rotordynamics 2.3 (plotly < 7)."""

import warnings

import numpy as np
import pytest

import rbfound as rb

# two programs, one theory: what is left is rounding
TOLERANCE = 1e-9

pytestmark = [
    pytest.mark.slow,  # importing ROSS takes some seconds
    pytest.mark.filterwarnings("ignore"),
]


@pytest.fixture(scope="module")
def ross():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("ross", reason="ROSS is not here: pip install 'rbfound[ross]'", exc_type=ImportError)


def square(seed=2):
    """A foundation with full matrices, cross-talk without any symmetry between the seats."""
    rng = np.random.default_rng(seed)
    phi = 0.15 * (np.eye(4) + 0.4 * rng.standard_normal((4, 4)))
    return rb.modal_foundation(
        phi, rb.radians(np.array([50.0, 90.0, 140.0, 210.0])), np.array([0.02, 0.03, 0.02, 0.04])
    )


def ross_machine(ross, foundation, elements=20):
    """A shaft of 1 m on two bearings at its ends, a disk in the middle, and the foundation on two nodes of its own."""
    from rbfound.rossbearing import FoundationElement

    steel = ross.Material("steel", rho=7850, E=2.1e11, Poisson=0.3)
    shaft = [ross.ShaftElement(1.0 / elements, 0.0, 0.05, material=steel, shear_effects=True) for _ in range(elements)]
    disk = ross.DiskElement(n=elements // 2, m=20.0, Id=0.05, Ip=0.1)
    one, two = elements + 1, elements + 2
    return ross.Rotor(
        shaft,
        [disk],
        [
            ross.BearingElement(n=0, n_link=one, kxx=1e7, kyy=2e7, cxx=1e3, cyy=1e3),
            ross.BearingElement(n=elements, n_link=two, kxx=1e7, kyy=2e7, cxx=1e3, cyy=1e3),
            FoundationElement(foundation, n=one, n_link=two),
            ross.BearingElement(n=two, kxx=0.0, cxx=0.0),
        ],
        [ross.PointMass(n=one, m=0.0), ross.PointMass(n=two, m=0.0)],
    )


def test_ross_finds_the_frequencies_of_our_machine(ross):
    foundation = square()
    model = ross_machine(ross, foundation)
    rotor = rb.Rotor(rb.Shaft([0.5, 0.5], [0.05, 0.05]), {0.5: rb.Disk(20.0, 0.05, 0.1)}, element=0.05)
    bearing = rb.Bearing(1e7, 2e7, cxx=1e3, cyy=1e3)
    machine = rb.mount(rotor, {0.0: bearing, 1.0: bearing}, on=foundation)
    speed = float(rb.from_rpm(3000))
    modes = machine.at(speed).modes()
    ours = modes.poles[rb.hertz(modes.poles.imag) < 300]
    theirs = np.array(model.run_modal(speed, num_modes=48, sparse=False).wd)
    assert len(ours) >= 6
    for pole in ours:
        assert np.abs(theirs - pole.imag).min() < TOLERANCE * pole.imag, rb.hertz(pole.imag)


def test_a_foundation_with_more_modes_than_seats_is_refused(ross):
    from rbfound.rossbearing import FoundationElement

    many = rb.modal_foundation(np.ones((4, 7)), np.arange(1.0, 8), np.zeros(7))
    with pytest.raises(ValueError, match="has 7 coordinates at 4 seats"):
        FoundationElement(many, 1, 2)
    with pytest.raises(ValueError, match="The seats are x1, y1"):
        FoundationElement(rb.modal_foundation(np.eye(2), [1.0, 2.0], [0, 0], ("x1", "y1")), 1, 2)
