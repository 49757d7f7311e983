"""The steps of a programme: what the crew does with top drive, block and pump.

Every number declares its unit and range (`schema.fields.quantity`); SI units and radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from slider_drilling.schema.fields import quantity

_LONGEST_S = 86_400.0
_TIME: dict[str, Any] = {"above": 0.0, "at_most": _LONGEST_S}
_DRIVE_SPEED: dict[str, Any] = {"above": 0.0, "at_most": 50.0, "usual": (0.0, 21.0), "mistaken_for": ("rpm",)}
_BLOCK_SPEED: dict[str, Any] = {"at_most": 2.0, "usual": (-0.6, 0.6), "mistaken_for": ("m/h",)}
_DISTANCE: dict[str, Any] = {"above": 0.0, "at_most": 60.0, "why": "a stand has 27 to 40 m"}
_WRAPS: dict[str, Any] = {"at_least": 0.0, "at_most": 400.0, "why": "in rad; 10 turns are 63"}


@dataclass(frozen=True)
class Rotate:
    """Rotate the string clockwise, for a time or until so much new hole is drilled.

    Attributes:
        speed: Of the top drive.
        time: From the start of the rotation on.
        length: New hole, by the block. A bit off bottom is lowered to bottom first.
        block_speed: During this step; by default that of the last block-speed step.
    """

    speed: float = quantity("rad/s", why="120 rpm is 12.6", **_DRIVE_SPEED)
    time: float | None = quantity("s", None, **_TIME)
    length: float | None = quantity("m", None, **_DISTANCE)
    block_speed: float | None = quantity("m/s", None, at_least=0.0, why="9 m/h is 0.0025", **_BLOCK_SPEED)


@dataclass(frozen=True)
class Rock:
    """Rock the top drive about its angle at the start, for whole cycles, and stop there.

    Attributes:
        right: Wraps to the right of that angle.
        left: Wraps to the left of it.
        speed: Of the strokes.
        rest: At each end.
        cycles: Right end, left end and back.
        time: In place of cycles: as many as fit, then rest until it is over.
        block_speed: During this step; by default that of the last block-speed step.
    """

    right: float = quantity("rad", **_WRAPS)
    left: float = quantity("rad", **_WRAPS)
    speed: float = quantity("rad/s", why="120 rpm is 12.6", **_DRIVE_SPEED)
    rest: float = quantity("s", 0.0, at_least=0.0, at_most=3600.0)
    cycles: int | None = quantity("-", None, at_least=1, at_most=10_000)
    time: float | None = quantity("s", None, **_TIME)
    block_speed: float | None = quantity("m/s", None, at_least=0.0, why="9 m/h is 0.0025", **_BLOCK_SPEED)


@dataclass(frozen=True)
class Rest:
    """Hold the top drive still; block and pump go on as they are."""

    time: float = quantity("s", **_TIME)


@dataclass(frozen=True)
class PickUp:
    """Lift the string; the block then stands still."""

    distance: float = quantity("m", **_DISTANCE)
    speed: float = quantity("m/s", 0.1, above=0.0, **_BLOCK_SPEED)


@dataclass(frozen=True)
class SlackOff:
    """Lower the string; the block then stands still."""

    distance: float = quantity("m", **_DISTANCE)
    speed: float = quantity("m/s", 0.05, above=0.0, **_BLOCK_SPEED)


@dataclass(frozen=True)
class Flow:
    """Change the flow; it holds from then on.

    Attributes:
        flow: Of mud; 0 stops the pump.
        ramp: Time of the change.
    """

    flow: float = quantity("m3/s", at_least=0.0, at_most=0.5, usual=(0.0, 0.2), mistaken_for=("L/min", "gal/min"),
                           why="500 gal/min is 0.0315")  # fmt: skip
    ramp: float = quantity("s", 5.0, at_least=0.5, at_most=600.0)


@dataclass(frozen=True)
class BlockSpeed:
    """Change the speed of the block; it holds from then on, until a pick-up, a slack-off, a slide or a connection.

    Attributes:
        speed: At which the block is lowered; 0 stops it.
        ramp: Time of the change.
    """

    speed: float = quantity("m/s", at_least=0.0, why="9 m/h is 0.0025", **_BLOCK_SPEED)
    ramp: float = quantity("s", 2.0, at_least=0.2, at_most=600.0)


@dataclass(frozen=True)
class DrillOff:
    """Lock the brake for a time and let the bit drill its weight off; then the block goes on as before."""

    time: float = quantity("s", **_TIME)


@dataclass(frozen=True)
class Slide:
    """Orient the bit off bottom, drill at a toolface, and lift the bit at the end.

    Attributes:
        tool_face: To hold.
        time: Of drilling, after the toolface was set.
        length: New hole, by the block, in place of a time.
        rate_of_penetration: That the auto-driller asks for.
        orient_time: Longest time to set the toolface; the programme ends where it does not suffice.
    """

    tool_face: float = quantity("rad", at_least=-2.0 * math.pi, at_most=2.0 * math.pi, why="in rad; write 30 deg")
    time: float | None = quantity("s", None, **_TIME)
    length: float | None = quantity("m", None, **_DISTANCE)
    rate_of_penetration: float = quantity("m/s", 0.0025, above=0.0, at_most=0.05, usual=(0.0, 0.05),
                                          mistaken_for=("m/h",), why="9 m/h is 0.0025")  # fmt: skip
    orient_time: float = quantity("s", 900.0, at_least=60.0, at_most=7200.0)


@dataclass(frozen=True)
class MakeConnection:
    """Make a connection: pick up, stop rotation and pump, wait, and pump again.

    Attributes:
        time: Without flow.
        distance: Of the pick-up.
    """

    time: float = quantity("s", 120.0, **_TIME)
    distance: float = quantity("m", 3.0, **_DISTANCE)


Action = Rotate | Rock | Rest | PickUp | SlackOff | Flow | BlockSpeed | DrillOff | Slide | MakeConnection

ACTIONS: dict[str, type[Action]] = {
    "rotate": Rotate, "rock": Rock, "rest": Rest, "pick_up": PickUp, "slack_off": SlackOff, "flow": Flow,
    "block_speed": BlockSpeed, "drill_off": DrillOff, "slide": Slide, "connection": MakeConnection,
}  # fmt: skip
"""Key in the file -> its dataclass."""
_KEYS = {kind: key for key, kind in ACTIONS.items()}


def key_of(action: Action) -> str:
    """Key of a step in the file."""
    return _KEYS[type(action)]
