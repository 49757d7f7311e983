"""Which effect: re-tune, screen, fit, accept one at a time, try to remove each, and say what that proves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.contender import (
    Base,
    Contender,
    fit_candidate,
    indistinguishable,
    judge,
    make_base,
    share_closed,
)  # fmt: skip
from slider_drilling.gap.fit import Fit, fit
from slider_drilling.gap.held_out import Bootstrap, Folds, HeldOut, make_folds
from slider_drilling.gap.model import Anchored, Array, Effect, Parameter, Values
from slider_drilling.gap.null import Threshold, noise_sample, null_threshold
from slider_drilling.gap.predictability import foresee
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate, screen
from slider_drilling.gap.survivors import chosen, favoured
from slider_drilling.gap.together import add_together
from slider_drilling.gap.tune import GROWTH, fit_growing, scattered, sharpen

MAX_EFFECTS = 3
SCATTER_KEPT = 3
# A tuning is better when its cost falls by more than fits from different starts scatter.
_BETTER = 0.98
_MUCH_BETTER = 0.8
# Once one candidate explains the log down to its noise, only so many are fitted in all: it and its rivals.
ENOUGH = 3
# So many of the best are taken to the end before one is preferred to another.
POLISHED = 2
Progress = Callable[[str, float], None]


@dataclass
class Findings:
    """Everything the attribution has learnt so far; readable at any time, so an interrupt loses nothing.

    threshold, tuned_threshold: c0 at the current and at the tuned fit; rounds: contenders by round;
    screened: the score test by round; groups: effects that cannot be told from each accepted one, with the reason.
    """

    problem: Problem
    folds: Folds
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


def start_findings(problem: Problem, seed: int) -> Findings:
    """The nominal model's residual and the resamples that every later score shares."""
    folds = make_folds(problem)
    problem.anchor({})
    residual = problem.residuals([{}])[0]
    return Findings(problem, folds, Bootstrap(problem, folds, seed), residual)


def attribute(
    findings: Findings,
    *,
    seed: int = 0,
    starts: Sequence[Values] = ({},),
    effects: Sequence[Effect] | None = None,
    scatter: int = 0,
    progress: Progress = lambda stage, share: None,
) -> Findings:
    """Run the attribution; findings are filled in place and returned.

    starts: nuisance values to tune from; scatter: so many points, spread evenly, are tried besides, in tuning and for
    every candidate. KeyboardInterrupt ends it early with
    ``partial`` set.
    """
    try:
        tune_nuisance(findings, starts, progress, scatter)
        _set_threshold(findings, seed)
        findings.tuned_threshold = findings.threshold
        catalogue = list(findings.problem.model.effects if effects is None else effects)
        if scatter and add_together(findings, catalogue, seed, progress):
            _set_threshold(findings, seed)
            catalogue = []
        for turn in range(MAX_EFFECTS):
            assert findings.current is not None
            if findings.at_floor(findings.current.score) or not catalogue:
                break
            if not _add_one(findings, catalogue, turn, scatter, progress):
                break
            _set_threshold(findings, seed)
            if len(findings.accepted) > 1:
                _try_removing(findings, seed)
    except KeyboardInterrupt:
        findings.partial = True
        findings.remarks.append("interrupted: the best answer so far")
    if findings.tuned is not None and _worse_than_nominal(findings, findings.tuned):
        findings.remarks.append("re-tuning did not lower the gap: the nominal parameters are as good")
    if findings.current is not None and findings.threshold is not None:
        above = findings.threshold.above(findings.current.score.by_channel)
        if above and findings.current.score.robust <= findings.threshold.robust:
            findings.remarks.append(f"within the null threshold as a whole, but not by itself: {', '.join(above)}")
    progress("done", 1.0)
    return findings


def tune_nuisance(
    findings: Findings, starts: Sequence[Values], progress: Progress, scatter: int = 0, thorough: bool = True
) -> None:
    """Re-fit the nuisance from every start, over a growing part of the runs, and anchor the model there.

    thorough: with a search besides least squares.
    """
    problem = findings.problem
    parameters = problem.free(problem.model.nuisance)
    starts = [*starts, *scattered(problem, parameters, {}, scatter, SCATTER_KEPT)]
    fits: list[Fit] = []
    for index, start in enumerate(starts):
        progress("re-tuning", 0.02 + 0.1 * index / len(starts))
        fits.append(fit_growing(problem, parameters, start, shares=GROWTH[:1]))
    best = min(fits, key=lambda result: result.cost)
    progress("re-tuning", 0.12)
    shaken = GROWTH[2:] if thorough else ()
    best = fit_growing(problem, parameters, best.values, iterations=8, shares=GROWTH[1:], shaken=shaken)
    if thorough and not scatter:
        problem, best = settle(problem, best)
    findings.tuned = make_base(problem, findings.folds, findings.bootstrap, best)
    findings.current = findings.tuned


def _add_one(
    findings: Findings, catalogue: Sequence[Effect], turn: int, scatter: int, progress: Progress, restarts: int = 1
) -> bool:
    """Screen everything not yet accepted, fit the survivors, accept the best that passes. False when none does.

    Where a candidate's fit turns up a much better tuning, the screening was done at the wrong place and starts again.
    """
    base = findings.current
    assert base is not None
    problem = base.problem
    names = {contender.effect.name for contender in findings.accepted}
    begin = 0.18 + 0.27 * turn
    progress("screening", begin)
    candidates = screen(problem, base.fit, [effect for effect in catalogue if effect.name not in names])
    findings.screened.append(candidates)
    contenders: list[Contender] = []
    findings.rounds.append(contenders)
    survivors = chosen(base, candidates)
    thorough = favoured(base, survivors)
    for index, candidate in enumerate(survivors):
        progress(f"fitting {candidate.effect.name}", begin + 0.03 + 0.24 * index / len(survivors))
        problem.anchor(base.fit.values)
        own, best, agree = fit_candidate(base, candidate, scatter=scatter, thorough=candidate in thorough)
        better = _retuned(base, best)
        if better is not None:
            much = better.cost < _MUCH_BETTER * base.fit.cost
            base = _rebase(findings, better, turn)
            if much and restarts > 0 and not findings.at_floor(base.score):
                findings.screened.pop()
                findings.rounds.pop()
                return _add_one(findings, catalogue, turn, scatter, progress, restarts - 1)
            problem = base.problem
            contenders[:] = [_again(findings, base, contender, len(catalogue)) for contender in contenders]
        own.anchor(best.values)
        contenders.append(
            judge(own, findings.folds, findings.bootstrap, base, candidate.effect, best, agree, len(catalogue))
        )
        if findings.at_floor(base.score):
            return False
        done = any(c.accepted and findings.at_floor(c.score) for c in contenders)
        if done and len(contenders) >= ENOUGH:
            break
    contenders.sort(key=lambda contender: contender.score.surprise)
    for index, contender in enumerate(contenders[:POLISHED]):
        own, fine = settle(contender.problem, contender.fit)
        contenders[index] = _again(findings, base, replace(contender, problem=own, fit=fine), len(catalogue))
    contenders.sort(key=lambda contender: contender.score.surprise)
    winner = next((contender for contender in contenders if contender.accepted), None)
    if winner is None:
        return False
    better = _retuned(base, winner.fit, shaken=GROWTH[2:])
    if better is not None:
        base = _rebase(findings, better, turn)
        contenders[:] = [_again(findings, base, contender, len(catalogue)) for contender in contenders]
        winner = next((contender for contender in contenders if contender.accepted), None)
        if winner is None or findings.at_floor(base.score):
            return False
    findings.groups[winner.effect.name] = _group(base, winner, contenders)
    findings.accepted.append(winner)
    sharper = sharpen(winner.problem, winner.fit)
    findings.current = make_base(winner.problem, findings.folds, findings.bootstrap, sharper)
    return True


def settle(problem: Problem, found: Fit) -> tuple[Problem, Fit]:
    """The problem in a fit's own floors, and the fit once more in them."""
    own = foresee(problem, found)
    return own, fit_growing(own, found.parameters, found.values, iterations=6, shares=(1.0,))


def _again(findings: Findings, base: Base, contender: Contender, candidates: int) -> Contender:
    """A contender judged against another base, or once more."""
    contender.problem.anchor(contender.fit.values)
    return judge(
        contender.problem, findings.folds, findings.bootstrap, base, contender.effect, contender.fit,
        contender.starts_agree, candidates,
    )  # fmt: skip


def _retuned(base: Base, other: Fit, shaken: Sequence[float] = ()) -> Fit | None:
    """A better fit without the candidate, from where the candidate's fit left the rest; None when there is none.

    A candidate must not win because its search found a better tuning that needs no effect at all; shaken: so that this
    one is searched for as the candidate was.
    """
    again = fit_growing(
        base.problem, base.fit.parameters, _only(other.values, base.fit), iterations=6, shares=(1.0,), shaken=shaken
    )
    return again if again.cost < _BETTER * base.fit.cost else None


def _only(values: Values, fitted: Fit) -> dict[str, float]:
    return {name: values[name] for name in fitted.values}


def _rebase(findings: Findings, better: Fit, turn: int) -> Base:
    """Put a better tuning in the place of the one that everything was compared with."""
    own, polished = settle(findings.problem, better)
    findings.current = make_base(own, findings.folds, findings.bootstrap, polished)
    if turn == 0:
        findings.tuned = findings.current
    return findings.current


def _group(base: Base, winner: Contender, contenders: Sequence[Contender]) -> dict[str, str]:
    group = {}
    for other in contenders:
        if other is winner or not other.physical or other.gain_bound <= 0.0:
            continue
        why = indistinguishable(base, winner, other)
        if why is not None:
            group[other.effect.name] = why
    return group


def _try_removing(findings: Findings, seed: int) -> None:
    """Refit without each earlier effect; one that held-out data does not miss goes."""
    current = findings.current
    assert current is not None
    for contender in list(findings.accepted[:-1]):
        own = {parameter.name for parameter in contender.effect.parameters}
        parameters: list[Parameter] = [p for p in current.fit.parameters if p.name not in own]
        start = {name: value for name, value in current.fit.values.items() if name not in own}
        problem, found = settle(current.problem, fit(current.problem, parameters, start, iterations=6))
        without = make_base(problem, findings.folds, findings.bootstrap, found)
        missed = without.score.surprise_resampled - current.score.surprise_resampled
        if float(np.quantile(missed, 0.05)) > 0.0 and without.score.surprise > current.score.surprise:
            continue
        findings.accepted.remove(contender)
        findings.remarks.append(f"{contender.effect.name} was accepted first and is not needed any more")
        findings.current = current = without
        _set_threshold(findings, seed)


def _set_threshold(findings: Findings, seed: int) -> None:
    """c0 at the current fit."""
    base = findings.current
    assert base is not None
    problem = base.problem
    error = np.zeros(problem.time.size)
    if isinstance(problem.model, Anchored):
        runs = range(len(problem.model.runs))
        differences = problem.model.discretisation([problem.set_of(base.fit.values, run) for run in runs])
        for (run, name), part in problem.slices.items():
            error[part] = differences[run][name] / problem.floor[part]
    noise = noise_sample(problem, base.fit.residual)
    findings.threshold = null_threshold(problem, base.fit, findings.folds, noise, error, seed=seed)


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
    nominal = problem.in_floors_of(final, findings.nominal_residual)
    before = tuned.problem.in_floors_of(final, tuned.score.residual)
    return float(np.sqrt(final.gap_squared(nominal))), float(np.sqrt(final.gap_squared(before)))


def _worse_than_nominal(findings: Findings, tuned: Base) -> bool:
    nominal = findings.problem.in_floors_of(tuned.problem, findings.nominal_residual)
    return tuned.problem.gap_squared(tuned.fit.residual) > tuned.problem.gap_squared(nominal)


def verdict(findings: Findings) -> str:
    """One of the six verdicts of spec gap.md."""
    tuned, current = findings.tuned, findings.current
    threshold, at_first = findings.threshold, findings.tuned_threshold
    if tuned is None or current is None or threshold is None or at_first is None:
        return "inconclusive"
    if findings.accepted:
        return "effect" if current.score.robust <= threshold.robust else "effect_and_unknown"
    problem = tuned.problem
    loss = problem.robust(findings.problem.in_floors_of(problem, findings.nominal_residual))[0] ** 2
    if float(problem.weight**2 @ loss) <= at_first.robust and not at_first.above(problem.by_channel(loss)):
        return "none"
    if tuned.score.robust <= at_first.robust:
        return "parameters"
    if findings.partial or (not tuned.fit.converged and not findings.rounds):
        return "inconclusive"
    return "unknown"
