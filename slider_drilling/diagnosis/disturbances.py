"""Flexible rivals of the catalogue: at each site of the rig, something off that no law describes.

Only their linear part is ever used (`slider_drilling.gap.evidence.rivals`): each coefficient is moved a little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, Disturbance, Parameter, Values

_KNOTS = 8
_ANGLE, _BLOCK, _SHARE = "moved.angle_", "moved.block_", "moved.angle_share"
_SPEEDS = (0.01, 0.03, 0.1, 0.3)  # m/s
_RESTS = (1.0, 5.0, 20.0, 60.0)  # s


def disturbances(
    values: Values, probes: Sequence[tuple[Parameter, float, float]], duration: float
) -> list[Disturbance]:
    """Friction over depth, over slip speed and over rest; the drive's angle; the block; the rock over time."""
    times = tuple(float(t) for t in np.linspace(0.0, duration, _KNOTS))
    found = [
        Disturbance(
            "contact", "friction over depth", tuple(0.5 * (low + high) for _, low, high in probes), "m",
            tuple({**values, p.name: p.nominal + 0.1} for p, _, _ in probes), (0.1,) * len(probes),
        ),
        Disturbance(
            "top_drive", "drive angle off over time", times, "s",
            tuple({**values, f"{_ANGLE}{k}": 0.05} for k in range(_KNOTS)), (0.05,) * _KNOTS,
        ),
        Disturbance("top_drive", "drive turns another share of its angle", (0.0,), "-", ({**values, _SHARE: 0.005},),
                    (0.005,)),
        Disturbance(
            "draw_works", "block off over time", times, "s",
            tuple({**values, f"{_BLOCK}{k}": 0.005} for k in range(_KNOTS)), (0.005,) * _KNOTS,
        ),
    ]  # fmt: skip
    if "stribeck.drop" not in values:
        sets = tuple({**values, "stribeck.drop": 0.03, "stribeck.speed": speed} for speed in _SPEEDS)
        found.append(Disturbance("contact", "friction over slip speed", _SPEEDS, "m/s", sets, (0.03,) * len(_SPEEDS)))
    if "static_aging.growth" not in values:
        sets = tuple({**values, "static_aging.growth": 0.03, "static_aging.time": rest} for rest in _RESTS)
        found.append(Disturbance("contact", "friction over rest", _RESTS, "s", sets, (0.03,) * len(_RESTS)))
    if "formation_change.factor" not in values:
        steps = tuple(float(t) for t in np.linspace(0.1, 0.9, 6) * duration)
        sets = tuple({**values, "formation_change.factor": 1.05, "formation_change.time": at} for at in steps)
        found.append(Disturbance("bit", "rock over time", steps, "s", sets, (0.05,) * len(steps)))
    return found


def moves_commands(values: Values) -> bool:
    """Whether values hold a coefficient that changes what the rig did."""
    return any(name.startswith("moved.") for name in values)


def disturbed(commands: Commands, values: Values) -> Commands:
    """What the rig did if these coefficients were so: added angle rad and block m, each a broken line over time."""
    angle, block = _line(commands.time, values, _ANGLE), _line(commands.time, values, _BLOCK)
    share = values.get(_SHARE, 0.0)
    turned = commands.top_drive_angle - commands.top_drive_angle[0]
    return replace(
        commands,
        top_drive_angle=commands.top_drive_angle + angle + share * turned,
        top_drive_speed=commands.top_drive_speed * (1.0 + share) + np.gradient(angle, commands.time),
        block_position=commands.block_position + block,
        block_speed=commands.block_speed + np.gradient(block, commands.time),
    )


def _line(time: Array, values: Values, prefix: str) -> Array:
    knots = np.linspace(time[0], time[-1], _KNOTS)
    heights = np.array([values.get(f"{prefix}{k}", 0.0) for k in range(_KNOTS)])
    return np.interp(time, knots, heights)
