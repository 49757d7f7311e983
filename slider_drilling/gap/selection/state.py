"""What is known after each step of the attribution; nothing here is ever changed in place."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from slider_drilling.gap.evidence.adequacy import Adequacy
from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap
from slider_drilling.gap.evidence.score import HeldOutScore, score_left_out_runs
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit


@dataclass(frozen=True)
class FittedModel:
    """A set of effects with its fit and its score; problem: corrected to finer simulations at the fit."""

    effects: tuple[Effect, ...]
    problem: Problem = field(repr=False)
    fit: Fit = field(repr=False)
    score: HeldOutScore = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    @cached_property
    def cross_run_score(self) -> HeldOutScore:
        """The score of each run by a fit to the others; it takes refits, and is made when it is first asked for."""
        return score_left_out_runs(self.problem, self.fit)


@dataclass(frozen=True)
class CandidateResult:
    """A finalist of one step: what the newest effect closes of the gap before it, and which tests it did not pass.

    closed, interval: share of E^2 - 1, held out, NaN where there was nothing to close; why_not: empty if it passed;
    beside: names of the effects that left that gap; in_other_runs: likewise, of each run by a fit to the others, None
    of a single run, and of who failed before.
    """

    effect: Effect
    fitted: FittedModel
    closed: float
    interval: tuple[float, float]
    failures: tuple[str, ...]
    beside: tuple[str, ...] = ()
    closed_in_other_runs: tuple[float, tuple[float, float]] | None = None

    @property
    def passed(self) -> bool:
        return not self.failures


@dataclass(frozen=True)
class SelectionStep:
    """One step forward: the finalists, most likely on unseen data first; who was accepted, and who cannot be told from
    it; promised: what every candidate's scan promised, ``-2 log p``, before any fit.
    """

    candidates: tuple[CandidateResult, ...]
    accepted: CandidateResult | None
    indistinguishable: tuple[str, ...]
    predicted_gain: dict[str, float]


@dataclass(frozen=True)
class SearchState:
    """nominal: score as given; tuned: re-tuned only; current: with the effects accepted so far; enough:
    adequacy of the current; ways: problems that fits may be made in, the free one first; step: those taken; instead:
    laws, likeliest first, that make the log likelier than a re-tuning that was enough, but went far; far: the state of
    such a re-tuning, where the names hold against one that is kept near; partial: interrupted before the end.
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
    done: bool = False
    interrupted: bool = False

    @property
    def current_mode(self) -> Problem:
        """The problem of the way in which the current is scored."""
        return next(
            way for way in self.modes if way.options.observer_gain == self.current.problem.options.observer_gain
        )

    @property
    def active_modes(self) -> list[int]:
        """Which of the ways a race runs in: every one; once something was found, that in which it was scored."""
        pull = self.current.problem.options.observer_gain
        return [
            index
            for index, way in enumerate(self.modes)
            if not self.current.effects or way.options.observer_gain == pull
        ]

    @property
    def indistinguishable(self) -> dict[str, tuple[str, ...]]:
        """By effect in the answer or accepted, those that cannot be told from it and are not in the answer besides; of
        several that came at once, those of the last.
        """
        return dict.fromkeys(self.current.names, ()) | {
            one.accepted.effect.name: tuple(name for name in one.indistinguishable if name not in self.current.names)
            for one in self.steps if one.accepted is not None
        }  # fmt: skip
