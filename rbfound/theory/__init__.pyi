"""What the theory chapters derive, in closed form or with dense matrices."""

from rbfound.theory import sdof as sdof
from rbfound.theory.condensation import (
    ReducedMachine as ReducedMachine,
    ReducedRotor as ReducedRotor,
    mount_reduced as mount_reduced,
    reduced_foundation as reduced_foundation,
    reduced_rotor as reduced_rotor,
    round_rotor as round_rotor,
)
from rbfound.theory.partialfractions import expanded as expanded, partial_fractions as partial_fractions, ratio as ratio
from rbfound.theory.reduction import (
    Reduction as Reduction,
    craig_bampton as craig_bampton,
    dynamic_reduction as dynamic_reduction,
    factorised as factorised,
    guyan as guyan,
    lowest_modes as lowest_modes,
    modal_reduction as modal_reduction,
    ritz as ritz,
)
from rbfound.theory.rigid import (
    RigidRotor as RigidRotor,
    conical as conical,
    isotropic_whirl as isotropic_whirl,
    rigid_rotor as rigid_rotor,
    support_stiffness as support_stiffness,
)
from rbfound.theory.sdof import RIPPLE as RIPPLE, Peak as Peak, half_power as half_power, local_maxima as local_maxima
from rbfound.theory.superposition import (
    antiresonances as antiresonances,
    chain as chain,
    modal_terms as modal_terms,
    normal_modes as normal_modes,
    pole_terms as pole_terms,
    real_matrices as real_matrices,
    residue_shapes as residue_shapes,
)
from rbfound.theory.transmissibility import (
    ground_forces as ground_forces,
    seat_forces as seat_forces,
    seat_momentum as seat_momentum,
    sine_cosine_amplitude as sine_cosine_amplitude,
    sine_cosine_matrix as sine_cosine_matrix,
)
