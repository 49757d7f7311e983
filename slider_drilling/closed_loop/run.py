"""One contender through one scenario, without DDS, and all of them in parallel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.closed_loop.contenders import BASELINES, LIMITS, UNDER_TEST, build_contender, measurements_for
from slider_drilling.closed_loop.faulty_rig import FaultyRig
from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.closed_loop.scenarios import DAILY
from slider_drilling.closed_loop.score import SlideScore, score_slide
from slider_drilling.closed_loop.trace import SlideTrace
from slider_drilling.control.controller_loader import (
    DEFAULT_CONTROLLER,
    checked_step,
    set_tool_face_target,
    statuses_of,
)
from slider_drilling.control.interface import Controller
from slider_drilling.process.worker_pool import map_in_processes

_COLUMNS = ("time", "target", "tool_face", "top_drive_angle", "surface_torque", "weight_on_bit",
            "rate_of_penetration", "bit_depth")


@dataclass(frozen=True)
class ScenarioResult:
    """A contender's score in a scenario and its trace."""

    scenario: Scenario
    contender: str
    score: SlideScore
    trace: SlideTrace


def run_scenario(
    scenario: Scenario, contender: str, seed: int = 0, elements: int = 200, name: str = DEFAULT_CONTROLLER,
    settings: Mapping[str, float] | None = None,
) -> ScenarioResult:  # fmt: skip
    """Drive one contender through a scenario. `name`: module:Class of the controller under test, settings: those of its
    own that are not at their default. Raises InputError."""
    rig = FaultyRig(scenario, seed, elements)
    controller = build_contender(contender, scenario, name, settings)
    measurements = rig.rig.measurements
    rows, events = [], _Events()
    for _ in range(round(scenario.duration / rig.rig.interval)):
        target = math.radians(scenario.target_at(measurements.time))
        set_tool_face_target(controller, target)
        command = checked_step(controller, measurements_for(contender, measurements, rig.rig.truth))
        measurements = rig.step(command)
        truth = rig.rig.truth
        events.take(measurements.time, controller)
        rows.append((truth.time, target, truth.tool_face, measurements.top_drive_angle, truth.surface_torque,
                     truth.weight_on_bit, truth.rate_of_penetration, truth.bit_depth))
    columns = dict(zip(_COLUMNS, np.array(rows).T, strict=True))
    trace = SlideTrace(**columns, events=tuple(events.seen))
    return ScenarioResult(scenario, contender, score_slide(scenario, trace), trace)


def run_all(
    pairs: Sequence[tuple[Scenario, str]], seed: int, elements: int, name: str, jobs: int,
    settings: Mapping[str, float] | None = None,
) -> Iterator[ScenarioResult]:
    """Each contender through its scenario, as they end. Raises InputError."""
    calls = ((scenario, contender, seed, elements, name, settings) for scenario, contender in pairs)
    yield from map_in_processes(run_scenario, calls, jobs)


def contender_pairs(scenarios: Sequence[Scenario]) -> list[tuple[Scenario, str]]:
    """Each scenario with its contenders: the baselines, which know nothing that could be wrong, in the daily ones
    and in drawn ones."""

    def beside(scenario: Scenario) -> tuple[str, ...]:
        return BASELINES if scenario in DAILY or scenario.rigs is not None else ()

    return [(scenario, contender) for scenario in scenarios for contender in (UNDER_TEST, *LIMITS, *beside(scenario))]


class _Events:
    """Changes of level or kind in a controller's status, looked at once a second."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, str, str, str]] = []
        self._levels: dict[str, str] = {}
        self._next = 0.0

    def take(self, time: float, controller: Controller) -> None:
        if time < self._next:
            return
        self._next = time + 1.0
        for status in statuses_of(controller):
            if self._levels.get(status.name, "OK") != status.level.name:
                self.seen.append((time, status.level.name, status.name, status.message))
            self._levels[status.name] = status.level.name
