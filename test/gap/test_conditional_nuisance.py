"""Nuisance that is calibrated only where it explains what no effect does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest
from toy import EFFECTS, TIME, Toy, toy

from slider_drilling.gap import Effect, Parameter, explain
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.intervals import (
    SPREAD_OF_ANSWERS,
    intervals_beside_all_nuisance,
    parameter_intervals,
)
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.selection import forward_selection
from slider_drilling.gap.selection.forward_selection import CLEAR_LEAD, clear_leaders

BEND = next(effect for effect in EFFECTS if effect.name == "bend")
TWIN = replace(BEND, name="twin", parameters=(replace(BEND.parameters[0], name="twin"),))


@dataclass(frozen=True)
class BendingToy(Toy):
    """The toy, whose bend is no effect but may be calibrated."""

    effects: tuple[Effect, ...] = tuple(effect for effect in EFFECTS if effect is not BEND)
    conditional_nuisance: tuple[Effect, ...] = (BEND,)

    def with_nuisance(self, parameters: Sequence[Parameter]) -> BendingToy:
        return replace(self, nuisance=(*self.nuisance, *parameters))


class TwinToy(BendingToy):
    """Its bend may be calibrated under two names."""

    def simulate(self, run, sets, options):  # type: ignore[no-untyped-def]
        merged = [{**values, "bend": values.get("bend", 0.0) + values.get("twin", 0.0)} for values in sets]
        return super().simulate(run, merged, options)


class LiftingToy(BendingToy):
    """Its bend lifts the level, too."""

    def simulate(self, run, sets, options):  # type: ignore[no-untyped-def]
        lifted = [{**values, "level": values.get("level", 0.0) + values.get("bend", 0.0)} for values in sets]
        return super().simulate(run, lifted, options)


def bending_toy(seed: int, **truth: float) -> BendingToy:
    return BendingToy(toy({"level": 2.0} | truth, seed).runs)


def test_nuisance_that_explains_the_gap_is_calibrated():
    answer = explain(bending_toy(1, bend=4.0))
    assert answer.verdict == "parameters"
    assert abs(answer.parameters["bend"] - 4.0) < 0.5


def test_simulations_before_it_was_calibrated_count_too():
    counted: list[int] = []

    class CountingToy(BendingToy):
        def simulate(self, run, sets, options):  # type: ignore[no-untyped-def]
            counted.append(len(sets))
            return super().simulate(run, sets, options)

    answer = explain(CountingToy(bending_toy(1, bend=4.0).runs))
    assert answer.parameters["bend"] != 0.0
    assert answer.simulation_count == sum(counted)


def test_effect_beside_conditional_nuisance_is_named():
    answer = explain(bending_toy(2, bend=4.0, saw=6.0))
    assert answer.effects == ("saw",)
    assert abs(answer.parameters["bend"] - 4.0) < 0.5


def test_nuisance_is_not_calibrated_without_need():
    answer = explain(bending_toy(3, saw=4.0))
    assert answer.effects == ("saw",)
    assert "bend" not in answer.parameters


def test_conditional_nuisance_is_no_candidate():
    answer = explain(bending_toy(4, bend=0.4, saw=4.0))
    assert "bend" not in [candidate.effect.name for candidate in answer.candidates]


def test_alike_nuisance_does_not_stop_calibration():
    """Two conditional parameters that do the same: the log need not tell which it is."""
    (run,) = toy({"level": 2.0, "bend": 4.0}, 5).runs
    answer = explain(TwinToy((run,), conditional_nuisance=(BEND, TWIN)))
    assert answer.verdict == "parameters"
    assert {"bend", "twin"} & set(answer.parameters)


@pytest.mark.parametrize("unknown, tried", [(0.0, False), (3.0, True)])
def test_nuisance_is_tried_together_only_where_something_is_left(monkeypatch, unknown, tried):
    asked, plain = [], forward_selection.grid_arms

    def grid_arms(state, conditional):
        asked.append(conditional)
        return plain(state, conditional)

    monkeypatch.setattr(forward_selection, "grid_arms", grid_arms)
    (run,) = toy({"level": 2.0, "saw": 4.0}, 3, extra=unknown * np.sin(TIME)).runs
    explain(TwinToy((run,), conditional_nuisance=(BEND, TWIN)))
    assert bool(asked) == tried


class RacedArm(NamedTuple):
    """What `clear_leaders` needs of an arm."""

    effects: tuple[Effect, ...]
    cost: float
    physical: bool = True


@pytest.mark.parametrize("lead, leads", [(CLEAR_LEAD - 1.0, False), (CLEAR_LEAD + 1.0, True)])
def test_effects_are_not_tested_where_nuisance_is_far_ahead(lead, leads):
    saw = next(effect for effect in EFFECTS if effect.name == "saw")
    nuisance, effect = RacedArm((BEND,), 500.0), RacedArm((saw,), 500.0 + lead)
    assert clear_leaders([nuisance, effect], (BEND,)) == ([nuisance] if leads else [])
    assert clear_leaders([nuisance._replace(cost=501.0 + lead), effect], (BEND,)) == []


def test_interval_leaves_room_for_nuisance_that_was_not_calibrated():
    model = LiftingToy(toy({"level": 2.0}, 6).runs)
    problem = build_problem(model, [{"force": 1.0}])
    found = fit(problem, problem.expand_per_run(model.nuisance), {})
    alone, beside = parameter_intervals(problem, found), intervals_beside_all_nuisance(problem, found)
    assert alone.keys() == beside.keys() == {"level", "slope"}
    widths = {name: (beside[name][1] - beside[name][0]) / (high - low) for name, (low, high) in alone.items()}
    assert widths["level"] > 1.2 * SPREAD_OF_ANSWERS
    assert widths["slope"] == pytest.approx(SPREAD_OF_ANSWERS, rel=0.02)
