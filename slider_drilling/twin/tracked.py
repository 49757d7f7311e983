"""The numbers of a rig that a twin keeps calibrated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.rig import FrictionInterval, Rig


@dataclass(frozen=True)
class TrackedParameter:
    """One calibrated number.

    Attributes:
        name: As in `slider_drilling.diagnosis.nuisance`.
        nominal: Value of the rig file.
        step: Change of the plant that shows its sensitivity; 0 for a number that only acts on a reading.
        spread: Standard deviation of what rigs have, about the nominal value.
        lower, upper: Limits.
        channel: The reading that it acts on, where `step` is 0.
    """

    name: str
    nominal: float
    step: float
    spread: float
    lower: float
    upper: float
    channel: str = ""


def tracked_parameters(rig: Rig) -> tuple[TrackedParameter, ...]:
    """What is tracked on this rig.

    Friction, bit and hook load have the spreads and limits of `slider_drilling.diagnosis.nuisance`; damping has a
    narrower spread; the gains of motor and pressure and the torque's offset have wider limits.
    """
    frictions = [TrackedParameter(f"friction_{k + 1}", 1.0, 0.05, 0.2, 0.4, 2.5) for k in range(_intervals(rig))]
    return (
        *frictions,
        TrackedParameter("torsional_stiffness", 1.0, 0.02, 0.05, 0.8, 1.19),
        TrackedParameter("torsional_damping", 1.0, 0.2, 0.3, 0.1, 5.0),
        TrackedParameter("axial_damping", 1.0, 0.2, 0.3, 0.1, 5.0),
        TrackedParameter("bit_stiffness", 1.0, 0.05, 0.2, 0.4, 2.5),
        TrackedParameter("motor_gain", 1.0, 0.02, 0.05, 0.7, 1.3),
        TrackedParameter("pressure_gain", 1.0, 0.005, 0.05, 0.7, 1.3),
        # What friction below the rocked part holds of a twist from before shows as a constant torque.
        TrackedParameter("torque_offset", 0.0, 0.0, 600.0, -1e4, 1e4, "surface_torque"),
        TrackedParameter("hook_load_offset", 0.0, 0.0, 1.5e4, -5e5, 5e5, "hook_load"),
        TrackedParameter("sheave_friction", 0.0, 0.0, 4e3, -1e3, 4e4, "hook_load"),
    )


def rig_at(rig: Rig, values: Mapping[str, float]) -> Rig:
    """The rig with these values of tracked parameters."""
    return rig_with(_halved(rig), values)


def _intervals(rig: Rig) -> int:
    return len(_halved(rig).well.friction_intervals)


def _halved(rig: Rig) -> Rig:
    """The rig with at least two friction intervals: upper and lower half of the hole wear differently."""
    intervals = rig.well.friction_intervals or (FrictionInterval(rig.string.length, 1.0),)
    if len(intervals) == 1:
        intervals = (FrictionInterval(0.5 * rig.string.length, intervals[0].factor), *intervals)
    return replace(rig, well=replace(rig.well, friction_intervals=intervals))
