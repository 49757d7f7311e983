"""Units of the oil field and their SI values: the one place where numbers that are not SI come in."""

from __future__ import annotations

import difflib
import math

from slider_drilling.errors import InputError

_FOOT = 0.3048
_POUND_FORCE = 4.4482216152605
_GALLON = 3.785411784e-3
_TURN = 2.0 * math.pi

# Kind of quantity -> unit -> its value in the SI unit, which is the kind's first.
KINDS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0, "d": 86400.0},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "rev": _TURN},
    "angular speed": {
        "rad/s": 1.0,
        "deg/s": math.pi / 180.0,
        "rev/s": _TURN,
        "rev/min": _TURN / 60.0,
        "rpm": _TURN / 60.0,
        # A pump's stroke counter counts turns of its crank.
        "spm": _TURN / 60.0,
    },
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": _FOOT, "in": _FOOT / 12.0},
    "speed": {
        "m/s": 1.0,
        "m/min": 1.0 / 60.0,
        "m/h": 1.0 / 3600.0,
        "ft/s": _FOOT,
        "ft/min": _FOOT / 60.0,
        "ft/h": _FOOT / 3600.0,
    },
    "force": {
        "N": 1.0,
        "daN": 10.0,
        "kN": 1e3,
        "kdaN": 1e4,
        "MN": 1e6,
        "lbf": _POUND_FORCE,
        "klbf": 1e3 * _POUND_FORCE,
        "kgf": 9.80665,
        "tf": 9806.65,
    },
    "torque": {
        "N m": 1.0,
        "daN m": 10.0,
        "kN m": 1e3,
        "ft lbf": _FOOT * _POUND_FORCE,
        "kft lbf": 1e3 * _FOOT * _POUND_FORCE,
        "kgf m": 9.80665,
    },
    "pressure": {
        "Pa": 1.0,
        "kPa": 1e3,
        "bar": 1e5,
        "MPa": 1e6,
        "psi": _POUND_FORCE / (_FOOT / 12.0) ** 2,
        "kgf/cm2": 98066.5,
    },
    "flow": {
        "m3/s": 1.0,
        "m3/min": 1.0 / 60.0,
        "m3/h": 1.0 / 3600.0,
        "L/s": 1e-3,
        "L/min": 1e-3 / 60.0,
        "gal/min": _GALLON / 60.0,
        "gpm": _GALLON / 60.0,
        "bbl/min": 42.0 * _GALLON / 60.0,
    },
}


def si_value(unit: str, kind: str, where: str) -> float:
    """What one of this unit is in the SI unit of its kind (N m, not ft lbf).

    A dot, hyphen or asterisk between two units means what a space does. Raises InputError, starting with ``where``,
    for a unit that is not of this kind.
    """
    known = KINDS[kind]
    written = " ".join(unit.replace("·", " ").replace("*", " ").replace("-", " ").replace(".", " ").split())
    if written in known:
        return known[written]
    other = [name for name, units in KINDS.items() if written in units]
    if other:
        raise InputError(f"{where}: unit = {unit!r}: is a unit of {other[0]}, not of {kind}; use {', '.join(known)}")
    near = difflib.get_close_matches(written, known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"use {', '.join(known)}"
    raise InputError(f"{where}: unit = {unit!r}: not a known unit of {kind}; {hint}")
