"""Figures of bodies: what they draw is what the drawing's lengths say."""

import numpy as np
import pytest

pytest.importorskip("skfem", reason="the solid model needs scikit-fem: pip install 'rbfound[solid]'")
pytest.importorskip("matplotlib", reason="figures need matplotlib: pip install 'rbfound[plots]'")

import matplotlib.pyplot as plt

from rbfound.solid import COARSE, FoundationGeometry, foundation_solid
from rbfound.thesis.sketches import cut


def area(polygon: np.ndarray) -> float:
    """Area of a polygon (corners, 2) by the shoelace formula."""
    x, y = polygon.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def test_the_pads_middles_lie_on_the_pads_and_their_neighbourhood_does_not() -> None:
    g = FoundationGeometry()
    assert g.on_pads(g.pads.T).all()
    beside = g.pads + np.array([2.1 * g.pad_half_size, 0, 0])
    assert not g.on_pads(beside.T).any()
    assert (g.on_pads(g.pads.T, pedestal=1) == [True, True, False, False]).all()


def test_the_cut_through_the_foundation_has_the_area_of_its_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    g = FoundationGeometry()
    monkeypatch.setattr(plt, "show", lambda: None)
    cut(foundation_solid(grid=COARSE))
    (drawn,) = plt.gcf().axes[0].collections
    plt.close()
    head = g.shaft_height + g.head_width / 2
    pedestal = (
        2 * g.foot_half_length * g.foot_thickness
        + g.web * (head - g.foot_thickness - 2 * g.bore_radius)
        + 2 * g.house_length * (g.house_radius - g.bore_radius)
    )
    stator = 2 * g.stator_length * (g.stator_outer - g.stator_inner)
    # mm²; below the shaft the plane cuts chords of the circles between the elements' corners, a millimetre inside them.
    # The smallest part, the houses, is 1.6 % of the whole.
    assert sum(map(area, (path.vertices[:-1] for path in drawn.get_paths()))) == pytest.approx(
        1e6 * (2 * pedestal + stator), rel=6e-3
    )
