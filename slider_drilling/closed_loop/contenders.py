"""The controller under test and what it is held against."""

from __future__ import annotations

import dataclasses

from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.control import FixedRocking, SlideController, SlideSettings
from slider_drilling.control.fixed_rocking import settings_for
from slider_drilling.control.load import DEFAULT, load_controller
from slider_drilling.control.protocol import Controller
from slider_drilling.rig import Rig

UNDER_TEST = "controller"
NO_ROCKING = "no_rocking"
FIXED_ROCKING = "fixed_rocking"
SHIFTED_ROCKING = "shifted_rocking"
BASELINES = (NO_ROCKING, FIXED_ROCKING, SHIFTED_ROCKING)
ABOUT = {
    UNDER_TEST: "the controller under test",
    NO_ROCKING: "top drive held still",
    FIXED_ROCKING: "constant rocking, no tool-face control",
    SHIFTED_ROCKING: "constant rocking, centre shifted by a tenth of the last error",
}


def build(contender: str, scenario: Scenario, rig: Rig, name: str = DEFAULT) -> Controller:
    """The contender for this scenario; `name` is the module:Class under test. Raises InputError."""
    fixed = settings_for(rig)
    if contender == NO_ROCKING:
        return FixedRocking(rig, dataclasses.replace(fixed, amplitude=0.0, shift_gain=0.0))
    if contender == FIXED_ROCKING:
        return FixedRocking(rig, dataclasses.replace(fixed, shift_gain=0.0))
    if contender == SHIFTED_ROCKING:
        return FixedRocking(rig, fixed)
    if name != DEFAULT:
        return load_controller(name, rig)
    limits = {"make_up_torque_limit": scenario.make_up_limit, "back_off_torque_limit": scenario.back_off_limit}
    return SlideController(rig, dataclasses.replace(SlideSettings(), **{k: v for k, v in limits.items() if v}))
