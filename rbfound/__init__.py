"""Rotors on flexible foundations: from measured frequency response functions to the machine that stands on them."""

from rbfound import sdof, thesis
from rbfound.circle import CircleFit, circle_fit, modal_constants
from rbfound.coupling import Machine, mount
from rbfound.files import load_foundation, load_frf, save_foundation, save_frf
from rbfound.fitting import PseudoModes, equivalent_matrices, pmsm, pseudo_modes
from rbfound.foundation import Foundation, modal_foundation
from rbfound.frf import FRF
from rbfound.impedance import MeasuredMachine, coupled_poles, mount_measured, passivity, unbalance_on_lines
from rbfound.modalfit import ModalFit, fit_modes, identify
from rbfound.peaks import Peaks, mode_indicator, pick_peaks
from rbfound.polynomials import Fraction, fit_fraction, rational_fraction
from rbfound.polyreference import Stabilisation, stabilisation, stable_poles
from rbfound.residues import Residues, fit_residues, lscf
from rbfound.rotor import Bearing, Disk, Rotor, Shaft
from rbfound.system import Modes, System, mac
from rbfound.tables import bound, table
from rbfound.uncertainty import CriticalBars, ErrorBars, campbell_bars, critical_bars, error_bars, monte_carlo
from rbfound.units import from_rpm, hertz, radians, rpm
from rbfound.whirl import Campbell, CriticalSpeeds, campbell, unbalance_response

__version__ = "0.1.0"

__all__ = [
    "FRF",
    "Bearing",
    "Campbell",
    "CircleFit",
    "CriticalBars",
    "CriticalSpeeds",
    "Disk",
    "ErrorBars",
    "Foundation",
    "Fraction",
    "Machine",
    "MeasuredMachine",
    "ModalFit",
    "Modes",
    "Peaks",
    "PseudoModes",
    "Residues",
    "Rotor",
    "Shaft",
    "Stabilisation",
    "System",
    "bound",
    "campbell",
    "campbell_bars",
    "circle_fit",
    "coupled_poles",
    "critical_bars",
    "equivalent_matrices",
    "error_bars",
    "fit_fraction",
    "fit_modes",
    "fit_residues",
    "from_rpm",
    "hertz",
    "identify",
    "load_foundation",
    "load_frf",
    "lscf",
    "mac",
    "modal_constants",
    "modal_foundation",
    "mode_indicator",
    "monte_carlo",
    "mount",
    "mount_measured",
    "passivity",
    "pick_peaks",
    "pmsm",
    "pseudo_modes",
    "radians",
    "rational_fraction",
    "rpm",
    "save_foundation",
    "save_frf",
    "sdof",
    "stabilisation",
    "stable_poles",
    "table",
    "thesis",
    "unbalance_on_lines",
    "unbalance_response",
]
