"""Three-dimensional bodies and their modes. Needs the extra rbfound[solid] (scikit-fem)."""

from rbfound.solid.axisymmetric import (
    cone_angle as cone_angle,
    gyroscopic as gyroscopic,
    section_mesh as section_mesh,
    solid_rotor as solid_rotor,
)
from rbfound.solid.elastic import Places as Places, Solid as Solid, elastic_solid as elastic_solid
from rbfound.solid.mesh import Block as Block, brick as brick, join as join
from rbfound.solid.modes import (
    direct_receptance as direct_receptance,
    foundation_solid as foundation_solid,
    mesh_study as mesh_study,
    mirror_halves as mirror_halves,
    momentum as momentum,
    natural_modes as natural_modes,
    reduce as reduce,
    ritz_modes as ritz_modes,
    surface as surface,
)
from rbfound.solid.pedestals import (
    COARSE as COARSE,
    WORKING as WORKING,
    FoundationGeometry as FoundationGeometry,
    foundation_blocks as foundation_blocks,
)
