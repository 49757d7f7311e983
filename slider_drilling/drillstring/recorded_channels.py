"""Recorded channels: commands that drive the plant, and its response, over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.errors import InputError

_COMMANDS = ("time", "top_drive_angle", "top_drive_speed", "block_position", "block_speed", "pump_speed")


@dataclass(frozen=True)
class Commands:
    """What drives the plant, each (n,); cubics through values and slopes join the samples.

    Attributes:
        time: s, increasing.
        top_drive_angle, top_drive_speed: rad and rad/s.
        block_position, block_speed: m lowered and m/s, positive lowers.
        pump_speed: rad/s of the crank, joined linearly.
    """

    time: Array
    top_drive_angle: Array
    top_drive_speed: Array
    block_position: Array
    block_speed: Array
    pump_speed: Array

    def __post_init__(self) -> None:
        for name in _COMMANDS:
            values = np.asarray(getattr(self, name), dtype=float)
            object.__setattr__(self, name, values)
            if values.shape != self.time.shape or values.ndim != 1:
                raise ValueError(
                    f"commands: {name} has shape {values.shape}, time {np.shape(self.time)}; give one shape"
                )
            # One sample is a rig that is stepped, ten times a simulated second.
            if not (math.isfinite(values[0]) if values.size == 1 else np.isfinite(values).all()):
                raise ValueError(f"commands: {name} holds a value that is not finite")
        if self.time.size > 1 and not (self.time[1:] > self.time[:-1]).all():
            raise ValueError("commands: time must increase")

    def rows(self) -> Array:
        """All but the times as columns (n, 5), as the kernel reads them."""
        rows = np.empty((len(self.time), len(_COMMANDS) - 1))
        for column, name in enumerate(_COMMANDS[1:]):
            rows[:, column] = getattr(self, name)
        return rows

    def samples(self, rows: slice | NDArray[Any]) -> Commands:
        """Some of the samples: a slice, or those for which a mask (n,) is true."""
        return Commands(*(getattr(self, name)[rows] for name in _COMMANDS))

    def resampled(self, time: Array) -> Commands:
        """The same motion at other times (m,); outside its own times it stands still."""
        inside = np.clip(time, self.time[0], self.time[-1])
        cell = np.clip(np.searchsorted(self.time, inside, side="right") - 1, 0, max(len(self.time) - 2, 0))
        angle = _cubic(self.time, self.top_drive_angle, self.top_drive_speed, cell, inside)
        block = _cubic(self.time, self.block_position, self.block_speed, cell, inside)
        pump = np.interp(inside, self.time, self.pump_speed)
        return Commands(np.asarray(time, dtype=float), *angle, *block, pump)


@dataclass(frozen=True)
class Response:
    """What the plant does, free of noise, each (n,).

    Attributes:
        time: s.
        surface_torque: N m, at the top drive.
        hook_load: N.
        standpipe_pressure: Pa.
        tool_face, tool_face_rate: rad (unwrapped) and rad/s, rotation of the lowest element.
        bit_torque: N m.
        weight_on_bit: N.
        differential_pressure: Pa, of the motor.
        bit_depth: m of measured depth.
        rate_of_penetration: m/s, the bit's axial speed.
    """

    time: Array
    surface_torque: Array
    hook_load: Array
    standpipe_pressure: Array
    tool_face: Array
    tool_face_rate: Array
    bit_torque: Array
    weight_on_bit: Array
    differential_pressure: Array
    bit_depth: Array
    rate_of_penetration: Array


def _cubic(time: Array, value: Array, slope: Array, cell: NDArray[np.intp], at: Array) -> tuple[Array, Array]:
    """Values and slopes of the Hermite cubic through (value, slope), at times ``at`` within their cells."""
    if len(time) == 1:
        return np.full_like(at, value[0]), np.zeros_like(at)
    length = time[cell + 1] - time[cell]
    u = (at - time[cell]) / length
    rise = value[cell + 1] - value[cell]
    a, b = slope[cell] * length - rise, rise - slope[cell + 1] * length
    position = value[cell] + u * (rise + (1.0 - u) * (a * (1.0 - u) + b * u))
    rate = rise + (1.0 - 2.0 * u) * (a * (1.0 - u) + b * u) + u * (1.0 - u) * (b - a)
    return position, rate / length


def require_finite(response: Response) -> Response:
    """Return the response. Raises InputError, naming the first such time, where it holds NaN or infinity.

    Each number of a rig file may be possible and all together not: a step can then become unstable. Fits try such sets
    and must see the result; a user who runs a rig gets this error.
    """
    wrong = np.zeros(response.time.shape, dtype=bool)
    for column in fields(Response):
        wrong |= ~np.isfinite(getattr(response, column.name))
    if wrong.any():
        raise InputError(
            f"simulation: no finite numbers from {response.time[wrong.argmax()]:g} s on: the rig file's numbers, each "
            "possible by itself, make the plant unstable together; switch effects off one by one"
        )
    return response
