"""ROS tests that meet neither each other nor anything else on the machine."""

import os
import uuid

import pytest

pytest.importorskip("rclpy", reason="no ROS 2: pip install '.[ros]' or source one")

from slider_drilling.nodes import environment

environment.prepare()


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes of this process see each other only."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))


@pytest.fixture
def namespace(monkeypatch: pytest.MonkeyPatch) -> str:
    """A namespace that nobody else has, for processes that have to find each other."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    return f"/rig_{uuid.uuid4().hex[:12]}"
