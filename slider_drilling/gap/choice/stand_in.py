"""A nuisance that went far: re-tuning was enough, and may have stood in for a law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.choice.refit import scored, tested
from slider_drilling.gap.choice.state import Explained, Judged, State
from slider_drilling.gap.choice.tuning import FAR_OFF, plausible, tuned_from
from slider_drilling.gap.evidence.compare import by_chance
from slider_drilling.gap.model import Effect, Parameter


def far_off(explained: Explained) -> list[tuple[Parameter, float, float]]:
    """What of the nuisance had to go farther than rigs are commonly off: parameter, its value, how many spreads."""
    found = []
    for parameter in explained.problem.model.nuisance:
        value = explained.fit.values.get(parameter.name, parameter.nominal)
        spreads = abs(value - parameter.nominal) / parameter.spread
        if not parameter.per_run and spreads > FAR_OFF:
            found.append((parameter, value, spreads))
    return found


def kept_near(state: State, effects: Sequence[Effect], seed: int) -> State:
    """The state with its re-tuning held to where rigs commonly are; what it was before stays known as ``far``. effects:
    looked for in what that leaves.
    """
    far = {parameter.name for parameter, _, _ in far_off(state.current)}
    freed = [_within(parameter) if parameter.name in far else parameter for parameter in state.current.fit.parameters]
    known = {name: value for name, value in state.current.fit.values.items() if "@" in name}
    near = scored(state.way, (), tuned_from(state.way, (state.current.fit.values, known), freed), state.blocks.folds)
    enough = tested(near, seed, effects)
    return replace(state, tuned=near, current=near, enough=enough, tuned_enough=enough, far=state)


def told_by_the_log(known: Explained, judged: Judged, rivals: int) -> bool:
    """Whether the log alone, whatever rigs commonly are, is likelier with an effect than its added parameters make it
    by chance, at the level shared among all; and foretells as much of what was held out.
    """
    there, here = (one.problem.cost(one.fit.residual)[0] for one in (known, judged.explained))
    added = len(judged.explained.fit.parameters) - len(known.fit.parameters)
    foretold = judged.explained.score.surprise <= known.score.surprise
    return foretold and there - here > by_chance(added, rivals)


def _within(parameter: Parameter) -> Parameter:
    low, high = plausible(parameter)
    return replace(parameter, lower=low, upper=high)
