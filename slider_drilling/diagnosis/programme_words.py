"""A programme in a driller's words, one line for each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

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
)
from slider_drilling.programmes.open_loop import plan_programme
from slider_drilling.programmes.steps import Action
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, Sentence, format_number, sentence

_TURN, _RPM = 2.0 * pi, 2.0 * pi / 60.0


@dataclass(frozen=True)
class StepInWords:
    """One step.

    Attributes:
        begin: s from the start.
        duration: s.
        text: What to do.
    """

    begin: float
    duration: float
    text: Sentence


def programme_in_words(programme: Programme, rig: Rig) -> tuple[StepInWords, ...]:
    """Every step of a programme without slides, with its time."""
    timed = plan_programme(programme, rig)
    return tuple(
        StepInWords(motion.begin, motion.motion.duration, _words(step.action))
        for step, motion in zip(programme.steps, timed, strict=True)
    )


def in_one_line(steps: Sequence[StepInWords]) -> Sentence:
    """All steps, joined by semicolons."""
    parts: list[str | Sentence] = []
    for step in steps:
        parts += ["; " if parts else "", step.text, f" ({step.duration:.0f} s)"]
    return sentence(*parts)


def _turns(angle: float) -> str:
    turns = round(angle / _TURN, 2)
    return f"{turns:g} {'turn' if turns == 1.0 else 'turns'}"


def _rpm(speed: float) -> str:
    return f"{format_number(speed / _RPM, 2)} rpm"


def _words(action: Action) -> Sentence:
    if isinstance(action, Rock):
        each = _turns(action.right) + " to either side"
        if action.right != action.left:
            each = f"{_turns(action.right)} right and {_turns(action.left)} left"
        rests = f", resting {action.rest:.0f} s at each end" if action.rest >= 0.5 else ""
        return sentence(f"rock {each} at {_rpm(action.speed)}{rests}")
    if isinstance(action, Rotate):
        return sentence(f"rotate at {_rpm(action.speed)}")
    if isinstance(action, Rest):
        return sentence("hold the top drive")
    if isinstance(action, DrillOff):
        return sentence("lock the brake and let the bit drill off")
    if isinstance(action, (PickUp, SlackOff)):
        how = "pick up " if isinstance(action, PickUp) else "slack off "
        return sentence(how, Quantity(action.distance, "m", 2), " at ", Quantity(60.0 * action.speed, "m/min", 2))
    if isinstance(action, BlockSpeed):
        return sentence("lower the block at ", Quantity(3600.0 * action.speed, "m/h"))
    if isinstance(action, Flow):
        return sentence("bring the flow to ", Quantity(1e3 * action.flow, "L/s"))
    return sentence(type(action).__name__)
