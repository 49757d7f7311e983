"""The verdict: whether what was named is a cause, a likeness of one, or nothing is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.choice.state import Explained, State
from slider_drilling.gap.evidence.compare import LEVEL, beats, by_chance, foretells_more, gaps, shrinks
from slider_drilling.gap.evidence.rivals import Rival, rivals
from slider_drilling.gap.evidence.score import Score
from slider_drilling.gap.model import Disturbed
from slider_drilling.gap.search.least_squares import pace


@dataclass(frozen=True)
class Decision:
    """verdict: none, parameters, effect, effect_and_unknown or unknown; named: effects in it; rival: the disturbance
    that explains as much as these, or of which the unknown has the shape; rest: the one that foretells most of what
    remains beside the names; state: re-tuned only where the names found are withdrawn.
    """

    verdict: str
    site: str | None
    named: tuple[str, ...]
    rival: Rival | None
    rest: Rival | None
    state: State = field(repr=False)


def decide(state: State) -> Decision:
    """The verdict that a state supports, held against every disturbance that no law describes."""
    if state.current.effects and not shrinks(state.blocks, state.tuned.score, state.current.score):
        state = _withdrawn(state)
    adequate, effects = state.enough.adequate, state.current.effects
    idle = state.partial or (adequate and not effects)
    found = [] if idle else rivals(state.tuned, state.blocks.folds, _worth(state))
    if effects and _has_stronger(state, found):
        if state.far is not None:
            return decide(state.far)
        state = _withdrawn(state)
        return _retuned(state) if state.enough.adequate else _unknown(state, found)
    rest = None if idle or adequate else _rest(state, rivals(state.current, state.blocks.folds) if effects else found)
    enough = adequate or (state.enough.within and rest is None)
    if effects:
        rival = _as_good(state, found)
        if enough and rival is None:
            return Decision("effect", effects[0].site, state.current.names, None, rest, state)
        if not state.tuned_enough.adequate:
            return Decision("effect_and_unknown", effects[0].site, state.current.names, rival, rest, state)
        # Re-tuning leaves no gap beyond noise: there is none that something else would close as well.
        return _retuned(_withdrawn(state))
    return _retuned(state) if enough else _unknown(state, found)


def _retuned(state: State) -> Decision:
    """No name, and none needed."""
    return Decision("none" if state.nominal_enough else "parameters", None, (), None, None, state)


def _withdrawn(state: State) -> State:
    """The state re-tuned only, whatever was accepted."""
    return replace(state, current=state.tuned, enough=state.tuned_enough)


def _worth(state: State) -> float:
    """What a disturbance has to gain of ``-2 log p`` before it is worth finishing: what the named laws do, but for what
    one parameter gains by chance and what the last iteration of so coarse a fit may.
    """
    gained = max(state.tuned.fit.cost - state.current.fit.cost - by_chance(1), 0.0)
    return max(gained - pace(gained), 0.0)


def _has_stronger(state: State, found: Sequence[Rival]) -> bool:
    """Whether some disturbance is a likelier cause than the laws that are named: it foretells more for certain.

    Where those leave nothing, one that is a law's own free form only says that the cause is not quite the catalogue's;
    any other says that it is another. One at another site need not be certain: what is named is no cause unless it
    foretells more than that one.
    """
    named = state.current.effects if state.enough.adequate else ()
    not_free = [rival for rival in found if not any(rival.frees(effect) for effect in named)]
    others = _elsewhere(state, found)
    certain = any(beats(state.blocks, rival.score, state.current.score, len(found)) for rival in not_free)
    return certain or any(_likelier(state, rival, len(others)) for rival in others)


def _likelier(state: State, rival: Rival, tried: int) -> bool:
    """Whether a disturbance foretells more than the named laws by more than one of so many does by chance, and leaves
    less.
    """
    mine = state.current.score
    return mine.surprise - rival.score.surprise > by_chance(1, tried) and rival.score.gap < mine.gap


def _elsewhere(state: State, found: Sequence[Rival]) -> list[Rival]:
    """The disturbances at sites that none of the named laws has."""
    named = {effect.site for effect in state.current.effects}
    return [rival for rival in found if rival.site not in named]


def _as_good(state: State, found: Sequence[Rival]) -> Rival | None:
    """The disturbance that foretells most of those at other sites, or as stiff as the named laws and no form of theirs,
    that these do not beat, or by next to nothing: the log does not tell whether the cause is a law's or that.
    """
    laws = state.current.effects
    sites, stiff = {law.site for law in laws}, sum(len(law.parameters) for law in laws)

    def another(rival: Rival) -> bool:
        return rival.site not in sites or (rival.x.size <= stiff and not any(rival.frees(law) for law in laws))

    others = [rival for rival in found if another(rival)]
    mine = state.current.score.surprise
    least = by_chance(1, max(len(others), 1))

    def beaten(rival: Rival) -> bool:
        certain = beats(state.blocks, state.current.score, rival.score, len(others))
        return certain and rival.score.surprise - mine > least

    return next((rival for rival in others if not beaten(rival)), None)


def _rest(state: State, found: Sequence[Rival]) -> Rival | None:
    """The flexible disturbance that foretells most of what the final model leaves: if none does for certain, what is
    left within its limits is noise with a colour, not structure.
    """
    certain = (one for one in found if beats(state.blocks, one.score, state.current.score, len(found)))
    return next(certain, None)


def _unknown(state: State, found: Sequence[Rival]) -> Decision:
    """No name: where the cause is likeliest to be, and the shape of what is off there, where one foretells more."""
    site = _likeliest_site(state, found)
    shape = (one for one in found if one.site == site and _explains(state, one.score, len(found)))
    return Decision("unknown", site, (), next(shape, None), None, state)


def _explains(state: State, score: Score, tried: int) -> bool:
    """Whether one of so many that were tried foretells more than re-tuning for certain, and the gap shrinks with it."""
    tuned = state.tuned.score
    shorter = shrinks(state.blocks, tuned, score)
    return shorter and foretells_more(state.blocks, score, tuned, tried)


def _likeliest_site(state: State, found: Sequence[Rival]) -> str | None:
    """The site of what foretells most of all that was tried, whether or not it may be named: a law that passes no test
    and a disturbance that no law describes act where something is missing. Where one channel alone is off, that
    channel's own, unless something else is likely, and foretells more for certain than any likely reading of it.
    """
    judged = [one for taken in state.steps[:1] for one in taken.judged]
    tried = [_Tried(one.effect.site, one.explained.score) for one in judged if _in_one_unit(state, one.explained)]
    tried += [_Tried(rival.site, rival.score, rival.reading) for rival in found]
    likely = _likely(state, tried)
    best = min(likely or _with_less_left(state, tried) or tried, key=_surprise, default=None)
    model, left = state.tuned.problem.model, state.tuned_enough
    off = left.beyond or left.structured
    if len(off) == 1 and isinstance(model, Disturbed):
        reading = min((one for one in likely if one.reading == off[0]), key=_surprise, default=None)
        if not likely or best is None:
            return model.site_of(off[0])
        if reading is not None and not _more_for_certain(state, best.score, reading.score, len(tried)):
            return model.site_of(off[0])
    return None if best is None else best.site


@dataclass(frozen=True)
class _Tried:
    """A law or a disturbance that was held out; reading: the channel whose reading alone would be off."""

    site: str
    score: Score
    reading: str | None = None


def _surprise(one: _Tried) -> float:
    return one.score.surprise


def _likely(state: State, tried: Sequence[_Tried]) -> list[_Tried]:
    """Those of which one explains what is left for certain; where none does, those with which the gap shrinks for
    certain, and than which re-tuning alone foretells no more for certain: a discrepancy forgives what is slow.
    """
    certain = [one for one in tried if _explains(state, one.score, len(tried))]
    tuned = state.tuned.score
    return certain or [
        one for one in tried
        if not beats(state.blocks, tuned, one.score) and shrinks(state.blocks, tuned, one.score)
    ]  # fmt: skip


def _with_less_left(state: State, tried: Sequence[_Tried]) -> list[_Tried]:
    """Those that foretell more on the whole and with which the gap is smaller: what foretells most while the gap grows
    describes what remains, and is no cause of it.
    """
    tuned = state.tuned.score
    return [one for one in tried if one.score.surprise < tuned.surprise and one.score.gap < tuned.gap]


def _more_for_certain(state: State, one: Score, other: Score, tried: int) -> bool:
    """Whether one of so many that were tried foretells more than the other for certain, or as much and leaves less of
    the gap for certain: a discrepancy forgives what is slow, the gap does not.
    """
    if foretells_more(state.blocks, one, other, tried):
        return True
    less = gaps(state.blocks, other) - gaps(state.blocks, one)
    return one.surprise <= other.surprise and float(np.quantile(less, LEVEL / tried)) > 0.0


def _in_one_unit(state: State, explained: Explained) -> bool:
    """Whether an explanation was scored in the noise that the state has now: densities compare in no other."""
    now, then = (one.problem.pieces for one in (state.tuned, explained))
    return all(mine.noise == other.noise for mine, other in zip(now, then, strict=True))
