"""The screen: predicted gains and the starts of fits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from toy import EFFECTS, toy

from slider_drilling.gap import Channel, Effect, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import rank_starts, scan_effects, screen

TIME = np.arange(600.0) * 0.1
SWING = 4.0 * np.sin(2.0 * np.pi * TIME / 15.0)
WIDTHS = tuple((0.1 * 2.0 ** (0.5 * k),) for k in range(12))
PLAY = Effect("play", "drive", (Parameter("play.width", 0.0, 0.0, 6.3, 0.05, "rad"),), scan=WIDTHS)
BIASES = ((0.02,), (-0.02,), (0.06,))
BIAS = Effect("bias", "sensor", (Parameter("bias.torque", 0.0, -9.0, 9.0, 0.02, "N m"),), scan=BIASES)


@dataclass(frozen=True)
class Spring:
    """A spring that is turned through a dead zone: what it shows at one width is no multiple of another's."""

    runs: tuple[LoggedRun, ...]
    nuisance: tuple[Parameter, ...] = (Parameter("stiffness", 1.0, 0.2, 5.0, 0.05, spread=0.1),)
    effects: tuple[Effect, ...] = (PLAY, BIAS)

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"torque": np.stack([torque(values) for values in sets])}


def torque(values: Mapping[str, float]) -> np.ndarray:
    half = 0.5 * values.get("play.width", 0.0)
    free = SWING - np.clip(SWING, -half, half)
    return values.get("stiffness", 1.0) * free + values.get("bias.torque", 0.0)


def calibrated(truth: Mapping[str, float]) -> tuple[Problem, Fit]:
    """The problem of a log of this spring, and its calibration."""
    measured = torque(truth) + np.random.default_rng(1).normal(0.0, 0.02, TIME.size)
    model = Spring(
        (LoggedRun("spring", TIME, SWING, (Channel("torque", TIME, measured, "N m", declared_noise=0.02),)),)
    )
    problem = build_problem(model, [{"torque": 0.02}])
    return problem, fit(problem, problem.expand_per_run(model.nuisance), {})


def test_start_lies_between_neighbouring_scan_points():
    problem, base = calibrated({"play.width": 3.0, "stiffness": 1.1})
    (candidate,) = screen(scan_effects(problem, base, [PLAY]))
    widths = np.sort([start["play.width"] for start in candidate.starts])
    points = np.array([point[0] for point in WIDTHS])
    assert np.all(widths[1:-1] >= points[:-2] - 1e-6)
    assert np.all(widths[1:-1] <= points[2:] + 1e-6)
    assert np.any(np.abs(widths - 3.0) < 0.8)


@pytest.mark.parametrize("width", [0.5, 1.5, 3.0])
def test_starts_are_ranked_by_their_cost(width):
    problem, base = calibrated({"play.width": width, "stiffness": 1.1})
    scan = scan_effects(problem, base, [PLAY])
    (candidate,) = screen(scan)
    ordered = rank_starts(scan, candidate)
    freed = problem.expand_per_run((*problem.model.nuisance, *PLAY.parameters))
    costs = [fit(problem, freed, start, iterations=0).cost for start, _ in ordered]
    assert costs == sorted(costs)
    for start, simulated in ordered:
        np.testing.assert_allclose(simulated * 0.02, torque(start), atol=1e-9)
    found = fit(problem, freed, ordered[0][0])
    assert found.values["play.width"] == pytest.approx(width, abs=0.02)


def test_linear_effect_is_found_beyond_its_scan():
    problem, base = calibrated({"bias.torque": 0.2})
    (candidate,) = screen(scan_effects(problem, base, [BIAS]))
    assert candidate.starts[0]["bias.torque"] == pytest.approx(0.2, abs=0.01)


def test_screen_predicts_gain_of_a_linear_effect():
    model = toy({"level": 1.0, "saw": 3.0}, 8)
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, parameters_of(problem, ()), {})
    first = screen(scan_effects(problem, base, EFFECTS))[0]
    found = fit(problem, parameters_of(problem, [first.effect]), first.starts[0])
    assert first.effect.name == "saw"
    assert base.cost - found.cost == pytest.approx(first.predicted_gain, rel=0.05)


def test_point_that_cannot_be_simulated_shows_nothing(monkeypatch):
    problem, base = calibrated({"play.width": 1.0, "stiffness": 1.1})
    simulate, widest = Spring.simulate, max(point[0] for point in PLAY.scan)

    def failing(self, run, sets, options):
        rows = simulate(self, run, sets, options)["torque"]
        known = np.array([values.get("play.width", 0.0) < widest for values in sets])
        return {"torque": np.where(known[:, None], rows, np.nan)}

    monkeypatch.setattr(Spring, "simulate", failing)
    scan = scan_effects(problem, base, [PLAY])
    assert [point for row, (_, point) in zip(scan.changes, scan.points, strict=True) if not row.any()] == [(widest,)]
    (candidate,) = screen(scan)
    assert candidate.predicted_gain > 0.0 and abs(candidate.starts[0]["play.width"] - 1.0) < 0.5
