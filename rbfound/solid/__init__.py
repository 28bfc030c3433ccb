"""Three-dimensional bodies and their modes. Needs the extra rbfound[solid] (scikit-fem).

A mesh of 20-node bricks becomes mass and stiffness, a few modes and a reduced foundation; a solid of revolution
becomes a rotor.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
