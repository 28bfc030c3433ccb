"""Exported foundations in the programs that they are for: ROSS, NASTRAN bulk data through pyNastran, GNU Octave.

python tools/crosscheck_exports.py [ROSS_PYTHON [NASTRAN_PYTHON]], which `make crosscheck` does: Pythons that have ROSS
and rbfound, and pyNastran (which wants another numpy). What is not there is skipped, and said.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rbfound as rb
from rbfound.files import dmig, read_arrays

Array = NDArray[np.float64]

ROSS_MISSING = "ROSS is not here: pip install 'rbfound[ross]'"
NASTRAN_MISSING = "pyNastran is not here: pip install pyNastran, into an environment of its own"
OCTAVE_MISSING = "GNU Octave is not on the PATH. On Debian or Ubuntu: apt-get install octave"

# Two programs, one theory: natural frequencies agree to this part of them.
AGREE = 1e-6
# Ten digits in a bulk data file.
DIGITS = 5.1e-10
DATA = Path(__file__).parent.parent / "data" / "foundation" / "truth.npz"
# With this argument the script runs where ROSS is and prints one number.
HERE = "--here"
SPEEDS = (0.0, 3000.0, 9000.0)  # [rev/min]
LINES = np.linspace(5.0, 300.0, 60)  # [Hz]

# Runs where pyNastran is, which knows nothing of rbfound: matrices and equations of a bulk data file as JSON.
READ_BULK = """
import json, sys
from pyNastran.bdf.bdf import BDF
model = BDF(debug=None)
model.read_bdf(sys.argv[1], punch=True, xref=False)
out = {"MPC": [list(map(list, zip(e.nodes, map(int, e.components), e.coefficients))) for e in model.mpcs[9001]]}
for name, card in model.dmig.items():
    matrix, rows, _ = card.get_matrix(is_sparse=False, apply_symmetry=True)
    out[name] = {"points": [rows[k][0] for k in range(len(rows))], "matrix": matrix.tolist()}
print(json.dumps(out, default=int))
"""

# Poles and receptances of a foundation's .mat file, and a file of FRFs that Octave itself writes.
IN_OCTAVE = """
load(argv(){1});
lines = dlmread(argv(){2});
n = rows(M);
poles = eig([zeros(n), eye(n); -M \\ K, -M \\ C]);
H = zeros(numel(lines), rows(B), rows(B));
for k = 1:numel(lines)
  w = 2 * pi * lines(k);
  H(k, :, :) = B * ((K + 1i * w * C - w ^ 2 * M) \\ B');
end
frequency = lines;
unit = "m/N";
save("-v7", argv(){3}, "frequency", "H", "labels", "unit", "poles");
"""


def square_foundation(seed: int = 2) -> rb.Foundation:
    """Four modes at four seats, with full matrices and cross-talk without any symmetry between the seats."""
    rng = np.random.default_rng(seed)
    phi = 0.15 * (np.eye(4) + 0.4 * rng.standard_normal((4, 4)))
    return rb.modal_foundation(
        phi, rb.from_hertz(np.array([50.0, 90.0, 140.0, 210.0])), np.array([0.02, 0.03, 0.02, 0.04])
    )


def full_foundation() -> rb.Foundation:
    """The foundation of the book in coordinates that are mixtures of its modes: full, symmetric M, C and K."""
    truth = rb.load_foundation(DATA)
    n = len(truth.M)
    mixed = np.eye(n) + 0.1 * np.random.default_rng(0).standard_normal((n, n))
    M, C, K = (mixed.T @ A @ mixed for A in (truth.M, truth.C, truth.K))
    return rb.Foundation((M + M.T) / 2, (C + C.T) / 2, (K + K.T) / 2, truth.B @ mixed, truth.labels)


def our_machine(foundation: rb.Foundation) -> rb.Machine:
    """A shaft of 1 m on two bearings at its ends, a disk in the middle, and the foundation under it."""
    rotor = rb.Rotor(rb.Shaft([0.5, 0.5], [0.05, 0.05]), {0.5: rb.Disk(20.0, 0.05, 0.1)}, element=0.05)
    bearing = rb.Bearing(1e7, 2e7, cxx=1e3, cyy=1e3)
    return rb.mount(rotor, {0.0: bearing, 1.0: bearing}, on=foundation)


def ross_machine(ross: Any, element: Any, foundation: rb.Foundation, elements: int = 20) -> Any:
    """The same in ROSS, the foundation on two nodes of its own; `element` is rbfound.files.FoundationElement."""
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
            element(foundation, n=one, n_link=two),
            ross.BearingElement(n=two, kxx=0.0, cxx=0.0),
        ],
        [ross.PointMass(n=one, m=0.0), ross.PointMass(n=two, m=0.0)],
    )


def worst_pole(ours: NDArray[np.complex128], theirs: NDArray[np.complex128]) -> float:
    """The largest distance of one of our poles to the nearest of theirs, as a part of it."""
    return float((np.abs(ours[:, None] - theirs).min(axis=1) / np.abs(ours)).max())


def at_ross() -> float:
    """How far ROSS' poles of the coupled machine are from ours, below 300 Hz; runs where ROSS is."""
    # only in the environment of ROSS
    import ross

    from rbfound.files import FoundationElement

    foundation = square_foundation()
    machine, model = our_machine(foundation), ross_machine(ross, FoundationElement, foundation)
    worst = 0.0
    for speed in rb.from_rpm(np.array(SPEEDS)):
        ours = machine.at(speed).modes().above(1.0).below(300.0).poles
        found = model.run_modal(float(speed), num_modes=48, sparse=False)
        worst = max(worst, worst_pole(ours, np.asarray(found.evalues)))
        if len(ours) < 6:
            raise ValueError(f"Only {len(ours)} modes lie below 300 Hz: too few to compare.")
    return worst


def at_nastran(python: str, foundation: rb.Foundation) -> float:
    """How far a bulk data file that pyNastran reads is from the foundation, as a part of each matrix' largest entry."""
    nodes = (1001, 1006)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "foundation.bdf"
        path.write_text(dmig(foundation, nodes), encoding="ascii")
        read = json.loads(_run([python, "-c", READ_BULK, str(path)]).splitlines()[-1])
    coordinates = list(range(9001, 9001 + len(foundation.M)))
    pairs = [(foundation.B, np.array([[b for *_, b in terms[1:]] for terms in read["MPC"]]))]
    for name in "MCK":
        found = read[f"{name}FOUND"]
        if found["points"] != coordinates:
            raise ValueError(f"{name}: pyNastran finds the scalar points {found['points']}.")
        pairs.append((getattr(foundation, name), np.array(found["matrix"])))
    for k, terms in enumerate(read["MPC"]):
        seat, points = terms[0], [[point, component] for point, component, _ in terms[1:]]
        if seat != [nodes[k // 2], 1 + k % 2, -1.0] or points != [[point, 0] for point in coordinates]:
            raise ValueError(f"MPC equation {k + 1} ties {seat} to {points}.")
    return max(float(np.abs(found - true).max() / np.abs(true).max()) for true, found in pairs)


def at_octave(program: str, foundation: rb.Foundation) -> tuple[float, float]:
    """How far Octave's poles and receptances of a foundation's .mat file are from ours; its own file is read back."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rb.save_foundation(foundation, folder / "foundation.mat")
        np.savetxt(folder / "lines.txt", LINES, fmt="%.17g")
        (folder / "solve.m").write_text(IN_OCTAVE, encoding="ascii")
        files = [str(folder / part) for part in ("foundation.mat", "lines.txt", "out.mat")]
        _run([program, "--no-gui", "--norc", "--quiet", str(folder / "solve.m"), *files])
        read = rb.load_frf(folder / "out.mat")
        theirs = read_arrays(folder / "out.mat", ["poles"])[0]["poles"].ravel()
    if read.labels != foundation.labels:
        raise ValueError(f"Octave wrote the seats {read.labels}.")
    ours = foundation.frf(LINES).H
    return worst_pole(foundation.modes().poles, theirs), float(np.abs(read.H - ours).max() / np.abs(ours).max())


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{command[0]} ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def _has(python: str, module: str) -> bool:
    found = shutil.which(python) is not None
    return found and subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode == 0


def main(ross: str = sys.executable, nastran: str = sys.executable) -> int:
    """Print how far each program is from rbfound; the number of those that are too far."""
    foundation = full_foundation()
    apart: list[tuple[str, float, float]] = []
    if _has(ross, "ross"):
        difference = float(_run([ross, __file__, HERE]).splitlines()[-1])
        apart.append(("ROSS: poles of a machine on a foundation with full cross-talk", difference, AGREE))
    else:
        print(f"Skipped: {ROSS_MISSING}.")
    if _has(nastran, "pyNastran"):
        title = f"pyNastran: DMIG and MPC of a foundation with {len(foundation.M)} modes"
        apart.append((title, at_nastran(nastran, foundation), DIGITS))
    else:
        print(f"Skipped: {NASTRAN_MISSING}.")
    octave = shutil.which("octave-cli")
    if octave:
        poles, receptances = at_octave(octave, foundation)
        apart.append(("GNU Octave: poles of a foundation's .mat file", poles, AGREE))
        apart.append(("GNU Octave: its receptances, in a .mat file that Octave wrote", receptances, AGREE))
    else:
        print(f"Skipped: {OCTAVE_MISSING}.")
    titles, found, most = zip(*apart, strict=True) if apart else ((), (), ())
    columns = ([f"{part:.1e}" for part in parts] for parts in (found, most))
    print(rb.table({"checked": titles, **dict(zip(("largest difference", "at most"), columns, strict=True))}))
    return sum(not difference <= allowed for _, difference, allowed in apart)


if __name__ == "__main__":
    if sys.argv[1:] == [HERE]:
        print(at_ross())
    else:
        sys.exit(min(main(*sys.argv[1:]), 1))
