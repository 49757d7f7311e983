"""All checks of a log, in the order in which each result makes the next check meaningful."""

from __future__ import annotations

from dataclasses import dataclass, field

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log_checks import expected_levels
from slider_drilling.log_checks.block_weight import check_block_weight
from slider_drilling.log_checks.check_table import CheckRow, check_rows
from slider_drilling.log_checks.excitation import check_excitation
from slider_drilling.log_checks.glitches import mask_glitches
from slider_drilling.log_checks.imported import check_import
from slider_drilling.log_checks.issue import Check, LogIssue, Severity
from slider_drilling.log_checks.position_and_speed import check_position_and_speed
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.log_checks.signs import check_signs
from slider_drilling.log_checks.time_stamps import check_time_stamps
from slider_drilling.log_checks.undeclared_nulls import mask_undeclared_nulls
from slider_drilling.log_checks.units_and_levels import check_level, check_pump_unit, check_tool_face_unit
from slider_drilling.log_checks.unknown_flow import mask_pressure_of_unknown_flow
from slider_drilling.log_checks.unsigned import check_unsigned
from slider_drilling.rig import Rig
from slider_drilling.units import Text

_NO_RIG = "needs the rig file: give it with --rig"
_NO_ROTATION = "the string never rotates for 20 s with the block at rest and a hook load"


@dataclass(frozen=True)
class LogChecks:
    """A checked log.

    Attributes:
        log: The log with repeated samples, glitches, and pressure measured at an unknown flow masked (NaN).
        issues: What the checks report, in their order.
        unchecked: Reasons why a check could not be made.
    """

    log: RigLog
    issues: tuple[LogIssue, ...]
    unchecked: dict[Check, str] = field(default_factory=dict, compare=False)

    def rows(self) -> tuple[CheckRow, ...]:
        """The table of checks."""
        return check_rows(self.log, self.issues, self.unchecked)

    def texts(self, severity: Severity) -> tuple[Text, ...]:
        """The sentences of one severity."""
        return tuple(issue.text for issue in self.issues if issue.severity == severity)

    def messages(self, severity: Severity) -> tuple[str, ...]:
        """The sentences of one severity, in SI units."""
        return tuple(str(text) for text in self.texts(severity))

    def raise_if_unusable(self) -> None:
        """Raise InputError, one line, if the log is unusable as it is or with this rig file."""
        reasons = self.messages("unusable")
        if reasons:
            raise InputError(f"{self.log.source}: {'; '.join(reasons)}")


def check_log(log: RigLog, rig: Rig, whole: bool = True) -> LogChecks:
    """Check a log against itself and against its rig file. Takes less than a second for a log of 400 s.

    Nothing is fitted. The checks compare time stamps with each other, angle with speed, levels with what the rig file's
    friction and flow allow, and signs with the energy balance and with one simulation of the logged motion.

    Args:
        log: The log as recorded.
        rig: The rig that the log is said to come from.
        whole: Whether the log begins as a run does. A part of a run may begin while wall and bit carry the string: its
            hook load shows no unit then.

    Raises:
        InputError: The log holds no top drive, so that nothing drives the plant.
    """
    if log.top_drive is None:
        raise InputError(log.lack_of_top_drive("drives the plant"))
    stamps = [*check_time_stamps(log, rig), *check_import(log)]
    if _any_unusable(stamps):
        return LogChecks(log, tuple(stamps))
    log, nulls = mask_undeclared_nulls(log)
    log, repeats = mask_repeated_samples(log)
    log, glitches = mask_glitches(log, rig)
    log, unknown = mask_pressure_of_unknown_flow(log)
    unsigned = check_unsigned(log)
    motion = [] if unsigned else check_position_and_speed(log, rig)
    issues = [*stamps, *nulls, *repeats, *glitches, *unknown, *unsigned, *motion, *check_tool_face_unit(log)]
    block, rotates = check_block_weight(log, rig)
    issues += block
    unchecked: dict[Check, str] = {} if rotates else {"block weight": _NO_ROTATION}
    rig = expected_levels.rig_off_bottom(log, rig)
    issues += check_level("hook_load", expected_levels.hook_load(log, rig, whole), log.imported)
    issues += check_pump_unit(log, rig) or check_level(
        "standpipe_pressure", expected_levels.standpipe_pressure(log, rig), log.imported
    )
    idle = check_excitation(log, rig)
    if _any_unusable(issues) or idle:
        # Without a usable motion there is no simulation to compare signs with.
        return LogChecks(log, (*issues, *check_signs(log, rig, None), *idle), unchecked)
    response = expected_levels.simulate_as_given(log, rig)
    if response is not None:
        torque = expected_levels.surface_torque(log, response.time, response.surface_torque)
        issues += check_level("surface_torque", torque, log.imported)
    issues += check_signs(log, rig, response)
    return LogChecks(log, tuple(issues), unchecked)


def check_without_rig(log: RigLog, reason: str = "") -> LogChecks:
    """The checks that need no rig file: rate, gaps, clock, nulls, signs, integrated channels.

    Args:
        log: The log.
        reason: Why the others are not made; by default, what makes them.
    """
    issues = [*check_time_stamps(log, None), *check_import(log)]
    if not _any_unusable(issues):
        masked, nulls = mask_undeclared_nulls(log)
        issues += [*nulls, *check_unsigned(masked)]
    reason = reason or (_NO_RIG if log.rig_text is None else "`slider-drilling info` compares log and rig file")
    return LogChecks(log, tuple(issues), {"units and levels": reason, "block weight": reason})


def _any_unusable(issues: list[LogIssue]) -> bool:
    return any(issue.severity == "unusable" for issue in issues)
