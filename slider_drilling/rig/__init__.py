"""The rig file: everything that a simulation needs, read from YAML and checked."""

from slider_drilling.rig.assumptions import Assumption
from slider_drilling.rig.parts import (
    FLOW_EXPONENT,
    Asperity,
    Bit,
    Contact,
    DrawWorks,
    FrictionInterval,
    Hydraulics,
    Motor,
    Mud,
    MudPump,
    Mwd,
    Sensor,
    Sensors,
    String,
    StringSection,
    TopDrive,
    Well,
)
from slider_drilling.rig.rig_file import (
    SCHEMA,
    Rig,
    check_duration,
    check_rig,
    dump_rig,
    load_rig,
    parse_rig,
    rig_from_tree,
    rig_tree,
)

__all__ = [
    "FLOW_EXPONENT", "SCHEMA", "Asperity", "Assumption", "Bit", "Contact", "DrawWorks", "FrictionInterval",
    "Hydraulics", "Motor", "Mud", "MudPump", "Mwd", "Rig", "Sensor", "Sensors", "String", "StringSection", "TopDrive",
    "Well", "check_duration", "check_rig", "dump_rig", "load_rig", "parse_rig", "rig_from_tree", "rig_tree",
]  # fmt: skip
