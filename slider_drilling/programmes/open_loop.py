"""The motion of a programme that needs no feedback, as commands of the plant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.errors import InputError
from slider_drilling.programmes.motion import DriveStates, StepMotion
from slider_drilling.programmes.plan_motion import plan_motion
from slider_drilling.programmes.programme import Programme
from slider_drilling.rig import Rig

MAX_OPEN_LOOP_S = 86_400.0


@dataclass(frozen=True)
class TimedMotion:
    """The motion of one step, and when it begins.

    Attributes:
        begin: s from the programme's start.
        motion: Of the drives.
    """

    begin: float
    motion: StepMotion


def initial_drives(rig: Rig, bit_height: float = 0.0) -> DriveStates:
    """Drives at rest, the pump at the reference flow, the bit so far (m) above bottom."""
    pump = rig.reference_pump_speed
    return DriveStates(0.0, 0.0, 0.0, 0.0, 0.0, pump, bit_height, bit_height)


SETTLING = 3.0
"""s before the first step, in which nothing moves and hook load and pressure are tared."""


def check_simulated_start(programme: Programme, source: str) -> None:
    """Check that a programme starts as a simulated string does: with the bit just on bottom. Raises InputError.

    With the bit believed off bottom, no weight is guarded.
    """
    if programme.bit_height > 0.0:
        raise InputError(f"{source}: bit_height = {programme.bit_height:g} m: a simulated rig starts with the bit just "
                         "on bottom; leave it out and begin with a pick_up")  # fmt: skip


def plan_programme(programme: Programme, rig: Rig, source: str = "programme") -> tuple[TimedMotion, ...]:
    """The motion of every step, one after the other.

    Args:
        programme: Without a step that needs feedback.
        rig: For the pump.
        source: Names the programme in errors.

    Raises:
        InputError: A step needs feedback, or does not fit what comes before it.
    """
    drives, begin, planned = initial_drives(rig, programme.bit_height), SETTLING, []
    for index, step in enumerate(programme.steps):
        where = f"{source}: steps[{index}].{step.key}"
        motion = plan_motion(step.action, drives, rig, programme.drive_acceleration, where)
        planned.append(TimedMotion(begin, motion))
        begin, drives = begin + motion.duration, motion.end
    return tuple(planned)


def open_loop_commands(
    programme: Programme, rig: Rig, interval: float | None = None, source: str = "programme"
) -> Commands:
    """What drives the plant through a programme, as the controller would, without tracking errors.

    Args:
        programme: Without a slide.
        rig: For the pump and the interval of the sensors.
        interval: s between samples; None for that of the rig's sensors.
        source: Names the programme in errors.

    Returns:
        Commands from 0 s to the programme's end.

    Raises:
        InputError: A step needs feedback, or does not fit what comes before it; or it takes longer than a day, or does
            not start on bottom.
    """
    check_simulated_start(programme, source)
    planned = plan_programme(programme, rig, source)
    duration = planned[-1].begin + planned[-1].motion.duration
    if duration > MAX_OPEN_LOOP_S:
        raise InputError(f"{source}: takes {duration / 3600.0:.1f} h; a day is the most that is simulated at once")
    interval = interval or 1.0 / rig.sensors.rate
    time = np.arange(0.0, duration + 0.5 * interval, interval)
    begins = np.array([step.begin for step in planned])
    step_of = np.searchsorted(begins, time, side="right") - 1
    rows = np.zeros((5, time.size))
    rows[4, step_of < 0] = initial_drives(rig).pump
    for index, step in enumerate(planned):
        chosen = step_of == index
        since = time[chosen] - step.begin
        motion = step.motion
        rows[0, chosen], rows[1, chosen] = motion.top_drive.sample(since)
        rows[2, chosen], rows[3, chosen] = motion.block.sample(since)
        rows[4, chosen] = motion.pump.sample(since)[1]
    return Commands(time, *rows)
