"""What the theory chapters derive, in closed form or with dense matrices.

One degree of freedom, chains of masses, the rigid rotor, reduction, modal superposition and transmitted forces. It
needs the core alone.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
