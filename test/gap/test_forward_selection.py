"""Forward selection: second effects, and when the search ends."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, SHAPES, TIME, Toy, force, toy

from slider_drilling.gap import SimulationOptions, explain
from slider_drilling.gap.evidence.adequacy import adequacy_of_fit
from slider_drilling.gap.evidence.score import make_folds, score_held_out
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection import forward_selection


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("large", "small"), [({"sine": 12.0}, {"bend": 3.0}), ({"sine": 20.0}, {"saw": 4.0})])
def test_second_effect_with_a_gap_is_named(seed, large, small):
    answer = explain(toy(large | small, seed))
    assert set(answer.effects) == {*large, *small}


@pytest.mark.parametrize("seed", range(3))
def test_second_effect_without_a_gap_is_suspected(seed):
    """It is certain, but beside the large one E is as good as one."""
    answer = explain(toy({"sine": 20.0, "saw": 1.5}, seed))
    assert answer.effects == ("sine",)
    assert [each.effect.name for each in answer.suspected] == ["saw"]


@pytest.mark.parametrize("seed", range(3))
def test_small_effect_that_leaves_structure_is_not_named(seed):
    """A hump that no law has: some laws close some of it, none ends it."""
    hump = 3.0 * np.exp(-(((TIME - 30.0) / 6.0) ** 2))
    answer = explain(toy({"sine": 12.0}, seed, extra=hump))
    assert answer.effects == ("sine",)


@dataclass(frozen=True)
class Wild(Toy):
    """A toy that behaves differently at every level."""

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        ways = [20.0 * np.sin(1e4 * (values.get("level", 0.0) - 1.0)) * SHAPES["sine"] for values in sets]
        return {"force": np.stack([force(values) + way for values, way in zip(sets, ways, strict=True)])}


def test_unpredictable_replicates_do_not_end_the_search():
    def adequacy(sine: float):
        model = Wild(toy({"level": 1.0, "sine": sine}, 5).runs)
        problem = build_problem(model, [{"force": 1.0}])
        found = fit(problem, parameters_of(problem, ()), {"level": 1.0}, iterations=0)
        return adequacy_of_fit(problem, found, score_held_out(problem, found, make_folds(problem)), seed=0)

    assert adequacy(0.0).complete
    excused = adequacy(1.3)
    assert excused.threshold > 1.5 and excused.adequate
    assert not excused.negligible and not excused.complete


def test_failure_with_new_noise_floors_is_reported(monkeypatch):
    def failed(state, one, left, seed):
        return state, replace(one, closed=-0.1, interval=(-0.2, 0.1), failures=("not in this noise",))

    monkeypatch.setattr(forward_selection, "update_floors", failed)
    answer = explain(toy({"sine": 4.0}, seed=1))
    assert answer.effects == ()
    sine = next(one for one in answer.candidates if one.effect.name == "sine")
    assert (sine.failures, sine.closed) == (("not in this noise",), -0.1)


@pytest.mark.parametrize(("uncertain", "left"), [({"saw"}, ("sine",)), ({"sine", "saw"}, ())])
def test_effects_of_uncertain_size_are_dropped_at_the_end(monkeypatch, uncertain, left):
    state = explain(toy({"sine": 20.0, "saw": 4.0}, 0)).state
    assert set(state.current.names) == {"sine", "saw"}
    reasons = {name: (f"{name} may be none",) for name in uncertain}
    monkeypatch.setattr(
        forward_selection, "failures", lambda stage, evidence: reasons.get(evidence.new_effects[0].name, ())
    )
    dropped = forward_selection.drop_uncertain_effects(state, EFFECTS, 0)
    assert dropped.current.names == left
    said = {each.effect.name: each.failures for step in dropped.steps for each in step.candidates if each.failures}
    assert {name: said[name] for name in uncertain} == reasons
