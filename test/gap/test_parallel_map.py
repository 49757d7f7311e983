"""Work on all cores comes back in its order, and fails as it would alone."""

import threading

import pytest
from toy import toy

from slider_drilling.gap import explain
from slider_drilling.process import parallel_map as module
from slider_drilling.process.parallel_map import idle_threads, parallel_map


@pytest.mark.parametrize("threads", [1, 2])
def test_results_come_in_input_order(threads, monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: threads)
    second = threading.Event()

    def slow_first(number: int) -> int:
        if number == 1:
            second.set()
        assert number or threads == 1 or second.wait(60.0), "the second piece did not run beside the first"
        return 10 * number

    assert parallel_map(slow_first, range(5)) == [0, 10, 20, 30, 40]
    assert parallel_map(slow_first, []) == []


@pytest.mark.parametrize("threads", [1, 2])
def test_error_is_raised(threads, monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: threads)
    with pytest.raises(ZeroDivisionError):
        parallel_map(lambda number: 1 / number, [2, 1, 0, 3])


def test_first_error_in_input_order_is_raised(monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: 2)
    later = threading.Event()

    def fails(number: int) -> None:
        if number == 1:
            later.set()
            raise KeyError
        assert later.wait(60.0)
        raise ValueError

    with pytest.raises(ValueError):
        parallel_map(fails, range(2))
    assert idle_threads() == 1


def test_nested_tasks_use_idle_threads(monkeypatch):
    """Two pieces on three threads: one of them, which asks for two more, has the third thread's help."""
    monkeypatch.setattr(module, "available_threads", lambda: 3)
    both, helped, over, seen = threading.Barrier(2), threading.Barrier(2), threading.Event(), set()

    def inner(number: int) -> None:
        seen.add(threading.get_ident())
        helped.wait(60.0)

    def outer(number: int) -> None:
        both.wait(60.0)
        if number == 1:
            assert over.wait(60.0)
            return
        assert idle_threads() == 1
        parallel_map(inner, range(2))
        over.set()

    parallel_map(outer, range(2))
    assert len(seen) == 2
    assert idle_threads() == 2


def test_threads_never_exceed_the_cores(monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: 2)
    lock, now, most = threading.Lock(), [0], [0]

    def innermost(number: int) -> int:
        with lock:
            now[0] += 1
            most[0] = max(most[0], now[0])
        sum(range(2000))
        with lock:
            now[0] -= 1
        return number

    found = parallel_map(lambda one: parallel_map(lambda two: innermost(one + two), range(5)), range(8))
    assert found == [[one + two for two in range(5)] for one in range(8)]
    assert most[0] <= 2
    assert idle_threads() == 1


def test_diagnosis_is_independent_of_threads(monkeypatch):
    answers = []
    for threads in (1, 2, 7):
        monkeypatch.setattr(module, "available_threads", lambda threads=threads: threads)
        answers.append(explain(toy({"level": 2.0, "slope": -1.5, "saw": 4.0}, 7)))
    results = [(one.effects, one.closed, one.closed_interval, one.parameters) for one in answers]
    assert results[0] == results[1] == results[2]
