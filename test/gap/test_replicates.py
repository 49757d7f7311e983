"""Replicates: what a model can predict of itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, NUISANCE, TIME, Toy, force, toy

from slider_drilling.gap import Channel, SimulationOptions, explain
from slider_drilling.gap.evidence.replicates import replicate_noise_factors
from slider_drilling.gap.evidence.score import make_folds, score_residual
from slider_drilling.gap.problem.noise import noise_floors
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection import refit
from slider_drilling.gap.selection.calibration import calibrate

READINGS = TIME[9::20]


@dataclass(frozen=True)
class Turning(Toy):
    """The toy with an angle that is read seldom and that a parameter turns: by a little, or by jumps without end."""

    jump: float = 0.0

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        found = {"force": np.stack([force(values) for values in sets])}
        angles = [self.jump * np.sin(1e4 * values.get("level", 0.0)) * (READINGS > 40.0) for values in sets]
        return found | {"angle": np.stack(angles)}


def turning(jump: float, seed: int = 3) -> Turning:
    plain = toy({"level": 1.0}, seed)
    noise = np.random.default_rng(seed).normal(0.0, 1.0, READINGS.size)
    angle = Channel("angle", READINGS, jump * np.sin(1e4) * (READINGS > 40.0) + noise, "rad", None, 1.0, 0.0, True)
    (run,) = plain.runs
    return Turning((replace(run, channels=(*run.channels, angle)),), jump=jump)


def factor(jump: float) -> float:
    problem = build_problem(turning(jump), [{"force": 1.0, "angle": 1.0}])
    found = fit(problem, parameters_of(problem, ()), {"level": 1.0})
    ((index, own),) = replicate_noise_factors(problem, found, seed=1).items()
    assert problem.pieces[index].name == "angle"
    return own


def test_noise_factor_grows_with_unpredictability():
    calm, wild, wilder = factor(0.0), factor(30.0), factor(300.0)
    assert 1.0 <= calm < 1.5
    assert 1.5 < wild < wilder


def test_only_the_unpredictable_channel_gets_higher_floor():
    floors = calibrated_state(turning(300.0)).floors
    assert floors[0]["angle"].method == "replicates" and floors[0]["angle"].sigma > 3.0
    assert floors[0]["force"].sigma == pytest.approx(1.0, rel=0.2)


def calibrated_state(model):
    floors = noise_floors(model.runs)
    return calibrate(model, EFFECTS, floors, [{}], 0, lambda stage, share: None)


def threshold_of(model) -> float:
    problem = build_problem(model, [{"force": 1.0}])
    found = fit(problem, parameters_of(problem, ()), {})
    return refit.check_adequacy(
        refit.finish_and_cross_validate(problem, (), found, make_folds(problem)), seed=0
    ).threshold


def test_wrong_model_does_not_widen_the_threshold():
    # A discrepancy leaves open what the truth, with noise alone, would tell: that is not what noise leaves.
    loose = tuple(replace(parameter, scale=30.0) for parameter in NUISANCE)
    right, wrong = (
        threshold_of(replace(toy({"level": 1.0}, 3, extra=extra), nuisance=loose))
        for extra in (0.0, 30.0 * np.sin(TIME / 6.0))
    )
    assert wrong < 1.1 * right < 1.7


@dataclass(frozen=True)
class Forked(Toy):
    """The toy that goes one way or the other, and next to nothing of its level decides."""

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        ways = [np.sign(np.sin(1e4 * values.get("level", 0.0))) for values in sets]
        rows = [force(values) + 50.0 * way * (TIME > 60.0) for values, way in zip(sets, ways, strict=True)]
        return {"force": np.stack(rows)}


def test_calibration_removes_branching_from_the_threshold():
    model = Forked(toy({"level": 1.0}, 3, extra=50.0 * np.sign(np.sin(1e4)) * (TIME > 60.0)).runs)
    assert threshold_of(model) < 1.5


def test_sparse_channel_weighs_by_its_samples():
    problem = build_problem(turning(0.0), [{"force": 1.0, "angle": 1.0}])
    found = fit(problem, parameters_of(problem, ()), {"level": 1.0})
    residual = np.zeros(problem.size)
    residual[problem.pieces[1].rows] = 3.0
    score = score_residual(problem, residual, found)
    mean = score.by_channel["angle"] ** 2 * READINGS.size / problem.size
    assert score.by_channel["angle"] > 1.0
    assert score.gap**2 == pytest.approx(mean)


@dataclass(frozen=True)
class Coarse(Toy):
    """The toy whose cheap simulation shows the saw turned over; the next two show it as it is."""

    max_fidelity: int = 2

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        sign = -1.0 if options.fidelity == 0 else 1.0
        rows = [force({**values, "saw": sign * values.get("saw", 0.0)}) for values in sets]
        return {"force": np.stack(rows)}


def test_effect_is_raced_at_its_own_fidelity():
    effects = tuple(
        replace(effect, fidelity=1, physical=(0.0, np.inf)) if effect.name == "saw" else effect for effect in EFFECTS
    )
    model = Coarse(toy({"level": 1.0, "saw": 4.0}, 5).runs, effects=effects)
    answer = explain(model)
    assert answer.effects == ("saw",)
    assert answer.parameters["saw"] == pytest.approx(4.0, abs=0.6)


def test_every_simulation_is_counted():
    model = toy({"level": 1.0, "saw": 4.0}, 5)
    asked = []

    @dataclass(frozen=True)
    class Counted(Toy):
        def simulate(self, run, sets, options):
            asked.append(len(sets))
            return Toy.simulate(self, run, sets, options)

    answer = explain(Counted(model.runs))
    during = answer.state.current.problem.counter.count
    assert during > 100 and during == sum(asked)
