"""Load and save: FRFs, foundations and machines, whatever their format."""

from rbfound.files.arrays import read_arrays as read_arrays
from rbfound.files.exports import (
    dmig as dmig,
    matrix27 as matrix27,
    replaced as replaced,
    text_replaced as text_replaced,
)
from rbfound.files.load_save import (
    UNIVERSAL as UNIVERSAL,
    explained as explained,
    foundation_bytes as foundation_bytes,
    foundation_text as foundation_text,
    load_errors as load_errors,
    load_foundation as load_foundation,
    load_frf as load_frf,
    save_foundation as save_foundation,
    save_frf as save_frf,
)
from rbfound.files.machine_file import load_machine as load_machine
from rbfound.files.ross_bearing import FoundationElement as FoundationElement
