"""What logs hold at best: the evidence for the true effects, by likelihood alone.

The oracle of the rounds: calibration with and without the true effects is fitted to the logs in the cheapest
simulation. No other effect competes, nothing is cross-validated, and no free form is tried, so that a diagnosis names
less. It takes a twentieth of a diagnosis's time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.reported_diagnosis import ReportedDiagnosis
from slider_drilling.campaign.job import Job
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer, read_result_tree
from slider_drilling.gap.experiment_design.detectable_size import evidence_needed
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import noise_floors, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import STARTS, rank_starts, scan_effects, screen
from slider_drilling.gap.selection.calibration import lower_floors
from slider_drilling.log import RigLog, read_log
from slider_drilling.log_checks import check_log

_NAN = float("nan")
# Share of the smallest scan point that a fit starts from beside those of the screen.
_LITTLE = 0.1


def fit_truth(job: Job) -> dict[str, Any]:
    """Returns, by true effect, the gain of ``-2 log p`` over the fit without it, and what a name needs."""
    logs = [read_log(job.inputs[name]) for name in sorted(job.inputs) if name.startswith("log")]
    return evidence_for(logs, job.options["effects"])


def evidence_for(logs: Sequence[RigLog], names: Sequence[str]) -> dict[str, Any]:
    """The evidence for some effects in logs of one rig.

    Args:
        logs: The logs.
        names: One or two effects of the catalogue.

    Returns:
        ``gains`` and ``needed`` by effect, and the ``calibrated`` values without any.
    """
    rig = logs[0].rig()
    model = build_model([check_log(log, rig).log for log in logs], rig).model
    effects = [effect for effect in model.effects if effect.name in names]
    problem, calibrated = _calibrated(model)
    fitted = {effect.name: _beside(problem, calibrated, (), effect) for effect in effects}
    gains = {name: pair.gain for name, pair in fitted.items()}
    if len(effects) == 2:
        first, second = effects
        gains = {
            each.name: _beside(problem, fitted[other.name].with_it, (other,), each).gain
            for each, other in ((first, second), (second, first))
        }
    needed = {effect.name: evidence_needed(len(effect.parameters), len(model.effects)) for effect in effects}
    return {"gains": gains, "needed": needed, "calibrated": calibrated.values}


def _calibrated(model: DrillString) -> tuple[Problem, Fit]:
    """Calibration alone, with noise floors from what it leaves."""
    floors = noise_floors(model.runs)
    rough_problem = build_problem(model, [sigmas(own) for own in floors])
    freed = parameters_of(rough_problem, ())
    rough = fit(rough_problem, freed, {})
    lowered = lower_floors(rough_problem, rough, floors)
    problem = build_problem(model, [sigmas(own) for own in lowered])
    return problem, fit(problem, freed, rough.values)


@dataclass(frozen=True)
class _Pair:
    """Fits without and with an effect, in simulations of the same mesh."""

    without: Fit
    with_it: Fit

    @property
    def gain(self) -> float:
        return self.without.cost - self.with_it.cost


def _beside(problem: Problem, base: Fit, known: Sequence[Effect], effect: Effect) -> _Pair:
    """The best fits beside known effects, with one effect more from its most promising starts."""
    own = problem.at_fidelity_of((*known, effect))
    start = fit(own, parameters_of(own, known), base.values) if own is not problem or known else base
    scan = scan_effects(own, start, [effect])
    (screened,) = screen(scan)
    freed = parameters_of(own, (*known, effect))
    ranked = rank_starts(scan, screened)[:STARTS]
    fits = [fit(own, freed, values, known=KnownStart(row)) for values, row in ranked]
    # From almost none of the effect, too; and where calibration has made up for the effect, from nominal values.
    amplitude = effect.parameters[0]
    point = min(effect.scan, key=lambda each: abs(each[0] - amplitude.nominal))
    little = amplitude.nominal + _LITTLE * (point[0] - amplitude.nominal)
    usual = {parameter.name: ranked[0][0][parameter.name] for parameter in effect.parameters}
    fits.append(fit(own, freed, {**start.values, **effect.values((little, *point[1:]))}))
    fits.append(fit(own, freed, usual))
    # A neutral effect is one, too.
    fits.append(start)
    best = min(fits, key=lambda found: found.cost)
    return _Pair(start, best)


def as_diagnosis(tree: Mapping[str, Any]) -> ReportedDiagnosis:
    """The evidence as a diagnosis that names every true effect whose gain suffices."""
    named = tuple(name for name, gain in tree["gains"].items() if gain > tree["needed"][name])
    return ReportedDiagnosis(
        "effect" if named else "parameters", named, dict.fromkeys(named, ()), (), None, _NAN, _NAN, (_NAN, _NAN), {}
    )


def as_answer(path: Path, logs: Sequence[str]) -> EarlierAnswer:
    """What a planner may know of the evidence: calibration alone. Raises InputError."""
    calibrated = {str(name): float(value) for name, value in read_result_tree(path)["calibrated"].items()}
    return EarlierAnswer(str(path), tuple(logs), "parameters", (), (Explanation((), 1.0, calibrated),))
