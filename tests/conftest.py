"""Hypothesis takes the same cases each time; `make fuzz` sets RBFOUND_FUZZ, and takes others each time.

What it finds then becomes an `@example` of the test or a case of its own.
"""

import os

from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None, database=None)
settings.register_profile("random", derandomize=False, deadline=None, database=None, print_blob=True)
settings.load_profile("random" if "RBFOUND_FUZZ" in os.environ else "same")
