"""What the search knows after each step. Nothing here is ever changed in place."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from slider_drilling.gap.evidence.adequacy import Adequacy
from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap
from slider_drilling.gap.evidence.score import HeldOutScore, score_left_out_runs
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.results.intervals import intervals_beside_all_nuisance
from slider_drilling.gap.search.least_squares import Fit


@dataclass(frozen=True)
class FittedModel:
    """A set of effects, fitted together with the nuisance and cross-validated.

    Attributes:
        effects: Effects in the model; empty for calibration alone.
        problem: The problem it was fitted in, corrected to finer simulations at the fit.
        fit: The fit over the whole log.
        score: The cross-validated score.
    """

    effects: tuple[Effect, ...]
    problem: Problem = field(repr=False)
    fit: Fit = field(repr=False)
    score: HeldOutScore = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(effect.name for effect in self.effects)

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each freed parameter in an answer. It takes simulations, and is computed on first use."""
        return intervals_beside_all_nuisance(self.problem, self.fit)

    @cached_property
    def cross_run_score(self) -> HeldOutScore:
        """The score of each run under a fit to the others. It takes refits, and is computed on first use."""
        return score_left_out_runs(self.problem, self.fit)


@dataclass(frozen=True)
class CandidateResult:
    """What became of one finalist of a step.

    Attributes:
        effect: The newest effect of the candidate.
        fitted: The model with it.
        closed: Share of the gap before it that it closes, held out; NaN where there was no gap.
        interval: 95 % interval of ``closed``.
        failures: Messages of the naming criteria that it failed, empty if it passed.
        beside: Names of the effects that were in the model before.
        closed_in_other_runs: Share and interval of the gap of each run under a fit to the others; None for a single run
            and for a candidate that failed before.
        too_small: Whether it failed criteria of size alone: the evidence is there, and it is suspected.
    """

    effect: Effect
    fitted: FittedModel
    closed: float
    interval: tuple[float, float]
    failures: tuple[str, ...]
    beside: tuple[str, ...] = ()
    closed_in_other_runs: tuple[float, tuple[float, float]] | None = None
    too_small: bool = False

    @property
    def passed(self) -> bool:
        """Whether it passed every naming criterion."""
        return not self.failures


@dataclass(frozen=True)
class SelectionStep:
    """One step of forward selection.

    Attributes:
        candidates: The finalists, best held-out prediction first.
        accepted: The one that was accepted, None if none was.
        indistinguishable: Names of finalists that the log cannot distinguish from the accepted one.
        predicted_gain: Gain of ``-2 log p`` that the screen predicted of every effect, before any fit.
    """

    candidates: tuple[CandidateResult, ...]
    accepted: CandidateResult | None
    indistinguishable: tuple[str, ...]
    predicted_gain: dict[str, float]


@dataclass(frozen=True)
class SearchState:
    """Everything that one step of the search hands to the next, grouped by life cycle.

    Attributes:
        floors: *Fixed by calibration; replaced only where a better model shows lower noise.* Noise floors by run and
            channel.
        modes: Problems that fits may be made in, one per simulation mode: the free run, then the run with an observer.
        bootstrap: Resamples for every comparison.
        nominal_score: *Calibration.* Score of the model as given.
        nominal_adequate: Whether the model as given leaves only noise.
        calibrated: The model with nuisance alone.
        calibrated_adequacy: Whether calibration alone is enough.
        unrestricted: Where the nuisance went far: the state of the calibration that was free to do so. The names in
            this state hold against a calibration that is kept near the model as given.
        current: *Current model, replaced at each step.* The model with the effects accepted so far.
        adequacy: Whether the current model is enough.
        steps: *History.* The steps taken.
        masked_effects: Effects, likeliest first, that make the log likelier than a calibration which was enough but
            needed implausible values.
        missing_nuisance: The model with a nuisance parameter that has to be calibrated before the search goes on.
        done: Whether the search has ended.
        interrupted: Whether it was interrupted before its end.
    """

    floors: tuple[dict[str, NoiseFloor], ...]
    modes: tuple[Problem, ...] = field(repr=False)
    nominal_score: HeldOutScore
    calibrated: FittedModel
    current: FittedModel
    adequacy: Adequacy
    calibrated_adequacy: Adequacy
    nominal_adequate: bool
    bootstrap: BlockBootstrap = field(repr=False)
    steps: tuple[SelectionStep, ...] = ()
    masked_effects: tuple[str, ...] = ()
    unrestricted: SearchState | None = None
    missing_nuisance: FittedModel | None = field(default=None, repr=False)
    done: bool = False
    interrupted: bool = False

    @property
    def current_mode(self) -> Problem:
        """The problem of the simulation mode in which the current model is scored."""
        gain = self.current.problem.options.observer_gain
        return next(mode for mode in self.modes if mode.options.observer_gain == gain)

    @property
    def active_modes(self) -> list[int]:
        """Indices of the modes of a race: all; once an effect was accepted, only that of the current model."""
        gain = self.current.problem.options.observer_gain
        return [
            index for index, mode in enumerate(self.modes)
            if not self.current.effects or mode.options.observer_gain == gain
        ]  # fmt: skip

    @property
    def indistinguishable(self) -> dict[str, tuple[str, ...]]:
        """By effect in the model: effects outside it that the log cannot distinguish from it.

        Of several effects that were accepted in one step, only the last has such a group.
        """
        return dict.fromkeys(self.current.names, ()) | {
            step.accepted.effect.name: tuple(
                name for name in step.indistinguishable if name not in self.current.names
            )
            for step in self.steps if step.accepted is not None
        }  # fmt: skip
