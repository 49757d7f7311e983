"""The live page's state: bounded buffers, and numbers in the page's units."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest

from slider_drilling.api.rigs import load_rig
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.interface import Level, Status
from slider_drilling.live.frame import (
    MAX_SAMPLES_PER_FRAME,
    StringView,
    dial_json,
    labels_json,
    rocking_json,
    samples_json,
)
from slider_drilling.live.freshness import Freshness
from slider_drilling.live.page_requests import MAX_REQUESTS, RequestQueue, SetRocking, SetTarget
from slider_drilling.live.state import (
    MAX_NOTICES,
    MAX_SAMPLES,
    MAX_STATUSES,
    MAX_TOOL_FACES,
    WINDOW,
    LiveParameter,
    LiveState,
)
from slider_drilling.units import FIELD

TOOL_FACE = (
    ("estimate_deg", "370.0"),
    ("one_sigma_deg", "4.5"),
    ("centre_rad", "3.25"),
    ("reactive_torque_n_m", "3000"),
)
REACH = (
    ("rocking_m", "3240"),
    ("reactive_from_m", "3432"),
    ("amplitude_rad", "12.0"),
    ("period_s", "8.0"),
    ("friction_over_assumed", "1.0"),
)


@pytest.fixture
def state() -> LiveState:
    state = LiveState()
    state.set_rig(load_rig())
    return state


def fill(state: LiveState, samples: int, interval: float = 0.1) -> None:
    for k in range(samples):
        state.add_sample(k * interval, math.sin(k), 1e3 * math.cos(k))


def test_state_keeps_only_the_window(state: LiveState) -> None:
    fill(state, 36_000)
    rows, count = state.samples_after(0)
    assert count == 36_000
    assert rows[-1].time - rows[0].time == pytest.approx(WINDOW, abs=0.11)
    fill(LiveState(), 10)


def test_fast_rig_does_not_exceed_the_buffer(state: LiveState) -> None:
    fill(state, 3 * MAX_SAMPLES, interval=0.001)
    for k in range(500):
        state.add_tool_face(float(k), 0.1)
        state.add_notice(f"notice {k}", success=True)
        state.update_statuses([Status(Level.OK, f"node: {k}", "")])
    assert len(state.samples_after(0)[0]) == MAX_SAMPLES
    assert (len(state.tool_faces()), len(state.notices_after(0))) == (MAX_TOOL_FACES, MAX_NOTICES)
    assert len(state.statuses()) == MAX_STATUSES


def test_newest_statuses_are_kept(state: LiveState) -> None:
    for k in range(MAX_STATUSES + 10):
        state.update_statuses([Status(Level.OK, "node: always", ""), Status(Level.OK, f"node: {k}", "")])
    names = {shown.status.name for shown in state.statuses()}
    assert len(names) == MAX_STATUSES
    assert {"node: always", f"node: {MAX_STATUSES + 9}"} <= names and "node: 0" not in names


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize("period", [1.0, 10.0])
def test_status_ages_by_its_own_period(period: float) -> None:
    clock = Clock()
    state = LiveState(clock)
    for _ in range(6):
        clock.now += period
        state.update_statuses([Status(Level.OK, "rig: clock", "keeps real time", (("speed", "1.0"),))])
    heard = clock.now

    def shown_after(periods: float) -> tuple[Level, Freshness, str]:
        clock.now = heard + periods * period
        (shown,) = state.statuses()
        return shown.level, shown.freshness, shown.message

    assert shown_after(1.9) == (Level.OK, Freshness.FRESH, "keeps real time")
    assert shown_after(2.1) == (Level.OK, Freshness.LATE, "keeps real time")
    assert state.status_value("clock", "speed") == 1.0
    level, freshness, message = shown_after(12.0)
    assert (level, freshness) == (Level.ERROR, Freshness.LOST)
    assert message == f"no status for {12.0 * period:.0f} s; last: keeps real time"
    assert state.status_value("clock", "speed") is None
    state.update_statuses([Status(Level.OK, "rig: clock", "keeps real time")])
    assert state.statuses()[0].freshness is Freshness.FRESH
    assert shown_after(12.0 + 2.1)[1] is Freshness.LATE, "one long silence is not the period"


def test_page_clock_ages_with_the_samples() -> None:
    clock = Clock()
    state = LiveState(clock)
    for k in range(10):
        clock.now += 0.1
        state.add_sample(k * 0.1, 0.0, 0.0)
    assert state.samples_age() == (0.0, Freshness.FRESH)
    clock.now += 12.0
    age, freshness = state.samples_age()
    assert (age, freshness) == (pytest.approx(12.0), Freshness.LOST)


def test_samples_are_returned_once(state: LiveState) -> None:
    fill(state, 5)
    first, count = state.samples_after(0)
    again, same = state.samples_after(count)
    assert (len(first), again, same) == (5, [], 5)


def test_clock_set_back_clears_the_buffers(state: LiveState) -> None:
    fill(state, 50)
    state.add_tool_face(3.0, 0.2)
    state.add_sample(0.0, 0.0, 0.0)
    assert [row.time for row in state.samples_after(0)[0]] == [0.0]
    assert state.tool_faces() == []


def test_differential_pressure_excludes_circulation(state: LiveState) -> None:
    rig = load_rig()
    full = rig.hydraulics.reference_flow / rig.mud_pump.displacement
    state.set_pump_speed(0.0, 0.5 * full)
    state.set_pressure(0.0, rig.hydraulics.reference_pressure * 0.5**1.8 + 2e6)
    for time in (0.0, 1.9, 2.1):
        state.add_sample(time, 0.0, 0.0)
    shown = [row.differential_pressure for row in state.samples_after(0)[0]]
    assert shown == pytest.approx([2e6, 2e6, math.nan], nan_ok=True)


def test_frame_is_json_in_page_units(state: LiveState) -> None:
    state.target, state.truth = math.radians(-170.0), math.radians(200.0)
    state.add_tool_face(90.0, math.radians(10.0))
    state.update_statuses(
        [
            Status(Level.OK, "rocking_controller: tool_face", "", TOOL_FACE),
            Status(Level.OK, "rocking_controller: reach", "", REACH),
        ]
    )
    state.add_sample(100.0, 2.0, 7500.0)
    dial = dial_json(state)
    assert dial == {"target": -170.0, "estimate": 10.0, "spread": 4.5, "measured": [[10.0, 10.0]], "truth": -160.0}
    assert rocking_json(state) == {"centre": 3.25, "amplitude": 12.0, "period": 8.0, "angle": 2.0}
    rows = samples_json(state.samples_after(0)[0])
    assert rows == [[100.0, 7.5, None, None, 2.0]]
    json.dumps([dial, rows], allow_nan=False)


def test_thinned_samples_keep_their_extremes(state: LiveState) -> None:
    fill(state, 3000)
    state.add_sample(299.95, 0.0, 9e6)
    fresh, _ = state.samples_after(0)
    shown = samples_json(fresh)
    assert len(shown) <= MAX_SAMPLES_PER_FRAME
    assert max(row[1] for row in shown) == 9e3
    assert all(a[0] <= b[0] for a, b in itertools.pairwise(shown))


def test_zones_and_rotation_along_the_well(state: LiveState) -> None:
    view = StringView(load_rig())
    assert view.rotation_json(state) == {"rocked_to": None, "reactive_from": None}
    state.update_statuses(
        [
            Status(Level.OK, "rocking_controller: tool_face", "", TOOL_FACE),
            Status(Level.OK, "rocking_controller: reach", "", REACH),
        ]
    )
    rotation, path = view.rotation_json(state), view.well_path_json()
    assert (rotation["rocked_to"], rotation["amplitude"][0], rotation["amplitude"][-1]) == (3240.0, 12.0, 0.0)
    assert rotation["lag"][0] == 0.0 < rotation["lag"][-1]
    assert (path["depth"][-1], path["verticalDepth"][0]) == (4000.0, 0.0)
    assert path["verticalDepth"][-1] == pytest.approx(1500.0 + 900.0 * 2.0 / math.pi, abs=1.0)


def test_rotation_agrees_with_reach_and_zones() -> None:
    model = TorqueAndDrag(load_rig(), 0.235, 3e4)
    depth = np.linspace(0.0, 4000.0, 401)
    amplitude, lag = model.rotation_along(depth, 12.0, 3000.0, 1.3)
    assert amplitude[0] == pytest.approx(12.0)
    assert depth[amplitude > 1e-3][-1] == pytest.approx(model.reach(12.0, 1.3), abs=60.0)
    assert (np.diff(amplitude) <= 1e-9).all() and (np.diff(lag) >= -1e-12).all()
    assert (lag[depth < model.zones(12.0, 3000.0, 1.3).reactive_from - 10.0] == 0.0).all()
    # All of the string is freed: what is left of the amplitude reaches the bit.
    assert model.rotation_along(depth, 60.0, 0.0, 1.0)[0][-1] == pytest.approx(60.0 - model.full_amplitude(1.0))


def test_request_queue_delivers_once_and_is_bounded() -> None:
    queue = RequestQueue()
    assert queue.put(SetTarget(0.5)) and queue.put(SetRocking(False))
    assert list(queue.take()) == [SetTarget(0.5), SetRocking(False)]
    assert list(queue.take()) == []
    assert [queue.put(SetRocking(True)) for _ in range(MAX_REQUESTS + 1)].count(False) == 1


def test_parameters_keep_their_latest_value(state: LiveState) -> None:
    for value in (1.0, 2.5):
        state.update_parameters([LiveParameter("rocking_controller", "gain", value, "-", 0.0, 8.0, "")])
    assert [one.value for one in state.parameters()] == [2.5]


def test_frame_is_in_field_units(state: LiveState) -> None:
    state.add_sample(100.0, math.pi, 1355.8179483314004)
    state.update_statuses([Status(Level.OK, "rocking_controller: reach", "", REACH)])
    assert samples_json(state.samples_after(0)[0], FIELD) == [[100.0, 1000.0, None, None, 0.5]]
    assert rocking_json(state, FIELD)["amplitude"] == pytest.approx(12.0 / (2.0 * math.pi))
    view = StringView(load_rig(), FIELD)
    assert view.well_path_json()["depth"][-1] == pytest.approx(4000.0 / 0.3048, abs=0.1)
    assert view.rotation_json(state)["rocked_to"] == pytest.approx(3240.0 / 0.3048)
    labels = labels_json(FIELD)
    assert labels["strips"] == [
        "surface torque, ft lbf", "differential pressure, psi", "hook load, klbf", "top drive, turns"]
    assert (labels["length"], labels["turn"], labels["digits"]) == ("ft", "turns", [0, 0, 1, 1])
