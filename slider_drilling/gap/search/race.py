"""The race between explanations: every effect starts from several places, and whoever falls behind is not followed.

An arm is a set of effects, a place to begin, and a way to run the model (free, or weakly pulled). All are scored by the
same likelihood, so arms that run in different ways compete: a pulled run is a prediction from the torque measured
so far, a free run one from the commands alone, and which of the two foretells more is for the log to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from slider_drilling.gap.model import Array, Effect, Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import MAX_ITERATIONS, TOLERANCE, Fit, fit, min_gain_to_catch_up
from slider_drilling.gap.search.screen import STARTS, rank_starts, scan_effects, screen
from slider_drilling.process.parallel_map import parallel_map

# Explanations that are judged.
FINALISTS = 3


@dataclass(frozen=True)
class Arm:
    """effects: all that are freed; way: index of the problem it is fitted in; begin: values to start from; near: the
    fit that it begins beside, whose Jacobian serves as its first, None where no fit is; begun: (N,) simulated there,
    where it is known; fit: as far as it has come.
    """

    effects: tuple[Effect, ...]
    mode: int
    start: Values
    base: Fit | None
    start_simulated: Array | None = field(default=None, repr=False)
    fit: Fit | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    @property
    def cost(self) -> float:
        return self.fit.cost if self.fit is not None else float("inf")

    @property
    def physical(self) -> bool:
        """Whether every effect has the sign that its name stands for."""
        values = self.start if self.fit is None else self.fit.values
        return all(effect.is_physical(values) for effect in self.effects)


def parameters_of(problem: Problem, effects: Sequence[Effect]) -> list[Parameter]:
    """The nuisance and the effects' own parameters, one copy per run of what belongs to the run."""
    nuisance = list(problem.model.nuisance)
    return problem.expand_per_run([*nuisance, *(parameter for effect in effects for parameter in effect.parameters)])


def race(problems: Sequence[Problem], arms: Sequence[Arm], incumbent_cost: float = float("inf")) -> list[Arm]:
    """Run the arms; those that lasted, cheapest first. known: cost that they have to come up with besides.

    Of the sets in each heat the better half goes on, twice as far as before, until few are left, which are followed to
    their ends (sequential halving; Karnin, Koren and Somekh, ICML 2013). problems: one per way.
    """
    iterations, running = 1, _furthered(problems, arms, 1, incumbent_cost)
    while _many(running := _better_half(running)):
        iterations *= 2
        running = _furthered(problems, running, iterations, incumbent_cost)
    return _furthered(problems, running, MAX_ITERATIONS, incumbent_cost)


def _furthered(problems: Sequence[Problem], running: Sequence[Arm], iterations: int, known: float) -> list[Arm]:
    """The arms after so many iterations more, cheapest first; one that does not come up with the leader, or with what
    is known, in so many stops.
    """
    leader = min((known, *(arm.cost for arm in running if arm.physical)))

    def advance(arm: Arm) -> Arm:
        least = min_gain_to_catch_up(arm.cost - leader, iterations) if arm.fit is not None else TOLERANCE
        return _advanced(problems[arm.mode].at_fidelity_of(arm.effects), arm, iterations, least)

    return sorted(parallel_map(advance, running), key=lambda arm: arm.cost)


def restart_leader(problems: Sequence[Problem], ran: Sequence[Arm], added: int = 1) -> list[Arm]:
    """What the race left, and its leader once more: each of so many that were added is looked for anew, beside the
    others and with the nuisance that it was found with.

    A scan from a nuisance that makes up for the effect, or from the rig as given, points where the effect would do for
    all the rest as well; from the leader's own it points to the effect alone.
    """
    leader = next((arm for arm in ran if arm.physical), ran[0])
    problem = problems[leader.mode].at_fidelity_of(leader.effects)
    arms = [arm for effect in leader.effects[-added:] for arm in _sought_anew(problem, leader, effect)]
    found = parallel_map(lambda arm: _advanced(problem, arm, MAX_ITERATIONS), arms)
    return sorted([*ran, *found], key=lambda arm: arm.cost)


def _sought_anew(problem: Problem, leader: Arm, effect: Effect) -> list[Arm]:
    """Arms that begin where one effect of the leader's leaves least beside all else of it."""
    assert leader.fit is not None
    others = [one for one in leader.effects if one is not effect]
    own = {parameter.name for parameter in effect.parameters}
    bare = {name: value for name, value in leader.fit.values.items() if name not in own}
    scan = scan_effects(problem, fit(problem, parameters_of(problem, others), bare, iterations=0), [effect])
    (candidate,) = screen(scan)
    starts = rank_starts(scan, candidate)[:STARTS]
    return [replace(leader, start=start, base=None, start_simulated=simulated, fit=None) for start, simulated in starts]


def _advanced(problem: Problem, arm: Arm, iterations: int, least: float = TOLERANCE) -> Arm:
    if arm.fit is not None and arm.fit.converged:
        return arm
    freed = parameters_of(problem, arm.effects)
    if arm.fit is None:
        known = arm.base.jacobian_rows if arm.base is not None else {}
        found = fit(
            problem,
            freed,
            arm.start,
            iterations=iterations,
            tolerance=least,
            simulated=arm.start_simulated,
            jacobian_rows=known,
        )
    else:
        found = fit(
            problem, freed, arm.fit.values, iterations=iterations, tolerance=least, simulated=arm.fit.simulated,
            jacobian_rows=arm.fit.reusable_rows,
        )  # fmt: skip
    return replace(arm, fit=found)


def _heats(running: Sequence[Arm]) -> list[list[Arm]]:
    """The arms that began beside the same fit. Compared with arms that began elsewhere, one that begins where nothing
    has been tuned yet looks worse than one that does nothing.
    """
    heats: dict[int, list[Arm]] = {}
    for arm in running:
        heats.setdefault(id(arm.base), []).append(arm)
    return list(heats.values())


def _many(running: Sequence[Arm]) -> bool:
    """Whether some heat has more than a few arms whose signs are their names'."""
    return any(sum(arm.physical for arm in heat) > FINALISTS for heat in _heats(running))


def _better_half(running: Sequence[Arm]) -> list[Arm]:
    """Of each heat the arms of the better half of its sets, the best of each, as long as they are more than a few; arms
    come cheapest first. Of those whose sign is not their name's only the best goes on: they bend to much, and none is a
    cause.
    """
    chosen = []
    for heat in _heats(running):
        best: dict[tuple[tuple[str, ...], bool], Arm] = {}
        for arm in heat:
            best.setdefault((arm.names, arm.physical), arm)
        half = (len({names for names, _ in best}) + 1) // 2
        chosen += [arm for arm in best.values() if arm.physical][: max(FINALISTS, half)]
        chosen += [arm for arm in best.values() if not arm.physical][:1]
    return chosen


def finalists(ran: Sequence[Arm]) -> list[list[Arm]]:
    """The arms of each set that is judged, cheapest first: the best of those with their name's sign, one without."""
    sets: dict[tuple[tuple[str, ...], bool], list[Arm]] = {}
    for arm in ran:
        sets.setdefault((arm.names, arm.physical), []).append(arm)
    named = [arms for (_, physical), arms in sets.items() if physical][:FINALISTS]
    shapes = [arms for (_, physical), arms in sets.items() if not physical][:1]
    return sorted(named + shapes, key=lambda arms: arms[0].cost)
