"""Mud motors, top drives and mud pumps by name."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from slider_drilling.errors import InputError


@dataclass(frozen=True)
class MotorSize:
    """A positive displacement motor.

    Attributes:
        size: Outer diameter, in.
        lobes: Of rotor and stator.
        stages: Of the power section.
        flow: Lowest and highest, gal/min.
        revolutions: Per gallon, without load.
    """

    size: float
    lobes: str
    stages: float
    flow: tuple[float, float]
    revolutions: float

    @property
    def name(self) -> str:
        """As `--motor` takes it."""
        return f"{self.size:g} in {self.lobes} {self.stages:.1f}"


MOTOR_SOURCE = "Schlumberger PowerPak Steerable Motor Handbook, 2004: speed without load over flow"
MOTORS = (
    MotorSize(4.75, "4/5", 5.0, (100.0, 250.0), 1.05),
    MotorSize(4.75, "7/8", 2.2, (100.0, 250.0), 0.53),
    MotorSize(6.25, "7/8", 4.8, (175.0, 400.0), 0.34),
    MotorSize(6.75, "4/5", 4.8, (300.0, 600.0), 0.50),
    MotorSize(6.75, "7/8", 3.0, (300.0, 600.0), 0.29),
    MotorSize(6.75, "7/8", 5.0, (300.0, 600.0), 0.28),
    MotorSize(8.0, "4/5", 5.3, (300.0, 900.0), 0.25),
    MotorSize(8.0, "7/8", 4.0, (300.0, 900.0), 0.16),
    MotorSize(9.625, "4/5", 6.0, (600.0, 1200.0), 0.22),
    MotorSize(9.625, "7/8", 4.8, (600.0, 1200.0), 0.11),
)
PRESSURE_PER_STAGE = 225.0
"""psi; full load of one stage of a power section of conventional rubber: 150 to 300 by maker and clearance."""
TORQUE_EFFICIENCY, TORQUE_EFFICIENCY_SPREAD = 0.65, 0.1
"""Torque at full load over that of a motor without losses: 0.5 to 0.8 in makers' curves."""
STALL_OVER_FULL_LOAD, STALL_SPREAD = 1.5, 0.2
"""Differential pressure at stall over that of full load: 1.3 to 1.8 in makers' curves."""
LEAK, LEAK_SPREAD = 0.15, 0.07
"""Share of the flow that slips past the rotor at full load: 0.05 to 0.3, more with wear and heat."""


@dataclass(frozen=True)
class TopDriveModel:
    """A top drive: torque that it holds continuously in ft lbf, and highest speed in rpm."""

    name: str
    torque: float
    speed: float
    source: str


TOP_DRIVES = (
    TopDriveModel("NOV TDS-8SA", 63_000.0, 270.0, "NOV, TDS-8SA data sheet, 2008"),
    TopDriveModel("NOV TDS-9SA", 32_500.0, 228.0, "Varco, TDS-9SA technical bulletin, 1997"),
    TopDriveModel("NOV TDS-10SA", 20_000.0, 182.0, "NOV, TDS-10SA data sheet, 2008"),
    TopDriveModel("NOV TDS-11SA", 37_500.0, 228.0, "Varco, TDS-11SA technical bulletin, 1998"),
    TopDriveModel("Canrig 1050E-500", 30_000.0, 180.0, "Canrig, 1050E-500 manual, section 2, rev. 03.02"),
)


@dataclass(frozen=True)
class PumpModel:
    """A triplex mud pump: stroke and largest liner in in, strokes per minute."""

    name: str
    stroke: float
    largest_liner: float
    speed: float


PUMP_SOURCE = "makers' data sheets: National Oilwell P series, Gardner Denver PZ series (manual 15-600, 1998), Bomco F"
PUMPS = (
    PumpModel("8-P-80", 8.5, 6.25, 160.0),
    PumpModel("9-P-100", 9.25, 6.75, 150.0),
    PumpModel("10-P-130", 10.0, 6.75, 140.0),
    PumpModel("12-P-160", 12.0, 7.25, 120.0),
    PumpModel("14-P-220", 14.0, 9.0, 105.0),
    PumpModel("PZ-9", 9.0, 7.0, 130.0),
    PumpModel("PZ-10", 10.0, 7.0, 115.0),
    PumpModel("PZ-11", 11.0, 7.0, 115.0),
    PumpModel("F-1000", 10.0, 6.75, 140.0),
    PumpModel("F-1300", 12.0, 7.0, 120.0),
    PumpModel("F-1600", 12.0, 7.0, 120.0),
)
PUMP_EFFICIENCY, PUMP_EFFICIENCY_SPREAD = 0.96, 0.02
"""Volumetric, of a triplex pump in good order: 0.93 to 0.98."""

Named = TypeVar("Named", MotorSize, TopDriveModel, PumpModel)


def triplex_displacement(liner: float, stroke: float, efficiency: float = PUMP_EFFICIENCY) -> float:
    """Volume of one turn of a single-acting triplex pump, in the cube of the diameters' unit."""
    return 3.0 * math.pi / 4.0 * liner**2 * stroke * efficiency


def find_by_name(text: str, table: Sequence[Named], what: str) -> Named:
    """The row of a table that a text names.

    Every word and number of the text must be in the row's name; "6 3/4" is 6.75.

    Raises:
        InputError: No row or several fit.
    """
    readings = [_words(text, fractions) for fractions in (True, False)]
    found = [row for row in table if any(words and words <= _words(row.name, False) for words in readings)]
    exact = [row for row in found if _words(row.name, False) in readings]
    if len(exact or found) == 1:
        return (exact or found)[0]
    shown = ", ".join(row.name for row in (found or table))
    fault = "fits several" if found else "not in the table"
    raise InputError(f"{what} = {text!r}: {fault}; one of {shown}, or give the numbers of its sheet")


def _words(text: str, fractions: bool) -> set[str]:
    """Words of a name, numbers as decimals, without units.

    fractions: Whether "8 7/8" is a size of 8.875, not a size of 8 and lobes 7/8.
    """
    plain = text.lower()
    if fractions:
        plain = re.sub(r"(?<![\d.])(\d+)[- ](\d+)/(2|4|8|16)(?!\d)", _as_decimal, plain)
    words = re.findall(r"\d+[/:]\d+|\d+\.?\d*|[a-z]+", plain)
    skipped = {"in", "inch", "stage", "stages", "stg", "lobe", "lobes", "motor", "pdm", "top", "drive", "pump"}
    return {f"{float(word):g}" if re.fullmatch(r"\d+\.?\d*", word) else word.replace(":", "/")
            for word in words if word not in skipped}  # fmt: skip


def _as_decimal(match: re.Match[str]) -> str:
    whole, over, under = (int(part) for part in match.groups())
    return f"{whole + over / under:g}"
