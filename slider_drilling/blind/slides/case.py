"""The cases of a campaign of sealed slides."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from slider_drilling.blind.slides.beginnings import CATALOGUE_CASES, NOTHING, OUTSIDE_CASES, SIX_CASES
from slider_drilling.blind.wells import DEFAULT_WELLS
from slider_drilling.drillstring.kernel_arrays import Array

DURATION_S = 2400.0
# Of ten slides four have one of the six cases, three another effect, one something from outside, and two nothing.
_KINDS = ("six", "catalogue", "none", "six", "outside", "six", "catalogue", "none", "six", "catalogue")
_ONSET = (0.35, 0.6)  # share of the slide
_GROWTH_S = (300.0, 700.0)  # s, of a ramp
# s, of changes whose times are given: 5 % in 10 minutes; a bed that grows; the others begin at once.
_FIXED_GROWTH = {"washout": 600.0, "growing_bed": 600.0, "motor_loss": 0.0, "torque_bias": 0.0, "backlash": 0.0,
                 "heave": 0.0}  # fmt: skip


@dataclass(frozen=True)
class SlideCase:
    """One sealed slide to be made.

    Attributes:
        begins: Key of `beginnings.BEGINNINGS`, or ``none``.
        onset: s, when it begins.
        growth: s, in which it reaches its full size; 0 for a step.
        well: Name in `blind.wells.WELLS`.
        seed: Of everything that is drawn.
        duration: s.
        driven_by: ``controller``, or ``crew`` that rocks by hand.
    """

    begins: str
    onset: float
    growth: float
    well: str
    seed: int
    duration: float = DURATION_S
    driven_by: str = "controller"

    def share_at(self, time: float) -> float:
        """Share of its full size at a time of the slide, s."""
        if self.begins == NOTHING or time < self.onset:
            return 0.0
        return 1.0 if self.growth == 0.0 else min((time - self.onset) / self.growth, 1.0)

    def shares_at(self, times: Array) -> Array:
        """The same at many times, (n,)."""
        return np.array([self.share_at(float(time)) for time in times])

    def to_json(self) -> dict[str, Any]:
        """The fields as JSON holds them."""
        return asdict(self)

    def file_stem(self) -> str:
        """A name for the case's files that does not reveal its content."""
        return hashlib.sha256(json.dumps(self.to_json()).encode()).hexdigest()[:10]


def slide_case_from_json(tree: Mapping[str, Any]) -> SlideCase:
    """The case that `SlideCase.to_json` gave."""
    return SlideCase(**tree)


def draw_slides(
    count: int, seed: int, duration: float = DURATION_S, begins: Sequence[str] = (), driven_by: str = "controller"
) -> list[SlideCase]:
    """The first `count` cases of a seed; a larger count starts with the same cases.

    Args:
        count: How many.
        seed: Another seed gives other wells, rigs, operations, noise and effects.
        duration: s, of each.
        begins: What may begin, in turn; the usual mixture if empty.
        driven_by: See `SlideCase`.
    """
    return [replace(case, driven_by=driven_by) for case in islice(_slides(seed, duration, begins), count)]


def _slides(seed: int, duration: float, begins: Sequence[str]) -> Iterator[SlideCase]:
    generator = np.random.default_rng([seed, 54])
    names = {"six": _in_turn(tuple(SIX_CASES), generator), "catalogue": _in_turn(tuple(CATALOGUE_CASES), generator),
             "outside": _in_turn(tuple(OUTSIDE_CASES), generator), "none": _in_turn((NOTHING,), generator),
             "chosen": _in_turn(tuple(begins), generator)}  # fmt: skip
    number = 0
    while True:
        for kind in ("chosen",) if begins else _KINDS:
            name = next(names[kind])
            onset = float(generator.uniform(*_ONSET)) * duration
            ramp = float(generator.uniform(*_GROWTH_S)) if generator.uniform() < 0.5 else 0.0
            growth = _FIXED_GROWTH.get(name, ramp)
            yield SlideCase(name, onset, growth, str(generator.choice(DEFAULT_WELLS)), 10000 * seed + number, duration)
            number += 1


def _in_turn(values: Sequence[str], generator: np.random.Generator) -> Iterator[str]:
    """All values in a random order, then all in another order, without end."""
    while values:
        for index in generator.permutation(len(values)):
            yield values[index]
