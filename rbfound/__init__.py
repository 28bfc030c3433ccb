"""Rotors on flexible foundations: from measured frequency response functions to the machine that stands on them."""

from rbfound._faces import face

__version__ = "0.2.0"

__getattr__, __dir__, __all__ = face(__name__, __file__)
