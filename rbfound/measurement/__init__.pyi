"""From signals to FRFs that can be trusted."""

from rbfound.measurement.averaging import USABLE as USABLE, Blocks as Blocks, spectra as spectra
from rbfound.measurement.noise import beside_neighbours as beside_neighbours, own_errors as own_errors
from rbfound.measurement.peaks import (
    REACH as REACH,
    Peaks as Peaks,
    mode_indicator as mode_indicator,
    nearest_peak as nearest_peak,
    pick_peaks as pick_peaks,
    prominence as prominence,
)
from rbfound.measurement.quality import (
    FEW_LINES as FEW_LINES,
    NO_PHASE as NO_PHASE,
    STATIC_PART as STATIC_PART,
    Report as Report,
    check as check,
    gains as gains,
    has_phase as has_phase,
)
from rbfound.measurement.virtual_test import (
    KINDS as KINDS,
    Sensors as Sensors,
    hammer as hammer,
    shaker as shaker,
    with_mass as with_mass,
)
