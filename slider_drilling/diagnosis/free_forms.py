"""Flexible rivals of the catalogue: at each site of the rig, something off that no law describes.

Of most only the linear part is used (`slider_drilling.gap.evidence.free_forms`): each coefficient is moved a little.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, FreeForm, Parameter, Values
from slider_drilling.rig import Contact

_KNOTS = 8
_QUARTERS = 4  # of a turn, at which friction over the angle has its coefficients
_MOVED = "moved."
_ANGLE, _BLOCK, _SHARE = f"{_MOVED}angle_", f"{_MOVED}block_", f"{_MOVED}angle_share"
_FRICTION, _AROUND = f"{_MOVED}friction_", f"{_MOVED}friction_at_"
_PUMP, _BITE = f"{_MOVED}pump_", f"{_MOVED}bite_"
_ACROSS, _GIVE = f"{_MOVED}across", f"{_MOVED}give"
_SPEEDS = (0.01, 0.03, 0.1, 0.3)  # m/s
_RESTS = (1.0, 5.0, 20.0, 60.0)  # s
_NOTHING = -1.0  # of a share that is off: nothing is left of it


def disturbances(
    values: Values, probes: Sequence[tuple[Parameter, float, float]], duration: float, contact: Contact
) -> list[FreeForm]:
    """Everything that may be off at some site of the rig, around the values; contact: the rig file's.

    What moves a law's own parameters is left out where that law is in force: where its amplitude is among the values.
    """
    found = [*_friction(values, probes, duration), *_asperities(values, contact), *_motion(values, duration)]
    if "formation_change.factor" not in values:
        steps = tuple(float(t) for t in np.linspace(0.1, 0.9, 6) * duration)
        sets = [{"formation_change.factor": 1.05, "formation_change.time": at} for at in steps]
        rock = _moved("bit", "rock over time", ("formation_change",), steps, "s", values, sets, 0.05)
        found.append(_spanned(rock, lambda at, begun: float(at >= begun)))
    return found


def _friction(values: Values, probes: Sequence[tuple[Parameter, float, float]], duration: float) -> list[FreeForm]:
    """Over depth, time, the pipe's angle, slip speed, and rest."""
    depths = [0.5 * (low + high) for _, low, high in probes]
    by_depth = ("cuttings_bed", "tortuosity", "buckling_contact")
    sets = [{p.name: p.nominal + 0.1} for p, _, _ in probes]
    over = _moved("contact", "friction over depth", by_depth, depths, "m", values, sets, 0.1)
    found = [replace(over, lower_bound=_NOTHING)]
    times, quarters = np.linspace(0.0, duration, _KNOTS), 2.0 * np.pi * np.arange(_QUARTERS) / _QUARTERS
    free: list[tuple[str, tuple[str, ...], Array, str, str, float | None]] = [
        ("friction over time", ("friction_drift",), times, "s", _FRICTION, None),
        ("friction over the pipe's angle", (), quarters, "rad", _AROUND, 2.0 * np.pi),
    ]
    for words, like, x, unit, prefix, period in free:
        # Friction may be off by half, and fast strokes then reach elsewhere: a small step does not show that.
        shares = tuple(Parameter(f"{prefix}{k}", 0.0, -0.9, 3.0, 0.05, spread=0.5) for k in range(x.size))
        sets = [{share.name: 0.02} for share in shares]
        found.append(_moved("contact", words, like, list(x), unit, values, sets, 0.02, shares, period))
    if "stribeck.drop" not in values:
        sets = [{"stribeck.drop": 0.03, "stribeck.speed": speed} for speed in _SPEEDS]
        of_speed = ("stribeck", "viscous_drag")
        over = _moved("contact", "friction over slip speed", of_speed, _SPEEDS, "m/s", values, sets, 0.03)
        found.append(_spanned(over, lambda speed, own: math.exp(-speed / own)))
    if "static_aging.growth" not in values:
        sets = [{"static_aging.growth": 0.03, "static_aging.time": rest} for rest in _RESTS]
        over = _moved("contact", "friction over rest", ("static_aging",), _RESTS, "s", values, sets, 0.03)
        found.append(_spanned(over, lambda rest, own: 1.0 - math.exp(-rest / own)))
    return found


def _asperities(values: Values, contact: Contact) -> list[FreeForm]:
    """What the file says of the contact and nothing that is tuned: how its asperities lie, and how far it gives way
    before it slides.
    """
    across = _lying_across(contact)
    lies = (Parameter(_ACROSS, 0.0, -across, 1.0 - across, 0.05),)
    gives = (Parameter(_GIVE, 0.0, -0.8, 20.0, 0.2),)
    return [
        _moved("contact", words, (), [0.0], "-", values, [{one[0].name: step}], step, one)
        for words, one, step in (
            ("friction by direction: asperities lying across the pipe", lies, 0.05 if across < 0.5 else -0.05),
            ("contact that gives way another distance before it slides", gives, 0.1),
        )
    ]


def contact_with(contact: Contact, values: Values) -> Contact:
    """The contact whose asperities lie otherwise, and that gives way farther by a share before it slides."""
    if _ACROSS not in values and _GIVE not in values:
        return contact
    angle, before = contact.asperity.orientation, _lying_across(contact)
    after = float(np.clip(before + values.get(_ACROSS, 0.0), 0.0, 1.0))
    turned = float(np.arcsin(np.sqrt(after)) - np.arcsin(np.sqrt(before)))
    away = -1.0 if np.sin(2.0 * angle) < 0.0 else 1.0
    lying = replace(contact.asperity, orientation=angle + away * turned)
    return replace(contact, asperity=lying, stiffness=contact.stiffness / (1.0 + values.get(_GIVE, 0.0)))


def _lying_across(contact: Contact) -> float:
    """By how much of 1 asperities lie across the hole's axis: where they lie along it, their angle's square tells."""
    return float(np.sin(contact.asperity.orientation) ** 2)


def _motion(values: Values, duration: float) -> list[FreeForm]:
    """The drive's angle, the block, what the pump and the bit give for what they get, over time; and a drive that turns
    more or less than it says.
    """
    times = [float(t) for t in np.linspace(0.0, duration, _KNOTS)]
    found = []
    # None is a law's free form: so few knots hold no wave of the sea, and no dead zone.
    for site, words, prefix, step, unit, least in (
        ("top_drive", "drive angle off over time", _ANGLE, 0.05, "rad", -math.inf),
        ("draw_works", "block off over time", _BLOCK, 0.005, "m", -math.inf),
        ("hydraulics", "flow off over time", _PUMP, 0.002, "-", _NOTHING),
        ("bit", "bit torque per weight over time", _BITE, 0.02, "-", _NOTHING),
    ):  # fmt: skip
        sets = [{f"{prefix}{k}": step} for k in range(_KNOTS)]
        found.append(replace(_moved(site, words, (), times, "s", values, sets, step), y_unit=unit, lower_bound=least))
    share = (Parameter(_SHARE, 0.0, -0.7, 0.5, 0.01),)
    words = "drive turns another share of its angle"
    return [*found, _moved("top_drive", words, (), [0.0], "-", values, [{_SHARE: 0.005}], 0.005, share)]


def _spanned(moved: FreeForm, off: Callable[[float, float], float]) -> FreeForm:
    """A share whose coefficients are a law's, one at each x: what is off is off(x, the coefficient's own x) of each."""
    curve = tuple(tuple(off(at, own) for own in moved.x) for at in moved.x)
    return replace(moved, basis=curve, lower_bound=_NOTHING)


def _moved(
    site: str, words: str, like: tuple[str, ...], x: Sequence[float], x_unit: str, values: Values,
    sets: Sequence[Values], step: float, parameters: tuple[Parameter, ...] = (), period: float | None = None,
) -> FreeForm:  # fmt: skip
    """A disturbance by what one step of each coefficient changes of the values."""
    moved = tuple({**values, **one} for one in sets)
    return FreeForm(site, words, like, tuple(map(float, x)), x_unit, moved, (step,) * len(moved), parameters, period)


def commands_part(values: Values) -> tuple[tuple[str, float], ...]:
    """What of the values changes what the rig did, or all friction as it did it."""
    return tuple(sorted((name, value) for name, value in values.items() if name.startswith(_MOVED)))


def friction_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) what all friction is multiplied by over the commands' times, None where nothing changes it.

    Over the pipe's angle: that of the drive, a broken line around the turn.
    """
    if not any(name.startswith(_FRICTION) for name in values):
        return None
    knots = np.arange(_QUARTERS + 1) / _QUARTERS
    around = [values.get(f"{_AROUND}{k % _QUARTERS}", 0.0) for k in range(_QUARTERS + 1)]
    turned = np.interp(commands.top_drive_angle / (2.0 * np.pi) % 1.0, knots, around)
    return np.asarray(1.0 + _line(commands.time, values, _FRICTION) + turned)


def bite_factor(commands: Commands, values: Values) -> Array | None:
    """(n,) what the bit's torque per weight is multiplied by at the commands' times, None where nothing changes it."""
    if not any(name.startswith(_BITE) for name in values):
        return None
    return 1.0 + _line(commands.time, values, _BITE)


def disturbed(commands: Commands, values: Values) -> Commands:
    """What the rig did if these coefficients were so: added angle rad and block m, and a share of the pump's speed,
    each a broken line over time.
    """
    if not commands_part(values):
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
