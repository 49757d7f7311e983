"""The dashboard in a running graph: it shows the topics and forwards requests to the nodes."""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("nicegui", reason="no NiceGUI: pip install '.[live]'")

import rclpy
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from turning import turn

from slider_drilling.errors import InputError
from slider_drilling.live import server as serve
from slider_drilling.live.page_requests import RequestQueue, SetParameter, SetRecording, SetRocking, SetTarget
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.log import read_log
from slider_drilling.nodes import dashboard, raw_topics
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.units import Units


class NoServer:
    """Replaces the web server."""

    def __init__(self, state: LiveState, requests: RequestQueue, address: serve.Address, units: Units) -> None:
        self.url, self.token = "http://127.0.0.1:0/", None

    def stop(self) -> None:
        pass


@pytest.fixture
def graph(alone: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Node]]:
    """Dashboard, simulator and controller at ten times real time."""
    monkeypatch.setattr(dashboard, "PageServer", NoServer)
    monkeypatch.setattr(dashboard, "PARAMETER_PERIOD", 0.2)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    made = [
        dashboard.Dashboard(ShutdownRequest()),
        FrictionSimulator(ShutdownRequest(), parameter_overrides=[
            Parameter("speed", value=10.0), Parameter("elements", value=20), Parameter("minimum_subscribers", value=2),
            Parameter("wait_for_controller", value=True)]),
        RockingController(ShutdownRequest(), parameter_overrides=[Parameter("tool_face_target", value=0.5)]),
    ]  # fmt: skip
    yield made
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown()


def test_page_shows_graph_and_changes_it(graph: list[Node]) -> None:
    board, _, controller = graph
    state, requests = board.state, board.requests
    notices = state.notices_after

    def notice(text: str) -> Callable[[], bool]:
        return lambda: any(text in one.text for one in notices(0))

    turn(
        graph,
        lambda: len(state.samples_after(0)[0]) > 150,
        lambda: len(state.tool_faces()) > 0,
        lambda: any(one.name == "gain" for one in state.parameters()),
        lambda: state.status_value("reach", "amplitude_rad") is not None,
    )
    rows = state.samples_after(0)[0]
    assert max(abs(row.surface_torque) for row in rows) > 1e3
    assert all(abs(row.differential_pressure) < 2e6 for row in rows[20:])
    assert state.target == 0.5 and state.truth is not None
    assert state.rig is not None and state.rig.string.length == 4000.0
    gain = next(one for one in state.parameters() if one.name == "gain")
    assert (gain.value, gain.low, gain.high, gain.unit) == (4.5, 0.0, 8.0, "-")
    requests.put(SetTarget(-1.0))
    requests.put(SetParameter("rocking_controller", "gain", 1.5))
    requests.put(SetParameter("rocking_controller", "gain", 99.0))
    expected = notice("target -57.3 deg"), notice("gain = 1.5"), notice("gain = 99: refused")
    turn(graph, *expected, lambda: state.target == -1.0)
    assert controller.get_parameter("gain").value == 1.5
    assert controller.get_parameter("tool_face_target").value == -1.0
    requests.put(SetRocking(False))
    turn(graph, notice("stop rocking: "), lambda: controller.get_parameter("rocking").value == 0.0)
    requests.put(SetRocking(True))
    turn(graph, lambda: controller.get_parameter("rocking").value == 1.0)
    assert all(math.isfinite(one.value) for one in state.parameters())


def test_page_pauses_and_resumes_recording(graph: list[Node], tmp_path: Path) -> None:
    recorder = Recorder(ShutdownRequest(), parameter_overrides=[Parameter("directory", value=str(tmp_path))])
    graph.append(recorder)
    state, requests = graph[0].state, graph[0].requests
    turn(graph, lambda: state.recording is True)
    for on in (False, True):
        requests.put(SetRecording(on))
        turn(graph, lambda: state.recording is on)  # noqa: B023
    # The recorder's status may come before its answer.
    turn(graph, lambda: len(state.notices_after(0)) >= 2)
    assert [one.text for one in state.notices_after(0)] == ["pause: paused", "resume: recording"]
    recorder.discard()


@pytest.mark.parametrize("answer", ["raises", "lacks values", "is empty"])
def test_unusable_answers_leave_the_page_alive(answer: str, graph: list[Node], capfd: pytest.CaptureFixture) -> None:
    """What a node answers whose settings vanish: in the experimental executor an exception there is a crash."""
    board = graph[0]

    class Client:
        def service_is_ready(self) -> bool:
            return True

        def call_async(self, request: object) -> rclpy.task.Future:
            future = rclpy.task.Future()
            if answer == "raises":
                future.set_exception(RuntimeError("the service is gone"))
            else:
                future.set_result(None if answer == "is empty" else type("A", (), {"values": [], "results": []})())
            return future

    board.create_client = lambda kind, service: Client()
    board._clients_by_service.clear()
    board._set_parameter("rocking_controller", "gain", 1.0, "gain = 1")
    board._trigger("rocking_controller/stop_rocking")
    board._read_parameters()
    said = capfd.readouterr().err
    assert "the answer of rocking_controller/set_parameters: cannot be used" in said


def test_page_survives_deactivation_and_cleanup(graph: list[Node]) -> None:
    board, _, controller = graph
    state = board.state
    turn(graph, lambda: any(one.name == "gain" for one in state.parameters()))
    controller.trigger_deactivate()
    controller.trigger_cleanup()
    listed: list[str] = []
    on_names = board._on_names
    board._on_names = lambda node, answer: (listed.append(node), on_names(node, answer))
    board.requests.put(SetParameter("rocking_controller", "gain", 1.5))
    turn(
        graph,
        lambda: any(one.text.startswith("gain = 1.5: refused") for one in state.notices_after(0)),
        lambda: "rocking_controller" in listed,  # read anew: what the page knew is gone
    )
    controller.trigger_configure()
    controller.trigger_activate()
    board.requests.put(SetParameter("rocking_controller", "gain", 1.25))
    turn(graph, lambda: controller.get_parameter("gain").value == 1.25)


def test_missing_service_gives_a_notice(graph: list[Node]) -> None:
    board = graph[0]
    board.requests.put(SetRecording(True))
    turn([board], lambda: board.state.last_notice == 1)
    (notice,) = board.state.notices_after(0)
    assert (notice.text, notice.success) == ("recorder/resume: no node offers it", False)


def test_run_with_a_live_page(
    namespace: str, repository: Path, tmp_path: Path, wait_for_bytes: Callable[..., Path]
) -> None:
    command = [
        sys.executable,
        "-m",
        "slider_drilling",
        "run",
        "--live",
        "--live-port",
        "0",
        "--speed",
        "10",
        "--target",
        "30",
        "--record",
        str(tmp_path / "out"),
        "--elements",
        "20",
    ]
    with subprocess.Popen(
        command, cwd=repository, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    ) as process:
        assert process.stderr is not None
        url = ""
        for line in process.stderr:
            url = url or "".join(re.findall(r"^live page: (\S+)", line))
            if "sliding" in line:
                break
        wait_for_bytes(tmp_path / "out", 20_000, process)
        page = urllib.request.urlopen(url).read().decode()
        assert "Slide drilling" in page
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(urllib.request.Request(url, headers={"Origin": "http://evil.example"}))
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=100)
    assert process.returncode == 130, error
    assert "wrote" in out
    (log,) = (tmp_path / "out").glob("*.mcap")
    assert read_log(log).tool_face_target.position[0] == pytest.approx(math.radians(30.0))


def test_token_is_in_its_file_only(start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listener) -> None:
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "logs"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    said: list[str] = []
    hear = said.append
    listener.node.create_subscription(Log, "/rosout", lambda message: hear(message.msg), raw_topics.LATCHED_WORDS)
    program = start("dashboard", new_interpreter=True, host="0.0.0.0", port=0)
    program.wait_for("live page: ")
    (path,) = re.findall(r"\?token=\$\(cat (\S+)\)", program.output)
    token = Path(path).read_text().strip()
    assert len(token) == 32
    listener.until(lambda: any("live page: " in text for text in said), "/rosout")
    command_line = Path(f"/proc/{program.process.pid}/cmdline").read_text()
    program.process.send_signal(signal.SIGINT)
    assert program.end() == 0, program.output
    logs = "".join(file.read_text() for file in (tmp_path / "logs").rglob("*") if file.is_file())
    assert "live page: " in logs
    for text in (program.output, logs, command_line, *said):
        assert token not in text
    assert not Path(path).exists()


def test_interrupted_start_leaves_no_token_file(
    start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listener
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    program = start("dashboard", host="0.0.0.0", port=0)
    listener.until(lambda: bool(list(tmp_path.glob("slider_drilling_token_*"))), "the token file")
    program.process.send_signal(signal.SIGINT)
    assert program.end() == 0, program.output
    assert not list(tmp_path.glob("slider_drilling_token_*"))


def test_taken_port_is_refused(namespace: str) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match="choose another"):
            serve._listen(serve.Address(port=taken.getsockname()[1]))


def test_notice_of_a_parameter_has_its_unit() -> None:
    pressure = LiveParameter("rocking_controller", "off_bottom_pressure", 0.0, "Pa", 0.0, 1e8, "")
    change = SetParameter("rocking_controller", "off_bottom_pressure", 1.799e7)
    assert dashboard._change(change, [pressure]) == "off_bottom_pressure = 179.9 bar"
    assert dashboard._change(SetParameter("rocking_controller", "gain", 99.0), []) == "gain = 99"
