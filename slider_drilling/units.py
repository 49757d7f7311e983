"""Oilfield units and their SI values: the only place where numbers that are not SI come in or go out."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.unit_spellings import unit_of_spelling, written_plainly

_FOOT = 0.3048
_POUND_FORCE = 4.4482216152605
_GALLON = 3.785411784e-3
_POUND = 0.45359237
_TURN = 2.0 * math.pi

# Kind of quantity -> unit -> its value in the SI unit, which comes first.
KINDS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "rev": _TURN, "turns": _TURN, "gon": math.pi / 200.0},
    "angular speed": {
        "rad/s": 1.0,
        "deg/s": math.pi / 180.0,
        "rev/s": _TURN,
        "rev/min": _TURN / 60.0,
        "rpm": _TURN / 60.0,
        # A pump's stroke counter counts turns of its crank.
        "spm": _TURN / 60.0,
    },
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": _FOOT, "in": _FOOT / 12.0, "usft": 1200.0 / 3937.0},
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
        "in lbf": _FOOT / 12.0 * _POUND_FORCE,
        "kgf m": 9.80665,
        "MN m": 1e6,
    },
    "pressure": {
        "Pa": 1.0,
        "kPa": 1e3,
        "bar": 1e5,
        "MPa": 1e6,
        "psi": _POUND_FORCE / (_FOOT / 12.0) ** 2,
        "kpsi": 1e3 * _POUND_FORCE / (_FOOT / 12.0) ** 2,
        "kgf/cm2": 98066.5,
        "atm": 101325.0,
    },
    "flow": {
        "m3/s": 1.0,
        "m3/min": 1.0 / 60.0,
        "m3/h": 1.0 / 3600.0,
        "L/s": 1e-3,
        "L/min": 1e-3 / 60.0,
        "gal/min": _GALLON / 60.0,
        "gpm": _GALLON / 60.0,
        "galUK/min": 4.54609e-3 / 60.0,
        "bbl/min": 42.0 * _GALLON / 60.0,
    },
    "energy": {"J": 1.0, "kJ": 1e3, "ft lbf": _FOOT * _POUND_FORCE, "kft lbf": 1e3 * _FOOT * _POUND_FORCE},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "lb/gal": _POUND / _GALLON, "lb/ft3": _POUND / _FOOT**3},
    "force per length": {"N/m": 1.0, "kN/m": 1e3, "lbf/ft": _POUND_FORCE / _FOOT, "kgf/m": 9.80665},
    "volume per turn": {
        "m3/rev": 1.0, "m3/rad": _TURN, "L/rev": 1e-3, "gal/rev": _GALLON, "bbl/rev": 42.0 * _GALLON,
        "m3/stk": 1.0, "L/stk": 1e-3, "gal/stk": _GALLON, "bbl/stk": 42.0 * _GALLON,
    },
    "turns per volume": {"rev/m3": 1.0, "rev/L": 1e3, "rev/gal": 1.0 / _GALLON},
    "torque per pressure": {
        "N m/Pa": 1.0, "N m/kPa": 1e-3, "N m/bar": 1e-5, "N m/MPa": 1e-6, "kN m/bar": 1e-2, "kN m/MPa": 1e-3,
        "ft lbf/psi": _FOOT * (_FOOT / 12.0) ** 2,
    },
    "angular acceleration": {"rad/s2": 1.0, "rpm/s": _TURN / 60.0},
    "dog leg": {"rad/m": 1.0, "deg/30 m": math.pi / 180.0 / 30.0, "deg/100 ft": math.pi / 180.0 / (100.0 * _FOOT)},
    "frequency": {"Hz": 1.0, "1/s": 1.0, "1/min": 1.0 / 60.0},
    "stiffness": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "lbf/in": 12.0 * _POUND_FORCE / _FOOT},
    "stress": {"Pa": 1.0, "MPa": 1e6, "GPa": 1e9, "psi": _POUND_FORCE / (_FOOT / 12.0) ** 2},
}  # fmt: skip

FIELD_UNITS = {
    "m": "ft", "mm": "in", "km": "ft",
    "m/s": "ft/s", "m/min": "ft/min", "m/h": "ft/h",
    "N": "lbf", "kN": "klbf", "MN": "klbf",
    "N m": "ft lbf", "kN m": "ft lbf",
    "Pa": "psi", "kPa": "psi", "bar": "psi", "MPa": "psi",
    "rad": "turns", "rad/s": "rev/min", "rev/s": "rev/min",
    "m3/s": "gal/min", "L/s": "gal/min", "L/min": "gal/min",
    "J": "ft lbf", "kJ": "ft lbf", "kg/m3": "lb/gal", "N/m": "lbf/ft", "kN/m": "lbf/ft", "deg/30 m": "deg/100 ft",
}  # fmt: skip
"""Oilfield display unit for each SI unit."""

Number = TypeVar("Number", float, NDArray[np.float64])


@dataclass(frozen=True)
class Units:
    """Display units of a page, plot or table: `SI` (m, kN, bar, kN m, rad) or `FIELD` (ft, klbf, psi, ft lbf, turns).

    Degrees and seconds are the same in both, and so is any unit that neither table holds.
    """

    name: str

    def display_unit(self, unit: str) -> str:
        """The display unit for a quantity in `unit`."""
        return FIELD_UNITS.get(unit, unit) if self.name == "field" else unit

    def convert(self, value: Number, unit: str) -> Number:
        """A number or an array in `unit`, converted to the display unit."""
        shown = self.display_unit(unit)
        if shown == unit:
            return value
        (factor,) = {known[unit] / known[shown] for known in KINDS.values() if unit in known and shown in known}
        return value * factor

    def format(self, value: float | None, unit: str, digits: int = 3) -> str:
        """A number in `unit` as text in the display unit: "12.3 kN m" or "9070 ft lbf"; "-" for None and NaN."""
        if value is None or math.isnan(value):
            return "-"
        return f"{format_number(self.convert(value, unit), digits)} {self.display_unit(unit)}".rstrip()

    def format_range(self, low: float, high: float, unit: str, digits: int = 3) -> str:
        """Two numbers in `unit` as a range in the display unit: "-4.10 to 12.3 kN m"."""
        first, last = (format_number(self.convert(end, unit), digits) for end in (low, high))
        return f"{first} to {last} {self.display_unit(unit)}".rstrip()

    def convert_text(self, text: Text) -> str:
        """A text with its quantities in these units. A plain `str` has none and stays as it is."""
        if isinstance(text, str):
            return text
        return "".join(
            part if isinstance(part, str) else self.format(part.value, part.unit, part.digits) for part in text.parts
        )

    def convert_message(self, message: Text) -> str:
        """A text in these units, also the quantities of a plain `str` in SI: a note or a reason, say."""
        plain = isinstance(message, str) and self.name != "si"
        return self.convert_text(quantities_in(str(message)) if plain else message)

    def convert_label(self, label: str) -> str:
        """A heading or axis label, "name, unit", with the display unit."""
        name, unit = split_label(label)
        return ", ".join(part for part in (name, self.display_unit(unit)) if part) if unit else label


@dataclass(frozen=True)
class Quantity:
    """A value with its unit, shown as "12.3 kN m".

    Attributes:
        value: In `unit`; None and NaN are shown as "-".
        unit: One of `KINDS`, or "" for a plain number.
        digits: Significant digits that are shown.
    """

    value: float | None
    unit: str = ""
    digits: int = 3


@dataclass(frozen=True)
class Sentence:
    """Text with quantities in it. Units are chosen when it is written: `Units.convert_text`; `str` gives SI.

    Attributes:
        parts: Words and quantities in their order; see `sentence`.
    """

    parts: tuple[str | Quantity, ...]

    def __str__(self) -> str:
        return SI.convert_text(self)


Text = str | Sentence


def sentence(*parts: Text | Quantity) -> Sentence:
    """One text of several parts: ``sentence("the block moved ", Quantity(0.32, "m"))``."""
    flat: list[str | Quantity] = []
    for part in parts:
        flat += part.parts if isinstance(part, Sentence) else [part]
    return Sentence(tuple(flat))


_WITH_UNIT = re.compile(
    r"(?<![\w.])([+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?)((?: to | / )[+-]?\d+(?:\.\d+)?)? "
    rf"({'|'.join(sorted(map(re.escape, FIELD_UNITS), key=len, reverse=True))})(?![\w/])"
)


def quantities_in(text: str) -> Sentence:
    """A text written in SI, such as a controller's message, with its numbers before a unit as quantities.

    ``"reaches 2400 m of 3100 m"`` becomes a sentence that `FIELD` shows as "reaches 7874 ft of 10171 ft".
    """
    parts: list[str | Quantity] = []
    end = 0
    for found in _WITH_UNIT.finditer(text):
        first, second, unit = found.groups()
        parts.append(text[end : found.start()])
        for number, between in ((first, ""), (second, second and second[: second.rindex(" ") + 1])):
            if number:
                plain = number.rpartition(" ")[2]
                digits = max(len(re.sub(r"\D", "", plain.partition("e")[0]).lstrip("0")), 1)
                sign = "+" if plain.startswith("+") else ""
                parts += [(between or "") + sign, Quantity(float(plain), unit, digits)]
        end = found.end()
    return Sentence((*(part for part in parts if part != ""), text[end:]))


SI = Units("si")
FIELD = Units("field")
UNITS = {units.name: units for units in (SI, FIELD)}


# The unit in which a driller reads an SI unit.
_DISPLAY_UNITS = {"N m": "kN m", "N": "kN", "Pa": "bar", "rad": "deg"}


def display_unit(unit: str) -> tuple[str, float]:
    """The unit shown for an SI unit, and the factor that converts a value to it."""
    shown = _DISPLAY_UNITS.get(unit, unit)
    factors = (units[unit] / units[shown] for units in KINDS.values() if unit in units and shown in units)
    return shown, next(factors, 1.0)


def displayed(value: float | None, unit: str, digits: int = 3) -> Quantity:
    """A value of an SI unit as the quantity that is shown; "-" is the unit of a plain number."""
    shown, factor = display_unit(unit)
    return Quantity(None if value is None else value * factor, "" if shown == "-" else shown, digits)


def split_label(label: str) -> tuple[str, str]:
    """Name and unit of a label "name, unit"; the unit is "" where no known unit follows the comma."""
    name, _, unit = label.rpartition(", ")
    return (name, unit) if any(unit in known for known in KINDS.values()) else (label, "")


def format_number(value: float, digits: int = 3) -> str:
    """A number as text with this many significant digits; all digits before the point are kept, rounding noise is 0."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else f"{value}"
    if abs(value) < 1e-12:
        return "0"
    exponent = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if not -4 <= exponent < 7:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        return f"{mantissa}e{int(power)}"
    return f"{value:.{max(digits - 1 - exponent, 0)}f}"


def unit_factor(unit: str, kind: str) -> float | None:
    """Value of one such unit in the SI unit of its kind, None for a unit that is not known.

    Args:
        unit: In any spelling of `slider_drilling.unit_spellings`: "ft-lbf", "KN.M", "1000 lbf", "°".
        kind: A key of `KINDS`.
    """
    size, spelling = written_plainly(unit)
    name = unit_of_spelling(spelling, kind, tuple(KINDS[kind]))
    return None if name is None else size * KINDS[kind][name]


def format_alike(values: Sequence[float]) -> list[str]:
    """Numbers with the same decimals: three digits for the largest; each its own if the smallest would lose all."""
    places = shared_decimals(values)
    if places is None:
        return [format_number(value) for value in values]
    return [f"{value + 0.0:.{places}f}" if math.isfinite(value) else format_number(value) for value in values]


def shared_decimals(values: Sequence[float], digits: int = 3) -> int | None:
    """Decimals that show so many digits of the largest value; None if the smallest would lose its last digit."""
    sizes = [abs(value) for value in values if math.isfinite(value) and abs(value) > 1e-12]
    if not sizes:
        return None
    places = max(digits - 1 - math.floor(math.log10(max(sizes))), 0)
    return places if min(sizes) >= 10.0**-places and max(sizes) < 1e7 else None


def si_factor(unit: str, kind: str, where: str) -> float:
    """Value of one such unit in the SI unit of its kind.

    Args:
        unit: Such as "ft lbf", in any spelling that `unit_factor` knows.
        kind: A key of `KINDS`.
        where: Starts the error message.

    Raises:
        InputError: For a unit that is not of this kind. The message names no "near" unit: it may differ in size.
    """
    factor = unit_factor(unit, kind)
    if factor is not None:
        return factor
    other = [name for name in KINDS if unit_factor(unit, name) is not None]
    known = ", ".join(KINDS[kind])
    if other:
        raise InputError(f"{where}: unit = {unit!r}: is a unit of {other[0]}, not of {kind}; use {known}")
    raise InputError(f"{where}: unit = {unit!r}: not a known unit of {kind}; use {known}")
