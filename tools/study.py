"""How accurate an identified foundation is, and how often its error bars hold the truth: many seeds of noise.

    python tools/study.py [seeds] [processes]

What is done is kept in _build/study, under a name that a change of the package, of the data or of this script changes:
called again after an interrupt, or with more seeds, the study goes on from there.

The truth is the solid foundation of data/foundation with all its modes; its FRFs at 0.5 Hz from 20 to 1000 Hz carry
complex normal noise of 1 or 5 % of each |H|. The rotor of the book stands on what `rb.fit_modes` makes of them, in
bearings of 1e7, 1e8 and 1e9 N/m. What is promised is in tests/identification/test_identification.py.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rbfound as rb
from rbfound.files import text_replaced
from rbfound.parallel import run

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "data" / "foundation" / "truth.npz"
KEPT = ROOT / "_build" / "study"
LINES = np.arange(0.5, 1000.25, 0.5)
BAND = (20.0, 1000.0)
STIFFNESS = (1e7, 1e8, 1e9)
LEVELS = (0.01, 0.05)


def noisy(frf: rb.FRF, level: float, seed: int) -> rb.FRF:
    """Complex normal errors of a standard deviation relative to each |H|."""
    e = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j]
    return rb.FRF(frf.frequency, frf.H * (1 + level * e / np.sqrt(2)), frf.labels)


def on(foundation: rb.Foundation, k: float) -> rb.Machine:
    """The rotor of the book in bearings of one stiffness on a foundation."""
    bearing = rb.Bearing(kxx=k, kyy=k, cxx=1e4, cyy=1e4)
    return rb.mount(rb.thesis.rotor(), dict.fromkeys(rb.thesis.bearings(), bearing), on=foundation)


def apart(true: Complex, found: Complex) -> tuple[Array, Array]:
    """Errors of frequency and damping of poles [%], (m,) and (m,)."""
    zeta, was = -found.real / np.abs(found), -true.real / np.abs(true)
    return 100 * np.abs(np.abs(found) / np.abs(true) - 1), 100 * np.abs(zeta / was - 1)


def one(level: float, seed: int) -> dict[str, Any]:
    """Errors, whether each interval holds the truth, and whether the foundation is stable and passive; all as lists."""
    truth = rb.load_foundation(DATA)
    fit = rb.fit_modes(noisy(truth.frf(LINES), level, seed), band=BAND)
    foundation = fit.foundation()
    own, poles = truth.modes().above(BAND[0]).below(BAND[1]).poles, foundation.modes().poles
    out = {"alone": apart(own, poles[np.abs(own[:, None] - poles).argmin(axis=1)])}
    held, stable = [], True
    for k in STIFFNESS:
        machine = on(foundation, k)
        true, bars = on(truth, k).at(0.0).modes().above(1).below(800).poles, rb.error_bars(fit, machine)
        near = np.abs(true[:, None] - bars.poles).argmin(axis=1)
        out[f"{k:g} N/m"] = apart(true, bars.poles[near])
        low, high = (end[near] for end in bars.interval(0.95))
        held.append((low < rb.hertz(true.imag)) & (rb.hertz(true.imag) < high))
        stable &= bool((machine.at(0.0).modes().poles.real <= 0).all())
    loss = np.linalg.eigvalsh(foundation.frf(LINES[::10]).H.imag)[:, -1]
    return {
        "off": {name: [part.tolist() for part in parts] for name, parts in out.items()},
        "held": [column.tolist() for column in held],
        "stable": stable,
        "passive": bool((loss <= 1e-12 * np.abs(loss).max()).all()),
    }


def kept(level: float) -> Path:
    """Where the results of a level of noise are kept."""
    sources = [DATA, Path(__file__), *sorted(Path(rb.__file__).parent.rglob("*.py"))]
    told = sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    return KEPT / f"{level:g}-{told[:16]}.json"


def main(seeds: int = 200, processes: int = 2) -> None:
    for level in LEVELS:
        title, path = f"{100 * level:g} % noise", kept(level)
        begun = json.loads(path.read_text()) if path.exists() else []

        def keep(found: list[dict[str, Any]], path: Path = path) -> None:
            text_replaced(path, json.dumps(found))

        with ProcessPoolExecutor(processes) as executor:
            found = run(partial(one, level), range(seeds), executor=executor, title=title, begun=begun, keep=keep)
        rows = {}
        for name in found[0]["off"]:
            f, zeta = (np.array([out["off"][name][part] for out in found]) for part in (0, 1))
            rows[name] = [
                np.median(f.max(axis=1)), f.max(), np.median(zeta.max(axis=1)), zeta.max()
            ]  # fmt: skip
        columns = ("frequency: median of the worst [%]", "worst [%]", "damping: median [%]", "worst damping [%]")
        print(f"\n{title}, {seeds} seeds, the worst mode of each")
        print(rb.table({"": list(rows), **dict(zip(columns, zip(*rows.values(), strict=True), strict=True))}, digits=2))
        for k, column in zip(STIFFNESS, zip(*(out["held"] for out in found), strict=True), strict=True):
            share = 100 * np.mean(column, axis=0)
            print(f"{k:g} N/m: the 95 % interval holds the truth in [%]", " ".join(f"{s:.0f}" for s in share))
        stable, passive = (sum(out[name] for out in found) for name in ("stable", "passive"))
        print(f"stable {stable} of {seeds}, passive {passive} of {seeds}")


if __name__ == "__main__":
    main(*(int(number) for number in sys.argv[1:]))
