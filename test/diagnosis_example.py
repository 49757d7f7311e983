"""A diagnosis as plain data, for tests of what is said and shown of one."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from slider_drilling.diagnosis.result import (
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    Diagnosis,
    FittedParameter,
    Gap,
    RankedEffect,
    ResidualShape,
)
from slider_drilling.diagnosis.rig_source import RigSource
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.results.breakdown import GapBreakdown
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.log import RigLog
from slider_drilling.log_checks import LogChecks, LogIssue
from slider_drilling.rig import load_rig

RIG = load_rig(installed_file("config/rig.example.yaml"))
SOURCE = RigSource("own.yaml", "given", "b/own.yaml")
DEG = math.pi / 180.0


def inconclusive(*issues: str) -> Diagnosis:
    """A diagnosis that ended with the checks of its log."""
    checks = LogChecks(RigLog("a/run.mcap", 0), tuple(LogIssue("uninformative", "top_drive", text) for text in issues))
    return Diagnosis(("a/run.mcap",), RIG, SOURCE, (checks,), "inconclusive")


def worn_motor() -> Diagnosis:
    """A motor that gives 24 % less torque per pressure, with two other candidates."""
    motor = RankedEffect("motor_wear", "motor", True, True, (), 0.92, (0.64, 0.97), {
        "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0, (0.21, 0.27)),
        "motor_wear.extra_leak": FittedParameter(0.0, "-", 0.0),
    }, ())  # fmt: skip
    other = RankedEffect("formation_change", "bit", True, False, ("motor_wear explains it better",), 0.4, (-2.0, 0.5), {
        "formation_change.factor": FittedParameter(0.8, "-", 1.0),
        "formation_change.time": FittedParameter(3.0, "s", 200.0),
    }, ())  # fmt: skip
    screened = RankedEffect("heave", "draw_works", False, False, ("not fitted",), None, None, {}, ())
    gap = Gap(
        9.0, 8.0, 1.1, 0.92, (0.64, 0.97), 1.2,
        {"tool_face": ChannelNoise(0.02, 0.02, "rad", "declared"),
         "hook_load": ChannelNoise(4e3, 3e3, "N", "differences")},
        {"tool_face": ChannelErrors("rad", 130.0 * DEG, 118.0 * DEG, 3.0 * DEG),
         "hook_load": ChannelErrors("N", 9e3, 8e3, 4e3)},
    )  # fmt: skip
    time = np.arange(0.0, 40.0, 0.1)
    stages = {"nominal": np.cos(time), "tuned": 0.5 * np.cos(time), "with_effect": np.sin(time)}
    errors = {stage: {"tool_face": 0.1, "hook_load": 2e3} for stage in stages}
    return Diagnosis(
        ("a/run.mcap",), RIG, SOURCE, (), "effect", "motor", ("motor_wear",), gap=gap, ranking=(motor, other, screened),
        breakdown=GapBreakdown({"tool_face": 0.9, "hook_load": 0.1}, {"still": 1.0}, {"above": 1.0},
                               [{"from": 0.0, "to": 40.0, "share": 1.0}],
                               [{"from": 0.0, "to": 900.0, "share": 1.0, "change": 0.3}]),
        tuned_parameters={"friction_1": FittedParameter(1.12, "-", 1.0),
                          "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0)},
        whole_run_errors=WholeRunErrors(0.5, errors, errors, errors, {"nominal": 0, "tuned": 9, "with_effect": 11},
                                        {}, (), SimpleNamespace(), {}),
        traces=(ChannelTrace(0, "tool_face", "rad", time, np.sin(time), stages, 20.0),
                ChannelTrace(0, "hook_load", "N", time, np.sin(time), stages, 20.0)),
        runtime=12.0,
    )  # fmt: skip


def shaped(of: str) -> ResidualShape:
    """What remains: pressure that is lost steadily; of: see `ResidualShape`."""
    time = 60.0 * np.arange(3.0)
    return ResidualShape(of, "pressure lost over time", time, 2e5 * np.arange(3.0), "s", "Pa")
