"""Time of the command `diagnose`."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import tempfile
from pathlib import Path

from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import wall_seconds
from slider_drilling.benchmarks.workload import rocking_commands
from slider_drilling.effects import Effects, Stribeck
from slider_drilling.rig.example import example_rig

DURATION = 300.0  # s of the log


def diagnose_time() -> BenchmarkResult:
    """Time to diagnose a log of the example rig with an effect that its rig file lacks."""
    from slider_drilling.drillstring import simulate

    rig = example_rig()
    commands = rocking_commands(rig, DURATION)
    simulate(rig, rocking_commands(rig, 1.0))
    once = wall_seconds(lambda: simulate(rig, commands), 3)
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "stribeck.mcap"
        write_log(log)
        taken = wall_seconds(lambda: _diagnose(log, folder), 1)
    return BenchmarkResult("diagnose_s", taken, "s", once, "one simulation of the log on one core",
                  f"{DURATION:.0f} s of log, Stribeck friction unknown to the rig file, all cores")  # fmt: skip


def write_log(path: Path, duration: float = DURATION) -> None:
    """Record ``duration`` s of a virtual rig with Stribeck friction; the rig file in the log does not have it."""
    from slider_drilling.control import FixedRocking
    from slider_drilling.drillstring import VirtualRig
    from slider_drilling.log import LogWriter
    from slider_drilling.rig import dump_rig

    nominal = example_rig()
    real = dataclasses.replace(nominal, effects=Effects(stribeck=Stribeck(drop=0.4)))
    virtual, controller = VirtualRig(real, seed=1), FixedRocking(nominal)
    with LogWriter(path, dump_rig(nominal), "slider_drilling bench") as writer:
        for _ in range(round(duration * nominal.sensors.rate)):
            now = virtual.measurements
            writer.joint_state("top_drive/joint_states", now.time, "top_drive", now.top_drive_angle,
                               now.top_drive_speed, now.surface_torque)  # fmt: skip
            writer.joint_state("draw_works/joint_states", now.time, "draw_works", now.block_position,
                               now.block_speed, now.hook_load)  # fmt: skip
            writer.joint_state("mud_pump/joint_states", now.time, "mud_pump", None, now.pump_speed)
            noise = nominal.sensors.standpipe_pressure.noise
            writer.fluid_pressure("standpipe_pressure", now.time, now.standpipe_pressure, noise * noise)
            for sample in now.mwd:
                writer.joint_state("mwd/tool_face", sample.measured_at, "mwd", sample.tool_face,
                                   log_time_s=sample.arrived_at)
            virtual.step(controller.step(now))


def _diagnose(log: Path, folder: str) -> None:
    command = [sys.executable, "-m", "slider_drilling", "diagnose", str(log), "-o", folder]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr.strip()[-500:]}")
