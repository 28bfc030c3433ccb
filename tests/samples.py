"""Foundations, machines and files that several test files begin with, and how far a result is from what was put in."""

from pathlib import Path

import numpy as np

import rbfound as rb

# --- foundations that are to be found again ---

LINES = np.arange(0.5, 1000.25, 0.5)
BAND = (20.0, 1000.0)
ABOVE = np.array([1150.0, 1500.0, 2100.0, 3000.0])
F_N = np.array([62.0, 150.0, 187.0, 330.0, 480.0, 640.0, 871.0])

# What is promised [%]: frequency and damping of the foundation alone, frequency and damping under the rotor.
PROMISED = {0.0: (0.01, 0.5, 0.02, 3.0), 0.01: (0.05, 3.0, 0.05, 5.0), 0.05: (0.2, 8.0, 0.2, 10.0)}


def known(f_n=F_N, zeta=0.015, seed=0, Phi=None):
    """A foundation with modes in the band and four above it."""
    f = np.concatenate([f_n, ABOVE])
    if Phi is None:
        Phi = 0.1 * np.random.default_rng(seed).standard_normal((4, len(f)))
    return rb.modal_foundation(Phi, 2 * np.pi * f, np.concatenate([np.broadcast_to(zeta, len(f_n)), np.full(4, 0.02)]))


def noisy(frf, level, seed=0):
    """Complex normal errors, independent of one another, of a standard deviation relative to each |H|."""
    e = np.random.default_rng(seed).standard_normal((*frf.H.shape, 2)) @ [1, 1j]
    return rb.FRF(frf.frequency, frf.H * (1 + level * e / np.sqrt(2)), frf.labels)


def errors(true, poles):
    """Worst error of frequency and of damping [%] of the poles that are nearest to the true ones."""
    near = poles[np.abs(true[:, None] - poles).argmin(axis=1)]
    frequency = np.abs(np.abs(near) / np.abs(true) - 1).max()
    damping = np.abs((near.real / np.abs(near)) / (true.real / np.abs(true)) - 1).max()
    return 100 * frequency, 100 * damping


def alone(truth, fit):
    true = truth.modes().above(BAND[0]).below(BAND[1]).poles
    omega, zeta = fit.omega[fit.inside], fit.zeta[fit.inside]
    return errors(true, omega * (-zeta + 1j * np.sqrt(1 - zeta**2)))


def machine_poles(foundation, k=1e8):
    bearing = rb.Bearing(kxx=k, kyy=k, cxx=1e4, cyy=1e4)
    on = rb.mount(rb.thesis.rotor(), dict.fromkeys(rb.thesis.bearings(), bearing), on=foundation)
    return on.at(0.0).modes().above(1.0)


def under_the_rotor(truth, fit, k=1e8):
    return errors(machine_poles(truth, k).below(800).poles, machine_poles(fit.foundation(), k).poles)


def assert_passive(foundation):
    # Im H below zero as a matrix: no force at any seats, in any phase, is fed
    H = foundation.frf(LINES[::20]).H
    assert np.abs(H - H.transpose(0, 2, 1)).max() <= 1e-12 * np.abs(H).max()
    highest = np.linalg.eigvalsh(H.imag)[:, -1]
    assert (highest <= 1e-12 * np.abs(H).max(axis=(1, 2))).all()
    assert min(foundation.definiteness().values()) > 0


# --- rotors on foundations ---

SHAFT = rb.Shaft(length=[0.1, 0.5, 0.2], diameter=[0.05, 0.08, 0.05])
ROTOR = rb.Rotor(SHAFT, {0.35: rb.Disk(15.0, 0.1, 0.18), 0.8: rb.Disk(4.0)}, element=0.1)
LEFT = rb.Bearing(kxx=2e7, kyy=3e7, kxy=4e6, kyx=-1e6, cxx=2e3, cyy=3e3, cxy=2e2, cyx=-1e2)
RIGHT = rb.Bearing(kxx=5e7, kyy=4e7, cxx=1e3, cyy=4e3)
BEARINGS = {0.1: LEFT, 0.6: RIGHT}


def spread_modes(seats=4, modes=7, seed=3):
    """A foundation with its modes evenly from 40 to 400 Hz."""
    rng = np.random.default_rng(seed)
    labels = tuple(f"{axis}{b + 1}" for b in range(seats // 2) for axis in "xy")
    omega = 2 * np.pi * np.linspace(40.0, 400.0, modes)
    return rb.modal_foundation(0.15 * rng.standard_normal((seats, modes)), omega, np.full(modes, 0.02), labels)


# --- files ---

FREQUENCY = np.array([0.0, 100 / 3, 50.0, 75.0, 100.0])
MACHINE = """# a rotor with one disk
speeds = [0, 6000]
foundation = "foundation.json"

[shaft]
length = [0.5, 0.5]
diameter = [0.05, 0.04]

[[disk]]
position = 0.5
mass = 10.0
Id = 0.03
Ip = 0.05

[[bearing]]
position = 0.0
kxx = 1e8
kyy = 1e8
cxx = 1e3
cyy = 1e3

[[bearing]]
position = 1.0
kxx = 1e8
kyy = 1e8
"""


def foundation(seats=4, modes=6):
    """A foundation with its modes at 300, 600, ... rad/s, 48, 95, ... Hz."""
    rng = np.random.default_rng(4)
    labels = tuple(f"{axis}{b + 1}" for b in range(seats // 2) for axis in "xy")
    return rb.modal_foundation(
        0.1 * rng.standard_normal((seats, modes)), 300.0 * np.arange(1, modes + 1), np.full(modes, 0.02), labels
    )


class Harmful:
    """Unpickling it would create a file."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))
