"""Runs and logs that begin with a string that is loaded already."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.replay import replay
from slider_drilling.drillstring import Commands, InitialState, simulate, simulate_batch
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.log import read_log
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.infer_initial_state import infer_initial_state, initial_transient_end
from slider_drilling.rig import load_rig
from slider_drilling.wellbore.static_loads import static_loads

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
ELEMENTS, PERIOD = 40, 16.0
LOADED = InitialState(weight_on_bit=4e4, axial_friction_share=0.3, tangential_friction_share=0.2, surface_torque=6e3)


def rocking(duration, lowering=0.003):
    time = np.arange(0.0, duration, 0.1)
    turn = 2.0 * math.pi / PERIOD
    pump = np.full_like(time, RIG.hydraulics.reference_flow / RIG.mud_pump.displacement)
    return Commands(
        time, 15.0 * (1 - np.cos(turn * time)), 15.0 * turn * np.sin(turn * time), lowering * time,
        np.full_like(time, lowering), pump,
    )  # fmt: skip


def still(duration=2.0):
    run = rocking(duration, 0.0)
    return replace(run, top_drive_angle=np.zeros_like(run.time), top_drive_speed=np.zeros_like(run.time))


@pytest.fixture(scope="module")
def late_log(tmp_path_factory):
    """A log and the same without its first 70 s, on a clock of its own."""
    path = tmp_path_factory.mktemp("logs") / "run.mcap"
    run = rocking(200.0)
    write_simulated(path, RIG, run, simulate(RIG, run, ELEMENTS), 0.0, "test")
    whole = read_log(path)
    return whole, cut_time_window(whole, 70.0, np.inf)


def test_loaded_string_is_in_equilibrium():
    """Nothing moves but the bit, which drills: forces of springs, weight and contacts add up from the first step on."""
    response = simulate(RIG, still(), ELEMENTS, LOADED)
    assert response.surface_torque == pytest.approx(6e3, rel=5e-3)
    assert np.ptp(response.hook_load) < 5e-3 * response.hook_load[0]
    assert response.weight_on_bit[0] == 4e4
    assert response.weight_on_bit[-1] == pytest.approx(4e4, rel=0.2)


def test_hook_carries_the_remaining_weight():
    hanging = simulate(RIG, still(), ELEMENTS).hook_load[0]
    assert simulate(RIG, still(), ELEMENTS, InitialState(weight_on_bit=3e4)).hook_load[0] == pytest.approx(
        hanging - 3e4
    )
    for speed in (1.0, -1.0):
        own = simulate(RIG, still(), ELEMENTS, InitialState(weight_on_bit=3e4, axial_friction_share=speed)).hook_load[0]
        soft_string = static_loads(RIG, speed, weight_on_bit=3e4, elements=ELEMENTS).hook_load
        assert hanging - own == pytest.approx(hanging - soft_string, rel=0.02)


def test_pressure_and_torque_match_weight_on_bit():
    lever = RIG.bit.aggressiveness * RIG.bit.diameter / 3.0
    before, now = (
        simulate(RIG, still(), ELEMENTS, start) for start in (InitialState(), InitialState(weight_on_bit=4e4))
    )
    motor = lever * 4e4 / RIG.motor.torque_per_pressure
    assert now.standpipe_pressure[0] - before.standpipe_pressure[0] == pytest.approx(motor)
    assert now.surface_torque[0] == pytest.approx(lever * 4e4)


def test_loaded_lane_leaves_others_unchanged():
    alone = simulate(RIG, still(), ELEMENTS)
    beside = simulate_batch([RIG, RIG], still(), ELEMENTS, [InitialState(), LOADED])[0]
    assert beside.hook_load == pytest.approx(alone.hook_load, rel=1e-9)
    assert beside.surface_torque == pytest.approx(alone.surface_torque, abs=1e-3)


def test_log_at_rest_starts_at_rest(late_log):
    whole, _ = late_log
    assert infer_initial_state(whole, RIG, commands_from_log(whole, RIG).commands) == InitialState()


def test_loaded_log_is_replayed_from_its_state(late_log):
    whole, late = late_log
    start = infer_initial_state(late, RIG, commands_from_log(late, RIG).commands)
    assert start.loaded and start.surface_torque is not None and start.weight_on_bit > 0.0
    own, hanging = replay(late, RIG, ELEMENTS), replay(late, RIG, ELEMENTS, InitialState())
    for name in ("surface_torque", "standpipe_pressure", "hook_load"):
        assert own.channels[name].rms < 0.7 * hanging.channels[name].rms, name
    assert replay(whole, RIG, ELEMENTS).channels["surface_torque"].rms < 1.0


def test_diagnosis_fits_initial_state_and_skips_transient(late_log):
    _, late = late_log
    prepared = build_model([late], RIG)
    begin = initial_transient_end(RIG, commands_from_log(late, RIG).commands)
    assert PERIOD < begin <= 0.2 * 130.0
    assert all(channel.time[0] >= begin for channel in prepared.model.runs[0].channels)
    assert {"start_weight", "start_drag", "start_hold"} <= {parameter.name for parameter in prepared.model.nuisance}
    assert any("starts while the string is loaded" in str(remark) for remark in prepared.remarks)


def test_loaded_string_at_rest_is_recognised(late_log):
    whole, _ = late_log
    run = commands_from_log(whole, RIG).commands
    resting = replace(run, top_drive_speed=np.zeros_like(run.time))
    lighter = replace(whole, draw_works=replace(whole.draw_works, effort=whole.draw_works.effort - 6e4))
    assert infer_initial_state(whole, RIG, resting) == InitialState()
    assert infer_initial_state(lighter, RIG, resting).loaded
    assert infer_initial_state(replace(whole, draw_works=None), RIG, resting) == InitialState()
