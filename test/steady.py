"""The example well with an effect, turned and lowered steadily."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.rig import Rig, load_rig

EXAMPLE = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
PUMP = EXAMPLE.hydraulics.reference_flow / EXAMPLE.mud_pump.displacement


def with_effect(rig: Rig, **effects) -> Rig:
    return dataclasses.replace(rig, effects=dataclasses.replace(rig.effects, **effects))


def commands(duration: float, speed: float = 0.0, block_speed: float = 0.0, pump: float = PUMP, rise: float = 2.0):
    """Turn and lower steadily after a smooth start of ``rise`` seconds."""
    time = np.arange(0.0, duration + 0.05, 0.1)
    ramp = 1.0 - np.exp(-time / rise)
    way = time - rise * ramp
    return Commands(time, speed * way, speed * ramp, block_speed * way, block_speed * ramp, pump + 0.0 * time)
