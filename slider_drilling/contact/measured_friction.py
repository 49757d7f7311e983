"""Measured friction, as `identify` reads it from a CSV table: over time, or over velocity.

Over time: one row per sample of one experiment, which starts with the contact undeformed:

    time_s            s, increasing
    axial_m           m, displacement along the hole's axis
    tangential_m      m, displacement across it (left out: none)
    normal_force_n    N
    friction_n        N along the axis, positive where it resists motion towards positive axial_m
    tangential_friction_n   N across it, likewise (left out: not measured)

Over velocity: one row per settled experiment, with the mean friction while a harmonic vibration is added to a feed:

    feed_m_per_s        m/s, along the axis
    vibration_m_per_s   m/s, amplitude of the vibration's velocity
    frequency_hz        Hz
    direction_deg       degrees from the axis to the vibration (left out: 0, longitudinal)
    normal_force_n      N
    friction_n          N, mean along the axis, positive where it resists the feed
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError

OVER_TIME = ("time_s", "axial_m", "normal_force_n", "friction_n")
OPTIONAL_OVER_TIME = ("tangential_m", "tangential_friction_n")
OVER_VELOCITY = ("feed_m_per_s", "vibration_m_per_s", "frequency_hz", "normal_force_n", "friction_n")
OPTIONAL_OVER_VELOCITY = ("direction_deg",)

Series = NDArray[np.float64]
# Largest plausible magnitude in each column's unit: a larger number has the wrong unit.
LIMITS = {
    "time_s": 1e9, "axial_m": 1e4, "tangential_m": 1e4, "normal_force_n": 1e8, "friction_n": 1e8,
    "tangential_friction_n": 1e8, "feed_m_per_s": 1e3, "vibration_m_per_s": 1e3, "frequency_hz": 1e5,
    "direction_deg": 1e4,
}  # fmt: skip


@dataclass(frozen=True)
class FrictionOverTime:
    """One experiment over time: arrays (n,) in s, m and N; tangential_friction is empty where not measured."""

    time: Series
    axial: Series
    tangential: Series
    normal_force: Series
    friction: Series
    tangential_friction: Series


@dataclass(frozen=True)
class FrictionOverVelocity:
    """Settled experiments: arrays (n,) in m/s, m/s, Hz, rad, N and N."""

    feed: Series
    vibration: Series
    frequency: Series
    direction: Series
    normal_force: Series
    friction: Series


def read_measured(path: Path) -> FrictionOverTime | FrictionOverVelocity:
    """Read a table of measured friction; its header says which of the two kinds it is.

    Raises InputError naming the file, and the lines with a missing, NaN or impossible value.
    """
    header, columns = _columns(path)
    if "time_s" in header:
        table = _named(path, header, columns, OVER_TIME, OPTIONAL_OVER_TIME)
        _check(path, "time_s", np.concatenate([[True], np.diff(table["time_s"]) > 0.0]), "must increase")
        _check(path, "normal_force_n", table["normal_force_n"] > 0.0, "must be positive")
        _require_friction(path, table["friction_n"])
        nothing = np.zeros(0)
        return FrictionOverTime(
            table["time_s"], table["axial_m"], table.get("tangential_m", np.zeros_like(table["time_s"])),
            table["normal_force_n"], table["friction_n"], table.get("tangential_friction_n", nothing),
        )  # fmt: skip
    table = _named(path, header, columns, OVER_VELOCITY, OPTIONAL_OVER_VELOCITY)
    for name in ("feed_m_per_s", "frequency_hz", "normal_force_n"):
        _check(path, name, table[name] > 0.0, "must be positive")
    _check(path, "vibration_m_per_s", table["vibration_m_per_s"] >= 0.0, "must not be negative")
    _require_friction(path, table["friction_n"])
    direction = np.radians(table.get("direction_deg", np.zeros_like(table["feed_m_per_s"])))
    return FrictionOverVelocity(
        table["feed_m_per_s"], table["vibration_m_per_s"], table["frequency_hz"], direction, table["normal_force_n"],
        table["friction_n"],
    )  # fmt: skip


def _require_friction(path: Path, friction: Series) -> None:
    if not friction.any():
        raise InputError(f"{path}: friction_n is zero throughout: there is no friction to identify")


def _columns(path: Path) -> tuple[list[str], list[list[str]]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read this table: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV table: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{path}: needs a header line and rows below it")
    header = [name.strip() for name in rows[0]]
    repeated = [name for name in dict.fromkeys(header) if header.count(name) > 1]
    if repeated:
        raise InputError(f"{path}: header: {', '.join(repeated)[:100]}: given twice; keep one")
    return header, rows[1:]


def _named(
    path: Path, header: list[str], rows: list[list[str]], needed: tuple[str, ...], optional: tuple[str, ...]
) -> dict[str, Series]:
    missing = [name for name in needed if name not in header]
    if missing:
        raise InputError(
            f"{path}: header: {', '.join(missing)} missing; needs {', '.join(OVER_TIME)} (over time) or "
            f"{', '.join(OVER_VELOCITY)} (over velocity)"
        )
    unknown = [name for name in header if name not in (*needed, *optional)]
    if unknown:
        raise InputError(f"{path}: header: {', '.join(unknown)}: not a column of this table; remove or rename")
    return {name: _numbers(path, name, header.index(name), rows) for name in header}


def _numbers(path: Path, name: str, column: int, rows: list[list[str]]) -> Series:
    values = np.array([_number(row[column]) if column < len(row) else math.nan for row in rows])
    _check(path, name, np.isfinite(values), "is missing or not a finite number")
    _check(path, name, np.abs(values) <= LIMITS[name], f"is beyond {LIMITS[name]:g}; check its unit")
    return values


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _check(path: Path, name: str, good: NDArray[np.bool_], rule: str) -> None:
    bad = np.flatnonzero(~good) + 2
    if bad.size:
        lines = ", ".join(str(line) for line in bad[:5]) + (f" and {bad.size - 5} more" if bad.size > 5 else "")
        raise InputError(f"{path}: line {lines}: {name} {rule}; remove or repair these rows")
