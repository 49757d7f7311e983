"""Every check in the order in which one makes the next meaningful."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log_checks import expected
from slider_drilling.log_checks.clock import look_at_clock
from slider_drilling.log_checks.excitation import look_at_excitation
from slider_drilling.log_checks.finding import Finding, Weight
from slider_drilling.log_checks.glitches import without_glitches
from slider_drilling.log_checks.levels import look_at_level, look_at_pump, look_at_tool_face
from slider_drilling.log_checks.motion import look_at_motion
from slider_drilling.log_checks.repeats import without_repeats
from slider_drilling.log_checks.signs import look_at_signs
from slider_drilling.log_checks.unknown_flow import without_unknown_flow
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class FirstLook:
    """log: the log with repeats, glitches, and pressure of an unknown flow, masked (NaN); findings: what was noticed,
    in the order of the checks.
    """

    log: RigLog
    findings: tuple[Finding, ...]

    def texts(self, weight: Weight) -> tuple[str, ...]:
        """The sentences of one weight."""
        return tuple(finding.text for finding in self.findings if finding.weight == weight)

    def refuse(self) -> None:
        """Raise InputError, one line, where the log cannot be used as it is or not with this rig file."""
        reasons = self.texts("refuse")
        if reasons:
            raise InputError(f"{self.log.source}: {'; '.join(reasons)}")


def first_look(log: RigLog, rig: Rig) -> FirstLook:
    """Look at a log and the rig file that it is said to belong to; takes well under a second for a log of 400 s.

    Nothing is fitted: stamps against each other, angle against speed, levels against what friction and flow of the
    rig file allow, signs against energy and one replay of the log's own motions. Raises InputError for a log without
    a top drive, which nothing could drive.
    """
    if log.top_drive is None:
        raise InputError(f"{log.source}: holds no top_drive/joint_states; without it nothing drives the plant")
    clock = look_at_clock(log, rig)
    if _refused(clock):
        return FirstLook(log, tuple(clock))
    log, repeats = without_repeats(log)
    log, glitches = without_glitches(log, rig)
    log, unknown = without_unknown_flow(log)
    found = [*clock, *repeats, *glitches, *unknown, *look_at_motion(log, rig), *look_at_tool_face(log)]
    rig = expected.off_bottom(log, rig)
    found += look_at_level("hook_load", expected.hook_load(log, rig))
    found += look_at_pump(log, rig) or look_at_level("standpipe_pressure", expected.standpipe_pressure(log, rig))
    idle = look_at_excitation(log, rig)
    if _refused(found) or idle:
        return FirstLook(log, (*found, *look_at_signs(log, rig, None), *idle))
    run = expected.replayed(log, rig)
    response = None if run is None else run[1]
    if response is not None:
        found += look_at_level("surface_torque", expected.surface_torque(log, response))
    found += look_at_signs(log, rig, response)
    return FirstLook(log, tuple(found))


def _refused(findings: list[Finding]) -> bool:
    return any(finding.weight == "refuse" for finding in findings)
