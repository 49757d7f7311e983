"""Checks a programme against a rig before it starts, and gives the nominal time of every step."""

from __future__ import annotations

import dataclasses

from slider_drilling.control.block.auto_driller import AutoDriller
from slider_drilling.control.interlocks.slide_interlocks import MIN_FLOW_SHARE, MIN_RATE
from slider_drilling.errors import InputError
from slider_drilling.programmes.limits import (
    CIRCULATION_SHARE,
    EITHER,
    CompleteLimits,
    LimitError,
    check_torque_limits,
    complete,
)
from slider_drilling.programmes.motion import DriveStates
from slider_drilling.programmes.open_loop import initial_drives
from slider_drilling.programmes.plan_motion import plan_motion
from slider_drilling.programmes.programme import Programme, Step, check_programme
from slider_drilling.programmes.steps import BlockSpeed, Flow, PickUp, Rock, Rotate, SlackOff, Slide
from slider_drilling.rig import Rig

LEAVING_TIME = 60.0  # s, nominal, to park the top drive after a slide and to lift the bit
_ORIENTING_SHARE = 0.4  # of the longest time to orient, nominal
_DEPTH_TOLERANCE = 10.0  # m, between a slide sheet's first row and the bit of the rig file
_SLIDE_WEIGHT, _SLIDE_PRESSURE = 0.7, 0.7  # of what a limit leaves, that a slide may ask for


def nominal_times(programme: Programme, rig: Rig, source: str = "programme") -> tuple[float, ...]:
    """The time of every step on a rig, s; a slide's is an estimate.

    Args:
        programme: Any.
        rig: That it is for.
        source: Names the programme in errors.

    Raises:
        InputError: Naming step and key of what this rig cannot do, or not within the limits.
    """
    check_programme(programme, source)
    _check_rig(programme, rig, source)
    drives, times = initial_drives(rig, programme.bit_height), []
    for index, step in enumerate(programme.steps):
        where = f"{source}: steps[{index}].{step.key}"
        limits = complete(step.limits, programme.limits, rig)
        _check_speeds(step, rig, where)
        if isinstance(step.action, Slide):
            check_slide(step.action, limits, rig, where)
            time, end = _nominal_slide(step.action, drives)
        else:
            motion = plan_motion(step.action, drives, rig, programme.drive_acceleration, where)
            time, end = motion.duration, motion.end
        _check_flow(step, drives, end, limits, rig, where)
        times.append(time)
        drives = end
    return tuple(times)


def check_start_depth(start: float | None, rig: Rig, source: str) -> None:
    """Check that a slide sheet begins (m) where the bit of the rig file is. Raises InputError."""
    if start is not None and abs(start - rig.string.length) > _DEPTH_TOLERANCE:
        raise InputError(f"{source}: begins at {start:.1f} m, the bit of the rig file is at {rig.string.length:.1f} m; "
                         "give the rig file of this depth")  # fmt: skip


def _check_rig(programme: Programme, rig: Rig, source: str) -> None:
    if rig.sensors.rate < MIN_RATE:
        raise InputError(f"{source}: sensors.rate of the rig = {rig.sensors.rate:g} Hz: limits are kept from "
                         f"{MIN_RATE:g} Hz on; sample the surface channels faster")  # fmt: skip
    if programme.drive_acceleration > rig.top_drive.max_acceleration:
        raise InputError(f"{source}: drive_acceleration = {programme.drive_acceleration:g} rad/s2: the top drive has "
                         f"{rig.top_drive.max_acceleration:g}")  # fmt: skip
    given = {"limits": programme.limits}
    given |= {f"steps[{index}].limits": step.limits for index, step in enumerate(programme.steps)}
    for where, limits in given.items():
        try:
            check_torque_limits(limits, rig)
        except LimitError as error:
            raise InputError(f"{source}: {where}.{error.name} = {error.reason}") from None


def _check_speeds(step: Step, rig: Rig, where: str) -> None:
    action = step.action
    if isinstance(action, (Rotate, Rock)) and action.speed > rig.top_drive.max_speed:
        raise InputError(f"{where}.speed = {action.speed:g} rad/s: the top drive has {rig.top_drive.max_speed:g}")
    if isinstance(action, (PickUp, SlackOff, BlockSpeed)) and action.speed > rig.max_block_speed:
        raise InputError(f"{where}.speed = {action.speed:g} m/s: the drawworks have {rig.max_block_speed:g}")
    if isinstance(action, (Rotate, Rock)) and (action.block_speed or 0.0) > rig.max_block_speed:
        raise InputError(f"{where}.block_speed = {action.block_speed:g} m/s: the drawworks have "
                         f"{rig.max_block_speed:g}")  # fmt: skip
    if isinstance(action, Flow) and action.flow / rig.mud_pump.displacement > rig.max_pump_speed:
        raise InputError(f"{where}.flow = {action.flow:g} m3/s: the pump has "
                         f"{rig.max_pump_speed * rig.mud_pump.displacement:g}")  # fmt: skip


def _check_flow(
    step: Step, start: DriveStates, end: DriveStates, limits: CompleteLimits, rig: Rig, where: str
) -> None:  # fmt: skip
    """The pressure of circulation alone stays below the limit, and nothing is lowered without flow."""
    pressure = float(rig.circulation_at(max(start.pump, end.pump)))
    if pressure >= CIRCULATION_SHARE * limits.pressure:
        raise InputError(f"{where}: circulation alone takes {pressure / 1e5:.0f} bar, more than "
                         f"{100 * CIRCULATION_SHARE:.0f} % of the limit of {limits.pressure / 1e5:.0f} bar; less flow, "
                         "or a higher limit")  # fmt: skip
    lowered = end.block > start.block or end.lowering > 0.0 or isinstance(step.action, Slide)
    if lowered and min(start.pump, end.pump) < MIN_FLOW_SHARE * rig.reference_pump_speed:
        raise InputError(f"{where}: the block is lowered with less than {100 * MIN_FLOW_SHARE:.0f} % of the "
                         "reference flow; raise the flow first")  # fmt: skip


def check_slide(action: Slide, limits: CompleteLimits, rig: Rig, where: str) -> None:
    """Check that a slide's weight and pressure leave room below the limits.

    Args:
        action: The slide.
        limits: Of the step.
        rig: Rig file.
        where: Names the step in errors.

    Raises:
        InputError: They do not, or the limits ask for a bit that stays on or off bottom.
    """
    if limits.bit != EITHER:
        raise InputError(f"{where}: lifts the bit to orient and drills then; its limit bit must be {EITHER!r}")
    driller = AutoDriller(rig, 0.0, rig.max_block_speed)
    pressure = driller.pressure_for(action.rate_of_penetration)
    weight = driller.weight_per_pressure * pressure
    left = limits.pressure - rig.circulating_pressure
    most = min(_SLIDE_WEIGHT * limits.weight_on_bit / weight, _SLIDE_PRESSURE * left / pressure)
    if most < 1.0:
        rate = 3600.0 * most * action.rate_of_penetration
        raise InputError(f"{where}.rate_of_penetration = {3600.0 * action.rate_of_penetration:.3g} m/h: needs "
                         f"{weight / 1e3:.0f} kN and {pressure / 1e5:.0f} bar across the motor, too near the limits; "
                         f"ask for {rate:.2g} m/h at most")  # fmt: skip


def _nominal_slide(action: Slide, drives: DriveStates) -> tuple[float, DriveStates]:
    length = action.length if action.length is not None else (action.time or 0.0) * action.rate_of_penetration
    drilling = action.time if action.time is not None else length / action.rate_of_penetration
    deepest = drives.deepest + length
    end = dataclasses.replace(drives, turning=0.0, block=deepest - 1.0, lowering=0.0, block_speed=0.0,
                              deepest=deepest, touching=deepest)  # fmt: skip
    return _ORIENTING_SHARE * action.orient_time + drilling + LEAVING_TIME, end
