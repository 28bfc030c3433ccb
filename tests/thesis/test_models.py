"""One door to the twelve models of the thesis."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound.thesis import models

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"


@pytest.mark.parametrize("letter", "abcdef")
def test_models_a_to_f_are_beams_that_stand_on_what_the_thesis_prints(letter):
    machine = rb.thesis.model(letter)
    assert isinstance(machine, rb.Machine)
    assert (machine.foundation is not None) == (letter in "def")


@pytest.mark.parametrize(("alone", "beside"), ["gj", "hk"])
def test_models_g_to_k_are_solids_that_keep_their_frequencies_side_by_side(alone, beside):
    pytest.importorskip("skfem", reason="the solid models need scikit-fem: pip install 'rbfound[solid]'")
    truth = rb.load_foundation(DATA / "truth.npz")
    machines = rb.thesis.model(alone), rb.thesis.model(beside, truth)
    assert [machine.foundation for machine in machines] == [None, truth]
    rotor, both = (m.at(0.0).modes().above(1.0).below(1200.0).frequency for m in machines)
    apart = np.sort(np.concatenate([rotor, truth.modes().below(1200.0).frequency]))
    np.testing.assert_allclose(both, apart, rtol=1e-9)


def test_models_j_k_and_l_stand_on_the_solid_foundation_unless_another_is_given(monkeypatch):
    pytest.importorskip("skfem", reason="the solid models need scikit-fem: pip install 'rbfound[solid]'")
    truth = rb.load_foundation(DATA / "truth.npz")  # is that foundation, and comes at once
    monkeypatch.setattr(models, "_solid_foundation", lambda: truth)
    assert all(rb.thesis.model(letter).foundation is truth for letter in "jkl")
    columns = rb.thesis.beside("l")
    # of the thesis's twelve frequencies those within 2 % have an error
    assert sum(error is not None for error in columns["error [%]"]) >= 5
    assert columns == rb.thesis.beside("l", truth)


@pytest.mark.parametrize("letter", ["m", "A", "", "ab", None])
def test_a_letter_that_is_no_model_is_an_error_that_says_which_there_are(letter):
    for function in (rb.thesis.model, rb.thesis.beside):
        with pytest.raises(ValueError, match="the letters are a to l"):
            function(letter)


@pytest.mark.parametrize("letter", "afgi")
def test_a_model_that_stands_on_no_foundation_or_on_a_printed_one_takes_none(letter):
    with pytest.raises(ValueError, match=f"Model {letter} takes no foundation"):
        rb.thesis.model(letter, rb.thesis.foundation())


def test_without_scikit_fem_a_sentence_says_what_models_g_to_l_need():
    code = "import sys; sys.modules['skfem'] = None; import rbfound as rb; rb.thesis.model('c'); rb.thesis.model('g')"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 1
    assert "ValueError: Models g to l are solids: pip install 'rbfound[solid]'" in run.stderr
