"""What papers say besides survey and tally: mud, motor, pump, top drive, pressure, bit, casing.

Each value is a text as a rig floor writes it, on the command line, typed in, or in a sheet of two columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.cells import read_cells
from slider_drilling.rig_papers import equipment
from slider_drilling.rig_papers.inches import size_in_text
from slider_drilling.schema.quantity_text import convert_quantity, read_quantity, split_quantity
from slider_drilling.units import KINDS


@dataclass(frozen=True)
class SheetKey:
    """A value that papers give.

    Attributes:
        name: In sheets; as an option, with hyphens.
        question: What is asked for in a terminal.
        example: As it may be written.
        required: Whether a rig file cannot be made without it.
    """

    name: str
    question: str
    example: str
    required: bool = True


SHEET_KEYS = (
    SheetKey("well", "name of the well", "Example 3H", False),
    SheetKey("mud", "mud density, and OBM, WBM or SBM", "9.6 ppg OBM"),
    SheetKey("motor", "motor: a name of the table, a file with its sheet, or its numbers",
             "0.28 rev/gal, 6600 ft-lbf @ 1100 psi, stall 9900 ft-lbf"),
    SheetKey("pump", "pump: volume per stroke (all pumps that count strokes), or liner and stroke", "4.2 gal/stk"),
    SheetKey("top_drive", "top drive: a name of the table, or torque and speed", "45000 ft-lbf, 180 rpm"),
    SheetKey("circulating_pressure", "standpipe pressure off bottom, and its flow", "3000 psi @ 500 gpm"),
    SheetKey("bit", "bit, where the tally has none", "8.5 in PDC", False),
    SheetKey("hole_diameter", "hole diameter, where it is not the bit's", "8.5 in", False),
    SheetKey("casing_shoe", "measured depth of the casing shoe", "6200 ft"),
    SheetKey("make_up_torque", "make-up torque of the drill pipe's connection", "26800 ft-lbf", False),
    SheetKey("sample_rate", "rate of the surface channels", "10 Hz", False),
)  # fmt: skip
_MUD_TYPES = {
    "obm": "oil", "oil": "oil", "sbm": "synthetic", "synthetic": "synthetic", "wbm": "water", "water": "water",
}  # fmt: skip
_MUD_DENSITY = (300.0, 3000.0)  # kg/m3, of foam to kill mud
_MOTOR_ROWS = {
    "revolutions": "m3/rev", "displacement": "m3/rev", "max_differential": "Pa", "torque": "N m",
    "torque_at_max_differential": "N m", "stall_torque": "N m", "stall_differential": "Pa", "leak": "-",
}  # fmt: skip


@dataclass(frozen=True)
class MudPaper:
    """Density in kg/m3, and what the mud is made of: oil, synthetic, water, or "" for not said."""

    density: float
    base: str


@dataclass(frozen=True)
class MotorPaper:
    """A motor's sheet.

    Attributes:
        displacement: m3/rev.
        max_pressure: Differential pressure at full load, Pa.
        torque: At full load, N m; None where only the table's size is known.
        stall_pressure: Pa; None where no paper tells.
        leak: Share of the flow that slips at full load; None where no paper tells.
    """

    displacement: float
    max_pressure: float
    torque: float | None
    stall_pressure: float | None
    leak: float | None = None


@dataclass(frozen=True)
class PumpPaper:
    """Volume per stroke in m3; measured: whether a paper gives it, rather than liner and stroke."""

    stroke_volume: float
    measured: bool


def read_sheet(path: Path) -> dict[str, str]:
    """Key -> text of a sheet with the columns key and value (others are for the reader). Raises InputError."""
    known = {key.name for key in SHEET_KEYS}
    values = _key_rows(path, "sheet")
    for name in values:
        if name not in known:
            raise InputError(f"{path}: {name}: unknown key; known keys: {', '.join(key.name for key in SHEET_KEYS)}")
    return values


def _key_rows(path: Path, what: str) -> dict[str, str]:
    values: dict[str, str] = {}
    for line, row in enumerate(read_cells(path, what, what), start=1):
        if not any(row) or row[0].lower() in ("key", ""):
            continue
        name = "_".join(row[0].lower().replace("-", " ").split())
        text = row[1] if len(row) > 1 else ""
        unit = row[2] if len(row) > 2 and re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?", text.lower()) else ""
        if name in values:
            raise InputError(f"{path}: line {line}: {row[0]}: given twice; keep one")
        if text:
            values[name] = f"{text} {unit}".strip()
    return values


def read_mud(text: str) -> MudPaper:
    """Density and kind of mud. Raises InputError."""
    words = re.findall(r"[A-Za-z]+", text)
    base = next((_MUD_TYPES[word.lower()] for word in words if word.lower() in _MUD_TYPES), "")
    plain = re.sub(r"\b(obm|wbm|sbm|oil|synthetic|water|based|base|mud)\b", " ", text, flags=re.IGNORECASE).strip(" ,-")
    number = float(plain) if re.fullmatch(r"\d+\.?\d*", plain) else None
    if number is not None:
        raise InputError(f"mud = {text!r}: has no unit{_meant(number)}")
    density = read_quantity(plain, "kg/m3", "mud")
    if not _MUD_DENSITY[0] <= density <= _MUD_DENSITY[1]:
        found = split_quantity(plain)
        raise InputError(f"mud = {text!r}: {density:.4g} kg/m3 is no drilling mud{_meant(found[0] if found else 0.0)}")
    return MudPaper(density, base)


def _meant(number: float) -> str:
    """The question which unit a density has."""
    units = [unit for unit in ("lb/gal", "g/cm3", "kg/m3", "lb/ft3")
             if _MUD_DENSITY[0] <= convert_quantity(number, unit, "kg/m3", "") <= _MUD_DENSITY[1]]  # fmt: skip
    return f"; is it {' or '.join(f'{number:g} {unit}' for unit in units)}?" if units else "; write it as 9.6 ppg"


def read_motor(text: str) -> MotorPaper:
    """A motor by the name of a table's row, by a file with its sheet, or by its numbers. Raises InputError."""
    if re.search(r"\.(csv|xlsx|txt)$", text.strip(), re.IGNORECASE):
        return _motor_from_rows(_key_rows(Path(text.strip()), "motor"), text.strip())
    parts = _parts(text)
    if any(_is_of(part, "m3/rev") for _, part in parts):
        return _motor_from_rows(_motor_rows(parts, text), "motor")
    size = equipment.find_by_name(text, equipment.MOTORS, "motor")
    gallon, psi = KINDS["flow"]["gpm"] * 60.0, KINDS["pressure"]["psi"]
    full_load = size.stages * equipment.PRESSURE_PER_STAGE * psi
    return MotorPaper(gallon / size.revolutions, full_load, None, None)


def _motor_rows(parts: Sequence[tuple[str, str]], text: str) -> dict[str, str]:
    """Numbers of a motor as the rows of its sheet."""
    rows: dict[str, str] = {}
    for word, quantity in parts:
        stall = "stall" in word.lower()
        if _is_of(quantity, "m3/rev"):
            name = "revolutions"
        elif _is_of(quantity, "Pa"):
            name = "stall_differential" if stall else "max_differential"
        elif _is_of(quantity, "N m"):
            name = "stall_torque" if stall else "torque"
        elif quantity.endswith("%"):
            name = "leak"
        else:
            continue  # size, lobes and flow range
        if name in rows:
            raise InputError(f"motor = {text!r}: {name} is given twice; keep one")
        rows[name] = quantity
    return rows


def _motor_from_rows(rows: Mapping[str, str], source: str) -> MotorPaper:
    values = {}
    for name, text in rows.items():
        plain = name.removeprefix("motor_")
        if plain in _MOTOR_ROWS:
            values[plain] = read_quantity(text, _MOTOR_ROWS[plain], f"{source}: {name}")
    torque = values.get("torque", values.get("torque_at_max_differential"))
    volume, pressure = values.get("revolutions", values.get("displacement")), values.get("max_differential")
    for name, value in (("revolutions (0.28 rev/gal)", volume), ("max_differential (1100 psi)", pressure),
                        ("torque at max differential (6600 ft-lbf)", torque)):  # fmt: skip
        if value is None:
            raise InputError(f"{source}: {name}: missing; add it from the motor's sheet")
        if value <= 0.0:
            raise InputError(f"{source}: {name} = {value:g}: must be above 0")
    assert volume is not None and pressure is not None and torque is not None
    stall = values.get("stall_differential")
    if stall is None and "stall_torque" in values:
        stall = pressure * values["stall_torque"] / torque
    if stall is not None and stall < pressure:
        raise InputError(f"{source}: stall at {stall / 1e5:.4g} bar, below full load at {pressure / 1e5:.4g} bar; are "
                         "they swapped?")  # fmt: skip
    return MotorPaper(volume, pressure, torque, stall, values.get("leak"))


def read_pump(text: str) -> PumpPaper:
    """Volume per stroke, from a paper or from liner and stroke. Raises InputError."""
    for _, part in _parts(text):
        if _is_of(part, "m3/stk"):
            return PumpPaper(read_quantity(part, "m3/stk", "pump"), True)
    sides = re.split(r"\s*[x×]\s*", text.strip(), maxsplit=1)
    inch = KINDS["length"]["in"]
    if len(sides) == 2:
        liner, stroke = (_inches(side, text) for side in sides)
    else:
        size = size_in_text(text)
        if size is None:
            raise InputError(f"pump = {text!r}: give the volume per stroke (4.2 gal/stk), liner and stroke "
                             "(6 in x 12 in) or a name and the liner (PZ-11 6 in)")  # fmt: skip
        name = re.sub(r"\d+(\s+\d+/\d+)?\s*(in\b|\").*", "", text).strip()
        liner, stroke = size * inch, equipment.find_by_name(name, equipment.PUMPS, "pump").stroke * inch
    if not (0.05 < liner < 0.3 and 0.1 < stroke < 0.5):
        raise InputError(f"pump = {text!r}: a liner of {liner:.3g} m and a stroke of {stroke:.3g} m are no mud pump's")
    return PumpPaper(equipment.triplex_displacement(liner, stroke), False)


def _inches(text: str, whole: str) -> float:
    found = split_quantity(text.replace("triplex", "").strip())
    if found is not None:
        return convert_quantity(*found, "m", f"pump = {whole!r}")
    size = size_in_text(f"{text.strip()} in")
    if size is None:
        raise InputError(f"pump = {whole!r}: {text!r} is no size")
    return size * KINDS["length"]["in"]


def read_top_drive(text: str) -> tuple[float, float]:
    """Torque (N m) and highest speed (rad/s), from numbers or from the table. Raises InputError."""
    parts = [part for _, part in _parts(text)]
    torque = next((part for part in parts if _is_of(part, "N m")), None)
    speed = next((part for part in parts if _is_of(part, "rad/s")), None)
    if torque is not None and speed is not None:
        return read_quantity(torque, "N m", "top_drive"), read_quantity(speed, "rad/s", "top_drive")
    if torque is not None or speed is not None:
        raise InputError(f"top_drive = {text!r}: give torque and speed, such as 45000 ft-lbf, 180 rpm")
    model = equipment.find_by_name(text, equipment.TOP_DRIVES, "top_drive")
    return model.torque * KINDS["torque"]["ft lbf"], model.speed * KINDS["angular speed"]["rpm"]


def read_circulating_pressure(text: str) -> tuple[float, float]:
    """Pressure (Pa) and flow (m3/s). Raises InputError."""
    parts = [part for _, part in _parts(text)]
    pressure = next((part for part in parts if _is_of(part, "Pa")), None)
    flow = next((part for part in parts if _is_of(part, "m3/s")), None)
    if pressure is None or flow is None:
        raise InputError(f"circulating_pressure = {text!r}: give pressure and flow, such as 3000 psi @ 500 gpm")
    return read_quantity(pressure, "Pa", "circulating_pressure"), read_quantity(flow, "m3/s", "circulating_pressure")


def read_size(text: str, what: str) -> float:
    """A diameter in m from "8.5 in", "8 1/2 in" or "216 mm". Raises InputError."""
    size = size_in_text(text)
    if size is not None:
        return size * KINDS["length"]["in"]
    words = re.sub(r"\b(pdc|tricone|roller|cone|bit)\b", "", text, flags=re.IGNORECASE).strip(" ,")
    return read_quantity(words, "m", what)


def _parts(text: str) -> list[tuple[str, str]]:
    """(words before it, quantity) of each number with a unit in a text, divided by commas, semicolons and @.

    Raises InputError for a comma within a number.
    """
    if re.search(r"\d,\d", text):
        raise InputError(f"{text!r}: is the comma within a number a decimal one? write 3000, or 3.5")
    parts = []
    for piece in re.split(r"[,;@]", text):
        match = re.fullmatch(r"\s*(.*?)\s*([-+]?(?:\d+\.?\d*|\.\d+)\s*[A-Za-z%].*?)\s*", piece)
        if match is not None:
            parts.append((match[1], match[2]))
    return parts


def _is_of(quantity: str, target: str) -> bool:
    found = split_quantity(quantity)
    if found is None or not math.isfinite(found[0]):
        return False
    try:
        convert_quantity(*found, target, "")
    except InputError:
        return False
    return True
