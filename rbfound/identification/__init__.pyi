"""From FRFs to a foundation model: one module for each method."""

from rbfound.identification.circle import (
    CircleFit as CircleFit,
    circle_fit as circle_fit,
    modal_constants as modal_constants,
)
from rbfound.identification.error_propagation import (
    CriticalBars as CriticalBars,
    ErrorBars as ErrorBars,
    campbell_bars as campbell_bars,
    critical_bars as critical_bars,
    error_bars as error_bars,
    monte_carlo as monte_carlo,
    without_window as without_window,
)
from rbfound.identification.least_squares import compliance as compliance
from rbfound.identification.lsfd import Residues as Residues, fit_residues as fit_residues, lscf as lscf
from rbfound.identification.measured_coupling import (
    MeasuredMachine as MeasuredMachine,
    coupled_poles as coupled_poles,
    mount_measured as mount_measured,
    passivity as passivity,
    unbalance_on_lines as unbalance_on_lines,
)
from rbfound.identification.modal_fit import (
    ModalFit as ModalFit,
    fit_modes as fit_modes,
    identify as identify,
)
from rbfound.identification.plscf import (
    Stabilisation as Stabilisation,
    stabilisation as stabilisation,
    stable_poles as stable_poles,
)
from rbfound.identification.pseudo_mode_shapes import (
    PseudoModes as PseudoModes,
    equivalent_matrices as equivalent_matrices,
    pmsm as pmsm,
    pseudo_modes as pseudo_modes,
)
from rbfound.identification.rfp import (
    Fraction as Fraction,
    fit_fraction as fit_fraction,
    orthogonal_basis as orthogonal_basis,
    power_basis as power_basis,
    rational_fraction as rational_fraction,
)
