"""Effects that start together stay within their physical ranges."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from toy import Toy, toy

from slider_drilling.gap import Effect, Parameter
from slider_drilling.gap.explain import coupled_effect_sets, explain
from slider_drilling.gap.selection import evidence_tests


def effect(name: str, **kinds) -> Effect:
    amplitude = Parameter(name, 0.0, -50.0, 50.0, 0.3, "N")
    return Effect(name, "contact", (amplitude,), scan=((1.0,), (2.0,), (4.0,)), **kinds)


def begun(effects: list[Effect]) -> dict[str, Parameter]:
    model = SimpleNamespace(coupled_effects=tuple(one.name for one in effects))
    (chosen,) = coupled_effect_sets(model, effects)
    return {one.name: one.parameters[0] for one in chosen}


def test_coupled_amplitudes_stay_physical():
    first = begun([effect("drop", physical=(0.0, np.inf)), effect("bias"), effect("lag", physical=(0.5, 30.0))])
    assert (first["drop"].lower, first["drop"].upper) == (0.0, 50.0)
    assert (first["bias"].lower, first["bias"].upper) == (-50.0, 50.0)
    assert (first["lag"].lower, first["lag"].upper) == (0.0, 30.0), "neutral stays within"


@dataclass(frozen=True)
class Joined(Toy):
    coupled_effects: tuple[str, ...] = ("sine", "bend")


@pytest.mark.parametrize("bend", [3.0, -3.0])
def test_nonphysical_coupled_effect_is_not_named(bend):
    """Sine and bend begin together; a bend that its name does not stand for must not be in the answer by that name."""
    log = toy({"sine": 4.0, "bend": bend}, seed=3)
    effects = (effect("sine", physical=(0.0, np.inf)), effect("bend", physical=(0.0, np.inf)), effect("saw"))
    answer = explain(Joined(log.runs, log.nuisance, effects), seed=1)
    assert "sine" in answer.effects
    assert ("bend" in answer.effects) == (bend > 0.0)
    assert all(answer.parameters[name] >= 0.0 for name in answer.effects if name != "saw")


@pytest.mark.parametrize("seed", range(3))
def test_needless_coupled_effect_is_dropped(seed, monkeypatch):
    """Sine and bend start together and there is no bend. However well it predicts, it fails the likelihood ratio."""
    compare = evidence_tests.predicts_better
    # Criteria that share no level among candidates compare three things: here, "still needed" alone.
    monkeypatch.setattr(evidence_tests, "predicts_better", lambda *given: len(given) == 3 or compare(*given))
    log = toy({"sine": 4.0}, seed=seed)
    answer = explain(Joined(log.runs, log.nuisance, (effect("sine"), effect("bend"), effect("saw"))), seed=1)
    assert answer.effects == ("sine",)
