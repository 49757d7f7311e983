"""What a controller's parameters would be by the parameters of the rig that a twin has calibrated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.live.freshness import Freshness
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.messages.health import Level
from slider_drilling.rig import Rig

CONTROLLER = "rocking_controller"
# Statuses of the load check. Another off-bottom pressure releases them, and a washout looks like one.
_LOAD_CHECK = ("off_bottom_pressure", "load_channels")
_CONSEQUENCES = {
    "friction_factor": "The controller repeats its breakover test with it, and does not lower meanwhile.",
    "off_bottom_pressure": "The load check learns again how pressure, torque and hook load agree.",
}


@dataclass(frozen=True)
class CalibratedParameter:
    """A change of a controller's parameter.

    Attributes:
        parameter: As it is now.
        value: By the twin, SI.
    """

    parameter: LiveParameter
    value: float

    @property
    def consequence(self) -> str:
        """What the controller does with another value."""
        return _CONSEQUENCES[self.parameter.name]


def calibrated_values(trends: Mapping[str, tuple[float, float, float]], rig: Rig) -> dict[str, float]:
    """Parameter of the controller -> value by the twin, SI.

    Motor gain and string stiffness are not among them: the controller measures both itself.

    Args:
        trends: (value, lower, upper) over the rig file's, by name.
        rig: The rig file.
    """
    values = {}
    friction, pressure = (trends.get(name, (math.nan,))[0] for name in ("friction", "circulating_pressure"))
    if math.isfinite(friction):
        values["friction_factor"] = SlideSettings().friction_factor * friction
    if math.isfinite(pressure):
        values["off_bottom_pressure"] = pressure * rig.hydraulics.reference_pressure
    return values


def proposed_changes(state: LiveState) -> tuple[list[CalibratedParameter], list[str]]:
    """The changes that "use calibrated rig" would make, and why others are not among them."""
    rig, trends = state.rig, state.twin.latest_trends()
    if rig is None:
        return [], ["no rig file yet"]
    if not trends:
        return [], ["the twin has calibrated nothing yet"]
    if not state.twin.compared:
        return [], ["the twin still learns the rig"]
    if state.twin.freshness() is Freshness.LOST:
        return [], [f"the twin has said nothing for {state.twin.age():.0f} s"]
    known = {one.name: one for one in state.parameters() if one.node == CONTROLLER}
    changes, remarks = [], []
    for name, value in calibrated_values(trends, rig).items():
        parameter = known.get(name)
        if parameter is None:
            remarks.append(f"{name}: the controller has no such parameter")
        elif not parameter.low <= value <= parameter.high:
            remarks.append(f"{name}: {value:g} is outside {parameter.low:g} to {parameter.high:g}: not changed")
        elif name == "off_bottom_pressure" and _load_check_stops(state):
            remarks.append(f"{name}: not changed: it would release the load check, which has stopped lowering")
        else:
            changes.append(CalibratedParameter(parameter, value))
    return changes, remarks


def _load_check_stops(state: LiveState) -> bool:
    return any(
        shown.level is Level.ERROR and shown.status.name.rpartition(": ")[2] in _LOAD_CHECK
        for shown in state.statuses()
    )
