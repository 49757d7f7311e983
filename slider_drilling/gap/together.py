"""Effects that only show together: all of them searched for at once, then each that is not missed left out.

With stick-slip an effect alone closes nothing: as long as one of the others is missing the phase is wrong, and a
wrong phase costs more than a wrong amplitude. Nor does a descent from one start get there. So the effects that a model
names (`slider_drilling.gap.model.Together`) are freed together with the nuisance, a population is evolved (scipy's
differential evolution) from points spread over all of their range, its best is polished by least squares, and then
the effects are tried without one after the other, each time with what is left of the population to begin from.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from slider_drilling.gap.contender import Base, Contender, judge, make_base
from slider_drilling.gap.findings import Findings
from slider_drilling.gap.fit import Fit
from slider_drilling.gap.held_out import Bootstrap
from slider_drilling.gap.model import Anchored, Array, Effect, Parameter, Together, Values
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import screen
from slider_drilling.gap.tune import fit_growing

POPULATION = 128
GENERATIONS = 80
# So many of a population go on to least squares, no two of them nearer than this in the unit cube.
POLISHED = 3
_APART = 0.2
# Members of a population that the exact model looks at.
_LOOKED_AT = 24
# Descents of one start, the model made exact before each.
_DESCENTS = (1.0, 1.0)
# Of a population that has lost an effect: it lies near the answer already.
_AGAIN = 15
# Starts begin from the best of so many times the population.
_FIRST = 4
# A range that spans more than this factor is searched by its logarithm.
_DECADE = 10.0
_SPREADS = 2.0
_BATCH = 64
_AGREEMENT = 0.15


@dataclass(frozen=True)
class Joint:
    """What is left of the effects: accepted with their scores, the fit with all of them, and what was tried.

    tried: every effect of the model's list with the score of leaving it out, in the order of trying.
    """

    accepted: tuple[Contender, ...]
    fit: Fit
    tried: tuple[Contender, ...]


class _Box:
    """The unit cube over the parameters' ranges, logarithmic where they span decades."""

    def __init__(self, parameters: Sequence[Parameter], effects: Sequence[Effect]) -> None:
        physical = {effect.parameters[0].name: effect.physical for effect in effects}
        self.names = [parameter.name for parameter in parameters]
        low, high = np.empty(len(parameters)), np.empty(len(parameters))
        for index, parameter in enumerate(parameters):
            least, most = physical.get(parameter.name, (-np.inf, np.inf))
            reach = _SPREADS * parameter.spread
            ratio = parameter.upper / parameter.lower if parameter.lower > 0.0 else 0.0
            near = (-np.inf, np.inf) if ratio > _DECADE else (parameter.nominal - reach, parameter.nominal + reach)
            low[index] = max(parameter.lower, least, near[0])
            high[index] = min(parameter.upper, most, near[1])
        self.logarithmic = (low > 0.0) & (high > _DECADE * low)
        self.low = np.where(self.logarithmic, np.log(np.where(low > 0.0, low, 1.0)), low)
        self.high = np.where(self.logarithmic, np.log(np.where(high > 0.0, high, 1.0)), high)

    def values(self, point: Array, fixed: Values) -> dict[str, float]:
        raw = self.low + point * (self.high - self.low)
        raw = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, raw, 0.0)), raw)
        return dict(fixed) | {name: float(value) for name, value in zip(self.names, raw, strict=True)}


def evolve(
    problem: Problem,
    box: _Box,
    fixed: Values,
    population: Array,
    generations: int,
    seed: int,
    tick: Callable[[], None],
) -> tuple[Array, Array]:
    """The population (n, p) after so many generations, best first, and its E^2 (n,)."""

    def costs(columns: Array) -> Array:
        tick()
        return costs_of(problem, [box.values(point, fixed) for point in columns.T])

    found = differential_evolution(
        costs, [(0.0, 1.0)] * population.shape[1], init=population, maxiter=generations, tol=0.0, polish=False,
        mutation=(0.4, 0.9), recombination=0.8, vectorized=True, updating="deferred", seed=seed,
    )  # fmt: skip
    order = np.argsort(found.population_energies)
    return found.population[order], found.population_energies[order]


def costs_of(problem: Problem, sets: Sequence[Values]) -> Array:
    """(K,) E^2 of the cheap model; a simulation that ran away costs more than any that did not."""
    if isinstance(problem.model, Anchored):
        problem.model.anchor([])
    found = []
    for begin in range(0, len(sets), _BATCH):
        found += [problem.gap_squared(residual) for residual in problem.residuals(sets[begin : begin + _BATCH])]
    costs = np.array(found)
    return np.where(np.isfinite(costs), costs, 1e12)


def add_together(findings: Findings, catalogue: Sequence[Effect], seed: int, progress: Progress) -> bool:
    """Put what `fit_together` finds into the findings; False where the model names nothing or nothing is accepted."""
    problem, base = findings.problem, findings.current
    model = problem.model
    names = model.together if isinstance(model, Together) else ()
    effects = [effect for effect in catalogue if effect.name in names]
    if base is None or len(effects) < 2 or findings.at_floor(base.score):
        return False
    findings.screened.append(screen(problem, base.fit, catalogue))
    joint = fit_together(problem, findings.bootstrap, base, effects, seed=seed, progress=progress)
    findings.rounds.append(list(joint.tried))
    if not joint.accepted:
        findings.screened.pop()
        findings.rounds.pop()
        return False
    findings.accepted.extend(joint.accepted)
    problem.anchor(joint.fit.values)
    findings.current = make_base(problem, findings.bootstrap, joint.fit)
    return True


def fit_together(
    problem: Problem,
    bootstrap: Bootstrap,
    base: Base,
    effects: Sequence[Effect],
    *,
    seed: int = 0,
    progress: Progress = lambda stage, share: None,
) -> Joint:
    """Free the effects together and keep those that held-out data misses.

    base: the tuned model without any of them. Acceptance is corrected by the number of effects: no other is tried.
    """
    fits, populations = [], []
    for turn in (0, 1):
        box = _Box(_freed(base, effects), effects)
        first = qmc.Sobol(len(box.names), seed=seed + turn).random_base2(int(np.ceil(np.log2(_FIRST * POPULATION))))
        first = first[np.argsort(costs_of(problem, [box.values(p, base.fit.values) for p in first]))[:POPULATION]]
        count = [0]

        def tick(turn: int = turn, count: list[int] = count) -> None:
            count[0] += 1
            progress("searching effects together", 0.18 + 0.2 * (turn + min(count[0] / GENERATIONS, 1.0)))

        evolved, _ = evolve(problem, box, base.fit.values, first, GENERATIONS, seed + turn, tick)
        populations.append(evolved)
        fits.append(_polished(problem, base, effects, _starts(problem, box, base.fit.values, evolved)))
    best = int(np.argmin([found.cost for found in fits]))
    gain = base.fit.cost - fits[best].cost
    agree = fits[1 - best].cost - fits[best].cost <= _AGREEMENT * gain
    return _without_the_unneeded(
        problem, bootstrap, base, list(effects), fits[best], populations[best], agree, seed, progress
    )


def _freed(base: Base, effects: Sequence[Effect]) -> list[Parameter]:
    return [*base.fit.parameters, *(parameter for effect in effects for parameter in effect.parameters)]


def _starts(problem: Problem, box: _Box, fixed: Values, population: Array) -> list[dict[str, float]]:
    """The few of a population (n, p), best first, that the exact model finds best among those that lie apart.

    A population lives on the cheap model; where a cycle more or less hangs on little, the exact one may see another.
    """
    apart: list[Array] = []
    for point in population:
        if all(np.linalg.norm(point - other) > _APART for other in apart):
            apart.append(point)
        if len(apart) == _LOOKED_AT:
            break
    costs = []
    for point in apart:
        values = box.values(point, fixed)
        problem.anchor(values)
        costs.append(problem.robust_gap(problem.residuals([values])[0]))
    return [box.values(apart[index], fixed) for index in np.argsort(costs)[:POLISHED]]


def _polished(problem: Problem, base: Base, effects: Sequence[Effect], starts: Sequence[Values]) -> Fit:
    """Least squares from every start, and from the best of them with a search around it."""
    parameters = _freed(base, effects)
    fits = [
        fit_growing(problem, parameters, base.fit.values | dict(start), iterations=8, shares=_DESCENTS)
        for start in starts
    ]
    best = min(fits, key=lambda found: found.cost)
    return fit_growing(problem, parameters, best.values, iterations=8, shares=(1.0, 1.0), shaken=(1.0,))


def _without_the_unneeded(
    problem: Problem,
    bootstrap: Bootstrap,
    base: Base,
    effects: list[Effect],
    whole: Fit,
    population: Array,
    agree: bool,
    seed: int,
    progress: Progress,
) -> Joint:
    candidates = len(effects)
    tried: list[Contender] = []
    needed: dict[str, Contender] = {}
    for place, effect in enumerate(list(effects)):
        progress(f"leaving out {effect.name}", 0.6 + 0.3 * place / 5.0)
        rest = [other for other in effects if other is not effect]
        full_box, box = _Box(_freed(base, effects), effects), _Box(_freed(base, rest), rest)
        kept = [full_box.names.index(name) for name in box.names]
        evolved, _ = evolve(problem, box, base.fit.values, population[:, kept], _AGAIN, seed, lambda: None)
        starts = [{n: whole.values[n] for n in box.names}, *_starts(problem, box, base.fit.values, evolved)]
        without = _polished(problem, base, rest, starts)
        reference = make_base(problem, bootstrap, without)
        problem.anchor(whole.values)
        contender = judge(problem, bootstrap, reference, effect, whole, agree, candidates)
        tried.append(contender)
        if contender.accepted:
            needed[effect.name] = contender
        else:
            effects, whole, population = rest, without, evolved
    # What is accepted stands with the values that it has once the others are out.
    final = [replace(c, fit=whole) if c.effect.name in needed else c for c in tried]
    return Joint(tuple(c for c in final if c.effect.name in needed), whole, tuple(final))
