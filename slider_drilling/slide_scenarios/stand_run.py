"""Runs stands without DDS, one or many in parallel, and scores them by the true state."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.process.worker_pool import map_in_processes
from slider_drilling.programmes.controller import ProgrammeController
from slider_drilling.programmes.limits import CompleteLimits, complete
from slider_drilling.programmes.progress import ProgrammeProgress, ProgrammeState, StepRecord
from slider_drilling.programmes.steps import Slide
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.score import TOLERANCE_DEG
from slider_drilling.slide_scenarios.stand_scenarios import StandScenario
from slider_drilling.slide_scenarios.trace import Array

_COLUMNS = ("time", "tool_face", "surface_torque", "weight_on_bit", "standpipe_pressure", "bit_depth")
_WEIGHT_MEAN = 1.0  # s, over which weight is averaged before it is compared with its limit


@dataclass(frozen=True)
class StandScore:
    """Figures of one stand, from its true state; the errors are of the slide, from when its toolface was set.

    Attributes:
        name: Of the scenario.
        about: One line.
        outcome: "done", or why it was aborted.
        duration_s: Of the whole stand, s.
        time_to_orient_s: From the end of rotating until the toolface counted as set, s; None if it never did.
        mean_abs_error_deg: Mean toolface error, deg; None without a toolface that was set.
        largest_error_deg: Largest toolface error, deg.
        within_15_deg: Share of the time within 15 degrees.
        slid_m: New hole of the slide, orienting included, m.
        drilled_m: New hole of the stand, m.
        right_torque_n_m: Largest surface torque to the right, N m.
        left_torque_n_m: Largest surface torque to the left, N m.
        peak_weight_n: Largest weight on bit, N.
        peak_pressure_pa: Largest standpipe pressure, Pa.
        within_limits: Whether these and the toolface stayed within the limits of the programme.
    """

    name: str
    about: str
    outcome: str
    duration_s: float
    time_to_orient_s: float | None
    mean_abs_error_deg: float | None
    largest_error_deg: float | None
    within_15_deg: float | None
    slid_m: float
    drilled_m: float
    right_torque_n_m: float
    left_torque_n_m: float
    peak_weight_n: float
    peak_pressure_pa: float
    within_limits: bool


def run_stand(scenario: StandScenario, seed: int = 0, elements: int = 200) -> StandScore:
    """Run one stand to its end.

    Args:
        scenario: The stand.
        seed: Of sensor noise and faults.
        elements: Of the string.

    Raises:
        InputError: The rig cannot run the programme.
    """
    rig = FaultyRig(scenario.rig, seed, elements)
    known = scenario.rig.assumed_rig()
    controller = ProgrammeController(known, scenario.programme, scenario.name)
    measurements, rows = rig.rig.measurements, []
    while not controller.ended and measurements.time < controller.longest_time:
        measurements = rig.step(controller.step(measurements))
        rows.append([getattr(rig.rig.truth, name) for name in _COLUMNS])
    truth = dict(zip(_COLUMNS, np.array(rows).T, strict=True))
    # Limits are those of the programme: its steps give none of their own.
    return score_stand(scenario, controller.progress(), complete(scenario.programme.limits, scenario.programme.limits,
                                                                 known), truth)  # fmt: skip


def run_stands(scenarios: Sequence[StandScenario], seed: int, elements: int, jobs: int) -> Iterator[StandScore]:
    """Run stands in parallel; each score is given as its run ends.

    Args:
        scenarios: The stands.
        seed: Of sensor noise and faults.
        elements: Of the string.
        jobs: Number of processes.
    """
    yield from map_in_processes(run_stand, ((scenario, seed, elements) for scenario in scenarios), jobs)


def score_stand(
    scenario: StandScenario, progress: ProgrammeProgress, limits: CompleteLimits, truth: dict[str, Array]
) -> StandScore:
    """Return the figures of one run.

    Args:
        scenario: The stand.
        progress: At its end.
        limits: Of all its steps.
        truth: True channels over time, (n,) each, SI.
    """
    slide = next((record for record in progress.records if record.key == "slide"), None)
    error = _slide_error(scenario, slide, truth)
    interval = float(truth["time"][1] - truth["time"][0])
    weights = np.ones(round(_WEIGHT_MEAN / interval)) * interval / _WEIGHT_MEAN
    weight = float(np.convolve(truth["weight_on_bit"], weights, mode="valid").max())
    right, left = float(truth["surface_torque"].max()), float(-truth["surface_torque"].min())
    pressure = float(truth["standpipe_pressure"].max())
    within = (right <= limits.right_torque and left <= limits.left_torque and weight <= limits.weight_on_bit
              and pressure <= limits.pressure)  # fmt: skip
    largest = None if error is None else float(error.max())
    if largest is not None:
        within = within and largest <= math.degrees(limits.tool_face_tolerance)
    depth = truth["bit_depth"]
    return StandScore(
        name=scenario.name, about=scenario.about,
        outcome="done" if progress.state is ProgrammeState.DONE else progress.reason or "not ended",
        duration_s=float(truth["time"][-1]),
        time_to_orient_s=None if slide is None or slide.tool_face_set is None else slide.tool_face_set - slide.begin,
        mean_abs_error_deg=None if error is None else float(error.mean()), largest_error_deg=largest,
        within_15_deg=None if error is None else float(np.mean(error <= TOLERANCE_DEG)),
        slid_m=0.0 if slide is None else _new_hole(truth, slide.begin, slide.end or math.inf),
        drilled_m=float(depth.max() - depth[0]), right_torque_n_m=right, left_torque_n_m=left, peak_weight_n=weight,
        peak_pressure_pa=pressure, within_limits=within,
    )  # fmt: skip


def _slide_error(scenario: StandScenario, slide: StepRecord | None, truth: dict[str, Array]) -> Array | None:
    """Toolface error (deg) while the slide held its toolface; None if it never did."""
    if slide is None or slide.tool_face_set is None:
        return None
    action = scenario.programme.steps[slide.number - 1].action
    assert isinstance(action, Slide)
    until = slide.tool_face_left or slide.end or math.inf
    held = (truth["time"] >= slide.tool_face_set) & (truth["time"] <= until)
    off = np.degrees(truth["tool_face"][held] - action.tool_face)
    error: Array = np.abs((off + 180.0) % 360.0 - 180.0)
    return error


def _new_hole(truth: dict[str, Array], begin: float, end: float) -> float:
    """New hole between two times, m."""
    hole = np.maximum.accumulate(truth["bit_depth"])
    first, last = np.interp([begin, end], truth["time"], hole)
    return float(last - first)
