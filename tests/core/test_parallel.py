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


def test_a_bar_is_shown_when_asked_for_counts_what_was_begun_and_ends_full(monkeypatch):
    pytest.importorskip("tqdm", reason="bars are tqdm's: pip install 'rbfound[progress]'")
    out = io.StringIO()
    monkeypatch.setattr("sys.stderr", out)
    assert parallel.run(double, range(5), progress=True, title="doubles", begun=[0, 2]) == [0, 2, 4, 6, 8]
    first, *_, last = out.getvalue().strip().split("\r")
    assert first.startswith("doubles:  40%")
    assert last.startswith("doubles: 100%")
    assert "5/5" in last


def test_quick_work_and_work_away_from_a_terminal_is_silent(monkeypatch):
    monkeypatch.setattr(parallel, "PATIENCE", 60.0)
    for out in (Terminal(), io.StringIO()):
        monkeypatch.setattr("sys.stderr", out)
        parallel.run(double, range(5))
        assert out.getvalue() == ""


def test_long_work_on_a_terminal_shows_a_bar_unasked(monkeypatch):
    pytest.importorskip("tqdm", reason="bars are tqdm's: pip install 'rbfound[progress]'")
    out = Terminal()
    monkeypatch.setattr("sys.stderr", out)
    monkeypatch.setattr(parallel, "PATIENCE", 0.0)
    parallel.run(double, range(5))
    assert "5/5" in out.getvalue()


def test_without_tqdm_the_work_is_done_and_a_bar_that_is_asked_for_is_refused(monkeypatch):
    monkeypatch.setattr(parallel, "find_spec", lambda name: None)
    assert parallel.run(double, range(3)) == [0, 2, 4]
    with pytest.raises(ValueError, match=r"pip install 'rbfound\[progress\]'"):
        parallel.run(double, range(3), progress=True)


@pytest.mark.parametrize("executor", [None, ThreadPoolExecutor(1)])
def test_an_error_of_the_task_comes_through_and_what_was_finished_has_been_kept(executor):
    kept = []
    with pytest.raises(ZeroDivisionError):
        parallel.run(lambda x: 1 / x, [1, 2, 0, 4], executor=executor, keep=lambda found: kept.append(list(found)))
    assert kept == [[1.0], [1.0, 0.5]]
