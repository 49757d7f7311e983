"""What recorder and nodes endure, as processes of their own: `python test/nodes/endurance.py WHAT`.

    topics      20 topics, 1 kHz together, for a minute: messages lost
    ceiling     ever more messages a second on 20 topics: what is recorded of them
    kills       a recorder killed at 20 random moments: seconds of the log lost
    restarts    each node killed and started again in real time: seconds until it is back
    two_rigs    two rigs in one graph for ten minutes of the wall's clock: steps back of their logs' time

Prints one line a figure. Times are of the machine as it is: on a busy one they say so of it, not of the nodes.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from node_process import DEADLINE, NodeProcess

from slider_drilling.nodes import environment

TOPICS = 20
RATES = (1_000, 2_000, 4_000, 6_000, 8_000, 10_000, 12_000, 16_000, 20_000)  # 1/s of all topics together
TICK = 0.005  # s between two bursts of the sender


def program(name: str, space: str, **parameters: object) -> NodeProcess:
    """A node as `ros2 run` starts it."""
    return NodeProcess(name, space, Path.cwd(), **parameters)


def ended(node: NodeProcess) -> None:
    """End it in order. Raises RuntimeError where it does not end so."""
    node.process.send_signal(signal.SIGINT)
    if code := node.end():
        raise RuntimeError(f"{node.name}: exit code {code}; said: {node.output}")


def awaited(has_happened: Callable[[], bool], what: str) -> float:
    """Seconds until it has. Raises RuntimeError where it never does."""
    started = time.monotonic()
    while not has_happened():
        if time.monotonic() - started > DEADLINE:
            raise RuntimeError(f"waited {DEADLINE:g} s for {what}")
        time.sleep(0.002)
    return time.monotonic() - started


def send(space: str, rate: float, seconds: float) -> None:
    """The sender's process: joint states on TOPICS topics, stamped with the wall's clock; prints how many it sent."""
    import rclpy
    from rclpy.node import Node

    from slider_drilling.messages import cdr
    from slider_drilling.messages.topics import JOINT_STATE, Topic
    from slider_drilling.nodes import raw_topics

    rclpy.init(args=[])
    node = Node("sender", namespace=space)
    out = [raw_topics.publisher(node, Topic(f"load/t{k:02}", JOINT_STATE, "load")) for k in range(TOPICS)]
    awaited(lambda: all(one.get_subscription_count() for one in out), "the recorder")
    started, sent = time.monotonic(), 0
    while (passed := time.monotonic() - started) < seconds:
        for _ in range(int(passed * rate) - sent):
            out[sent % TOPICS].publish(cdr.encode_joint_state(time.time_ns(), "load", float(sent)))
            sent += 1
        time.sleep(TICK)
    print(sent, passed, flush=True)
    raw_topics.flush(node, DEADLINE)


@dataclass(frozen=True)
class Load:
    """asked, sent: messages a second; lost: messages; counted: those of them that the recorder knows of."""

    asked: float
    sent: float
    messages: int
    lost: int
    counted: int


def load(rate: float, seconds: float) -> Load:
    """Send and record."""
    from slider_drilling.log.info import log_info

    space = f"/load_{os.getpid()}"
    with tempfile.TemporaryDirectory() as folder:
        recorder = program("recorder", space, directory=folder, file="load.mcap", regex=f"{space}/load/.*")
        sender = subprocess.run(
            [
                sys.executable,
                __file__,
                "send",
                "--space",
                space,
                "--rate",
                str(rate),
                "--seconds",
                str(seconds),
            ],
            capture_output=True,
            text=True,
            check=True,
        )
        sent, passed = map(float, sender.stdout.split())
        ended(recorder)
        found = [one for one in log_info(Path(folder)).topics if "/load/" in one.topic]
    recorded = sum(one.messages for one in found)
    return Load(rate, sent / passed, int(sent), int(sent) - recorded, sum(one.lost for one in found))


def topics() -> None:
    """A minute of a thousand messages a second."""
    print_load(load(1000.0, 60.0))


def ceiling() -> None:
    """Five seconds at each rate, until messages are lost."""
    for rate in RATES:
        found = load(rate, 5.0)
        print_load(found)
        if found.lost:
            return


def print_load(one: Load) -> None:
    """One line."""
    print(
        f"{TOPICS} topics, {one.sent:.0f} messages a second together ({one.asked:.0f} asked for): {one.messages} "
        f"sent, {one.lost} lost, {one.counted} counted as lost",
        flush=True,
    )


def kills() -> None:
    """Seconds between a kill and the last message that the log holds, by the wall's clock."""
    from slider_drilling.log.info import log_info

    lost = []
    for case in range(20):
        draw = random.Random(f"kill {case}")
        with tempfile.TemporaryDirectory() as folder:
            space = f"/kill_{os.getpid()}_{case}"
            recorder = program("recorder", space, directory=folder, file="a.mcap")
            sender = program("friction_simulator", space, elements=20, speed=1.0)
            path = Path(folder) / "a.mcap"
            awaited(lambda path=path: path.exists() and path.stat().st_size > 40_000, "a log")  # type: ignore[misc]
            time.sleep(draw.uniform(0.0, 2.0))
            at = time.time()
            recorder.kill()
            sender.kill()
            info = log_info(path)
            lost.append(at - (info.start_ns / 1e9 + info.seconds))
            print(f"killed with {path.stat().st_size} bytes: {lost[-1]:.2f} s lost", flush=True)
    print(f"{len(lost)} kills: {np.median(lost):.2f} s lost in the middle, {max(lost):.2f} s at the most")


def restarts() -> None:
    """Kill one node of a rig in real time and start it again at once: how long commands, or the log, are missing."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node

    from slider_drilling.log.info import log_info
    from slider_drilling.messages.topics import TOPICS as RIG
    from slider_drilling.nodes import raw_topics

    space, heard = f"/restart_{os.getpid()}", [0.0]
    rclpy.init(args=[])
    node = Node("listener", namespace=space)
    raw_topics.subscription(node, RIG["top_drive_command"], lambda data: heard.append(time.monotonic()))
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def another_command() -> bool:
        before = len(heard)
        executor.spin_once(timeout_sec=0.01)
        return len(heard) > before

    with tempfile.TemporaryDirectory() as folder:
        of = {
            "rocking_controller": {"use_sim_time": True},
            "recorder": {"directory": folder},
            "friction_simulator": {"elements": 20, "speed": 1.0, "wait_for_controller": True},
        }
        there = {name: program(name, space, **parameters) for name, parameters in of.items()}
        awaited(lambda: another_command() and len(heard) > 20, "commands")
        for name in of:
            there[name].kill()
            while another_command() and name != "recorder":
                pass  # what was still on its way
            last = heard[-1]
            there[name] = program(name, space, **of[name])
            if name == "recorder":
                awaited(lambda: len(list(Path(folder).rglob("*.mcap"))) == 2, "a second log")
                awaited(
                    lambda: max(path.stat().st_mtime for path in Path(folder).rglob("*.mcap")) > time.time() - 0.5,
                    "it to grow",
                )
                time.sleep(3.0)
            else:
                awaited(another_command, "the next command")
                print(f"{name} killed and started again: {heard[-1] - last:.2f} s without a command", flush=True)
        for name in ("recorder", "rocking_controller", "friction_simulator"):
            ended(there[name])
        first, second = sorted((log_info(path) for path in Path(folder).rglob("*.mcap")), key=lambda one: one.start_ns)
        missing = second.start_ns / 1e9 - (first.start_ns / 1e9 + first.seconds)
        print(f"recorder killed and started again: {missing:.2f} s in no log")
    rclpy.try_shutdown()


def two_rigs() -> None:
    """Six processes for ten minutes."""
    from slider_drilling.log import read_log
    from slider_drilling.log.info import log_info

    with tempfile.TemporaryDirectory() as folder:
        simulators, others = {}, []
        for rig, begins in (("a", 0.0), ("b", 5000.0)):
            space = f"/two_{os.getpid()}/{rig}"
            others += [
                program("rocking_controller", space, use_sim_time=True),
                program("recorder", space, directory=f"{folder}/{rig}", use_sim_time=True),
            ]
            simulators[rig] = program(
                "friction_simulator",
                space,
                elements=20,
                speed=1.0,
                duration=600.0,
                start_time=begins,
                wait_for_controller=True,
                minimum_subscribers=2,
            )
        for one in simulators.values():
            one.process.wait(900.0)
        for one in others:
            ended(one)
        for rig in simulators:
            info, log = log_info(Path(folder) / rig), read_log(Path(folder) / rig)
            late = np.abs(log.top_drive.arrival - log.top_drive.time).max()  # type: ignore[union-attr]
            print(
                f"rig {rig}: {info.seconds:.1f} s in the log, {sum(one.clock_back for one in info.topics)} steps "
                f"back of a stamp, {late:.2f} s from stamp to arrival at the most, notes: {list(log.notes)}"
            )


WHAT = {"topics": topics, "ceiling": ceiling, "kills": kills, "restarts": restarts, "two_rigs": two_rigs}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=[*WHAT, "send"])
    parser.add_argument("--space", default="")
    parser.add_argument("--rate", type=float, default=0.0)
    parser.add_argument("--seconds", type=float, default=0.0)
    given = parser.parse_args()
    environment.prepare()
    os.environ.setdefault("ROS_DOMAIN_ID", str(100 + os.getpid() % 100))
    if given.what == "send":
        send(given.space, given.rate, given.seconds)
    else:
        WHAT[given.what]()
