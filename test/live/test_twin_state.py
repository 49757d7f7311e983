"""What the live page shows of the drilling and of a twin: numbers, units, limits of memory."""

from __future__ import annotations

import json
import math

import pytest

from slider_drilling.api.rigs import load_rig
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.live.calibrated_parameters import proposed_changes
from slider_drilling.live.drilling_progress import DrillingProgress
from slider_drilling.live.frame import drilling_figures, expected_json
from slider_drilling.live.freshness import Freshness
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.live.twin_frame import answer_text, detection_label, twin_json
from slider_drilling.live.twin_state import MAX_EXPECTED, MAX_TREND_POINTS, TwinState
from slider_drilling.units import FIELD, quantities_in

DETECTION = {"detected": 95.0, "since": 60.0, "interval": [55.0, 66.0], "site": "hydraulics", "effects": ["washout"],
             "suspected": [], "what": "standpipe pressure 3.2 bar lower", "verdict": "named",
             "answered": 120.0}  # fmt: skip


@pytest.fixture
def state() -> LiveState:
    state = LiveState()
    state.set_rig(load_rig())
    return state


def slide(state: LiveState, seconds: float, rate: float = 0.01, turn: float = 0.0) -> None:
    """A block that is lowered at a rate, m/s; the top drive turns at `turn`, rad/s."""
    for k in range(round(seconds) * 10 + 1):
        state.set_block(0.1 * k, rate * 0.1 * k, 3e5)
        state.add_sample(0.1 * k, turn * 0.1 * k, 1e3)


def test_figures_show_depth_rate_and_hook_load(state: LiveState) -> None:
    slide(state, 100.0)
    state.update_statuses([Status(Level.OK, "rocking_controller: weight_on_bit", "", (("by_hook_load_n", "45000"),))])
    assert dict(drilling_figures(state)) == {
        "hook load": "300.0 kN", "weight on bit, by hook load": "45.0 kN", "rate of penetration": "36.0 m/h",
        "bit depth": "4001.00 m", "slide length": "1.00 m"}  # fmt: skip
    assert dict(drilling_figures(state, FIELD)) == {
        "hook load": "67.4 klbf", "weight on bit, by hook load": "10.1 klbf", "rate of penetration": "118.1 ft/h",
        "bit depth": "13126.64 ft", "slide length": "3.28 ft"}  # fmt: skip


def test_unknown_figures_are_dashes(state: LiveState) -> None:
    state.update_statuses([Status(Level.OK, "rocking_controller: weight_on_bit", "", (("by_hook_load_n", "nan"),))])
    assert {value for _, value in drilling_figures(state)} == {"-"}


def test_measured_bit_depth_is_preferred(state: LiveState) -> None:
    state.set_block(0.0, 5.0, 3e5)
    state.set_bit_depth(0.0, 2500.0)
    state.add_sample(0.0, 0.0, 0.0)
    assert state.drilling().bit_depth == 2500.0
    state.set_block(60.0, 5.0, 3e5)
    state.add_sample(60.0, 0.0, 0.0)
    assert math.isnan(state.drilling().bit_depth), "not the block's in its place"


@pytest.mark.parametrize("period", [8.0, 25.0])
def test_slide_begins_when_rotation_ends(period: float) -> None:
    progress = DrillingProgress()
    depth = angle = 0.0
    for k in range(6000):
        time = 0.1 * k
        angle = 6.0 * min(time, 300.0) + (15.0 * math.sin(2.0 * math.pi * time / period) if time > 300.0 else 0.0)
        depth += 0.001
        progress.add(time, depth, angle)
        if k == 2900:
            assert progress.is_rotating and progress.slide_length == pytest.approx(0.0, abs=0.02)
    assert not progress.is_rotating
    assert progress.slide_length == pytest.approx(3.0, abs=0.6)


def test_pick_up_makes_no_hole() -> None:
    progress = DrillingProgress()
    for k in range(900):
        progress.add(0.1 * k, 0.001 * min(k, 500) - (2.0 if k > 600 else 0.0), 0.0)
    assert progress.slide_length == pytest.approx(0.5)
    assert progress.rate_of_penetration == pytest.approx((0.5 - 0.29) / 60.0)


def test_controller_texts_have_no_bare_si_left() -> None:
    from slider_drilling.control import SlideController
    from slider_drilling.drillstring import VirtualRig

    rig = load_rig()
    plant, controller = VirtualRig(rig, elements=20), SlideController(rig)
    for _ in range(600):
        plant.step(controller.step(plant.measurements))
    texts = [FIELD.convert_text(quantities_in(one.message)) for one in controller.status()]
    assert any("ft" in text for text in texts) and any("psi" in text for text in texts)
    for text in texts:
        assert not any(f" {unit}" in f"{text} ".replace(",", " ") for unit in ("m ", "bar ", "N m ", "kN ")), text


def expect(twin: TwinState, at: float, torque: float, circulation: float = 1.8e7) -> None:
    twin.set_expected("standpipe_pressure", at, 2e7)
    twin.set_expected("hook_load", at - 1.0, 3e5)
    twin.set_expected("surface_torque", at, torque)
    twin.finish_expected(at, circulation)


def test_expected_samples_are_of_one_time() -> None:
    twin = TwinState()
    expect(twin, 5.0, 4e3)
    samples, count = twin.expected_after(0)
    assert expected_json(samples) == [[5.0, 4.0, 20.0, None, None]], "the hook load is an older one"
    assert (count, twin.expected_after(count)) == (1, ([], 1))
    assert expected_json(samples, FIELD)[0][2] == pytest.approx(290.08)


def test_expected_pressure_is_across_the_motor(state: LiveState) -> None:
    full = state.rig.hydraulics.reference_flow / state.rig.mud_pump.displacement
    state.set_pump_speed(1.0, full)
    state.set_pressure(1.0, state.rig.hydraulics.reference_pressure + 2e6)
    state.add_sample(1.0, 0.0, 0.0)
    assert state.circulation_at(1.0) == pytest.approx(state.rig.hydraulics.reference_pressure)
    assert math.isnan(state.circulation_at(0.5))


def test_twin_state_is_bounded() -> None:
    twin = TwinState()
    for k in range(3 * MAX_EXPECTED):
        expect(twin, 0.1 * k, 0.0)
    for k in range(3 * MAX_TREND_POINTS):
        for bound in ("value", "lower", "upper"):
            twin.set_trends(bound, 10.0 * k, {"friction": 1.0})
    assert len(twin.expected_after(0)[0]) == MAX_EXPECTED
    assert len(twin.trends()) == MAX_TREND_POINTS


def test_gaps_are_shares_of_their_threshold() -> None:
    twin = TwinState()
    for seconds, gap in ((10, 3.0), (60, 1.8), (300, 0.6)):
        twin.set_gaps(seconds, {"surface_torque": gap, "tool_face": math.nan})
    twin.set_thresholds({"surface_torque": 1.2})
    torque, tool_face = twin_json(twin, 0.0)["gaps"]
    assert torque == {"name": "surface torque", "share": 1.5, "quick": 2.5, "slow": 0.5, "shown": "1.80 of 1.20"}
    nothing = {"share": None, "quick": None, "slow": None, "shown": "- (no threshold)"}
    assert tool_face == {"name": "toolface", **nothing}


def test_trends_need_all_three_numbers() -> None:
    twin = TwinState()
    twin.set_trends("value", 10.0, {"friction": 1.1})
    twin.set_trends("lower", 10.0, {"friction": 1.0})
    assert twin.latest_trends() == {}
    twin.set_trends("upper", 10.0, {"friction": 1.2})
    assert twin.latest_trends() == {"friction": (1.1, 1.0, 1.2)}
    drawn = twin_json(twin, 20.0)
    assert drawn["trends"][0] == {"name": "friction", "points": [[10.0, 1.1, 1.0, 1.2]]}
    json.dumps(drawn, allow_nan=False)


def test_detections_are_named_on_the_time_line() -> None:
    twin = TwinState()
    twin.set_diagnosis(json.dumps({"state": "watching", "detections": [DETECTION, {"since": 3.0}]}))
    (drawn,) = twin_json(twin, 130.0)["detections"]
    assert (drawn["label"], drawn["named"], drawn["interval"]) == ("washout", True, [55.0, 66.0])
    unnamed = {**DETECTION, "effects": []}
    assert detection_label(unnamed, FIELD) == "standpipe pressure 46 psi lower"
    assert detection_label({**unnamed, "suspected": ["motor_wear"]}).startswith("suspected: motor wear (")


def test_unreadable_diagnosis_is_refused() -> None:
    for text in ("[1]", "{"):
        with pytest.raises(ValueError):
            TwinState().set_diagnosis(text)


def test_page_says_what_a_diagnosis_answered() -> None:
    twin = TwinState()
    assert answer_text(twin) == ""
    summary = "What is different: the torque reading is 900 N m too high. That explains 98 %."
    twin.set_diagnosis(json.dumps({"answered": 1775.2, "answer": {"summary": summary}}))
    assert answer_text(twin) == f"The last diagnosis, at 1775 s: {summary}"
    assert "664 ft lbf too high" in answer_text(twin, FIELD)
    twin.set_diagnosis(json.dumps({"start": 300.2, "answered": 2075.4, "answer": {"summary": summary}}))
    assert answer_text(twin).startswith("The last diagnosis, at 2075 s, its times counted from 300 s: What")


def test_silent_twin_ages() -> None:
    now = [0.0]
    twin = TwinState(lambda: now[0])
    assert twin.freshness() is None
    twin.set_gaps(60, {"hook_load": 0.1})
    now[0] = 30.0
    assert (twin.freshness(), twin.age()) == (Freshness.LOST, 30.0)


def with_trends(state: LiveState, friction: float, pressure: float) -> None:
    for bound in ("value", "lower", "upper"):
        state.twin.set_trends(bound, 10.0, {"friction": friction, "circulating_pressure": pressure, "motor_gain": 0.9})
    state.twin.set_diagnosis('{"compared": true}')


def declare(state: LiveState) -> None:
    state.update_parameters(
        [
            LiveParameter("rocking_controller", "friction_factor", 0.235, "-", 0.02, 1.0, ""),
            LiveParameter("rocking_controller", "off_bottom_pressure", 0.0, "Pa", 0.0, 1e8, "; 0: the rig file's"),
        ]
    )


def test_calibrated_rig_sets_friction_and_pressure(state: LiveState) -> None:
    assert proposed_changes(state) == ([], ["the twin has calibrated nothing yet"])
    with_trends(state, 1.2, 1.05)
    assert len(proposed_changes(state)[1]) == 2, "a controller without these parameters"
    declare(state)
    changes, remarks = proposed_changes(state)
    assert {one.parameter.name: one.value for one in changes} == pytest.approx(
        {
            "friction_factor": 1.2 * SlideSettings().friction_factor,
            "off_bottom_pressure": 1.05 * state.rig.hydraulics.reference_pressure,
        }
    )
    assert remarks == []
    assert all(one.consequence for one in changes), "a driller confirms what the controller will do"


def test_twin_that_learns_or_is_silent_proposes_nothing() -> None:
    now = [0.0]
    state = LiveState(lambda: now[0])
    state.set_rig(load_rig())
    declare(state)
    with_trends(state, 1.2, 1.05)
    state.twin.set_gaps(60, {"hook_load": 0.1})
    assert len(proposed_changes(state)[0]) == 2
    now[0] = 30.0
    assert proposed_changes(state) == ([], ["the twin has said nothing for 30 s"])
    state.twin.set_diagnosis('{"compared": false}')
    assert proposed_changes(state) == ([], ["the twin still learns the rig"])


def test_latched_load_check_is_not_released(state: LiveState) -> None:
    declare(state)
    with_trends(state, 99.0, 0.8)
    state.update_statuses([Status(Level.ERROR, "rocking_controller: off_bottom_pressure", "latched: washout")])
    changes, remarks = proposed_changes(state)
    assert changes == []
    assert ["outside" in remarks[0], "would release the load check" in remarks[1]] == [True, True]


def test_statuses_of_a_twin_name_it() -> None:
    page = pytest.importorskip("slider_drilling.live.page", reason="no NiceGUI: pip install '.[live]'")
    names = ["twin: bit", "twin: string", "rocking_controller: string", "recorder: log"]
    shown = [page._title(name, names) for name in names]
    assert shown == ["bit (twin)", "string (twin)", "string (rocking controller)", "log"]
