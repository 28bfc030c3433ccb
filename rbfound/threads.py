"""One BLAS thread for what works on many small matrices.

More threads cost such work many times its time and gain nothing, and they change the order of sums: the last digits.
The limit holds for the whole process while at least one such function runs.
"""

import sys
from collections.abc import Callable
from functools import cache, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

_lock = Lock()
_running = 0
_limit: Any = None


@cache
def _controller() -> Any:
    """The BLAS libraries of this process, or None in a browser, whose Python has one thread."""
    if sys.platform == "emscripten":
        return None
    # numpy and scipy bring one BLAS each: both have to be loaded before they are looked for
    import scipy.linalg
    import threadpoolctl

    assert scipy.linalg
    return threadpoolctl.ThreadpoolController().select(user_api="blas")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function, run with one BLAS thread; the number of threads is as before when it ends."""

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> R:
        global _running, _limit
        with _lock:
            if _running == 0 and (controller := _controller()) is not None:
                _limit = controller.limit(limits=1)
            _running += 1
        try:
            return function(*args, **kwargs)
        finally:
            with _lock:
                _running -= 1
                # the last one of several threads of Python that run at once
                if _running == 0 and _limit is not None:
                    _limit.restore_original_limits()
                    _limit = None

    return alone
