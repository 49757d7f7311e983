"""What `closed-loop --all` adds: each effect of the catalogue at two sizes on three wells, then two at once.

The sizes are what a rig has on a good day and on a bad one. The controller is told of none of them.
"""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.closed_loop.scenario import WELLS, Scenario
from slider_drilling.closed_loop.scenarios import effects_with
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig

DURATION_S = 1200.0

Block = dict[str, float]


@dataclass(frozen=True)
class _Sizes:
    """An effect's parameters, small and large; along: those that are shares of the string's length."""

    small: Block
    large: Block
    along: tuple[str, ...] = ()

    def of(self, size: str, length: float) -> Block:
        block = self.small if size == "small" else self.large
        return {key: value * length if key in self.along else value for key, value in block.items()}


CATALOGUE: dict[str, _Sizes] = {
    "stribeck": _Sizes({"drop": 0.2}, {"drop": 0.6}),
    "viscous_drag": _Sizes({"coefficient": 5.0}, {"coefficient": 25.0}),
    "static_aging": _Sizes({"growth": 0.2}, {"growth": 0.6}),
    "buckling_contact": _Sizes({"factor": 0.3}, {"factor": 1.0}),
    "cuttings_bed": _Sizes({"factor": 1.8, "top": 0.64, "bottom": 0.72}, {"factor": 3.5, "top": 0.64, "bottom": 0.72},
                           ("top", "bottom")),
    "tortuosity": _Sizes({"curvature": 2e-4}, {"curvature": 8e-4}),
    "friction_drift": _Sizes({"rate": 1e-4}, {"rate": 4e-4}),
    "top_drive_backlash": _Sizes({"angle": 0.1}, {"angle": 0.5}),
    "torsional_compliance": _Sizes({"extra": 0.04}, {"extra": 0.13}),
    "axial_oscillation_tool": _Sizes({"force": 5e3, "depth": 0.7}, {"force": 2e4, "depth": 0.7}, ("depth",)),
    "heave": _Sizes({"amplitude": 0.05, "period": 9.0}, {"amplitude": 0.2, "period": 11.0}),
    "motor_wear": _Sizes({"torque_loss": 0.1}, {"torque_loss": 0.25, "extra_leak": 0.2}),
    "formation_change": _Sizes({"factor": 0.7, "time": 600.0}, {"factor": 2.0, "time": 600.0}),
    "torque_sensor_gain": _Sizes({"gain": 0.03}, {"gain": -0.1}),
    "torque_sensor_lag": _Sizes({"lag": 0.2}, {"lag": 0.8}),
    "torque_sensor_bias": _Sizes({"bias": 150.0}, {"bias": -500.0}),
    "torque_at_motor": _Sizes({"inertia": 400.0, "friction": 100.0}, {"inertia": 1500.0, "friction": 400.0}),
}
PAIRS = (("torsional_compliance", "motor_wear"), ("cuttings_bed", "torque_sensor_bias"), ("stribeck", "heave"),
         ("friction_drift", "torque_sensor_lag"), ("tortuosity", "torsional_compliance"),
         ("top_drive_backlash", "static_aging"))


def every_effect() -> tuple[Scenario, ...]:
    """Raises InputError where the installation lacks a rig file."""
    lengths = {well: load_rig(installed_file(file)).string.length for well, file in WELLS.items()}
    found = [_one((name,), size, well, length) for name in CATALOGUE for size in ("small", "large")
             for well, length in lengths.items()]
    found += [_one(pair, "small", well, length) for pair in PAIRS for well, length in lengths.items()]
    return tuple(found)


def _one(names: tuple[str, ...], size: str, well: str, length: float) -> Scenario:
    blocks = {name: CATALOGUE[name].of(size, length) for name in names}
    words = " and ".join(name.replace("_", " ") for name in names)
    about = "; ".join(f"{key} {value:g}" for block in blocks.values() for key, value in block.items())
    return Scenario(f"{words}, {size}, {well}", well, about, duration=DURATION_S, effects=effects_with(**blocks))
