"""Two effects of which each hides the other: neither explains anything alone, both together do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import SHAPES, TIME, Toy, toy

from slider_drilling.gap import Effect, Parameter, SimulationOptions, explain
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import scan_effects, screen, screen_pairs

# Each the sine with a little of the saw, of one sign and of the other: their difference is a saw alone.
ALIKE = {
    "left": SHAPES["sine"] + 0.2 * SHAPES["saw"],
    "right": SHAPES["sine"] - 0.2 * SHAPES["saw"],
    "third": SHAPES["saw"] + 0.2 * np.cos(2.0 * np.pi * TIME / 7.0),  # much like their difference, and not quite
}


def effect(name: str, **kinds: object) -> Effect:
    return Effect(name, "contact", (Parameter(name, 0.0, -50.0, 50.0, 0.3, "N"),), ((-4.0,), (2.0,), (5.0,)), **kinds)


@dataclass(frozen=True)
class Hidden(Toy):
    effects: tuple[Effect, ...] = (effect("left"), effect("right"), effect("bend"), effect("step"))

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        shapes = {**SHAPES, **ALIKE}
        rows = [sum((v * shapes[name] for name, v in one.items()), np.zeros_like(TIME)) for one in sets]
        return {"force": np.stack(rows)}


def hidden(left: float, right: float, seed: int) -> Hidden:
    log = toy({"level": 1.0}, seed, extra=left * ALIKE["left"] + right * ALIKE["right"])
    return Hidden(log.runs)


def test_pair_predicts_more_than_either_effect():
    model = hidden(8.0, -8.0, seed=3)
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, problem.expand_per_run(model.nuisance), {})
    alone = {one.effect.name: one.predicted_gain for one in screen(scan_effects(problem, base, model.effects))}
    best, *others = screen_pairs(scan_effects(problem, base, model.effects), 3, np.inf)
    assert {one.name for one in best.effects} == {"left", "right"}
    reached = fit(problem, parameters_of(problem, best.effects), best.start)
    assert best.predicted_gain == pytest.approx(base.cost - reached.cost, rel=0.1), "in a linear model secants hold"
    assert max(alone.values()) < 0.2 * best.predicted_gain
    assert best.start["left"] == pytest.approx(8.0, abs=3.5)
    assert best.start["right"] == pytest.approx(-8.0, abs=3.5)
    assert all(one.predicted_gain <= best.predicted_gain for one in others)


def test_identical_effects_make_no_pair():
    model = replace(hidden(8.0, -8.0, seed=3), effects=(effect("left"), effect("left")))
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, problem.expand_per_run(model.nuisance), {})
    assert screen_pairs(scan_effects(problem, base, model.effects), 3, np.inf) == []


def test_pairs_far_above_the_threshold_are_dropped():
    model = hidden(8.0, -8.0, seed=3)
    problem = build_problem(model, [{"force": 0.1}])
    scan = scan_effects(problem, fit(problem, problem.expand_per_run(model.nuisance), {}), model.effects)
    (best, *_) = screen_pairs(scan, 9, np.inf)
    assert best.predicted_gap == pytest.approx(10.0, rel=0.2), "all that a tenth of the noise leaves"
    assert best in screen_pairs(scan, 9, 3.0)
    assert screen_pairs(scan, 9, 2.0) == []


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_effects_that_hide_each_other_are_named(seed):
    answer = explain(hidden(12.0, -12.0, seed))
    assert answer.verdict == "effect"
    assert set(answer.effects) == {"left", "right"}
    assert set(answer.indistinguishable) == {"left", "right"}
    assert "left" in answer.sentence and "right" in answer.sentence
    assert answer.parameters["left"] == pytest.approx(12.0, abs=4.0)
    assert answer.closed_interval[0] > 0.0


def test_pair_stays_within_physical_ranges():
    backwards = (effect("left", physical=(0.0, np.inf)), effect("right", physical=(0.0, np.inf)), effect("bend"))
    answer = explain(replace(hidden(12.0, -12.0, seed=1), effects=backwards))
    assert "right" not in answer.effects


def test_noise_has_no_pair():
    for seed in range(8):
        assert explain(hidden(0.0, 0.0, seed)).effects == ()


THREE = (effect("left"), effect("right"), effect("third"))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_pair_replaces_a_similar_single_effect(seed):
    answer = explain(replace(hidden(30.0, -30.0, seed), effects=THREE))
    assert (answer.verdict, set(answer.effects)) == ("effect", {"left", "right"})
    (taken,) = answer.state.steps
    assert any(one.effect.name == "third" and one.passed for one in taken.candidates), "reported, and not in the answer"


def test_sufficient_single_effect_is_kept():
    log = toy({"level": 1.0}, seed=1, extra=12.0 * ALIKE["third"])
    answer = explain(Hidden(log.runs, effects=THREE))
    assert (answer.verdict, answer.effects) == ("effect", ("third",))


# A shape that no law has, and that no law can nearly follow.
LAWLESS = 3.0 * np.sin(2.0 * np.pi * TIME / 5.0)


@pytest.mark.parametrize(("size", "effects", "named"), [(30.0, THREE, ("third",)), (12.0, THREE[:2], ())])
def test_pair_that_leaves_a_gap_is_refused(size, effects, named):
    """Neither in the place of one effect nor of none, however much of the gap they close."""
    log = hidden(size, -size, seed=1)
    (run,) = log.runs
    channel = replace(run.channels[0], measured=run.channels[0].measured + LAWLESS)
    answer = explain(Hidden((replace(run, channels=(channel,)),), effects=effects))
    assert answer.verdict == ("effect_and_unknown" if named else "unknown")
    assert answer.effects == named
