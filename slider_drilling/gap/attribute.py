"""Which effect: re-tune, screen, fit, accept one at a time, try to remove each, and say what that proves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.gap.contender import Base, make_base
from slider_drilling.gap.findings import Findings, set_threshold, threshold_of
from slider_drilling.gap.fit import Fit
from slider_drilling.gap.held_out import HeldOut
from slider_drilling.gap.model import Effect, Parameter, Refinable, Values
from slider_drilling.gap.null import Threshold
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.together import add_together
from slider_drilling.gap.tune import GROWTH, SMOOTH, begun_again, fit_growing, scattered, settle
from slider_drilling.gap.turn import add_one

MAX_EFFECTS = 3
# Points spread over where a rig may lie, how many of them tuning begins from, how many of its ends are followed.
_SPREAD, _KEPT, _FOLLOWED = 64, 4, 2


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
            # A second effect is looked for only where the log as a whole asks for one.
            if _at_floor(findings, seed, whole=bool(findings.accepted)) or not catalogue:
                break
            if not add_one(findings, catalogue, turn, scatter, progress):
                _at_floor(findings, seed, whole=True)
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


def _at_floor(findings: Findings, seed: int, whole: bool = False) -> bool:
    """Whether the current model leaves noise alone; where it leaves little more, it is refined before that is told.

    whole: all channels together are enough; else each by itself.
    """
    base = findings.current
    assert base is not None and findings.threshold is not None

    def reached(score: HeldOut, threshold: Threshold) -> bool:
        return score.robust <= threshold.robust and (whole or threshold.holds(score))

    if reached(base.score, findings.threshold):
        return True
    model = base.problem.model
    if base.fit.cost > SMOOTH or not isinstance(model, Refinable):
        return False
    problem = replace(base.problem, model=model.refined())
    found = fit_growing(problem, base.fit.parameters, base.fit.values, iterations=8, shares=(1.0,))
    problem, found = settle(problem, found)
    closer = make_base(problem, findings.bootstrap, found)
    threshold = threshold_of(findings, closer, seed)
    if not reached(closer.score, threshold):
        return False
    findings.current, findings.threshold = closer, threshold
    if not findings.accepted:
        findings.tuned, findings.tuned_threshold = closer, threshold
    return True


def tune_nuisance(
    findings: Findings, starts: Sequence[Values], progress: Progress, scatter: int = 0, thorough: bool = True
) -> None:
    """Re-fit the nuisance from every start, over a growing part of the runs, and anchor the model there.

    Where the first part is not explained down to its noise from these, it is tried from points spread over where a rig
    may lie: what sticks and slips leaves least squares more than one place to end in. thorough: with a search besides.
    """
    problem = findings.problem
    parameters = problem.free(problem.model.nuisance)
    shaken = GROWTH[2:] if thorough else ()

    def first_fits(starts: Sequence[Values]) -> list[Fit]:
        return [fit_growing(problem, parameters, start, shares=GROWTH[:1]) for start in starts]

    progress("re-tuning", 0.02)
    fits = first_fits(starts)
    if min(found.cost for found in fits) > SMOOTH:
        progress("re-tuning from elsewhere", 0.04)
        fits += first_fits(scattered(problem, parameters, {}, scatter or _SPREAD, _KEPT))
    fits.sort(key=lambda found: found.cost)
    progress("re-tuning", 0.1)
    ends: list[Fit] = []
    for start in fits[:_FOLLOWED]:
        whole = fit_growing(problem, parameters, start.values, iterations=8, shares=GROWTH[1:], shaken=shaken)
        ends.append(begun_again(problem, whole))
        if ends[-1].cost <= SMOOTH:
            break
    best = min(ends, key=lambda found: found.cost)
    problem.anchor(best.values)
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
        found = fit_growing(current.problem, parameters, start, iterations=6, shares=(1.0,), shaken=(1.0,))
        problem, found = settle(current.problem, found)
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
