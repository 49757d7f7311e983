"""Checks of the arguments of a run, before it starts."""

from __future__ import annotations

import math
import numbers

from slider_drilling.drillstring import Commands, InitialState
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, check_duration
from slider_drilling.schema.option_types import check_argument

MAX_SAMPLES = 5_000_000
"""Largest number of samples of a run in memory: 139 h at 10 Hz. ``slider-drilling run`` records longer ones."""
MIN_ELEMENTS, MAX_ELEMENTS = 10, 5000


def check_rig(rig: object, caller: str) -> None:
    """Raise InputError unless this is a rig; a path or keys and values are none yet."""
    if not isinstance(rig, Rig):
        raise InputError(f"{caller}: rig: {type(rig).__name__} is no rig; make one of it with load_rig")


def check_run(
    rig: Rig, duration: float, target: float, seed: int, elements: int, start: InitialState, caller: str
) -> None:
    """Check the arguments of a run.

    Args:
        rig: The rig to simulate.
        duration: Simulated time, s.
        target: Toolface, rad.
        seed: Seed of the sensor noise.
        elements: Elements of the string.
        start: Initial twist and toolface.
        caller: Name of the function, for the message.

    Raises:
        InputError: An argument cannot be used; the message names it.
    """
    angles = {"target": target, "start.twist": start.twist, "start.offset": start.tool_face_offset}
    for name, value in {"duration": duration, **angles}.items():
        check_argument(value, float, f"{caller}: {name}")
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"{caller}: duration = {duration} s: must be finite and above 0")
    samples = duration * rig.sensors.rate
    if not 1.0 <= round(samples) <= MAX_SAMPLES:
        raise InputError(
            f"{caller}: duration = {duration:g} s: makes {samples:.3g} samples at {rig.sensors.rate:g} Hz; "
            f"a run has 1 to {MAX_SAMPLES}"
        )
    check_duration(rig, duration, caller)
    for name, value in angles.items():
        if not math.isfinite(value):
            raise InputError(f"{caller}: {name} = {value}: must be a finite number of rad")
    check_seed(seed, caller)
    check_elements(elements, caller)


def check_commands(rig: Rig, commands: Commands, caller: str) -> None:
    """Raise InputError if there are less than two samples, or the run is too long for the rig's friction drift."""
    if len(commands.time) < 2:
        raise InputError(f"{caller}: commands: {len(commands.time)} sample(s); give at least two")
    check_duration(rig, float(commands.time[-1] - commands.time[0]), caller)


def check_seed(seed: int, caller: str) -> None:
    """Raise InputError unless the seed is a whole number of at least 0."""
    if not isinstance(seed, numbers.Integral) or seed < 0:
        raise InputError(f"{caller}: seed = {seed!r}: must be a whole number of at least 0")


def check_elements(elements: int, caller: str) -> None:
    """Raise InputError unless the number of elements is within its range."""
    if not isinstance(elements, numbers.Integral) or not MIN_ELEMENTS <= elements <= MAX_ELEMENTS:
        raise InputError(f"{caller}: elements = {elements!r}: must be within {MIN_ELEMENTS} to {MAX_ELEMENTS}")
