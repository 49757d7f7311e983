"""Parameters of a model that is used without feedback: a swing whose phase is lost unless the horizon grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.gap import Channel, Effect, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.free_run import FreeRunModels, _keeps_its_phase, best_free_runs
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection.refit import cross_validate

TIME = np.arange(400.0) * 0.1
RATE = Parameter("rate", 1.0, 0.5, 3.0, 0.02, "rad/s", spread=0.3)
SWING = Effect("swing", "string", (Parameter("swing.size", 0.0, 0.0, 9.0, 0.2, "N"),), scan=((1.0,), (3.0,), (6.0,)))


@dataclass(frozen=True)
class Swing:
    """size sin(rate t): with a wrong rate the error over the whole run has many local minima."""

    runs: tuple[LoggedRun, ...]
    nuisance: tuple[Parameter, ...] = (RATE,)
    effects: tuple[Effect, ...] = (SWING,)
    observed_channel: str = "torque"

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        time = self.runs[run].time
        free = [values.get("swing.size", 0.0) * np.sin(values.get("rate", 1.0) * time) for values in sets]
        fed = options.observer_gain * self.runs[run].channels[0].measured
        return {"torque": (np.array(free) + fed) / (1.0 + options.observer_gain)}

    def with_measured(self, run: int, measured: np.ndarray):
        return self

    def noise_shrinkage(self, run: int, gain: float) -> float:
        return 1.0 + gain

    def truncated(self, fraction: float):
        inside = fraction * TIME[-1] >= TIME
        run, (channel,) = self.runs[0], self.runs[0].channels
        part = replace(channel, time=TIME[inside], measured=channel.measured[inside])
        cut = replace(run, time=TIME[inside], excitation=run.excitation[inside], channels=(part,))
        return replace(self, runs=(cut,))


def searched(
    gain: float, effects: tuple[Effect, ...] = (SWING,), rate: float = 1.0, size: float = 0.5,
    nuisance: tuple[Parameter, ...] = (RATE,), interrupted: bool = False,
):  # fmt: skip
    """What a search knows that ended at a rate and a size, scored with feedback of this gain. True are 1.7 and 5."""
    measured = 5.0 * np.sin(1.7 * TIME) + np.random.default_rng(1).normal(0.0, 0.1, TIME.size)
    run = LoggedRun("swing", TIME, np.sin(TIME), (Channel("torque", TIME, measured, "N"),))
    model = Swing((run,), nuisance)
    problem = build_problem(model, [{"torque": 0.1}], SimulationOptions(0, gain))

    def fitted(named):
        values = {"rate": rate} | ({"swing.size": size} if named or nuisance != (RATE,) else {})
        parameters = parameters_of(problem, named)
        return cross_validate(problem, fit(problem, parameters, values, iterations=0), named, make_folds(problem))

    free = problem.with_options(SimulationOptions())
    floors = [{"torque": NoiseFloor(0.1, "declared", 0.1, None)}]
    return SimpleNamespace(
        calibrated=fitted(()), current=fitted(effects), modes=(free, problem), floors=floors,
        interrupted=interrupted,
    )


def test_growing_horizon_finds_the_phase():
    models = best_free_runs(searched(0.3))
    values = models.best.fit.values
    assert models.refitted
    assert abs(values["rate"] - 1.7) < 0.01
    assert abs(values["swing.size"] - 5.0) < 0.1
    assert models.gaps[2] < 1.2 and models.gaps[2] < models.gaps[1] <= models.gaps[0]


def test_models_scored_in_free_runs_are_kept():
    state = searched(0.0)
    models = best_free_runs(state)
    assert models.calibrated is state.calibrated and models.final is state.current and not models.refitted


def test_worse_free_run_is_not_written():
    state = searched(0.0, rate=2.6, size=5.0)
    models = best_free_runs(state)
    assert models.gaps[2] > models.gaps[1]
    assert models.best is models.calibrated
    better = FreeRunModels(models.calibrated, models.final, (3.0, 2.0, 1.0), False)
    assert better.best is models.final


def test_interrupted_search_writes_no_worse_free_run_than_as_given():
    """What was scored with feedback may be worse in a free run than the model as given."""
    state = searched(0.3, (), 2.6, 5.0, (RATE, *SWING.parameters), interrupted=True)
    models = best_free_runs(state)
    assert models.best.fit.values == {"rate": 1.0, "swing.size": 0.0}
    assert models.gaps[2] == models.gaps[1] == models.gaps[0] and not models.refitted


@pytest.mark.parametrize(("final", "enough"), [(2.97, False), (1.0, True)])
def test_effects_must_better_a_free_run(final, enough):
    models = FreeRunModels(SimpleNamespace(), SimpleNamespace(), (3.0, 3.0, final), True)
    assert models.effects_close_enough == enough
    assert models.without_effects.gaps == (3.0, 3.0, 3.0)


@pytest.mark.parametrize(("accumulates", "lost"), [(True, False), (False, True)])
def test_step_missed_by_what_accumulates_is_no_lost_phase(accumulates, lost):
    angle = Channel("angle", TIME, np.random.default_rng(2).normal(0.0, 0.1, TIME.size), "rad", accumulates=accumulates)

    class SwingAndAngle(Swing):
        def simulate(self, run, sets, options):
            simulated = super().simulate(run, sets, options)
            return {**simulated, "angle": np.tile(6.0 * (TIME > 20.0), (len(sets), 1))}

    torque = Channel("torque", TIME, 5.0 * np.sin(1.7 * TIME), "N")
    model = SwingAndAngle((LoggedRun("swing", TIME, np.sin(TIME), (torque, angle)),))
    problem = build_problem(model, [{"torque": 0.1, "angle": 0.1}], SimulationOptions())
    assert _keeps_its_phase(problem, {"rate": 1.7, "swing.size": 5.0}) is not lost
