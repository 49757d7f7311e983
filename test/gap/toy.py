"""A linear model for the engine: shapes over time, added up. Everything about it is known in closed form."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap import Channel, Effect, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import parameters_of

TIME = np.arange(240.0) * 0.5
SHAPES = {
    "level": np.ones_like(TIME),
    "slope": TIME / 60.0 - 1.0,
    "sine": np.sin(2.0 * np.pi * TIME / 12.0),
    "bend": (TIME / 60.0 - 1.0) ** 2 - 1.0 / 3.0,
    "step": np.where(TIME > 60.0, 1.0, 0.0),
    "saw": (TIME % 9.0) / 9.0 - 0.5,
}
NUISANCE = tuple(Parameter(name, 0.0, -50.0, 50.0, 0.3, "N", spread=5.0) for name in ("level", "slope"))
EFFECTS = tuple(
    Effect(name, "sensor" if name == "step" else "contact", (Parameter(name, 0.0, -50.0, 50.0, 0.3, "N"),),
           scan=((-2.0,), (1.0,), (3.0,)))
    for name in ("sine", "bend", "step", "saw")
)  # fmt: skip


@dataclass(frozen=True)
class Toy:
    runs: tuple[LoggedRun, ...]
    nuisance: tuple[Parameter, ...] = NUISANCE
    effects: tuple[Effect, ...] = EFFECTS

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([force(values) for values in sets])}


def force(values: Mapping[str, float]) -> np.ndarray:
    return sum((values.get(name, 0.0) * shape for name, shape in SHAPES.items()), np.zeros_like(TIME))


def toy(truth: Mapping[str, float], seed: int, noise: float = 1.0, extra: np.ndarray | float = 0.0) -> Toy:
    """A log of the toy with white noise, and with something extra that no shape has."""
    measured = force(truth) + extra + np.random.default_rng(seed).normal(0.0, noise, TIME.size)
    channel = Channel("force", TIME, measured, "N", declared_noise=noise)
    return Toy((LoggedRun("toy", TIME, np.sin(2.0 * np.pi * TIME / 12.0), (channel,)),))


def fit_toy(model: Toy, names: Collection[str]) -> tuple[Problem, Fit]:
    """A toy's nuisance fitted with the effects of these names, and its problem."""
    problem = build_problem(model, [{"force": 1.0}])
    effects = [effect for effect in EFFECTS if effect.name in names]
    return problem, fit(problem, parameters_of(problem, effects), {})
