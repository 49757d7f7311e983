"""The registry of effects: what a nominal simulation leaves out, and all that the project knows about each.

An effect is a section of the rig file (``effects:``) and a law in the plant (`slider_drilling.drillstring.assemble` and
its kernel). With every parameter at its default the plant is, bit for bit, the plant without the effect. Catalogue of
the diagnosis, sealed logs, random rigs, scenarios, the option ``--effect`` and the reference page follow `EFFECTS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from slider_drilling.effects.angle_friction import AngleFriction, DirectionFriction
from slider_drilling.effects.contact import (
    CONTACT,
    BucklingContact,
    ContactEffects,
    CuttingsBed,
    FrictionDrift,
    StaticAging,
    Stribeck,
    Tortuosity,
    ViscousDrag,
)
from slider_drilling.effects.definition import EffectDefinition, FitParameter, Search, SearchInputs, Sizes
from slider_drilling.effects.drives_and_bit import (
    DRIVES_AND_BIT,
    AxialOscillationTool,
    DriveEffects,
    FormationChange,
    Heave,
    MotorWear,
    TopDriveBacklash,
    TorsionalCompliance,
)
from slider_drilling.effects.torque_reading import (
    TORQUE_READING,
    TorqueAtMotor,
    TorqueReadingEffects,
    TorqueSensorBias,
    TorqueSensorGain,
    TorqueSensorLag,
)

__all__ = [
    "EFFECTS", "SEARCH_ORDER", "AngleFriction", "AxialOscillationTool", "BucklingContact", "CuttingsBed",
    "DirectionFriction",
    "EffectDefinition", "Effects", "FitParameter", "FormationChange", "FrictionDrift", "Heave", "MotorWear", "Search",
    "SearchInputs", "Sizes", "StaticAging", "Stribeck", "TopDriveBacklash", "TorqueAtMotor", "TorqueSensorBias",
    "TorqueSensorGain", "TorqueSensorLag", "TorsionalCompliance", "Tortuosity", "ViscousDrag", "effects_with",
]  # fmt: skip


# Dataclass fields come from the last base first: contact, drives, torque reading.
@dataclass(frozen=True)
class Effects(TorqueReadingEffects, DriveEffects, ContactEffects):
    """The rig file's ``effects`` section: every effect of the catalogue. The defaults are neutral."""


_DEFINITIONS = {definition.name: definition for definition in (*CONTACT, *DRIVES_AND_BIT, *TORQUE_READING)}
EFFECTS: Mapping[str, EffectDefinition] = {field.name: _DEFINITIONS[field.name] for field in fields(Effects)}
"""Every effect by name, in the order of the rig file."""
SEARCH_ORDER = tuple(_DEFINITIONS.values())
"""Every effect, in the order in which a diagnosis tries them."""


def effects_with(**sections: Mapping[str, float]) -> Effects:
    """Returns neutral effects with some parameters changed: ``effects_with(stribeck={"drop": 0.3})``."""
    neutral = Effects()
    return replace(neutral, **{name: replace(getattr(neutral, name), **values) for name, values in sections.items()})
