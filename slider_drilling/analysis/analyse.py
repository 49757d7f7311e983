"""Analysis of a log's friction, from its measurements and from the plant fitted to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from slider_drilling.analysis.along_string import StringHistory, simulate_along_string, without_rocking, zones_over_time
from slider_drilling.analysis.calibrate_friction import FrictionCalibration
from slider_drilling.analysis.calibrate_log import calibrate_log
from slider_drilling.analysis.cycles import Breakover, RockingCycle, breakover, rocking_cycles
from slider_drilling.analysis.driller_weights import DrillerWeights
from slider_drilling.analysis.fit_friction import ELEMENTS, FrictionFit, fit_friction
from slider_drilling.errors import InputError
from slider_drilling.gap.progress import Progress
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import most_active_window
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, Text, sentence
from slider_drilling.wellbore.zones import Zones

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Analysis:
    """Result of `analyse`; parts that the log does not determine are None or empty.

    Attributes:
        log, rig: That were analysed.
        time, angle, torque: Of the top drive, s, rad and N m, (n,).
        cycles: Rocking cycles.
        breakover: First start of rotation from rest.
        fit: The friction fit.
        rocked: The fitted plant driven by the log.
        still: The same with the top drive held.
        zones: (time s, zones) of each cycle.
        calibration: Friction from the driller's weights, given or found in the log.
        undetermined: One sentence for each missing part.
    """

    log: RigLog
    rig: Rig | None
    time: Array
    angle: Array
    torque: Array
    cycles: list[RockingCycle]
    breakover: Breakover | None
    fit: FrictionFit | None
    rocked: StringHistory | None
    still: StringHistory | None
    zones: list[tuple[float, Zones]]
    undetermined: tuple[Text, ...]
    calibration: FrictionCalibration | None = None


MAX_DURATION = 3600.0
"""s of a log that are analysed, since the string is simulated over them some hundred times."""


def analyse(
    log: RigLog, rig: Rig | None, elements: int = ELEMENTS, progress: Progress | None = None,
    weights: Sequence[DrillerWeights] = (), block_weight: float | None = None,
) -> Analysis:  # fmt: skip
    """Analyse the friction of one log; without a rig only torque and angle.

    Of a log longer than `MAX_DURATION` the part that rocks most is analysed.

    Args:
        log, rig, elements: What is analysed.
        progress: Called with the step's name and the fraction that is done.
        weights: The driller's weights; empty for those that the log holds.
        block_weight: In the hook loads of weights and log, N; see `calibrate_friction`.

    Raises:
        InputError: Where the log holds no surface torque, or weights cannot be.
    """
    calibration, no_weights = calibrate_log(log, rig, weights, block_weight)
    log, left_out = most_active_window(log, MAX_DURATION)
    time, angle, speed, torque = _surface(log)
    cycles = rocking_cycles(time, angle, torque)
    broke = breakover(time, speed, torque)
    missing: list[Text] = [*filter(None, [left_out, no_weights]), *_missing_at_surface(cycles, broke)]
    if rig is None:
        missing.append(
            "friction factors, zones, axial friction, weight transfer: the log has no rig file and none was given"
        )
        return Analysis(log, None, time, angle, torque, cycles, broke, None, None, None, [], tuple(missing))

    def simulated(count: int) -> None:
        if progress is not None:
            progress("fitting friction", 1.0 - 1.0 / (1.0 + count / 100.0))

    fit = fit_friction(log, rig, elements, simulated)
    missing += [
        sentence(
            f"friction of the {row.kind} from ", Quantity(round(row.top), "m"), " to ",
            Quantity(round(row.bottom), "m"), ": this log does not determine it",
        )
        for row in fit.intervals if not row.is_determined
    ]  # fmt: skip
    commands = fit.inputs.commands
    rocked = simulate_along_string(fit.rig, fit.start, commands, elements, _named(progress, "downhole"))
    axial = "hook_load" in fit.channels and np.ptp(commands.block_position) > 0.0
    still = None
    if axial:
        still = simulate_along_string(
            fit.rig, fit.start, without_rocking(commands), elements, _named(progress, "without rocking")
        )
    else:
        missing.append(
            "axial friction, weight transfer, the case without rocking: the log holds no block that moves and hook load"
        )
    zones = zones_over_time(rocked, cycles)
    if not zones:
        missing.append("three zones over time: the log holds no full rocking cycle")
    return Analysis(log, rig, time, angle, torque, cycles, broke, fit, rocked, still, zones, tuple(missing),
                    calibration)  # fmt: skip


def _surface(log: RigLog) -> tuple[Array, Array, Array, Array]:
    drive = log.top_drive
    if drive is None or not np.any(np.isfinite(drive.effort)):
        raise InputError(
            f"{log.source}: holds no surface torque (effort of top_drive/joint_states); nothing to analyse"
            f"{log.why_unreadable('top_drive')}"
        )
    keep = np.isfinite(drive.effort) & (np.isfinite(drive.position) | np.isfinite(drive.velocity))
    if np.count_nonzero(keep) < 10:
        raise InputError(f"{log.source}: fewer than ten samples hold surface torque beside angle or speed")
    time, angle, speed = drive.time[keep], drive.position[keep], drive.velocity[keep]
    if not np.all(np.isfinite(speed)):
        speed = np.gradient(angle, time)
    if not np.all(np.isfinite(angle)):
        angle = cumulative_trapezoid(speed, time, initial=0.0)
    return time, angle, speed, drive.effort[keep]


def _missing_at_surface(cycles: list[RockingCycle], broke: Breakover | None) -> list[str]:
    missing = []
    if not cycles:
        missing.append("friction work per rocking cycle: the log holds no full rocking cycle")
    if broke is None:
        missing.append(
            "measured breakover torque: the string is never started from rest into lasting rotation (with a rig file, "
            "the torque that would turn it is given from the fitted friction)"
        )
    return missing


def _named(progress: Progress | None, step: str) -> Callable[[float], None] | None:
    return None if progress is None else lambda share: progress(step, share)
