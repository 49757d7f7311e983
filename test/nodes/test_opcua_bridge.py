"""The node `opcua_bridge` in the graph, against a real OPC UA server."""

import math
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

pytest.importorskip("asyncua", reason="no asyncua: pip install '.[bridge]'")

from opcua_server import RigServer

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS


@pytest.fixture(scope="module")
def server() -> Iterator[RigServer]:
    made = RigServer()
    yield made
    made.close()


@pytest.fixture
def bridge(start, repository: Path, tmp_path: Path) -> Callable:
    """Starts the node with the example's mapping, some keys changed."""

    def start_one(command: bool = False, block_joint: str = "block", **changed: object):
        mapping = yaml.safe_load((repository / "config" / "opcua_rig.example.yaml").read_text()) | changed
        (tmp_path / "rig.yaml").write_text(yaml.safe_dump(mapping))
        return start(
            "opcua_bridge", mapping=tmp_path / "rig.yaml", command=str(command).lower(), block_joint=block_joint
        )

    return start_one


def test_node_publishes_and_stops_the_drives(server, bridge, listener):
    process = bridge(command=True, url=server.url)
    listener.until(lambda: len(listener.heard["top_drive"]) > 2 and bool(listener.heard["draw_works"]), "samples")
    stamp, *top_drive = listener.latest("top_drive")
    assert top_drive == pytest.approx([3.14159265, 3.14159265, 5000.0])
    assert listener.latest("draw_works")[1:] == pytest.approx((1.5, 0.0025, 9e5))
    assert listener.latest("mud_pump")[2] == pytest.approx(6.2831853)
    listener.until(lambda: any(block[0] == stamp for block in listener.heard["draw_works"]), "one stamp a sample")
    listener.until_status("opcua_bridge: heartbeat", 0, "changes")
    block = listener.publisher(TOPICS["draw_works_command"])

    def lowers() -> bool:
        block.publish(cdr.encode_joint_state(0, "draw_works", None, 0.01))
        listener.listen(0.05)
        return server.read("DrawWorks.SpeedWanted") == pytest.approx(36.0)

    listener.until(lowers, "the command")
    process.process.send_signal(signal.SIGINT)
    assert process.end() == 0, process.output
    assert server.read("DrawWorks.SpeedWanted") == 0.0


def test_atomic_command_is_written_or_refused_as_a_whole(server, bridge, listener):
    bridge(command=True, url=server.url, block_joint="travelling_block")
    listener.until(lambda: len(listener.heard["draw_works"]) > 2, "samples")
    drives = listener.publisher(DRIVES_COMMAND)

    def send(names: tuple[str, ...], block_speed: float) -> float:
        speeds = (0.1, block_speed, math.nan)
        drives.publish(cdr.encode_joint_states(0, names, (0.5, math.nan, math.nan), speeds))
        listener.listen(0.05)
        return server.read("DrawWorks.SpeedWanted")

    names = ("top_drive", "travelling_block", "mud_pump")
    listener.until(lambda: send(names, 0.01) == pytest.approx(36.0), "the command")
    listener.until(lambda: send(("top_drive", "block", "mud_pump"), 0.02) is not None, "another")
    listener.until_status("opcua_bridge: commands", 2, "drives/command: joints top_drive, block, mud_pump")


def test_node_without_command_listens_to_none(server, bridge, listener):
    bridge(url=server.url)
    listener.until_status("opcua_bridge: commands", 0, "reading only")
    assert listener.node.count_subscribers("draw_works/command") == 0


@pytest.mark.parametrize(("changed", "expected"), [
    ({"read": {"torque": {"node": "i=1", "unit": "N m"}}}, "read: unknown torque; did you mean surface_torque?"),
    ({"heartbeat": ""}, "heartbeat: missing"),
])  # fmt: skip
def test_mistake_is_one_line_and_exit_code_2(changed, expected, bridge):
    process = bridge(command=True, **changed)
    assert process.end() == 2, process.output
    assert expected in process.last_output()
