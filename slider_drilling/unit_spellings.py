"""Spellings of units, as recorders, LAS, WITSML and WITS write them, and the units that they mean.

Sources: Energistics Unit of Measure Dictionary 1.0 (WITSML `uom`: klbf, galUS/min, dega, ft.lbf, 1000 lbf, c/min);
WITS specification, units of record 1 (KDN, KLB, KNM, KFLB, L/M, F/HR); CWLS LAS 2.0 examples; exports of recorders.

A spelling never changes the size of a unit: one that may mean two sizes (ton, mph, mPa) is not in the tables.
"""

from __future__ import annotations

import re

# Kind of quantity -> unit of `slider_drilling.units.KINDS` -> its other spellings, in lower case, with a blank where a
# dot, hyphen, asterisk or underscore may stand.
SPELLINGS: dict[str, dict[str, str]] = {
    "time": {
        "s": "sec, secs, second, seconds", "ms": "msec, millisecond, milliseconds", "us": "µs, μs, usec, microseconds",
        "ns": "nsec, nanoseconds", "min": "mins, minute, minutes", "h": "hr, hrs, hour, hours", "d": "day, days",
    },
    "angle": {
        "deg": "°, º, dega, degree, degrees, degs, deg a", "rev": "revs, revolution, revolutions", "turns": "turn",
        "gon": "grad", "rad": "rads, radian, radians",
    },
    "angular speed": {
        "rpm": "r/min, revs/min, 1/min, c/min, rev/minute, revolutions/min, u/min, tr/min, min 1",
        "rev/s": "rps, c/s, r/s, revs/s, 1/s", "deg/s": "°/s, º/s, dega/s, deg/sec, degrees/s",
        "rad/s": "rad/sec, radians/s",
        "spm": "strokes/min, stroke/min, stk/min, stks/min, strk/min, str/min, spm/min, strokes per minute",
    },
    "length": {
        "m": "meter, meters, metre, metres, mtr", "mm": "millimeter, millimeters, millimetre, millimetres",
        "cm": "centimeter, centimeters, centimetre, centimetres", "km": "kilometer, kilometers, kilometre, kilometres",
        "ft": "f, feet, foot, ift, ftmd", "in": 'inch, inches, "', "usft": "ftus, us ft, ft us, us survey feet",
    },
    "speed": {
        "m/s": "m/sec, mps", "m/min": "meters/min, metres/min", "m/h": "m/hr, m/hour, meters/hr, metres/hr",
        "ft/s": "ft/sec, f/s, fps, feet/s", "ft/min": "fpm, f/min, feet/min",
        "ft/h": "ft/hr, f/hr, f/h, fph, feet/hr, feet/h, ft/hour",
    },
    "force": {
        "N": "newton, newtons", "daN": "dan", "kN": "kn", "kdaN": "kdan, kdn, 10 kn",
        "lbf": "lb, lbs, lbsf, pound, pounds, pounds force, lb f",
        "klbf": "klb, klbs, klbsf, kip, kips, k lb, k lbs, k lbf, kpound, kpounds, kilopounds",
        "kgf": "kg, kgs, kg f, kilogram, kilograms",
        "tf": "t, te, tonne, tonnes, tons metric, metric ton, metric tons, mt, mton, kkgf",
    },
    "torque": {
        "N m": "nm, newton meter, newton metre, newton meters", "daN m": "danm", "kN m": "knm, kilonewton meter",
        "ft lbf": "ft lb, ft lbs, lb ft, lbs ft, lbf ft, ftlb, ftlbs, ftlbf, lbft, lbfft, foot pound, foot pounds, "
                  "f lb, f lbs, flb",
        "kft lbf": "kft lb, kft lbs, kftlb, kftlbs, kftlbf, klb ft, klbs ft, klbf ft, klbft, k ft lb, k ft lbs, "
                   "k ft lbf, kflb, kf lb, kf lbs, kip ft, kips ft, ft kip, ft kips, ft klbf, ft klb, kfoot pounds",
        "in lbf": "in lb, in lbs, inlb, lb in, lbf in", "kgf m": "kg m, kgm, kgfm, m kg, m kgf",
    },
    "pressure": {
        "Pa": "pascal, pascals", "kPa": "kpa, kpag", "bar": "bars, barg, bar g",
        "psi": "psig, psi g, lbf/in2, lb/in2, lbs/in2, lbf/in^2, lb/in^2", "kpsi": "ksi, k psi, kpsig",
        "kgf/cm2": "kg/cm2, kg/cm^2, kgf/cm^2, ksc, at", "atm": "atmosphere, atmospheres",
    },
    "flow": {
        "m3/s": "m^3/s, m3/sec", "m3/min": "m^3/min, cum/min, m3/m", "m3/h": "m3/hr, m^3/h, m^3/hr",
        "L/s": "l/s, lps, l/sec, ltr/s", "L/min": "l/min, lpm, l/m, lt/min, ltr/min, liter/min, liters/min, litres/min",
        "gpm": "galus/min, gal us/min, us gal/min, usgal/min, usgpm, us gpm, gal(us)/min, gals/min, galons/min, "
               "gallons/min, gal/minute, gallon/min",
        "galUK/min": "galuk/min, igpm, imp gal/min, uk gal/min", "bbl/min": "bpm, bbls/min, bbl/m, stb/min",
    },
    "density": {
        "kg/m3": "kg/m^3, kgm3", "g/cm3": "g/cc, gm/cc, sg, g/cm^3, kg/l, gcc",
        "lb/ft3": "pcf, lbm/ft3, lb/cuft, lb/cu ft", "lb/gal": "ppg, lbm/gal, lbs/gal, lb/galus, lbm/galus, lb/usgal",
    },
    "force per length": {"lbf/ft": "lb/ft, lbs/ft, ppf, lbm/ft", "kgf/m": "kg/m"},
    "volume per turn": {"gal/stk": "gal/stroke, galus/stk", "bbl/stk": "bbl/stroke, bbls/stk", "L/stk": "l/stroke"},
    "turns per volume": {"rev/gal": "revs/gal, rpg, rev/galus, rpm/gpm", "rev/L": "revs/l"},
    "torque per pressure": {"ft lbf/psi": "ft lb/psi, ft lbs/psi, lb ft/psi"},
}  # fmt: skip

# Units that differ in size by the case of one letter: the mega units, which only a capital M begins.
_MEGA = ("MN", "MN m", "MPa")
_SIZE = re.compile(r"^x?\s*(?P<size>10\^?3|1 ?000|1e3)(?![\d.])\s*(?P<rest>\D.*)$")
_SUPERSCRIPTS = str.maketrans("²³", "23")


def written_plainly(unit: str) -> tuple[float, str]:
    """A number in front of a unit (1000 lbf), and the unit with blanks between its parts."""
    text = unit.translate(_SUPERSCRIPTS).strip().strip("[]()").strip()
    match = _SIZE.match(text)
    size, text = (1000.0, match["rest"]) if match else (1.0, text)
    return size, " ".join(re.sub(r"[·∙⋅*_.\-]", " ", text).split())


def unit_of_spelling(spelling: str, kind: str, units: tuple[str, ...]) -> str | None:
    """The unit that a spelling means, None for one that is not known.

    Args:
        spelling: As `written_plainly` gives it.
        kind: Of quantity.
        units: The units of that kind.
    """
    if spelling in units:
        return spelling
    lower, joined = spelling.lower(), spelling.replace(" ", "")
    for unit in _MEGA:
        if unit in units and lower.replace(" ", "") == unit.lower().replace(" ", ""):
            return unit if joined.startswith("M") else None
    for unit in units:
        if lower == unit.lower() or lower in _spelled(kind, unit):
            return unit
    return None


def _spelled(kind: str, unit: str) -> list[str]:
    others = SPELLINGS.get(kind, {}).get(unit)
    return others.split(", ") if others else []
