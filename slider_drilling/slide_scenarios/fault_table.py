"""Table of `closed-loop --faults`: what happens with each fault, and whether a limit was passed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from slider_drilling.control import SlideSettings
from slider_drilling.control.block.auto_driller import AutoDriller
from slider_drilling.control.block.block_control import WEIGHT_LIMIT_SHARE
from slider_drilling.control.estimation.calibrated_rig import with_worn_motor
from slider_drilling.slide_scenarios.run import ScenarioResult
from slider_drilling.slide_scenarios.trace import STOPPING
from slider_drilling.units import Units, format_number

SCHEMA = "slider_drilling/closed_loop_faults/1"


@dataclass(frozen=True)
class SlideLimits:
    """Limits of a slide: weight on bit N, pressure across the motor Pa, torque to the right and to the left N m."""

    weight: float
    pressure: float
    make_up: float
    back_off: float


@dataclass(frozen=True)
class FaultOutcome:
    """What happened in one slide.

    Attributes:
        name: Of the scenario.
        about: Its fault.
        stopped_at_s: First error of the controller after which nothing more than the string's stretch was drilled off,
            or None.
        status: Its name, or that of the first error where drilling went on; "" without any.
        message: Its reason.
        peak_weight_n: Largest weight on bit.
        peak_pressure_pa: Largest pressure across the motor.
        make_up_n_m: Largest torque to the right.
        back_off_n_m: Largest torque to the left.
        within_limits: Whether all of these are within the limits.
        drilled_m: New hole.
        mean_abs_error_deg: Toolface error while the bit drilled, deg; NaN where it did not.
    """

    name: str
    about: str
    stopped_at_s: float | None
    status: str
    message: str
    peak_weight_n: float
    peak_pressure_pa: float
    make_up_n_m: float
    back_off_n_m: float
    within_limits: bool
    drilled_m: float
    mean_abs_error_deg: float


def limits_for(result: ScenarioResult) -> SlideLimits:
    """Return the limits that the default settings give for the scenario's rig."""
    settings, rig = SlideSettings(), with_worn_motor(result.scenario.assumed_rig())
    driller = AutoDriller(rig, settings.auto_driller_time, settings.max_block_speed)
    weight = driller.weight_per_pressure * driller.pressure_for(settings.rate_of_penetration)
    return SlideLimits(settings.weight_on_bit_limit or WEIGHT_LIMIT_SHARE * weight,
                       settings.stall_share * rig.motor.max_pressure,
                       settings.make_up_torque_limit, settings.back_off_torque_limit)


def outcome_of(result: ScenarioResult) -> FaultOutcome:
    """Return what happened in one slide."""
    trace, limits = result.trace, limits_for(result)
    weight, pressure = float(np.max(trace.weight_on_bit)), float(np.max(trace.differential_pressure))
    make_up, back_off = result.score.make_up_n_m, result.score.back_off_n_m
    errors = [event for event in trace.events if event[1] == "ERROR" and event[2] in STOPPING]
    warnings = [event for event in trace.events if event[1] == "WARN" and event[2] in STOPPING and event[0] > 60.0]
    stop = next((event for event in errors if _ends(result, event[0])), None)
    shown = stop or next(iter(errors or warnings), (math.nan, "", "", ""))
    return FaultOutcome(
        result.scenario.name, result.scenario.about, None if stop is None else round(stop[0], 1), shown[2], shown[3],
        weight, pressure, make_up, back_off,
        weight <= limits.weight and pressure <= limits.pressure and make_up <= limits.make_up
        and back_off <= limits.back_off, result.score.drilled_m, _drilling_error(result))  # fmt: skip


def _ends(result: ScenarioResult, time: float) -> bool:
    """Whether the bit has lost most of its weight by the end of a slide with an error at `time` (s)."""
    trace = result.trace
    last = trace.time > trace.time[-1] - 120.0
    return bool(time < trace.time[-1] and np.mean(trace.weight_on_bit[last]) < 0.5 * np.max(trace.weight_on_bit))


def _drilling_error(result: ScenarioResult) -> float:
    """Mean toolface error (deg) while the bit was loaded and the time for setting had passed."""
    trace = result.trace
    loaded = (trace.weight_on_bit > 0.25 * np.max(trace.weight_on_bit)) & (trace.time > 240.0)
    if result.score.nothing_drilled or not loaded.any():
        return math.nan
    error = (np.degrees(trace.tool_face - trace.target)[loaded] + 180.0) % 360.0 - 180.0
    return float(np.mean(np.abs(error)))


def terminal_header(units: Units) -> tuple[str, ...]:
    """Column labels over `terminal_row`."""
    weight, pressure, torque = (units.display_unit(unit) for unit in ("kN", "bar", "kN m"))
    return ("fault", "stops\ns", "status", f"weight\n{weight}", f"pressure\n{pressure}", f"torque\n{torque}",
            "within\nlimits")  # fmt: skip


def terminal_row(outcome: FaultOutcome, units: Units) -> tuple[str, ...]:
    """One line of the terminal's table: a cell for each of `terminal_header`."""
    right, left = (format_number(units.convert(torque / 1e3, "kN m"))
                   for torque in (outcome.make_up_n_m, outcome.back_off_n_m))  # fmt: skip
    return (outcome.name, "-" if outcome.stopped_at_s is None else f"{outcome.stopped_at_s:.0f}", outcome.status or "-",
            format_number(units.convert(outcome.peak_weight_n / 1e3, "kN")),
            format_number(units.convert(outcome.peak_pressure_pa / 1e5, "bar")), f"{right} / {left}",
            "yes" if outcome.within_limits else "NO")


def as_json(outcomes: Sequence[FaultOutcome], limits: SlideLimits, seed: int, elements: int) -> dict[str, Any]:
    """Return the tree of closed_loop_faults.json; NaN becomes null."""
    rows = [{key: None if isinstance(value, float) and not math.isfinite(value) else value
             for key, value in asdict(outcome).items()} for outcome in outcomes]
    return {"schema": SCHEMA, "seed": seed, "elements": elements, "limits": asdict(limits), "faults": rows}
