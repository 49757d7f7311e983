"""What the instruments of a foreign rig make of its true channels, before noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array

# m/s of block speed at which half of the sheaves' friction acts: line and bearings wind up first. Another form, and
# another speed, than the diagnosis calibrates (`diagnosis.drill_string.direction_of_block`).
SHEAVE_REVERSAL_SPEED = 1e-3


def as_read(
    structure: Structure, commands: Commands, response: Response, driven: Array, generator: np.random.Generator
) -> tuple[Commands, Response]:
    """What a recorder gets to see.

    Args:
        structure: of the plant.
        commands: asked for, (n,) each.
        response: of the plant, at the same times.
        driven: (n, 2) angle rad and speed rad/s that the drive really had.
        generator: of the jitter.

    Returns:
        The commands as encoders show them, and the response as transducers show it.
    """
    time = commands.time
    taken = time + structure.clock_jitter * generator.normal(size=time.size)

    def late(values: Array) -> Array:
        return np.interp(taken, time, values)

    angle, step = late(driven[:, 0]), structure.encoder_step
    if step > 0.0:
        angle = np.round(angle / step) * step
    seen = replace(commands, top_drive_angle=angle, top_drive_speed=late(driven[:, 1]))
    hook_load = response.hook_load * (1.0 + structure.hook_load_gain) + structure.hook_load_offset
    hook_load = hook_load - structure.deadline_hysteresis * sheave_friction(commands.block_speed)
    if structure.held_hook_load > 0.0:
        hook_load = np.interp(np.floor(time / structure.held_hook_load) * structure.held_hook_load, time, hook_load)
    return seen, replace(
        response, surface_torque=late(response.surface_torque), hook_load=hook_load,
        standpipe_pressure=late(response.standpipe_pressure),
    )  # fmt: skip


def sheave_friction(block_speed: Array) -> Array:
    """Share (n,) of the sheaves' friction that acts, from -1 to 1; block_speed: m/s, positive lowers."""
    return np.asarray(block_speed / (np.abs(block_speed) + SHEAVE_REVERSAL_SPEED))
