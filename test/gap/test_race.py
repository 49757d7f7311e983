"""The race, and the restart of its leader beside the rest of itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, TIME, Toy, toy

from slider_drilling.gap import Effect, Parameter, SimulationOptions
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import FINALISTS, Arm, finalists, parameters_of, race, restart_leader
from slider_drilling.gap.search.screen import scan_effects, screen

TONE = Effect(
    "tone", "contact",
    (Parameter("tone.size", 0.0, -50.0, 50.0, 0.3, "N"), Parameter("tone.hertz", 0.2, 0.05, 0.45, 1e-3, "Hz")),
    scan=tuple((3.0, hertz) for hertz in (0.11, 0.23, 0.31)),
)  # fmt: skip
STEP = Effect("step", "sensor", (Parameter("step", 0.0, -50.0, 50.0, 0.3, "N"),), scan=((1.0,), (3.0,), (6.0,)))


def tone(hertz: float) -> np.ndarray:
    return np.sin(2.0 * np.pi * hertz * TIME)


@dataclass(frozen=True)
class Sounding(Toy):
    effects: tuple[Effect, ...] = (TONE, STEP)

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        heard = [one.get("tone.size", 0.0) * tone(one.get("tone.hertz", 0.2)) for one in sets]
        return {"force": np.stack(heard) + super().simulate(run, sets, options)["force"]}


@pytest.mark.parametrize(("added", "hertz"), [(1, 0.11), (2, 0.3101)])
def test_leader_restarts_each_added_effect(added, hertz):
    """The tone began at another pitch, where no gradient leads to its own."""
    model = Sounding(toy({"level": 1.0, "step": 4.0}, seed=2, extra=5.0 * tone(0.3101)).runs)
    problem = build_problem(model, [{"force": 1.0}])
    ran = race([problem], [Arm((TONE, STEP), 0, {"tone.size": 3.0, "tone.hertz": 0.11, "step": 1.0}, None)])
    best = restart_leader([problem], ran, added)[0]
    assert best.names == ("tone", "step")
    assert best.fit is not None and best.cost <= ran[0].cost
    assert best.fit.values["tone.hertz"] == pytest.approx(hertz, abs=0.01)
    assert best.fit.values["step"] == pytest.approx(4.0, abs=1.0)


def test_race_ends_where_exhaustive_search_does():
    model = toy({"level": 1.0, "slope": 0.5, "bend": 3.0}, 8)
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, parameters_of(problem, ()), {})
    costs = {}
    for effect in EFFECTS:
        starts = [base.values | effect.values(point) for point in effect.scan]
        ends = [fit(problem, parameters_of(problem, [effect]), start, iterations=20) for start in starts]
        costs[effect.name] = min(end.cost for end in ends)
    arms = [
        Arm((c.effect,), 0, start, base) for c in screen(scan_effects(problem, base, EFFECTS)) for start in c.starts
    ]
    ran = race((problem,), arms)
    assert ran[0].names == (min(costs, key=lambda name: costs[name]),) == ("bend",)
    assert ran[0].cost == pytest.approx(costs["bend"], abs=0.5)


def test_nonphysical_arms_take_no_finalist_place():
    signed = [replace(effect, physical=(0.0, np.inf)) for effect in EFFECTS]
    wrong = [Arm((effect,), 0, {effect.name: -3.0}, None) for effect in signed[:3]]
    right = [Arm((effect,), 0, {effect.name: 3.0}, None) for effect in signed]
    leaders = [arms[0] for arms in finalists([*wrong, *right])]
    assert sum(arm.physical for arm in leaders) == FINALISTS
    assert [arm.names for arm in leaders if not arm.physical] == [(signed[0].name,)]
