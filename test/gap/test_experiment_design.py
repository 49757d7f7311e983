"""Optimal design of runs: what a run would tell, the smallest size that shows, and the search for the best run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy.stats import ncx2
from toy import EFFECTS, SHAPES, TIME, Toy, force, toy

from slider_drilling.gap import Channel, LoggedRun, Manoeuvre, Parameter, SimulationOptions, explain
from slider_drilling.gap.experiment_design.criterion import planned_information, prospect
from slider_drilling.gap.experiment_design.detectable_size import (
    POWER,
    ProbedShape,
    detectable_size,
    evidence_needed,
    noncentrality_needed,
    probed_shapes,
)
from slider_drilling.gap.experiment_design.information import (
    Change,
    ChannelInformation,
    Information,
    run_information,
)
from slider_drilling.gap.experiment_design.knowledge import Explanation, after_fit, before_any_log
from slider_drilling.gap.experiment_design.plan import plan_run
from slider_drilling.gap.experiment_design.search import minimise
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.selection.evidence_tests import MIN_GAP

FREE = ("level", "slope")


def beyond(name: str, rows: Sequence[str]) -> float:
    """Squared length of a shape outside the span of others."""
    basis = np.stack([SHAPES[row] for row in rows]).T
    rest = SHAPES[name] - basis @ np.linalg.lstsq(basis, SHAPES[name], rcond=None)[0]
    return float(rest @ rest)


def information(model: Toy, names: Sequence[str] = ("bend",), run: str = "1"):
    problem = build_problem(model, [{"force": 1.0}])
    free = tuple(replace(parameter, spread=np.inf) for parameter in model.nuisance)
    return run_information(problem, {}, free, [Change(name, {name: 1.0}) for name in names], run)


def test_schur_complement_is_what_calibration_cannot_follow():
    schur, power = information(toy({}, 1), ("bend", "sine")).beyond_free()
    assert np.diag(schur) == pytest.approx([beyond("bend", FREE), beyond("sine", FREE)], rel=1e-6)
    assert power["force"] == pytest.approx(np.diag(schur), rel=1e-6)


def test_information_of_two_runs_adds_up():
    one = information(toy({}, 1))
    both = one + information(toy({}, 2), run="2")
    assert both.beyond_free()[0] == pytest.approx(2.0 * one.beyond_free()[0], rel=1e-6)


def test_model_error_hides_what_it_could_make():
    model = toy({}, 1)
    (run,) = model.runs
    channel = replace(run.channels[0], model_error=0.1)
    problem = build_problem(replace(model, runs=(replace(run, channels=(channel,)),)), [{"force": 1.0}])
    changes = [Change("sine", {"sine": 31.0})]
    still, moved = (
        run_information(problem, {"sine": size}, model.nuisance, changes, "1").beyond_free()[0][0, 0]
        for size in (0.0, 30.0)
    )
    assert moved * 31.0**2 < 0.5 * still


def test_power_is_reached_at_the_needed_noncentrality():
    needed = noncentrality_needed(2, 17)
    assert ncx2.sf(evidence_needed(2, 17), 2, needed) == pytest.approx(POWER, abs=1e-6)


def test_power_at_the_size_that_just_makes_a_gap_is_neither_none_nor_certain():
    (bend,) = [effect for effect in EFFECTS if effect.name == "bend"]
    shape = ProbedShape(bend, ((1.0,), (2.0,)))
    samples, squares = 400, np.array([1.0, 4.0])
    force_channel = ChannelInformation(np.zeros((1, 1)), samples, 0.0)
    known = Information(("bend",), 0, np.zeros((1, 1)), {"force": force_channel}, np.zeros(0))
    powers = []
    for gap in (0.3, 0.9, 1.0, 1.1, 2.0):
        left = {"force": max(MIN_GAP, 3.0 * np.sqrt(2.0 / samples)) * gap * samples * squares}
        powers.append(detectable_size(shape, 1e3 * squares, left, known, 1, 0.0).power)
    assert powers == sorted(powers)
    assert powers[0] < 0.05 and powers[2] == pytest.approx(0.5, abs=0.01) and powers[-1] > 0.95


def test_detectable_size_is_mostly_named():
    model = toy({}, 1)
    knowledge = before_any_log(model, EFFECTS)
    shapes = knowledge.shapes()
    information = planned_information(knowledge, Manoeuvre("again", {}, model), shapes)
    sizes = {each.name: each.size for each in prospect(knowledge, information, shapes).effects}
    size = sizes["bend"].amplitude
    named = [explain(toy({"bend": size, "level": 1.0}, seed)).effects == ("bend",) for seed in range(8)]
    assert sum(named) >= 6
    assert not any(explain(toy({"bend": 0.3 * size}, seed)).effects for seed in range(2))


@dataclass(frozen=True)
class Knobs(Toy):
    """A toy of which a run may shake more or less, and louder than allowed."""

    shaken: float = 0.1

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([self.shaken * force(values) for values in sets])}


@dataclass(frozen=True)
class KnobProgrammes:
    model: Knobs
    variables: tuple[Parameter, ...] = (Parameter("shake", 0.1, 0.1, 4.0, 0.1),)
    starts: tuple[Mapping[str, float], ...] = ({"shake": 0.1},)
    loudest: float = 2.0
    tried: list[float] = field(default_factory=list)

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        return {"routine": self.programme({"shake": 0.1})}

    def programme(self, values: Mapping[str, float]) -> Manoeuvre:
        self.tried.append(values["shake"])
        return Manoeuvre("shake", dict(values), replace(self.model, shaken=values["shake"]))

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Mapping[str, float]]) -> np.ndarray:
        return np.full(len(sets), manoeuvre.settings["shake"] / self.loudest)


def knobs() -> Knobs:
    channel = Channel("force", TIME, np.zeros_like(TIME), "N", declared_noise=1.0)
    return Knobs((LoggedRun("none", TIME, SHAPES["sine"], (channel,)),))


def test_plan_shakes_as_much_as_the_limits_allow():
    model = knobs()
    plan = plan_run(before_any_log(model), KnobProgrammes(model), evaluations=60)
    assert 1.6 < plan.planned.manoeuvre.settings["shake"] <= 1.8
    assert plan.planned.limit_use <= 0.9
    least, routine = plan.planned.prospect.least(), plan.baseline.least()
    assert least is not None and routine is not None
    assert least.ratio < 0.2 * routine.ratio


def test_plan_without_allowed_programme_is_refused():
    model = knobs()
    with pytest.raises(ValueError, match="no programme stays within the limits"):
        plan_run(before_any_log(model), KnobProgrammes(model, loudest=0.05), evaluations=10)


def test_same_seed_gives_the_same_point():
    variables = tuple(Parameter(name, 0.0, -1.0, 1.0, 0.1) for name in "abc")

    def loss(values: Mapping[str, float]) -> float:
        return sum((value - 0.5) ** 2 for value in values.values())

    first, again = (minimise(loss, variables, [{}], 120, seed=3) for _ in range(2))
    assert first == again
    assert first.loss < 0.02


def test_both_signs_of_an_amplitude_count_once():
    (shape,) = probed_shapes(EFFECTS[0])
    assert [shape.distance(point) for point in shape.points] == [1.0, 2.0, 3.0]


@dataclass(frozen=True)
class QuietKnobs(KnobProgrammes):
    """Programmes that may shake a little only, beside a fixed one that shakes more."""

    variables: tuple[Parameter, ...] = (Parameter("shake", 0.1, 0.1, 0.2, 0.05),)

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        return {name: self.programme({"shake": shake}) for name, shake in (("routine", 0.1), ("known", 1.0))}


def test_plan_is_never_worse_than_fixed():
    model = knobs()
    plan = plan_run(before_any_log(model), QuietKnobs(model), evaluations=8)
    assert plan.planned.manoeuvre.settings["shake"] == 1.0
    loud = plan_run(before_any_log(model), QuietKnobs(model, loudest=0.5), evaluations=8)
    assert loud.planned.manoeuvre.settings["shake"] <= 0.2


def test_what_a_fit_leaves_is_model_error():
    """Something that no effect explains: the plan after it promises less."""
    plain, odd = toy({"slope": 30.0}, 1), toy({"slope": 30.0}, 1)
    (run,) = odd.runs
    channel = run.channels[0]
    strange = 8.0 * np.sign(np.sin(0.4 * channel.time))
    odd = replace(odd, runs=(replace(run, channels=(replace(channel, measured=channel.measured + strange),)),))
    sizes = []
    for model in (plain, odd):
        knowledge = after_fit(model, [Explanation((), 1.0, {})])
        shapes = knowledge.shapes()
        information = planned_information(knowledge, Manoeuvre("again", {}, plain), shapes)
        found = {each.name: each.size.amplitude for each in prospect(knowledge, information, shapes).effects}
        sizes.append(found["bend"])
    assert sizes[1] > 1.5 * sizes[0]
