"""Free-form alternatives: what they explain is their own, and no nuisance passes its bounds beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from toy import TIME, Toy, force, toy

from slider_drilling.gap import Channel, Effect, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.free_forms import fit_free_forms
from slider_drilling.gap.evidence.score import FOLDS, Folds, make_folds, score_held_out
from slider_drilling.gap.model import FreeForm
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection.state import FittedModel


@dataclass(frozen=True)
class Beside(Toy):
    """The toy with a second channel of noise alone, and a level that may not exceed 1."""

    nuisance: tuple[Parameter, ...] = (Parameter("level", 0.0, -1.0, 1.0, 0.3, "N", spread=5.0),)
    effects: tuple[Effect, ...] = ()

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        made = np.stack([force(values) for values in sets])
        return {"force": made, "still": np.zeros_like(made)}


def beside(level: float) -> Beside:
    (run,) = toy({"level": level}, 4).runs
    still = Channel("still", TIME, np.random.default_rng(9).normal(size=TIME.size), "N", declared_noise=1.0)
    return Beside((LoggedRun(run.name, run.time, run.excitation, (*run.channels, still)),))


def calibrated(problem: Problem, iterations: int | None = None) -> tuple[FittedModel, Folds]:
    """The calibrated model, cross-validated, and its folds."""
    found, folds = fit(problem, parameters_of(problem, ()), {}, iterations=iterations), make_folds(problem)
    return FittedModel((), problem, found, score_held_out(problem, found, folds)), folds


def found_at(level: float):
    known, folds = calibrated(build_problem(beside(level), [{"force": 1.0, "still": 1.0}]))
    return known, fit_free_forms(known, folds)


def test_idle_free_form_gains_nothing_at_a_bound():
    known, found = found_at(6.0)
    assert known.fit.values["level"] == 1.0
    idle = [form for form in found if form.description.startswith("still")]
    assert idle
    for form in idle:
        assert form.score.by_channel["force"] > 0.99 * known.score.by_channel["force"]
    best = found[0]
    assert best.description.startswith("force")
    assert best.score.by_channel["force"] < 1.2


def test_nuisance_is_solved_beside_a_free_form():
    known, found = found_at(0.5)
    moved = replace(known, fit=replace(known.fit, values={"level": 0.0}, residual=known.fit.residual + shift(known)))
    idle = [
        form for form in fit_free_forms(moved, make_folds(known.problem)) if form.description.startswith("still")
    ]
    assert all(form.score.by_channel["force"] < 1.05 * known.score.by_channel["force"] for form in idle)
    assert found


def shift(known: FittedModel) -> np.ndarray:
    """What the residual gains when the level goes back to zero."""
    (force_piece,) = [piece for piece in known.problem.pieces if piece.name == "force"]
    change = np.zeros(known.problem.size)
    change[force_piece.rows] = known.fit.values["level"]
    return change


def test_free_form_extrapolates_a_drift():
    """Without its last stretch a curve continues straight."""
    (run,) = toy({}, 4, extra=8.0 * TIME / TIME[-1]).runs
    known, folds = calibrated(build_problem(Beside((run,)), [{"force": 1.0}]))
    best = fit_free_forms(known, folds)[0]
    assert best.description == "force off by an amount that follows time"
    last = folds.fold == folds.fold.max()
    assert float(np.mean(best.score.squares[last])) < 1.5
    slope = np.polyfit(best.x, best.y, 1)[0]
    np.testing.assert_allclose(slope, 8.0 / TIME[-1], rtol=0.15)


def test_linear_solution_equals_refits():
    """In a linear model, to solve without a stretch is to refit without it, and it takes no simulation."""
    (run,) = toy({"level": 0.4}, 4, extra=4.0 * TIME / TIME[-1]).runs
    drift = "force off by an amount that drifts with time"

    def drifting(worth: float) -> tuple[FreeFormFit, int]:
        problem = build_problem(Beside((run,)), [{"force": 1.0}])
        known, folds = calibrated(problem)
        before = problem.counter.count
        (found,) = (form for form in fit_free_forms(known, folds, worth) if form.description == drift)
        return found, problem.counter.count - before

    (refitted, many), (solved, few) = drifting(0.0), drifting(1e6)
    assert refitted.score.gap < 1.1
    np.testing.assert_allclose(solved.score.residual, refitted.score.residual, atol=0.02)
    assert few < many - FOLDS


@dataclass(frozen=True)
class Growing(Toy):
    """A force that grows the faster the larger its level is: a drift bends the level far from where it belongs."""

    nuisance: tuple[Parameter, ...] = (Parameter("level", 0.0, -4.0, 4.0, 0.3, spread=4.0),)
    effects: tuple[Effect, ...] = ()

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([20.0 * np.exp(one.get("level", 0.0) * TIME / TIME[-1]) for one in sets])}


def test_drift_is_fitted_with_the_nuisance():
    """Solved for once, around the bent level, no drift ends the gap."""
    (run,) = toy({}, 4, extra=20.0 * np.exp(0.5 * TIME / TIME[-1]) - 40.0 * TIME / TIME[-1]).runs
    known, folds = calibrated(build_problem(Growing((run,)), [{"force": 1.0}]), iterations=30)
    assert known.fit.values["level"] < -2.0, "it belongs at 0.5"
    by_description = {form.description: form for form in fit_free_forms(known, folds)}
    drift = by_description["force off by an amount that drifts with time"]
    assert drift.score.gap < 1.05
    assert by_description["force off by an amount that follows time"].score.gap > 1.15
    assert drift.y[1] - drift.y[0] < -10.0
    np.testing.assert_allclose(drift.x, TIME[[0, -1]])
    assert drift.sensor_channel == "force"


@dataclass(frozen=True)
class Far(Toy):
    """A toy with a disturbance that does next to nothing until it is far from nominal."""

    effects: tuple[Effect, ...] = ()

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        made = [force(one) + reached(one.get("give", 0.0)) for one in sets]
        return {"force": np.stack(made)}

    def free_forms(self, values: Mapping[str, float]) -> Sequence[FreeForm]:
        give = Parameter("give", 0.0, -0.8, 20.0, 0.2)
        return [FreeForm("contact", "give", (), (0.0,), "-", ({**values, "give": 0.1},), (0.1,), (give,))]

    def sensor_site(self, channel: str) -> str:
        return "sensor"


def reached(give: float) -> np.ndarray:
    return 6.0 * np.exp(-((give - 12.0) ** 2) / 4.0) * np.sin(2.0 * np.pi * TIME / 7.0)


def test_free_form_parameter_is_searched_over_its_range():
    (run,) = toy({"level": 2.0}, 4, extra=reached(12.0)).runs
    known, folds = calibrated(build_problem(Far((run,)), [{"force": 1.0}]))
    assert known.score.gap > 3.0
    best = fit_free_forms(known, folds)[0]
    assert best.description == "give"
    assert best.score.gap < 1.15
    np.testing.assert_allclose(best.y, [12.0], atol=0.2)


BEGINS = (20.0, 60.0, 100.0)


@dataclass(frozen=True)
class Stepped(Toy):
    """A toy whose disturbance is a force that steps: each coefficient is of all that comes after its time."""

    effects: tuple[Effect, ...] = ()
    least: float = -np.inf

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        made = [force(one) + sum(one.get(f"step_{at}", 0.0) * (at <= TIME) for at in BEGINS) for one in sets]
        return {"force": np.stack(made)}

    def free_forms(self, values: Mapping[str, float]) -> Sequence[FreeForm]:
        sets = tuple({**values, f"step_{at}": 0.1} for at in BEGINS)
        after = tuple(tuple(float(at >= start) for start in BEGINS) for at in BEGINS)
        return [FreeForm("contact", "force over time", (), BEGINS, "s", sets, (0.1,) * len(BEGINS), y_unit="N",
                            basis=after, lower_bound=self.least)]  # fmt: skip

    def sensor_site(self, channel: str) -> str:
        return "sensor"


def stepped(size: float, least: float = -np.inf) -> FreeFormFit:
    (run,) = toy({}, 4, extra=size * ((TIME >= 60.0) & (TIME < 100.0))).runs
    known, folds = calibrated(build_problem(Stepped((run,), nuisance=(), least=least), [{"force": 1.0}]))
    (found,) = (form for form in fit_free_forms(known, folds) if form.description == "force over time")
    return found


def test_basis_turns_coefficients_into_a_curve():
    """A force that acts for a while: its coefficients are one step up and one down."""
    found = stepped(5.0)
    np.testing.assert_allclose(found.y, [0.0, 5.0, 0.0], atol=0.7)
    assert found.y_unit == "N"


def test_free_form_respects_its_lower_bound():
    """Friction below zero would push."""
    np.testing.assert_allclose(stepped(-5.0).y[1], -5.0, atol=0.7)
    bounded = stepped(-5.0, least=-1.0)
    assert bounded.y.min() >= -1.0
