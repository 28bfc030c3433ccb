"""A task done over and over."""

import io
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from rbfound import parallel


class Terminal(io.StringIO):
    def isatty(self):
        return True


def double(x):
    return 2 * x


def test_results_come_in_the_order_of_the_items_through_any_executor():
    expected = [0, 2, 4, 6]
    assert parallel.run(double, range(4)) == expected
    for executor in (ThreadPoolExecutor(2), ProcessPoolExecutor(1)):
        with executor:
            assert parallel.run(double, range(4), executor=executor) == expected


def test_a_bar_is_shown_when_asked_for_and_ends_full(monkeypatch):
    out = io.StringIO()
    monkeypatch.setattr("sys.stderr", out)
    parallel.run(double, range(5), progress=True, title="doubles")
    last = out.getvalue().split("\r")[-1]
    assert last.startswith("doubles [" + "=" * parallel.WIDTH + "] 5 of 5, 0 s left")
    assert last.endswith("\n")


def test_quick_work_and_work_away_from_a_terminal_is_silent(monkeypatch):
    for out in (Terminal(), io.StringIO()):
        monkeypatch.setattr("sys.stderr", out)
        parallel.run(double, range(5))
        assert out.getvalue() == ""


def test_long_work_on_a_terminal_shows_a_bar_unasked(monkeypatch):
    out = Terminal()
    monkeypatch.setattr("sys.stderr", out)
    monkeypatch.setattr(parallel, "PATIENCE", 0.0)
    parallel.run(double, range(5))
    assert "5 of 5" in out.getvalue()


def test_an_error_of_the_task_comes_through():
    with ThreadPoolExecutor(1) as executor, pytest.raises(ZeroDivisionError):
        parallel.run(lambda x: 1 / x, [1, 0, 1], executor=executor)
