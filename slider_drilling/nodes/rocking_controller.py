"""The node `rocking_controller`: the shell around any controller of `slider_drilling.control`'s protocol."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher

from slider_drilling.control.load import DEFAULT, load_controller, step_checked
from slider_drilling.control.protocol import AdjustableController, ReportingController, TargetedController
from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import link
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.health import Health, Level, Status
from slider_drilling.nodes.parameters import Declared, declare, of_settings, on_change
from slider_drilling.nodes.rig_parameter import RIG, rig_of
from slider_drilling.nodes.sample_inbox import Joint, SampleInbox
from slider_drilling.signals import Measurements, RigCommand

PARAMETERS = (
    RIG,
    Declared("controller", DEFAULT, "the controller, as module:Class"),
    Declared("tool_face_target", 0.0, "tool-face to hold, also taken from tool_face/target", "rad",
             -math.pi, math.pi, live=True),
    Declared("stale_after", 1.0, "age at which a channel counts as lost", "s", 0.05, 60.0, live=True),
)


class RockingController(Node):
    """Makes Measurements of the rig's topics, steps the controller, publishes its command with the sample's stamp.

    Reads surface channels and MWD only, never truth. Raises InputError for a rig file, controller or parameter that
    cannot be used.
    """

    def __init__(self, halt: Halt, **node_options: Any) -> None:
        super().__init__("rocking_controller", **node_options)
        self._halt = halt
        values = declare(self, PARAMETERS)
        rig, _ = rig_of(values["rig"])
        self._controller = load_controller(values["controller"], rig)
        self._set_target(values["tool_face_target"])
        self._declare_settings()
        self._inbox = SampleInbox(values["stale_after"])
        self._health = Health(self)
        self._stamp_ns: int | None = None     # of the last sample
        self._heard_ns = 0                    # this node's clock at the last sample
        self._silent = False
        self._sent_targets: deque[int] = deque(maxlen=20)
        self._target_publisher = link.publisher(self, TOPICS["tool_face_target"])
        self._subscribe()
        # Made once the rig's topics are connected: a simulator in lockstep starts when it sees them.
        self._command_publishers: dict[str, Publisher] = {}
        self._timer = self.create_timer(0.02, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME))
        on_change(self, self._change)
        self.get_logger().info(f"rocking with {values['controller']}")

    def _declare_settings(self) -> None:
        if isinstance(self._controller, AdjustableController):
            declared = of_settings(self._controller.settings)
            self._controller.configure(dataclasses.replace(self._controller.settings, **declare(self, declared)))

    def _subscribe(self) -> None:
        # MWD first: where several messages wait, an executor may take them in this order.
        self._mwd = link.subscription(self, TOPICS["mwd_tool_face"], self._on_mwd)
        link.subscription(self, TOPICS["tool_face_target"], self._on_target)
        self._channels = [
            link.subscription(self, TOPICS["standpipe_pressure"], self._on_standpipe_pressure),
            *(link.subscription(self, TOPICS[name], self._joint_receiver(name))
              for name in ("mud_pump", "draw_works", "top_drive")),
        ]

    def _joint_receiver(self, channel: str) -> Callable[[bytes], None]:
        topic = TOPICS[channel]

        def receive(data: bytes) -> None:
            try:
                reading = Joint(*cdr.read_joint_state(data, topic.joint))
            except InputError as error:
                self._unreadable(topic.name, error)
                return
            self._take(channel, reading)

        return receive

    def _on_standpipe_pressure(self, data: bytes) -> None:
        try:
            stamp_ns, pressure, _ = cdr.read_fluid_pressure(data)
        except InputError as error:
            self._unreadable("standpipe_pressure", error)
            return
        self._take("standpipe_pressure", Joint(stamp_ns, pressure, math.nan, math.nan))

    def _on_mwd(self, data: bytes) -> None:
        try:
            stamp_ns, tool_face, _, _ = cdr.read_joint_state(data, "tool_face")
        except InputError as error:
            self._unreadable("mwd/tool_face", error)
            return
        if math.isfinite(tool_face):
            self._inbox.put_mwd(stamp_ns, tool_face)

    def _on_target(self, data: bytes) -> None:
        try:
            stamp_ns, target, _, _ = cdr.read_joint_state(data, "tool_face")
        except InputError as error:
            self._unreadable("tool_face/target", error)
            return
        if stamp_ns in self._sent_targets:
            return
        if not math.isfinite(target):
            self.get_logger().warning(f"tool_face/target: {target} rad refused: must be finite")
            return
        target = math.remainder(target, 2.0 * math.pi)
        self.set_parameters([Parameter("tool_face_target", Parameter.Type.DOUBLE, target)])

    def _unreadable(self, topic: str, error: InputError) -> None:
        self.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=5.0)

    def _take(self, channel: str, reading: Joint) -> None:
        for measurements in self._inbox.put(channel, reading):
            self._heard_ns = self.get_clock().now().nanoseconds
            self._silent = False
            self._step(measurements)

    def _step(self, measurements: Measurements) -> None:
        if self._halt.error is not None:
            return
        self._stamp_ns = stamp_ns = round(measurements.time * 1e9)
        try:
            command = step_checked(self._controller, measurements)
        except InputError as error:
            self._halt.fail(error)
            return
        if self._health.is_due(stamp_ns):
            self._health.publish(stamp_ns, self._statuses(stamp_ns))
            self._publish_target(stamp_ns)
        self._publish_command(stamp_ns, command)

    def _publish_command(self, stamp_ns: int, command: RigCommand) -> None:
        self._make_command_publishers()
        out = self._command_publishers
        out["mud_pump"].publish(cdr.joint_state(stamp_ns, "mud_pump", None, float(command.pump_speed)))
        out["block"].publish(cdr.joint_state(stamp_ns, "block", None, float(command.block_speed)))
        out["top_drive"].publish(cdr.joint_state(
            stamp_ns, "top_drive", float(command.top_drive_angle), float(command.top_drive_speed)))

    def _make_command_publishers(self) -> None:
        """The top drive's last: who waits for it then knows the others."""
        if not self._command_publishers:
            topics = (link.PUMP_COMMAND, TOPICS["draw_works_command"], TOPICS["top_drive_command"])
            self._command_publishers = {topic.joint: link.publisher(self, topic) for topic in topics}

    def _on_timer(self) -> None:
        """Connect; and tell the controller when the rig has gone silent."""
        if not self._command_publishers:
            if all(channel.get_publisher_count() > 0 for channel in (*self._channels, self._mwd)):
                self._make_command_publishers()
            return
        if self._stamp_ns is None or self._halt.requested:
            return
        silent_ns = self.get_clock().now().nanoseconds - self._heard_ns
        if silent_ns > self._inbox.stale_after * 1e9:
            if not self._silent:
                self._silent, self._silent_from = True, self._stamp_ns
                self.get_logger().error(f"the rig is silent since {self._stamp_ns / 1e9:.1f} s")
            stamp_ns = self._silent_from + silent_ns
            if stamp_ns - self._stamp_ns >= 100_000_000:
                self._step(self._inbox.nothing(stamp_ns))

    def _change(self, changes: dict[str, Any]) -> None:
        if isinstance(self._controller, AdjustableController):
            settings = self._controller.settings
            own = {name: value for name, value in changes.items() if hasattr(settings, name)}
            if own:
                self._controller.configure(dataclasses.replace(settings, **own))
        self._inbox.stale_after = changes.get("stale_after", self._inbox.stale_after)
        if "tool_face_target" in changes:
            self._set_target(changes["tool_face_target"])
            if self._stamp_ns is not None:
                self._publish_target(self._stamp_ns)

    def _set_target(self, target: float) -> None:
        if isinstance(self._controller, TargetedController):
            self._controller.tool_face_target = target
        self._target = target

    def _publish_target(self, stamp_ns: int) -> None:
        self._sent_targets.append(stamp_ns)
        self._target_publisher.publish(cdr.joint_state(stamp_ns, "tool_face", self._target))

    def _statuses(self, stamp_ns: int) -> list[Status]:
        stale = self._inbox.stale(stamp_ns)
        if self._silent:
            heard = Status(Level.ERROR, "measurements", f"the rig is silent since {self._silent_from / 1e9:.1f} s")
        elif stale:
            heard = Status(Level.WARN, "measurements", f"no {', '.join(stale)} for {self._inbox.stale_after:g} s")
        else:
            heard = Status(Level.OK, "measurements", "every surface channel is there")
        own = self._controller.status() if isinstance(self._controller, ReportingController) else ()
        return [heard, *own]
