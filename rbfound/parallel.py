"""A task done over and over: in this process or through any executor, with tqdm's bar (extra `rbfound[progress]`)."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from importlib.util import find_spec
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

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
