"""Plans the motion of the drives for each kind of step that needs no feedback."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.programmes.motion import DriveStates, SpeedProfile, StepMotion
from slider_drilling.programmes.steps import (
    Action,
    BlockSpeed,
    DrillOff,
    Flow,
    MakeConnection,
    PickUp,
    Rest,
    Rock,
    Rotate,
    SlackOff,
    key_of,
)
from slider_drilling.rig import Rig

BLOCK_ACCELERATION = 0.05  # m/s2: full tripping speed in 40 s, drilling speed at once
_BLOCK_RAMP = 2.0  # s, between two speeds of drilling
_PUMP_RAMP = 10.0  # s, of a connection
_MOST_STRETCH = 1.0  # m by which weight shortens a string
_APPROACH_SPEED, _APPROACH_HEIGHT = 0.05, 0.5  # m/s and m above bottom, of a rotating bit that is lowered to it


@dataclass
class _Planner:
    """The three profiles of a step while they are made."""

    start: DriveStates
    displacement: float
    acceleration: float
    top_drive: SpeedProfile
    block: SpeedProfile
    pump: SpeedProfile
    block_speed: float

    def turn_at(self, speed: float) -> None:
        """Bring the top drive to a speed, rad/s."""
        self.top_drive.ramp(speed, abs(speed - self.top_drive.speed) / self.acceleration)

    def lower_at(self, speed: float, ramp: float | None = None) -> None:
        """Bring the block to a speed, m/s, within a time, s."""
        change = abs(speed - self.block.speed)
        self.block.ramp(speed, max(_BLOCK_RAMP, change / BLOCK_ACCELERATION) if ramp is None else ramp)

    def wait_for_all(self) -> float:
        """Let every drive go on as it is until the slowest has ended; returns that time, s."""
        profiles = self.top_drive, self.block, self.pump
        until = max(profile.duration for profile in profiles)
        for profile in profiles:
            profile.hold_until(until)
        return until

    def finish(self, time: float = 0.0) -> StepMotion:
        """The motion, at least so long, s."""
        self.block.hold_until(time)
        duration = self.wait_for_all()
        deepest = max(self.start.deepest, self.block.highest)
        # What the bit weighs is not known beforehand; measured positions replace this in a run.
        touching = max(self.start.touching, deepest - _MOST_STRETCH)
        end = DriveStates(self.top_drive.position, self.top_drive.speed, self.block.position, self.block.speed,
                          self.block_speed, self.pump.speed, deepest, touching)  # fmt: skip
        return StepMotion(duration, self.top_drive, self.block, self.pump, end)


def plan_motion(action: Action, start: DriveStates, rig: Rig, acceleration: float, where: str) -> StepMotion:
    """The motion of one step.

    Args:
        action: The step.
        start: Where the drives are.
        rig: For the pump.
        acceleration: Of the top drive, rad/s2.
        where: Names the step in errors.

    Raises:
        InputError: The step needs feedback, or its numbers do not fit the state in which it starts.
    """
    plan = _PLANS.get(type(action))
    if plan is None:
        raise InputError(f"{where}: a {key_of(action)} depends on what is measured, so its motion is not known "
                         "beforehand; run it with a controller")  # fmt: skip
    planner = _Planner(
        start, rig.mud_pump.displacement, acceleration, SpeedProfile(start.angle, start.turning),
        SpeedProfile(start.block, start.lowering), SpeedProfile(0.0, start.pump), start.block_speed,
    )  # fmt: skip
    return plan(action, planner, where)


def _rotate(action: Rotate, planner: _Planner, where: str) -> StepMotion:
    speed = planner.block_speed if action.block_speed is None else action.block_speed
    planner.turn_at(action.speed)
    if action.length is None:
        planner.lower_at(speed)
        return planner.finish(action.time or 0.0)
    if speed <= 0.0:
        raise InputError(f"{where}: length = {action.length:g} m needs a block that is lowered; give this step a "
                         "block_speed, or put a block_speed step before it")  # fmt: skip
    block, height = planner.block, planner.start.touching - planner.block.position
    if height > _APPROACH_HEIGHT:
        planner.lower_at(0.0)
        block.hold_until(planner.top_drive.duration)
        left = planner.start.touching - _APPROACH_HEIGHT - block.position
        block.travel(left, _APPROACH_SPEED, BLOCK_ACCELERATION)
    planner.lower_at(speed)
    left = planner.start.deepest + action.length - block.position
    block.hold(max(left, 0.0) / speed)
    return planner.finish()


def _rock(action: Rock, planner: _Planner, where: str) -> StepMotion:
    drive = planner.top_drive
    planner.turn_at(0.0)
    planner.lower_at(planner.block_speed if action.block_speed is None else action.block_speed)
    began = drive.duration
    _cycle(action, drive, planner.acceleration)
    cycle = drive.duration - began
    if action.time is not None and cycle > action.time:
        raise InputError(f"{where}: time = {action.time:g} s: one cycle takes {cycle:.1f} s; give more time, fewer "
                         "wraps or a higher speed")  # fmt: skip
    cycles = action.cycles if action.time is None else int(action.time / cycle)
    for _ in range((cycles or 1) - 1):
        _cycle(action, drive, planner.acceleration)
    drive.hold_until(began + (action.time or 0.0))
    return planner.finish()


def _cycle(action: Rock, drive: SpeedProfile, acceleration: float) -> None:
    """Right end, left end and back to the centre."""
    for end, distance in ((True, action.right), (True, -action.right - action.left), (False, action.left)):
        drive.travel(distance, action.speed, acceleration)
        if end:
            drive.hold(action.rest)


def _rest(action: Rest, planner: _Planner, where: str) -> StepMotion:
    planner.turn_at(0.0)
    planner.lower_at(planner.block_speed)
    return planner.finish(action.time)


def _pick_up(action: PickUp, planner: _Planner, where: str) -> StepMotion:
    return _move_block(planner, -action.distance, action.speed)


def _slack_off(action: SlackOff, planner: _Planner, where: str) -> StepMotion:
    return _move_block(planner, action.distance, action.speed)


def _move_block(planner: _Planner, distance: float, speed: float) -> StepMotion:
    planner.lower_at(0.0)
    planner.block.travel(distance, speed, BLOCK_ACCELERATION)
    planner.block_speed = 0.0
    return planner.finish()


def _flow(action: Flow, planner: _Planner, where: str) -> StepMotion:
    planner.lower_at(planner.block_speed)
    planner.pump.ramp(action.flow / planner.displacement, action.ramp)
    return planner.finish(action.ramp)


def _block_speed(action: BlockSpeed, planner: _Planner, where: str) -> StepMotion:
    planner.lower_at(action.speed, action.ramp)
    planner.block_speed = action.speed
    return planner.finish(action.ramp)


def _drill_off(action: DrillOff, planner: _Planner, where: str) -> StepMotion:
    planner.lower_at(0.0)
    return planner.finish(action.time)


def _connection(action: MakeConnection, planner: _Planner, where: str) -> StepMotion:
    pump = planner.pump.speed
    planner.lower_at(0.0)
    planner.block.travel(-action.distance, PickUp.speed, BLOCK_ACCELERATION)
    planner.block_speed = 0.0
    planner.top_drive.hold_until(planner.block.duration)
    planner.turn_at(0.0)
    planner.pump.hold_until(planner.wait_for_all())
    planner.pump.ramp(0.0, _PUMP_RAMP)
    planner.pump.hold(action.time)
    planner.pump.ramp(pump, _PUMP_RAMP)
    return planner.finish()


_PLANS: dict[type, Callable[[Any, _Planner, str], StepMotion]] = {
    Rotate: _rotate, Rock: _rock, Rest: _rest, PickUp: _pick_up, SlackOff: _slack_off, Flow: _flow,
    BlockSpeed: _block_speed, DrillOff: _drill_off, MakeConnection: _connection,
}  # fmt: skip
