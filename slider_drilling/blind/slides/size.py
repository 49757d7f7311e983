"""How large something is in a slide: what it changes in the readings, in noise levels, over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.blind.slides.beginnings import Beginning
from slider_drilling.blind.slides.case import SlideCase
from slider_drilling.control.interface import Measurements
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.drillstring import Commands, Response, simulate_batch
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

WINDOW_S = 60.0
"""Time over which a size is the root mean square of a change."""
VISIBLE = 1.5
"""Noise levels from which a change must be seen."""
_ELEMENTS = 60
_CHANNELS = ("surface_torque", "hook_load", "standpipe_pressure")


def commands_of(measured: Sequence[Measurements]) -> Commands:
    """The motion of the drives in a run."""
    names = ("time", "top_drive_angle", "top_drive_speed", "block_position", "block_speed", "pump_speed")
    return Commands(*(np.array([getattr(sample, name) for sample in measured]) for name in names))


def size_over_time(
    rig: Rig, nuisance: dict[str, float], beginning: Beginning, case: SlideCase, commands: Commands
) -> Array:
    """(n,) size in noise levels of the rig file at the commands' times.

    It is the root mean square of what is added over the last `WINDOW_S`, in the channel that changes most, times the
    share that has grown. The arguments are those of `added_over_time`.
    """
    added = added_over_time(rig, nuisance, beginning, case, commands)
    samples = max(round(WINDOW_S / INTERVAL_S), 1)
    size = np.max([np.sqrt(_trailing_mean(each**2, samples)) for each, _ in added.values()], axis=0)
    return np.asarray(size * case.shares_at(commands.time))


def added_over_time(
    rig: Rig, nuisance: dict[str, float], beginning: Beginning, case: SlideCase, commands: Commands
) -> dict[str, tuple[Array, Array]]:
    """What the full change adds to every channel, in noise levels of the rig file, and the channel without it.

    The model's plant follows the same motion with and without the full effect.

    Args:
        rig: The rig file.
        nuisance: Multiples of its numbers, as the rig really is.
        beginning: What begins.
        case: When it begins and how it grows.
        commands: Motion of the drives, n samples.
    """
    full = dict(nuisance)
    for name, value in beginning.values(1.0, 0.25 * WINDOW_S).items():
        full[name] = value if "." in name else full.get(name, 1.0) * value
    flow = beginning.flow(1.0, 0.0)
    (neutral,) = simulate_batch([rig_with(rig, nuisance)], commands, _ELEMENTS)
    lost = commands if flow == 1.0 else replace(commands, pump_speed=flow * commands.pump_speed)
    (changed,) = simulate_batch([rig_with(rig, full)], lost, _ELEMENTS)
    read = beginning.hook_load(1.0, 0.0, 0.0)
    return {name: (_difference(name, neutral, changed, read) / _noise(rig, name), getattr(neutral, name))
            for name in _CHANNELS}  # fmt: skip


def _difference(name: str, neutral: Response, changed: Response, hook_load: float) -> Array:
    difference = getattr(changed, name) - getattr(neutral, name)
    return np.asarray(difference + (hook_load if name == "hook_load" else 0.0))


def _noise(rig: Rig, name: str) -> float:
    return float(getattr(rig.sensors, name).noise)


def _trailing_mean(values: Array, samples: int) -> Array:
    mean = uniform_filter1d(values, samples, mode="nearest", origin=(samples - 1) // 2)
    return np.asarray(np.maximum(mean, 0.0))  # running sums leave tiny negative values
