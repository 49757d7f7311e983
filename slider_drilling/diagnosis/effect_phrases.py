"""Sites and effects in a driller's words."""

from __future__ import annotations

from collections.abc import Mapping

from slider_drilling.diagnosis.rig_changes import RIG_CHANGES
from slider_drilling.effects import EFFECTS
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Sentence, format_number, sentence

SITES = {
    "sensor": "the surface sensors",
    "top_drive": "the top drive",
    "draw_works": "the drawworks",
    "string": "the string",
    "contact": "the contact between string and hole",
    "motor": "the mud motor",
    "bit": "the bit and the rock",
    "hydraulics": "the hydraulics",
}


def effect_phrase(effect: str, values: Mapping[str, float]) -> Sentence:
    """What an effect of this size means: one clause that begins with a capital.

    Args:
        effect: Name in the catalogue, of a change of the rig, or of a user's effect.
        values: Fitted parameters by their short names. The amplitude must be there; others are mentioned if given.
    """
    if effect in RIG_CHANGES:
        return sentence(RIG_CHANGES[effect].phrase(next(iter(values.values()))))
    if effect not in EFFECTS:
        settings = ", ".join(f"{name} {format_number(value)}" for name, value in values.items())
        return sentence(f"{plain_name(effect).capitalize()} ({settings})")
    return sentence(EFFECTS[effect].phrase(values))
