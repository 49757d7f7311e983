"""A row of a rocking plan as settings of the controllers: `FixedRocking` and `SlideController`."""

from __future__ import annotations

from dataclasses import asdict, fields

import yaml

from slider_drilling.control.fixed_rocking import FixedRockingSettings
from slider_drilling.control.settings import check
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.plan import PlanRow


def fixed_rocking_settings(rig: Rig, row: PlanRow) -> FixedRockingSettings:
    """Settings with which `FixedRocking` rocks as planned. Raises InputError where one is out of its range."""
    settings = FixedRockingSettings(
        amplitude=round(row.drive.amplitude, 4),
        period=round(row.drive.period, 3),
        rounding=round(row.drive.rounding, 4),
        block_speed=round(row.load.rate_of_penetration, 6),
        pump_speed=round(rig.reference_pump_speed, 4),
    )
    check(settings)
    return settings


def slide_settings(row: PlanRow) -> SlideSettings:
    """Settings with which `SlideController` rocks as planned and keeps the plan's torque limits.

    Raises:
        InputError: One is out of its range.
    """
    settings = SlideSettings(
        amplitude=round(row.drive.amplitude, 4),
        period=round(row.drive.period, 3),
        make_up_torque_limit=round(row.limits.right, 1),
        back_off_torque_limit=round(row.limits.left, 1),
        differential_pressure=round(row.load.differential_pressure, 1),
        rate_of_penetration=round(row.load.rate_of_penetration, 6),
    )
    check(settings)
    return settings


def parameters_file(controller: str, settings: FixedRockingSettings | SlideSettings, heading: str) -> str:
    """The settings that differ from their defaults, as a ROS parameters file of the node `rocking_controller`.

    Args:
        controller: module:Class.
        settings: Of that controller.
        heading: Comment in the first line.
    """
    changed = {field.name: value for field in fields(settings)
               if (value := asdict(settings)[field.name]) != field.default}  # fmt: skip
    tree = {"/**/rocking_controller": {"ros__parameters": {"controller": controller, **changed}}}
    return f"# {heading}\n{yaml.safe_dump(tree, sort_keys=False)}"
