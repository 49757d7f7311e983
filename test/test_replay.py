"""Replay matches another program's runs of the same equations, and its own runs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.commands.replay import command
from slider_drilling.diagnosis.replay import channel_of, replay
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig, parse_rig

RIG_FILE = Path(__file__).parents[1] / "config" / "rig.example.yaml"
RIG = load_rig(RIG_FILE)


def short_run() -> Commands:
    time = np.arange(0.0, 30.0, 0.1)
    rate = 2.0 * math.pi / 12.0
    pump = np.where(time < 15.0, 12.3, 11.0)
    return Commands(
        time, 8.0 * (1 - np.cos(rate * time)), 8.0 * rate * np.sin(rate * time), 0.003 * time, 0 * time + 0.003, pump
    )


@pytest.mark.parametrize("well", ["base", "short", "long"])
def test_replay_matches_the_reference_rig(shared_data, well):
    """Figures of another implementation, another mesh, no noise."""
    log = read_log(shared_data / "logs" / f"nominal_{well}.mcap")
    channels = replay(log, log.rig()).channels
    assert channels["surface_torque"].rms < 60.0
    assert channels["standpipe_pressure"].rms < 20e3
    assert channels["hook_load"].rms < 500.0
    assert channels["tool_face"].rms < math.radians(6.0)


def test_replay_of_an_own_run_matches_it(tmp_path):
    """Through MCAP and back: stamps in ns are all that is lost."""
    commands = short_run()
    response = simulate(RIG, commands, elements=40)
    write_simulated(tmp_path / "run.mcap", RIG, commands, response, 1.7e9, "test")
    log = read_log(tmp_path / "run.mcap")
    again = replay(log, log.rig(), elements=40)
    assert set(again.channels) == {"surface_torque", "standpipe_pressure", "hook_load", "tool_face"}
    assert again.channels["surface_torque"].rms < 0.1
    assert again.channels["standpipe_pressure"].rms < 1.0
    assert again.channels["hook_load"].rms < 1.0
    assert again.channels["tool_face"].rms < 1e-4
    assert again.assumptions == ()


def test_rig_file_says_how_wrong_the_model_may_be():
    text = RIG_FILE.read_text().replace("hook_load: {noise: 4000.0,", "hook_load: {noise: 4000.0, model_error: 0.05,")
    time = np.arange(0.0, 30.0, 0.1)
    names = ("surface_torque", "hook_load", "tool_face")
    channels = {name: channel_of(parse_rig(text), name, time, time) for name in names}
    assert {name: channel.model_error for name, channel in channels.items()} == {
        "surface_torque": 0.02, "hook_load": 0.05, "tool_face": 0.0,
    }  # fmt: skip


def test_command_prints_the_documented_json(tmp_path):
    commands = short_run()
    write_simulated(tmp_path / "run.mcap", RIG, commands, simulate(RIG, commands, elements=40), 0.0, "test")
    result = CliRunner().invoke(
        command, [str(tmp_path / "run.mcap"), "--json", "--elements", "40", "-o", str(tmp_path / "out.mcap")]
    )
    assert result.exit_code == 0, result.output
    channels = json.loads(result.stdout)["channels"]
    assert set(channels["surface_torque"]) == {"rms", "rms_over_noise"}
    assert read_log(tmp_path / "out.mcap").truth_bit is not None


def test_assumptions_for_missing_channels_are_printed(tmp_path):
    from slider_drilling.log import LogWriter
    from slider_drilling.rig import dump_rig

    with LogWriter(tmp_path / "torque.mcap", dump_rig(RIG)) as writer:
        for k in range(100):
            writer.joint_state("rig/top_drive/joint_states", 0.1 * k, "top_drive", velocity=0.1 * k, effort=100.0)
    log = read_log(tmp_path / "torque.mcap")
    run = replay(log, log.rig(), elements=40)
    assert list(run.channels) == ["surface_torque"]
    assert len(run.assumptions) == 2
    assert run.commands.top_drive_angle[-1] == pytest.approx(0.5 * 9.9**2, rel=1e-6)
