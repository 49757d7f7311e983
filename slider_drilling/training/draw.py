"""Draws rigs for training: the random slides of `closed-loop --campaign`, some with plants of foreign structure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.blind.foreign.structure import draw_structure
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.slide_scenarios.drawn import draw_slide
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.training.drawn_rigs import DrawnRig


def draw_rigs(
    count: int, base: Rig, seed: int, duration: float, effects: bool | Sequence[str], foreign: float
) -> list[DrawnRig]:
    """Returns drawn rigs; the first few are the same for every count.

    Args:
        count: How many.
        base: Rig that wells, strings and fluids are drawn around.
        seed: Rig k is that of slide k of a campaign of this seed.
        duration: Of an episode, s.
        effects: Whether rigs have effects of the catalogue, or which ones.
        foreign: Share of rigs whose plant is of foreign structure.

    Raises:
        InputError: An effect is unknown, or the share is not from 0 to 1.
    """
    if not 0.0 <= foreign <= 1.0:
        raise InputError(f"vector_env: foreign = {foreign}: give a share from 0 to 1")
    names = (tuple(sorted(EFFECTS)) if effects else ()) if isinstance(effects, bool) else tuple(effects)
    for name in names:
        if name not in EFFECTS:
            raise InputError(f"vector_env: effects: {name!r} is unknown; use {', '.join(sorted(EFFECTS))}")
    return [_draw(number, base, seed, duration, names, foreign) for number in range(count)]


def _draw(number: int, base: Rig, seed: int, duration: float, effects: tuple[str, ...], foreign: float) -> DrawnRig:
    scenario = draw_slide(number, seed, base, duration, effects)
    random = np.random.default_rng((seed, number, 2))
    if random.uniform() >= foreign:
        return DrawnRig(scenario)
    return DrawnRig(scenario, draw_structure(random), int(random.integers(2**31)))


def given_rigs(rigs: Sequence[Rig], duration: float) -> list[DrawnRig]:
    """Returns rigs that are exactly as their files say, one each."""
    return [
        DrawnRig(Scenario(f"rig {number}", f"{rig.string.length / 1e3:.1f} km", "as its file", duration=duration,
                          rigs=(rig, rig)))
        for number, rig in enumerate(rigs)
    ]  # fmt: skip
