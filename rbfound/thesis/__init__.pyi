"""What the thesis prints, its models a to l, and the comparisons with it."""

from rbfound.thesis import shaft_fit as shaft_fit, sketches as sketches
from rbfound.thesis.beam_models import (
    CE as CE,
    DIAGONAL_C as DIAGONAL_C,
    FOUNDATION as FOUNDATION,
    KE as KE,
    ME as ME,
    OMEGA as OMEGA,
    PHI as PHI,
    POINT_MASS as POINT_MASS,
    TABLES as TABLES,
    UNBALANCE_RADIUS as UNBALANCE_RADIUS,
    ZETA as ZETA,
    bearings as bearings,
    compare as compare,
    foundation as foundation,
    printed as printed,
    rotor as rotor,
    unrounded_foundation as unrounded_foundation,
)
from rbfound.thesis.full_models import axially_tied as axially_tied, centre_line as centre_line
from rbfound.thesis.methods import (
    compare_methods as compare_methods,
    frequency_errors as frequency_errors,
    method_result as method_result,
    response_error as response_error,
    usual_methods as usual_methods,
)
from rbfound.thesis.models import beside as beside, model as model
from rbfound.thesis.peak_readings import reading_errors as reading_errors, readings as readings
from rbfound.thesis.shaft_fit import ShaftFit as ShaftFit, fit_shaft as fit_shaft
