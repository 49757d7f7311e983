"""A rig, and the state that a run begins in, with the values of parameters."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.catalogue import to_user
from slider_drilling.diagnosis.disturbances import ACROSS, GIVE
from slider_drilling.diagnosis.nuisance import (
    ANISOTROPY,
    COMPLIANCE,
    COMPLIANCE_DECADES,
    ELASTIC_SHARE,
    VECTOR_SHARE,
    compliance_of,
)
from slider_drilling.diagnosis.rig_changes import with_rig_changes
from slider_drilling.drillstring import InitialState
from slider_drilling.effects import Effects
from slider_drilling.gap.model import Parameter, Values
from slider_drilling.rig import Asperity, Contact, FrictionInterval, Rig


def rig_with(rig: Rig, values: Values) -> Rig:
    """The rig with nuisance multiples and effect parameters; values that are not the rig's are ignored.

    If the file has one friction for the whole hole, ``friction_2`` is that of its lower half.
    """
    values = with_rig_changes(values)
    intervals = rig.well.friction_intervals or (FrictionInterval(rig.string.length, 1.0),)
    if len(intervals) == 1 and "friction_2" in values:
        intervals = (FrictionInterval(0.5 * rig.string.length, intervals[0].factor), *intervals)
    scaled = [
        replace(interval, factor=interval.factor * values.get(f"friction_{index + 1}", 1.0))
        for index, interval in enumerate(intervals)
    ]
    string, motor, hydraulics = rig.string, rig.motor, rig.hydraulics
    calibrated = replace(
        rig,
        well=replace(rig.well, friction_intervals=with_probes(tuple(scaled), rig.string.length, values)),
        string=replace(
            string,
            shear_modulus=string.shear_modulus * values.get("torsional_stiffness", 1.0),
            axial_damping=string.axial_damping * values.get("axial_damping", 1.0),
            torsional_damping=string.torsional_damping * values.get("torsional_damping", 1.0),
            weight_factor=string.weight_factor * values.get("string_weight", 1.0),
            contact_radius_factor=string.contact_radius_factor * values.get("contact_radius", 1.0),
        ),
        contact=contact_with(rig.contact, values),
        bit=replace(
            rig.bit,
            aggressiveness=rig.bit.aggressiveness * values.get("bit_aggressiveness", 1.0),
            depth_of_cut_stiffness=rig.bit.depth_of_cut_stiffness * values.get("bit_stiffness", 1.0),
        ),
        motor=replace(
            motor,
            torque_per_pressure=motor.torque_per_pressure * values.get("motor_gain", 1.0),
            leak=motor.leak * values.get("motor_leak", 1.0),
        ),
        hydraulics=replace(
            hydraulics,
            reference_pressure=hydraulics.reference_pressure * values.get("pressure_gain", 1.0),
            lag=hydraulics.lag * values.get("pressure_lag", 1.0),
        ),
    )
    return replace(calibrated, effects=_effects_with(calibrated, to_user(values, string.length)))


def contact_with(contact: Contact, values: Values) -> Contact:
    """The contact with its asperities turned or rounder, and with another compliance before it slides."""
    if not {ACROSS, GIVE, COMPLIANCE, COMPLIANCE_DECADES, ANISOTROPY, ELASTIC_SHARE, VECTOR_SHARE} & set(values):
        return contact
    angle, before = contact.asperity.orientation, share_across(contact)
    after = float(np.clip(before + values.get(ACROSS, 0.0), 0.0, 1.0))
    turned = float(np.arcsin(np.sqrt(after)) - np.arcsin(np.sqrt(before)))
    away = -1.0 if np.sin(2.0 * angle) < 0.0 else 1.0
    asperity = _with_anisotropy(replace(contact.asperity, orientation=angle + away * turned), values)
    compliance = compliance_of(values) * (1.0 + values.get(GIVE, 0.0))
    elastic = values.get(ELASTIC_SHARE, contact.elastic_share)
    vector = values.get(VECTOR_SHARE, contact.vector_share)
    stiffness = contact.stiffness / compliance
    return replace(contact, asperity=asperity, stiffness=stiffness, elastic_share=elastic, vector_share=vector)


def _with_anisotropy(asperity: Asperity, values: Values) -> Asperity:
    """The asperity with another ratio of its axes; their product stays."""
    if ANISOTROPY not in values:
        return asperity
    mean = math.sqrt(asperity.minor_axis * asperity.major_axis)
    flatness = (asperity.major_axis / mean) ** values[ANISOTROPY]
    return replace(asperity, minor_axis=mean / flatness, major_axis=mean * flatness)


def share_across(contact: Contact) -> float:
    """Share (0 to 1) by which asperities lie across the hole's axis.

    The squared sine of their angle: friction of asperities along the axis depends on the angle's square.
    """
    return float(np.sin(contact.asperity.orientation) ** 2)


def _effects_with(rig: Rig, values: Values) -> Effects:
    blocks: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        effect, dot, parameter = name.partition(".")
        if dot and hasattr(rig.effects, effect):
            blocks.setdefault(effect, {})[parameter] = value
    changed = {name: replace(getattr(rig.effects, name), **block) for name, block in blocks.items()}
    return replace(rig.effects, **changed)


_PROBES = 10  # stretches of the hole whose friction is probed


def depth_probes(length: float) -> tuple[tuple[Parameter, float, float], ...]:
    """Friction multipliers (parameter, from, to) of equal stretches of a hole; length: m."""
    edges = np.linspace(0.0, length, _PROBES + 1)
    return tuple(
        (Parameter(f"probe_{index}", 1.0, 0.1, 5.0, 0.2), float(edges[index]), float(edges[index + 1]))
        for index in range(_PROBES)
    )


def with_probes(intervals: tuple[FrictionInterval, ...], length: float, values: Values) -> tuple[FrictionInterval, ...]:
    """Friction intervals, cut at the edges of the probes among the values and multiplied by them."""
    probes = [(low, high, values[p.name]) for p, low, high in depth_probes(length) if p.name in values]
    if not probes:
        return intervals
    edges = sorted(
        {interval.to for interval in intervals} | {e for low, high, _ in probes for e in (low, high) if e > 0}
    )
    cut = []
    for edge in edges:
        factor = next(interval.factor for interval in intervals if interval.to >= edge - 1e-9)
        for low, high, multiple in probes:
            if low < edge <= high + 1e-9:
                factor *= multiple
        cut.append(FrictionInterval(edge, factor))
    return tuple(cut)


def initial_state_with(values: Values, before: InitialState) -> InitialState:
    """The initial state with fitted values; before: without them."""
    start = replace(before, twist=values.get("start_twist", 0.0))
    if not before.loaded:
        return start
    weight = max(before.weight_on_bit + values.get("start_weight", 0.0), 0.0)
    drag = min(max(before.axial_friction_share + values.get("start_drag", 0.0), -1.0), 1.0)
    hold = values.get("start_hold", 0.0)
    return replace(start, weight_on_bit=weight, axial_friction_share=drag, tangential_friction_share=hold)
