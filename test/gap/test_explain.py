"""The whole engine on a linear model: false alarms, names, intervals, over 200 replicates."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom
from toy import TIME, Toy, toy

from slider_drilling.gap import explain
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.explain import GapDiagnosis
from slider_drilling.gap.results.intervals import parameter_intervals
from slider_drilling.gap.selection.state import CandidateResult, SelectionStep

TUNED = {"level": 2.0, "slope": -1.5}
REPLICATES = 100


@pytest.fixture(scope="module")
def quiet():
    return [explain(toy(TUNED, seed)) for seed in range(REPLICATES)]


@pytest.fixture(scope="module")
def sawn():
    return [explain(toy(TUNED | {"saw": 4.0}, 1000 + seed)) for seed in range(REPLICATES)]


def test_false_alarms_stay_at_their_level(quiet):
    alarms = sum(answer.verdict not in ("none", "parameters") for answer in quiet)
    # one in a hundred by each of the two tests that may raise one
    assert alarms <= binom.ppf(0.999, REPLICATES, 0.02)


def test_only_the_true_effect_is_named(sawn):
    right = sum(answer.effects == ("saw",) for answer in sawn)
    assert right >= 0.97 * REPLICATES


def test_parameter_intervals_cover_the_truth(quiet, sawn):
    held = []
    for answer in sawn:
        if answer.effects == ("saw",):
            current = answer.state.current
            spans = parameter_intervals(current.problem, current.fit)
            held += [low <= truth <= high for truth, (low, high) in ((4.0, spans["saw"]), (-1.5, spans["slope"]))]
    assert binom.ppf(0.001, len(held), 0.95) <= sum(held) <= binom.ppf(0.999, len(held), 0.95)


def test_named_effect_shrinks_the_gap(sawn):
    for answer in sawn:
        if answer.effects:
            assert answer.gap_with_effects < answer.gap_calibrated
            assert answer.closed_interval[0] > 0.0


def test_same_seed_gives_the_same_diagnosis():
    first, second = (explain(toy(TUNED | {"bend": 3.0}, 7), seed=4) for _ in range(2))
    assert (first.effects, first.closed, first.closed_interval) == (
        second.effects,
        second.closed,
        second.closed_interval,
    )
    assert [one.closed for one in first.candidates] == [one.closed for one in second.candidates]


def test_two_effects_are_both_named():
    answer = explain(toy(TUNED | {"bend": 4.0, "saw": 5.0}, 5))
    assert set(answer.effects) == {"bend", "saw"}
    assert answer.verdict == "effect"
    assert answer.misfit_channels == ()
    first, second = answer.candidates[:2]
    assert (first.beside, second.beside) == ((), (first.effect.name,))


def test_smaller_second_effect_is_named():
    answer = explain(toy(TUNED | {"bend": 30.0, "saw": 6.0}, 5))
    assert set(answer.effects) == {"bend", "saw"}


def test_unknown_shape_is_reported():
    hump = 4.0 * np.exp(-(((TIME - 40.0) / 9.0) ** 2)) - 3.0 * np.exp(-(((TIME - 95.0) / 9.0) ** 2))
    answer = explain(toy(TUNED, 3, extra=hump))
    assert answer.verdict in ("unknown", "effect_and_unknown")
    if answer.alternative is not None:
        assert answer.alternative.x.shape == answer.alternative.y.shape


def test_interrupt_gives_the_diagnosis_so_far():
    calls = []

    def interrupted(stage, share):
        calls.append(stage)
        if stage.startswith("racing"):
            raise KeyboardInterrupt

    answer = explain(toy(TUNED | {"saw": 4.0}, 1), progress=interrupted)
    assert answer.state.interrupted
    assert answer.effects == ()
    assert any("interrupted" in remark for remark in answer.remarks)


def test_excluded_effects_are_not_named():
    model = toy(TUNED | {"saw": 4.0}, 2)
    answer = explain(model, effects=[effect for effect in model.effects if effect.name != "saw"])
    assert "saw" not in answer.effects
    assert answer.verdict != "effect"


def test_model_needs_no_optional_protocol():
    assert not hasattr(Toy, "max_fidelity")


def test_implausible_nuisance_is_remarked():
    (remark,) = explain(toy({"level": 20.0, "slope": 1.0}, 8)).remarks
    assert remark.startswith("level is calibrated to") and "4.0 standard deviations from the model's 0" in remark
    assert not explain(toy(TUNED, 8)).remarks


def candidate(effect, density):
    score = HeldOutScore(density, density, density, 1.0, {}, 0)
    fitted = SimpleNamespace(score=score)
    return CandidateResult(effect, fitted, 0.5, (0.2, 0.8), ())


def test_candidates_list_each_effect_once():
    first, second, *_ = toy({}, 1).effects
    once, again, other = candidate(first, np.zeros(3)), candidate(first, np.ones(3)), candidate(second, np.ones(3))
    steps = (SelectionStep((again, other), once, (), {}), SelectionStep((other,), None, (), {}))
    listed = GapDiagnosis.candidates.fget(SimpleNamespace(state=SimpleNamespace(steps=steps)))
    assert [one.effect.name for one in listed] == [first.name, second.name]
    assert listed[0] is once
