"""The rig file: everything that a simulation needs, read from YAML and checked."""

from slider_drilling.rig.file import check_rig, dump_rig, load_rig, parse_rig, rig_from_tree
from slider_drilling.rig.parts import (
    SCHEMA,
    Asperity,
    Bit,
    Contact,
    FrictionInterval,
    Hydraulics,
    Motor,
    Mud,
    MudPump,
    Mwd,
    Rig,
    Sensor,
    Sensors,
    String,
    StringSection,
    TopDrive,
    Well,
)
from slider_drilling.rig.relations import check_duration

__all__ = [
    "SCHEMA",
    "Asperity",
    "Bit",
    "Contact",
    "FrictionInterval",
    "Hydraulics",
    "Motor",
    "Mud",
    "MudPump",
    "Mwd",
    "Rig",
    "Sensor",
    "Sensors",
    "String",
    "StringSection",
    "TopDrive",
    "Well",
    "check_duration",
    "check_rig",
    "dump_rig",
    "load_rig",
    "parse_rig",
    "rig_from_tree",
]  # fmt: skip
