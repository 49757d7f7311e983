"""The node `opcua_bridge`: a real rig's OPC UA server on the topics of this package, and commands back to it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.joint_names import JOINT_NAMES, named
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.spin import steady_timer
from slider_drilling.opcua.command_gate import CommandGate
from slider_drilling.opcua.link import Sample, ServerLink
from slider_drilling.opcua.mapping import READ, WRITE, RigMapping, load_mapping

_STATUS_PERIOD = 1.0  # s of wall time
_COMMAND_TOPICS = {
    "top_drive_command": TOPICS["top_drive_command"],
    "draw_works_command": TOPICS["draw_works_command"],
    "pump_command": raw_topics.PUMP_COMMAND,
}


class OpcuaBridge(ManagedNode):
    """Publishes one sample a period of a rig's OPC UA server and, if allowed, writes commands to it.

    It publishes while the rig's heartbeat changes. When commands end, the heartbeat stops or the node ends, it writes a
    stop to what it commanded.
    """

    NAME = "opcua_bridge"
    PARAMETERS = (
        NodeParameter("mapping", "", "path of the mapping file: which node of the server holds what, in which unit"),
        NodeParameter("command", False, "write commands to the rig; false: only read"),
        *JOINT_NAMES,
        AUTOSTART,
    )

    _link: ServerLink | None = None

    def configure(self) -> None:
        """Read the mapping and make publishers and subscriptions."""
        if not self.values["mapping"]:
            raise InputError(f"{self.NAME}: parameter mapping is missing: give the path of the mapping file")
        self._mapping = load_mapping(Path(self.values["mapping"]))
        self._gate = self._make_gate(self._mapping)
        keys = {READ[name].topic for name in self._mapping.read}
        # The top drive's last: it is the one that controllers act on.
        self._sample_publishers = {
            key: raw_topics.publisher(self, TOPICS[key]) for key in sorted(keys, key="top_drive".__eq__)
        }
        self._mwd_time: datetime | None = None
        self._diagnostics = DiagnosticsPublisher(self)
        if self._gate is not None:
            for key in sorted({WRITE[name].topic for name in self._mapping.write}):
                topic = named(_COMMAND_TOPICS[key], self.values)
                raw_topics.subscription(self, topic, raw_topics.decoding(self, topic, self._command_receiver(key)))
            raw_topics.subscription(self, DRIVES_COMMAND, self._receive_drives)
        steady_timer(self, _STATUS_PERIOD, self._report)

    def activate(self) -> None:
        """Connect to the server."""
        self._link = ServerLink(self._mapping, self._gate, self._publish, self.shutdown_request.fail)
        self.get_logger().info(
            f"{self._mapping.url}: " + ("commands are written" if self._gate is not None else "reading only")
        )

    def deactivate(self) -> None:
        """Stop the rig's drives as far as they were commanded, and disconnect."""
        self.close()

    def cleanup(self) -> None:
        """Disconnect."""
        self.close()

    def close(self) -> None:
        """Stop the rig's drives as far as they were commanded, and disconnect; call it however the program ends."""
        link, self._link = self._link, None
        if link is None:
            return
        link.stop()
        if self._gate is not None and self._gate.commanding:
            self.get_logger().error("the server was gone: the rig still has the last commands; stop it by hand")

    def destroy_node(self) -> None:
        """Close, then destroy the node."""
        self.close()
        super().destroy_node()

    def _make_gate(self, mapping: RigMapping) -> CommandGate | None:
        if not self.values["command"]:
            return None
        if not mapping.write:
            raise InputError(f"{self.values['mapping']}: write: missing; command = true needs nodes to write to")
        return CommandGate(mapping.write, mapping.command_timeout)

    def _command_receiver(self, key: str) -> Callable[..., None]:
        def receive(stamp_ns: int, *values: float) -> None:
            if self._gate is not None and self.is_active:
                self._gate.put(self._wanted({key: values}), time.monotonic())

        return receive

    def _wanted(self, commands: Mapping[str, Sequence[float]]) -> dict[str, float]:
        """What commands (topic key -> position, velocity, effort) want of the nodes of the server that may be written.

        A command may give a position without a speed, or a speed without a position.
        """
        wanted = {name: commands[WRITE[name].topic][WRITE[name].place] for name in self._mapping.write
                  if WRITE[name].topic in commands}  # fmt: skip
        return {name: value for name, value in wanted.items() if not math.isnan(value)}

    def _receive_drives(self, data: bytes) -> None:
        """Take the command of all drives as a whole, or refuse it."""
        if self._gate is None or not self.is_active:
            return
        try:
            commands = {
                key: cdr.decode_joint_state(data, named(topic, self.values).joint)[1:]
                for key, topic in _COMMAND_TOPICS.items()
            }
        except InputError as error:
            self._gate.refused = f"{DRIVES_COMMAND.name}: {error}"
            return
        self._gate.put(self._wanted(commands), time.monotonic())

    def _publish(self, sample: Sample) -> None:
        """Publish one sample, every channel of it with the same stamp. Called by the link's thread."""
        stamp_ns = self.get_clock().now().nanoseconds
        values: dict[str, list[float | None]] = {key: [None, None, None] for key in self._sample_publishers}
        for name, value in sample.values.items():
            values[READ[name].topic][READ[name].place] = value
        for key, publisher in self._sample_publishers.items():
            first = values[key][0]
            if all(value is None for value in values[key]):
                continue
            if key == "standpipe_pressure":
                publisher.publish(cdr.encode_fluid_pressure(stamp_ns, first or 0.0, 0.0))
            elif key == "mwd_tool_face":
                self._publish_tool_face(first or 0.0, sample.mwd_time)
            else:
                joint = named(TOPICS[key], self.values).joint
                publisher.publish(cdr.encode_joint_state(stamp_ns, joint, *values[key]))

    def _publish_tool_face(self, tool_face: float, measured_at: datetime | None) -> None:
        """Publish a toolface once, stamped with when it was measured as the server has it."""
        if measured_at is None or measured_at == self._mwd_time:
            return
        self._mwd_time = measured_at
        # Times of OPC UA are UTC; asyncua gives them without a zone.
        stamp_ns = round(measured_at.replace(tzinfo=timezone.utc).timestamp() * 1e9)
        angle = math.remainder(tool_face, 2.0 * math.pi)
        self._sample_publishers["mwd_tool_face"].publish(cdr.encode_joint_state(stamp_ns, "tool_face", angle))

    def _report(self) -> None:
        """Publish the health of the link and log what is wrong."""
        if self._link is None:
            return
        statuses = [*self._link.statuses(), *self._command_statuses(self._link)]
        for status in statuses:
            if status.level == Level.ERROR:
                self.get_logger().error(f"{status.name}: {status.message}", throttle_duration_sec=5.0)
        self._diagnostics.publish(self.get_clock().now().nanoseconds, statuses)

    def _command_statuses(self, link: ServerLink) -> list[Status]:
        if self._gate is None:
            return [Status(Level.OK, "commands", "reading only")]
        refused, self._gate.refused = self._gate.refused, ""
        if link.health.refused:
            reasons = "; ".join(f"{name}: {reason}" for name, reason in link.health.refused.items())
            return [Status(Level.ERROR, "commands", f"cannot be written: {reasons}")]
        if refused:
            return [Status(Level.ERROR, "commands", f"refused: {refused}")]
        return [Status(Level.OK, "commands", "written" if self._gate.commanding else "none")]
