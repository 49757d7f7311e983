"""What an attribution has learnt: fits, thresholds, what was accepted, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from slider_drilling.gap.contender import Base, Contender, share_closed
from slider_drilling.gap.held_out import Bootstrap, HeldOut, make_folds
from slider_drilling.gap.model import Array
from slider_drilling.gap.null import Threshold, noise_sample, null_threshold
from slider_drilling.gap.predictability import unsettled
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate


@dataclass
class Findings:
    """Everything the attribution has learnt so far; readable at any time, so an interrupt loses nothing.

    threshold, tuned_threshold: c0 at the current and at the tuned fit; rounds: contenders by round;
    screened: the score test by round; groups: effects that cannot be told from each accepted one, with the reason.
    """

    problem: Problem
    bootstrap: Bootstrap
    nominal_residual: Array
    tuned: Base | None = None
    current: Base | None = None
    threshold: Threshold | None = None
    screened: list[list[Candidate]] = field(default_factory=list)
    rounds: list[list[Contender]] = field(default_factory=list)
    accepted: list[Contender] = field(default_factory=list)
    groups: dict[str, dict[str, str]] = field(default_factory=dict)
    tuned_threshold: Threshold | None = None
    partial: bool = False
    remarks: list[str] = field(default_factory=list)

    def at_floor(self, score: HeldOut) -> bool:
        """Whether a held-out score is what noise alone would leave."""
        assert self.threshold is not None
        return self.threshold.holds(score)

    @property
    def tuned_at_floor(self) -> bool:
        """The same of the tuned model."""
        tuned, threshold = self.tuned, self.tuned_threshold
        return tuned is not None and threshold is not None and threshold.holds(tuned.score)

    @property
    def nothing_left(self) -> bool:
        """Whether the tuned model, all channels together, leaves what noise alone would."""
        tuned, threshold = self.tuned, self.tuned_threshold
        return tuned is not None and threshold is not None and tuned.score.robust <= threshold.robust

    def nominal_in(self, problem: Problem) -> Array:
        """(N,) the nominal model's residual in the floors of another problem."""
        return self.problem.in_floors_of(problem, self.nominal_residual)


def start_findings(problem: Problem, seed: int) -> Findings:
    """The nominal model's residual and the resamples that every later score shares."""
    problem.anchor({})
    residual = problem.residuals([{}])[0]
    return Findings(problem, Bootstrap(problem, make_folds(problem), seed), residual)


def threshold_of(findings: Findings, base: Base, seed: int) -> Threshold:
    """c0 at a fit."""
    problem = base.problem
    error = unsettled(problem, base.fit) / problem.floor
    noise = noise_sample(problem, base.fit.residual)
    return null_threshold(problem, base.fit, findings.bootstrap.folds, noise, error, seed=seed)


def set_threshold(findings: Findings, seed: int) -> None:
    """c0 at the current fit."""
    assert findings.current is not None
    findings.threshold = threshold_of(findings, findings.current, seed)


def total_closed(findings: Findings) -> tuple[float, tuple[float, float]]:
    """Share of the tuned model's gap that the accepted effects close together, with its 95 % interval.

    NaN when the tuned model is at the noise floor already: there is nothing to close a share of.
    """
    tuned, current = findings.tuned, findings.current
    nothing = float("nan"), (float("nan"), float("nan"))
    if tuned is None or current is None or not findings.accepted or findings.tuned_at_floor:
        return nothing
    return share_closed(findings.bootstrap, tuned, current.problem, current.score)


def gaps_before(findings: Findings) -> tuple[float, float]:
    """E of the nominal and of the tuned model (held out), in the floors of the model that the findings end with."""
    tuned, problem = findings.tuned, findings.problem
    if tuned is None or findings.current is None:
        return float(np.sqrt(problem.gap_squared(findings.nominal_residual))), float("nan")
    final = findings.current.problem
    nominal = findings.nominal_in(final)
    before = tuned.problem.in_floors_of(final, tuned.score.residual)
    return float(np.sqrt(final.gap_squared(nominal))), float(np.sqrt(final.gap_squared(before)))


def verdict(findings: Findings) -> str:
    """One of the six verdicts of spec gap.md."""
    tuned, current = findings.tuned, findings.current
    threshold, at_first = findings.threshold, findings.tuned_threshold
    if tuned is None or current is None or threshold is None or at_first is None:
        return "inconclusive"
    if findings.accepted:
        return "effect" if current.score.robust <= threshold.robust else "effect_and_unknown"
    problem = tuned.problem
    loss = problem.robust(findings.nominal_in(problem))[0] ** 2
    if float(problem.weight**2 @ loss) <= at_first.robust and not at_first.above(problem.by_channel(loss)):
        return "none"
    if findings.nothing_left:
        return "parameters"
    if findings.partial or (not tuned.fit.converged and not findings.rounds):
        return "inconclusive"
    return "unknown"
