"""From one explanation to the next: re-tune, then add the effect that foretells most, for as long as one is needed.

`begin` gives the first state and `step` the next; neither changes what it was given, so an interrupt leaves the last
state whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.choice.state import Explained, Judged, State, Step
from slider_drilling.gap.evidence.adequacy import adequacy
from slider_drilling.gap.evidence.compare import LEVEL, Blocks, advantage, beats, gaps, make_blocks, share_closed
from slider_drilling.gap.evidence.score import Folds, held_out, make_folds, score_of
from slider_drilling.gap.model import Effect, Graded, How, Model, Parameter, Pulled, Values
from slider_drilling.gap.problem.noise import NoiseFloor, lowered, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import FINALISTS, Arm, parameters_of, race
from slider_drilling.gap.search.screen import Candidate, screen

Report = Callable[[str, float], None]

# Gain of the weak observer (see `slider_drilling.gap.model.Pulled`).
PULL = 0.3
# An effect is worth a name if it closes at least this share of the gap.
LEAST_SHARE = 0.05
# Effects that may be named together.
MOST_EFFECTS = 3
_TUNING, _POLISH = 14, 3
# Of ``-2 log p`` per sample: a fit that loses more on the fine mesh is made there.
_RECOVERED = 0.02
_STARTS_EACH = 2
_SCATTERED, _FOLLOWED = 32, 2


def begin(
    model: Model, floors: Sequence[dict[str, NoiseFloor]], starts: Sequence[Values], seed: int, report: Report
) -> State:
    """Re-tune the model and see whether that is enough."""
    report("re-tuning", 0.02)
    free = build_problem(model, [sigmas(own) for own in floors])
    tuned = _tuned(free, starts)
    floors = _lowered(free, tuned, floors)
    free = build_problem(model, [sigmas(own) for own in floors])
    blocks = make_blocks(make_folds(free), seed)
    tuned = fit(free, tuned.parameters, tuned.values, iterations=2)
    explained = _explained(free, (), tuned, blocks.folds)
    enough = adequacy(explained.problem, explained.fit, explained.score, seed)
    if not enough.adequate:
        report("re-tuning from other starts", 0.06)
        again = _tuned(free, _scattered(free, tuned))
        if again.cost < tuned.cost:
            explained = _explained(free, (), again, blocks.folds)
            enough = adequacy(explained.problem, explained.fit, explained.score, seed)
    nominal = free.at({}, _fine(model))
    residual = nominal.residuals([{}])[0]
    given = score_of(nominal, residual, replace(explained.fit, discrepancy=nominal.cost(residual)[1]))
    good = given.gap <= enough.threshold and all(given.by_channel[c] <= v for c, v in enough.by_channel.items())
    ways = (free, free.run_as(How(0, PULL))) if _can_be_pulled(model) else (free,)
    return State(
        tuple(floors), ways, given, residual, explained, explained, enough, enough, good, blocks, (),
        explained.fit.simulations, done=enough.adequate,
    )  # fmt: skip


def step(
    state: State, effects: Sequence[Effect], together: Sequence[Sequence[Effect]], seed: int, report: Report
) -> State:
    """Race the effects that may come next, judge the finalists on unseen data, and accept the best that passes."""
    left = [effect for effect in effects if effect.name not in state.current.names]
    if not left or len(state.current.effects) >= MOST_EFFECTS:
        return replace(state, done=True)
    turn = len(state.steps)
    report(f"racing {len(left)} effects" + (f", step {turn + 1}" if turn else ""), min(0.1 + 0.3 * turn, 0.8))
    bases = _bases(state)
    screened = [screen(problem, base, left) for problem, base in zip(state.ways, bases, strict=True)]
    arms = _arms(state, screened, together if turn == 0 else ())
    ran = race(state.ways, bases, arms)
    spent = sum(arm.fit.simulations for arm in ran if arm.fit is not None)
    report("judging the finalists", min(0.25 + 0.3 * turn, 0.9))
    state, judged = _judge(state, ran, len(left), seed)
    accepted = next((one for one in judged if one.passed), None)
    promised = {c.effect.name: max(0.0, c.promise) for c in screened[0]}
    state = replace(state, simulations=state.simulations + spent)
    if accepted is None:
        return replace(state, steps=(*state.steps, Step(judged, None, (), promised)), done=True)
    enough = adequacy(accepted.explained.problem, accepted.explained.fit, accepted.explained.score, seed)
    taken = Step(judged, accepted, _group(state.blocks, accepted, judged), promised)
    return replace(state, current=accepted.explained, enough=enough, steps=(*state.steps, taken), done=enough.adequate)


def _judge(state: State, ran: Sequence[Arm], rivals: int, seed: int) -> tuple[State, tuple[Judged, ...]]:
    """Refit the finalists in the way that foretells most, and hold them out against what is known so far.

    Where that way is not the one the state was scored in, what is known is scored anew in it.
    """
    way = ran[0].way
    problem = state.ways[way]
    if state.current.problem.how != problem.how:
        state = _in_way(state, problem, seed)
    finalists = list(dict.fromkeys(arm.names for arm in ran))[:FINALISTS]
    judged = []
    for names in finalists:
        own = [arm for arm in ran if arm.names == names]
        arm = next((a for a in own if a.way == way), own[0])
        assert arm.fit is not None
        found = arm.fit
        if arm.way != way:
            found = fit(problem, arm.fit.parameters, arm.fit.values, iterations=_TUNING)
        explained = _explained(problem, arm.effects, found, state.blocks.folds)
        judged.append(_verdict(state, explained, rivals))
    judged.sort(key=lambda one: float(np.sum(one.explained.score.density)))
    return state, tuple(judged)


def _verdict(state: State, explained: Explained, rivals: int) -> Judged:
    """The tests of an effect: it foretells more than what is known, the gap shrinks by enough, its sign is its own."""
    known, blocks = state.current, state.blocks
    effect = explained.effects[-1]
    before, after = gaps(known.problem, blocks, known.score), gaps(explained.problem, blocks, explained.score)
    shares = share_closed(before, after)
    closed = float(share_closed(known.score.gap**2, explained.score.gap**2))
    low, high = (float(np.nanquantile(shares, q)) for q in (0.5 * LEVEL, 1.0 - 0.5 * LEVEL))
    why = []
    if not beats(blocks, explained.score, known.score, rivals):
        why.append("foretells no more of unseen data than without it, at the level shared among all candidates")
    if not (closed >= LEAST_SHARE and low > 0.0):
        why.append("the gap does not shrink for certain")
    amplitude = explained.fit.values[effect.parameters[0].name]
    if not effect.physical[0] <= amplitude <= effect.physical[1]:
        why.append(f"its sign is not physical: it would be {effect.nonphysical}")
    return Judged(effect, explained, closed, (low, high), tuple(why))


def _group(blocks: Blocks, accepted: Judged, judged: Sequence[Judged]) -> tuple[str, ...]:
    """Finalists that pass and are not beaten by the one accepted, at the stated level."""
    rivals = [one for one in judged if one is not accepted and one.passed]
    return tuple(
        one.effect.name
        for one in rivals
        if not beats(blocks, accepted.explained.score, one.explained.score, max(len(rivals), 1))
    )


def _in_way(state: State, problem: Problem, seed: int) -> State:
    """The state with what is known fitted and scored in another way of running the model."""
    folds = state.blocks.folds

    def again(known: Explained) -> Explained:
        found = fit(problem, known.fit.parameters, known.fit.values, iterations=_TUNING)
        return _explained(problem, known.effects, found, folds)

    tuned = again(state.tuned)
    current = tuned if state.current is state.tuned else again(state.current)
    nominal = problem.at({}, _fine(problem.model))
    residual = nominal.residuals([{}])[0]
    given = score_of(nominal, residual, replace(tuned.fit, discrepancy=nominal.cost(residual)[1]))
    enough = adequacy(tuned.problem, tuned.fit, tuned.score, seed)
    return replace(state, tuned=tuned, current=current, nominal=given, nominal_residual=residual, tuned_enough=enough)


def _explained(problem: Problem, effects: Sequence[Effect], found: Fit, folds: Folds) -> Explained:
    """A fit finished where the cheap simulation equals the fine one, and held out.

    Where what the mesh adds changes with every step, so that correcting the cheap simulation leads nowhere, the fine
    one itself is fitted.
    """
    fine = _fine(problem.model)
    exact = problem.at(found.values, fine)
    polished = fit(exact, found.parameters, found.values, iterations=_POLISH)
    exact = problem.at(polished.values, fine)
    polished = fit(exact, found.parameters, polished.values, iterations=1)
    if fine > problem.how.fidelity and polished.cost > found.cost + _RECOVERED * problem.size:
        exact = problem.run_as(replace(problem.how, fidelity=fine))
        polished = fit(exact, found.parameters, found.values, iterations=_POLISH + 2)
    return Explained(tuple(effects), exact, polished, held_out(exact, polished, folds))


def _tuned(problem: Problem, starts: Sequence[Values]) -> Fit:
    parameters = parameters_of(problem, ())
    found = [fit(problem, parameters, start, iterations=_TUNING) for start in starts]
    return min(found, key=lambda one: one.cost)


def _scattered(problem: Problem, tuned: Fit) -> list[dict[str, float]]:
    """Where else tuning may begin: the cheapest of points spread over where a rig may lie."""
    parameters = list(tuned.parameters)
    if not parameters:
        return [tuned.values]
    low, high = zip(*(_plausible(parameter) for parameter in parameters), strict=True)
    unit = qmc.Sobol(len(parameters), seed=0).random(_SCATTERED)
    points = [
        tuned.values | {p.name: float(v) for p, v in zip(parameters, row, strict=True)}
        for row in np.array(low) + (np.array(high) - np.array(low)) * unit
    ]
    costs = [problem.cost(residual)[0] for residual in problem.residuals(points)]
    return [points[index] for index in np.argsort(costs)[:_FOLLOWED]]


def _plausible(parameter: Parameter) -> tuple[float, float]:
    spread = parameter.spread if np.isfinite(parameter.spread) else parameter.upper - parameter.lower
    low = max(parameter.lower, parameter.nominal - 1.5 * spread)
    return low, min(parameter.upper, parameter.nominal + 1.5 * spread)


def _lowered(
    problem: Problem, tuned: Fit, floors: Sequence[dict[str, NoiseFloor]]
) -> tuple[dict[str, NoiseFloor], ...]:
    found = [dict(own) for own in floors]
    for piece in problem.pieces:
        left = tuned.residual[piece.rows] * piece.noise
        found[piece.run][piece.name] = lowered(found[piece.run][piece.name], left)
    return tuple(found)


def _bases(state: State) -> list[Fit]:
    """What is known, fitted in every way, with its Jacobian: where the race begins."""
    parameters = state.current.fit.parameters
    return [fit(problem, parameters, state.current.fit.values, iterations=_TUNING // 2) for problem in state.ways]


def _arms(state: State, screened: Sequence[Sequence[Candidate]], together: Sequence[Sequence[Effect]]) -> list[Arm]:
    known = state.current.effects
    arms = []
    for way, candidates in enumerate(screened):
        for candidate in candidates:
            for start in candidate.starts[:_STARTS_EACH]:
                arms.append(Arm((*known, candidate.effect), way, start))
        by_name = {candidate.effect.name: candidate for candidate in candidates}
        for effects in together:
            if all(effect.name in by_name for effect in effects):
                for place in range(_STARTS_EACH):
                    start: dict[str, float] = {}
                    for effect in effects:
                        start |= by_name[effect.name].starts[place]
                    for effect in effects:
                        own = {p.name for p in effect.parameters}
                        values = by_name[effect.name].starts[place]
                        start |= {name: value for name, value in values.items() if name in own}
                    arms.append(Arm((*known, *effects), way, start))
    return arms


def _can_be_pulled(model: Model) -> bool:
    return isinstance(model, Pulled) and any(c.name == model.pulled for run in model.runs for c in run.channels)


def _fine(model: Model) -> int:
    """The fidelity that fits are finished in: the one below the finest, which is left to show what it misses."""
    return max(model.finest - 1, 0) if isinstance(model, Graded) else 0


def explained_by(state: State, effects: Sequence[Effect], seed: int) -> Judged:
    """What one given effect closes, fitted alone from its best starts: the oracle of a blind check."""
    bases = _bases(replace(state, current=state.tuned))
    arms = []
    for way, (problem, base) in enumerate(zip(state.ways, bases, strict=True)):
        (candidate,) = screen(problem, base, effects)
        arms += [Arm(tuple(effects), way, start) for start in candidate.starts[:_STARTS_EACH]]
    _, judged = _judge(replace(state, current=state.tuned), race(state.ways, bases, arms), 1, seed)
    return judged[0]


__all__ = ["advantage", "begin", "explained_by", "step"]
