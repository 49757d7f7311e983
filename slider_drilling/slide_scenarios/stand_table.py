"""Table and JSON of `closed-loop --stands`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from slider_drilling.slide_scenarios.stand_run import StandScore
from slider_drilling.units import Units, format_number

SCHEMA = "slider_drilling/closed_loop_stands/1"


def terminal_header(units: Units) -> tuple[str, ...]:
    """Column labels over `terminal_row`."""
    length, torque, weight, pressure = (units.display_unit(unit) for unit in ("m", "kN m", "kN", "bar"))
    return ("stand", "oriented\ns", "mean\ndeg", "largest\ndeg", f"slid\n{length}", f"torque\n{torque}",
            f"weight\n{weight}", f"pressure\n{pressure}", "within\nlimits")  # fmt: skip


def terminal_row(score: StandScore, units: Units) -> tuple[str, ...]:
    """One line of the terminal's table: a cell for each of `terminal_header`."""
    right, left = (format_number(units.convert(torque / 1e3, "kN m"))
                   for torque in (score.right_torque_n_m, score.left_torque_n_m))  # fmt: skip
    return (score.name, _figure(score.time_to_orient_s, 0, "never"), _figure(score.mean_abs_error_deg, 1, "-"),
            _figure(score.largest_error_deg, 1, "-"), format_number(units.convert(score.slid_m, "m")),
            f"{right} / {left}", format_number(units.convert(score.peak_weight_n / 1e3, "kN")),
            format_number(units.convert(score.peak_pressure_pa / 1e5, "bar")),
            "yes" if score.within_limits else "NO")  # fmt: skip


def as_json(scores: Sequence[StandScore], seed: int, elements: int, partial: bool) -> dict[str, Any]:
    """Return the tree of closed_loop_stands.json."""
    rows = [{key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(score).items()}
            for score in scores]  # fmt: skip
    return {"schema": SCHEMA, "seed": seed, "elements": elements, "partial": partial, "stands": rows}


def _figure(value: float | None, digits: int, otherwise: str) -> str:
    return otherwise if value is None else f"{value:.{digits}f}"
