"""Refits without a stretch: what the rest of the log tells is refitted, how the run began is not."""

from dataclasses import dataclass

import numpy as np
import pytest

from slider_drilling.gap.fit import fit
from slider_drilling.gap.held_out import FOLDS, fold_steps, held_out, make_folds
from slider_drilling.gap.model import Channel, Parameter, Run
from slider_drilling.gap.noise import NoiseFloor
from slider_drilling.gap.residuals import build_problem

TIME = np.arange(0.0, 120.0, 0.1)
START = Parameter("start", 0.0, -100.0, 100.0, 1.0, per_run=True)
SLOPE = Parameter("slope", 0.0, -5.0, 5.0, 0.1)


@dataclass
class Settling:
    """A line, and a start that is forgotten within the first fold."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (START, SLOPE)
    effects: tuple = ()

    def simulate(self, run, sets):
        time = self.runs[run].time
        rows = [v.get("start", 0.0) * np.exp(-time / 2.0) + v.get("slope", 0.0) * time for v in sets]
        return {"height": np.stack(rows)}


@pytest.fixture
def settled():
    noise = np.random.default_rng(6).normal(0.0, 1.0, TIME.size)
    measured = 40.0 * np.exp(-TIME / 2.0) + 0.5 * TIME + noise
    run = Run("run", TIME, np.sin(TIME), (Channel("height", TIME, measured),))
    problem = build_problem(Settling((run,)), [{"height": NoiseFloor(1.0, "declared")}])
    return problem, fit(problem, problem.free(problem.model.nuisance), {})


def test_the_start_stays_and_the_slope_is_refitted(settled):
    problem, found = settled
    steps = fold_steps(problem, found, make_folds(problem))
    names = [parameter.name for parameter in found.parameters]
    assert np.all(steps[:, names.index("start@0")] == 0.0)
    assert np.all(steps[:, names.index("slope")] != 0.0)


def test_a_step_is_the_fit_without_its_fold(settled):
    problem, found = settled
    folds = make_folds(problem)
    steps = fold_steps(problem, found, folds)
    start = found.values["start@0"] * np.exp(-TIME / 2.0)
    measured = problem.model.runs[0].channels[0].measured - start
    for fold in range(FOLDS):
        kept = folds.of != fold
        alone = measured[kept] @ TIME[kept] / (TIME[kept] @ TIME[kept])
        refitted = found.values["slope"] + SLOPE.scale * steps[fold, 1]
        assert refitted == pytest.approx(alone, abs=2e-4)


def test_a_forgotten_start_is_not_held_against_the_fit(settled):
    problem, found = settled
    residual, _ = held_out(problem, found, make_folds(problem))
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(1.0, abs=0.1)
