"""The one door: from a model and its logs to an answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from slider_drilling.gap.evidence.compare import gap_closed
from slider_drilling.gap.evidence.free_forms import FreeFormFit
from slider_drilling.gap.model import Effect, HasCoupledEffects, HasObserver, Model, Values
from slider_drilling.gap.problem.noise import NoiseFloor, noise_floor
from slider_drilling.gap.results.breakdown import GapBreakdown, break_down_gap
from slider_drilling.gap.results.next_manoeuvre import RecommendedManoeuvre, recommend_manoeuvre
from slider_drilling.gap.results.sentence import verdict_sentence
from slider_drilling.gap.selection.calibration import NUISANCE_LIMIT
from slider_drilling.gap.selection.forward_selection import add_effect, calibrate
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.state import CandidateResult, SearchState
from slider_drilling.gap.selection.verdict import reach_verdict

Report = Callable[[str, float], None]


@dataclass(frozen=True)
class GapDiagnosis:
    """What the engine concludes; gaps are E, not E^2, held out where parameters were fitted.

    verdict: none, parameters, effect, effect_and_unknown or unknown; closed, interval: the share of the re-tuned gap
    that all named effects close, NaN without a name; rival: the flexible disturbance that explains as much as they do,
    or that the unknown is shaped like; rest: the one that foretells most of what remains beside them.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    closed: float
    closed_interval: tuple[float, float]
    breakdown: GapBreakdown | None
    alternative: FreeFormFit | None
    remainder: FreeFormFit | None
    next_manoeuvre: RecommendedManoeuvre | None
    remarks: tuple[str, ...]
    runtime: float
    state: SearchState = field(repr=False)

    @property
    def gap_nominal(self) -> float:
        return self.state.nominal_score.gap

    @property
    def gap_calibrated(self) -> float:
        return self.state.calibrated.score.gap

    @property
    def gap_with_effects(self) -> float:
        return self.state.current.score.gap if self.effects else float("nan")

    @property
    def null_threshold(self) -> float:
        """E that the final model would leave of its own replicates, 99 times of a hundred."""
        return self.state.adequacy.threshold

    @property
    def simulation_count(self) -> int:
        """How many simulations it took."""
        return self.state.current.problem.counter.count

    @property
    def parameters(self) -> dict[str, float]:
        """Everything that was fitted in the final model, by name."""
        return dict(self.state.current.fit.values)

    @property
    def sentence(self) -> str:
        """The verdict with its figures."""
        gaps = (self.gap_nominal, self.gap_calibrated, self.gap_with_effects, self.null_threshold)
        told = tuple(
            name
            + (
                f" (or {' or '.join(self.indistinguishable[name])}: not told apart)"
                if self.indistinguishable[name]
                else ""
            )
            for name in self.effects
        )
        alike, rest = ("" if one is None else one.description for one in (self.alternative, self.remainder))
        return verdict_sentence(
            self.verdict,
            told,
            self.site,
            gaps,
            self.closed,
            self.closed_interval,
            alike,
            rest,
            self.masked_effects,
            self.misfit_channels,
        )

    @property
    def misfit_channels(self) -> tuple[str, ...]:
        """Channels of which the final model leaves more than noise does, or structure that noise has not."""
        return tuple(dict.fromkeys((*self.state.adequacy.channels_above, *self.state.adequacy.channels_structured)))

    @property
    def masked_effects(self) -> tuple[str, ...]:
        """Laws that a re-tuning which was enough, but went far, may stand for, likeliest first: none closes a gap."""
        return self.state.masked_effects if self.verdict == "parameters" else ()

    @property
    def indistinguishable(self) -> dict[str, tuple[str, ...]]:
        """By accepted effect, those that cannot be told from it and that are not named besides."""
        return self.state.indistinguishable

    @property
    def candidates(self) -> tuple[CandidateResult, ...]:
        """Every finalist of every step: accepted ones first, then by what they foretell."""
        accepted = [one.accepted for one in self.state.steps if one.accepted is not None]
        seen, kept = {one.effect.name for one in accepted}, []
        for one in chain.from_iterable(taken.candidates for taken in self.state.steps):
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
) -> GapDiagnosis:
    """Diagnose a model against the runs it carries.

    starts: nuisance values to begin tuning from; effects: candidates, the model's catalogue by default; floors: noise
    per run and channel where the caller knows it better than the log; progress(stage, share done). An interrupt after
    re-tuning gives the answer so far, marked partial. Raises ValueError when no channel can be used.
    """
    began = time.perf_counter()
    candidates = list(model.effects if effects is None else effects)
    if floors is None:
        floors = [{channel.name: noise_floor(channel) for channel in run.channels} for run in model.runs]
    state = calibrate(model, candidates, floors, starts, seed, progress)
    try:
        while not state.done:
            state = add_effect(state, candidates, _coupled_effects(model, candidates), seed, progress)
    except KeyboardInterrupt:
        state = replace(state, interrupted=True)
    return conclude(state, began)


def conclude(state: SearchState, began: float) -> GapDiagnosis:
    """The answer that the state supports; began: when, by the performance counter."""
    decided = reach_verdict(state)
    state, named = decided.state, decided.effects
    closed, interval = (float("nan"), (float("nan"), float("nan")))
    if named:
        closed, interval = gap_closed(state.bootstrap, state.calibrated.score, state.current.score)
    manoeuvre = None if state.interrupted else recommend_manoeuvre(state)
    return GapDiagnosis(
        decided.verdict, decided.site, named, closed, interval, break_down_gap(state.calibrated),
        decided.alternative, decided.remainder,
        manoeuvre, _remarks(state), time.perf_counter() - began, state,
    )  # fmt: skip


def _coupled_effects(model: Model, candidates: Sequence[Effect]) -> list[list[Effect]]:
    """Effects that the model says may only show at once: they start together as well as alone."""
    if not isinstance(model, HasCoupledEffects) or not model.coupled_effects:
        return []
    chosen = [effect.within_physical_range for effect in candidates if effect.name in model.coupled_effects]
    return [chosen] if len(chosen) > 1 else []


def _remarks(state: SearchState) -> tuple[str, ...]:
    said = []
    for index, floors in enumerate(state.floors):
        for name, floor in floors.items():
            run = f" in run {index + 1}" if len(state.floors) > 1 else ""
            if floor.excess is not None:
                said.append(
                    f"{name}{run} scatters {floor.excess:.1f} times what its sensor is said to: what is above twice "
                    "the declared noise counts as gap"
                )
            if floor.method == "declared" and floor.declared and floor.observed is not None:
                said.append(
                    f"{name}{run} scatters {floor.observed / floor.declared:.2g} times what its sensor is said to: E "
                    "is counted in half of what is said, below which such a sensor would hide a difference; state its "
                    "noise as it is to see smaller ones"
                )
    missing = state.current.score.unrefitted_folds
    if missing:
        said.append(f"{missing} of the held-out stretches could not be refitted: their score is of what was seen")
    for parameter, value, spreads in (
        outside_prior(state.unrestricted.current) if state.unrestricted is not None else ()
    ):
        said.append(
            f"{parameter.name} at {value:.3g} where the model has {parameter.nominal:.3g}, {spreads:.1f} times as far "
            "off as is common, would leave no more than noise either, but the log is likelier with what is named; the "
            f"gap is counted from a re-tuning that stays within {NUISANCE_LIMIT:g} times of what is common"
        )
    said += [
        f"{parameter.name} is tuned to {value:.3g} where the model has {parameter.nominal:.3g}: {spreads:.1f} times as "
        "far off as is common, so that an effect which acts alike may hide in it"
        for parameter, value, spreads in outside_prior(state.current)
    ]
    model = state.current.problem.model
    if state.current.problem.options.observer_gain > 0.0 and isinstance(model, HasObserver):
        fed = model.observed_channel.replace("_", " ")
        said.append(
            f"judged with the measured {fed} fed back weakly, which foretells more: E, and errors told with it, "
            f"are those of predictions from the {fed} measured so far"
        )
    if state.interrupted:
        said.append("interrupted: not everything was looked at")
    return tuple(said)
