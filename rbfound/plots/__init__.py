"""Every figure of the book. Needs the extra rbfound[plots] (matplotlib).

Each function draws a new figure from results, or into an `ax`; it computes nothing that a result does not have.
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
