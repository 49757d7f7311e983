"""Check the level of each channel against the rig file; if it cannot fit, name the unit that it seems to be in."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.import_record import ImportRecord
from slider_drilling.log_checks.expected_levels import ExpectedLevel, standpipe_pressure
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS, Quantity, sentence, unit_factor

# Kind of quantity of each channel, and the unit that it is shown in.
_SHOWN = {"surface_torque": ("torque", "kN m"), "hook_load": ("force", "kN"), "standpipe_pressure": ("pressure", "bar")}
# Units that recorders write; a hint names no other.
_RECORDED = {
    "torque": ("N m", "daN m", "kN m", "ft lbf", "kft lbf", "kgf m"),
    "force": ("N", "daN", "kN", "kdaN", "lbf", "klbf", "kgf", "tf"),
    "pressure": ("Pa", "kPa", "bar", "MPa", "psi", "kpsi", "kgf/cm2"),
}
# A unit explains a level if it brings it within this ratio of the expected one, and this many times nearer.
_NEAR, _NEARER = 3.0, 4.0
_OTHER_RIG = 0.1  # a level within this ratio may come from another rig; beyond it only a unit explains it
_FULL_TURN = 2.0 * math.pi + 0.05  # rad


def check_level(channel: str, level: ExpectedLevel | None, imported: ImportRecord | None = None) -> list[LogIssue]:
    """A level that no calibration reaches: wrong unit, or another rig's file.

    Args:
        channel: Its name.
        level: As measured and as expected; None where it is not known.
        imported: What an import did, with the units that it took; None for a recorded log.
    """
    if level is None or level.fits:
        return []
    kind, shown = _SHOWN[channel]
    factors = {name: KINDS[kind][name] for name in _RECORDED[kind]}
    si, factor = next(iter(factors)), factors[shown]
    if level.dead:
        text = sentence(
            f"{channel} {level.verb} zero or noise about it, but the rig file gives ",
            Quantity(level.expected / factor, shown),
            ": its sensor is dead, not connected or tared; leave the channel out, or export it again",
        )  # fmt: skip
        return [LogIssue("unusable", channel, text, "units and levels")]
    ratio = abs(level.measured) / level.expected
    mismatch = "log and rig file do not belong together; give this rig's own file with --rig"
    taken = imported.units.get(channel, "") if imported is not None else ""
    taken_factor = unit_factor(taken, kind) if taken else None
    if taken_factor:
        # The numbers are in another unit than the import was told: SI, too, may be the right one.
        others = {name: value / taken_factor for name, value in factors.items() if value != taken_factor}
        units, pair = _matching_units(ratio, others), ""
    else:
        units = _matching_units(ratio, {name: value for name, value in factors.items() if name != si})
        pair = _mistaken_unit(ratio, [one for one in _MISTAKEN if not units or one in _THOUSANDS], factors)
    named = f"{' or '.join(units[:2])}{f' that was imported as {taken}' if taken_factor else ''}"
    named += f", or {pair}" if pair and units else ""
    if units and _OTHER_RIG < ratio < 1.0 / _OTHER_RIG:
        advice = f"either it is in {named} and must be imported with that unit, or {mismatch}"
    elif units:
        advice = f"it looks like {named}; import it with that unit"
    elif pair:
        advice = f"it looks like {pair}; import it with the right unit, or {mismatch}"
    else:
        advice = mismatch
    text = sentence(
        f"{channel} {level.verb} ", Quantity(level.measured / factor, shown), ", but the rig file gives ",
        Quantity(level.expected / factor, shown), f": {advice}",
    )  # fmt: skip
    return [LogIssue("unusable", channel, text, "units and levels")]


def check_pump_unit(log: RigLog, rig: Rig) -> list[LogIssue]:
    """A pressure that does not fit the flow because the pump's speed is in strokes per minute."""
    as_logged = standpipe_pressure(log, rig)
    if as_logged is None or as_logged.fits or log.mud_pump is None:
        return []
    rpm = KINDS["angular speed"]["rpm"]
    in_rpm = standpipe_pressure(log, rig, rpm)
    if in_rpm is None or not 1.0 / _NEAR < in_rpm.measured / in_rpm.expected < _NEAR:
        return []
    speed = float(np.nanmedian(log.mud_pump.velocity))
    # A pump whose speed is the rig file's as it is has the right unit: the pressure has not.
    if speed * np.sqrt(rpm) < rig.reference_pump_speed:
        return []
    text = sentence(
        "mud_pump turns at ", Quantity(speed, "rad/s", 4), ", whose flow needs ",
        Quantity(as_logged.expected / 1e5, "bar"), ", but ", Quantity(as_logged.measured / 1e5, "bar"),
        " were measured: it looks like strokes per minute; import it with unit spm",
    )  # fmt: skip
    return [LogIssue("unusable", "mud_pump", text, "units and levels")]


def check_tool_face_unit(log: RigLog) -> list[LogIssue]:
    """A toolface in degrees: no angle in rad exceeds a full turn."""
    if log.mwd_tool_face is None:
        return []
    values = log.mwd_tool_face.position[np.isfinite(log.mwd_tool_face.position)]
    if not np.any(np.abs(values) > _FULL_TURN):
        return []
    largest = float(np.max(np.abs(values)))
    advice = "it looks like deg; import it with that unit" if largest <= 360.5 else "wrap it into (-pi, pi]"
    text = f"tool_face reads up to {largest:.4g} rad, more than a turn: {advice}"
    return [LogIssue("unusable", "tool_face", text, "units and levels")]


# Units that recorders and people take for one another: in the table, and taken for.
_MISTAKEN = (
    ("psi", "bar"), ("bar", "psi"), ("psi", "kPa"), ("kPa", "psi"), ("bar", "kPa"), ("kPa", "bar"), ("MPa", "bar"),
    ("bar", "MPa"), ("klbf", "kN"), ("kN", "klbf"), ("klbf", "kdaN"), ("kdaN", "klbf"), ("tf", "klbf"), ("klbf", "tf"),
    ("kN", "kdaN"), ("kdaN", "kN"), ("kN", "tf"), ("tf", "kN"), ("ft lbf", "N m"), ("N m", "ft lbf"),
    ("kft lbf", "kN m"), ("kN m", "kft lbf"), ("kft lbf", "ft lbf"), ("ft lbf", "kft lbf"), ("ft lbf", "kN m"),
    ("kN m", "ft lbf"), ("daN m", "kN m"), ("kN m", "daN m"), ("MPa", "psi"), ("psi", "MPa"),
    ("kPa", "MPa"), ("MPa", "kPa"),
)  # fmt: skip
# As far off as a unit that was never converted: kPa taken for Pa looks like MPa taken for kPa.
_THOUSANDS = (("MPa", "kPa"), ("kft lbf", "ft lbf"))
_NEAR_PAIR = 1.6  # ratio of levels within which a mistaken unit explains the level


def _mistaken_unit(ratio: float, pairs: Sequence[tuple[str, str]], factors: dict[str, float]) -> str:
    """The pairs of units that explain a measured over expected level, at most two, in words; empty where none does.

    Args:
        ratio: Measured over expected level.
        pairs: Those that count.
        factors: Units of the quantity with their SI values.
    """
    if ratio <= 0.0:
        return ""
    pairs = [(one, other) for one, other in pairs if one in factors and other in factors]
    distance = {pair: abs(math.log(ratio * factors[pair[0]] / factors[pair[1]])) for pair in pairs}
    near = sorted((pair for pair in pairs if distance[pair] <= math.log(_NEAR_PAIR)), key=lambda pair: distance[pair])
    return ", or ".join(f"{unit} that was imported as {taken}" for unit, taken in near[:2])


def _matching_units(ratio: float, factors: dict[str, float]) -> list[str]:
    """Units that would explain a measured over expected level, the best first."""
    if ratio <= 0.0:
        return []
    distance = {name: abs(math.log(ratio * factor)) for name, factor in factors.items()}
    limit = min(math.log(_NEAR), abs(math.log(ratio)) / _NEARER)
    return sorted((name for name in distance if distance[name] < limit), key=lambda name: distance[name])
