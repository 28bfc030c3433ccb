"""Identification beside sdypy-EMA, pyFBS and SDynPy: what each gets wrong, and what it costs, in one run.

`make bench` installs the peers into an environment of their own, runs this script and writes identification.md.
All tools get the same noisy receptances and the same band, on one BLAS thread. Poles have to be picked from each
peer's stabilisation chart by somebody: here by one who knows the true frequencies, which no user does.
"""

import contextlib
import io
import os
import platform
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

# before numpy and Qt are loaded: one thread, no window, no word from Qt about where its files would go
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MPLBACKEND="agg")
os.environ.update(QT_QPA_PLATFORM="offscreen", QT_LOGGING_RULES="*=false")

import numpy as np
import sdynpy
from numpy.typing import NDArray
from pyfbs.modal_id import ModalID
from sdypy import EMA

import rbfound as rb

Array = NDArray[np.float64]

LINES = np.arange(0.5, 1000.25, 0.5)
BAND = (20.0, 1000.0)
IN_BAND = np.array([62.0, 150.0, 187.0, 330.0, 480.0, 640.0, 871.0])
ABOVE = np.array([1150.0, 1500.0, 2100.0, 3000.0])
LEVELS = (0.0, 0.01, 0.05)
SEEDS = range(3)
REPEATS = 5
# Where the static remainder of a peer is put as modes, and up to where coupled frequencies count [Hz].
FAR, LIMIT = 4000.0, 800.0


@dataclass(frozen=True)
class Found:
    """What a tool found: poles (m,) [rad/s], shapes (4, m) or None, static remainder of the band (4, 4) or None."""

    poles: NDArray[np.complex128]
    Phi: Array | None = None
    remainder: Array | None = None
    foundation: rb.Foundation | None = None


# --- the tools ---


def rbfound_identify(frf: rb.FRF, hints: Array) -> Found:
    fit = rb.fit_modes(frf, band=BAND)
    own = fit.inside
    poles = fit.omega * (-fit.zeta + 1j * np.sqrt(1 - fit.zeta**2))
    return Found(poles[own], fit.Phi[:, own], None, fit.foundation())


def rbfound_poles(frf: rb.FRF, hints: Array) -> Found:
    return Found(rb.identification.stable_poles(rb.identification.stabilisation(frf, band=BAND))[0])


def sdypy(order: int, *, model: bool) -> Callable[[rb.FRF, Array], Found]:
    """sdypy-EMA: least-squares complex frequency, poles by its own select_closest_poles, real constants."""

    def run(frf: rb.FRF, hints: Array) -> Found:
        rows = frf.H.reshape(len(frf.frequency), -1).T
        fit = EMA.Model(rows, frf.frequency, lower=BAND[0], upper=BAND[1], pol_order_high=order, frf_form="receptance")
        fit.get_poles("lscf", show_progress=False)
        if not model:
            return Found(np.concatenate(fit.all_poles))
        fit.select_closest_poles(list(hints))
        fit.get_constants("lsfd_proportional")
        omega, zeta = rb.from_hertz(fit.nat_freq), fit.nat_xi
        # its own shapes are those of one column and a-normalised: the best that all sixteen constants give is taken
        values, vectors = np.linalg.eigh(symmetric(np.moveaxis(fit.A.reshape(4, 4, -1), -1, 0)))
        Phi = (vectors[:, :, -1] * np.sqrt(np.abs(values[:, -1:]))).T
        return Found(omega * (-zeta + 1j * np.sqrt(1 - zeta**2)), Phi, symmetric(fit.UR.real.reshape(4, 4)))

    return run


def pyfbs(order: int, *, model: bool) -> Callable[[rb.FRF, Array], Found]:
    """pyFBS: poly-reference least-squares complex frequency, then least squares with real participation."""

    def run(frf: rb.FRF, hints: Array) -> Found:
        part = frf.between(*BAND)
        fit = ModalID(part.frequency, part.H)
        fit.p_lscf(order)
        if not model:
            return Found(np.concatenate([poles[0] for poles in fit.poles]))
        _, frequency, damping, kind = fit.stab_plot.T
        poles = rb.from_hertz(frequency) * (-damping / 100 + 1j * np.sqrt(1 - (damping / 100) ** 2))
        taken = [fit.p_l_from_index(k) for k in picked(poles, kind == 3, hints)]
        fit.selected_poles = np.array([pole for pole, _ in taken])
        fit.selected_mpf = np.array([participation for _, participation in taken]).T
        fit.p_lsfd("receptance", assume_proportional=True, reconstruction=False)
        fit.normalize([0, 1, 2, 3], [0, 1, 2, 3], check_dp=False)
        return Found(fit.selected_poles, fit.phi_o, symmetric(fit.au.real))

    return run


def sdynpy_polypy(*, model: bool) -> Callable[[rb.FRF, Array], Found]:
    """SDynPy: PolyPy of the orders 8 to 60, real shapes. From receptances its shapes have no scale: accelerances."""
    seats = sdynpy.coordinate_array(np.arange(1, 5), 1)
    pairs = sdynpy.coordinate.outer_product(seats, seats)

    def run(frf: rb.FRF, hints: Array) -> Found:
        omega = np.asarray(rb.from_hertz(frf.frequency))
        data = np.moveaxis(frf.H, 0, -1) * -(omega**2)
        kind = sdynpy.data.FunctionTypes.FREQUENCY_RESPONSE_FUNCTION
        fit = sdynpy.PolyPy(sdynpy.data_array(kind, frf.frequency, data, pairs), *BAND, displacement_derivative=2)
        fit.compute_poles(np.arange(8, 61, 4))
        chart = np.concatenate(fit.pole_list)
        poles = chart["omega"] * (-chart["zeta"] + 1j * np.sqrt(1 - chart["zeta"] ** 2))
        if not model:
            return Found(poles)
        taken = picked(poles, chart["part_stable"], hints)
        fit.compute_shapes(chart[taken], real_modes=True)
        far = fit.frfs_residuals.ordinate[..., -1].real / -(omega[-1] ** 2)
        return Found(poles[taken], fit.shapes.shape_matrix.T, symmetric(far))

    return run


def picked(poles: NDArray[np.complex128], stable: NDArray[np.bool_], hints: Array) -> list[int]:
    """Of the stable poles about each hint [Hz], the one nearest to their median; of all poles where none is stable."""
    chosen = []
    for hint in hints:
        about = np.abs(rb.hertz(np.abs(poles)) / hint - 1) < 0.01
        near = np.flatnonzero(about & stable) if (about & stable).any() else np.flatnonzero(about)
        if not len(near):
            near = np.array([np.abs(rb.hertz(np.abs(poles)) - hint).argmin()])
        middle = np.median(poles[near].real) + 1j * np.median(poles[near].imag)
        chosen.append(int(near[np.abs(poles[near] - middle).argmin()]))
    return chosen


def symmetric(A: Array) -> Array:
    return (A + np.swapaxes(A, -1, -2)) / 2


# Each tool up to a model, and as far as its poles only.
OURS = "rbfound identify"
MODELS: dict[str, Callable[[rb.FRF, Array], Found]] = {
    OURS: rbfound_identify,
    "sdypy-EMA LSCF, order 30": sdypy(30, model=True),
    "sdypy-EMA LSCF, order 60": sdypy(60, model=True),
    "pyFBS pLSCF, order 30": pyfbs(30, model=True),
    "SDynPy PolyPy, orders 8-60": sdynpy_polypy(model=True),
}
POLES: dict[str, Callable[[rb.FRF, Array], Found]] = {
    OURS: rbfound_poles,
    "sdypy-EMA LSCF, order 30": sdypy(30, model=False),
    "sdypy-EMA LSCF, order 60": sdypy(60, model=False),
    "pyFBS pLSCF, order 30": pyfbs(30, model=False),
    "SDynPy PolyPy, orders 8-60": sdynpy_polypy(model=False),
}


# --- truth and errors ---


def truth(seed: int, above: bool) -> rb.Foundation:
    """Seven modes in the band, damped 1 to 2 %, with random shapes; four above it if wanted."""
    f = np.concatenate([IN_BAND, ABOVE]) if above else IN_BAND
    zeta = np.concatenate([np.linspace(0.01, 0.02, len(IN_BAND)), np.full(len(f) - len(IN_BAND), 0.02)])
    Phi = 0.1 * np.random.default_rng(seed).standard_normal((4, len(f)))
    return rb.modal_foundation(Phi, rb.from_hertz(f), zeta)


def measured(foundation: rb.Foundation, level: float, seed: int) -> rb.FRF:
    """Its receptances with complex normal errors of a standard deviation relative to each |H|."""
    frf = foundation.frf(LINES)
    error = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j] / np.sqrt(2)
    return rb.FRF(frf.frequency, frf.H * (1 + level * error), frf.labels)


def mounted(foundation: rb.Foundation) -> NDArray[np.complex128]:
    """Poles of the stepped rotor at rest, in bearings of 1e8 N/m and 1e4 N s/m, on the foundation."""
    machine = rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=foundation)
    return machine.at(0.0).modes().above(1.0).poles


def model_of(found: Found, static: bool) -> rb.Foundation | None:
    """The foundation that a tool's modes make; with its static remainder as one mode a seat far above, or without."""
    if found.foundation is not None:
        return found.foundation
    if found.Phi is None or (static and found.remainder is None):
        return None
    Phi, omega, zeta = found.Phi, np.abs(found.poles), np.maximum(-found.poles.real / np.abs(found.poles), 0)
    if static:
        values, vectors = np.linalg.eigh(found.remainder)
        far = float(rb.from_hertz(FAR))
        Phi = np.hstack([Phi, far * vectors * np.sqrt(np.maximum(values, 0))])
        omega, zeta = np.append(omega, np.full(4, far)), np.append(zeta, np.full(4, 0.02))
    return rb.modal_foundation(Phi, omega, zeta)


def apart(true: NDArray[np.complex128], poles: NDArray[np.complex128]) -> tuple[float, float]:
    """Worst error of frequency and of damping [%], of the poles that are nearest to the true ones."""
    near = poles[np.abs(true[:, None] - poles).argmin(axis=1)]
    zeta, zeta_true = -near.real / np.abs(near), -true.real / np.abs(true)
    return 100 * np.abs(np.abs(near) / np.abs(true) - 1).max(), 100 * np.abs(zeta / zeta_true - 1).max()


def errors(known: rb.Foundation, found: Found) -> Array:
    """Worst errors [%]: frequency, damping, shapes; frequency under the rotor, the same with the static remainder."""
    m = len(IN_BAND)
    omega, zeta = np.sqrt(np.diag(known.K)[:m]), np.diag(known.C)[:m] / (2 * np.sqrt(np.diag(known.K)[:m]))
    true = omega * (-zeta + 1j * np.sqrt(1 - zeta**2))
    own = apart(true, found.poles)
    near = np.abs(true[:, None] - found.poles).argmin(axis=1)
    Phi = found.Phi[:, near] * np.sign((found.Phi[:, near] * known.B[:, :m]).sum(axis=0))
    shape = 100 * (np.linalg.norm(Phi - known.B[:, :m], axis=0) / np.linalg.norm(known.B[:, :m], axis=0)).max()
    coupled = mounted(known)
    coupled = coupled[rb.hertz(coupled.imag) <= LIMIT]
    under = [apart(coupled, mounted(model_of(found, static)))[0] for static in (False, True)]
    return np.array([*own, shape, *under])


# --- the run ---


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """The peers print their progress and warn of what does not matter here."""
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        warnings.simplefilter("ignore")
        yield


def seconds(tool: Callable[[rb.FRF, Array], Found], frf: rb.FRF) -> tuple[float, Found]:
    # a copy: SDynPy may change its data in place
    own = rb.FRF(frf.frequency, frf.H.copy(), frf.labels)
    with quiet():
        start = time.process_time()
        found = tool(own, IN_BAND)
        return time.process_time() - start, found


def study(above: bool, level: float) -> list[list[str]]:
    """One row a tool: its worst errors over the seeds, its median CPU time for the poles and for the model."""
    worst = {name: np.zeros(5) for name in MODELS}
    spent: dict[tuple[str, bool], list[float]] = {(name, whole): [] for name in MODELS for whole in (False, True)}
    for seed in SEEDS:
        known = truth(seed, above)
        frf = measured(known, level, seed)
        for repeat in range(REPEATS):
            # by turns, so that whatever else the machine does hits all alike
            for name in MODELS:
                spent[name, False].append(seconds(POLES[name], frf)[0])
                time_spent, found = seconds(MODELS[name], frf)
                spent[name, True].append(time_spent)
                if repeat == 0:
                    worst[name] = np.maximum(worst[name], errors(known, found))
    ours = np.median(spent[OURS, True])
    rows = []
    for name in MODELS:
        poles, whole = np.median(spent[name, False]), np.median(spent[name, True])
        told = [percent(value) for value in worst[name]]
        if name == OURS:
            told[-1] = "(built in)"
        rows.append([name, *told, f"{poles:.3f}", f"{whole:.3f}", f"{whole / ours:.2f}"])
    return rows


def percent(value: float) -> str:
    return f"{value:.2g}" if value >= 1e-9 else "< 1e-9"


HEAD = [
    "tool",
    "frequency [%]",
    "damping [%]",
    "shape [%]",
    "under the rotor [%]",
    "with its static remainder [%]",
    "poles, CPU [s]",
    "model, CPU [s]",
    "ratio to rbfound",
]


def markdown(rows: list[list[str]]) -> str:
    lines = [HEAD, ["---"] + ["---:"] * (len(HEAD) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def processor() -> str:
    names = [line.split(":", 1)[1].strip() for line in cpu_lines() if line.startswith("model name")]
    return names[0] if names else platform.machine()


def cpu_lines() -> list[str]:
    info = Path("/proc/cpuinfo")
    return info.read_text(encoding="utf-8").splitlines() if info.exists() else []


def page() -> str:
    packages = ("rbfound", "sdypy-EMA", "pyFBS", "sdynpy", "numpy", "scipy")
    parts = [
        INTRODUCTION,
        f"Machine: {processor()}, {os.cpu_count()} cores, {platform.system()}; one BLAS thread. "
        f"Python {platform.python_version()}, " + ", ".join(f"{name} {version(name)}" for name in packages) + ".",
    ]
    for above, title in (
        (False, "Seven modes, none above the band"),
        (True, "The same, and four modes above the band"),
    ):
        parts.append(f"## {title}")
        for level in LEVELS:
            rows = study(above, level)
            parts += [f"Noise {100 * level:g} % of each |H|:", markdown(rows)]
            print(parts[-2], *[" | ".join(row) for row in rows], sep="\n", flush=True)
    return "\n\n".join(parts) + "\n"


INTRODUCTION = f"""# Identification beside the peers

Written by `make bench` (`benchmarks/identification.py`): do not edit by hand.

Sixteen receptances between four seats, {len(LINES)} lines from {LINES[0]:g} to {LINES[-1]:g} Hz of which those from
{BAND[0]:g} Hz on are used, {len(IN_BAND)} modes between {IN_BAND[0]:g} and {IN_BAND[-1]:g} Hz with 1 to 2 % damping; in
the second part four more modes at {", ".join(f"{f:g}" for f in ABOVE)} Hz. Errors are the worst over all modes
and {len(SEEDS)} random foundations, each with noise of its own.

- *Under the rotor*: the natural frequencies below {LIMIT:g} Hz of the thesis's rotor in bearings of 1e8 N/m and
  1e4 N s/m on the identified foundation. *With its static remainder*: the peer's upper residual is added
  as one mode a seat at {FAR:g} Hz. No peer does this by itself, and it is the best that can be made of what they give.
- *Poles*: up to the stabilisation chart, of rbfound up to the poles picked from it. *Model*: up to real
  mass-normalised shapes, picking of poles included; of rbfound also the modes above the band and all error bars.
- CPU time, the median of {REPEATS} runs for each foundation, tools by turns; after one run to warm up.
  A ratio below 1 means that the peer is faster.
- No peer picks poles by itself. sdypy-EMA's `select_closest_poles` is told the true frequencies; for pyFBS and
  SDynPy, of the stable poles within 1 % of a true frequency the one nearest to their median is taken. That
  favours them: rbfound is told nothing, neither where the modes are nor how many.
- sdypy-EMA gives modal constants of sixteen separate FRFs; the shape is the largest eigenvector of their
  symmetric part, our own step. SDynPy gets accelerances, as its shapes have no scale otherwise."""


if __name__ == "__main__":
    warm = measured(truth(0, True), 0.01, 0)
    for tool in (*POLES.values(), *MODELS.values()):
        seconds(tool, warm)
    (Path(__file__).parent / "identification.md").write_text(page(), encoding="utf-8")
