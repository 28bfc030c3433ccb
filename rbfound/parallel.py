"""A task done over and over: in this process or through any executor, with a bar that shows how far it is."""

import sys
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor
from typing import TextIO, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# Seconds before a bar appears, and between two drawings of it.
PATIENCE, PAUSE = 2.0, 0.2
WIDTH = 30


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
        Whether a bar is written to stderr. Unless given: on a terminal, once the work has taken two seconds.
    title : what the bar says in front
    begun : results of the first items, from a run that was interrupted; these are not worked off again
    keep : function of the results so far, called after each one
    """
    results = list(begun[: len(items)])
    rest = items[len(results) :]
    done: Iterator[Result] = map(task, rest) if executor is None else iter(executor.map(task, rest))
    with _Bar(len(items), title, progress, sys.stderr) as bar:
        try:
            for result in done:
                results.append(result)
                if keep is not None:
                    keep(results)
                bar.show(len(results))
        finally:
            # an executor's iterator cancels, when it is closed, what has not begun
            if isinstance(done, Generator):
                done.close()
    return results


class _Bar:
    """[=====     ] 50 of 100, 12 s left."""

    def __init__(self, total: int, title: str, wanted: bool | None, out: TextIO) -> None:
        self.total, self.title, self.out = total, title + " " * bool(title), out
        self.wanted = out.isatty() if wanted is None else wanted
        self.patience = PATIENCE if wanted is None else 0.0
        self.begun = self.drawn = time.monotonic()
        self.visible = False

    def __enter__(self) -> "_Bar":
        return self

    def show(self, done: int) -> None:
        now = time.monotonic()
        early = now - self.begun < self.patience or (now - self.drawn < PAUSE and done < self.total)
        if not self.wanted or (early and not (self.visible and done == self.total)):
            return
        filled = WIDTH * done // self.total
        left = (now - self.begun) / done * (self.total - done)
        text = f"{self.title}[{'=' * filled:{WIDTH}}] {done} of {self.total}, {left:.0f} s left"
        self.out.write(f"\r{text:<{WIDTH + len(self.title) + 34}}")
        self.out.flush()
        self.drawn, self.visible = now, True

    def __exit__(self, *_: object) -> None:
        if self.visible:
            self.out.write("\n")
            self.out.flush()
