"""The bench measures what it says: names, equalities, no time."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from click.testing import CliRunner
from process_groups import ends

from slider_drilling.benchmarks import many_rigs, peers, published, sessions, string_rates
from slider_drilling.benchmarks import suite as everything
from slider_drilling.benchmarks.diagnosis import write_log
from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import wall_seconds
from slider_drilling.benchmarks.workload import RockingPlant, rocking_commands, variants
from slider_drilling.commands.bench import command
from slider_drilling.control import FixedRocking
from slider_drilling.drillstring import Commands, Plant, VirtualRig, simulate
from slider_drilling.log import read_log
from slider_drilling.rig.example import example_rig
from slider_drilling.wellbore.mesh import build_mesh
from slider_drilling.wellbore.static_loads import static_loads

ASKED = ("single_ns_per_element_step", "batch_ns_per_element_step", "single_precision_ns_per_element_step",
         "real_time_factor", "closed_loop_real_time_factor", "recorder_messages_per_s", "diagnose_s",
         "help_s")  # fmt: skip


def test_json_has_figures_references_and_ratios(monkeypatch):
    """The command's own output, with the minutes of measuring left out."""
    quick = tuple((name, lambda name=name: [BenchmarkResult(name, 3.0, "ns", 2.0, "another")]) for name in ASKED)
    monkeypatch.setattr(everything, "STAGES", quick)
    done = CliRunner().invoke(command, ["--json"], catch_exceptions=False)
    printed = json.loads(done.stdout)
    assert [row["name"] for row in printed["results"]] == list(ASKED)
    for row in printed["results"]:
        assert {"name", "value", "unit", "reference", "ratio"} <= set(row)
        assert row["ratio"] == pytest.approx(row["value"] / row["reference"])
    assert "processor" in printed["machine"]


def test_stages_give_their_figures(monkeypatch):
    """Without ROS every name is still there, and says why it has no value."""
    monkeypatch.setattr(sessions, "ros_is_there", lambda: False)
    monkeypatch.setattr(string_rates, "BATCH", 2)
    rows = [*string_rates.string_rates(), *sessions.session_rates(), sessions.node_start()]
    assert {*ASKED[:6], "node_start_s"} <= {row.name for row in rows}
    for row in rows:
        if row.name in ASKED[:4]:
            assert row.value > 0.0 and row.ratio > 0.0
        else:
            assert row.value is None and row.ratio is None and row.note.startswith("not available: ROS 2")


STAYS = (
    "from slider_drilling.process.parent_death import interrupt_with_parent as e; e(); "
    "open('there', 'w'); import time; time.sleep(600)"
)


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel of Linux tells a process that its parent is gone")
def test_benchmark_process_ends_with_killed_parent(tmp_path):
    other = tmp_path / "python"
    other.write_text(f'#!/bin/sh\nexec {sys.executable} -c "{STAYS}"\n')
    other.chmod(0o755)
    code = f"import sys\nfrom slider_drilling.benchmarks import sessions\nsys.executable = {str(other)!r}\n"
    code += "sessions.run_benchmark('')"
    with subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, start_new_session=True) as bench:
        try:
            waited = time.monotonic() + 60.0
            while not (tmp_path / "there").exists():
                assert time.monotonic() < waited and bench.poll() is None, "it never started what measures"
                time.sleep(0.01)
            bench.kill()
            bench.wait()
            assert ends(bench.pid, 60.0), "what measures was left behind"
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(bench.pid, signal.SIGKILL)


def test_table_shows_missing_figures(monkeypatch):
    rows = [BenchmarkResult("help_s", 0.25, "s", 0.125, "python"),
            BenchmarkResult("diagnose_s", None, "s", note="not available: why")]  # fmt: skip
    monkeypatch.setattr(everything, "STAGES", (("all", lambda: rows),))
    done = CliRunner().invoke(command, [], catch_exceptions=False)
    assert "0.25 s" in done.stdout
    assert "not available: why" in done.stdout


def test_timed_plant_equals_one_run():
    """What is timed is the whole simulation with all channels: in parts it ends where one run ends."""
    rig = example_rig()
    plant = RockingPlant(rig, elements=20)
    first = plant.last.time.size
    plant.advance(1.0)
    interval, began = plant.last.time[1] - plant.last.time[0], plant.last.time[0]
    # The parts' own commands: times counted from one beginning differ from theirs by a last bit.
    parts = (rocking_commands(rig, 1.0 - interval), rocking_commands(rig, 1.0 - interval, began))
    joined = (np.concatenate([getattr(part, field.name) for part in parts]) for field in dataclasses.fields(Commands))
    whole = Plant(rig, 20).advance(Commands(*joined))
    assert np.array_equal(plant.last.surface_torque, whole.surface_torque[first:])
    alone = simulate(rig, rocking_commands(rig, 1.9), elements=20)
    assert plant.last.surface_torque[-1] == pytest.approx(alone.surface_torque[-1], rel=1e-12)
    assert plant.last.time[-1] == pytest.approx(1.9)
    assert plant.element_steps(2.0) == pytest.approx(20 * 2.0 / plant.step)


def test_variants_differ():
    shares = [rig.bit.aggressiveness for rig in variants(example_rig(), 5)]
    assert len(set(shares)) == 5


def test_reference_arithmetic_stays_normal():
    """Numbers that overflow or fade to nothing would take another time than those of a step."""
    moving = np.full((8, 96), 0.1)
    string_rates.repeat_arithmetic(5000, 96, np.full((16, 96), 0.1), moving, np.linspace(4.0, 0.1, 8))
    assert np.all(np.isfinite(moving))
    assert np.all(np.abs(moving) > 1e-6)
    assert np.all(np.abs(moving) < 1e3)


def test_median_is_over_runs():
    calls = []
    assert math.isfinite(wall_seconds(lambda: calls.append(1), repeats=3))
    assert len(calls) == 3


def test_log_to_diagnose_has_unknown_effect(tmp_path):
    path = tmp_path / "log.mcap"
    write_log(path, duration=30.0)
    log = read_log(path)
    assert log.rig().effects.stribeck.drop == 0.0
    assert len(log.top_drive.time) == 300
    assert len(log.mwd_tool_face.time) > 0
    virtual, controller = VirtualRig(example_rig(), seed=1), FixedRocking(example_rig())
    nominal = [virtual.measurements.surface_torque]
    nominal += [virtual.step(controller.step(virtual.measurements)).surface_torque for _ in range(299)]
    assert np.max(np.abs(log.top_drive.effort - nominal)) > 500.0


def test_static_peers_agree_within_three_percent():
    """Both formulas of others give our hook loads, once the sign of one of them is put right (see benchmarks/peers)."""
    pytest.importorskip("welleng")
    pytest.importorskip("torque_drag")
    mine, as_it_comes, turned, other = peers.compare()
    assert turned.hook_loads == pytest.approx(mine.hook_loads, rel=0.03)
    assert other.hook_loads == pytest.approx(mine.hook_loads, rel=0.03)
    assert as_it_comes.hook_loads[2] == pytest.approx(mine.hook_loads[2], rel=0.03)


def test_welleng_equals_our_string_with_reversed_curvature():
    """What a build's sign does to hook loads; 652 and 360 kN are welleng 0.30's own figures for this well."""
    rig = peers.one_pipe(example_rig())
    mesh = build_mesh(rig, 200)
    bent = dataclasses.replace(mesh, vertical_curvature=-mesh.vertical_curvature)
    raised, lowered = (
        static_loads(rig, speed, friction_coefficient=peers.FRICTION, mesh=bent).hook_load for speed in (-1.0, 1.0)
    )
    assert (raised, lowered) == pytest.approx((652.0e3, 359.6e3), rel=0.003)


def test_published_run_has_its_size():
    rig = published.shortened(example_rig(), 2500.0)
    assert rig.string.length == pytest.approx(2500.0)
    assert [one.to for one in rig.well.friction_intervals][-1] == pytest.approx(2500.0)
    assert np.all(np.isfinite(simulate(rig, rocking_commands(rig, 1.0), elements=45).surface_torque))


def test_many_rigs_are_counted(monkeypatch):
    """Steps of all slots count, and every figure is there."""
    pytest.importorskip("gymnasium")
    for name, value in {"SLOTS": 4, "DRAWN": 2, "ELEMENTS": 20, "STEPS": 2, "REPEATS": 1, "_SINGLE_STEPS": 4}.items():
        monkeypatch.setattr(many_rigs, name, value)
    rows = many_rigs.environment_rates()
    assert len({row.name for row in rows}) == 4 and all(row.value > 0.0 for row in rows)
