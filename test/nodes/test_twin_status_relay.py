"""What is said of changes: the twin's statuses and JSON, and what a controller repeats of them."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.messages.health import Level, Status
from slider_drilling.nodes.twin_status_relay import FORGOTTEN_AFTER, NOT_COMPARED, TwinStatusRelay
from slider_drilling.nodes.twin_statuses import TwinHealth, twin_statuses
from slider_drilling.twin import ChannelState, Detection, MotorStall, Trend, TwinReport
from slider_drilling.twin.gap_diagnosis import gap_diagnosis

START = 1.7e9  # s of the rig's clock
HEALTH = TwinHealth(behind=2.0, restarts=0, asking=False)
PRESSURE = Detection(
    1, 95.0, 60.0, (55.0, 66.0), "standpipe_pressure", "hydraulics", "step", 3.2, "standpipe pressure 3.2 bar lower"
)
WASHOUT = Detection(**{**vars(PRESSURE), "effects": ("washout",), "verdict": "named", "answered": 140.0})


def report(*detections: Detection) -> TwinReport:
    state = ChannelState("standpipe_pressure", "Pa", 1.8e7, 1.83e7, 1.2, 1.4, 0.9, 0.8, 2e5)
    trends = {"friction": Trend(1.12, 1.05, 1.19)}
    return TwinReport(200.0, "watching", "", np.arange(3.0), {}, {state.name: state}, trends, None, detections)


def by_name(*detections: Detection, health: TwinHealth = HEALTH) -> dict[str, Status]:
    return {one.name: one for one in twin_statuses(report(*detections), START, health)}


def test_site_says_level_reason_and_since() -> None:
    status = by_name(PRESSURE)["hydraulics"]
    assert (status.level, status.message) == (Level.WARN, "standpipe pressure 3.2 bar lower, since 22:14:20 UTC")
    values = dict(status.values)
    assert (values["since_s"], values["since_low_s"], values["detected_s"]) == (
        "1700000060.0",
        "1700000055.0",
        "1700000095.0",
    )
    assert (values["kind"], values["size_noise_levels"]) == ("step", "3.20")
    assert values["gap_60_standpipe_pressure"] == "1.40"


def test_named_effect_is_an_error() -> None:
    status = by_name(WASHOUT)["hydraulics"]
    assert (status.level, status.message) == (
        Level.ERROR,
        "washout since 22:14:20 UTC: standpipe pressure 3.2 bar lower",
    )
    suspected = by_name(Detection(**{**vars(PRESSURE), "suspected": ("motor_wear",)}))["hydraulics"]
    assert suspected.level is Level.WARN and suspected.message.endswith("suspected: motor wear")


@pytest.mark.parametrize("verdict", ["none", "parameters", "unknown", "inconclusive"])
def test_answer_without_a_name_is_said_in_words(verdict: str) -> None:
    message = by_name(replace(PRESSURE, verdict=verdict))["hydraulics"].message
    _, answer = message.split("; ")
    assert len(answer.split()) > 3 and verdict != answer


def test_twin_that_cannot_keep_up_says_so() -> None:
    assert by_name()["state"].message == "watching"
    assert by_name(health=replace(HEALTH, behind=40.0))["state"].message == "watching; 40 s behind the rig"


LARGE = replace(PRESSURE, number=2, size=9.0, since=70.0)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_site_shows_the_most_severe_change_and_how_many_others_stand(order: tuple[int, ...]) -> None:
    small = replace(PRESSURE, number=3, size=1.6)
    found = [PRESSURE, LARGE, small]
    status = by_name(*(found[k] for k in order))["hydraulics"]
    assert dict(status.values)["size_noise_levels"] == "9.00" and dict(status.values)["changes"] == "3"
    assert status.message.endswith("since 22:14:30 UTC; 2 other changes there")
    named = by_name(*(found[k] for k in order), replace(WASHOUT, number=4))["hydraulics"]
    assert named.level is Level.ERROR and named.message.startswith("washout")
    assert named.message.endswith("; 3 other changes there")
    suspected = by_name(LARGE, replace(small, suspected=("washout",)))["hydraulics"]
    assert suspected.message.endswith("suspected: washout; 1 other change there")


def test_change_that_has_ended_hides_none() -> None:
    status = by_name(PRESSURE, replace(LARGE, ended=180.0))["hydraulics"]
    assert dict(status.values)["size_noise_levels"] == "3.20" and "other" not in status.message


def test_change_that_has_ended_is_no_change() -> None:
    ended = Detection(**{**vars(WASHOUT), "ended": 180.0})
    assert by_name(ended)["hydraulics"].level is Level.OK
    assert by_name(ended, PRESSURE)["hydraulics"].level is Level.WARN


def test_unknown_site_has_its_own_status() -> None:
    assert by_name(Detection(**{**vars(PRESSURE), "site": "cement"}))["cement"].level is Level.WARN


def test_failed_diagnosis_is_said() -> None:
    state = by_name(health=TwinHealth(2.0, 1, False, "no diagnosis: too few samples"))["state"]
    assert (state.level, state.message) == (Level.WARN, "watching; no diagnosis: too few samples")
    values = dict(state.values)
    assert [values[f"trend_friction{end}"] for end in ("", "_low", "_high")] == ["1.12", "1.05", "1.19"]
    assert [one.message for one in twin_statuses(None, 0.0, HEALTH)] == ["waiting for samples of the drives"]


def test_detection_times_are_of_the_rigs_clock() -> None:
    whole = gap_diagnosis(report(WASHOUT), START, {"verdict": "named"}, 140.0)
    assert (whole["state"], whole["answered"], whole["answer"]) == ("watching", START + 140.0, {"verdict": "named"})
    (tree,) = whole["detections"]
    assert (tree["since"], tree["interval"], tree["answered"], tree["ended"]) == (
        START + 60.0,
        [START + 55.0, START + 66.0],
        START + 140.0,
        None,
    )
    assert set(PRESSURE.as_json()) <= set(tree) and tree["effects"] == ["washout"]
    unsized = report(Detection(**{**vars(PRESSURE), "size": math.nan}))
    json.dumps(gap_diagnosis(unsized, START, None, None), allow_nan=False)


class Clock:
    """A clock that is set by hand."""

    now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def relay(clock: Clock) -> TwinStatusRelay:
    return TwinStatusRelay(clock)


def sent(*detections: Detection) -> list[Status]:
    """The twin's statuses as they come to a controller."""
    named = twin_statuses(report(*detections), START, HEALTH)
    return [Status(one.level, f"rig_a/twin: {one.name}", one.message, one.values) for one in named]


def test_no_twin_gives_no_status(relay: TwinStatusRelay) -> None:
    relay.take([Status(Level.ERROR, "recorder: log", "full"), Status(Level.ERROR, "a_twin: motor", "hot")])
    assert relay.statuses() == []


def test_a_twin_that_learns_sees_no_fault_yet(relay: TwinStatusRelay) -> None:
    learning = replace(report(), state="learning")
    statuses = twin_statuses(learning, START, HEALTH)
    assert {one.message for one in statuses if one.name != "state"} == {NOT_COMPARED}
    relay.take([Status(one.level, f"twin: {one.name}", one.message, one.values) for one in statuses])
    (status,) = relay.statuses()
    assert (status.level, status.message) == (Level.OK, "the twin learns the rig: it would see no fault yet")


def test_controller_repeats_a_washout(relay: TwinStatusRelay) -> None:
    relay.take(sent())
    (status,) = relay.statuses()
    assert (status.level, status.name) == (Level.OK, "twin")
    assert status.message == "the twin sees no washout, plugged nozzle or motor fault"
    relay.take(sent(WASHOUT))
    (status,) = relay.statuses()
    assert status.level is Level.WARN, "the twin stops nothing"
    assert status.message == "the twin says: washout since 22:14:20 UTC: standpipe pressure 3.2 bar lower"


def test_stall_is_said_by_the_motor_and_repeated_by_the_controller(relay: TwinStatusRelay) -> None:
    stalled = replace(report(), stall=MotorStall(100.0, 6.2e6, 6.0e6))
    statuses = twin_statuses(stalled, START, HEALTH)
    motor = next(each for each in statuses if each.name == "motor")
    said = "the motor stalls since 22:15:00 UTC: 62 bar across it, and it stalls at 60 bar"
    assert (motor.level, motor.message) == (Level.WARN, said)
    relay.take([replace(each, name=f"twin: {each.name}") for each in statuses])
    assert relay.statuses()[0].message == f"the twin says: {said}"


@pytest.mark.parametrize(("ended", "level"), [(190.0, Level.WARN), (139.0, Level.OK)])
def test_stall_is_forgotten_a_minute_after_it(ended: float, level: Level) -> None:
    over = replace(report(), stall=MotorStall(100.0, 6.2e6, 6.0e6, ended))
    motor = next(each for each in twin_statuses(over, START, HEALTH) if each.name == "motor")
    assert motor.level is level and motor.message.startswith("the motor stalled from" if level else "no change")


def test_other_changes_are_not_repeated(relay: TwinStatusRelay) -> None:
    torque = Detection(**{**vars(PRESSURE), "site": "contact", "channel": "surface_torque", "what": "more torque"})
    relay.take(sent(torque))
    assert relay.statuses()[0].level is Level.OK
    relay.take(sent(Detection(**{**vars(torque), "suspected": ("motor_wear",)})))
    assert relay.statuses()[0].level is Level.WARN
    relay.take(sent(torque))
    assert relay.statuses()[0].level is Level.OK


def test_status_of_a_silent_twin_ages(relay: TwinStatusRelay, clock: Clock) -> None:
    relay.take(sent(WASHOUT))
    clock.now += 30.0
    (status,) = relay.statuses()
    assert status.message.endswith("lower (30 s ago; silent since)") and dict(status.values)["age_s"] == "30"
    clock.now += FORGOTTEN_AFTER
    assert relay.statuses() == []
