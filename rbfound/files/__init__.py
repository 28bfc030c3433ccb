"""Load and save: FRFs, foundations and machines, whatever their format.

`load_frf` and `load_foundation` recognise the format by what is in the file. Exports are for MATLAB, ANSYS, NASTRAN
and ROSS.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
