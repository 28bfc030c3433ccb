"""What `import rbfound` offers, for type checkers and editors; `__init__.py` loads each name when it is used."""

from rbfound import averaging, rig, sdof, thesis
from rbfound.adaptive import adaptive_lines
from rbfound.balance import permissible_unbalance
from rbfound.checking import Report, check
from rbfound.circle import CircleFit, circle_fit, modal_constants
from rbfound.coupling import Machine, mount
from rbfound.files import load_foundation, load_frf, save_foundation, save_frf
from rbfound.fitting import PseudoModes, equivalent_matrices, pmsm, pseudo_modes
from rbfound.foundation import Foundation, modal_foundation
from rbfound.frf import FRF, relative_error
from rbfound.impedance import MeasuredMachine, coupled_poles, mount_measured, passivity, unbalance_on_lines
from rbfound.inverse import ShaftFit, fit_shaft
from rbfound.lumped import chain
from rbfound.modalfit import ModalFit, fit_modes, identify
from rbfound.orbits import Orbits, ellipses
from rbfound.peaks import Peaks, mode_indicator, pick_peaks
from rbfound.polynomials import Fraction, fit_fraction, rational_fraction
from rbfound.polyreference import Stabilisation, stabilisation, stable_poles
from rbfound.reduction import Reduction, craig_bampton, dynamic_reduction, guyan, modal_reduction
from rbfound.residues import Residues, fit_residues, lscf
from rbfound.rigid import RigidRotor, rigid_rotor
from rbfound.rotor import Bearing, Disk, Rotor, Shaft
from rbfound.synthesis import antiresonances, modal_terms, normal_modes, pole_terms, residue_shapes
from rbfound.system import Modes, System, mac
from rbfound.tables import bound, table
from rbfound.transmitted import ground_forces, seat_forces
from rbfound.uncertainty import CriticalBars, ErrorBars, campbell_bars, critical_bars, error_bars, monte_carlo
from rbfound.units import from_rpm, hertz, radians, rpm
from rbfound.whirl import Campbell, CriticalSpeeds, campbell, unbalance_response

__version__: str

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
    "Orbits",
    "Peaks",
    "PseudoModes",
    "Reduction",
    "Report",
    "Residues",
    "RigidRotor",
    "Rotor",
    "Shaft",
    "ShaftFit",
    "Stabilisation",
    "System",
    "adaptive_lines",
    "antiresonances",
    "averaging",
    "bound",
    "campbell",
    "campbell_bars",
    "chain",
    "check",
    "circle_fit",
    "coupled_poles",
    "craig_bampton",
    "critical_bars",
    "dynamic_reduction",
    "ellipses",
    "equivalent_matrices",
    "error_bars",
    "fit_fraction",
    "fit_modes",
    "fit_residues",
    "fit_shaft",
    "from_rpm",
    "ground_forces",
    "guyan",
    "hertz",
    "identify",
    "load_foundation",
    "load_frf",
    "lscf",
    "mac",
    "modal_constants",
    "modal_foundation",
    "modal_reduction",
    "modal_terms",
    "mode_indicator",
    "monte_carlo",
    "mount",
    "mount_measured",
    "normal_modes",
    "passivity",
    "permissible_unbalance",
    "pick_peaks",
    "pmsm",
    "pole_terms",
    "pseudo_modes",
    "radians",
    "rational_fraction",
    "relative_error",
    "residue_shapes",
    "rig",
    "rigid_rotor",
    "rpm",
    "save_foundation",
    "save_frf",
    "sdof",
    "seat_forces",
    "stabilisation",
    "stable_poles",
    "table",
    "thesis",
    "unbalance_on_lines",
    "unbalance_response",
]
