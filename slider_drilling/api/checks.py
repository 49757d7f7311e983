"""What a run is asked for, checked before it starts: each number by itself, and against the rig that it is asked of."""

from __future__ import annotations

import math

from slider_drilling.drillstring import Commands, InitialState
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, check_duration

MAX_SAMPLES = 5_000_000
"""Of a run that is held in memory: 139 h at 10 Hz. Longer ones are recorded, by ``slider-drilling run``."""
MIN_ELEMENTS, MAX_ELEMENTS = 10, 5000


def check_run(
    rig: Rig, duration: float, target: float, seed: int, elements: int, start: InitialState, caller: str
) -> None:
    """Raises InputError naming the argument that a run of ``duration`` s cannot have; ``what``: the function."""
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"{caller}: duration = {duration} s: must be finite and above 0")
    samples = duration * rig.sensors.rate
    if not 1.0 <= round(samples) <= MAX_SAMPLES:
        raise InputError(
            f"{caller}: duration = {duration:g} s: makes {samples:.3g} samples at {rig.sensors.rate:g} Hz; "
            f"a run has 1 to {MAX_SAMPLES}"
        )
    check_duration(rig, duration, caller)
    for name, value in (("target", target), ("start.twist", start.twist), ("start.offset", start.tool_face_offset)):
        if not math.isfinite(value):
            raise InputError(f"{caller}: {name} = {value}: must be a finite number of rad")
    check_seed(seed, caller)
    check_elements(elements, caller)


def check_commands(rig: Rig, commands: Commands, caller: str) -> None:
    """Raises InputError where commands drive nothing, or last longer than the rig's friction does."""
    if len(commands.time) < 2:
        raise InputError(f"{caller}: commands: {len(commands.time)} sample(s); give at least two")
    check_duration(rig, float(commands.time[-1] - commands.time[0]), caller)


def check_seed(seed: int, caller: str) -> None:
    """Raises InputError for a seed that no random generator takes."""
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"{caller}: seed = {seed!r}: must be a whole number of at least 0")


def check_elements(elements: int, caller: str) -> None:
    """Raises InputError for a number of elements that no mesh is made of."""
    if not isinstance(elements, int) or not MIN_ELEMENTS <= elements <= MAX_ELEMENTS:
        raise InputError(f"{caller}: elements = {elements!r}: must be within {MIN_ELEMENTS} to {MAX_ELEMENTS}")
