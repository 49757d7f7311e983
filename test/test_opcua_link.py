"""The link to a real OPC UA server: dead rigs, unusable values, lost servers, and what is written at the end."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

pytest.importorskip("asyncua", reason="no asyncua: pip install '.[bridge]'")

from opcua_server import BAD_VALUE, NO_BEAT, WANTED, RigServer

from slider_drilling.errors import InputError
from slider_drilling.messages.health import Level
from slider_drilling.opcua.command_gate import CommandGate
from slider_drilling.opcua.link import Sample, ServerLink
from slider_drilling.opcua.mapping import RigMapping, load_mapping

EXAMPLE = Path(__file__).parents[1] / "config" / "opcua_rig.example.yaml"
DEADLINE = 60.0  # s, for anything that has to happen
LONG = 60.0  # s, a timeout that no test waits for: a starved server or controller must not look like a dead one
SHORT = 0.4  # s, a timeout that a test waits for


class Bridge:
    """A link with what it gave."""

    def __init__(self, mapping: RigMapping, command: bool) -> None:
        self.samples: list[Sample] = []
        self.errors: list[InputError] = []
        self.gate = CountingGate(mapping.write, mapping.command_timeout) if command else None
        self.link = ServerLink(mapping, self.gate, self.samples.append, self.errors.append)

    def say(self, **values: float) -> None:
        for name, value in values.items():
            self.gate.put({name: value}, time.monotonic())

    def status(self, name: str) -> tuple[int, str]:
        found = {status.name: (int(status.level), status.message) for status in self.link.statuses()}
        return found.get(name, (-1, ""))

    def take_what_was_said(self) -> None:
        """Wait until the link has taken all that was said, and has written what it writes of it.

        It takes and writes in turn: once it takes again, it has written what it took before.
        """
        before = self.gate.times_emptied + 1
        until(lambda: self.gate.times_emptied > before, "the link takes commands")

    def forget_controller_after(self, seconds: float) -> None:
        """Another command_timeout, s, from now on."""
        self.gate._timeout = seconds


class CountingGate(CommandGate):
    """Counts how often the link took or dropped what waited."""

    times_emptied = 0

    def take(self, now: float) -> dict[str, float]:
        self.times_emptied += 1
        return super().take(now)

    def drop(self) -> None:
        self.times_emptied += 1
        super().drop()


def until(happened: Callable[[], bool], why: str = "") -> None:
    end = time.monotonic() + DEADLINE
    while not happened():
        assert time.monotonic() < end, why
        time.sleep(0.01)


@pytest.fixture(scope="module")
def shared_server() -> Iterator[RigServer]:
    made = RigServer()
    yield made
    made.close()


@pytest.fixture
def server(shared_server: RigServer) -> RigServer:
    shared_server.mend()
    return shared_server


@pytest.fixture
def mapping_file(tmp_path: Path) -> Callable[..., Path]:
    """The example's mapping with some keys changed."""

    def write(**changed: object) -> Path:
        own = {"period": 0.02, "heartbeat_timeout": LONG, "command_timeout": LONG}
        tree = yaml.safe_load(EXAMPLE.read_text()) | own | changed
        (tmp_path / "rig.yaml").write_text(yaml.safe_dump(tree))
        return tmp_path / "rig.yaml"

    return write


@pytest.fixture
def start(mapping_file: Callable[..., Path]) -> Iterator[Callable[..., Bridge]]:
    made: list[Bridge] = []

    def start_one(url: str, command: bool = True, **changed: object) -> Bridge:
        made.append(Bridge(load_mapping(mapping_file(url=url, **changed)), command))
        return made[-1]

    yield start_one
    for bridge in made:
        bridge.link.stop()


def wanted(server: RigServer) -> list[float]:
    return [server.read(name) for name in WANTED]


def command_all(bridge: Bridge, server: RigServer) -> None:
    """Commands until the rig follows them."""

    def follows() -> bool:
        bridge.say(top_drive_angle=math.pi / 2.0, top_drive_speed=math.pi, block_speed=0.01, pump_speed=2.0 * math.pi)
        return wanted(server) == pytest.approx([90.0, 30.0, 36.0, 60.0])

    until(follows, "commands are written")


def test_samples_are_in_si_units(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url, command=False)
    until(lambda: len(bridge.samples) > 3)
    assert bridge.samples[-1].values == pytest.approx({
        "top_drive_angle": math.pi, "top_drive_speed": math.pi, "surface_torque": 5e3, "block_position": 1.5,
        "block_speed": 0.0025, "hook_load": 9e5, "standpipe_pressure": 1.8e7, "pump_speed": 2.0 * math.pi,
        "mwd_tool_face": math.pi / 4.0})  # fmt: skip
    assert bridge.samples[-1].mwd_time is not None
    assert bridge.status("heartbeat") == (Level.OK, "changes")


@pytest.mark.parametrize("value", ["off", None, math.nan, math.inf, True, [1.0, 2.0], b"\x00", "bad quality"])
def test_unusable_value_is_left_out(server: RigServer, start: Callable[..., Bridge], value: object) -> None:
    bridge = start(server.url)
    until(lambda: len(bridge.samples) > 2)
    if value == "bad quality":
        server.spoil("TopDrive.Torque")
    else:
        server.write("TopDrive.Torque", value)
    until(lambda: "surface_torque" not in bridge.samples[-1].values)
    assert bridge.samples[-1].values["hook_load"] == pytest.approx(9e5)
    assert bridge.status("values") == (Level.WARN, "not usable: surface_torque")
    command_all(bridge, server)
    assert not bridge.errors


@pytest.mark.parametrize("beat", [NO_BEAT, math.nan, None, "", BAD_VALUE])
def test_dead_heartbeat_stops_samples_and_commands(
    server: RigServer, start: Callable[..., Bridge], beat: object
) -> None:
    bridge = start(server.url, heartbeat_timeout=SHORT)
    command_all(bridge, server)
    server.alive, server.beat = False, beat
    until(lambda: bridge.status("heartbeat")[0] == Level.ERROR, "the heartbeat stands still")
    # The drives' speeds are zero for a rig that comes back; the pump and the angle are as they were.
    until(lambda: wanted(server)[1:3] == [0.0, 0.0], "the drives are stopped")
    count = len(bridge.samples)
    bridge.say(top_drive_angle=1.0, top_drive_speed=1.0, block_speed=1.0, pump_speed=1.0)
    bridge.take_what_was_said()
    assert wanted(server) == pytest.approx([90.0, 0.0, 0.0, 60.0])
    assert len(bridge.samples) == count
    server.mend()
    until(lambda: len(bridge.samples) > count, "the rig is back")
    bridge.forget_controller_after(SHORT)
    until(lambda: wanted(server) == pytest.approx([180.0, 0.0, 0.0, 0.0]), "held, stopped")
    bridge.take_what_was_said()
    assert wanted(server) == pytest.approx([180.0, 0.0, 0.0, 0.0]), "commands for the dead rig are forgotten"
    bridge.forget_controller_after(LONG)
    command_all(bridge, server)


def test_heartbeat_that_never_changed_is_dead(server: RigServer, start: Callable[..., Bridge]) -> None:
    server.beat = math.nan
    until(lambda: math.isnan(server.read("Heartbeat")), "the server shows it")
    bridge = start(server.url)
    until(lambda: bridge.status("server")[0] == Level.OK)
    bridge.say(block_speed=0.01)
    bridge.take_what_was_said()
    assert bridge.samples == [] and wanted(server) == [0.0] * 4


def test_end_stops_what_was_commanded(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url)
    command_all(bridge, server)
    bridge.link.stop()
    assert wanted(server) == pytest.approx([180.0, 0.0, 0.0, 60.0]), "held where it was, stopped, pump as it was"
    assert bridge.gate.commanding == []


def test_end_writes_nothing_that_was_not_commanded(server: RigServer, start: Callable[..., Bridge]) -> None:
    for name in WANTED:
        server.write(name, 7.0)
    bridge = start(server.url)
    until(lambda: len(bridge.samples) > 2)
    bridge.link.stop()
    assert wanted(server) == [7.0] * 4


def test_silent_controller_stops_the_drives(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url, command_timeout=SHORT)
    command_all(bridge, server)
    until(lambda: wanted(server) == pytest.approx([180.0, 0.0, 0.0, 60.0]), "stopped")
    assert bridge.status("heartbeat")[0] == Level.OK


def test_pump_is_stopped_only_if_asked(server: RigServer, start: Callable[..., Bridge]) -> None:
    write = yaml.safe_load(EXAMPLE.read_text())["write"]
    write["pump_speed"]["at_end"] = "zero"
    bridge = start(server.url, write=write)
    command_all(bridge, server)
    bridge.link.stop()
    assert wanted(server)[3] == 0.0


def test_command_of_several_values_is_refused_as_a_whole() -> None:
    mapping = load_mapping(EXAMPLE)
    gate = CommandGate(mapping.write, mapping.command_timeout)
    gate.put({"top_drive_angle": 1.0, "block_speed": 50.0}, 0.0)
    assert "block_speed = " in gate.refused and gate.take(0.0) == {}
    gate.put({"top_drive_angle": 1.0, "block_speed": 0.01}, 0.0)
    assert gate.take(0.0) == {"top_drive_angle": 1.0, "block_speed": 0.01}


def test_command_beyond_the_limits_is_refused(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url)
    until(lambda: len(bridge.samples) > 2)
    for value in (50.0, -50.0, math.nan, math.inf):
        bridge.say(block_speed=value)
        assert "block_speed = " in bridge.gate.refused
    bridge.take_what_was_said()
    assert wanted(server) == [0.0] * 4


def test_refused_write_is_reported(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url)
    server.forbid_writing("TopDrive.AngleWanted")
    until(lambda: len(bridge.samples) > 2)

    def others_follow() -> bool:
        bridge.say(top_drive_angle=1.0, block_speed=0.01)
        return server.read("DrawWorks.SpeedWanted") == pytest.approx(36.0)

    until(others_follow)
    assert server.read("TopDrive.AngleWanted") == 0.0
    until(lambda: list(bridge.link.health.refused) == ["top_drive_angle"])


def test_number_that_the_node_cannot_hold_is_refused(server: RigServer, start: Callable[..., Bridge]) -> None:
    """An integer of 16 bits holds 32767 deg; the other drives follow, and are stopped, all the same."""
    write = yaml.safe_load(EXAMPLE.read_text())["write"]
    write["top_drive_angle"]["node"] = "ns=2;s=TopDrive.AngleInteger"
    bridge = start(server.url, write=write, command_timeout=SHORT)
    until(lambda: len(bridge.samples) > 2)

    def angle_is_refused_and_others_follow() -> bool:
        bridge.say(top_drive_angle=math.radians(40_000.0), block_speed=0.01)
        refused = bridge.link.health.refused == {"top_drive_angle": "40000 does not fit Int16"}
        return refused and server.read("DrawWorks.SpeedWanted") == pytest.approx(36.0)

    until(angle_is_refused_and_others_follow)
    until(lambda: server.read("DrawWorks.SpeedWanted") == 0.0, "stopped")
    assert server.read("TopDrive.AngleInteger") == 180 and not bridge.errors


@pytest.mark.slow
def test_lost_server_is_found_again(start: Callable[..., Bridge]) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    bridge = start(f"opc.tcp://127.0.0.1:{port}/rig/")
    until(lambda: "trying again" in bridge.status("server")[1])
    first = RigServer(port)
    command_all(bridge, first)
    first.close()
    until(lambda: bridge.status("server")[0] == Level.ERROR, "the server is lost")
    bridge.say(top_drive_angle=1.0, block_speed=0.02)
    count = len(bridge.samples)
    second = RigServer(port)
    until(lambda: len(bridge.samples) > count, "the server is found again")
    bridge.forget_controller_after(SHORT)
    until(lambda: wanted(second) == pytest.approx([180.0, 0.0, 0.0, 0.0]), "stopped")
    bridge.take_what_was_said()
    assert wanted(second) == pytest.approx([180.0, 0.0, 0.0, 0.0]), "nothing that waited is written"
    bridge.forget_controller_after(LONG)
    command_all(bridge, second)
    assert not bridge.errors
    second.close()


@pytest.mark.parametrize(("part", "name", "expected"), [
    ("read", "hook_load", "read.hook_load: the server has no node ns=2;s=Absent: BadNodeIdUnknown"),
    ("write", "block_speed", "write.block_speed: the server has no node ns=2;s=Absent: BadNodeIdUnknown"),
])  # fmt: skip
def test_missing_node_ends_the_link(
    server: RigServer, start: Callable[..., Bridge], part: str, name: str, expected: str
) -> None:
    entries = yaml.safe_load(EXAMPLE.read_text())[part]
    entries[name]["node"] = "ns=2;s=Absent"
    bridge = start(server.url, **{part: entries})
    until(lambda: bool(bridge.errors))
    assert expected in str(bridge.errors[0])


def test_command_node_that_holds_text_is_refused(server: RigServer, start: Callable[..., Bridge]) -> None:
    bridge = start(server.url, write={"block_speed": {"node": "ns=2;s=Name", "unit": "m/s"}})
    until(lambda: bool(bridge.errors))
    assert "write.block_speed: node ns=2;s=Name takes String, not numbers" in str(bridge.errors[0])


def test_commands_need_a_heartbeat(start: Callable[..., Bridge]) -> None:
    with pytest.raises(InputError, match="heartbeat: missing"):
        start("opc.tcp://127.0.0.1:1/", heartbeat="")


@pytest.mark.parametrize(("changed", "expected"), [
    ({"url": "http://rig"}, "url = 'http://rig': must start with opc.tcp://"),
    ({"perod": 1.0}, "top level: unknown perod; did you mean period?"),
    ({"period": 0.0}, "period = 0: must be within 0.01 to 10"),
    ({"period": "fast"}, "period = 'fast': must be a number"),
    ({"heartbeat": 5}, "heartbeat = 5: must be text"),
    ({"read": {}}, "read: missing"),
    ({"read": {"torque": {"node": "i=1", "unit": "N m"}}}, "read: unknown torque; did you mean surface_torque?"),
    ({"read": {"hook_load": {"node": "i=1", "unit": "bar"}}}, "read.hook_load: unit = 'bar': is a unit of pressure"),
    ({"read": {"hook_load": {"unit": "N"}}}, "read.hook_load.node: missing"),
    ({"read": {"hook_load": "i=1"}}, "read.hook_load = 'i=1': expected keys and values"),
    ({"write": {"block_speed": {"node": "i=1", "unit": "m/s", "at_end": "hold"}}}, "must be zero or keep"),
    ({"write": {"block_speed": {"node": "i=1", "unit": "m/s", "low": 2.0, "high": 1.0}}}, "exchange them"),
    ({"read": {"hook_load": {"node": "i=1", "unit": "N"}}}, "at_end = hold needs read.top_drive_angle"),
])  # fmt: skip
def test_mistake_in_the_mapping_is_one_line(
    mapping_file: Callable[..., Path], changed: dict[str, object], expected: str
) -> None:
    path = mapping_file(**changed)
    with pytest.raises(InputError) as caught:
        load_mapping(path)
    assert str(caught.value).startswith(f"{path}: ") and expected in str(caught.value)


def test_node_id_that_cannot_be_read_is_refused(start: Callable[..., Bridge]) -> None:
    with pytest.raises(InputError, match="heartbeat: node = 'beat': not a node id such as ns=2;s=Name"):
        start("opc.tcp://127.0.0.1:1/", heartbeat="beat")
