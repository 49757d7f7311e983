"""The one door: from a model and its logs to an answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from slider_drilling.gap.answer.next_run import NextManoeuvre, next_manoeuvre
from slider_drilling.gap.answer.sentence import sentence
from slider_drilling.gap.answer.where import Where, locate
from slider_drilling.gap.choice.decide import decide
from slider_drilling.gap.choice.forward import begin, step
from slider_drilling.gap.choice.stand_in import far_off
from slider_drilling.gap.choice.state import Judged, State
from slider_drilling.gap.choice.tuning import FAR_OFF
from slider_drilling.gap.evidence.compare import closed_between
from slider_drilling.gap.evidence.rivals import Rival
from slider_drilling.gap.model import Effect, Model, Pulled, Together, Values
from slider_drilling.gap.problem.noise import NoiseFloor, noise_floor

Report = Callable[[str, float], None]


@dataclass(frozen=True)
class Answer:
    """What the engine concludes; gaps are E, not E^2, held out where parameters were fitted.

    verdict: none, parameters, effect, effect_and_unknown or unknown; closed, interval: the share of the re-tuned gap
    that all named effects close, NaN without a name; rival: the flexible disturbance that explains as much as they do,
    or that the unknown is shaped like; rest: the one that foretells most of what remains beside them.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    closed: float
    interval: tuple[float, float]
    where: Where | None
    rival: Rival | None
    rest: Rival | None
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
    def simulations(self) -> int:
        """How many simulations it took."""
        return self.state.current.problem.spent.simulations

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
        alike, rest = ("" if one is None else one.words for one in (self.rival, self.rest))
        return sentence(
            self.verdict, told, self.site, gaps, self.closed, self.interval, alike, rest, self.instead, self.stand_out
        )

    @property
    def stand_out(self) -> tuple[str, ...]:
        """Channels of which the final model leaves more than noise does, or structure that noise has not."""
        return tuple(dict.fromkeys((*self.state.enough.beyond, *self.state.enough.structured)))

    @property
    def instead(self) -> tuple[str, ...]:
        """Laws that a re-tuning which was enough, but went far, may stand for, likeliest first: none closes a gap."""
        return self.state.instead if self.verdict == "parameters" else ()

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
    decided = decide(state)
    state, named = decided.state, decided.named
    closed, interval = (float("nan"), (float("nan"), float("nan")))
    if named:
        closed, interval = closed_between(state.blocks, state.tuned.score, state.current.score)
    manoeuvre = None if state.partial else next_manoeuvre(state)
    return Answer(
        decided.verdict, decided.site, named, closed, interval, locate(state.tuned), decided.rival, decided.rest,
        manoeuvre, _remarks(state), time.perf_counter() - began, state,
    )  # fmt: skip


def _together(model: Model, candidates: Sequence[Effect]) -> list[list[Effect]]:
    """Effects that the model says may only show at once: they start together as well as alone."""
    if not isinstance(model, Together) or not model.together:
        return []
    chosen = [effect.as_named for effect in candidates if effect.name in model.together]
    return [chosen] if len(chosen) > 1 else []


def _remarks(state: State) -> tuple[str, ...]:
    said = []
    for index, floors in enumerate(state.floors):
        for name, floor in floors.items():
            run = f" in run {index + 1}" if len(state.floors) > 1 else ""
            if floor.excess is not None:
                said.append(
                    f"{name}{run} scatters {floor.excess:.1f} times what its sensor is said to: what is above twice "
                    "the declared noise counts as gap"
                )
            if floor.method == "declared" and floor.declared and floor.seen is not None:
                said.append(
                    f"{name}{run} scatters {floor.seen / floor.declared:.2g} times what its sensor is said to: E is "
                    "counted in half of what is said, below which such a sensor would hide a difference; state its "
                    "noise as it is to see smaller ones"
                )
    missing = state.current.score.not_refitted
    if missing:
        said.append(f"{missing} of the held-out stretches could not be refitted: their score is of what was seen")
    for parameter, value, spreads in far_off(state.far.current) if state.far is not None else ():
        said.append(
            f"{parameter.name} at {value:.3g} where the model has {parameter.nominal:.3g}, {spreads:.1f} times as far "
            "off as is common, would leave no more than noise either, but the log is likelier with what is named; the "
            f"gap is counted from a re-tuning that stays within {FAR_OFF:g} times of what is common"
        )
    said += [
        f"{parameter.name} is tuned to {value:.3g} where the model has {parameter.nominal:.3g}: {spreads:.1f} times as "
        "far off as is common, so that an effect which acts alike may hide in it"
        for parameter, value, spreads in far_off(state.current)
    ]
    model = state.current.problem.model
    if state.current.problem.how.pull > 0.0 and isinstance(model, Pulled):
        fed = model.pulled.replace("_", " ")
        said.append(
            f"judged with the measured {fed} fed back weakly, which foretells more: E, and errors told with it, "
            f"are those of predictions from the {fed} measured so far"
        )
    if state.partial:
        said.append("interrupted: not everything was looked at")
    return tuple(said)
