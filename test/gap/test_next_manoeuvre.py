"""The run to ask for next: two explanations differ under it more than anything can make up for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from toy import SHAPES, Toy, force, toy

from slider_drilling.gap import Effect, Manoeuvre, Parameter, SimulationOptions, explain
from slider_drilling.gap.results import next_manoeuvre


def law(name: str) -> Effect:
    return Effect(name, "contact", (Parameter(name, 0.0, -50.0, 50.0, 0.3, "N"),), scan=((-2.0,), (1.0,), (3.0,)))


@dataclass(frozen=True)
class Twins(Toy):
    """Two laws that are nearly one in the log; shaken, the right one is a saw besides, still, both are nothing."""

    effects: tuple[Effect, ...] = (law("left"), law("right"))
    moved: float = 1.0
    shaken: float = 0.02
    most: float = 1.0

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([force(one) + self.twins(one) for one in sets])}

    def twins(self, values: Mapping[str, float]) -> np.ndarray:
        both = values.get("left", 0.0) + values.get("right", 0.0)
        return self.moved * (both * SHAPES["sine"] + self.shaken * values.get("right", 0.0) * SHAPES["saw"])

    @property
    def programme_duration(self) -> float:
        return 120.0

    def programmes(self, duration: float) -> "Shaking":
        return Shaking(self, (Parameter("shaken", 0.02, 0.02, 2.0, 0.1),), ({"shaken": 0.02},))


@dataclass(frozen=True)
class Shaking:
    model: Twins
    variables: tuple[Parameter, ...]
    starts: tuple[Mapping[str, float], ...]

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        return {"rest": Manoeuvre("rest", {}, replace(self.model, moved=0.0))}

    def programme(self, values: Mapping[str, float]) -> Manoeuvre:
        return Manoeuvre("shake", dict(values), replace(self.model, shaken=values["shaken"]))

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Mapping[str, float]]) -> np.ndarray:
        return np.full(len(sets), manoeuvre.settings.get("shaken", 0.0) / (1.2 * self.model.most))


def twins(truth: float, most: float = 1.0) -> Twins:
    (run,) = toy({"level": 2.0}, 6, extra=truth * SHAPES["sine"]).runs
    return Twins((run,), most=most)


def test_run_that_separates_two_effects_is_asked_for():
    answer = explain(twins(5.0))
    (name,) = answer.effects
    other = "right" if name == "left" else "left"
    assert answer.indistinguishable[name] == (other,)
    asked = answer.next_manoeuvre
    assert asked is not None
    assert asked.reason == f"{name} cannot be distinguished from {other}"
    assert set(asked.separates) == {name, other}
    shaken = asked.manoeuvre.settings["shaken"]
    assert shaken > 0.5
    # Of a saw, what level, slope and the common sine cannot make up for.
    rows = np.stack([SHAPES["level"], SHAPES["slope"], SHAPES["sine"]])
    saw = SHAPES["saw"] - rows.T @ np.linalg.lstsq(rows.T, SHAPES["saw"], rcond=None)[0]
    free = 0.5 * (5.0 * shaken) ** 2 * float(saw @ saw)
    assert 0.5 * free < asked.log_likelihood_ratio <= 1.2 * free


def test_nothing_is_asked_for_within_no_limits():
    answer = explain(twins(5.0, most=0.001))
    assert answer.next_manoeuvre is None
    assert "but no test can be planned: no programme stays within the limits" in answer.remarks[-1]


def test_nothing_is_asked_for_after_a_clean_answer():
    quiet = explain(twins(0.0))
    assert quiet.verdict in ("none", "parameters")
    assert quiet.next_manoeuvre is None


@pytest.mark.parametrize("share", [0.02, 1.0])
def test_explanations_are_weighed_by_what_they_predict(share):
    model = replace(twins(0.0), shaken=share)
    measured = model.runs[0].channels[0].measured + model.twins({"right": 5.0})
    (run,) = model.runs
    channel = replace(run.channels[0], measured=measured)
    answer = explain(replace(model, runs=(replace(run, channels=(channel,)),)))
    weights = {each.effects: each.weight for each in answer.explanations}
    assert sum(weights.values()) == pytest.approx(1.0)
    assert weights[("right",)] > (0.9 if share == 1.0 else 0.3)
    assert answer.explanations[0].effects == answer.effects


FAR = ((SimpleNamespace(name="slope"), 7.0, 4.2),)
SUSPECTED = SimpleNamespace(effect=SimpleNamespace(name="sine"), too_small=True)


@pytest.mark.parametrize(
    ("verdict", "names", "group", "far", "steps", "free_form", "says"),
    [
        ("unknown", (), (), (), (), False, "no known effect explains the gap"),
        ("effect", ("bend",), ("saw",), (), (), False, "bend cannot be distinguished from saw"),
        ("effect_and_unknown", ("bend",), (), (), (), False, "something remains beside the named effects"),
        ("effect", ("bend",), (), (), (), True, "a free form does as well as the named effects"),
        ("parameters", (), (), FAR, (), False,
         "slope is calibrated to 7, 4.2 standard deviations from the model as given"),
        ("parameters", (), (), (), (SUSPECTED,), False, "sine suspected: the evidence is there, but the size is not"),
        ("parameters", (), (), (), (), False, ""),
        ("effect", ("bend",), (), (), (), False, ""),
        ("none", (), (), (), (), False, ""),
    ],
)
def test_every_answer_but_a_clean_one_is_open(monkeypatch, verdict, names, group, far, steps, free_form, says):
    monkeypatch.setattr(next_manoeuvre, "outside_prior", lambda fitted: far)
    state = SimpleNamespace(
        current=SimpleNamespace(names=names), indistinguishable=dict.fromkeys(names, group),
        steps=(SimpleNamespace(candidates=steps),),
    )  # fmt: skip
    assert next_manoeuvre.what_is_open(state, verdict, free_form) == says
