"""ROS tests whose nodes see neither each other nor other programs on the machine."""

import os
import subprocess
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2: pip install '.[ros]' or source one")

import rclpy
from listener import Listener
from node_process import NodeProcess
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from recorder_bench import Bench

from slider_drilling.nodes import environment
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.shutdown import ShutdownRequest

environment.prepare()


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes of this process see each other only."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))


@pytest.fixture
def make(alone: None) -> Iterator[Callable[..., Node]]:
    """Makes nodes, with parameters, that are gone after the test."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    made: list[Node] = []

    def make_one(kind: Callable[..., Node], **parameters: object) -> Node:
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        made.append(kind(ShutdownRequest(), parameter_overrides=overrides))
        return made[-1]

    yield make_one
    for node in made:
        if isinstance(node, Recorder):
            node.discard()
        node.destroy_node()
    rclpy.try_shutdown()


@pytest.fixture
def namespace(monkeypatch: pytest.MonkeyPatch) -> str:
    """A namespace that nobody else has, for processes that have to find each other."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    return f"/rig_{uuid.uuid4().hex[:12]}"


@pytest.fixture
def bench(alone: None) -> Iterator[Callable[..., Bench]]:
    """Makes recorders with nodes beside them."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield Bench
    rclpy.try_shutdown()


@pytest.fixture
def wait_for_bytes() -> Callable[[Path, int, subprocess.Popen], Path]:
    """Waits until a recording process has written so much into a folder; gives the file that it is writing."""

    def wait(folder: Path, size: int, process: subprocess.Popen) -> Path:
        end = time.monotonic() + 100.0
        while time.monotonic() < end and process.poll() is None:
            for path in folder.rglob("*.mcap"):
                if path.stat().st_size >= size:
                    return path
            time.sleep(0.02)
        there = [path.name for path in folder.iterdir()]
        raise AssertionError(f"no log of {size} bytes in {folder}: {there}; exit code {process.poll()}")

    return wait


@pytest.fixture
def started() -> Iterator[list[NodeProcess]]:
    """The programs of a test; what is still there at the end is killed."""
    programs: list[NodeProcess] = []
    yield programs
    for program in programs:
        if program.process.poll() is None:
            program.kill()


@pytest.fixture
def start(namespace: str, tmp_path: Path, started: list[NodeProcess]) -> Callable[..., NodeProcess]:
    """Starts programs in one namespace; `new_interpreter` starts one as `ros2 run` does."""

    def start_one(name: str, within: str = "", new_interpreter: bool = False, **parameters: object) -> NodeProcess:
        started.append(NodeProcess(name, namespace + within, tmp_path, started, new_interpreter, **parameters))
        return started[-1]

    return start_one


@pytest.fixture
def listener(namespace: str, started: list[NodeProcess]) -> Iterator[Listener]:
    """Hears and says things in the namespace of the programs."""
    made = Listener(namespace, started)
    yield made
    made.close()
