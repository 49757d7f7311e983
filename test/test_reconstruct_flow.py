"""A pump that is not in the log: what standpipe pressure tells of its flow, and what is fitted."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.run_inputs import read_run_inputs
from slider_drilling.diagnosis.unlogged_flow import add_flow_steps, flow_step_parameters
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.gap.model import SimulationOptions
from slider_drilling.log import read_log
from slider_drilling.log.series import JointSeries
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.reconstruct_flow import flow_fraction, flow_reduced, pressure_steps
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
REFERENCE = RIG.hydraulics.reference_flow / RIG.mud_pump.displacement
ELEMENTS = 32


def pumped(share):
    """Rocking for two minutes at shares (1200,) of the reference flow."""
    time = 0.1 * np.arange(1200)
    turn = 2.0 * math.pi / 16.0
    return Commands(time, 15.0 * (1 - np.cos(turn * time)), 15.0 * turn * np.sin(turn * time), 0.002 * time,
                    np.full_like(time, 0.002), REFERENCE * share)  # fmt: skip


def less_between(begin, end, share):
    time = 0.1 * np.arange(1200)
    return np.where((time >= begin) & (time < end), share, 1.0)


@pytest.fixture(scope="module")
def without_pump(tmp_path_factory):
    """A log whose pump ran at 93 % from 50 to 80 s, and is not in it."""
    path = tmp_path_factory.mktemp("logs") / "run.mcap"
    run = pumped(less_between(50.0, 80.0, 0.93))
    write_simulated(path, RIG, run, simulate(RIG, run, ELEMENTS), 0.0, "test")
    return replace(read_log(path), mud_pump=None)


def noisy(values):
    return values + 4e4 * np.random.default_rng(2).normal(size=values.size)


def test_constant_flow_has_no_steps():
    run = pumped(np.ones(1200))
    felt = noisy(simulate(RIG, run, ELEMENTS).standpipe_pressure)
    assert pressure_steps(run.time, felt, RIG) == ()
    assert (flow_fraction(run.time, felt, (), RIG) == 1.0).all()
    assert not flow_reduced(run.time, felt, RIG).any()


@pytest.mark.parametrize("share", [0.8, 0.93])
def test_flow_changed_and_restored_is_found(share):
    run = pumped(less_between(50.0, 80.0, share))
    felt = noisy(simulate(RIG, run, ELEMENTS).standpipe_pressure)
    (begin, down), (end, up) = pressure_steps(run.time, felt, RIG)
    assert (begin, end) == pytest.approx((50.0, 80.0), abs=0.5)
    assert down < 0.0 < up
    found = flow_fraction(run.time, felt, pressure_steps(run.time, felt, RIG), RIG)
    assert found[650] == pytest.approx(share, abs=0.02) and found[300] == found[1000] == 1.0


def test_idle_pump_shows_in_circulating_pressure():
    run = pumped(less_between(50.0, 80.0, 0.0))
    felt = simulate(RIG, run, ELEMENTS).standpipe_pressure
    assert flow_fraction(run.time, felt, pressure_steps(run.time, felt, RIG), RIG)[700] == pytest.approx(0.0, abs=0.02)
    near = flow_reduced(run.time, felt, RIG)
    assert near[700] and near[805] and not near[300] and not near[1100]


def test_pressure_step_follows_its_lag():
    time = np.linspace(0.0, 40.0, 401)
    values = {"circulation_step_1": -2e6, "circulation_step_2": 1e6}
    found = add_flow_steps(np.zeros(401), time, (10.0, 20.0), values, 1.5)
    assert found[time < 10.0] == pytest.approx(0.0)
    assert found[115] == pytest.approx(-2e6 * (1.0 - math.exp(-1.0)), rel=1e-6)
    assert found[-1] == pytest.approx(-1e6, rel=1e-4)
    sudden = add_flow_steps(np.zeros(401), time, (10.0, 20.0), values, 0.0)
    assert sudden[101] == -2e6 and sudden[99] == 0.0
    assert len(flow_step_parameters([(10.0, 20.0), (5.0,)])) == 2


def test_missing_pump_is_fitted_by_steps(without_pump):
    prepared = build_model([without_pump], RIG)
    names = {one.name for one in prepared.model.nuisance}
    assert {"pressure_lag", "circulation_step_1", "circulation_step_2"} <= names
    text = " ".join(map(str, prepared.remarks))
    assert "pressure steps at" in text and "down to 93 %" in text
    model = replace(prepared.model, meshes=(ELEMENTS,))
    sets = [{}, {"circulation_step_2": 1e6}]
    plain, stepped = model.simulate(0, sets, SimulationOptions())["standpipe_pressure"]
    assert np.sqrt(np.mean((plain - model.runs[0].channels[1].measured) ** 2)) < 3e5
    assert stepped[-1] - plain[-1] == pytest.approx(1e6, rel=1e-3) and stepped[0] == plain[0]


def test_logged_pump_needs_no_flow_steps(without_pump):
    logged = commands_from_log(without_pump, RIG).commands
    nothing = np.full_like(logged.time, np.nan)
    pump = JointSeries(logged.time, logged.time, nothing, np.full_like(logged.time, REFERENCE), nothing)

    def steps(log):
        return read_run_inputs(log, RIG, []).flow_step_times

    empty = replace(pump, velocity=nothing)
    assert steps(without_pump) and steps(replace(without_pump, mud_pump=empty)) == steps(without_pump)
    assert not steps(replace(without_pump, mud_pump=pump))
    assert not steps(replace(without_pump, standpipe_pressure=None))
