"""Checks of a log that an import made of a table: what it did, and angles that were integrated rather than measured."""

from __future__ import annotations

from slider_drilling.log import RigLog
from slider_drilling.log.import_record import IntegratedQuantity
from slider_drilling.log_checks.issue import Check, LogIssue
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Quantity, sentence

# rad: an angle that is farther off says nothing of the string's twist, nor of the toolface.
_MAX_ANGLE_ERROR = 1.0
_MAX_POSITION_ERROR = 0.3  # m
_CHECKS: dict[str, Check] = {
    "clock": "clock", "nulls": "nulls", "signs": "signs", "gaps": "gaps", "columns": "samples", "table": "samples",
}  # fmt: skip


def check_import(log: RigLog) -> list[LogIssue]:
    """What the import of a table found and did; angles and positions that it integrated."""
    if log.imported is None:
        return []
    issues = [LogIssue("note", "import", text, _CHECKS[name]) for name, text in log.imported.checks if name in _CHECKS]
    for column, integrated in log.imported.integrated.items():
        issues += _integrated(column, integrated)
    return issues


def _integrated(column: str, integrated: IntegratedQuantity) -> list[LogIssue]:
    angle = "angle" in column
    unit, limit = ("rad", _MAX_ANGLE_ERROR) if angle else ("m", _MAX_POSITION_ERROR)
    name = plain_name(column)
    if integrated.gaps:
        many = "a gap" if integrated.gaps == 1 else f"{integrated.gaps} gaps"
        text = sentence(
            f"{name} was integrated from its speed, which has {many} of {integrated.in_gaps:.0f} s: what it turned "
            "there is not known; import a stretch without gaps with --rows, or the measured angle"
        )
        return [LogIssue("uninformative", "top_drive" if angle else "draw_works", text, "integrated")]
    text = sentence(
        f"{name} was integrated from its speed and may be off by ", Quantity(integrated.error, unit, 2),
    )  # fmt: skip
    if integrated.error <= limit:
        return [LogIssue("note", "top_drive" if angle else "draw_works", text, "integrated")]
    text = sentence(
        text, ": too far to compare twist and toolface; record the angle itself, or the speed more than once a second"
    )
    return [LogIssue("uninformative", "top_drive" if angle else "draw_works", text, "integrated")]
