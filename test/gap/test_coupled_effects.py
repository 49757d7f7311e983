"""Effects that start together stay within their physical ranges."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from toy import Toy, toy

from slider_drilling.gap import Effect, Parameter
from slider_drilling.gap.explain import coupled_effect_sets, explain
from slider_drilling.gap.search.global_search import global_search
from slider_drilling.gap.selection import evidence_tests, start_points


def effect(name: str, **kinds) -> Effect:
    amplitude = Parameter(name, 0.0, -50.0, 50.0, 0.3, "N")
    return Effect(name, "contact", (amplitude,), scan=((1.0,), (2.0,), (4.0,)), **kinds)


def start_bounds(effects: list[Effect]) -> dict[str, Parameter]:
    model = SimpleNamespace(coupled_effects=tuple(one.name for one in effects))
    (chosen,) = coupled_effect_sets(model, effects)
    return {one.name: one.parameters[0] for one in chosen}


def test_coupled_amplitudes_stay_physical():
    first = start_bounds([effect("drop", physical=(0.0, np.inf)), effect("bias"), effect("lag", physical=(0.5, 30.0))])
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


@dataclass(frozen=True)
class Fed(Joined):
    """The same, and half of what is measured can be fed back."""

    observed_channel: str = "force"

    def simulate(self, run, sets, options):
        free = super().simulate(run, sets, options)["force"]
        fed = options.observer_gain * self.runs[run].channels[0].measured
        return {"force": (free + fed) / (1.0 + options.observer_gain)}

    def with_measured(self, run, measured):
        return self

    def noise_shrinkage(self, run, gain):
        return 1.0 + gain


def test_coupled_effects_are_searched_in_every_simulation_mode(monkeypatch):
    """Fed back, a self-excited oscillation keeps its phase, and a search finds what it cannot find in free runs."""
    gains = []

    def search(problem, fine, spans, fixed, seed):
        gains.append(problem.options.observer_gain)
        return global_search(problem, fine, spans, fixed, seed)

    monkeypatch.setattr(start_points, "global_search", search)
    log = toy({"sine": 4.0}, seed=0)
    explain(Fed(log.runs, log.nuisance, (effect("sine"), effect("bend"))), seed=1)
    assert len(gains) > 1 and gains[0] == 0.0 and all(gain > 0.0 for gain in gains[1:])
