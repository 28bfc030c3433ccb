"""What can be played with: in a notebook, and in the published page.

A thing is a function from settings to figures and tables; Python computes, and a small front end in JavaScript draws.
The widgets need the extra rbfound[widgets].
"""

from rbfound._faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
