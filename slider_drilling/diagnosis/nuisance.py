"""Nuisance parameters: what is calibrated on any rig, and unknowns of a single run. Fitted beside every effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.diagnosis.assumed_priors import assumed_parameters, with_assumed_spreads
from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.diagnosis.unlogged_block import block_rate_parameters
from slider_drilling.diagnosis.unlogged_flow import flow_step_parameters
from slider_drilling.effects.torque_reading import TORQUE_SENSOR_BIAS, TORQUE_SENSOR_GAIN, TORQUE_SENSOR_LAG
from slider_drilling.gap.model import Effect, Parameter, Values
from slider_drilling.rig import Rig

COMPLIANCE = "contact_compliance"
"""How far the contact gives before it slides, over the rig file's."""
COMPLIANCE_DECADES = "contact_compliance_decades"
"""Its decimal logarithm, which is fitted."""
ELASTIC_SHARE = "contact_elastic_share"
"""How far the contact does not slip before it breaks away (`Contact.elastic_share`)."""
VECTOR_SHARE = "contact_vector_share"
"""How far the contact slips with the pipe's velocity as one vector (`Contact.vector_share`)."""
ANISOTROPY = "friction_anisotropy"
"""Exponent of the ratio of the asperity's axes: 0 where friction is the same in all directions."""
TOOL_FACE_OFFSET = "tool_face_offset"
"""rad, toolface less the rotation of the lowest element."""
START_TWISTS = (0.0, -4.0)
"""rad: where a fit of the string's twist at the start begins, if the log does not show it."""
_MIN_FLOW_CHANGE = 0.02  # of the pump's speed


def nuisance_parameters(rig: Rig, channels: Sequence[str]) -> tuple[Parameter, ...]:
    """Calibrated multiples of the rig file's values that these channels can show, and the string's initial twist."""
    # With torque alone no hook load confirms the file's friction and side force, and no toolface its stiffness.
    torque_only = set(channels) == {"surface_torque"}
    lowest, spread = (0.15, 0.5) if torque_only else (0.4, 0.2)
    intervals = range(max(len(rig.well.friction_intervals), 2 if torque_only else 1))
    parameters = [Parameter(f"friction_{index + 1}", 1.0, lowest, 2.5, 0.05, spread=spread) for index in intervals]
    parameters += [
        Parameter("torsional_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5),
        Parameter("start_twist", 0.0, -60.0, 60.0, 0.2, "rad", spread=5.0, per_run=True),
    ]
    if torque_only:
        parameters.append(Parameter("torsional_stiffness", 1.0, 0.7, 1.5, 0.02, spread=0.15))
    if set(channels) & {"hook_load", "standpipe_pressure", "tool_face"}:
        parameters.append(Parameter("axial_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5))
        parameters.append(Parameter("bit_stiffness", 1.0, 0.4, 2.5, 0.05, spread=0.2))
        parameters += tool_joints()
    if "hook_load" in channels:
        parameters += hook_load_reading()
    if "surface_torque" in channels and not torque_only:
        parameters += torque_reading()
    if "standpipe_pressure" in channels:
        # A larger error of the gain is a fault with its own name (motor_wear), not a calibration.
        parameters.append(Parameter("motor_gain", 1.0, 0.85, 1.15, 0.02, spread=0.05))
        parameters.append(Parameter("pressure_gain", 1.0, 0.8, 1.2, 0.005, spread=0.05))
    if "tool_face" in channels:
        parameters.append(Parameter(TOOL_FACE_OFFSET, 0.0, -3.2, 3.2, 0.1, "rad", spread=0.5, per_run=True))
    # What the rig file assumes, it may be wrong in by its own spread.
    return (*with_assumed_spreads(parameters, rig), *assumed_parameters(rig, channels))


def conditional_nuisance() -> tuple[Effect, ...]:
    """What no paper tells of a hole's contact: how far it gives, when and along what it slips, how direction counts.

    Pre-sliding lengths range over decades, from the almost rigid contact of Coulomb's law up (Astrom and Canudas de
    Wit, IEEE Control Systems Magazine 28, 2008). An elasto-plastic contact does not slip before it breaks away (Dupont
    et al., IEEE Transactions on Automatic Control 47, 2002), Dahl's does. The paper lets the axial and the tangential
    motion slip in turn; other models let their vector slip (Velenis, Tsiotras and Canudas de Wit, Vehicle System
    Dynamics 43, 2005). Friction of the paper's asperity is a third smaller in one direction than in the other;
    torque-and-drag models have one coefficient for both (Johancsik, Friesen and Dawson, Journal of Petroleum Technology
    36, 1984). These are calibrated where they explain more than every known effect: beside viscous drag or aging most
    logs cannot identify them.
    """
    compliance = Parameter(COMPLIANCE_DECADES, 0.0, -2.3, 1.0, 0.1, spread=1.0)
    elastic = Parameter(ELASTIC_SHARE, 0.0, 0.0, 1.0, 0.1, spread=0.5)
    vector = Parameter(VECTOR_SHARE, 0.0, 0.0, 1.0, 0.1, spread=0.5)
    anisotropy = Parameter(ANISOTROPY, 1.0, 0.0, 2.0, 0.1, spread=0.5)
    return (
        Effect(COMPLIANCE, "contact", (compliance,), scan=((-2.0,), (-1.2,), (-0.6,), (-0.1,), (0.4,)),
               law="how far the contact gives before it slides"),
        Effect(ELASTIC_SHARE, "contact", (elastic,), scan=((0.05,), (0.5,), (0.9,)),
               law="whether the contact slips before it breaks away"),
        Effect(VECTOR_SHARE, "contact", (vector,), scan=((0.1,), (0.5,), (0.9,)),
               law="whether the contact slips with the pipe's velocity as one vector"),
        Effect(ANISOTROPY, "contact", (anisotropy,), scan=((0.1,), (0.8,), (1.5,)),
               law="how much friction along and across the pipe differ"),
    )  # fmt: skip


def compliance_of(values: Values) -> float:
    """Compliance of the contact over the rig file's, from fitted values or from those that a user knows."""
    return float(values.get(COMPLIANCE, 10.0 ** values.get(COMPLIANCE_DECADES, 0.0)))


def reported_nuisance() -> dict[str, Parameter]:
    """Nuisance that a user knows under another name than it is fitted under, by that name."""
    return {COMPLIANCE: Parameter(COMPLIANCE, 1.0, 0.005, 10.0, 0.1)}


def with_reported_nuisance(values: Values) -> dict[str, float]:
    """Values as a user knows them: the compliance itself, not its logarithm."""
    reported = {name: value for name, value in values.items() if name != COMPLIANCE_DECADES}
    return reported | {COMPLIANCE: compliance_of(values)} if COMPLIANCE_DECADES in values else reported


def tool_joints() -> tuple[Parameter, ...]:
    """What tool joints, wear and mud that moves with the pipe change: weight and inertia, and the lever of friction.

    Sources: API RP 7G, adjusted weights 4 to 12 % above plain ends, of which a tally keeps most; API 5DP, joints 1.2 to
    1.3 times as wide as their pipe, which carry a part of the side force.
    """
    return (
        Parameter("string_weight", 1.0, 0.93, 1.1, 0.01, spread=0.02),
        Parameter("contact_radius", 1.0, 0.95, 1.25, 0.01, spread=0.05),
    )


def hook_load_reading() -> tuple[Parameter, ...]:
    """How the hook load is read: what is left of the block's weight after the tare, gain, and friction of the sheaves.

    Sources of the spreads: Luke and Juvkam-Wold, SPE Drilling Engineering 8 (1993), sheave friction of 1 to 3 % of the
    load; Cayeux et al., SPE 163492 (2013), transducers of 0.5 to 2 %.
    """
    return (
        Parameter("hook_load_offset", 0.0, -5e5, 5e5, 2e3, "N", spread=1.5e4),
        Parameter("hook_load_gain", 1.0, 0.8, 1.25, 0.005, spread=0.015),
        Parameter("sheave_friction", 0.0, -1e3, 4e4, 1e3, "N", spread=4e3),
    )


def torque_reading() -> tuple[Parameter, ...]:
    """How surface torque is read, within what nobody acts on. A larger error is a fault with a name of its own.

    The bounds are the smallest faults that the registry of effects calls material, the spreads half of them: a log
    cannot distinguish the two, but by their size.
    """
    gain, bias, lag = (effect.sizes.material for effect in (TORQUE_SENSOR_GAIN, TORQUE_SENSOR_BIAS, TORQUE_SENSOR_LAG))
    share, zero, delay = gain["gain"], bias["bias"], lag["lag"]
    return (
        Parameter("torque_gain", 1.0, 1.0 - share, 1.0 + share, 0.005, spread=0.5 * share),
        Parameter("torque_offset", 0.0, -zero, zero, 0.5 * zero, "N m", spread=0.5 * zero),
        Parameter("torque_delay", 0.0, -delay, delay, 0.02, "s", spread=0.5 * delay),
    )


def run_parameters(channels: Sequence[str], runs: Sequence[RunInputs]) -> tuple[Parameter, ...]:
    """Parameters that stand for what these logs lack: block rate, flow steps, state of a loaded string at the start."""
    parameters: tuple[Parameter, ...] = ()
    if any(run.block_from_pressure for run in runs):
        parameters += block_rate_parameters([run.commands for run in runs])
    if "standpipe_pressure" in channels and any(_flow_changes(run) for run in runs):
        # The lag of the mud column shows where the flow changes suddenly.
        parameters += (Parameter("pressure_lag", 1.0, 0.3, 3.0, 0.05, spread=0.2),)
        parameters += flow_step_parameters([run.flow_step_times or () for run in runs])
    if any(run.initial_state.loaded for run in runs):
        parameters += loaded_start_parameters()
    return parameters


def _flow_changes(run: RunInputs) -> bool:
    """Whether the pump's speed changed, or may have."""
    speed = run.commands.pump_speed
    changed = float(np.ptp(speed)) > _MIN_FLOW_CHANGE * float(np.max(np.abs(speed), initial=0.0))
    return bool(run.flow_step_times) or changed


def loaded_start_parameters() -> tuple[Parameter, ...]:
    """Initial state of a loaded string: weight on bit and axial friction beyond what the log's first second shows, and
    the tangential share of the friction.
    """
    return (
        Parameter("start_weight", 0.0, -5e5, 5e5, 2e3, "N", spread=2e4, per_run=True),
        Parameter("start_drag", 0.0, -2.0, 2.0, 0.05, spread=0.3, per_run=True),
        Parameter("start_hold", 0.0, -1.0, 1.0, 0.05, spread=0.3, per_run=True),
    )
