"""Disturbances by the coefficients of free forms: of commands, friction and the bit's torque over a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.nuisance import ANISOTROPY
from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, Values

KNOTS = 8  # of a curve over time
QUARTERS = 4  # of a turn: knots of friction over the pipe's angle
_PREFIX = "moved."  # of all coefficients
ANGLE, BLOCK, SHARE = f"{_PREFIX}angle_", f"{_PREFIX}block_", f"{_PREFIX}angle_share"
FRICTION, AROUND = f"{_PREFIX}friction_", f"{_PREFIX}friction_at_"
TURNING = f"{_PREFIX}turning_difference"
PUMP, BITE = f"{_PREFIX}pump_", f"{_PREFIX}bite_"
ACROSS, GIVE = f"{_PREFIX}across", f"{_PREFIX}give"


def disturbance_key(values: Values) -> tuple[tuple[str, float], ...]:
    """Values in which the sets of a batch may not differ: they change commands, factors, or the friction curve."""
    return tuple(
        sorted((name, value) for name, value in values.items() if name.startswith(_PREFIX) or name == ANISOTROPY)
    )


def friction_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) factor of all friction at the commands' times, None without such a coefficient.

    It is piecewise linear over time, and over the drive's angle, which stands for the pipe's.
    """
    if not any(name.startswith(FRICTION) for name in values):
        return None
    knots = np.arange(QUARTERS + 1) / QUARTERS
    by_angle = [values.get(f"{AROUND}{k % QUARTERS}", 0.0) for k in range(QUARTERS + 1)]
    angle_part = np.interp(commands.top_drive_angle / (2.0 * np.pi) % 1.0, knots, by_angle)
    return np.asarray(1.0 + _line(commands.time, values, FRICTION) + angle_part)


def turning_difference(values: Values) -> float:
    """Share by which friction is larger while an element turns right (`slider_drilling.drillstring.Modifiers`)."""
    return values.get(TURNING, 0.0)


def bit_torque_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) factor of the bit's torque per weight at the commands' times, None without such a coefficient."""
    if not any(name.startswith(BITE) for name in values):
        return None
    return 1.0 + _line(commands.time, values, BITE)


def disturbed_commands(commands: Commands, values: Values) -> Commands:
    """The commands with an added angle (rad), block position (m) and share of the pump's speed over time."""
    if not disturbance_key(values):
        return commands
    angle, block = _line(commands.time, values, ANGLE), _line(commands.time, values, BLOCK)
    share = values.get(SHARE, 0.0)
    turned = commands.top_drive_angle - commands.top_drive_angle[0]
    return replace(
        commands,
        top_drive_angle=commands.top_drive_angle + angle + share * turned,
        top_drive_speed=commands.top_drive_speed * (1.0 + share) + np.gradient(angle, commands.time),
        block_position=commands.block_position + block,
        block_speed=commands.block_speed + np.gradient(block, commands.time),
        pump_speed=commands.pump_speed * (1.0 + _line(commands.time, values, PUMP)),
    )


def _line(time: Array, values: Values, prefix: str) -> Array:
    knots = np.linspace(time[0], time[-1], KNOTS)
    heights = np.array([values.get(f"{prefix}{k}", 0.0) for k in range(KNOTS)])
    return np.interp(time, knots, heights)
