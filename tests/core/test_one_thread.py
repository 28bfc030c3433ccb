"""Work on small matrices takes one BLAS thread, and leaves the others as they were.

How many threads BLAS can have is settled when it is loaded: what is tested runs in a process of its own with two.
"""

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from threading import Barrier
from typing import Any

import pytest

THREADS = "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"


def counts() -> set[int]:
    from threadpoolctl import ThreadpoolController

    return {library.num_threads for library in ThreadpoolController().select(user_api="blas").lib_controllers}


def plain() -> list[set[int]]:
    from rbfound.parallel import one_thread

    return [one_thread(counts)(), counts()]


def nested() -> list[set[int]]:
    from rbfound.parallel import one_thread

    @one_thread
    def inner() -> None:
        raise ZeroDivisionError

    @one_thread
    def outer() -> set[int]:
        with pytest.raises(ZeroDivisionError):
            inner()
        return counts()

    return [outer(), counts()]


def overlapping() -> list[set[int]]:
    from rbfound.parallel import one_thread

    begun, may_end = Barrier(2), Barrier(2)

    @one_thread
    def long() -> None:
        begun.wait(10)
        may_end.wait(10)

    @one_thread
    def short() -> set[int]:
        begun.wait(10)
        return counts()

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.submit(long), pool.submit(short)
        seen = [second.result(10), counts()]
        may_end.wait(10)
        first.result(10)
    return [*seen, counts()]


def in_the_package() -> list[set[int]]:
    """The counts of threads that numpy's and scipy's solvers see within calls of the package, and those afterwards."""
    import numpy as np
    import scipy.linalg
    from threadpoolctl import ThreadpoolController

    import rbfound as rb

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers
    seen: set[int] = set()

    def watched(solver: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **options: Any) -> Any:
            seen.update(library.num_threads for library in libraries)
            return solver(*args, **options)

        return call

    for module in (np.linalg, scipy.linalg):
        for name in ("cholesky", "eig", "eigh", "lstsq", "qr", "solve", "svd"):
            if hasattr(module, name):
                setattr(module, name, watched(getattr(module, name)))
    foundation = rb.modal_foundation([[0.1, 0.2], [0.2, 0.1]], [600.0, 1200.0], [0.02, 0.02], ("x1", "y1"))
    frf = foundation.frf(np.arange(20.0, 300.0)).with_noise(0.01)
    counts_of = []
    for work in (
        lambda: rb.fit_modes(frf),
        lambda: rb.campbell(rb.thesis.model("c"), [0.0, 100.0]),
        lambda: rb.check(frf),
    ):
        seen.clear()
        work()
        counts_of.append(set(seen))
    return [*counts_of, {library.num_threads for library in libraries}]


def with_two_threads(function: Callable[[], Any]) -> Any:
    """What a function returns in a fresh process whose BLAS has two threads."""
    kept = {name: os.environ.get(name) for name in THREADS}
    try:
        os.environ.update(dict.fromkeys(THREADS, "2"))
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            if pool.submit(counts_of_numpy).result() != {2}:
                pytest.skip("BLAS has one thread here: two processors and a BLAS with threads are needed.")
            return pool.submit(function).result()
    finally:
        for name, value in kept.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def counts_of_numpy() -> set[int]:
    import scipy.linalg

    assert scipy.linalg
    return counts()


def test_one_thread_inside_and_as_many_as_before_when_it_ends() -> None:
    assert with_two_threads(plain) == [{1}, {2}]


def test_also_after_an_error_and_within_one_another() -> None:
    assert with_two_threads(nested) == [{1}, {2}]


def test_calls_that_overlap_do_not_leave_the_limit_behind() -> None:
    assert with_two_threads(overlapping) == [{1}, {1}, {2}]


def test_fits_and_sweeps_take_one_thread() -> None:
    assert with_two_threads(in_the_package) == [{1}, {1}, {1}, {2}]
