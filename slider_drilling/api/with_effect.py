"""A rig whose plant has an effect that its rig file does not state."""

from __future__ import annotations

from typing import Any

from slider_drilling.api.checks import check_rig
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.changes import parse_number
from slider_drilling.schema.quantity_text import split_quantity


def with_effect(rig: Rig, effect: str) -> Rig:
    """Returns the rig with one effect of the catalogue added to its plant.

    Args:
        rig: The rig as its file states it.
        effect: ``"stribeck"`` for a usual size, or with values in the units of the rig file:
            ``"stribeck:drop=0.4,speed=0.05"``. Values that are not given have their usual size.

    Raises:
        InputError: There is no such effect or key, or a value is out of range.
    """
    check_rig(rig, "with_effect")
    if not isinstance(effect, str):
        raise InputError(f"effect: {type(effect).__name__} is no effect; write NAME, or NAME:KEY=VALUE")
    name, colon, given = effect.partition(":")
    without_values = name.partition("=")[0]
    if without_values in EFFECTS and name not in EFFECTS:
        raise InputError(f"effect = {effect!r}: give its values by their keys, as in {without_values}:KEY=VALUE")
    if name not in EFFECTS:
        raise InputError(f"effect = {name!r}: no such effect; one of {', '.join(EFFECTS)}")
    values: dict[str, Any] = dict(EFFECTS[name].sizes.values("usual", rig.string.length))
    for pair in given.split(",") if colon else ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"effect = {effect!r}: {pair!r} is not KEY=VALUE")
        values[key.strip()] = _number_or_quantity(text, f"effect {name}: {key.strip()}")
    return rig.with_({f"effects.{name}": values})


def _number_or_quantity(text: str, what: str) -> float | str:
    """A number, or a number with its unit, which the rig file's schema converts."""
    return text if split_quantity(text) is not None else parse_number(text, what)
