"""A block whose motion is not in the log: what standpipe pressure tells of it, and what a fit adds to it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.unlogged_block import block_offsets
from slider_drilling.drillstring import Commands, simulate, simulate_batch
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.gap.model import SimulationOptions
from slider_drilling.log import read_log
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.reconstruct_block import rate_knots, reconstruct_block
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
ELEMENTS = 32


def drilling(rates, each=40.0):
    """Rocking while the block is lowered at one rate after the other, m/s, each for so many seconds."""
    time = np.arange(0.0, each * len(rates), 0.1)
    turn = 2.0 * math.pi / 16.0
    knots = each * np.arange(len(rates) + 1)
    block = np.interp(time, knots, np.concatenate([[0.0], np.cumsum(np.array(rates) * each)]))
    pump = np.full_like(time, RIG.hydraulics.reference_flow / RIG.mud_pump.displacement)
    return Commands(time, 15.0 * (1 - np.cos(turn * time)), 15.0 * turn * np.sin(turn * time), block,
                    np.gradient(block, time), pump)  # fmt: skip


def test_block_offset_equals_a_lowered_block():
    """The same run, whether the commands lower the block or every lane does by itself."""
    run = drilling((0.003, 0.002))
    run = replace(run, block_speed=np.diff(run.block_position, append=2 * run.block_position[-1]
                                           - run.block_position[-2]) / 0.1)  # fmt: skip
    still = replace(run, block_position=np.zeros_like(run.time), block_speed=np.zeros_like(run.time))
    both = np.stack([run.block_position, 0.5 * run.block_position])
    own = simulate_batch([RIG, RIG], still, ELEMENTS, block_offset=both)
    by_commands = simulate(RIG, run, ELEMENTS)
    assert own[0].hook_load == pytest.approx(by_commands.hook_load, abs=300.0)
    assert own[0].standpipe_pressure == pytest.approx(by_commands.standpipe_pressure, abs=5e3)
    assert np.ptp(own[1].weight_on_bit) < np.ptp(own[0].weight_on_bit)


def test_initial_block_offset_is_equilibrium():
    """No wave runs through a string whose block was lower from the first sample on."""
    run = drilling((0.0, 0.0))
    own = simulate_batch([RIG], run, ELEMENTS, block_offset=np.full((1, run.time.size), -0.5))[0]
    assert np.ptp(own.hook_load[run.time < 2.0]) < 10.0


def test_pressure_shows_the_block_rate():
    run = drilling((0.003, 0.003, 0.004, 0.002))
    felt = simulate(RIG, run, ELEMENTS).standpipe_pressure
    turning = run.top_drive_speed != 0.0
    position, speed = reconstruct_block(run.time, turning, run.pump_speed, run.time, felt, RIG)
    assert 0.2 * run.block_position[-1] < position[-1] < 1.1 * run.block_position[-1]
    assert np.ptp(speed) == 0.0 and position == pytest.approx(speed * run.time)
    slower = drilling((0.0015, 0.0015, 0.002, 0.001))
    felt = simulate(RIG, slower, ELEMENTS).standpipe_pressure
    assert reconstruct_block(run.time, turning, run.pump_speed, run.time, felt, RIG)[1][0] < 0.7 * speed[0]


def test_held_weight_raises_no_block():
    """Pressure falls when the rocking stops, and the block goes on as it did."""
    run = drilling((0.003, 0.003, 0.003, 0.003))
    rests = run.time > 120.0
    angle = np.where(rests, run.top_drive_angle[1200], run.top_drive_angle)
    still = replace(run, top_drive_angle=angle, top_drive_speed=np.where(rests, 0.0, run.top_drive_speed))
    felt = simulate(RIG, still, ELEMENTS).standpipe_pressure
    turning = still.top_drive_speed != 0.0
    found = reconstruct_block(run.time, turning, run.pump_speed, run.time, felt, RIG)[1][0]
    taken_in = reconstruct_block(run.time, np.ones_like(turning), run.pump_speed, run.time, felt, RIG)[1][0]
    first = run.time <= 120.0
    before = reconstruct_block(run.time[first], turning[first], run.pump_speed[first], run.time, felt, RIG)[1][0]
    assert found == pytest.approx(before, rel=0.05) and taken_in < 0.9 * found


def test_idle_pump_lowers_no_block():
    run = drilling((0.0, 0.0))
    turning = run.top_drive_speed != 0.0
    position, _ = reconstruct_block(run.time, turning, 0.0 * run.time, run.time, 0.0 * run.time, RIG)
    assert not position.any()


def test_missing_drawworks_are_fitted_by_rates(tmp_path):
    run = drilling((0.003, 0.004, 0.002))
    write_simulated(tmp_path / "run.mcap", RIG, run, simulate(RIG, run, ELEMENTS), 0.0, "test")
    whole = read_log(tmp_path / "run.mcap")
    log = replace(whole, draw_works=None)
    driven = commands_from_log(log, RIG)
    assert driven.block_from_pressure
    assert "the block's motion is reconstructed from standpipe pressure" in driven.assumptions[0]
    assert not commands_from_log(whole, RIG).block_from_pressure
    assert not commands_from_log(replace(log, standpipe_pressure=None), RIG).commands.block_position.any()

    model = replace(build_model([log], RIG).model, meshes=(ELEMENTS,))
    names = [one.name for one in model.nuisance if one.name.startswith("block_rate_")]
    assert names == [f"block_rate_{k + 1}" for k in range(6)]
    missing = np.diff(np.interp(rate_knots(run.time), run.time, run.block_position - driven.commands.block_position))
    truth = dict(zip(names, missing / np.diff(rate_knots(run.time)), strict=True))
    found = model.simulate(0, [{}, truth], SimulationOptions())["standpipe_pressure"]
    errors = np.sqrt(np.mean((found - model.runs[0].channels[1].measured) ** 2, axis=1))
    assert model.runs[0].channels[1].name == "standpipe_pressure" and errors[1] < 0.1 * errors[0]


def test_only_the_unlogged_block_is_fitted(tmp_path):
    run = drilling((0.003, 0.004, 0.002))
    write_simulated(tmp_path / "run.mcap", RIG, run, simulate(RIG, run, ELEMENTS), 0.0, "test")
    whole = read_log(tmp_path / "run.mcap")
    model = replace(build_model([whole, replace(whole, draw_works=None)], RIG).model, meshes=(ELEMENTS,))
    sets = [{}, {"block_rate_2": 0.002, "block_rate_3": 0.002}]
    pressures = [model.simulate(index, sets, SimulationOptions())["standpipe_pressure"] for index in (0, 1)]
    moved = [np.ptp(pressure, axis=0).max() for pressure in pressures]
    assert moved[0] == 0.0 and moved[1] > 1e5
    assert block_offsets(run.time, sets, model.nuisance)[1][-1] == pytest.approx(0.002 * 40.0, rel=0.01)
