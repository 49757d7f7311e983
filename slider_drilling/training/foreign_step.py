"""The compiled step of many rigs of foreign structure, each with its own parameters, structure and commands."""

from __future__ import annotations

from slider_drilling.blind.foreign import kernel
from slider_drilling.blind.foreign.instruments import SHEAVE_REVERSAL_SPEED
from slider_drilling.drillstring.kernel_arrays import CHANNELS
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit
from slider_drilling.training.instruments import (
    ANGLE,
    HOOK_LOAD,
    PRESSURE,
    SPEED,
    TOOL_FACE,
    TORQUE,
    follow_commands,
    next_normal,
    read_mwd,
    read_surface,
)
from slider_drilling.training.plant_rows import EXACT, copy_values, foreign_elements_of, foreign_run_of

# Columns of `instruments`: what a foreign rig's instruments make of its channels (`blind.foreign.instruments`).
JITTER, ENCODER_STEP, HOOK_GAIN, HOOK_OFFSET, HYSTERESIS, HELD = range(6)
_CHANNELS = len(CHANNELS)


@njit(**EXACT)
def _late(was, now, share):
    """A value that is read a share of an interval late."""
    return now + share * (was - now)


@njit(**EXACT)
def _hook_load(k, truth, drives, instruments):
    """Hook load as the dead line shows it, N."""
    settings = instruments[k]
    load = truth[HOOK_LOAD] * (1.0 + settings[HOOK_GAIN]) + settings[HOOK_OFFSET]
    return load - settings[HYSTERESIS] * drives[3] / (abs(drives[3]) + SHEAVE_REVERSAL_SPEED)


@njit(**EXACT)
def _set_slow_changes(row, changes, time):
    """Factors of friction, bit torque and pressure into columns 6 to 8 of a row; changes: (m, 4), one a second."""
    cell = min(int(time), len(changes) - 2)
    u = min(time - cell, 1.0)
    for column in range(3):
        row[6 + column] = changes[cell, 1 + column] + u * (changes[cell + 1, 1 + column] - changes[cell, 1 + column])


@njit(**JIT_OPTIONS)
def step_foreign_rigs(
    first, last, samples, interval, active, fresh, absolute, commands, steps, plants, rows, driven, held, out, s, p, e,
    friction, runs, instruments, slow_changes, state,
):  # fmt: skip
    """As `model_step.step_rigs`, for rigs of foreign structure.

    Args:
        first, last, samples, interval, active, fresh, absolute, commands, s, p: As there.
        steps: (rigs, 5) substeps, their length s and pulses on their way; the rest is not used.
        plants: (rigs,) number of the foreign plant of each rig.
        rows: (slots, 2, 9) the plant's commands: time s, drives, slow factors.
        driven: (slots, 2) true angle rad and speed rad/s of the drive at the last sample.
        held: (slots, 2) hook load N, and the time until which its reading is held, s.
        out: (slots, 1, channels + 2).
        e, runs: Constants, see `plant_rows`.
        friction: (plants, size) coefficients over the slip's direction.
        instruments: (plants, 6).
        slow_changes: (plants, m, 4).
        state: Tuple of arrays (slots, ...) in the order of `ForeignState`.
    """
    begin = 1 if fresh else 0
    position, speed, rotation, rotation_speed, stretch_axial, stretch_tangential, rest, scalars, pulses = state
    for i in range(first, last):
        if not active[i]:
            continue
        k = s.rig[i]
        j = plants[k]
        own, run, step = foreign_elements_of(e, j), foreign_run_of(runs, j), instruments[j, ENCODER_STEP]
        s.received[i] = 0
        for _ in range(samples):
            if not fresh:
                follow_commands(i, k, interval, absolute, commands[i], s, p)
            row, time, truth = rows[i, 1], s.samples[i] * interval, s.truth[i]
            copy_values(row, rows[i, 0])
            row[0] = time
            copy_values(s.drives[i], row[1:6])
            _set_slow_changes(row, slow_changes[j], time)
            was, torque, pressure = truth[TOOL_FACE], truth[TORQUE], truth[PRESSURE]
            kernel.advance(
                rows[i, begin:], int(steps[k, 0]), steps[k, 1], own, friction[j], run, position[i], speed[i],
                rotation[i], rotation_speed[i], stretch_axial[i], stretch_tangential[i], rest[i], scalars[i],
                pulses[i, : int(steps[k, 2])], out[i], fresh,
            )  # fmt: skip
            copy_values(out[i, 0], truth)
            angle, rate = out[i, 0, _CHANNELS], out[i, 0, _CHANNELS + 1]
            late = 0.0
            if not fresh:
                late = min(abs(next_normal(i, s)) * instruments[j, JITTER] / interval, 1.0)
                read_mwd(i, k, interval, was, truth[TOOL_FACE], s, p)
            if fresh:
                torque, pressure, held[i, 1] = truth[TORQUE], truth[PRESSURE], 0.0
                driven[i, 0], driven[i, 1] = angle, rate
            if time >= held[i, 1]:
                held[i, 0] = _hook_load(j, truth, s.drives[i], instruments)
                held[i, 1] = time + instruments[j, HELD] - 0.5 * interval
            read_surface(
                i, k, fresh, _late(torque, truth[TORQUE], late), held[i, 0],
                _late(pressure, truth[PRESSURE], late), s, p,
            )  # fmt: skip
            shown = _late(driven[i, 0], angle, late)
            s.readings[i, ANGLE] = round(shown / step) * step if step > 0.0 else shown
            s.readings[i, SPEED] = _late(driven[i, 1], rate, late)
            driven[i, 0], driven[i, 1] = angle, rate
