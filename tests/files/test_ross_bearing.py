"""The element of ROSS: ROSS' frequencies of the coupled machine are ours. Needs ross-rotordynamics 2.3 (plotly < 7)."""

import warnings

import numpy as np
import pytest
from crosscheck_exports import at_ross

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


def test_ross_finds_the_frequencies_of_our_machine(ross):
    assert at_ross() < TOLERANCE


def test_a_foundation_with_more_modes_than_seats_is_refused(ross):
    from rbfound.files import FoundationElement

    many = rb.modal_foundation(np.ones((4, 7)), np.arange(1.0, 8), np.zeros(7))
    with pytest.raises(ValueError, match="has 7 coordinates at 4 seats"):
        FoundationElement(many, 1, 2)
    with pytest.raises(ValueError, match="The seats are x1, y1"):
        FoundationElement(rb.modal_foundation(np.eye(2), [1.0, 2.0], [0, 0], ("x1", "y1")), 1, 2)
