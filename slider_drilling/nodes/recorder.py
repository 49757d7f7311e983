"""The node `recorder`: writes the rig's topics to an MCAP file as they come."""

from __future__ import annotations

import datetime
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from rclpy.clock import Clock, JumpThreshold, ROSClock, TimeJump
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from std_msgs.msg import String

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS, Topic
from slider_drilling.nodes import link
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.health import Health, Level, Status
from slider_drilling.nodes.parameters import Declared, declare
from slider_drilling.nodes.rig_parameter import rig_of

PARAMETERS = (
    Declared("directory", ".", "folder for the log, made where it is missing"),
    Declared("file", "", "name of the log; empty: slide_ and the time"),
    Declared("rig", "", "path of the rig file to attach; empty: what comes on rig_description"),
    Declared("notes", "", "free text for the log's metadata"),
)
RECORDED = (*TOPICS.values(), DIAGNOSTICS, link.PUMP_COMMAND)
QUIET = 5.0  # s of wall time without a message after which the log says so


class Recorder(Node):
    """Writes every message's bytes under the time of its arrival by this node's clock (simulated, with use_sim_time).

    `close` finishes the file; it must be called whatever ends the program. Raises InputError for a folder or a
    parameter that cannot be used.
    """

    def __init__(self, halt: Halt, **node_options: Any) -> None:
        super().__init__("recorder", **node_options)
        self._halt = halt
        values = declare(self, PARAMETERS)
        rig_text = rig_of(values["rig"])[1] if values["rig"] else None
        self._writer = _begin(Path(values["directory"]), values["file"], rig_text, values["notes"])
        self.path = self._writer.path
        self._has_rig = rig_text is not None
        self.messages = 0
        self.lost = 0
        self._simulated_ns = 0
        any_jump = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1))
        self._jumps = self.get_clock().create_jump_callback(any_jump, post_callback=self._on_jump)
        self._last_message = time.monotonic()
        self._health = Health(self)
        self.get_logger().info(f"recording to {self.path}")
        self._subscribe()
        self._timer = self.create_timer(FLUSH_PERIOD, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def is_connected(self, nodes: int) -> bool:
        """Whether every topic of a log has a publisher here, and `diagnostics` one of every node."""
        wanted = {topic.name: nodes if topic is DIAGNOSTICS else 1 for topic in RECORDED}
        return all(self._subscriptions_of[name].get_publisher_count() >= count for name, count in wanted.items())

    def _subscribe(self) -> None:
        self.create_subscription(String, link.RIG_DESCRIPTION.name, self._on_rig, link.LATCHED)
        events = SubscriptionEventCallbacks(message_lost=self._on_lost)
        self._subscriptions_of = {
            topic.name: self.create_subscription(
                link.message_class(topic.type), topic.name, self._receiver(topic), link.RELIABLE,
                event_callbacks=events, raw=True)
            for topic in RECORDED
        }

    def _receiver(self, topic: Topic) -> Callable[[bytes], None]:
        name, kind = self.resolve_topic_name(topic.name), topic.type
        is_beat = topic is TOPICS["top_drive"]
        clock = cast(ROSClock, self.get_clock())

        def receive(data: bytes) -> None:
            # Simulated time stands still between two messages of /clock, and asking for it is dear.
            now = self._simulated_ns if clock.ros_time_is_active else clock.now().nanoseconds
            try:
                self._writer.message(name, kind, data, now, now)
            except InputError as error:
                self._halt.fail(error)
                return
            self.messages += 1
            if is_beat:
                self._last_message = time.monotonic()
                if self._health.is_due(now):
                    self._health.publish(now, [self._status()])

        return receive

    def _on_jump(self, jump: TimeJump) -> None:
        self._simulated_ns = self.get_clock().now().nanoseconds

    def _on_rig(self, message: String) -> None:
        if not self._has_rig:
            self._has_rig = True
            try:
                self._writer.attach_rig(message.data)
            except InputError as error:
                self._halt.fail(error)

    def _on_lost(self, event: Any) -> None:
        self.lost += event.total_count_change
        self.get_logger().error(f"{self.lost} messages lost before they could be written", throttle_duration_sec=5.0)

    def _status(self) -> Status:
        values = (("messages", str(self.messages)), ("lost", str(self.lost)))
        if self.lost:
            return Status(Level.ERROR, "log", f"{self.lost} messages are missing in the log", values)
        return Status(Level.OK, "log", "recording", values)

    def _on_timer(self) -> None:
        # What came in before all fell silent must not wait for the next message to be written.
        try:
            self._writer.flush()
        except InputError as error:
            self._halt.fail(error)
            return
        quiet = time.monotonic() - self._last_message
        if quiet > QUIET and not self._halt.requested:
            what = f"nothing comes on {self.resolve_topic_name('top_drive/joint_states')} for {quiet:.0f} s"
            self.get_logger().warning(what, throttle_duration_sec=30.0)
            self._health.publish(self.get_clock().now().nanoseconds, [Status(Level.WARN, "log", what)])

    def close(self) -> None:
        """Finish the log. Raises InputError where that fails."""
        self._writer.close()

    def discard(self) -> None:
        """Leave no log: what was to be recorded never began."""
        self._writer.discard()


def _begin(directory: Path, name: str, rig_text: str | None, notes: str) -> LogWriter:
    """Begin the log; the folder is made. Raises InputError where it cannot be, or a file of that name is there."""
    if name and (Path(name).name != name or not name.endswith(".mcap")):
        raise InputError(f"recorder: parameter file = {name!r}: must be a name ending in .mcap, without a folder")
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{directory}: cannot make this folder for logs: {error.strerror}") from None
    own = f"slide_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}"
    for candidate in [name] if name else itertools.chain([f"{own}.mcap"], (f"{own}_{k}.mcap" for k in range(2, 100))):
        path = directory / candidate
        if name or not path.exists():
            with contextlib.suppress(FileExistsError):
                return LogWriter(path, rig_text, "slider_drilling recorder", notes)
    raise InputError(f"{directory}: holds a hundred logs named {own} already; give another folder")
