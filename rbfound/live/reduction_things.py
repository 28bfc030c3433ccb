"""Reduction to play with: which masters and how many modes of the rest make a beam small, and what that costs."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.live.sketch import axis, choice, figure, line, listing, slider, switch
from rbfound.machine import mount
from rbfound.rotor import X_PLANE
from rbfound.theory import Reduction, craig_bampton
from rbfound.thesis import bearings, rotor
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]

TIP = 1.0
# Modes of the rest, at the most.
MOST = 8.0
LINES = np.linspace(5.0, 1500.0, 300)
# Nodes whose displacements are masters, by name; those of the bearings always are.
MASTERS = {
    "bearings": "both bearings",
    "tip": "bearings and tip",
    "middle": "bearings, tip and middle",
    "fourth": "every fourth node",
    "second": "every second node",
}

Settings = Mapping[str, Any]


def reduction_thing() -> tuple[list[dict[str, Any]], Callable[[Settings], dict[str, Any]]]:
    """Controls and answer: one plane of the rotor in its bearings, reduced after Guyan and after Craig and Bampton."""
    machine = mount(rotor(), bearings())
    x = np.ravel(4 * np.arange(len(machine.mesh.z))[:, None] + X_PLANE[:2])
    M, C, K = (A[np.ix_(x, x)] for A in (machine.M, machine.C, machine.K))
    z, tip = machine.mesh.z, 2 * machine.mesh.node(TIP)
    held = [machine.mesh.node(place) for place in bearings()]
    exact = _response(M, C, K, np.eye(len(M))[tip])
    controls = [
        choice("masters", "masters", MASTERS, "tip"),
        switch("rotations", "their rotations too", False),
        slider("modes", "modes of the rest, masters held", "", 0.0, MOST, 2.0, step=1.0),
    ]

    @lru_cache(maxsize=8)
    def reduction(masters: str, rotations: bool) -> Reduction:
        at = _coordinates(masters, rotations, held, tip, z)
        return craig_bampton(M, C, K, at, min(int(MOST), len(M) - len(at)))

    @lru_cache(maxsize=8)
    def truncated(count: int) -> NDArray[np.complex128]:
        _, shapes = linalg.eigh(K, M, subset_by_index=(0, count - 1))
        return _reduced(M, C, K, shapes, tip)

    def answer(settings: Settings) -> dict[str, Any]:
        most = reduction(str(settings["masters"]), bool(settings["rotations"]))
        T = most.T[:, : most.static + int(settings["modes"])]
        curves = {
            "whole": exact,
            "reduced": _reduced(M, C, K, T, tip),
            "as many modes": truncated(T.shape[1]),
        }
        return _told(curves, (M, K), T)

    return controls, answer


def _coordinates(masters: str, rotations: bool, held: list[int], tip: int, z: Array) -> list[int]:
    nodes = set(held)
    if masters != "bearings":
        nodes.add(tip // 2)
    if masters == "middle":
        nodes.add(int(np.abs(z - np.mean(z[held])).argmin()))
    if masters in ("fourth", "second"):
        nodes |= set(range(0, len(z), 4 if masters == "fourth" else 2))
    return sorted(2 * node + k for node in nodes for k in range(1 + rotations))


def _reduced(M: Array, C: Array, K: Array, T: Array, tip: int) -> NDArray[np.complex128]:
    m, c, k = (T.T @ A @ T for A in (M, C, K))
    return _response(m, c, k, T[tip])


def _response(M: Array, C: Array, K: Array, row: Array) -> NDArray[np.complex128]:
    w = from_hertz(LINES)[:, None, None]
    force = np.broadcast_to(row[:, None].astype(complex), (len(LINES), len(row), 1))
    return np.asarray(np.linalg.solve(K + 1j * w * C - w**2 * M, force)[:, :, 0] @ row)


def _told(curves: Mapping[str, NDArray[np.complex128]], whole: tuple[Array, Array], T: Array) -> dict[str, Any]:
    frequency = axis("frequency [Hz]", 0.0, float(LINES[-1]))
    exact = curves["whole"]
    figures = [
        figure(
            "Receptance of the shaft's tip",
            frequency,
            axis("|H| [m/N]", 1e-10, 1e-4, log=True),
            [line(name, LINES, np.abs(H), style) for style, (name, H) in enumerate(curves.items())],
        ),
        figure(
            "Error of the receptance",
            frequency,
            axis("|ΔH| / |H|", 1e-8, 10.0, log=True),
            [
                line(name, LINES, np.maximum(np.abs(H / exact - 1), 1e-12), style)
                for style, (name, H) in enumerate(curves.items())
                if style
            ],
        ),
    ]
    M, K = whole
    true = hertz(np.sqrt(linalg.eigvalsh(K, M, subset_by_index=(0, 7))))
    found = hertz(np.sqrt(linalg.eigvalsh(T.T @ K @ T, T.T @ M @ T)))[:8]
    table = {
        "whole [Hz]": true,
        "reduced [Hz]": found,
        "error [%]": 100 * (found / true[: len(found)] - 1),
    }
    return {
        "figures": figures,
        "tables": [listing(f"Undamped frequencies: {T.shape[1]} of {len(M)} coordinates are left", table)],
    }
