"""FRFs that no foundation can have: a fit of them says so first, and what has no phase is refused."""

import numpy as np
import pytest
from samples import LINES, known, noisy

import rbfound as rb
from rbfound.cli import main

FLAWS = {
    "a phase of the other sign": lambda H: H.conj(),
    "all channels flipped": lambda H: -H,
    "one sensor flipped": lambda H: H * np.array([1, 1, -1, 1])[:, None],
}
MACHINE = """speeds = [0, 3000]
foundation = "foundation.json"
[shaft]
length = [1.0]
diameter = [0.08]
[[bearing]]
position = 0.1
kxx = 1e8
[[bearing]]
position = 0.9
kxx = 1e8
"""


def flawed(flaw, seed=0):
    frf = noisy(known(seed=seed).frf(LINES[40:1000:4]), 0.01, seed)
    return rb.FRF(frf.frequency, FLAWS[flaw](frf.H))


@pytest.mark.parametrize("flaw", FLAWS)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 5))])
def test_a_model_that_misses_the_data_by_half_of_their_size_or_more_says_so_first(flaw, seed):
    try:
        first = rb.identify(flawed(flaw, seed)).notes[0]
    except ValueError as error:
        # a search that goes astray altogether ends here
        first = str(error)
    assert first.startswith(("Warning: this is no model of the data", "The fit did not converge", "No mode was found"))


@pytest.mark.parametrize("part", [np.abs, np.real])
@pytest.mark.parametrize("seed", range(3))
def test_what_has_no_phase_is_refused_and_the_check_says_so_first(part, seed):
    frf = noisy(known(seed=seed).frf(LINES[40:1000:4]), 0.01, seed)
    bare = rb.FRF(frf.frequency, part(frf.H))
    assert rb.check(bare).warnings[0].startswith("The FRFs have no phase")
    with pytest.raises(ValueError, match="The FRFs have no phase"):
        rb.identify(bare)
    assert rb.check(frf).has_phase


def test_the_commands_pass_the_warnings_of_a_foundation_on(tmp_path, capsys):
    rb.save_frf(flawed("one sensor flipped"), tmp_path / "set")
    assert main(["identify", str(tmp_path / "set"), "-o", str(tmp_path / "foundation.json")]) == 1
    assert "Warning: this is no model of the data" in capsys.readouterr().out
    (tmp_path / "machine.toml").write_text(MACHINE)
    assert main(["campbell", str(tmp_path / "machine.toml"), "--steps", "3"]) == 1
    out = capsys.readouterr().out
    assert "The foundation came with warnings:" in out
    assert "Warning: this is no model of the data" in out
