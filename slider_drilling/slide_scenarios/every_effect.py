"""What `closed-loop --all` adds: each effect of the registry at two sizes on three wells, then pairs of effects.

The controller knows none of them.
"""

from __future__ import annotations

from slider_drilling.effects import EFFECTS, effects_with
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig
from slider_drilling.slide_scenarios.scenario import WELLS, Scenario

DURATION_S = 1200.0
PAIRS = (("torsional_compliance", "motor_wear"), ("cuttings_bed", "torque_sensor_bias"), ("stribeck", "heave"),
         ("friction_drift", "torque_sensor_lag"), ("tortuosity", "torsional_compliance"),
         ("top_drive_backlash", "static_aging"))  # fmt: skip


def every_effect() -> tuple[Scenario, ...]:
    """Returns the scenarios.

    Raises:
        InputError: The installation lacks a rig file.
    """
    lengths = {well: load_rig(installed_file(file)).string.length for well, file in WELLS.items()}
    scenarios = [_scenario((name,), size, well, length) for name in EFFECTS for size in ("small", "large")
                 for well, length in lengths.items()]  # fmt: skip
    scenarios += [_scenario(pair, "small", well, length) for pair in PAIRS for well, length in lengths.items()]
    return tuple(scenarios)


def _scenario(names: tuple[str, ...], size: str, well: str, length: float) -> Scenario:
    sections = {name: EFFECTS[name].sizes.values(size, length) for name in names}
    title = " and ".join(EFFECTS[name].title for name in names)
    about = "; ".join(f"{key} {value:g}" for section in sections.values() for key, value in section.items())
    return Scenario(f"{title}, {size}, {well}", well, about, duration=DURATION_S, effects=effects_with(**sections))
