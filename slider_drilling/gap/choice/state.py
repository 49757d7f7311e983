"""What is known after each step of the attribution; nothing here is ever changed in place."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from slider_drilling.gap.evidence.adequacy import Adequacy
from slider_drilling.gap.evidence.blocks import Blocks
from slider_drilling.gap.evidence.score import Score, held_out_runs
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit


@dataclass(frozen=True)
class Explained:
    """A set of effects with its fit and its score; problem: corrected to finer simulations at the fit."""

    effects: tuple[Effect, ...]
    problem: Problem = field(repr=False)
    fit: Fit = field(repr=False)
    score: Score = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    @cached_property
    def across_runs(self) -> Score:
        """The score of each run by a fit to the others; it takes refits, and is made when it is first asked for."""
        return held_out_runs(self.problem, self.fit)


@dataclass(frozen=True)
class Judged:
    """A finalist of one step: what the newest effect closes of the gap before it, and which tests it did not pass.

    closed, interval: share of E^2 - 1, held out, NaN where there was nothing to close; why_not: empty if it passed;
    beside: names of the effects that left that gap; in_other_runs: likewise, of each run by a fit to the others, None
    of a single run, and of who failed before.
    """

    effect: Effect
    explained: Explained
    closed: float
    interval: tuple[float, float]
    why_not: tuple[str, ...]
    beside: tuple[str, ...] = ()
    in_other_runs: tuple[float, tuple[float, float]] | None = None

    @property
    def passed(self) -> bool:
        return not self.why_not


@dataclass(frozen=True)
class Step:
    """One step forward: the finalists, most likely on unseen data first; who was accepted, and who cannot be told from
    it; promised: what every candidate's scan promised, ``-2 log p``, before any fit.
    """

    judged: tuple[Judged, ...]
    accepted: Judged | None
    group: tuple[str, ...]
    promised: dict[str, float]


@dataclass(frozen=True)
class State:
    """nominal: score as given; tuned: re-tuned only; current: with the effects accepted so far; enough:
    adequacy of the current; ways: problems that fits may be made in, the free one first; step: those taken; instead:
    laws, likeliest first, that make the log likelier than a re-tuning that was enough, but went far; far: the state of
    such a re-tuning, where the names hold against one that is kept near; partial: interrupted before the end.
    """

    floors: tuple[dict[str, NoiseFloor], ...]
    ways: tuple[Problem, ...] = field(repr=False)
    nominal: Score
    tuned: Explained
    current: Explained
    enough: Adequacy
    tuned_enough: Adequacy
    nominal_enough: bool
    blocks: Blocks = field(repr=False)
    steps: tuple[Step, ...] = ()
    instead: tuple[str, ...] = ()
    far: State | None = None
    done: bool = False
    partial: bool = False

    @property
    def way(self) -> Problem:
        """The problem of the way in which the current is scored."""
        return next(way for way in self.ways if way.how.pull == self.current.problem.how.pull)

    @property
    def open_ways(self) -> list[int]:
        """Which of the ways a race runs in: every one; once something was found, that in which it was scored."""
        pull = self.current.problem.how.pull
        return [index for index, way in enumerate(self.ways) if not self.current.effects or way.how.pull == pull]

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """By effect in the answer or accepted, those that cannot be told from it and are not in the answer besides; of
        several that came at once, those of the last.
        """
        return dict.fromkeys(self.current.names, ()) | {
            one.accepted.effect.name: tuple(name for name in one.group if name not in self.current.names)
            for one in self.steps if one.accepted is not None
        }  # fmt: skip
