"""What goes into the plant and what comes out, as records over time."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.errors import InputError

_COMMANDS = ("time", "top_drive_angle", "top_drive_speed", "block_position", "block_speed", "pump_speed")


@dataclass(frozen=True)
class Commands:
    """What moves the plant, each (n,), sampled at ``time`` and joined by cubics through values and slopes.

    time: s, increasing. top_drive_angle: rad; top_drive_speed: rad/s; block_position: m lowered; block_speed: m/s,
    positive lowers; pump_speed: rad/s of the crank (joined linearly).
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
                raise ValueError(f"commands: {name} has shape {values.shape}, time {np.shape(self.time)}")
            if not np.isfinite(values).all():
                raise ValueError(f"commands: {name} holds a value that is not finite")
        if not (self.time[1:] > self.time[:-1]).all():
            raise ValueError("commands: time must increase")

    def rows(self) -> Array:
        """(n, 5) as the kernel reads them."""
        rows = np.empty((len(self.time), len(_COMMANDS) - 1))
        for column, name in enumerate(_COMMANDS[1:]):
            rows[:, column] = getattr(self, name)
        return rows

    def samples(self, rows: slice | NDArray[Any]) -> Commands:
        """Some of the samples: a slice of them, or those that a mask (n,) is true for."""
        return Commands(*(getattr(self, name)[rows] for name in _COMMANDS))

    def resampled(self, time: Array) -> Commands:
        """The same motion sampled at other times (m,), held still outside its own."""
        inside = np.clip(time, self.time[0], self.time[-1])
        cell = np.clip(np.searchsorted(self.time, inside, side="right") - 1, 0, max(len(self.time) - 2, 0))
        angle = _cubic(self.time, self.top_drive_angle, self.top_drive_speed, cell, inside)
        block = _cubic(self.time, self.block_position, self.block_speed, cell, inside)
        pump = np.interp(inside, self.time, self.pump_speed)
        return Commands(np.asarray(time, dtype=float), *angle, *block, pump)


@dataclass(frozen=True)
class Response:
    """What the plant does at ``time``, free of noise, each (n,).

    surface_torque: N m, what the top drive feels; hook_load: N; standpipe_pressure: Pa; tool_face: rad, unwrapped,
    rotation of the lowest element; tool_face_rate: rad/s; bit_torque: N m; weight_on_bit: N; differential_pressure:
    Pa, of the motor; bit_depth: m of measured depth; rate_of_penetration: m/s, the bit's axial speed.
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
    """Values and slopes of the cubic Hermite through (value, slope) at times ``at`` within their cells."""
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
    """The response itself. Raises InputError where it holds anything but finite numbers, and says from when on.

    Each number of the rig file may be possible and all of them together not: a step can then outrun itself. Fits
    try such sets, and must see what comes of them; whoever runs a rig must hear of it.
    """
    wrong = np.zeros(response.time.shape, dtype=bool)
    for column in fields(Response):
        wrong |= ~np.isfinite(getattr(response, column.name))
    if wrong.any():
        raise InputError(
            f"simulation: no finite numbers from {response.time[wrong.argmax()]:g} s on: the rig file's numbers, each "
            "possible by itself, do not go together; take effects out one by one"
        )
    return response
