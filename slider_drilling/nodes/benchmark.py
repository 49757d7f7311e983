"""The benchmarks that need DDS, in a process of their own: `python -m slider_drilling.nodes.benchmark NAME`.

NAME is `closed_loop`, `recorder` or `start`. Prints one JSON object.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from slider_drilling.benchmarks.machine import peak_megabytes
from slider_drilling.nodes import environment
from slider_drilling.process.parent_death import interrupt_with_parent

DURATION = 120.0  # simulated s of the closed loop
MESSAGES, BURST = 20_000, 50


def closed_loop() -> dict[str, float | None]:
    """Simulator, controller and recorder over DDS in lockstep: speed, and messages in the log per second."""
    from slider_drilling.nodes.session import SessionOptions, run_session

    with tempfile.TemporaryDirectory() as folder:
        outcome = run_session(SessionOptions(duration=DURATION, record=Path(folder)))
    rate = outcome.messages / outcome.wall
    return {"factor": outcome.simulated / outcome.wall, "messages_per_s": rate, "peak_megabytes": peak_megabytes()}


def recorder() -> dict[str, float]:
    """Messages per second from a publisher over DDS into a log, without a loss."""
    import rclpy
    from rclpy.node import Node
    from rclpy.parameter import Parameter

    from slider_drilling.messages import cdr
    from slider_drilling.messages.topics import TOPICS
    from slider_drilling.nodes import raw_topics
    from slider_drilling.nodes.recorder import Recorder
    from slider_drilling.nodes.spin import make_executor

    with tempfile.TemporaryDirectory() as folder:
        rclpy.init()
        node = Node("benchmark")
        recording = Recorder(parameter_overrides=[Parameter("directory", value=folder)])
        publisher = raw_topics.publisher(node, TOPICS["top_drive"])
        executor = make_executor()
        executor.add_node(recording)
        while publisher.get_subscription_count() == 0:
            executor.spin_once(timeout_sec=0.01)
        start_time = time.perf_counter()
        for sent in range(BURST, MESSAGES + 1, BURST):
            for k in range(sent - BURST, sent):
                publisher.publish(cdr.encode_joint_state(k * 1_000_000, "top_drive", 1.0, 2.0, 3.0))
            while recording.messages < sent:
                executor.spin_once(timeout_sec=1.0)
        wall = time.perf_counter() - start_time
        recording.close()
        rclpy.try_shutdown()
    return {"messages_per_s": MESSAGES / wall, "lost": float(recording.lost)}


def start() -> dict[str, float | None]:
    """Start a friction simulator; the caller times the process."""
    from slider_drilling.nodes.friction_simulator import FrictionSimulator
    from slider_drilling.nodes.run_node import init

    init(["slider-drilling"])
    FrictionSimulator()
    return {"peak_megabytes": peak_megabytes()}


def main(name: str) -> None:
    """Run a benchmark and print its result."""
    environment.prepare()
    interrupt_with_parent()
    # A ROS domain of its own, so that other nodes on this machine take no part.
    os.environ["ROS_DOMAIN_ID"] = str(100 + os.getpid() % 100)
    measures: dict[str, Any] = {"closed_loop": closed_loop, "recorder": recorder, "start": start}
    print(json.dumps(measures[name]()))


if __name__ == "__main__":
    main(sys.argv[1])
