"""The thesis's rotor to play with: its natural frequencies and its unbalance response, with and without foundation."""

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbfound.campbell_diagram import Campbell, campbell, whirl_direction
from rbfound.foundation import Foundation
from rbfound.live.sketch import axis, figure, line, listing, mark, slider, switch
from rbfound.rotor import Bearing
from rbfound.theory import ReducedMachine, mount_reduced, reduced_foundation, reduced_rotor
from rbfound.thesis import rotor
from rbfound.units import from_rpm, hertz, rpm

Array = NDArray[np.float64]

# Bearings of the thesis's rotor and the tip of its shaft [m]; modes up to so many hertz are kept of each body.
SEATS, TIP = (0.045, 0.85), 1.0
ROTOR_LIMIT, FOUNDATION_LIMIT = 2000.0, 1000.0
# The highest speed [rev/min], the highest frequency that is drawn [Hz], and steps of speed.
FASTEST, HIGHEST, STEPS = 30000.0, 700.0, 9
# One gram-metre of unbalance, and the speeds [rev/min] at which the answer to it is drawn.
UNBALANCE = 1e-3
SWEEP = np.linspace(300.0, 24000.0, 240)
# A whirl that is neither: less round than this.
FLAT = 0.1
SENSES = ("forward whirl", "backward whirl", "in a plane")
# Their styles have the colours that `rbfound.plots` gives them: red forward, blue backward.
STYLES = (1, 0, 2)

BEARING = [
    slider("k", "bearing stiffness", "N/m", 1e6, 1e9, 1e8, log=True),
    slider("c", "bearing damping", "N s/m", 1e2, 1e5, 1e4, log=True),
]

Settings = Mapping[str, Any]
Answer = Callable[[Settings], dict[str, Any]]


def campbell_thing(foundation: Foundation) -> tuple[list[dict[str, Any]], Answer]:
    """Controls and answer: natural frequencies over speed, from the bearings, with the foundation or without."""
    mount = _mounting(foundation)

    @lru_cache(maxsize=4)
    def diagram(k: float, c: float, flexible: bool) -> tuple[ReducedMachine, Campbell]:
        machine = mount(k, c, flexible)
        return machine, campbell(machine, from_rpm(np.linspace(0.0, FASTEST, STEPS)), count=12)

    controls = [
        *BEARING,
        slider("speed", "speed", "rev/min", 0.0, FASTEST, 9000.0, step=100.0),
        switch("foundation", "on its flexible foundation", True),
    ]

    def answer(settings: Settings) -> dict[str, Any]:
        machine, swept = diagram(float(settings["k"]), float(settings["c"]), bool(settings["foundation"]))
        return _campbell(machine, swept, float(settings["speed"]))

    return controls, answer


def unbalance_thing(foundation: Foundation) -> tuple[list[dict[str, Any]], Answer]:
    """Controls and answer: response to an unbalance at the tip, modes of the foundation held still or not."""
    light = reduced_foundation(foundation, FOUNDATION_LIMIT)
    frequency = hertz(np.sqrt(np.diag(light.K)))
    own = int((frequency < FOUNDATION_LIMIT).sum())
    mount = _mounting(foundation)

    @lru_cache(maxsize=4)
    def on_ground(k: float, c: float) -> Array:
        return _amplitudes(mount(k, c, False), np.zeros((4, 0)))[:1]

    controls = [*BEARING]
    controls += [switch(f"mode{j}", f"mode {j + 1}, {frequency[j]:.0f} Hz", True) for j in range(own)]

    def answer(settings: Settings) -> dict[str, Any]:
        k, c = float(settings["k"]), float(settings["c"])
        kept = [j for j in range(len(frequency)) if j >= own or settings[f"mode{j}"]]
        amplitudes = _amplitudes(mount(k, c, True, kept), light.B[:, kept])
        return _unbalance(amplitudes, on_ground(k, c)[0])

    return controls, answer


def _mounting(foundation: Foundation) -> Callable[..., ReducedMachine]:
    free, light = reduced_rotor(rotor(), [*SEATS, TIP], ROTOR_LIMIT), reduced_foundation(foundation, FOUNDATION_LIMIT)
    return partial(_mount, free, light)


def _mount(free: Any, light: Foundation, k: float, c: float, flexible: bool, kept: Any = None) -> ReducedMachine:
    bearing = Bearing(kxx=k, kyy=k, cxx=c, cyy=c)
    if kept is not None:
        M, C, K = (A[np.ix_(kept, kept)] for A in (light.M, light.C, light.K))
        light = Foundation(M, C, K, light.B[:, kept], light.labels)
    return mount_reduced(free, dict.fromkeys(SEATS, bearing), light if flexible else None)


def _campbell(machine: ReducedMachine, swept: Campbell, speed: float) -> dict[str, Any]:
    system = machine.at(float(from_rpm(speed)))
    modes = system.modes().above(1.0).below(HIGHEST)
    turn = whirl_direction(modes, system)
    speeds = rpm(swept.speeds)
    lines = [line("frequency = speed", [0.0, FASTEST], [0.0, FASTEST / 60], 5, thin=True)]
    for frequency, whirl in zip(swept.frequency.T, swept.whirl.T, strict=True):
        lines += _in_senses(speeds, frequency, np.array([_sense(value) for value in whirl]))
    lines += [line("this speed", [speed, speed], [0.0, HIGHEST], 3, thin=True)]
    marks = [mark("", speed, f, STYLES[_sense(w)]) for f, w in zip(modes.frequency, turn, strict=True)]
    diagram = figure(
        "Campbell diagram",
        axis("speed [rev/min]", 0.0, FASTEST),
        axis("natural frequency [Hz]", 0.0, HIGHEST),
        lines,
        marks,
        wide=True,
    )
    here: dict[str, Any] = {
        "frequency [Hz]": modes.frequency,
        "damping [%]": 100 * modes.damping,
        "whirl": [SENSES[_sense(w)] for w in turn],
    }
    tables = [
        listing(f"At {speed:.0f} rev/min", here),
        listing("Critical speeds, read off the lines", _critical(swept)),
    ]
    return {"figures": [diagram], "tables": tables}


def _in_senses(speeds: Array, frequency: Array, senses: NDArray[np.int_]) -> list[dict[str, Any]]:
    """A mode over speed in the style of its whirl: a line for each sense, with nan where it has another one."""
    lines = []
    for sense in np.unique(senses):
        own = senses == sense
        # up to where the next one begins
        own[1:] |= own[:-1]
        lines.append(line(SENSES[sense], speeds, np.where(own, frequency, np.nan), STYLES[sense]))
    return lines


def _sense(whirl: float) -> int:
    """0 forward, 1 backward, 2 neither, or not known."""
    return 0 if whirl > FLAT else 1 if whirl < -FLAT else 2


def _critical(swept: Campbell) -> dict[str, Any]:
    """Where the lines of the diagram cross frequency = speed, read straight between two speeds of the sweep."""
    found = []
    margin = swept.poles.imag - swept.speeds[:, None]
    for k, b in zip(*np.nonzero(margin[:-1] * margin[1:] < 0), strict=True):
        part = margin[k, b] / (margin[k, b] - margin[k + 1, b])
        speed, damping, whirl = (
            (1 - part) * values[k] + part * values[k + 1]
            for values in (swept.speeds, swept.damping[:, b], swept.whirl[:, b])
        )
        found.append((float(rpm(speed)), 100 * damping, SENSES[_sense(whirl)]))
    names = "speed [rev/min]", "damping [%]", "whirl"
    columns = zip(*sorted(row for row in found if row[0] < 60 * HIGHEST), strict=True)
    return dict(zip(names, columns, strict=False))


def _amplitudes(machine: ReducedMachine, seats: Array) -> Array:
    """Of the tip in x and y, and of the second seat in x and y, (4, speeds) [m]; no seats on rigid ground."""
    speeds = np.asarray(from_rpm(SWEEP))
    q = machine.unbalance(speeds, TIP, UNBALANCE)
    tip = machine.rotor.rows(TIP)
    n = tip.shape[1]
    return np.abs(np.vstack([tip @ q[:, :n].T, seats[2:] @ q[:, n:].T]))


def _unbalance(amplitudes: Array, ground: Array) -> dict[str, Any]:
    micro = 1e6 * amplitudes
    x, y = axis("speed [rev/min]", 0.0, float(SWEEP[-1])), axis("amplitude [µm]", 0.1, 1e4, log=True)
    figures = [
        figure(
            "Tip of the shaft, one gram-metre of unbalance there",
            x,
            y,
            [
                line("rigid ground", SWEEP, 1e6 * ground, 5, thin=True),
                line("x", SWEEP, micro[0], 0),
                line("y", SWEEP, micro[1], 1),
            ],
        ),
        figure(
            "Second bearing seat",
            x,
            axis("amplitude [µm]", 1e-3, 1e2, log=True),
            [line("x", SWEEP, micro[2], 0), line("y", SWEEP, micro[3], 1)],
        ),
    ]
    rows = {}
    for name, curve in (("rigid ground", 1e6 * ground), ("x", micro[0]), ("y", micro[1])):
        top = int(curve.argmax())
        rows[name] = (SWEEP[top], curve[top])
    table = {
        "": list(rows),
        "speed [rev/min]": [row[0] for row in rows.values()],
        "amplitude [µm]": [row[1] for row in rows.values()],
    }
    return {"figures": figures, "tables": [listing("Largest amplitude of the tip", table)]}
