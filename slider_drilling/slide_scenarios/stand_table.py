"""Table and JSON of `closed-loop --stands`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from slider_drilling.slide_scenarios.stand_run import StandScore

SCHEMA = "slider_drilling/closed_loop_stands/1"
HEADER = ("stand", "oriented\ns", "mean\ndeg", "largest\ndeg", "slid\nm", "torque\nkN m", "weight\nkN", "pressure\nbar",
          "within\nlimits")  # fmt: skip


def terminal_row(score: StandScore) -> tuple[str, ...]:
    """One line of the terminal's table: a cell for each of `HEADER`."""
    return (score.name, _figure(score.time_to_orient_s, 0, "never"), _figure(score.mean_abs_error_deg, 1, "-"),
            _figure(score.largest_error_deg, 1, "-"), f"{score.slid_m:.2f}",
            f"{score.right_torque_n_m / 1e3:.1f} / {score.left_torque_n_m / 1e3:.1f}",
            f"{score.peak_weight_n / 1e3:.0f}", f"{score.peak_pressure_pa / 1e5:.0f}",
            "yes" if score.within_limits else "NO")  # fmt: skip


def as_json(scores: Sequence[StandScore], seed: int, elements: int, partial: bool) -> dict[str, Any]:
    """Return the tree of closed_loop_stands.json."""
    rows = [{key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(score).items()}
            for score in scores]  # fmt: skip
    return {"schema": SCHEMA, "seed": seed, "elements": elements, "partial": partial, "stands": rows}


def _figure(value: float | None, digits: int, otherwise: str) -> str:
    return otherwise if value is None else f"{value:.{digits}f}"
