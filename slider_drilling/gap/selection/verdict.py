"""The verdict: whether what was named is a cause, a likeness of one, or nothing is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.evidence.compare import (
    LEVEL,
    chi2_critical,
    predicts_better,
    predicts_better_among,
    resampled_squared_gaps,
    shrinks,
)
from slider_drilling.gap.evidence.free_forms import FreeFormFit, fit_free_forms
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import HasFreeForms
from slider_drilling.gap.search.least_squares import min_gain_to_catch_up
from slider_drilling.gap.selection.state import FittedModel, SearchState


@dataclass(frozen=True)
class Decision:
    """verdict: none, parameters, effect, effect_and_unknown or unknown; named: effects in it; rival: the disturbance
    that explains as much as these, or of which the unknown has the shape; rest: the one that foretells most of what
    remains beside the names; state: re-tuned only where the names found are withdrawn.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    alternative: FreeFormFit | None
    remainder: FreeFormFit | None
    state: SearchState = field(repr=False)


def reach_verdict(state: SearchState) -> Decision:
    """The verdict that a state supports, held against every disturbance that no law describes."""
    if state.current.effects and not shrinks(state.bootstrap, state.calibrated.score, state.current.score):
        state = _withdrawn(state)
    adequate, effects = state.adequacy.adequate, state.current.effects
    idle = state.interrupted or (adequate and not effects)
    found = [] if idle else fit_free_forms(state.calibrated, state.bootstrap.folds, _worth(state))
    if effects and _has_stronger(state, found):
        if state.unrestricted is not None:
            return reach_verdict(state.unrestricted)
        state = _withdrawn(state)
        return _retuned(state) if state.adequacy.adequate else _unknown(state, found)
    rest = (
        None
        if idle or adequate
        else _rest(state, fit_free_forms(state.current, state.bootstrap.folds) if effects else found)
    )
    enough = adequate or (state.adequacy.within_thresholds and rest is None)
    if effects:
        rival = _as_good(state, found)
        if enough and rival is None:
            return Decision("effect", effects[0].site, state.current.names, None, rest, state)
        if not state.calibrated_adequacy.adequate:
            return Decision("effect_and_unknown", effects[0].site, state.current.names, rival, rest, state)
        # Re-tuning leaves no gap beyond noise: there is none that something else would close as well.
        return _retuned(_withdrawn(state))
    return _retuned(state) if enough else _unknown(state, found)


def _retuned(state: SearchState) -> Decision:
    """No name, and none needed."""
    return Decision("none" if state.nominal_adequate else "parameters", None, (), None, None, state)


def _withdrawn(state: SearchState) -> SearchState:
    """The state re-tuned only, whatever was accepted."""
    return replace(state, current=state.calibrated, adequacy=state.calibrated_adequacy)


def _worth(state: SearchState) -> float:
    """What a disturbance has to gain of ``-2 log p`` before it is worth finishing: what the named laws do, but for what
    one parameter gains by chance and what the last iteration of so coarse a fit may.
    """
    gained = max(state.calibrated.fit.cost - state.current.fit.cost - chi2_critical(1), 0.0)
    return max(gained - min_gain_to_catch_up(gained), 0.0)


def _has_stronger(state: SearchState, found: Sequence[FreeFormFit]) -> bool:
    """Whether some disturbance is a likelier cause than the laws that are named: it foretells more for certain.

    Where those leave nothing, one that is a law's own free form only says that the cause is not quite the catalogue's;
    any other says that it is another. One at another site need not be certain: what is named is no cause unless it
    foretells more than that one.
    """
    named = state.current.effects if state.adequacy.adequate else ()
    not_free = [rival for rival in found if not any(rival.covers(effect) for effect in named)]
    others = _elsewhere(state, found)
    certain = any(predicts_better(state.bootstrap, rival.score, state.current.score, len(found)) for rival in not_free)
    return certain or any(_likelier(state, rival, len(others)) for rival in others)


def _likelier(state: SearchState, rival: FreeFormFit, tried: int) -> bool:
    """Whether a disturbance foretells more than the named laws by more than one of so many does by chance, and leaves
    less.
    """
    mine = state.current.score
    return (
        mine.held_out_deviance - rival.score.held_out_deviance > chi2_critical(1, tried) and rival.score.gap < mine.gap
    )


def _elsewhere(state: SearchState, found: Sequence[FreeFormFit]) -> list[FreeFormFit]:
    """The disturbances at sites that none of the named laws has."""
    named = {effect.site for effect in state.current.effects}
    return [rival for rival in found if rival.site not in named]


def _as_good(state: SearchState, found: Sequence[FreeFormFit]) -> FreeFormFit | None:
    """The disturbance that foretells most of those at other sites, or as stiff as the named laws and no form of theirs,
    that these do not beat, or by next to nothing: the log does not tell whether the cause is a law's or that.
    """
    laws = state.current.effects
    sites, stiff = {law.site for law in laws}, sum(len(law.parameters) for law in laws)

    def another(rival: FreeFormFit) -> bool:
        return rival.site not in sites or (rival.x.size <= stiff and not any(rival.covers(law) for law in laws))

    others = [rival for rival in found if another(rival)]
    mine = state.current.score.held_out_deviance
    least = chi2_critical(1, max(len(others), 1))

    def beaten(rival: FreeFormFit) -> bool:
        certain = predicts_better(state.bootstrap, state.current.score, rival.score, len(others))
        return certain and rival.score.held_out_deviance - mine > least

    return next((rival for rival in others if not beaten(rival)), None)


def _rest(state: SearchState, found: Sequence[FreeFormFit]) -> FreeFormFit | None:
    """The flexible disturbance that foretells most of what the final model leaves: if none does for certain, what is
    left within its limits is noise with a colour, not structure.
    """
    certain = (one for one in found if predicts_better(state.bootstrap, one.score, state.current.score, len(found)))
    return next(certain, None)


def _unknown(state: SearchState, found: Sequence[FreeFormFit]) -> Decision:
    """No name: where the cause is likeliest to be, and the shape of what is off there, where one foretells more."""
    site = _likeliest_site(state, found)
    shape = (one for one in found if one.site == site and _explains(state, one.score, len(found)))
    return Decision("unknown", site, (), next(shape, None), None, state)


def _explains(state: SearchState, score: HeldOutScore, tried: int) -> bool:
    """Whether one of so many that were tried foretells more than re-tuning for certain, and the gap shrinks with it."""
    tuned = state.calibrated.score
    shorter = shrinks(state.bootstrap, tuned, score)
    return shorter and predicts_better_among(state.bootstrap, score, tuned, tried)


def _likeliest_site(state: SearchState, found: Sequence[FreeFormFit]) -> str | None:
    """The site of what foretells most of all that was tried, whether or not it may be named: a law that passes no test
    and a disturbance that no law describes act where something is missing. Where one channel alone is off, that
    channel's own, unless something else is likely, and foretells more for certain than any likely reading of it.
    """
    judged = [one for taken in state.steps[:1] for one in taken.candidates]
    tried = [_Tried(one.effect.site, one.fitted.score) for one in judged if _in_one_unit(state, one.fitted)]
    tried += [_Tried(rival.site, rival.score, rival.sensor_channel) for rival in found]
    likely = _likely(state, tried)
    best = min(likely or _with_less_left(state, tried) or tried, key=_surprise, default=None)
    model, left = state.calibrated.problem.model, state.calibrated_adequacy
    off = left.channels_above or left.channels_structured
    if len(off) == 1 and isinstance(model, HasFreeForms):
        reading = min((one for one in likely if one.reading == off[0]), key=_surprise, default=None)
        if not likely or best is None:
            return model.sensor_site(off[0])
        if reading is not None and not _more_for_certain(state, best.score, reading.score, len(tried)):
            return model.sensor_site(off[0])
    return None if best is None else best.site


@dataclass(frozen=True)
class _Tried:
    """A law or a disturbance that was held out; reading: the channel whose reading alone would be off."""

    site: str
    score: HeldOutScore
    reading: str | None = None


def _surprise(one: _Tried) -> float:
    return one.score.held_out_deviance


def _likely(state: SearchState, tried: Sequence[_Tried]) -> list[_Tried]:
    """Those of which one explains what is left for certain; where none does, those with which the gap shrinks for
    certain, and than which re-tuning alone foretells no more for certain: a discrepancy forgives what is slow.
    """
    certain = [one for one in tried if _explains(state, one.score, len(tried))]
    tuned = state.calibrated.score
    return certain or [
        one for one in tried
        if not predicts_better(state.bootstrap, tuned, one.score) and shrinks(state.bootstrap, tuned, one.score)
    ]  # fmt: skip


def _with_less_left(state: SearchState, tried: Sequence[_Tried]) -> list[_Tried]:
    """Those that foretell more on the whole and with which the gap is smaller: what foretells most while the gap grows
    describes what remains, and is no cause of it.
    """
    tuned = state.calibrated.score
    return [one for one in tried if one.score.held_out_deviance < tuned.held_out_deviance and one.score.gap < tuned.gap]


def _more_for_certain(state: SearchState, one: HeldOutScore, other: HeldOutScore, tried: int) -> bool:
    """Whether one of so many that were tried foretells more than the other for certain, or as much and leaves less of
    the gap for certain: a discrepancy forgives what is slow, the gap does not.
    """
    if predicts_better_among(state.bootstrap, one, other, tried):
        return True
    less = resampled_squared_gaps(state.bootstrap, other) - resampled_squared_gaps(state.bootstrap, one)
    return one.held_out_deviance <= other.held_out_deviance and float(np.quantile(less, LEVEL / tried)) > 0.0


def _in_one_unit(state: SearchState, explained: FittedModel) -> bool:
    """Whether an explanation was scored in the noise that the state has now: densities compare in no other."""
    now, then = (one.problem.pieces for one in (state.calibrated, explained))
    return all(mine.noise == other.noise for mine, other in zip(now, then, strict=True))
