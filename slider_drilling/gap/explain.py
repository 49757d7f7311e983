"""The one door: from a model and its logs to an answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
from scipy.stats import chi2

from slider_drilling.gap.answer.next_run import NextManoeuvre, next_manoeuvre
from slider_drilling.gap.answer.sentence import sentence
from slider_drilling.gap.answer.where import Where, locate
from slider_drilling.gap.choice.forward import begin, step
from slider_drilling.gap.choice.state import Explained, Judged, State
from slider_drilling.gap.evidence.compare import LEVEL, beats, closed_between
from slider_drilling.gap.evidence.rivals import Rival, rivals
from slider_drilling.gap.model import Disturbed, Effect, Model, Together, Values
from slider_drilling.gap.problem.noise import NoiseFloor, noise_floor

Report = Callable[[str, float], None]

# Standard deviations of what rigs are off by, from which a re-tuned parameter is told.
_FAR_OFF = 2.5
# Of what the named laws gain: a disturbance that gains less when it is fitted does not get there by finishing.
_HALF_WAY = 0.5


@dataclass(frozen=True)
class Answer:
    """What the engine concludes; gaps are E, not E^2, held out where parameters were fitted.

    verdict: none, parameters, effect, effect_and_unknown or unknown; closed, interval: the share of the re-tuned gap
    that all named effects close, NaN without a name; rival: the flexible disturbance that foretells most, where
    something structured remains.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    closed: float
    interval: tuple[float, float]
    where: Where | None
    rival: Rival | None
    manoeuvre: NextManoeuvre | None
    remarks: tuple[str, ...]
    runtime: float
    state: State = field(repr=False)

    @property
    def nominal(self) -> float:
        return self.state.nominal.gap

    @property
    def tuned(self) -> float:
        return self.state.tuned.score.gap

    @property
    def with_effect(self) -> float:
        return self.state.current.score.gap if self.effects else float("nan")

    @property
    def threshold(self) -> float:
        """E that the final model would leave of its own replicates, 99 times of a hundred."""
        return self.state.enough.threshold

    @property
    def parameters(self) -> dict[str, float]:
        """Everything that was fitted in the final model, by name."""
        return dict(self.state.current.fit.values)

    @property
    def sentence(self) -> str:
        """The verdict with its figures."""
        gaps = (self.nominal, self.tuned, self.with_effect, self.threshold)
        told = tuple(
            name + (f" (or {' or '.join(self.groups[name])}: not told apart)" if self.groups[name] else "")
            for name in self.effects
        )
        alike = self.rival.words if self.rival is not None else ""
        return sentence(self.verdict, told, self.site, gaps, self.closed, self.interval, alike)

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """By accepted effect, those that cannot be told from it and that are not named besides."""
        return self.state.groups

    @property
    def judged(self) -> tuple[Judged, ...]:
        """Every finalist of every step: accepted ones first, then by what they foretell."""
        accepted = [one.accepted for one in self.state.steps if one.accepted is not None]
        seen, kept = {one.effect.name for one in accepted}, []
        for one in chain.from_iterable(taken.judged for taken in self.state.steps):
            if one.effect.name not in seen:
                seen.add(one.effect.name)
                kept.append(one)
        return (*accepted, *kept)


def explain(
    model: Model,
    *,
    seed: int = 0,
    starts: Sequence[Values] = ({},),
    effects: Sequence[Effect] | None = None,
    floors: Sequence[dict[str, NoiseFloor]] | None = None,
    progress: Report = lambda stage, share: None,
) -> Answer:
    """Diagnose a model against the runs it carries.

    starts: nuisance values to begin tuning from; effects: candidates, the model's catalogue by default; floors: noise
    per run and channel where the caller knows it better than the log; progress(stage, share done). An interrupt after
    re-tuning gives the answer so far, marked partial. Raises ValueError when no channel can be used.
    """
    began = time.perf_counter()
    candidates = list(model.effects if effects is None else effects)
    if floors is None:
        floors = [{channel.name: noise_floor(channel) for channel in run.channels} for run in model.runs]
    state = begin(model, candidates, floors, starts, seed, progress)
    try:
        while not state.done:
            state = step(state, candidates, _together(model, candidates), seed, progress)
    except KeyboardInterrupt:
        state = replace(state, partial=True)
    return conclude(state, began)


def conclude(state: State, began: float) -> Answer:
    """The answer that the state supports; began: when, by the performance counter."""
    named = state.current.names
    adequate = state.enough.adequate
    found = [] if state.partial or (adequate and not named) else rivals(state.tuned, state.blocks.folds, _worth(state))
    rival = stronger = _stronger(state, found) if named else None
    if rival is None and not adequate and found and beats(state.blocks, found[0].score, state.tuned.score, len(found)):
        rival = found[0]
    if stronger is not None:
        named, state = (), replace(state, current=state.tuned, enough=state.tuned_enough)
    enough = state.enough.adequate
    if state.enough.within and not enough:
        enough = not (_foretold(state) if named else rival is not None)
    if named and enough:
        rival = _as_good(state, found)
    if named:
        verdict = "effect" if enough and rival is None else "effect_and_unknown"
    elif enough and stronger is None:
        verdict = "none" if state.nominal_enough else "parameters"
    else:
        verdict = "unknown"
    closed, interval = _closed(state) if named else (float("nan"), (float("nan"), float("nan")))
    where = locate(state.tuned)
    site = state.current.effects[0].site if named else None
    if verdict == "unknown":
        site = _likeliest_site(state, found)
    manoeuvre = None if state.partial else next_manoeuvre(state)
    return Answer(
        verdict, site, named, closed, interval, where, rival, manoeuvre, _remarks(state), time.perf_counter() - began,
        state,
    )  # fmt: skip


def _worth(state: State) -> float:
    """What a disturbance has to gain of ``-2 log p`` before it is worth finishing: half of what the named laws do."""
    return _HALF_WAY * (state.tuned.fit.cost - state.current.fit.cost)


def _stronger(state: State, found: Sequence[Rival]) -> Rival | None:
    """The disturbance that foretells most, if it foretells more than the laws that are named.

    Where those leave nothing, one that is a law's own free form only says that the cause is not quite the catalogue's;
    any other says that it is another.
    """
    named = state.current.effects if state.enough.adequate else ()
    for rival in found:
        free = any(rival.frees(effect) for effect in named)
        if not free and beats(state.blocks, rival.score, state.current.score, len(found)):
            return rival
    return None


def _as_good(state: State, found: Sequence[Rival]) -> Rival | None:
    """The disturbance that foretells most of those at other sites that the named laws do not beat, or by next to
    nothing: the log does not tell whether the cause is a law's or something there.
    """
    named = {effect.site for effect in state.current.effects}
    others = [rival for rival in found if rival.site not in named]
    mine = float(np.sum(state.current.score.density))
    least = float(chi2.ppf(1.0 - LEVEL / max(len(others), 1), 1))

    def beaten(rival: Rival) -> bool:
        certain = beats(state.blocks, state.current.score, rival.score, len(others))
        return certain and float(np.sum(rival.score.density)) - mine > least

    return next((rival for rival in others if not beaten(rival)), None)


def _foretold(state: State) -> bool:
    """Whether any flexible disturbance foretells more of what the final model leaves: if none does, what is left within
    its limits is noise with a colour, not structure.
    """
    found = rivals(state.current, state.blocks.folds)
    return any(beats(state.blocks, one.score, state.current.score, len(found)) for one in found)


def _closed(state: State) -> tuple[float, tuple[float, float]]:
    """Share of the re-tuned gap that the named effects close, and its 95 % interval."""
    tuned, current = state.tuned, state.current
    return closed_between(state.blocks, tuned.score, current.score)


def _likeliest_site(state: State, found: Sequence[Rival]) -> str | None:
    """The site of what foretells most of all that was tried, whether or not it may be named: a law that passes no test
    and a disturbance that no law describes act where something is missing. Where none of them foretells more for
    certain and one channel alone is off, that channel's own.
    """
    tried = [(one.effect.site, one.explained.score) for taken in state.steps[:1] for one in taken.judged]
    tried += [(rival.site, rival.score) for rival in found]
    certain = [one for one in tried if beats(state.blocks, one[1], state.tuned.score, len(tried))]
    model, left = state.tuned.problem.model, state.tuned_enough
    off = left.beyond or left.structured
    if not certain and len(off) == 1 and isinstance(model, Disturbed):
        return model.site_of(off[0])
    if not tried:
        return None
    return min(certain or tried, key=lambda one: float(np.sum(one[1].density)))[0]


def _together(model: Model, candidates: Sequence[Effect]) -> list[list[Effect]]:
    """Effects that the model says may only show at once: they start together as well as alone."""
    if not isinstance(model, Together) or not model.together:
        return []
    chosen = [effect for effect in candidates if effect.name in model.together]
    return [chosen] if len(chosen) > 1 else []


def _far_off(explained: Explained) -> list[str]:
    """What of the nuisance had to go farther than rigs are commonly off: it may do so in the stead of an effect."""
    said = []
    for parameter in explained.problem.model.nuisance:
        value = explained.fit.values.get(parameter.name, parameter.nominal)
        spreads = abs(value - parameter.nominal) / parameter.spread
        if not parameter.per_run and spreads > _FAR_OFF:
            said.append(
                f"{parameter.name} is tuned to {value:.3g} where the model has {parameter.nominal:.3g}: {spreads:.1f} "
                "times as far off as is common, so that an effect which acts alike may hide in it"
            )
    return said


def _remarks(state: State) -> tuple[str, ...]:
    said = []
    for index, floors in enumerate(state.floors):
        for name, floor in floors.items():
            if floor.excess is not None:
                run = f" in run {index + 1}" if len(state.floors) > 1 else ""
                said.append(
                    f"{name}{run} scatters {floor.excess:.1f} times what its sensor is said to: what is above twice "
                    "the declared noise counts as gap"
                )
    missing = state.current.score.not_refitted
    if missing:
        said.append(f"{missing} of the held-out stretches could not be refitted: there the score is in-sample")
    said += _far_off(state.current)
    if state.current.problem.how.pull > 0.0:
        said.append(
            "judged with the measured torque fed back weakly: a free run of this string loses its phase; E is that of "
            "predictions from the torque measured so far"
        )
    if state.partial:
        said.append("interrupted: not everything was looked at")
    return tuple(said)
