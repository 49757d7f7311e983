"""Runs contenders through scenarios without DDS, one or many in parallel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.control.controller_loader import (
    DEFAULT_CONTROLLER,
    checked_step,
    set_tool_face_target,
    statuses_of,
)
from slider_drilling.control.interface import Controller
from slider_drilling.process.worker_pool import map_in_processes
from slider_drilling.slide_scenarios.contenders import (
    BASELINES,
    UNDER_TEST,
    UPPER_BOUNDS,
    build_contender,
    measurements_for,
)
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.slide_scenarios.scenarios import DAILY
from slider_drilling.slide_scenarios.score import SlideScore, score_slide
from slider_drilling.slide_scenarios.trace import SlideTrace

_COLUMNS = ("time", "target", "tool_face", "top_drive_angle", "surface_torque", "weight_on_bit",
            "rate_of_penetration", "bit_depth", "differential_pressure")
_STATUS_INTERVAL = 1.0   # s


@dataclass(frozen=True)
class ScenarioResult:
    """Score and time series of one contender in one scenario."""

    scenario: Scenario
    contender: str
    score: SlideScore
    trace: SlideTrace


def run_scenario(
    scenario: Scenario, contender: str, seed: int = 0, elements: int = 200, name: str = DEFAULT_CONTROLLER,
    settings: Mapping[str, float] | None = None,
) -> ScenarioResult:  # fmt: skip
    """Run one contender through a scenario.

    Args:
        scenario: The slide.
        contender: A key of `contenders.ABOUT`.
        seed: Of sensor noise and faults.
        elements: Of the string.
        name: module:Class of the controller under test.
        settings: Settings of the controller under test that differ from its defaults.

    Raises:
        InputError: The controller cannot be built, or fails during the run.
    """
    rig = FaultyRig(scenario, seed, elements)
    controller = build_contender(contender, scenario, name, settings)
    measurements = rig.rig.measurements
    rows, events = [], _StatusEvents()
    for _ in range(round(scenario.duration / rig.rig.interval)):
        target = math.radians(scenario.target_at(measurements.time))
        set_tool_face_target(controller, target)
        command = checked_step(controller, measurements_for(contender, measurements, rig.rig.truth))
        measurements = rig.step(command)
        truth = rig.rig.truth
        events.update(measurements.time, controller)
        rows.append((truth.time, target, truth.tool_face, measurements.top_drive_angle, truth.surface_torque,
                     truth.weight_on_bit, truth.rate_of_penetration, truth.bit_depth,
                     truth.differential_pressure))
    columns = dict(zip(_COLUMNS, np.array(rows).T, strict=True))
    trace = SlideTrace(**columns, events=tuple(events.events))
    return ScenarioResult(scenario, contender, score_slide(scenario, trace), trace)


def run_all(
    pairs: Sequence[tuple[Scenario, str]], seed: int, elements: int, name: str, jobs: int,
    settings: Mapping[str, float] | None = None,
) -> Iterator[ScenarioResult]:
    """Run contenders through scenarios in parallel.

    Args:
        pairs: Scenario and contender of each run.
        seed: Of sensor noise and faults.
        elements: Of the string.
        name: module:Class of the controller under test.
        jobs: Number of processes.
        settings: Settings of the controller under test that differ from its defaults.

    Yields:
        Each result as its run ends.

    Raises:
        InputError: The controller cannot be built, or fails during a run.
    """
    calls = ((scenario, contender, seed, elements, name, settings) for scenario, contender in pairs)
    yield from map_in_processes(run_scenario, calls, jobs)


def contender_pairs(scenarios: Sequence[Scenario]) -> list[tuple[Scenario, str]]:
    """Return each scenario with each of its contenders.

    The baselines run only in the daily scenarios and on random rigs: they use no knowledge of the rig that could be
    wrong, so the scenarios with an inaccurate rig file would not test them.
    """

    def baselines(scenario: Scenario) -> tuple[str, ...]:
        return BASELINES if scenario in DAILY or scenario.rigs is not None else ()

    return [(scenario, contender) for scenario in scenarios
            for contender in (UNDER_TEST, *UPPER_BOUNDS, *baselines(scenario))]


class _StatusEvents:
    """Changes of level in a controller's status, checked once per second."""

    def __init__(self) -> None:
        self.events: list[tuple[float, str, str, str]] = []
        self._levels: dict[str, str] = {}
        self._next = 0.0

    def update(self, time: float, controller: Controller) -> None:
        if time < self._next:
            return
        self._next = time + _STATUS_INTERVAL
        for status in statuses_of(controller):
            if self._levels.get(status.name, "OK") != status.level.name:
                self.events.append((time, status.level.name, status.name, status.message))
            self._levels[status.name] = status.level.name
