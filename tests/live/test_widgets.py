"""The peak picker's traits, as a notebook's cells use them: no browser is needed."""

import re
from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound import thesis

widgets = pytest.importorskip("rbfound.live.widgets", reason="widgets need anywidget: pip install 'rbfound[widgets]'")

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"


@pytest.fixture(scope="module")
def fine() -> rb.FRF:
    return rb.load_frf(DATA / "fine")


@pytest.fixture
def picker(fine: rb.FRF) -> "widgets.PeakPicker":
    truth = rb.load_foundation(DATA / "truth.npz")
    return widgets.peak_picker(fine, thesis.rotor(), thesis.bearings(), truth)


def test_peaks_set_in_a_cell_give_the_foundation_of_pmsm(picker: "widgets.PeakPicker", fine: rb.FRF) -> None:
    picker.peaks = [159.5, 480.0, 626.0, 343.0]
    assert picker.peaks[0] == {"seat": "x1", "frequency": 159.5, "damping": None}
    damping = picker.picked.peaks.damping
    peaks = rb.Peaks(np.array([159.5, 480.0, 626.0, 343.0]), damping)
    same, condition = rb.pmsm(fine, peaks), rb.identification.pseudo_modes(fine, peaks).condition
    np.testing.assert_array_equal(picker.foundation.K, same.K)
    assert picker.message == ""
    told = "Peak picker, PMSM: x1 159.5, y1 480.0, x2 626.0, y2 343.0 Hz, cond(Phi) "
    assert repr(picker) == f"{told}{condition:.3g}"


def test_what_follows_can_be_observed(picker: "widgets.PeakPicker") -> None:
    seen: list[str] = []
    picker.observe(lambda change: seen.append(change["name"]), names=["foundation", "result", "message"])
    picker.peaks = picker.peaks[:3]
    assert sorted(seen) == ["foundation", "message", "result"]
    assert picker.foundation is None
    assert picker.picked is None
    assert picker.message == "Every seat needs one peak, 4 in all: y2 has none."
    assert repr(picker) == f"Peak picker, PMSM: {picker.message}"


def test_a_method_chosen_in_a_cell_brings_its_own_peaks_and_the_old_ones_come_back(
    picker: "widgets.PeakPicker",
) -> None:
    picker.peaks = [150.0, 350.0, 150.0, 350.0]
    picker.method = "distinct"
    assert picker.picked.condition < 2
    assert sorted(round(peak["frequency"]) for peak in picker.peaks) == [160, 343, 480, 626]
    picker.method = "pmsm"
    assert [peak["frequency"] for peak in picker.peaks] == [150.0, 350.0, 150.0, 350.0]
    with pytest.raises(Exception, match="guess"):
        picker.method = "guess"


def test_the_picture_sends_peaks_method_and_stamp_at_once_and_gets_its_stamp_back(picker: "widgets.PeakPicker") -> None:
    peaks = [{"seat": "x1", "frequency": f, "damping": None} for f in (160.0, 280.0, 480.0, 626.0)]
    picker.set_state({"peaks": peaks, "method": "distinct", "stamp": 7})
    assert picker.peaks == peaks
    assert picker.result["stamp"] == 7
    assert picker.result["method"] == "distinct"
    # the same peaks again are not computed again, but they are answered
    before = picker.picked
    picker.set_state({"peaks": peaks, "stamp": 8})
    assert picker.result["stamp"] == 8
    assert picker.picked is before


def test_a_question_sent_as_a_message_is_answered_like_a_change(picker: "widgets.PeakPicker") -> None:
    peaks = [
        {"seat": s, "frequency": f, "damping": None}
        for s, f in zip(("x1", "y1", "x2", "y2"), (160.0, 280.0, 480.0, 626.0), strict=True)
    ]
    # what ipywidgets does with a message of the front end
    picker._handle_custom_msg({"peaks": peaks, "method": "pmsm", "stamp": 9}, [])
    assert picker.peaks == peaks
    assert picker.result["stamp"] == 9
    np.testing.assert_array_equal(picker.foundation.M, rb.pmsm(picker.bench.frf, picker.picked.peaks).M)


def test_the_first_peaks_can_be_given() -> None:
    frf = rb.load_frf(DATA / "fine")
    picker = widgets.peak_picker(frf, peaks=[160, 344, 160, 344])
    assert [peak["frequency"] for peak in picker.peaks] == [160, 344, 160, 344]
    assert picker.scene["first"]["pmsm"] == picker.peaks
    assert picker.result["under"] == []
    with pytest.raises(ValueError, match="no method 'guess'"):
        widgets.peak_picker(frf, method="guess")
    with pytest.raises(ValueError, match="2 frequencies"):
        widgets.peak_picker(frf, peaks=[1, 2])


def test_the_front_end_asks_nothing_of_the_network() -> None:
    for text in (widgets.PeakPicker._esm, widgets.PeakPicker._css):
        assert not any(word in str(text) for word in ("http:", "https:", "fetch(", "XMLHttp", "import(", "url("))
        # a line that begins so is JavaScript's; the lines of Python that can be copied stand in a string
        assert not re.search(r"^\s*import\b", str(text), re.MULTILINE)
