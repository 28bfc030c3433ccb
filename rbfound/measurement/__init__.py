"""From signals to FRFs that can be trusted.

Averaged spectra, noise, peaks and the quality check of a set of FRFs, and a virtual test rig that makes such data
from a known foundation.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
