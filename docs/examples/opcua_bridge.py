"""A real rig's OPC UA server on the topics of this package, and, behind a switch, its commands back to the server.

    python opcua_bridge.py opcua_rig.yaml                # reads only
    python opcua_bridge.py opcua_rig.yaml --command      # writes commands, too

Needs `pip install asyncua` beside ROS 2. The mapping file says which node holds what, and in which unit.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import sys
import time
from dataclasses import dataclass
from datetime import timezone
from pathlib import Path

import yaml
from asyncua import Client, Node, ua

from slider_drilling.errors import InputError
from slider_drilling.nodes import environment
from slider_drilling.units import si_factor

# What a rig gives: name -> topic key, place in (position, velocity, effort), kind of quantity.
READ = {
    "top_drive_angle": ("top_drive", 0, "angle"),
    "top_drive_speed": ("top_drive", 1, "angular speed"),
    "surface_torque": ("top_drive", 2, "torque"),
    "block_position": ("draw_works", 0, "length"),
    "block_speed": ("draw_works", 1, "speed"),
    "hook_load": ("draw_works", 2, "force"),
    "standpipe_pressure": ("standpipe_pressure", 0, "pressure"),
    "pump_speed": ("mud_pump", 1, "angular speed"),
    "mwd_tool_face": ("mwd_tool_face", 0, "angle"),
}
# What a rig takes: name -> topic, place, kind.
WRITE = {
    "top_drive_angle": ("top_drive_command", 0, "angle"),
    "top_drive_speed": ("top_drive_command", 1, "angular speed"),
    "block_speed": ("draw_works_command", 1, "speed"),
    "pump_speed": ("pump_command", 1, "angular speed"),
}
HEARTBEAT = 1.0  # s within which the heartbeat has to change
TOO_OLD = 0.5  # s: a command that waited longer for the server is not for now, and is not written


@dataclass(frozen=True)
class Point:
    """One value on the server: its node, and SI units a unit of it."""

    node: str
    factor: float


@dataclass(frozen=True)
class Mapping:
    """period: s between two readings of everything; heartbeat: a node whose value changes while the rig is alive."""

    url: str
    period: float
    heartbeat: str
    read: dict[str, Point]
    write: dict[str, Point]


def load_mapping(path: Path) -> Mapping:
    """Raises InputError naming the key that is missing, unknown or cannot be used."""
    try:
        tree = yaml.safe_load(path.read_text())
        points = {}
        for part, known in (("read", READ), ("write", WRITE)):
            found = tree.get(part) or {}
            unknown = set(found) - set(known)
            if unknown:
                raise InputError(f"{path}: {part}: unknown {', '.join(sorted(unknown))}; known are {', '.join(known)}")
            points[part] = {name: Point(one["node"], si_factor(one["unit"], known[name][2], f"{path}: {part}.{name}"))
                            for name, one in found.items()}
        mapping = Mapping(str(tree["url"]), float(tree.get("period", 0.1)), str(tree.get("heartbeat", "")),
                          points["read"], points["write"])
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise InputError(f"{path}: no mapping: {type(error).__name__}: {' '.join(str(error).split())}") from None
    if not 0.01 <= mapping.period <= 10.0:
        raise InputError(f"{path}: period = {mapping.period} s: must be within 0.01 to 10")
    return mapping


class Bridge:
    """Publishes one sample a period, every channel of it with the same stamp; a value of bad quality is left out."""

    def __init__(self, mapping: Mapping, command: bool) -> None:
        import rclpy
        from rclpy.node import Node as RosNode

        from slider_drilling.messages.topics import TOPICS
        from slider_drilling.nodes import raw_topics

        self._mapping = mapping
        self.node = RosNode("opcua_bridge")
        self._topics = {**TOPICS, "pump_command": raw_topics.PUMP_COMMAND}
        keys = {READ[name][0] for name in mapping.read}
        # The top drive's last: it is the one that controllers act on.
        ordered = sorted(keys, key="top_drive".__eq__)
        self._publishers = {key: raw_topics.publisher(self.node, TOPICS[key]) for key in ordered}
        self._commands: dict[str, tuple[float, float]] = {}   # name -> value, when it came
        self._mwd_stamp: object = None
        self._beat: tuple[object, float] = (None, 0.0)   # the heartbeat's value, when it last changed
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(self.node)
        if command:
            for key in {WRITE[name][0] for name in mapping.write}:
                raw_topics.subscription(self.node, self._topics[key], lambda data, key=key: self._on_command(key, data))

    def _on_command(self, key: str, data: bytes) -> None:
        from slider_drilling.messages import cdr

        values = cdr.decode_joint_state(data, self._topics[key].joint)[1:]
        for name in self._mapping.write:
            topic, place, _ = WRITE[name]
            if topic == key and math.isfinite(values[place]):
                self._commands[name] = (values[place], time.monotonic())

    def is_alive(self, beat: object) -> bool:
        """Whether the heartbeat has changed of late: a server goes on giving the last values of a dead rig."""
        now = time.monotonic()
        if beat != self._beat[0]:
            self._beat = (beat, now)
        alive = now - self._beat[1] < HEARTBEAT
        if not alive:
            self.node.get_logger().error("the rig's heartbeat stands still: nothing is published",
                                         throttle_duration_sec=5.0)
        return alive

    def publish(self, found: dict[str, ua.DataValue]) -> None:
        """One sample."""
        from slider_drilling.messages import cdr

        stamp_ns = self.node.get_clock().now().nanoseconds
        values: dict[str, list[float | None]] = {key: [None, None, None] for key in self._publishers}
        for name, one in found.items():
            key, place, _ = READ[name]
            if one.StatusCode.is_good() and one.Value is not None and math.isfinite(float(one.Value.Value)):
                values[key][place] = float(one.Value.Value) * self._mapping.read[name].factor
        for key, publisher in self._publishers.items():
            first, *others = values[key]
            if first is None and not any(value is not None for value in others):
                continue
            if key == "standpipe_pressure":
                publisher.publish(cdr.encode_fluid_pressure(stamp_ns, first or 0.0, 0.0))
            elif key == "mwd_tool_face":
                self._publish_mwd(found["mwd_tool_face"], math.remainder(first or 0.0, 2.0 * math.pi))
            else:
                publisher.publish(cdr.encode_joint_state(stamp_ns, self._topics[key].joint, *values[key]))

    def _publish_mwd(self, one: ua.DataValue, tool_face: float) -> None:
        """A toolface once, stamped with when it was measured as the server has it."""
        from slider_drilling.messages import cdr

        if one.SourceTimestamp is None or one.SourceTimestamp == self._mwd_stamp:
            return
        self._mwd_stamp = one.SourceTimestamp
        stamp = one.SourceTimestamp.replace(tzinfo=timezone.utc)   # OPC UA's times are UTC, said or not
        self._publishers["mwd_tool_face"].publish(
            cdr.encode_joint_state(round(stamp.timestamp() * 1e9), "tool_face", tool_face))

    def take_commands(self) -> dict[str, float]:
        """Commands that have come since last asked and are still for now, in the server's units."""
        self._executor.spin_once(timeout_sec=0.0)
        now = time.monotonic()
        fresh = {name: value / self._mapping.write[name].factor
                 for name, (value, came) in self._commands.items() if now - came < TOO_OLD}
        self._commands.clear()
        return fresh


async def serve(mapping: Mapping, command: bool) -> None:
    """Until interrupted. Raises InputError where the server cannot be reached or lacks a node."""
    bridge = Bridge(mapping, command)
    try:
        async with Client(mapping.url) as client:
            read = {name: client.get_node(point.node) for name, point in mapping.read.items()}
            heartbeat = client.get_node(mapping.heartbeat) if mapping.heartbeat else None
            write = {name: client.get_node(point.node) for name, point in mapping.write.items()} if command else {}
            for node in (*read.values(), *write.values()):
                await node.read_browse_name()
            bridge.node.get_logger().info(
                f"connected to {mapping.url}; " + ("commands are written" if command else "reading only"))
            await exchange(bridge, read, write, heartbeat, mapping.period)
    except (OSError, ua.UaError, asyncio.TimeoutError) as error:
        raise InputError(f"{mapping.url}: {type(error).__name__}: {' '.join(str(error).split())}") from None


async def exchange(
    bridge: Bridge, read: dict[str, Node], write: dict[str, Node], heartbeat: Node | None, period: float
) -> None:
    """Read everything once a period, write what came meanwhile."""
    loop = asyncio.get_running_loop()
    due = loop.time()
    while True:
        found = await asyncio.gather(*(node.read_data_value(raise_on_bad_status=False) for node in read.values()))
        if heartbeat is None or bridge.is_alive(await heartbeat.read_value()):
            bridge.publish(dict(zip(read, found, strict=True)))
        due = max(due + period, loop.time())
        while loop.time() < due:
            for name, value in bridge.take_commands().items():
                await write[name].write_value(ua.DataValue(ua.Variant(value, ua.VariantType.Double)))
            await asyncio.sleep(min(0.01, period))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mapping", type=Path, help="YAML file, see opcua_rig.yaml")
    parser.add_argument("--command", action="store_true", help="write commands to the rig; nothing is without it")
    given, _ = parser.parse_known_args()
    try:
        mapping = load_mapping(given.mapping)
        environment.prepare()
        from slider_drilling.nodes.run_node import init

        init([sys.argv[0], *sys.argv[sys.argv.index("--ros-args"):]] if "--ros-args" in sys.argv else sys.argv[:1])
        asyncio.run(serve(mapping, given.command))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
