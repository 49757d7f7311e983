"""Finalists of all steps in one list, whatever was fitted twice."""

from types import SimpleNamespace

import numpy as np
from toy import toy

from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.explain import GapDiagnosis
from slider_drilling.gap.selection.state import CandidateResult, SelectionStep


def judged(effect, density):
    score = HeldOutScore(density, density, density, 1.0, {}, 0)
    explained = SimpleNamespace(score=score)
    return CandidateResult(effect, explained, 0.5, (0.2, 0.8), ())


def test_an_effect_that_was_judged_more_than_once_is_told_once():
    first, second, *_ = toy({}, 1).effects
    once, again, other = judged(first, np.zeros(3)), judged(first, np.ones(3)), judged(second, np.ones(3))
    steps = (SelectionStep((again, other), once, (), {}), SelectionStep((other,), None, (), {}))
    told = GapDiagnosis.candidates.fget(SimpleNamespace(state=SimpleNamespace(steps=steps)))
    assert [one.effect.name for one in told] == [first.name, second.name]
    assert told[0] is once
