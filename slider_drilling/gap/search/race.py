"""The race between fits: every effect starts from several points, and fits that fall behind stop early.

An arm is a set of effects, a start, and a simulation mode (free run, or run with an observer). All arms are scored by
the same likelihood, so that modes compete too: with an observer a simulation predicts from what is measured so far, a
free run from the commands alone, and the log decides which predicts better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from slider_drilling.gap.model import Array, Effect, Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import (
    MAX_ITERATIONS,
    TOLERANCE,
    Fit,
    KnownStart,
    fit,
    min_gain_to_catch_up,
)
from slider_drilling.gap.search.screen import STARTS, rank_starts, scan_effects, screen
from slider_drilling.process.parallel_map import parallel_map

# Sets of effects that are refitted and tested after a race.
FINALISTS = 3


@dataclass(frozen=True)
class Arm:
    """One fit in a race.

    Attributes:
        effects: All effects that are freed.
        mode: Index of the problem it is fitted in, one for each simulation mode.
        start: Parameter values to start from.
        base: The fit that it starts beside, whose Jacobian it reuses; None if there is none.
        start_simulated: (N,) simulation of the start, where it is known.
        fit: The fit as far as it has come, None before the first iteration.
    """

    effects: tuple[Effect, ...]
    mode: int
    start: Values
    base: Fit | None
    start_simulated: Array | None = field(default=None, repr=False)
    fit: Fit | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(effect.name for effect in self.effects)

    @property
    def cost(self) -> float:
        """``-2 log p`` so far, infinite before the first iteration."""
        return self.fit.cost if self.fit is not None else float("inf")

    @property
    def physical(self) -> bool:
        """Whether every effect lies in its physical range."""
        values = self.start if self.fit is None else self.fit.values
        return all(effect.is_physical(values) for effect in self.effects)


def parameters_of(problem: Problem, effects: Sequence[Effect]) -> list[Parameter]:
    """The nuisance and the effects' own parameters, one copy per run of those that belong to the run."""
    nuisance = list(problem.model.nuisance)
    return problem.expand_per_run([*nuisance, *(parameter for effect in effects for parameter in effect.parameters)])


def race(problems: Sequence[Problem], arms: Sequence[Arm], incumbent_cost: float = float("inf")) -> list[Arm]:
    """Run the arms by sequential halving (Karnin, Koren and Somekh, ICML 2013).

    After each round the better half of the sets of each heat continues, for twice as many iterations, until few are
    left. These are followed to their ends.

    Args:
        problems: The problem of each simulation mode.
        arms: The arms.
        incumbent_cost: ``-2 log p`` that they have to catch up with besides the leader's.

    Returns:
        The arms that lasted, cheapest first.
    """
    iterations, running = 1, _advance_all(problems, arms, 1, incumbent_cost)
    while _too_many(running := _better_half(running)):
        iterations *= 2
        running = _advance_all(problems, running, iterations, incumbent_cost)
    return _advance_all(problems, running, MAX_ITERATIONS, incumbent_cost)


def restart_leader(problems: Sequence[Problem], finishers: Sequence[Arm], added: int = 1) -> list[Arm]:
    """The finishers of a race, and new arms in which the leader's newest effects start again.

    The first scan was made beside a nuisance that makes up for the effect, or beside the model as given. It points
    where the effect would do for everything that is missing. A scan beside the leader's other parameters points to
    the effect alone.

    Args:
        problems: The problem of each simulation mode.
        finishers: Arms that the race left, cheapest first.
        added: How many effects were added; each is scanned again.

    Returns:
        Old and new arms, cheapest first.
    """
    leader = next((arm for arm in finishers if arm.physical), finishers[0])
    problem = problems[leader.mode].at_fidelity_of(leader.effects)
    arms = [arm for effect in leader.effects[-added:] for arm in _arms_of_rescan(problem, leader, effect)]
    restarted = parallel_map(lambda arm: _advance(problem, arm, MAX_ITERATIONS), arms)
    return sorted([*finishers, *restarted], key=lambda arm: arm.cost)


def finalists(finishers: Sequence[Arm]) -> list[list[Arm]]:
    """The best sets of effects, each with its arms, cheapest first: `FINALISTS` physical ones and one nonphysical."""
    sets: dict[tuple[tuple[str, ...], bool], list[Arm]] = {}
    for arm in finishers:
        sets.setdefault((arm.names, arm.physical), []).append(arm)
    physical = [arms for (_, is_physical), arms in sets.items() if is_physical][:FINALISTS]
    nonphysical = [arms for (_, is_physical), arms in sets.items() if not is_physical][:1]
    return sorted(physical + nonphysical, key=lambda arms: arms[0].cost)


def _advance_all(
    problems: Sequence[Problem], arms: Sequence[Arm], iterations: int, incumbent_cost: float
) -> list[Arm]:
    """The arms after so many further iterations, cheapest first; arms that cannot catch up in these stop."""
    best = min((incumbent_cost, *(arm.cost for arm in arms if arm.physical)))

    def advance(arm: Arm) -> Arm:
        least_gain = min_gain_to_catch_up(arm.cost - best, iterations) if arm.fit is not None else TOLERANCE
        return _advance(problems[arm.mode].at_fidelity_of(arm.effects), arm, iterations, least_gain)

    return sorted(parallel_map(advance, arms), key=lambda arm: arm.cost)


def _advance(problem: Problem, arm: Arm, iterations: int, least_gain: float = TOLERANCE) -> Arm:
    """The arm after so many further iterations."""
    if arm.fit is not None and arm.fit.converged:
        return arm
    freed = parameters_of(problem, arm.effects)
    if arm.fit is None:
        start, simulated = arm.start, arm.start_simulated
        rows = arm.base.jacobian_rows if arm.base is not None else {}
    else:
        start, simulated, rows = arm.fit.values, arm.fit.simulated, arm.fit.reusable_rows
    advanced = fit(
        problem, freed, start, iterations=iterations, tolerance=least_gain, known=KnownStart(simulated, rows)
    )
    return replace(arm, fit=advanced)


def _arms_of_rescan(problem: Problem, leader: Arm, effect: Effect) -> list[Arm]:
    """Arms that start one effect of the leader again, where it leaves least beside the rest of the leader."""
    assert leader.fit is not None
    others = [other for other in leader.effects if other is not effect]
    own = {parameter.name for parameter in effect.parameters}
    rest = {name: value for name, value in leader.fit.values.items() if name not in own}
    scan = scan_effects(problem, fit(problem, parameters_of(problem, others), rest, iterations=0), [effect])
    (screened,) = screen(scan)
    starts = rank_starts(scan, screened)[:STARTS]
    return [replace(leader, start=start, base=None, start_simulated=simulated, fit=None) for start, simulated in starts]


def _heats(arms: Sequence[Arm]) -> list[list[Arm]]:
    """The arms by the fit that they start beside.

    Only these can be compared early: beside a nuisance that is not calibrated yet, a good effect looks worse than no
    effect beside one that is.
    """
    heats: dict[int, list[Arm]] = {}
    for arm in arms:
        heats.setdefault(id(arm.base), []).append(arm)
    return list(heats.values())


def _too_many(arms: Sequence[Arm]) -> bool:
    """Whether some heat has more physical arms than finalists."""
    return any(sum(arm.physical for arm in heat) > FINALISTS for heat in _heats(arms))


def _better_half(arms: Sequence[Arm]) -> list[Arm]:
    """Of each heat, the best arm of each set in the better half of its sets, but no fewer than `FINALISTS`.

    Arms come cheapest first. Of the nonphysical ones only the best continues: they can fit much, and none is a cause.
    """
    kept = []
    for heat in _heats(arms):
        best: dict[tuple[tuple[str, ...], bool], Arm] = {}
        for arm in heat:
            best.setdefault((arm.names, arm.physical), arm)
        half = (len({names for names, _ in best}) + 1) // 2
        kept += [arm for arm in best.values() if arm.physical][: max(FINALISTS, half)]
        kept += [arm for arm in best.values() if not arm.physical][:1]
    return kept
