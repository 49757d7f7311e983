"""A name is given only if the gap shrinks with it, whatever was accepted on the way."""

from dataclasses import replace

import numpy as np
from toy import EFFECTS, toy

from slider_drilling.gap import explain
from slider_drilling.gap.selection import forward_selection as forward
from slider_drilling.gap.selection.verdict import reach_verdict


def test_names_with_which_the_gap_does_not_shrink_for_certain_are_withdrawn():
    state = explain(toy({"level": 2.0, "sine": 4.0}, seed=2), effects=EFFECTS).state
    assert reach_verdict(state).effects == ("sine",)
    score = state.current.score
    half = np.arange(score.squares.size) % 2 == 0
    wider = np.where(half, state.calibrated.score.squares * 1.2, state.calibrated.score.squares * 0.9)
    worse = replace(score, squares=wider, gap=float(np.sqrt(np.mean(wider))))
    decided = reach_verdict(replace(state, current=replace(state.current, score=worse)))
    assert decided.effects == ()
    assert decided.verdict == "unknown"
    assert decided.state.current is decided.state.calibrated


def test_who_fails_in_the_noise_that_it_shows_says_why(monkeypatch):
    def failed(state, one, left, seed):
        return state, replace(one, closed=-0.1, interval=(-0.2, 0.1), failures=("not in this noise",))

    monkeypatch.setattr(forward, "update_floors", failed)
    answer = explain(toy({"sine": 4.0}, seed=1))
    assert answer.effects == ()
    sine = next(one for one in answer.candidates if one.effect.name == "sine")
    assert (sine.failures, sine.closed) == (("not in this noise",), -0.1)
