"""A test programme as numbers that a search can change: its parts, their order and lengths, flow and block speed.

The parts are strokes of two kinds, rotation, a drill-off, and a pick-up with strokes off bottom. Every point within the
bounds is a programme that a crew can do.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from slider_drilling.gap.model import Parameter, Values
from slider_drilling.programmes import (
    BlockSpeed,
    DrillOff,
    Flow,
    PickUp,
    Programme,
    Rest,
    Rock,
    Rotate,
    SlackOff,
    Step,
)
from slider_drilling.programmes.open_loop import plan_programme
from slider_drilling.programmes.steps import Action
from slider_drilling.rig import Rig

TURN = 2.0 * pi
PARTS = ("rock_wide", "rock_narrow", "rotate", "drill_off", "pick_up")
DRIVE_ACCELERATION = 4.0  # rad/s2
# s before the first motion; a part that would last less than the second number is left out.
_LEAD, _SHORTEST = 4.0, 10.0
_FLOW_RAMP, _BLOCK_RAMP = 3.0, 2.0  # s
_MIN_WRAPS, _MIN_FLOW_CHANGE = 0.1 * TURN, 0.02


def programme_variables(rig: Rig) -> tuple[Parameter, ...]:
    """The numbers, within what a crew may do on this rig."""
    fast = 0.6 * rig.top_drive.max_speed

    def number(name: str, nominal: float, lower: float, upper: float, unit: str = "-") -> Parameter:
        return Parameter(name, min(max(nominal, lower), upper), lower, upper, 0.1 * (upper - lower), unit)

    def share(part: str, nominal: float = 0.0) -> Parameter:
        return number(f"{part}.share", nominal, 0.0, 1.0)

    def strokes(part: str, wraps: float, most: float, speed: float, rest: float) -> tuple[Parameter, ...]:
        return (
            number(f"{part}.wraps", wraps * TURN, 0.2 * TURN, most * TURN, "rad"),
            number(f"{part}.speed", speed, 0.3, fast, "rad/s"),
            number(f"{part}.rest", rest, 0.0, 20.0, "s"),
        )

    return (
        *strokes("rock_wide", 2.5, 6.0, 3.0, 0.0), share("rock_wide", 1.0),
        *strokes("rock_narrow", 1.0, 3.0, 1.0, 6.0), share("rock_narrow"),
        number("rotate.speed", 4.0, 0.5, fast, "rad/s"), share("rotate"), share("drill_off"),
        number("pick_up.distance", 4.0, 0.5, 10.0, "m"), number("pick_up.speed", 0.15, 0.05, 0.4, "m/s"),
        number("pick_up.wraps", 0.0, 0.0, 4.0 * TURN, "rad"), share("pick_up"),
        number("block.speed", 0.0028, 0.0015, 0.005, "m/s"), number("block.second", 1.0, 0.3, 1.7),
        number("block.change", 0.5, 0.15, 0.9), number("flow.level", 1.0, 0.8, 1.0),
        number("flow.start", 0.6, 0.1, 0.8), number("flow.length", 0.15, 0.08, 0.4),
        *(number(f"{part}.order", (index + 0.5) / len(PARTS), 0.0, 1.0) for index, part in enumerate(PARTS)),
    )  # fmt: skip


ROUTINE: Values = {}
"""Routine rocking: one amplitude and speed, constant block speed and flow."""
BY_HAND: Values = {
    "rock_wide.share": 0.9, "rock_wide.wraps": 4.0 * TURN, "rock_wide.speed": 4.0, "rock_wide.rest": 3.0,
    "rock_narrow.share": 0.7, "rock_narrow.speed": 0.8, "rock_narrow.rest": 8.0, "rotate.share": 0.4,
    "drill_off.share": 0.3, "pick_up.share": 0.6, "block.second": 0.6, "flow.level": 0.85,
}  # fmt: skip
"""A test with a little of everything, from which the search starts."""
GENTLE: Values = {"rock_wide.wraps": 0.25 * TURN, "rock_wide.speed": 1.0, "block.speed": 0.0015}
"""Little of one thing, for rigs with tight limits."""


def programme_of(design: Values, rig: Rig, duration: float) -> Programme:
    """The programme with these numbers.

    Args:
        design: The numbers, complete.
        rig: The rig.
        duration: Longest time that it may take, s.
    """
    design, available = _rounded(design), duration - _LEAD - _FLOW_RAMP
    while True:
        steps = _steps(design, rig, float(int(available)))
        programme = Programme(tuple(steps), "Test programme", drive_acceleration=DRIVE_ACCELERATION)
        *_, last = plan_programme(programme, rig)
        over = last.begin + last.motion.duration - duration
        if over <= 1e-6:
            return programme
        available -= over + 0.1


def _rounded(design: Values) -> dict[str, float]:
    """The numbers as a driller would set them."""
    return {name: max(round(value / unit), 1) * unit if (unit := _step_of(name)) else value
            for name, value in design.items()}  # fmt: skip


def _step_of(name: str) -> float:
    """Step in which a number is set; 0 for one that nobody sets."""
    key = name.rpartition(".")[2]
    if name == "block.speed":
        return 0.2 / 3600.0
    if name == "pick_up.speed":
        return 0.01
    return {"wraps": 0.25 * TURN, "speed": TURN / 60.0, "rest": 1.0, "distance": 0.5, "level": 0.01}.get(key, 0.0)


@dataclass(frozen=True)
class _Part:
    kind: str
    begin: float
    duration: float


def _parts(design: Values, available: float) -> list[_Part]:
    """The parts in their order, over so many seconds; those with too small a share are left out."""
    chosen = sorted(PARTS, key=lambda part: design[f"{part}.order"])
    while True:
        total = sum(design[f"{part}.share"] for part in chosen)
        if total <= 0.0:
            return [_Part("rock_wide", 0.0, available)]
        lengths = {part: float(int(available * design[f"{part}.share"] / total)) for part in chosen}
        shortest = min(chosen, key=lambda part: lengths[part])
        if lengths[shortest] >= _SHORTEST or len(chosen) == 1:
            break
        chosen.remove(shortest)
    parts, at = [], 0.0
    for kind in chosen:
        parts.append(_Part(kind, at, lengths[kind]))
        at += lengths[kind]
    return parts


def _steps(design: Values, rig: Rig, available: float) -> list[Step]:
    """All steps: parts, cut where flow or block speed change."""
    first, step = design["block.speed"], _step_of("block.speed")
    second = round(first * design["block.second"] / step) * step
    flow = rig.hydraulics.reference_flow
    low_from = float(int(design["flow.start"] * available))
    events: list[tuple[float, Action]] = []
    if second != first:
        events.append((float(int(design["block.change"] * available)), BlockSpeed(second, _BLOCK_RAMP)))
    if 1.0 - design["flow.level"] >= _MIN_FLOW_CHANGE:
        events += [
            (low_from, Flow(flow * design["flow.level"], _FLOW_RAMP)),
            (low_from + float(int(design["flow.length"] * available)), Flow(flow, _FLOW_RAMP)),
        ]
    events.sort(key=lambda event: event[0])
    actions: list[Action] = [BlockSpeed(first, _BLOCK_RAMP), Rest(_LEAD)]
    feed = first
    for part in _parts(design, available):
        at, end = part.begin, part.begin + part.duration
        while events and events[0][0] <= end - _SHORTEST and part.kind != "pick_up":
            when, event = events.pop(0)
            if when - at >= _SHORTEST:
                actions += _piece(part.kind, design, when - at, feed)
                at = when
            actions.append(event)
            feed = event.speed if isinstance(event, BlockSpeed) else feed
        actions += _piece(part.kind, design, end - at, feed)
    return [Step(action) for action in (*actions, *(event for _, event in events if isinstance(event, Flow)))]


def _piece(kind: str, design: Values, duration: float, feed: float) -> list[Action]:
    """A part, or a piece of one, of so many seconds; feed: block speed before and after it, m/s."""
    if kind == "rotate":
        return [Rotate(design["rotate.speed"], duration)]
    if kind == "drill_off":
        return [DrillOff(duration)]
    if kind == "pick_up":
        return _pick_up(design, duration, feed)
    return _rock(design[f"{kind}.wraps"], design[f"{kind}.speed"], design[f"{kind}.rest"], duration)


def _pick_up(design: Values, duration: float, feed: float) -> list[Action]:
    """Up, strokes or a rest off bottom, and down again by as much."""
    speed = design["pick_up.speed"]
    distance = max(min(design["pick_up.distance"], float(int(0.7 * duration * speed)) / 2.0), 0.5)
    between = max(duration - 2.0 * distance / speed - 8.0, 3.0)
    middle = _rock(design["pick_up.wraps"], design["rock_wide.speed"], 0.0, between)
    return [PickUp(distance, speed), *middle, SlackOff(distance, speed), BlockSpeed(feed, _BLOCK_RAMP)]


def _rock(wraps: float, speed: float, rest: float, duration: float) -> list[Action]:
    """Whole cycles within the time, with fewer wraps and shorter rests where one would not fit; else a rest."""
    reversals = 4.0 * speed / DRIVE_ACCELERATION
    rest = min(rest, float(int(0.25 * duration)))
    longest = (0.98 * duration - 2.0 * rest - reversals) * speed / 4.0
    if wraps > longest:
        wraps = int(longest / (0.25 * TURN)) * 0.25 * TURN
    if wraps < _MIN_WRAPS:
        return [Rest(duration)]
    return [Rock(wraps, wraps, speed, rest, time=duration)]
