"""Candidates for the next run: other rocking, rests, steps of flow and of block speed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, LoggedRun
from slider_drilling.rig import Rig

_DURATION_S = 100.0
_ACCELERATION = 4.0  # rad/s2, of the drive at a reversal


@dataclass(frozen=True)
class _ManoeuvrePlan:
    """A run to be made.

    Attributes:
        description: What to do.
        amplitude: rad each way.
        speed: rad/s of the drive.
        rest: s after each stroke.
        flow_step: Flow in the second half, as a share of the log's.
        block_step: Block speed in the second half, as a share of the log's.
    """

    description: str
    amplitude: float
    speed: float
    rest: float = 0.0
    flow_step: float = 1.0
    block_step: float = 1.0


NextRun = tuple[str, dict[str, float], LoggedRun, Commands]


def next_runs(rig: Rig, made: LoggedRun, log: Commands) -> list[NextRun]:
    """Candidates that vary what one log did.

    Args:
        rig: The rig file as given.
        made: The logged run, for its channels.
        log: Its commands.

    Returns:
        Description, settings, run (its measurements are zero) and commands of each.
    """
    amplitude = max(0.5 * float(np.ptp(log.top_drive_angle)) / 2.0, 3.0)
    speed = max(float(np.quantile(np.abs(log.top_drive_speed), 0.9)), 0.5)
    plans = [
        _ManoeuvrePlan("rock half as far", 0.5 * amplitude, speed),
        _ManoeuvrePlan("rock twice as far", 2.0 * amplitude, speed),
        _ManoeuvrePlan("rock at a third of the speed", amplitude, speed / 3.0),
        _ManoeuvrePlan("rock at twice the speed", amplitude, 2.0 * speed),
        _ManoeuvrePlan("rest ten seconds at every reversal", amplitude, speed, rest=10.0),
        _ManoeuvrePlan("rest thirty seconds at every reversal", amplitude, speed, rest=30.0),
        _ManoeuvrePlan("step the flow down by a fifth half-way", amplitude, speed, flow_step=0.8),
        _ManoeuvrePlan("stop the block half-way", amplitude, speed, block_step=0.0),
    ]
    return [(plan.description, _settings(plan), *_run(rig, made, log, plan)) for plan in plans]


def _settings(plan: _ManoeuvrePlan) -> dict[str, float]:
    return {
        "amplitude_rad": plan.amplitude, "speed_rad_s": plan.speed, "rest_s": plan.rest,
        "flow_step": plan.flow_step, "block_step": plan.block_step,
    }  # fmt: skip


def _run(rig: Rig, made: LoggedRun, log: Commands, plan: _ManoeuvrePlan) -> tuple[LoggedRun, Commands]:
    """The run and commands of a plan, with the log's channels at the plan's times."""
    interval = 1.0 / rig.sensors.rate
    time = np.arange(0.0, _DURATION_S, interval, dtype=np.float64)
    speed = _rocking(time, plan)
    second_half = np.where(time > 0.5 * _DURATION_S, 1.0, 0.0)
    block_speed = float(np.median(log.block_speed)) * (1.0 + (plan.block_step - 1.0) * second_half)
    pump = float(np.median(log.pump_speed)) * (1.0 + (plan.flow_step - 1.0) * second_half)
    commands = Commands(time, _integral(speed, interval), speed, _integral(block_speed, interval), block_speed, pump)
    channels = []
    for channel in made.channels:
        every = max(round(float(np.median(np.diff(channel.time))) / interval), 1)
        samples = time[every::every] if every > 1 else time
        channels.append(replace(channel, time=samples, measured=np.zeros_like(samples)))
    run = LoggedRun(plan.description, time, commands.top_drive_angle, tuple(channels))
    return run, commands


def _rocking(time: Array, plan: _ManoeuvrePlan) -> Array:
    """Drive speed, rad/s: half a stroke out, then strokes to and fro with rests at the reversals."""
    stroke = 2.0 * plan.amplitude / plan.speed
    speed = np.zeros_like(time)
    at, direction, length = 2.0, 1.0, 0.5 * stroke
    while at < time[-1]:
        speed[(time >= at) & (time < at + length)] = direction * plan.speed
        at, direction, length = at + length + plan.rest, -direction, stroke
    interval = time[1] - time[0]
    ramp = max(round(2.0 * plan.speed / _ACCELERATION / interval), 1)
    return np.convolve(speed, np.ones(ramp) / ramp, mode="same")


def _integral(rate: Array, interval: float) -> Array:
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * interval)])
