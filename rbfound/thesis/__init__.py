"""What the thesis prints, its models a to l, and the comparisons with it.

`model("a")` to `model("l")` are its twelve models, `TABLES` its printed frequencies. Models g to l need the extra
rbfound[solid].
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
