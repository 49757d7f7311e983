"""The contenders of a closed loop: the controller under test, its upper bounds and the baselines."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from slider_drilling.control import FixedRocking, SlideController, SlideSettings
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER, configure, load_controller, settings_of
from slider_drilling.control.fixed_rocking import settings_for
from slider_drilling.control.interface import Controller, Measurements, MwdSample
from slider_drilling.drillstring import GroundTruth
from slider_drilling.rig import Mwd, Rig
from slider_drilling.slide_scenarios.scenario import Scenario

UNDER_TEST = "controller"
NO_ROCKING = "no_rocking"
FIXED_ROCKING = "fixed_rocking"
SHIFTED_ROCKING = "shifted_rocking"
INFORMED = "informed"
ORACLE = "oracle"
BASELINES = (NO_ROCKING, FIXED_ROCKING, SHIFTED_ROCKING)
UPPER_BOUNDS = (INFORMED, ORACLE)
ABOUT = {
    UNDER_TEST: "the controller under test",
    INFORMED: "the controller under test with the true rig file; the difference is the cost of an inaccurate rig file",
    ORACLE: "the informed controller with the true toolface at 10 Hz; the difference is the cost of MWD",
    NO_ROCKING: "top drive held still",
    FIXED_ROCKING: "constant rocking without toolface control",
    SHIFTED_ROCKING: "constant rocking, its centre shifted by a tenth of the last error",
}


def build_contender(
    contender: str, scenario: Scenario, name: str = DEFAULT_CONTROLLER, settings: Mapping[str, float] | None = None
) -> Controller:
    """Build a contender for a scenario.

    Args:
        contender: A key of `ABOUT`.
        scenario: The slide.
        name: module:Class of the controller under test.
        settings: Settings of the controller under test that differ from its defaults.

    Raises:
        InputError: The controller cannot be built, or a setting is out of its range.
    """
    rig = rig_file_for(contender, scenario)
    fixed = settings_for(rig)
    if contender == NO_ROCKING:
        return FixedRocking(rig, dataclasses.replace(fixed, amplitude=0.0, shift_gain=0.0))
    if contender == FIXED_ROCKING:
        return FixedRocking(rig, dataclasses.replace(fixed, shift_gain=0.0))
    if contender == SHIFTED_ROCKING:
        return FixedRocking(rig, fixed)
    if name != DEFAULT_CONTROLLER:
        controller = load_controller(name, rig)
        if settings:
            configure(controller, dataclasses.replace(settings_of(controller), **settings))
        return controller
    limits = {"make_up_torque_limit": scenario.make_up_limit, "back_off_torque_limit": scenario.back_off_limit}
    known = {key: value for key, value in limits.items() if value}
    return SlideController(rig, dataclasses.replace(SlideSettings(), **{**known, **(settings or {})}))


def rig_file_for(contender: str, scenario: Scenario) -> Rig:
    """Return the rig file that the contender gets: the assumed one, or the true one for the upper bounds.

    Raises:
        InputError: The installation lacks the rig file.
    """
    if contender not in UPPER_BOUNDS:
        return scenario.assumed_rig()
    rig = scenario.true_rig()
    if contender == INFORMED:
        return rig
    ideal = Mwd(period=1.0 / rig.sensors.rate, latency=0.0, noise=0.0, resolution=0.0)
    return dataclasses.replace(rig, sensors=dataclasses.replace(rig.sensors, mwd=ideal))


def measurements_for(contender: str, measurements: Measurements, truth: GroundTruth) -> Measurements:
    """Return what the contender sees of a sample; the oracle gets the true toolface in each."""
    if contender != ORACLE:
        return measurements
    tool_face = math.remainder(truth.tool_face, 2.0 * math.pi)
    return dataclasses.replace(measurements, mwd=(MwdSample(truth.time, truth.time, tool_face),))
