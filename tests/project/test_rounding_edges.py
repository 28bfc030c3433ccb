"""Numbers of a notebook that lie at a rounding edge."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import rounding_edges
from rounding_edges import complaints

ROOT = Path(rounding_edges.__file__).parent.parent


def runs(*values, how="number", by=4, texts=None):
    """Runs of a notebook of one cell that prints one number, under as many kinds."""
    texts = texts or ["alike"] * len(values)
    return {
        f"kind {k}": [[7, text, [[how, by, v, 0.0]]]] for k, (v, text) in enumerate(zip(values, texts, strict=True))
    }


def test_what_prints_differently_is_listed_with_both_lines():
    (line,) = complaints(runs(1.0, 1.0, texts=["a\n8861 rev/min", "a\n8862 rev/min"]))
    assert line == "  cell 7: prints otherwise under kind 1: 8861 rev/min | 8862 rev/min"


@pytest.mark.parametrize(
    ("how", "by", "values"),
    [
        ("number", 4, (8861.48, 8861.483)),  # 0.02 from the edge, which ten times the spread reaches
        ("format", ".1f", (0.25 + 1e-14, 0.25 + 1e-14)),  # within 1e-12 of itself
        ("format", ".2f", (-1e-17, 1e-17)),  # -0.00 or 0.00
        ("round", 2, (0.1249999, 0.1249998)),
        ("bound", 1e-11, (2e-12, 5e-12)),
    ],
)
def test_a_number_nearer_to_an_edge_than_ten_times_its_spread_is_listed(how, by, values):
    assert len(list(complaints(runs(*values, how=how, by=by)))) == 1


@pytest.mark.parametrize(
    ("how", "by", "values"),
    [
        ("number", 4, (8861.48, 8861.4801)),
        ("format", ".0f", (2.5, 2.5)),  # a half that was typed in is no matter of rounding
        ("format", ".1f", (1e-5, 2e-5)),  # a size: it gets no minus sign
        ("bound", 1e-11, (1e-16, 3e-14)),
    ],
)
def test_a_number_far_from_an_edge_is_not_listed(how, by, values):
    assert list(complaints(runs(*values, how=how, by=by))) == []


def test_every_formatted_number_that_is_printed_is_kept_in_full(tmp_path):
    cells = [
        "import numpy as np\nimport rbfound as rb\nx, count = 1 / 3, 7",
        "text = f'{x:.3f} of {count}, {x!r}'\nunseen = f'{2 * x:.5f}'",
        "print(text, rb.table({'a': [x]}, digits=2), rb.bound(x * 1e-9, rounding=1e-10))",
        "np.round(x, 1), np.array([x]).round(2), round(x, 3)",
    ]
    path = tmp_path / "some.ipynb"
    path.write_text(json.dumps({"cells": [{"cell_type": "code", "source": [cell]} for cell in cells]}))
    env = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "agg"}
    child = [sys.executable, rounding_edges.__file__, "--child", str(path)]
    told = json.loads(subprocess.run(child, capture_output=True, check=True, env=env).stdout)
    kept = [(how, by, value) for _, _, numbers in told for how, by, value, _ in numbers]
    x = 1 / 3
    assert ("format", ".3f", x) in kept
    assert ("number", 2, x) in kept
    assert ("bound", 1e-10, x * 1e-9) in kept
    assert [("round", digits, x) in kept for digits in (1, 2, 3)] == [True] * 3
    assert not any(np.isclose(value, 2 * x) for _, _, value in kept)
