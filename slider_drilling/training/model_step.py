"""The compiled step of many rigs whose plant is that of `drillstring`, each with its own parameters and commands."""

from __future__ import annotations

from slider_drilling.drillstring import kernel
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit
from slider_drilling.training.instruments import (
    ANGLE,
    HOOK_LOAD,
    PRESSURE,
    SPEED,
    TOOL_FACE,
    TORQUE,
    follow_commands,
    read_mwd,
    read_surface,
)
from slider_drilling.training.plant_rows import copy_values, curve_of, elements_of, lanes_of, state_of


@njit(**JIT_OPTIONS)
def step_rigs(
    first, last, samples, elements, interval, active, fresh, absolute, commands, steps, plants, no_offset, out, s, p, e,
    c, curve, state,
):  # fmt: skip
    """Step the active slots from `first` to before `last` through some samples of the sensors.

    Args:
        samples: How many; the command holds for all of them.
        elements: Of each string.
        interval: s between samples.
        active: (slots,).
        fresh: Whether the runs start: their first sample is measured, and nothing moves.
        absolute, commands: As in `follow_commands`; (slots, 4).
        steps: (rigs, 5) substeps, their length s, pulses on their way, and whether friction depends on speed or on
            rest.
        plants: (rigs,) row of each rig's plant in the constants.
        no_offset: (2, 0).
        out: (slots, 1, channels, 1).
        s, p: `InstrumentRecords`, `InstrumentSettings`.
        e, c, curve: Constants, see `plant_rows`.
        state: `KernelState` of arrays (slots, ...).
    """
    begin = 1 if fresh else 0
    for i in range(first, last):
        if not active[i]:
            continue
        k = s.rig[i]
        j = plants[k]
        own, lanes, friction = elements_of(e, j), lanes_of(c, j), curve_of(curve, j)
        now = state_of(state, i, int(steps[k, 2]))
        s.received[i] = 0
        for _ in range(samples):
            if not fresh:
                follow_commands(i, k, interval, absolute, commands[i], s, p)
            was = s.truth[i, TOOL_FACE]
            kernel.advance(
                1, elements, int(steps[k, 0]), steps[k, 1], steps[k, 3] > 0.0, steps[k, 4] > 0.0, s.rows[i, begin:],
                no_offset, own, friction, lanes, now, out[i],
            )  # fmt: skip
            truth = s.truth[i]
            copy_values(out[i, 0, :, 0], truth)
            if not fresh:
                read_mwd(i, k, interval, was, truth[TOOL_FACE], s, p)
            read_surface(i, k, fresh, truth[TORQUE], truth[HOOK_LOAD], truth[PRESSURE], s, p)
            s.readings[i, ANGLE], s.readings[i, SPEED] = s.drives[i, 0], s.drives[i, 1]
