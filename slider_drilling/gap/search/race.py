"""The race between explanations: every effect starts from several places, and whoever falls behind is not followed.

An arm is a set of effects, a place to begin, and a way to run the model (free, or weakly pulled). All are scored by the
same likelihood, so arms that run in different ways compete: a pulled run is a prediction from the torque measured
so far, a free run one from the commands alone, and which of the two foretells more is for the log to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.compiler import threads
from slider_drilling.gap.model import Effect, Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit

# Iterations of each rung; after each but the last, the better share of the sets of effects goes on.
_RUNGS = (2, 2, 8)
_KEPT = (0.6, 0.4)
_EACH = (2, 1)  # arms of a set that go on
# Sets that are always followed to the end, as far as there are so many.
FINALISTS = 4


@dataclass(frozen=True)
class Arm:
    """effects: all that are freed; way: index of the problem it is fitted in; begin: values to start from; near: the
    fit whose Jacobian serves as its first, None where no fit is; fit: as far as it has come.
    """

    effects: tuple[Effect, ...]
    way: int
    begin: Values
    near: Fit | None
    fit: Fit | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    @property
    def cost(self) -> float:
        return self.fit.cost if self.fit is not None else float("inf")


def parameters_of(problem: Problem, effects: Sequence[Effect]) -> list[Parameter]:
    """The nuisance and the effects' own parameters, one copy per run of what belongs to the run."""
    nuisance = list(problem.model.nuisance)
    return problem.free([*nuisance, *(parameter for effect in effects for parameter in effect.parameters)])


def race(problems: Sequence[Problem], arms: Sequence[Arm]) -> list[Arm]:
    """Run the arms; the best of each set of effects that lasted, cheapest first.

    problems: one per way.
    """
    running = list(arms)
    for rung, iterations in enumerate(_RUNGS):

        def advance(arm: Arm, iterations: int = iterations, first: bool = rung == 0) -> Arm:
            return _advanced(problems[arm.way], arm, iterations, first)

        with ThreadPoolExecutor(threads()) as pool:
            running = list(pool.map(advance, running))
        running.sort(key=lambda arm: arm.cost)
        if rung < len(_KEPT):
            running = _better(running, _KEPT[rung], _EACH[rung])
    return running


def _advanced(problem: Problem, arm: Arm, iterations: int, first: bool) -> Arm:
    if arm.fit is not None and arm.fit.settled:
        return arm
    known = None
    if first and arm.near is not None:
        known = {parameter.name: row for parameter, row in zip(arm.near.parameters, arm.near.jacobian, strict=True)}
    start = arm.begin if arm.fit is None else arm.fit.values
    found = fit(problem, parameters_of(problem, arm.effects), start, iterations=iterations, known=known)
    before = 0 if arm.fit is None else arm.fit.simulations
    return replace(arm, fit=replace(found, simulations=before + found.simulations))


def _better(running: Sequence[Arm], share: float, each: int) -> list[Arm]:
    """The arms of the better share of sets, at most ``each`` of a set; arms come cheapest first."""
    sets = list(dict.fromkeys(arm.names for arm in running))
    kept = set(sets[: max(FINALISTS, int(np.ceil(share * len(sets))))])
    counts = dict.fromkeys(sets, 0)
    chosen = []
    for arm in running:
        counts[arm.names] += 1
        if arm.names in kept and counts[arm.names] <= each:
            chosen.append(arm)
    return chosen
