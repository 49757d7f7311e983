"""Free-form disturbances: at each site of the rig, a deviation that no law describes.

The engine compares them with the catalogue. Of most only the linear part is used
(`slider_drilling.gap.evidence.free_forms`): each coefficient is moved by a small step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.disturbances import (
    ACROSS,
    ANGLE,
    AROUND,
    BITE,
    BLOCK,
    FRICTION,
    GIVE,
    KNOTS,
    PUMP,
    QUARTERS,
    SHARE,
    TURNING,
)
from slider_drilling.diagnosis.rig_values import share_across
from slider_drilling.gap.model import Array, FreeForm, Parameter, Values
from slider_drilling.rig import Contact

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
    times, quarters = np.linspace(0.0, duration, KNOTS), 2.0 * np.pi * np.arange(QUARTERS) / QUARTERS
    curves: list[tuple[str, tuple[str, ...], Array, str, str, float | None]] = [
        ("friction over time", ("friction_drift",), times, "s", FRICTION, None),
        ("friction over the pipe's angle", (), quarters, "rad", AROUND, 2.0 * np.pi),
    ]
    for description, laws, x, unit, prefix, period in curves:
        # Friction may be wrong by half, and fast strokes then reach another depth: a linear step does not show that.
        shares = tuple(Parameter(f"{prefix}{k}", 0.0, -0.9, 3.0, 0.05, spread=0.5) for k in range(x.size))
        sets = [{share.name: 0.02} for share in shares]
        forms.append(_form("contact", description, laws, list(x), unit, values, sets, 0.02, shares, period))
    right = (Parameter(TURNING, 0.0, -0.8, 0.8, 0.05, spread=0.5),)
    sets = [{TURNING: 0.02}]
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
    across = share_across(contact)
    direction = (Parameter(ACROSS, 0.0, -across, 1.0 - across, 0.05),)
    compliance = (Parameter(GIVE, 0.0, -0.95, 20.0, 0.2),)
    return [
        _form("contact", description, (), [0.0], "-", values, [{parameters[0].name: step}], step, parameters)
        for description, parameters, step in (
            ("asperities turned across the pipe", direction, 0.05 if across < 0.5 else -0.05),
            ("contact compliance before it slides", compliance, 0.1),
        )
    ]


def _motion(values: Values, duration: float) -> list[FreeForm]:
    """Errors over time of the drive's angle, the block, the flow and the bit's torque; and of the drive's scale."""
    times = [float(t) for t in np.linspace(0.0, duration, KNOTS)]
    forms = []
    # None of them is a law's free form: so few knots can show neither a wave of the sea nor a dead zone.
    for site, description, prefix, step, unit, lower_bound in (
        ("top_drive", "drive angle off over time", ANGLE, 0.05, "rad", -math.inf),
        ("draw_works", "block off over time", BLOCK, 0.005, "m", -math.inf),
        ("hydraulics", "flow off over time", PUMP, 0.002, "-", _NOTHING_LEFT),
        ("bit", "bit torque per weight over time", BITE, 0.02, "-", _NOTHING_LEFT),
    ):  # fmt: skip
        sets = [{f"{prefix}{k}": step} for k in range(KNOTS)]
        form = _form(site, description, (), times, "s", values, sets, step)
        forms.append(replace(form, y_unit=unit, lower_bound=lower_bound))
    scale = (Parameter(SHARE, 0.0, -0.7, 0.5, 0.01),)
    scaled = _form("top_drive", "drive angle scaled", (), [0.0], "-", values, [{SHARE: 0.005}], 0.005, scale)
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
