"""The example bridge against an asyncua server: a rig's values on topics, commands only if enabled."""

import asyncio
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest
import yaml

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics

asyncua = pytest.importorskip("asyncua")
ua = asyncua.ua

BAD = 0x80310000  # BadNoCommunication
VALUES = {
    "TopDrive.Angle": 180.0,
    "TopDrive.Speed": 30.0,
    "TopDrive.Torque": 5.0,
    "DrawWorks.Lowered": 1.5,
    "DrawWorks.Speed": 9.0,
    "DrawWorks.HookLoad": 900.0,
    "Mud.StandpipePressure": 180.0,
    "Mud.PumpSpeed": 60.0,
    "Mwd.ToolFace": 45.0,
}
WANTED = ("TopDrive.AngleWanted", "TopDrive.SpeedWanted", "DrawWorks.SpeedWanted", "Mud.PumpSpeedWanted")


class RigServer:
    """An OPC UA server with a rig's nodes, in a thread of its own; the heartbeat counts while `alive`."""

    def __init__(self) -> None:
        self.url = ""
        self.alive = True
        self._ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._thread = threading.Thread(target=lambda: self._loop.run_until_complete(self._serve()), daemon=True)
        self._thread.start()
        assert self._ready.wait(100.0)

    async def _serve(self) -> None:
        self._server = asyncua.Server()
        await self._server.init()
        self._server.set_endpoint("opc.tcp://127.0.0.1:0/rig/")
        self._server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        index = await self._server.register_namespace("rig")
        assert index == 2
        objects = self._server.nodes.objects
        self._nodes = {}
        for name, value in {**VALUES, **dict.fromkeys(WANTED, 0.0), "Heartbeat": 0.0}.items():
            self._nodes[name] = await objects.add_variable(ua.NodeId(name, 2), name, value)
            await self._nodes[name].set_writable()
        await self._server.start()
        port = self._server.bserver._server.sockets[0].getsockname()[1]
        self.url = f"opc.tcp://127.0.0.1:{port}/rig/"
        self._ready.set()
        beat = 0.0
        while not self._end.is_set():
            beat += self.alive
            await self._nodes["Heartbeat"].write_value(beat)
            await asyncio.sleep(0.1)
        await self._server.stop()

    def _run(self, work):
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(30.0)

    def read(self, name: str) -> float:
        return self._run(self._nodes[name].read_value())

    def spoil(self, name: str) -> None:
        """A value of bad quality, as of a sensor that is off."""
        self._run(
            self._nodes[name].write_value(ua.DataValue(ua.Variant(1.0, ua.VariantType.Double), ua.StatusCode(BAD)))
        )

    def mend(self) -> None:
        """As at the start."""
        self.alive = True
        for name, value in {**VALUES, **dict.fromkeys(WANTED, 0.0)}.items():
            self._run(self._nodes[name].write_value(value))

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(30.0)


@pytest.fixture(scope="module")
def server() -> Iterator[RigServer]:
    made = RigServer()
    yield made
    made.close()


@pytest.fixture
def bridge(namespace, repository, tmp_path):
    """Starts the example with its own mapping, some keys changed."""
    examples = repository / "docs" / "examples"
    started = []

    def start(*arguments: str, **changed: object) -> subprocess.Popen:
        mapping = yaml.safe_load((examples / "opcua_rig.yaml").read_text()) | changed
        (tmp_path / "rig.yaml").write_text(yaml.safe_dump(mapping))
        command = [
            sys.executable,
            str(examples / "opcua_bridge.py"),
            str(tmp_path / "rig.yaml"),
            *arguments,
            "--ros-args",
            "-r",
            f"__ns:={namespace}",
        ]
        environment = os.environ | {"PYTHONPATH": str(repository)}
        started.append(subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True))
        return started[-1]

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
            process.wait()


def test_bridge_publishes_values_in_si(server, bridge, listener):
    process = bridge(url=server.url)
    listener.until(lambda: len(listener.heard["top_drive"]) > 2 and bool(listener.heard["draw_works"]), "samples")
    stamp, *top_drive = listener.heard["top_drive"][-1]
    assert top_drive == pytest.approx([3.14159265, 3.14159265, 5000.0])
    assert listener.heard["draw_works"][-1][1:] == pytest.approx((1.5, 0.0025, 9e5))
    assert listener.heard["mud_pump"][-1][2] == pytest.approx(6.2831853)
    listener.until(lambda: any(block[0] == stamp for block in listener.heard["draw_works"]), "one stamp a sample")
    server.spoil("TopDrive.Torque")
    listener.until(
        lambda: listener.heard["top_drive"][-1][3] != listener.heard["top_drive"][-1][3], "NaN where quality is bad"
    )
    server.alive = False

    def is_silent() -> bool:
        count = len(listener.heard["draw_works"])
        listener.listen(0.5)
        return len(listener.heard["draw_works"]) == count

    listener.until(is_silent, "a dead rig's values are not given on")
    server.mend()
    process.send_signal(signal.SIGINT)
    assert process.wait(30.0) == 0


@pytest.mark.parametrize("switch", [[], ["--command"]], ids=["read only", "commands"])
def test_bridge_writes_commands_only_if_enabled(switch, server, bridge, listener):
    bridge(*switch, url=server.url)
    listener.until(lambda: bool(listener.heard["top_drive"]), "samples")
    command = raw_topics.publisher(listener.node, TOPICS["top_drive_command"])
    if switch:
        listener.until(lambda: command.get_subscription_count() == 2, "the bridge listens")  # and the listener itself

    def say() -> bool:
        command.publish(cdr.encode_joint_state(0, "top_drive", 1.0, 0.5))
        listener.listen(0.05)
        return server.read("TopDrive.AngleWanted") != 0.0 or (
            not switch and len(listener.heard["top_drive_command"]) > 20
        )

    listener.until(say, "the command")
    assert server.read("TopDrive.AngleWanted") == pytest.approx(57.29578 if switch else 0.0)
    assert command.get_subscription_count() == (2 if switch else 1)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"url": "opc.tcp://127.0.0.1:1/"}, "opc.tcp://127.0.0.1:1/: "),
        ({"read": {"torque": {"node": "x", "unit": "N m"}}}, "read: unknown torque; known are top_drive_angle"),
        ({"read": {"hook_load": {"node": "x", "unit": "bar"}}}, "read.hook_load: unit = 'bar': is a unit of pressure"),
        ({"period": 0.0}, "period = 0.0 s: must be within"),
    ],
)
def test_mistake_is_one_line_and_exit_code_2(change, expected, bridge):
    process = bridge(**change)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode == 2, said
    (line,) = [line for line in said.splitlines() if line.strip() and not line.startswith("[INFO]")]
    assert expected in line
