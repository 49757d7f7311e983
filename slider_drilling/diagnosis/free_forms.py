"""Free-form disturbances: at each site of the rig, a deviation that no law describes.

The engine compares them with the catalogue. Of most only the linear part is used
(`slider_drilling.gap.evidence.free_forms`): each coefficient is moved by a small step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.nuisance import (
    ANISOTROPY,
    COMPLIANCE,
    COMPLIANCE_DECADES,
    ELASTIC_SHARE,
    VECTOR_SHARE,
    compliance_of,
)
from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, FreeForm, Parameter, Values
from slider_drilling.rig import Asperity, Contact

_KNOTS = 8
_QUARTERS = 4  # of a turn: knots of friction over the pipe's angle
_PREFIX = "moved."  # of all coefficients
_ANGLE, _BLOCK, _SHARE = f"{_PREFIX}angle_", f"{_PREFIX}block_", f"{_PREFIX}angle_share"
_FRICTION, _AROUND = f"{_PREFIX}friction_", f"{_PREFIX}friction_at_"
_TURNING = f"{_PREFIX}turning_difference"
_PUMP, _BITE = f"{_PREFIX}pump_", f"{_PREFIX}bite_"
_ACROSS, _GIVE = f"{_PREFIX}across", f"{_PREFIX}give"
_SPEEDS = (0.01, 0.03, 0.1, 0.3)  # m/s
_RESTS = (1.0, 5.0, 20.0, 60.0)  # s
_NOTHING_LEFT = -1.0  # lower bound of a share: friction or flow cannot be negative


def catalogue_free_forms(
    values: Values, probes: Sequence[tuple[Parameter, float, float]], duration: float, contact: Contact
) -> list[FreeForm]:
    """All free forms around a fit.

    Args:
        values: Parameters of the fit. If they hold a law's amplitude, its own free form is left out.
        probes: Friction multipliers along the hole.
        duration: s, of the longest run.
        contact: The rig file's.
    """
    forms = [*_friction(values, probes, duration), *_asperities(values, contact), *_motion(values, duration)]
    if "formation_change.factor" not in values:
        steps = tuple(float(t) for t in np.linspace(0.1, 0.9, 6) * duration)
        sets = [{"formation_change.factor": 1.05, "formation_change.time": at} for at in steps]
        rock = _form("bit", "rock over time", ("formation_change",), steps, "s", values, sets, 0.05)
        forms.append(_with_basis(rock, lambda at, step: float(at >= step)))
    return forms


def _friction(values: Values, probes: Sequence[tuple[Parameter, float, float]], duration: float) -> list[FreeForm]:
    """Friction over depth, time, the pipe's angle, direction of turning, slip speed and rest time."""
    depths = [0.5 * (low + high) for _, low, high in probes]
    depth_laws = ("cuttings_bed", "tortuosity", "buckling_contact")
    sets = [{p.name: p.nominal + 0.1} for p, _, _ in probes]
    over = _form("contact", "friction over depth", depth_laws, depths, "m", values, sets, 0.1)
    forms = [replace(over, lower_bound=_NOTHING_LEFT)]
    times, quarters = np.linspace(0.0, duration, _KNOTS), 2.0 * np.pi * np.arange(_QUARTERS) / _QUARTERS
    curves: list[tuple[str, tuple[str, ...], Array, str, str, float | None]] = [
        ("friction over time", ("friction_drift",), times, "s", _FRICTION, None),
        ("friction over the pipe's angle", (), quarters, "rad", _AROUND, 2.0 * np.pi),
    ]
    for description, laws, x, unit, prefix, period in curves:
        # Friction may be wrong by half, and fast strokes then reach another depth: a linear step does not show that.
        shares = tuple(Parameter(f"{prefix}{k}", 0.0, -0.9, 3.0, 0.05, spread=0.5) for k in range(x.size))
        sets = [{share.name: 0.02} for share in shares]
        forms.append(_form("contact", description, laws, list(x), unit, values, sets, 0.02, shares, period))
    right = (Parameter(_TURNING, 0.0, -0.8, 0.8, 0.05, spread=0.5),)
    sets = [{_TURNING: 0.02}]
    way_round = "friction higher turning right and lower turning left"
    forms.append(_form("contact", way_round, (), [0.0], "-", values, sets, 0.02, right))
    if "stribeck.drop" not in values:
        sets = [{"stribeck.drop": 0.03, "stribeck.speed": speed} for speed in _SPEEDS]
        speed_laws = ("stribeck", "viscous_drag")
        over = _form("contact", "friction over slip speed", speed_laws, _SPEEDS, "m/s", values, sets, 0.03)
        forms.append(_with_basis(over, lambda speed, scale: math.exp(-speed / scale)))
    if "static_aging.growth" not in values:
        sets = [{"static_aging.growth": 0.03, "static_aging.time": rest} for rest in _RESTS]
        over = _form("contact", "friction over rest", ("static_aging",), _RESTS, "s", values, sets, 0.03)
        forms.append(_with_basis(over, lambda rest, scale: 1.0 - math.exp(-rest / scale)))
    return forms


def _asperities(values: Values, contact: Contact) -> list[FreeForm]:
    """Properties of the contact that are not calibrated: direction of its asperities, compliance before it slides."""
    across = _share_across(contact)
    direction = (Parameter(_ACROSS, 0.0, -across, 1.0 - across, 0.05),)
    compliance = (Parameter(_GIVE, 0.0, -0.95, 20.0, 0.2),)
    return [
        _form("contact", description, (), [0.0], "-", values, [{parameters[0].name: step}], step, parameters)
        for description, parameters, step in (
            ("asperities turned across the pipe", direction, 0.05 if across < 0.5 else -0.05),
            ("contact compliance before it slides", compliance, 0.1),
        )
    ]


def contact_with(contact: Contact, values: Values) -> Contact:
    """The contact with its asperities turned or rounder, and with another compliance before it slides."""
    if not {_ACROSS, _GIVE, COMPLIANCE, COMPLIANCE_DECADES, ANISOTROPY, ELASTIC_SHARE, VECTOR_SHARE} & set(values):
        return contact
    angle, before = contact.asperity.orientation, _share_across(contact)
    after = float(np.clip(before + values.get(_ACROSS, 0.0), 0.0, 1.0))
    turned = float(np.arcsin(np.sqrt(after)) - np.arcsin(np.sqrt(before)))
    away = -1.0 if np.sin(2.0 * angle) < 0.0 else 1.0
    asperity = _with_anisotropy(replace(contact.asperity, orientation=angle + away * turned), values)
    compliance = compliance_of(values) * (1.0 + values.get(_GIVE, 0.0))
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


def _share_across(contact: Contact) -> float:
    """Share (0 to 1) by which asperities lie across the hole's axis.

    The squared sine of their angle: friction of asperities along the axis depends on the angle's square.
    """
    return float(np.sin(contact.asperity.orientation) ** 2)


def _motion(values: Values, duration: float) -> list[FreeForm]:
    """Errors over time of the drive's angle, the block, the flow and the bit's torque; and of the drive's scale."""
    times = [float(t) for t in np.linspace(0.0, duration, _KNOTS)]
    forms = []
    # None of them is a law's free form: so few knots can show neither a wave of the sea nor a dead zone.
    for site, description, prefix, step, unit, lower_bound in (
        ("top_drive", "drive angle off over time", _ANGLE, 0.05, "rad", -math.inf),
        ("draw_works", "block off over time", _BLOCK, 0.005, "m", -math.inf),
        ("hydraulics", "flow off over time", _PUMP, 0.002, "-", _NOTHING_LEFT),
        ("bit", "bit torque per weight over time", _BITE, 0.02, "-", _NOTHING_LEFT),
    ):  # fmt: skip
        sets = [{f"{prefix}{k}": step} for k in range(_KNOTS)]
        form = _form(site, description, (), times, "s", values, sets, step)
        forms.append(replace(form, y_unit=unit, lower_bound=lower_bound))
    scale = (Parameter(_SHARE, 0.0, -0.7, 0.5, 0.01),)
    scaled = _form("top_drive", "drive angle scaled", (), [0.0], "-", values, [{_SHARE: 0.005}], 0.005, scale)
    return [*forms, scaled]


def _with_basis(form: FreeForm, basis: Callable[[float, float], float]) -> FreeForm:
    """A share that is a sum of a law's curves, one with its parameter at each x; basis: value at x of one of them."""
    curves = tuple(tuple(basis(x, parameter) for parameter in form.x) for x in form.x)
    return replace(form, basis=curves, lower_bound=_NOTHING_LEFT)


def _form(
    site: str, description: str, laws: tuple[str, ...], x: Sequence[float], x_unit: str, values: Values,
    steps: Sequence[Values], step: float, parameters: tuple[Parameter, ...] = (), period: float | None = None,
) -> FreeForm:  # fmt: skip
    """A free form by one step of each coefficient around the values."""
    sets = tuple({**values, **one_step} for one_step in steps)
    return FreeForm(
        site, description, laws, tuple(map(float, x)), x_unit, sets, (step,) * len(sets), parameters, period
    )


def disturbance_key(values: Values) -> tuple[tuple[str, float], ...]:
    """Values in which the sets of a batch may not differ: they change commands, factors, or the friction curve."""
    return tuple(
        sorted((name, value) for name, value in values.items() if name.startswith(_PREFIX) or name == ANISOTROPY)
    )


def friction_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) factor of all friction at the commands' times, None without such a coefficient.

    It is piecewise linear over time, and over the drive's angle, which stands for the pipe's.
    """
    if not any(name.startswith(_FRICTION) for name in values):
        return None
    knots = np.arange(_QUARTERS + 1) / _QUARTERS
    by_angle = [values.get(f"{_AROUND}{k % _QUARTERS}", 0.0) for k in range(_QUARTERS + 1)]
    angle_part = np.interp(commands.top_drive_angle / (2.0 * np.pi) % 1.0, knots, by_angle)
    return np.asarray(1.0 + _line(commands.time, values, _FRICTION) + angle_part)


def turning_difference(values: Values) -> float:
    """Share by which friction is larger while an element turns right (`slider_drilling.drillstring.Modifiers`)."""
    return values.get(_TURNING, 0.0)


def bit_torque_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) factor of the bit's torque per weight at the commands' times, None without such a coefficient."""
    if not any(name.startswith(_BITE) for name in values):
        return None
    return 1.0 + _line(commands.time, values, _BITE)


def disturbed_commands(commands: Commands, values: Values) -> Commands:
    """The commands with an added angle (rad), block position (m) and share of the pump's speed over time."""
    if not disturbance_key(values):
        return commands
    angle, block = _line(commands.time, values, _ANGLE), _line(commands.time, values, _BLOCK)
    share = values.get(_SHARE, 0.0)
    turned = commands.top_drive_angle - commands.top_drive_angle[0]
    return replace(
        commands,
        top_drive_angle=commands.top_drive_angle + angle + share * turned,
        top_drive_speed=commands.top_drive_speed * (1.0 + share) + np.gradient(angle, commands.time),
        block_position=commands.block_position + block,
        block_speed=commands.block_speed + np.gradient(block, commands.time),
        pump_speed=commands.pump_speed * (1.0 + _line(commands.time, values, _PUMP)),
    )


def _line(time: Array, values: Values, prefix: str) -> Array:
    knots = np.linspace(time[0], time[-1], _KNOTS)
    heights = np.array([values.get(f"{prefix}{k}", 0.0) for k in range(_KNOTS)])
    return np.interp(time, knots, heights)
