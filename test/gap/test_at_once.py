"""Work on all cores comes back in its order, and fails as it would alone."""

import threading

import pytest
from toy import toy

from slider_drilling.gap import explain
from slider_drilling.gap.search import at_once as module
from slider_drilling.gap.search.at_once import at_once


@pytest.mark.parametrize("threads", [1, 2])
def test_what_is_made_comes_in_the_order_of_what_was_given(threads, monkeypatch):
    monkeypatch.setattr(module, "threads", lambda: threads)
    second = threading.Event()

    def slow_first(number: int) -> int:
        if number == 1:
            second.set()
        assert number or threads == 1 or second.wait(60.0), "the second piece did not run beside the first"
        return 10 * number

    assert at_once(slow_first, range(5)) == [0, 10, 20, 30, 40]
    assert at_once(slow_first, []) == []


@pytest.mark.parametrize("threads", [1, 2])
def test_what_fails_is_raised(threads, monkeypatch):
    monkeypatch.setattr(module, "threads", lambda: threads)
    with pytest.raises(ZeroDivisionError):
        at_once(lambda number: 1 / number, [2, 1, 0, 3])


def test_the_answer_does_not_hang_on_the_threads(monkeypatch):
    answers = []
    for threads in (1, 2):
        monkeypatch.setattr(module, "threads", lambda threads=threads: threads)
        answers.append(explain(toy({"level": 2.0, "slope": -1.5, "saw": 4.0}, 7)))
    told = [(one.effects, one.closed, one.interval, one.parameters) for one in answers]
    assert told[0] == told[1]
