"""The leader of a race is looked for anew beside the rest of itself: what it began with is not where it has to stay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from toy import TIME, Toy, toy

from slider_drilling.gap import Effect, Parameter, SimulationOptions
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.race import Arm, race, restart_leader

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
def test_each_of_those_that_were_added_is_looked_for_anew(added, hertz):
    """The tone began at another pitch, where no gradient leads to its own."""
    model = Sounding(toy({"level": 1.0, "step": 4.0}, seed=2, extra=5.0 * tone(0.3101)).runs)
    problem = build_problem(model, [{"force": 1.0}])
    ran = race([problem], [Arm((TONE, STEP), 0, {"tone.size": 3.0, "tone.hertz": 0.11, "step": 1.0}, None)])
    best = restart_leader([problem], ran, added)[0]
    assert best.names == ("tone", "step")
    assert best.fit is not None and best.cost <= ran[0].cost
    assert best.fit.values["tone.hertz"] == pytest.approx(hertz, abs=0.01)
    assert best.fit.values["step"] == pytest.approx(4.0, abs=1.0)
