"""Which effect: re-tune, screen, fit, accept one at a time, try to remove each, and say what that proves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.gap.contender import Base, make_base
from slider_drilling.gap.findings import Findings, set_threshold
from slider_drilling.gap.fit import Fit, fit
from slider_drilling.gap.model import Effect, Parameter, Values
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.together import add_together
from slider_drilling.gap.tune import GROWTH, begun_again, fit_growing, scattered, settle
from slider_drilling.gap.turn import add_one

MAX_EFFECTS = 3
SCATTER_KEPT = 3


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
        set_threshold(findings, seed)
        findings.tuned_threshold = findings.threshold
        catalogue = list(findings.problem.model.effects if effects is None else effects)
        if scatter and add_together(findings, catalogue, seed, progress):
            set_threshold(findings, seed)
            catalogue = []
        for turn in range(MAX_EFFECTS):
            assert findings.current is not None
            if findings.at_floor(findings.current.score) or not catalogue:
                break
            if not add_one(findings, catalogue, turn, scatter, progress):
                break
            set_threshold(findings, seed)
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
    best = begun_again(problem, best)
    if thorough and not scatter:
        problem, best = settle(problem, best)
    findings.tuned = make_base(problem, findings.bootstrap, best)
    findings.current = findings.tuned


def _try_removing(findings: Findings, seed: int) -> None:
    """Refit without each earlier effect; one that held-out data does not miss goes."""
    current = findings.current
    assert current is not None
    for contender in list(findings.accepted[:-1]):
        own = {parameter.name for parameter in contender.effect.parameters}
        parameters: list[Parameter] = [p for p in current.fit.parameters if p.name not in own]
        start = {name: value for name, value in current.fit.values.items() if name not in own}
        problem, found = settle(current.problem, fit(current.problem, parameters, start, iterations=6))
        without = make_base(problem, findings.bootstrap, found)
        missed = without.score.surprise_resampled - current.score.surprise_resampled
        if float(np.quantile(missed, 0.05)) > 0.0 and without.score.surprise > current.score.surprise:
            continue
        findings.accepted.remove(contender)
        findings.remarks.append(f"{contender.effect.name} was accepted first and is not needed any more")
        findings.current = current = without
        set_threshold(findings, seed)


def _worse_than_nominal(findings: Findings, tuned: Base) -> bool:
    nominal = findings.nominal_in(tuned.problem)
    return tuned.problem.gap_squared(tuned.fit.residual) > tuned.problem.gap_squared(nominal)
