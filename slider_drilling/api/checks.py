"""What a run is asked for, checked before it starts: each number by itself, and against the rig that it is asked of."""

from __future__ import annotations

import math

from slider_drilling.drillstring import Commands, Start
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, check_duration

MOST_SAMPLES = 5_000_000
"""Of a run that is held in memory: 139 h at 10 Hz. Longer ones are recorded, by ``slider-drilling run``."""
FEWEST_ELEMENTS, MOST_ELEMENTS = 10, 5000


def check_run(rig: Rig, duration: float, target: float, seed: int, elements: int, start: Start, what: str) -> None:
    """Raises InputError naming the argument that a run of ``duration`` s cannot have; ``what``: the function."""
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"{what}: duration = {duration} s: must be finite and above 0")
    samples = duration * rig.sensors.rate
    if not 1.0 <= round(samples) <= MOST_SAMPLES:
        raise InputError(
            f"{what}: duration = {duration:g} s: makes {samples:.3g} samples at {rig.sensors.rate:g} Hz; "
            f"a run has 1 to {MOST_SAMPLES}"
        )
    check_duration(rig, duration, what)
    for name, value in (("target", target), ("start.twist", start.twist), ("start.offset", start.offset)):
        if not math.isfinite(value):
            raise InputError(f"{what}: {name} = {value}: must be a finite number of rad")
    check_seed(seed, what)
    check_elements(elements, what)


def check_commands(rig: Rig, commands: Commands, what: str) -> None:
    """Raises InputError where commands drive nothing, or last longer than the rig's friction does."""
    if len(commands.time) < 2:
        raise InputError(f"{what}: commands: {len(commands.time)} sample(s); give at least two")
    check_duration(rig, float(commands.time[-1] - commands.time[0]), what)


def check_seed(seed: int, what: str) -> None:
    """Raises InputError for a seed that no random generator takes."""
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"{what}: seed = {seed!r}: must be a whole number of at least 0")


def check_elements(elements: int, what: str) -> None:
    """Raises InputError for a number of elements that no mesh is made of."""
    if not isinstance(elements, int) or not FEWEST_ELEMENTS <= elements <= MOST_ELEMENTS:
        raise InputError(f"{what}: elements = {elements!r}: must be within {FEWEST_ELEMENTS} to {MOST_ELEMENTS}")
