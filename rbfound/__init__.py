"""Rotors on flexible foundations: from measured frequency response functions to the machine that stands on them."""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

# Which module has which names. A name's module is loaded when the name is first asked for (PEP 562), so that a program
# waits for no more than what it uses; `__init__.pyi` says the same to type checkers and editors.
_MODULES = ("averaging", "rig", "sdof", "thesis")
_NAMES = {
    "adaptive": "adaptive_lines",
    "balance": "permissible_unbalance",
    "checking": "Report check",
    "circle": "CircleFit circle_fit modal_constants",
    "coupling": "Machine mount",
    "files": "load_foundation load_frf save_foundation save_frf",
    "fitting": "PseudoModes equivalent_matrices pmsm pseudo_modes",
    "foundation": "Foundation modal_foundation",
    "frf": "FRF relative_error",
    "impedance": "MeasuredMachine coupled_poles mount_measured passivity unbalance_on_lines",
    "inverse": "ShaftFit fit_shaft",
    "lumped": "chain",
    "modalfit": "ModalFit fit_modes identify",
    "orbits": "Orbits ellipses",
    "peaks": "Peaks mode_indicator pick_peaks",
    "polynomials": "Fraction fit_fraction rational_fraction",
    "polyreference": "Stabilisation stabilisation stable_poles",
    "reduction": "Reduction craig_bampton dynamic_reduction guyan modal_reduction",
    "residues": "Residues fit_residues lscf",
    "rigid": "RigidRotor rigid_rotor",
    "rotor": "Bearing Disk Rotor Shaft",
    "synthesis": "antiresonances modal_terms normal_modes pole_terms residue_shapes",
    "system": "Modes System mac",
    "tables": "bound table",
    "transmitted": "ground_forces seat_forces",
    "uncertainty": "CriticalBars ErrorBars campbell_bars critical_bars error_bars monte_carlo",
    "units": "from_rpm hertz radians rpm",
    "whirl": "Campbell CriticalSpeeds campbell unbalance_response",
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = sorted([*_MODULES, *_HOMES])


def __getattr__(name: str) -> Any:
    if name in _MODULES or name in _NAMES:
        return import_module(f"rbfound.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'rbfound' has no attribute {name!r}")
    value = getattr(import_module(f"rbfound.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
