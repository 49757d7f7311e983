"""Effects that start together: none of them may bend another way than its name."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from toy import Toy, toy

from slider_drilling.gap import Effect, Parameter
from slider_drilling.gap.explain import _coupled_effects, explain
from slider_drilling.gap.selection import forward_selection as forward


def effect(name: str, **kinds) -> Effect:
    amplitude = Parameter(name, 0.0, -50.0, 50.0, 0.3, "N")
    return Effect(name, "contact", (amplitude,), scan=((1.0,), (2.0,), (4.0,)), **kinds)


def begun(effects: list[Effect]) -> dict[str, Parameter]:
    model = SimpleNamespace(coupled_effects=tuple(one.name for one in effects))
    (chosen,) = _coupled_effects(model, effects)
    return {one.name: one.parameters[0] for one in chosen}


def test_amplitudes_stay_within_what_their_names_stand_for():
    first = begun([effect("drop", physical=(0.0, np.inf)), effect("bias"), effect("lag", physical=(0.5, 30.0))])
    assert (first["drop"].lower, first["drop"].upper) == (0.0, 50.0)
    assert (first["bias"].lower, first["bias"].upper) == (-50.0, 50.0)
    assert (first["lag"].lower, first["lag"].upper) == (0.0, 30.0), "neutral stays within"


@dataclass(frozen=True)
class Joined(Toy):
    coupled_effects: tuple[str, ...] = ("sine", "bend")


@pytest.mark.parametrize("bend", [3.0, -3.0])
def test_a_shape_with_the_wrong_sign_is_not_named_beside_others(bend):
    """Sine and bend begin together; a bend that its name does not stand for must not be in the answer by that name."""
    log = toy({"sine": 4.0, "bend": bend}, seed=3)
    effects = (effect("sine", physical=(0.0, np.inf)), effect("bend", physical=(0.0, np.inf)), effect("saw"))
    answer = explain(Joined(log.runs, log.nuisance, effects), seed=1)
    assert "sine" in answer.effects
    assert ("bend" in answer.effects) == (bend > 0.0)
    assert all(answer.parameters[name] >= 0.0 for name in answer.effects if name != "saw")


@pytest.mark.parametrize("seed", range(3))
def test_what_came_along_and_pays_for_nothing_is_no_name(seed, monkeypatch):
    """Sine and bend begin together and there is no bend: no difference of a score, however sure, makes it a name."""
    monkeypatch.setattr(forward, "predicts_better", lambda *compared: True)
    log = toy({"sine": 4.0}, seed=seed)
    answer = explain(Joined(log.runs, log.nuisance, (effect("sine"), effect("bend"), effect("saw"))), seed=1)
    assert answer.effects == ("sine",)
