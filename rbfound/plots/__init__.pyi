"""Every figure of the book. Needs the extra rbfound[plots] (matplotlib)."""

from rbfound.plots.frf import (
    circle as circle,
    driving_point_set as driving_point_set,
    frf_matrix as frf_matrix,
    half_power as half_power,
    indicator as indicator,
    matrices as matrices,
    over_time as over_time,
    receptances as receptances,
)
from rbfound.plots.identification import (
    beside_reference as beside_reference,
    campbell_bands as campbell_bands,
    conditions as conditions,
    errors_in_bars as errors_in_bars,
    nyquist as nyquist,
    parts as parts,
    passivity as passivity,
    pole_map as pole_map,
    polynomials as polynomials,
    price as price,
    residual_parts as residual_parts,
    stabilisation_chart as stabilisation_chart,
)
from rbfound.plots.machines import (
    amplitude_and_phase as amplitude_and_phase,
    campbell as campbell,
    directions as directions,
    ladder as ladder,
    mode_shapes as mode_shapes,
    orbits as orbits,
    over_speed as over_speed,
    overview as overview,
    rigid_on_supports as rigid_on_supports,
    rotor as rotor,
    rotors as rotors,
    spread as spread,
    unbalance as unbalance,
)
from rbfound.plots.quality import blow as blow, checked as checked, coherences as coherences, page as page
from rbfound.plots.solids import (
    VIEW as VIEW,
    body as body,
    body_on as body_on,
    campbells as campbells,
    centre_lines as centre_lines,
    cost as cost,
    moved as moved,
    section as section,
)
from rbfound.plots.style import (
    BLACK as BLACK,
    BLUE as BLUE,
    GREEN as GREEN,
    ORANGE as ORANGE,
    RED as RED,
    STYLE as STYLE,
    styled as styled,
)
from rbfound.plots.surfaces import Body as Body, rotor_body as rotor_body, solid_body as solid_body
from rbfound.plots.theory import (
    chain_drawing as chain_drawing,
    chain_shapes as chain_shapes,
    contributions as contributions,
    errors as errors,
    errors_for_seconds as errors_for_seconds,
    frf_kinds as frf_kinds,
    growth as growth,
    guesses as guesses,
    lines_where_needed as lines_where_needed,
    phasors as phasors,
    winding as winding,
    zeros_and_poles as zeros_and_poles,
)
from rbfound.plots.viewer import turnable as turnable
