"""Fits whose Jacobian is updated by steps: exact in a linear model, as good and cheaper in a nonlinear one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from toy import TIME, Toy, fit_toy, toy

from slider_drilling.gap import Parameter, SimulationOptions
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search import least_squares
from slider_drilling.gap.search.least_squares import (
    KnownStart,
    bounded_step,
    broyden_update,
    fit,
    linearised_at_its_end,
)

PARAMETERS = (Parameter("size", 1.0, 0.1, 9.0, 0.1), Parameter("fall", 1.0, 0.1, 9.0, 0.1),
              Parameter("level", 0.0, -9.0, 9.0, 0.1))  # fmt: skip


@dataclass(frozen=True)
class Bent(Toy):
    """An exponential: nothing about it is linear but its level."""

    nuisance: tuple[Parameter, ...] = PARAMETERS

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([bent(**{p.name: values.get(p.name, p.nominal) for p in PARAMETERS})
                                   for values in sets])}  # fmt: skip


def bent(size: float, fall: float, level: float) -> np.ndarray:
    return 40.0 * size * np.exp(-fall * TIME / 30.0) + level


@dataclass(frozen=True)
class Failing(Bent):
    """It cannot be simulated from a size on."""

    limit: float = np.inf

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        known = np.array([values.get("size", 1.0) < self.limit for values in sets])
        return {"force": np.where(known[:, None], super().simulate(run, sets, options)["force"], np.nan)}


def problem_of(truth: Mapping[str, float], seed: int):
    model = toy({}, seed, extra=bent(**truth))
    return build_problem(Bent(model.runs), [{"force": 1.0}])


def test_broyden_update_changes_only_along_the_step():
    generator = np.random.default_rng(1)
    jacobian, step, change = generator.normal(size=(3, 20)), generator.normal(size=3), generator.normal(size=20)
    after, _ = broyden_update(jacobian, step, change)
    across = np.cross(step, generator.normal(size=3))
    assert step @ after == pytest.approx(change)
    assert across @ after == pytest.approx(across @ jacobian)


def test_linear_step_is_predicted_fully():
    jacobian, step = np.random.default_rng(2).normal(size=(3, 20)), np.array([0.3, -1.0, 2.0])
    after, predicted = broyden_update(jacobian, step, step @ jacobian)
    assert predicted == pytest.approx(1.0)
    assert after == pytest.approx(jacobian)


def test_linearised_fit_has_the_slopes_of_its_end():
    problem = problem_of({"size": 2.0, "fall": 2.5, "level": 1.0}, 3)
    found = fit(problem, PARAMETERS, {"size": 0.4, "fall": 0.3, "level": 0.0})
    there = fit(problem, PARAMETERS, found.values, iterations=0).jacobian
    assert np.max(np.abs(found.jacobian - there)) > 0.05 * np.max(np.abs(there))
    known = linearised_at_its_end(problem, found)
    assert known.jacobian == pytest.approx(there) and not known.jacobian_stale
    assert (known.values, known.cost, known.converged) == (found.values, found.cost, found.converged)


@pytest.mark.parametrize("seed", range(4))
def test_updated_jacobian_fits_as_well_as_new_ones(seed, monkeypatch):
    truth = {"size": 2.0, "fall": 2.5, "level": 1.0}
    ends = []
    carried = least_squares.broyden_update
    for anew in (False, True):
        if anew:
            monkeypatch.setattr(least_squares, "broyden_update", lambda *seen: (carried(*seen)[0], 0.0))
        ends.append(fit(problem_of(truth, seed), PARAMETERS, {}, iterations=20, tolerance=1e-3))
    assert ends[0].cost == pytest.approx(ends[1].cost, abs=0.05)
    assert [ends[0].values[p.name] for p in PARAMETERS] == pytest.approx(list(truth.values()), abs=0.3)


def test_continued_fit_simulates_nothing_again():
    problem = problem_of({"size": 2.0, "fall": 2.5, "level": 1.0}, 1)
    first = fit(problem, PARAMETERS, {}, iterations=2)
    before = problem.counter.count
    known = KnownStart(first.simulated, first.reusable_rows)
    continued = fit(problem, PARAMETERS, first.values, iterations=1, known=known)
    with_it = problem.counter.count - before
    anew = fit(problem, PARAMETERS, first.values, iterations=1)
    assert problem.counter.count - before - with_it > with_it
    assert continued.cost <= first.cost and anew.cost <= first.cost


def test_linear_fit_is_least_squares():
    model = toy({"level": 2.0, "slope": -1.0, "saw": 3.0}, 4)
    problem, found = fit_toy(model, ["saw"])
    columns = np.column_stack([problem.simulate([{name: 1.0}])[0] for name in ("level", "slope", "saw")])
    weight = np.diag([1.0 / 5.0**2, 1.0 / 5.0**2, 0.0])
    measured = model.runs[0].channels[0].measured
    exact = np.linalg.solve(columns.T @ columns + weight, columns.T @ measured)
    assert [found.values[name] for name in ("level", "slope", "saw")] == pytest.approx(exact, abs=0.02)


@pytest.mark.parametrize("width", [0.01, 0.3, 100.0])
def test_step_is_the_least_within_its_bounds(width):
    """Where the free step lies within them, and where it does not."""
    random = np.random.default_rng(3)
    for _ in range(20):
        slopes, gradient = random.normal(size=(6, 3)), random.normal(size=3)
        low, high = -width * random.random(3), width * random.random(3)
        normal = slopes.T @ slopes
        ridge = np.diag(0.1 * np.diag(normal))
        factor = np.linalg.cholesky(normal + ridge)
        least = lsq_linear(factor.T, np.linalg.solve(factor, gradient), (low, high), method="bvls").x
        assert bounded_step(normal, gradient, 0.1, low, high) == pytest.approx(least, abs=1e-6)


def failing_problem(limit: float):
    return build_problem(Failing(toy({}, 1, extra=bent(1.0, 1.0, 0.0)).runs, limit=limit), [{"force": 1.0}])


def test_fit_from_where_nothing_can_be_simulated_ends_there():
    found = fit(failing_problem(2.0), PARAMETERS, {"size": 3.0})
    assert found.cost == np.inf and not found.converged and found.values["size"] == 3.0


def test_parameter_whose_step_cannot_be_simulated_stays():
    found = fit(failing_problem(1.01), PARAMETERS, {"size": 1.0, "level": 3.0}, iterations=1)
    assert found.values["size"] == pytest.approx(1.0, abs=1e-6)
    assert abs(found.values["level"]) < 1.0
