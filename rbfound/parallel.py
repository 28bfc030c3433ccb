"""How work runs: over and over, here or through any executor, with a bar; and on one BLAS thread.

The bar is tqdm's (extra `rbfound[progress]`). More than one thread costs work on many small matrices many times its
time and gains nothing, and threads change the order of sums: the last digits.
"""

import sys
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from functools import cache, wraps
from importlib.util import find_spec
from threading import Lock
from typing import Any, ParamSpec, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
P = ParamSpec("P")

_lock = Lock()
_running = 0
_limit: Any = None

# Seconds before a bar appears that nobody asked for.
PATIENCE = 2.0


def run(
    task: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    executor: Executor | None = None,
    progress: bool | None = None,
    title: str = "",
    begun: Sequence[Result] = (),
    keep: Callable[[list[Result]], object] | None = None,
) -> list[Result]:
    """The task's result for each item, in the order of the items.

    An interrupt (Ctrl-C) or an error of the task cancels what has not begun. What `keep` has put somewhere safe by then
    can be handed in again as `begun`.

    Parameters
    ----------
    task : function of one item
        For an executor of processes or machines it must be importable there (functools.partial of one, too).
    executor : concurrent.futures.Executor, optional
        Whatever has its `map`: a ProcessPoolExecutor, `dask.distributed.Client(...).get_executor()`, an
        MPIPoolExecutor. Unless given, the items are worked off here, one after the other.
    progress : bool, optional
        Whether a bar is written to stderr, which needs tqdm. Unless given: on a terminal, once the work has taken two
        seconds, and never where tqdm is not installed.
    title : what the bar says in front
    begun : results of the first items, from a run that was interrupted; these are not worked off again
    keep : function of the results so far, called after each one
    """
    results = list(begun[: len(items)])
    rest = items[len(results) :]
    done: Iterator[Result] = map(task, rest) if executor is None else iter(executor.map(task, rest))
    try:
        for result in _with_bar(done, len(results), len(items), title, progress):
            results.append(result)
            if keep is not None:
                keep(results)
    finally:
        # an executor's iterator cancels, when it is closed, what has not begun
        if isinstance(done, Generator):
            done.close()
    return results


def _with_bar(done: Iterator[Result], first: int, total: int, title: str, wanted: bool | None) -> Iterable[Result]:
    there = find_spec("tqdm") is not None
    if wanted and not there:
        raise ValueError("A progress bar needs tqdm: pip install 'rbfound[progress]', or progress=False.")
    if wanted is False or not there:
        return done
    from tqdm import tqdm

    # disable=None: shown on a terminal only
    when = {"disable": None, "delay": PATIENCE} if wanted is None else {}
    bar: Iterable[Result] = tqdm(done, title or None, total, initial=first, **when)
    return bar


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


def one_thread(function: Callable[P, Result]) -> Callable[P, Result]:
    """The function, run with one BLAS thread; the number of threads is as before when it ends.

    The limit holds for the whole process while at least one such function runs.
    """

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> Result:
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
