"""What `import rbfound` offers, for type checkers and editors, and for `rbfound._faces`, which loads it by need."""

from rbfound import (
    files as files,
    identification as identification,
    live as live,
    measurement as measurement,
    plots as plots,
    solid as solid,
    theory as theory,
    thesis as thesis,
)
from rbfound.campbell_diagram import campbell as campbell
from rbfound.files import (
    load_foundation as load_foundation,
    load_frf as load_frf,
    save_foundation as save_foundation,
    save_frf as save_frf,
)
from rbfound.foundation import Foundation as Foundation, modal_foundation as modal_foundation
from rbfound.frf import FRF as FRF, relative_error as relative_error
from rbfound.identification import (
    equivalent_matrices as equivalent_matrices,
    error_bars as error_bars,
    fit_modes as fit_modes,
    identify as identify,
    pmsm as pmsm,
)
from rbfound.machine import Machine as Machine, mount as mount
from rbfound.measurement import Peaks as Peaks, check as check, pick_peaks as pick_peaks
from rbfound.rotor import Bearing as Bearing, Disk as Disk, Rotor as Rotor, Shaft as Shaft
from rbfound.system import System as System, mac as mac
from rbfound.tables import bound as bound, table as table
from rbfound.unbalance import unbalance_response as unbalance_response
from rbfound.units import from_hertz as from_hertz, from_rpm as from_rpm, hertz as hertz, rpm as rpm

__version__: str
