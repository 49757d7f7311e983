"""Speed of the closed loop over DDS and of the recorder, each in its own process."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import wall_seconds
from slider_drilling.process.parent_death import PARENT_PID_VARIABLE
from slider_drilling.rig.example import example_rig

TIMEOUT = 600.0
NO_ROS = "not available: ROS 2 is not installed (pip install 'slider_drilling[ros]', or source a ROS 2 Jazzy)"


def ros_is_there() -> bool:
    """Whether ROS 2 is installed."""
    return importlib.util.find_spec("rclpy") is not None


def session_rates() -> list[BenchmarkResult]:
    """Real-time factor of the closed loop with the recorder on, and throughput of the recorder."""
    if not ros_is_there():
        units = {"closed_loop_real_time_factor": "-", "recorder_messages_per_s": "1/s", "closed_loop_peak_memory": "MB"}
        return [BenchmarkResult(name, None, unit, note=NO_ROS) for name, unit in units.items()]
    closed, recorded = run_benchmark("closed_loop"), run_benchmark("recorder")
    return [
        BenchmarkResult("closed_loop_real_time_factor", closed["factor"], "-", _without_topics(),
               "the same rig and controller without topics and log",
               "200 elements, 10 Hz, lockstep over DDS, recorder on, three nodes in one process"),
        BenchmarkResult("recorder_messages_per_s", recorded["messages_per_s"], "1/s", _without_dds(),
               "the same messages written without DDS",
               f"one publisher, one core, {recorded['lost']:.0f} lost; "
               f"{closed['messages_per_s']:.0f} a second in the closed loop"),
        BenchmarkResult("closed_loop_peak_memory", closed["peak_megabytes"], "MB"),
    ]  # fmt: skip


def node_start() -> BenchmarkResult:
    """Start time of the friction simulator with compiled code in the cache."""
    if not ros_is_there():
        return BenchmarkResult("node_start_s", None, "s", note=NO_ROS)
    run_benchmark("start")
    return BenchmarkResult("node_start_s", wall_seconds(lambda: run_benchmark("start"), 3), "s",
                  note="friction_simulator, code compiled before")  # fmt: skip


def run_benchmark(what: str) -> dict[str, float]:
    """Run a benchmark process and read the figures that it prints; its files are deleted."""
    command = [sys.executable, "-m", "slider_drilling.nodes.benchmark", what]
    with tempfile.TemporaryDirectory() as scratch:
        own = {"TMPDIR": scratch, PARENT_PID_VARIABLE: str(os.getpid())}
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False,
                              env={**os.environ, **own})  # fmt: skip
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr.strip()[-500:]}")
    figures: dict[str, float] = json.loads(done.stdout.strip().splitlines()[-1])
    return figures


def _without_topics() -> float:
    """Real-time factor of virtual rig and controller without topics."""
    from slider_drilling.control import FixedRocking
    from slider_drilling.drillstring import VirtualRig

    rig = example_rig()
    virtual, controller = VirtualRig(rig), FixedRocking(rig)

    def simulate() -> None:
        for _ in range(round(60.0 * rig.sensors.rate)):
            virtual.step(controller.step(virtual.measurements))

    return 60.0 / wall_seconds(simulate, 3)


def _without_dds() -> float:
    """Messages per second that the log writer takes without DDS."""
    from slider_drilling.log import LogWriter
    from slider_drilling.messages import cdr
    from slider_drilling.messages.topics import JOINT_STATE

    count = 20_000
    with tempfile.TemporaryDirectory() as folder, LogWriter(Path(folder) / "bench.mcap") as writer:
        start = time.perf_counter()
        for k in range(count):
            stamp = k * 1_000_000
            data = cdr.encode_joint_state(stamp, "top_drive", 1.0, 2.0, 3.0)
            writer.message("top_drive/joint_states", JOINT_STATE, data, stamp, stamp)
        return count / (time.perf_counter() - start)
