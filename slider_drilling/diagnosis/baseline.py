"""What an earlier log says about a rig: its calibration, the effects that it always had, and what no model explains.

All of this is shared with a later log, so that only what differs between the two counts as a change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.changed_string import ChangedString
from slider_drilling.diagnosis.nuisance import START_TWISTS
from slider_drilling.diagnosis.prediction_noise import prediction_noise
from slider_drilling.diagnosis.rig_changes import RIG_CHANGES
from slider_drilling.diagnosis.undisturbed import from_calm_start, without_operations
from slider_drilling.diagnosis.usual_error import problem_in_units, usual_gap, usual_square
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Effect, Parameter
from slider_drilling.gap.problem.noise import NoiseFloor, noise_floors, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.results.intervals import TWO_SIDED_95, parameter_intervals
from slider_drilling.gap.search.least_squares import Fit, fit, linearised_at_its_end
from slider_drilling.gap.search.multi_start import fit_from_starts
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import scan_effects, screen
from slider_drilling.log import RigLog
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig

# Effects that the baseline may have all along. More would only describe the model's own error.
_MAX_STANDING = 2
# Share of the baseline's gap that a standing effect closes, at least.
_MIN_SHARE = 0.15
# Gain of ``-2 log p`` below which an effect is not worth a fit, and does not stand.
_MIN_GAIN = 30.0
_NO_BASELINE = 30.0  # E, beyond which a calibrated model says nothing of the rig
_UNKNOWN_SHARE = 0.25  # of the standard deviation in the baseline
# How far a calibrated number may wander within an hour, one standard deviation: friction, bit and pressure of the
# plants of foreign structure change slowly, and the hole deepens. Multiples of the rig file's value, else SI.
_WANDERS = {
    "friction_": 0.02, "pressure_gain": 0.0025, "motor_gain": 0.01, "bit_stiffness": 0.03, "hook_load_offset": 600.0,
    "hook_load_gain": 0.001, "sheave_friction": 500.0, "torsional_damping": 0.1, "axial_damping": 0.1,
    "torque_gain": 0.001, "torque_offset": 20.0, "torque_delay": 0.005,
}  # fmt: skip


@dataclass(frozen=True)
class BaselineParameter:
    """A parameter as the baseline found it: value and standard deviation of what it may be later."""

    value: float
    spread: float


@dataclass(frozen=True)
class Baseline:
    """A rig as it was. It can be pickled, and used for any number of later logs.

    Attributes:
        rig: Rig file as given.
        sources: Names of the logs.
        parameters: Calibrated parameters and those of standing effects, by name; none of a single run.
        standing: Effects that the rig had all along.
        noise: By channel, RMS of what the model left, no less than the noise of the sensor: one unit of E.
        chance_gains: By candidate, ``-2 log p`` per sample that it gains although nothing has changed.
        gap: E of the calibrated model over the baseline, in the noise of the sensors.
        duration: s, of all logs.
    """

    rig: Rig
    sources: tuple[str, ...]
    parameters: Mapping[str, BaselineParameter]
    standing: tuple[Effect, ...]
    noise: Mapping[str, NoiseFloor]
    chance_gains: Mapping[str, float]
    gap: float
    duration: float

    @property
    def values(self) -> dict[str, float]:
        """Parameter values by name."""
        return {name: parameter.value for name, parameter in self.parameters.items()}


def fit_baseline(logs: Sequence[RigLog], rig: Rig, whole: bool = True) -> Baseline:
    """Calibrate the rig to logs that were made before something changed.

    Args:
        logs: One or several; several are fitted together.
        rig: The rig file.
        whole: Whether the logs begin as runs do, see `check_log`.

    Raises:
        InputError: A log is unusable, or no calibration makes the simulation follow it.
    """
    checks = [check_log(log, rig, whole) for log in logs]
    for checked in checks:
        checked.raise_if_unusable()
    calm = [from_calm_start(checked.log, rig, longest=True) for checked in checks]
    string = without_operations(build_model(calm, rig).model)
    model = ChangedString(string, {}, string.nuisance, string.effects)  # nothing is shared yet
    floors = noise_floors(model.runs)
    problem = build_problem(model, [sigmas(own) for own in floors])
    runs = range(len(model.runs))
    starts = [{f"start_twist@{run}": twist for run in runs} for twist in START_TWISTS]
    found = fit_from_starts(problem, starts)
    standing, found = _standing_effects(problem, found, list(model.effects))
    if usual_gap(problem, found.residual) > _NO_BASELINE:
        raise InputError(
            f"{logs[0].source}: no baseline: the calibrated simulation leaves {usual_gap(problem, found.residual):.0f} "
            "times the noise; give a stretch of undisturbed work"
        )
    noise = prediction_noise(calm, rig, _noise_left(problem, found, floors), found.values)
    in_these_units = problem_in_units(model, noise)
    again = linearised_at_its_end(
        in_these_units, fit(in_these_units, found.parameters, found.values, iterations=1)
    )
    return Baseline(
        rig, tuple(log.source for log in logs), _parameters(in_these_units, again), standing, noise,
        chance_gains(in_these_units, again, candidates_for_change(model.effects, standing, again.values)),
        usual_gap(problem, found.residual), float(sum(run.duration for run in model.runs)),
    )  # fmt: skip


def candidates_for_change(
    catalogue: Sequence[Effect], standing: Sequence[Effect], values: Mapping[str, float]
) -> tuple[Effect, ...]:
    """What may have changed: every effect, from where it stood, and the rig's own numbers."""
    own = {effect.name for effect in standing}
    sudden = [_from_the_start(effect) for effect in catalogue]
    moved = [_around(effect, values) if effect.name in own else effect for effect in sudden]
    return tuple(
        [effect for effect in moved if effect is not None] + [change.candidate() for change in RIG_CHANGES.values()]
    )


def chance_gains(problem: Problem, found: Fit, candidates: Sequence[Effect]) -> dict[str, float]:
    """By candidate, the gain of ``-2 log p`` per sample that a scan predicts where nothing has changed."""
    screened = screen(scan_effects(problem, found, candidates))
    return {each.effect.name: max(each.predicted_gain, 0.0) / problem.size for each in screened}


def _standing_effects(problem: Problem, found: Fit, effects: list[Effect]) -> tuple[tuple[Effect, ...], Fit]:
    """Effects that close a good part of the baseline's gap, and the fit with them.

    None that begins or grows during the baseline: a later log has a time of its own.
    """
    standing: list[Effect] = []
    effects = [effect for effect in effects if not EFFECTS[effect.name].during_run]
    for _ in range(_MAX_STANDING):
        remaining = [effect for effect in effects if effect.name not in {own.name for own in standing}]
        best = screen(scan_effects(problem, found, remaining))[0]
        if best.predicted_gain < _MIN_GAIN:
            break
        added = best.effect.within_physical_range
        within = problem.at_fidelity_of(standing)
        fitted = fit(within, parameters_of(problem, [*standing, added]), best.starts[0])
        before, after = (usual_gap(problem, each.residual) ** 2 for each in (found, fitted))
        closes = (before - after) / max(before - 1.0, 1e-9)
        if found.cost - fitted.cost < _MIN_GAIN or closes < _MIN_SHARE or not best.effect.is_physical(fitted.values):
            break
        standing.append(added)
        found = fitted
    return tuple(standing), found


def _noise_left(problem: Problem, found: Fit, floors: Sequence[Mapping[str, NoiseFloor]]) -> dict[str, NoiseFloor]:
    """By channel, the larger of the sensor's noise and the RMS of what the fit leaves."""
    squares: dict[str, list[float]] = {}
    for piece in problem.pieces:
        squares.setdefault(piece.name, []).append(usual_square(problem, piece, found.residual) * piece.noise**2)
    noise = {}
    for name, values in squares.items():
        floor = max((own[name] for own in floors if name in own), key=lambda each: each.sigma)
        left = float(np.sqrt(np.mean(values)))
        noise[name] = replace(floor, sigma=left, method="baseline") if left > floor.sigma else floor
    return noise


def _parameters(problem: Problem, found: Fit) -> dict[str, BaselineParameter]:
    intervals = parameter_intervals(problem, found)
    known = {}
    for parameter in found.parameters:
        if "@" in parameter.name:
            continue
        value = found.values[parameter.name]
        low, high = intervals.get(parameter.name, (value - parameter.scale, value + parameter.scale))
        deviation = max((high - low) / (2.0 * TWO_SIDED_95), 0.0)
        wander = _WANDERS.get(parameter.name.rstrip("0123456789"), 0.1 * parameter.scale)
        # A number that the baseline does not determine is still the same number later: only a part of what is unknown
        # of it may show in another manoeuvre.
        spread = min(float(np.hypot(_UNKNOWN_SHARE * deviation, wander)), max(parameter.spread, wander))
        known[parameter.name] = BaselineParameter(value, spread)
    return known


def shared_nuisance(nuisance: Sequence[Parameter], baseline: Baseline) -> tuple[Parameter, ...]:
    """Calibrated parameters of a later log: as the baseline found them, and no farther off than they wander.

    Args:
        nuisance: Of the later log alone.
        baseline: What they were.
    """
    shared = [_around_baseline(each, baseline.parameters.get(each.name)) for each in nuisance]
    own = {each.name for each in shared}
    shared += [
        _around_baseline(parameter, baseline.parameters.get(parameter.name))
        for effect in baseline.standing for parameter in effect.parameters if parameter.name not in own
    ]  # fmt: skip
    return tuple(shared)


def _around_baseline(parameter: Parameter, known: BaselineParameter | None) -> Parameter:
    if known is None:
        return parameter
    lower, upper = min(parameter.lower, known.value), max(parameter.upper, known.value)
    return replace(parameter, nominal=known.value, spread=max(known.spread, 1e-6), lower=lower, upper=upper)


def _from_the_start(effect: Effect) -> Effect:
    """The effect without a time of its own: the later log begins where the change does."""
    times = [index for index, parameter in enumerate(effect.parameters) if parameter.name.endswith(".time")]
    if effect.name != "formation_change" or not times:
        return effect
    amplitude = effect.parameters[0]
    points = ((1.4 * amplitude.nominal,), (0.7 * amplitude.nominal,), (2.0 * amplitude.nominal,))
    return replace(effect, parameters=(amplitude,), scan=points)


def _around(effect: Effect, values: Mapping[str, float]) -> Effect | None:
    """A standing effect that may have changed in size: neutral is what it was. None where no size is left to try."""
    amplitude = effect.parameters[0]
    was = values[amplitude.name]
    steps = sorted({point[0] - amplitude.nominal for point in effect.scan}, key=abs)
    points = [
        (was + sign * step,) for step in steps for sign in (1.0, -1.0)
        if amplitude.lower < was + sign * step < amplitude.upper and step != 0.0
    ]  # fmt: skip
    if len(points) < 3:
        return None
    return replace(effect, parameters=(replace(amplitude, nominal=was),), scan=tuple(points))
