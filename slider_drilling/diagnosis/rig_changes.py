"""Changes of a rig's own numbers during a run: candidates beside the catalogue when two logs are compared.

A single log cannot distinguish them from an error in the rig file, and calibration absorbs them. Two logs of one rig
share their calibration, so that what differs between them has a name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from slider_drilling.effects.definition import percent
from slider_drilling.gap.model import Effect, Parameter, Values

_ENDLESS = float("inf")


@dataclass(frozen=True)
class RigChange:
    """One change of the rig's numbers.

    Attributes:
        name: Its name.
        site: Where it acts.
        key: Short name of its parameter, a share; 0 is no change.
        multiplied: Calibrated parameters that it multiplies; a name that ends in ``_`` stands for all that begin so.
        sign: The multiple is ``1 + sign share``.
        physical: Range of the share that the name stands for.
        material: Smallest share that an engineer acts on.
        law: In words.
        nonphysical: What a share outside `physical` is called.
        phrase: One clause for a share.
    """

    name: str
    site: str
    key: str
    multiplied: tuple[str, ...]
    sign: float
    physical: tuple[float, float]
    material: float
    law: str
    nonphysical: str
    phrase: Callable[[float], str]

    @property
    def parameter(self) -> str:
        """Full name of its parameter."""
        return f"{self.name}.{self.key}"

    def candidate(self) -> Effect:
        """The change as a candidate of the gap engine."""
        share = Parameter(self.parameter, 0.0, -0.6, 2.0, 0.02)
        typical = 2.0 * self.material
        either_way = self.physical[0] < 0.0
        points = (typical, -typical, 3.0 * typical) if either_way else (typical, 2.0 * typical, 0.5 * typical)
        return Effect(
            self.name, self.site, (share,), tuple((point,) for point in points), self.physical, self.nonphysical,
            self.law, material={self.parameter: self.material},
        )  # fmt: skip


def _friction_phrase(share: float) -> str:
    return f"Friction along the hole is {percent(share)} {'higher' if share > 0.0 else 'lower'}"


def _hook_load_phrase(share: float) -> str:
    return f"The hook load reading is {percent(share)} {'higher' if share > 0.0 else 'lower'}"


_CHANGES = (
    RigChange(
        "washout", "hydraulics", "loss", ("pressure_gain",), -1.0, (0.0, _ENDLESS), 0.01,
        "circulating pressure times 1 - loss", "a circulating pressure that rises",
        lambda share: f"Circulating pressure is {percent(share)} lower, as with a washout",
    ),
    RigChange(
        "plugged_nozzle", "hydraulics", "rise", ("pressure_gain",), 1.0, (0.0, _ENDLESS), 0.01,
        "circulating pressure times 1 + rise", "a circulating pressure that falls",
        lambda share: f"Circulating pressure is {percent(share)} higher, as with a plugged nozzle",
    ),
    RigChange(
        "friction_change", "contact", "share", ("friction_",), 1.0, (-_ENDLESS, _ENDLESS), 0.05,
        "friction along the whole hole times 1 + share", "its opposite", _friction_phrase,
    ),
    RigChange(
        "dulling_bit", "bit", "loss", ("bit_aggressiveness",), -1.0, (0.0, _ENDLESS), 0.05,
        "bit torque per weight times 1 - loss", "a bit that gives more torque per weight",
        lambda share: f"The bit gives {percent(share)} less torque per weight",
    ),
    RigChange(
        "hook_load_gain", "sensor", "share", ("hook_load_gain",), 1.0, (-_ENDLESS, _ENDLESS), 0.01,
        "hook load reading times 1 + share", "its opposite", _hook_load_phrase,
    ),
)  # fmt: skip
RIG_CHANGES: Mapping[str, RigChange] = {change.name: change for change in _CHANGES}
"""By name."""
_BY_PARAMETER = {change.parameter: change for change in _CHANGES}


def changes_of_number(parameter: str, share: float) -> dict[str, float]:
    """Names of the changes that a moved calibrated number may stand for, with the amplitude of each.

    Args:
        parameter: The calibrated number.
        share: By which it moved.
    """
    amplitudes = {
        change.name: change.sign * share for change in _CHANGES
        if any(_covers(name, parameter) for name in change.multiplied)
        and change.physical[0] <= change.sign * share <= change.physical[1]
    }  # fmt: skip
    if parameter == "motor_gain" and share < 0.0:
        amplitudes["motor_wear"] = -share
    if parameter == "bit_stiffness":
        amplitudes["formation_change"] = 1.0 + share
    return amplitudes


def opposite_of(name: str) -> RigChange | None:
    """The change that multiplies the same numbers the other way; None where there is none."""
    own = RIG_CHANGES.get(name)
    return next(
        (each for each in _CHANGES if own and each.multiplied == own.multiplied and each.sign == -own.sign), None
    )


def _covers(name: str, parameter: str) -> bool:
    return parameter == name or (name.endswith("_") and parameter.startswith(name) and parameter[len(name) :].isdigit())


def with_rig_changes(values: Values) -> Values:
    """The values with every change among them multiplied into the calibrated parameters that it changes."""
    changes = [(_BY_PARAMETER[name], share) for name, share in values.items() if name in _BY_PARAMETER]
    if not changes:
        return values
    changed = {name: value for name, value in values.items() if name not in _BY_PARAMETER}
    for change, share in changes:
        for name in _multiplied(change, changed):
            changed[name] = changed.get(name, 1.0) * max(1.0 + change.sign * share, 0.01)
    return changed


def _multiplied(change: RigChange, values: Values) -> list[str]:
    """The parameters that a change multiplies. Of friction intervals, those that are calibrated."""
    names: list[str] = []
    for name in change.multiplied:
        calibrated = [known for known in values if known != name and _covers(name, known)]
        names += calibrated or [f"{name}1"] if name.endswith("_") else [name]
    return names
