"""The node `log_player`: a log's messages on their topics again, in the log's own time."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from slider_drilling.control.protocol import Level, Status
from slider_drilling.errors import InputError
from slider_drilling.log.container import Container
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS, Topic, canonical_type, namespace_of
from slider_drilling.nodes import link
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.health import Health
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import Declared, declare, on_change

PARAMETERS = (
    Declared("log", "", "path of the MCAP log to play"),
    Declared("rate", 1.0, "seconds of the log a second", "s/s", 0.001, 1000.0, live=True),
    Declared("loop", False, "begin again at the end; the clock then steps back", live=True),
    Declared("delay", 1.0, "wall time before the first message, for subscribers to connect", "s", 0.0, 3600.0),
    Declared("minimum_subscribers", 0, "subscriptions that every played topic must have before the first message", "-",
             0, 100),
)


def _namespace(topics: Iterable[str]) -> str:
    """The namespace that the rig's topics of a log share; "" where there is none, or several rigs'."""
    found = {namespace for topic in topics for known in (*TOPICS.values(), link.PUMP_COMMAND)
             if (namespace := namespace_of(topic, known.name)) is not None}
    return found.pop() if len(found) == 1 else ""


@dataclass(frozen=True)
class Played:
    """One message: ns of its log time, its publisher, its bytes."""

    time_ns: int
    publisher: Publisher
    data: bytes


class LogPlayer(Node):
    """Publishes a log's messages and /clock, in the order and at the pace of their log times.

    Topics come into this node's namespace; one that all the rig's topics have in the log is left off. Raises
    InputError for a log or a parameter that cannot be used.
    """

    def __init__(self, halt: Halt, **node_options: Any) -> None:
        super().__init__("log_player", **node_options)
        self._halt = halt
        values = declare(self, PARAMETERS)
        if not values["log"]:
            raise InputError("log_player: parameter log is empty; give the path of an MCAP log")
        self._rate, self._loop, self._delay = values["rate"], values["loop"], values["delay"]
        self._minimum_subscribers = values["minimum_subscribers"]
        self._clock_publisher = link.publisher(self, link.CLOCK)
        self._health = Health(self)
        self._played = self._load(Path(values["log"]))
        self._played_on = {played.publisher for played in self._played}
        self._next = 0
        self._turns = 0
        self._begin_ns = self._played[0].time_ns
        self._pace = Pace(self._rate, 0.0, time.monotonic() + self._delay)
        self._timer = self.create_timer(0.002, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME))
        on_change(self, self._change)

    def _load(self, path: Path) -> list[Played]:
        container = Container(path)
        messages = [(channel.id, message.log_time, message.data) for channel, message in container.messages()]
        own = _namespace(channel.topic for channel in container.channels.values())
        publishers = {}
        for channel in container.channels.values():
            schema = container.schemas.get(channel.schema_id)
            kind = "" if schema is None else schema.name
            publishers[channel.id] = self._publisher(channel.topic, own, channel.message_encoding, kind)
        played = []
        for channel_id, log_time, data in messages:
            publisher = publishers[channel_id]
            if publisher is not None:
                played.append(Played(log_time, publisher, data))
        for note in container.notes:
            self.get_logger().warning(f"{path}: {note}")
        if not played:
            raise InputError(f"{path}: no message that can be played")
        rig = next((one.data for one in container.attachments if one.name == "rig.yaml"), None)
        if rig is not None:
            self._rig_publisher = self.create_publisher(String, link.RIG_DESCRIPTION.name, link.LATCHED)
            self._rig_publisher.publish(String(data=rig.decode("utf-8", "replace")))
        return sorted(played, key=lambda one: one.time_ns)

    def _publisher(self, topic: str, namespace: str, encoding: str, kind: str) -> Publisher | None:
        """A publisher for a channel of the log; None, with a warning, where it cannot be played."""
        name = topic.removeprefix(namespace + "/").lstrip("/")
        if name in ("clock", link.RIG_DESCRIPTION.name):
            # The player's own: the clock from the log times, the rig from the log's attachment.
            return None
        if encoding != "cdr" or not kind:
            self.get_logger().warning(f"{topic}: not played: encoded as {encoding!r}, type {kind!r}")
            return None
        try:
            return link.publisher(self, Topic(name, canonical_type(kind)))
        except (ImportError, AttributeError) as error:
            self.get_logger().warning(f"{topic}: not played: {kind}: {error}")
            return None

    def _change(self, changes: dict[str, Any]) -> None:
        self._loop = changes.get("loop", self._loop)
        if "rate" in changes:
            self._rate = changes["rate"]
            self._pace = Pace(self._rate, self._elapsed(), time.monotonic())

    def _elapsed(self) -> float:
        """Seconds of the log up to the next message."""
        return (self._played[min(self._next, len(self._played) - 1)].time_ns - self._begin_ns) / 1e9

    def _on_timer(self) -> None:
        """Publish what is due; at the end begin again or end."""
        if self._waits_for_subscribers():
            return
        while self._next < len(self._played) and not self._halt.requested:
            now = time.monotonic()
            if self._pace.due(self._elapsed()) > now:
                return
            self._publish_next()
            self._pace.passed(self._elapsed(), now)
        if self._halt.requested:
            return
        if not self._loop:
            self._halt.stop()
            return
        self._next = 0
        self._turns += 1
        self._pace = Pace(self._rate, 0.0, time.monotonic())

    def _waits_for_subscribers(self) -> bool:
        """Whether somebody is missing still; the delay counts from when nobody is."""
        if self._minimum_subscribers == 0:
            return False
        missing = [one.topic_name for one in self._played_on
                   if one.get_subscription_count() < self._minimum_subscribers]
        if missing:
            self.get_logger().info(f"waiting for subscriptions to {', '.join(missing)}", throttle_duration_sec=5.0)
            return True
        self._minimum_subscribers = 0
        self._pace = Pace(self._rate, 0.0, time.monotonic() + self._delay)
        return False

    def _publish_next(self) -> None:
        one = self._played[self._next]
        if self._next == 0 or self._played[self._next - 1].time_ns != one.time_ns:
            self._clock_publisher.publish(cdr.clock(one.time_ns))
            if self._health.is_due(one.time_ns):
                self._health.publish(one.time_ns, [self._status()])
        one.publisher.publish(one.data)
        self._next += 1

    def _status(self) -> Status:
        behind = self._pace.take_worst_behind()
        values = (("rate", f"{self._rate:g}"), ("turns", str(self._turns)), ("behind_s", f"{behind:.3f}"))
        if behind > 0.5:
            return Status(Level.WARN, "clock", f"the rate cannot be kept: {behind:.2f} s behind", values)
        return Status(Level.OK, "clock", "playing", values)
