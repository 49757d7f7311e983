"""The recommended run: two explanations differ under it more than in the present log."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import SHAPES, Toy, force, toy

from slider_drilling.gap import Effect, Manoeuvre, Parameter, SimulationOptions, explain


def law(name: str) -> Effect:
    return Effect(name, "contact", (Parameter(name, 0.0, -50.0, 50.0, 0.3, "N"),), scan=((-2.0,), (1.0,), (3.0,)))


@dataclass(frozen=True)
class Twins(Toy):
    """Two laws that are nearly one in the log; shaken, the right one is a saw besides, still, both are nothing."""

    effects: tuple[Effect, ...] = (law("left"), law("right"))
    moved: float = 1.0
    shaken: float = 0.02
    offered: tuple[str, ...] = ("shake", "rest")

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([force(one) + self.twins(one) for one in sets])}

    def twins(self, values: Mapping[str, float]) -> np.ndarray:
        both = values.get("left", 0.0) + values.get("right", 0.0)
        return self.moved * (both * SHAPES["sine"] + self.shaken * values.get("right", 0.0) * SHAPES["saw"])

    def manoeuvres(self) -> list[Manoeuvre]:
        made = {"shake": replace(self, shaken=1.0), "rest": replace(self, moved=0.0)}
        return [Manoeuvre(name, {"by": 1.0}, made[name]) for name in self.offered]


def twins(truth: float, offered: tuple[str, ...] = ("shake", "rest")) -> Twins:
    (run,) = toy({"level": 2.0}, 6, extra=truth * SHAPES["sine"]).runs
    return Twins((run,), offered=offered)


def test_manoeuvre_that_separates_two_effects_is_recommended():
    answer = explain(twins(5.0))
    (name,) = answer.effects
    other = "right" if name == "left" else "left"
    assert answer.indistinguishable[name] == (other,)
    found = answer.next_manoeuvre
    assert found is not None
    assert (found.description, found.separates) == ("shake", (name, other))
    # Of a saw of five, what level and slope cannot make up for.
    rows = np.stack([SHAPES["level"], SHAPES["slope"]])
    saw = SHAPES["saw"] - rows.T @ np.linalg.lstsq(rows.T, SHAPES["saw"], rcond=None)[0]
    assert found.distance == pytest.approx(5.0 * float(np.sqrt(np.mean(saw**2))), rel=0.1)
    assert found.distance_in_log < 0.1
    assert found.all_distances["rest"] == pytest.approx(0.0, abs=1e-9)


def test_no_manoeuvre_without_gain_or_gap():
    assert explain(twins(5.0, ("rest",))).next_manoeuvre is None
    quiet = explain(twins(0.0))
    assert quiet.verdict in ("none", "parameters")
    assert quiet.next_manoeuvre is None
