"""Files that others export, written for the tests: Universal Files through pyuff, and tables."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rbfound as rb


def table(path: Path, frf: rb.FRF) -> Path:
    """All FRFs in one table, to the last digit."""
    pairs = [(response, force) for response in frf.labels for force in frf.labels]
    names = [f"{response} from {force} {part} [m/N]" for response, force in pairs for part in ("re", "im")]
    parts = frf.H.reshape(len(frf.frequency), -1).view(float)
    heading = ",".join(["Frequency [Hz]", *names])
    np.savetxt(path, np.column_stack([frf.frequency, parts]), delimiter=",", header=heading, comments="", fmt="%.16e")
    return path


def universal(
    path: Path,
    frf: rb.FRF,
    kind: int = 8,
    unit: tuple[str, str] = ("m", "N"),
    binary: int = 0,
    flip: tuple[int, ...] = (),
    nodes: tuple[int, ...] = (7, 12),
) -> Path:
    """The FRFs of two bearings as datasets 58; the directions of some seats may be turned round."""
    pyuff = pytest.importorskip("pyuff", reason="UFF needs pyuff: pip install 'rbfound[uff]'")
    sets: list[Any] = []
    for i in range(4):
        for j in range(4):
            sign = (-1) ** (i in flip) * (-1) ** (j in flip)
            sets.append(
                pyuff.prepare_58(
                    binary=binary, func_type=4, id1="rig",
                    rsp_node=nodes[i // 2], rsp_dir=(1 + i % 2) * (-1) ** (i in flip),
                    ref_node=nodes[j // 2], ref_dir=(1 + j % 2) * (-1) ** (j in flip),
                    abscissa_spec_data_type=18, ordinate_spec_data_type=kind, orddenom_spec_data_type=13,
                    ordinate_axis_units_lab=unit[0], orddenom_axis_units_lab=unit[1],
                    data=sign * frf.H[:, i, j], x=frf.frequency,
                )
            )  # fmt: skip
    # adding: in its mode "overwrite" pyuff 2.5.8 writes over the heading of a binary set; it leaves that file open too
    path.unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        pyuff.UFF(str(path)).write_sets(sets, "add")
    return path
