"""Every check in the order in which one makes the next meaningful."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log_checks import expected_levels as expected
from slider_drilling.log_checks.excitation import check_excitation
from slider_drilling.log_checks.glitches import mask_glitches
from slider_drilling.log_checks.issue import LogIssue, Severity
from slider_drilling.log_checks.position_and_speed import check_position_and_speed
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.log_checks.signs import check_signs
from slider_drilling.log_checks.time_stamps import check_time_stamps
from slider_drilling.log_checks.units_and_levels import check_level, check_pump_unit, check_tool_face_unit
from slider_drilling.log_checks.unknown_flow import mask_pressure_of_unknown_flow
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class LogChecks:
    """log: the log with repeats, glitches, and pressure of an unknown flow, masked (NaN); findings: what was noticed,
    in the order of the checks.
    """

    log: RigLog
    issues: tuple[LogIssue, ...]

    def messages(self, severity: Severity) -> tuple[str, ...]:
        """The sentences of one weight."""
        return tuple(finding.text for finding in self.issues if finding.severity == severity)

    def raise_if_unusable(self) -> None:
        """Raise InputError, one line, where the log cannot be used as it is or not with this rig file."""
        reasons = self.messages("unusable")
        if reasons:
            raise InputError(f"{self.log.source}: {'; '.join(reasons)}")


def check_log(log: RigLog, rig: Rig) -> LogChecks:
    """Look at a log and the rig file that it is said to belong to; takes well under a second for a log of 400 s.

    Nothing is fitted: stamps against each other, angle against speed, levels against what friction and flow of the
    rig file allow, signs against energy and one replay of the log's own motions. Raises InputError for a log without
    a top drive, which nothing could drive.
    """
    if log.top_drive is None:
        raise InputError(f"{log.source}: holds no top_drive/joint_states; without it nothing drives the plant")
    clock = check_time_stamps(log, rig)
    if _refused(clock):
        return LogChecks(log, tuple(clock))
    log, repeats = mask_repeated_samples(log)
    log, glitches = mask_glitches(log, rig)
    log, unknown = mask_pressure_of_unknown_flow(log)
    found = [*clock, *repeats, *glitches, *unknown, *check_position_and_speed(log, rig), *check_tool_face_unit(log)]
    rig = expected.rig_off_bottom(log, rig)
    found += check_level("hook_load", expected.hook_load(log, rig))
    found += check_pump_unit(log, rig) or check_level("standpipe_pressure", expected.standpipe_pressure(log, rig))
    idle = check_excitation(log, rig)
    if _refused(found) or idle:
        return LogChecks(log, (*found, *check_signs(log, rig, None), *idle))
    run = expected.simulate_as_given(log, rig)
    response = None if run is None else run[1]
    if response is not None:
        found += check_level("surface_torque", expected.surface_torque(log, response))
    found += check_signs(log, rig, response)
    return LogChecks(log, tuple(found))


def _refused(findings: list[LogIssue]) -> bool:
    return any(finding.severity == "unusable" for finding in findings)
