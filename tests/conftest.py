"""Before any test: one thread, as in the Makefile, and Hypothesis takes the same cases each time.

`make fuzz` sets RBFOUND_FUZZ, and Hypothesis takes others each time; what it finds then becomes an `@example` of the
test or a case of its own.
"""

import os

from hypothesis import settings

# read when numpy is imported, which only the tests do
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

settings.register_profile("same", derandomize=True, deadline=None, database=None)
settings.register_profile("random", derandomize=False, deadline=None, database=None, print_blob=True)
settings.load_profile("random" if "RBFOUND_FUZZ" in os.environ else "same")
