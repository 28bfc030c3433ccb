"""From FRFs to a foundation model: one module for each method.

Circle fit, pseudo mode shapes (PMSM), rational fractions (RFP), poly-reference poles (pLSCF), residues (LSFD), the
modal fit of all FRFs at once, and what noise does to its result under the rotor.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
