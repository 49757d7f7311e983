"""What any rig is tuned in, and what of a run nobody logged: fitted beside every effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.diagnosis.unlogged_block import block_rates
from slider_drilling.diagnosis.unlogged_flow import step_parameters
from slider_drilling.gap.model import Parameter
from slider_drilling.rig import Rig

# Of the pump's speed, by which it was set to another.
_OTHER_FLOW = 0.02


def nuisance_parameters(rig: Rig, channels: Sequence[str]) -> tuple[Parameter, ...]:
    """What any rig is tuned in, as multiples of the rig file's values; those that no channel can see are left out."""
    # Nothing but torque: no hook load has checked the file's friction, nor what a bend of the hole presses the string
    # with; no toolface how far its string twists.
    alone = set(channels) == {"surface_torque"}
    lowest, spread = (0.15, 0.5) if alone else (0.4, 0.2)
    intervals = range(max(len(rig.well.friction_intervals), 2 if alone else 1))
    found = [Parameter(f"friction_{index + 1}", 1.0, lowest, 2.5, 0.05, spread=spread) for index in intervals]
    found += [
        Parameter("torsional_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5),
        Parameter("start_twist", 0.0, -60.0, 60.0, 0.2, "rad", spread=5.0, per_run=True),
    ]
    if alone:
        found.append(Parameter("torsional_stiffness", 1.0, 0.7, 1.5, 0.02, spread=0.15))
    seen = set(channels)
    if seen & {"hook_load", "standpipe_pressure", "tool_face"}:
        found.append(Parameter("axial_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5))
        found.append(Parameter("bit_stiffness", 1.0, 0.4, 2.5, 0.05, spread=0.2))
    if "standpipe_pressure" in seen:
        # A gain that is off by more than this is a fault with a name (motor_wear), not a calibration.
        found.append(Parameter("motor_gain", 1.0, 0.85, 1.15, 0.02, spread=0.05))
        found.append(Parameter("pressure_gain", 1.0, 0.8, 1.2, 0.005, spread=0.05))
    if "tool_face" in seen:
        found.append(Parameter("tool_face_offset", 0.0, -3.2, 3.2, 0.1, "rad", spread=0.5, per_run=True))
    return tuple(found)


def run_parameters(channels: Sequence[str], runs: Sequence[RunInputs]) -> tuple[Parameter, ...]:
    """What is tuned because of how these runs were driven and of what their logs do not hold."""
    found: tuple[Parameter, ...] = ()
    if any(run.lowered for run in runs):
        found += block_rates([run.commands for run in runs])
    if "standpipe_pressure" in channels and any(_flow_changes(run) for run in runs):
        # Of the column of mud, which shows where the flow changes at once.
        found += (Parameter("pressure_lag", 1.0, 0.3, 3.0, 0.05, spread=0.2),)
        found += step_parameters([run.flow_steps or () for run in runs])
    if any(run.start.loaded for run in runs):
        found += work_parameters()
    return found


def _flow_changes(run: RunInputs) -> bool:
    """Whether the pump was set to another speed meanwhile, or may have been."""
    speed = run.commands.pump_speed
    return bool(run.flow_steps) or float(np.ptp(speed)) > _OTHER_FLOW * float(np.max(np.abs(speed), initial=0.0))


def work_parameters() -> tuple[Parameter, ...]:
    """Of a string that was at work when its log began: weight on its bit and share of the friction along the hole
    beyond what the first second shows, and the share of that which acts around it.
    """
    return (
        Parameter("start_weight", 0.0, -5e5, 5e5, 2e3, "N", spread=2e4, per_run=True),
        Parameter("start_drag", 0.0, -2.0, 2.0, 0.05, spread=0.3, per_run=True),
        Parameter("start_hold", 0.0, -1.0, 1.0, 0.05, spread=0.3, per_run=True),
    )
