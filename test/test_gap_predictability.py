"""What a model cannot foretell is told apart from what it gets wrong, and claiming too much of it costs."""

from dataclasses import dataclass

import numpy as np
import pytest

from slider_drilling.gap.fit import fit
from slider_drilling.gap.model import Channel, Parameter, Run
from slider_drilling.gap.noise import NoiseFloor
from slider_drilling.gap.predictability import foresee, unpredictable
from slider_drilling.gap.residuals import build_problem

TIME = np.arange(0.0, 60.0, 0.05)
SPINS, THROW = 40.0, 20.0
SIGMA = 0.5
SLOPE = Parameter("slope", 1.0, 0.0, 2.0, 0.1)


@dataclass
class Spinner:
    """A line that is thrown, from SPINS on, by an amount that hangs on the last digits of its slope."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (SLOPE,)
    effects: tuple = ()
    throw: float = THROW

    def simulate(self, run, sets):
        slopes = np.array([values.get("slope", 1.0) for values in sets])[:, None]
        thrown = self.throw * np.sin(1e7 * slopes**2) * (self.runs[run].time >= SPINS)
        return {"height": slopes * self.runs[run].time + thrown}


def problem_of(measured, throw=THROW):
    run = Run("spinner", TIME, np.sin(TIME), (Channel("height", TIME, measured),))
    return build_problem(Spinner((run,), throw=throw), [{"height": NoiseFloor(SIGMA, "declared")}])


def fitted(throw):
    noise = np.random.default_rng(3).normal(0.0, SIGMA, TIME.size)
    problem = problem_of(TIME + noise, throw)
    return problem, fit(problem, problem.free(problem.model.nuisance), {"slope": 1.0})


def test_what_follows_its_parameters_smoothly_is_foretold():
    problem, found = fitted(throw=0.0)
    assert unpredictable(problem, found).max() < 1e-6
    assert foresee(problem, found).price.max() < 1e-9


def test_what_scatters_is_known_by_its_scatter():
    problem, found = fitted(THROW)
    spread = unpredictable(problem, found)
    assert spread[TIME < SPINS - 2.0].max() < 1e-6
    # A sine of a random phase has this standard deviation; eight pairs know it to a third.
    assert np.median(spread[TIME > SPINS + 2.0]) == pytest.approx(THROW / np.sqrt(2.0), rel=0.5)


@pytest.mark.parametrize("claimed", [0.25, 4.0])
def test_claiming_less_or_more_than_the_truth_costs(claimed):
    problem = problem_of(TIME)
    truth = 3.0 * SIGMA
    residual = np.random.default_rng(4).normal(0.0, np.hypot(truth, SIGMA), TIME.size) / SIGMA

    def surprise(spread):
        honest = problem.foretold(np.full(TIME.size, spread))
        return honest.robust_gap(problem.in_floors_of(honest, residual))

    assert surprise(truth) < surprise(claimed * truth)


def test_a_residual_changes_its_floors_and_back():
    problem = problem_of(TIME)
    wide = problem.foretold(np.linspace(0.0, 5.0, TIME.size))
    residual = np.random.default_rng(5).normal(size=TIME.size)
    there = problem.in_floors_of(wide, residual)
    assert np.allclose(there * wide.floor, residual * problem.floor)
    assert np.allclose(wide.in_floors_of(problem, there), residual)
