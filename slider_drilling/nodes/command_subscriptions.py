"""Subscribes to the command topics and reports on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rclpy.node import Node

from slider_drilling.errors import InputError
from slider_drilling.messages.decoder import TopicDecoder
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox, Refusal
from slider_drilling.nodes.joint_names import named

COMMANDS = (TOP_DRIVE, BLOCK, PUMP)
STANDING_SPEED = 0.01  # rad/s, below which the top drive stands
CONFLICT_MEMORY = 2.0  # s of the rig's clock for which a second controller is remembered


class CommandSubscriptions:
    """Puts commands from their topics into an inbox.

    Args:
        node: Makes the subscriptions and logs refused commands.
        inbox: Takes the commands.
        on_command: Called after every command that the inbox took.
        top_drive_speed: Returns the measured speed, rad/s.
        joints: Values of the parameters that name the joints.
    """

    def __init__(
        self, node: Node, inbox: CommandInbox, on_command: Callable[[], None], top_drive_speed: Callable[[], float],
        joints: Mapping[str, Any],
    ) -> None:  # fmt: skip
        self._node = node
        self._top_drive_speed = top_drive_speed
        self._inbox = inbox
        self._on_command = on_command
        self._refusals: dict[str, Refusal] = {}  # the last of each topic since the last status
        self._timed_out: list[str] = []
        self._unanswered = self._reported_unanswered = 0
        known = (TOPICS["top_drive_command"], TOPICS["draw_works_command"], raw_topics.PUMP_COMMAND)
        topics = [named(topic, joints) for topic in known]
        self._subscriptions = {
            topic.name: raw_topics.subscription(node, topic, self._receiver(topic)) for topic in topics
        }
        self._all_drives = raw_topics.subscription(node, DRIVES_COMMAND, self._drives_receiver(topics))

    def unpublished(self) -> list[str]:
        """Topics that nobody publishes, neither by themselves nor in the command of all drives."""
        if self._all_drives.get_publisher_count():
            return []
        return [name for name, one in self._subscriptions.items() if one.get_publisher_count() == 0]

    def controller_ids(self) -> set[bytes]:
        """The identities of the publishers of the top drive's commands."""
        subscriptions = (self._subscriptions[TOP_DRIVE], self._all_drives)
        return set().union(*(raw_topics.publisher_ids(self._node, one.topic_name) for one in subscriptions))

    def last_refusal(self) -> str:
        """Why the last command was refused with an error; "" if none was since the last status."""
        errors = [one.reason for one in self._refusals.values() if one.level is Level.ERROR]
        return errors[-1] if errors else ""

    def count_sample(self) -> None:
        """Count the present sample if it had no command in real time; log when commands stop or return."""
        self._unanswered += bool(self._inbox.unanswered(self._inbox.now_ns, (TOP_DRIVE,)))
        timed_out = self._inbox.timed_out()
        if timed_out and not self._timed_out:
            self._node.get_logger().error(self._timeout_message(timed_out))
        elif self._timed_out and not timed_out:
            self._node.get_logger().info("commands are back")
        self._timed_out = timed_out

    def conflict(self) -> str:
        """What to do about two controllers that both answer; "" if there is one.

        A publisher that died or was restarted is still listed for some seconds, so the list alone proves nothing. Two
        answers to one sample do.
        """
        conflict_ns = self._inbox.conflict_ns
        if conflict_ns is None or (self._inbox.now_ns - conflict_ns) / 1e9 > CONFLICT_MEMORY:
            return ""
        common = self._all_drives.get_publisher_count()
        shared = [name for name, one in self._subscriptions.items() if one.get_publisher_count() + common > 1]
        if not shared:
            return ""
        return f"several nodes publish {' and '.join(shared)}; stop all but one, or set another ROS_DOMAIN_ID"

    def status(self) -> Status:
        """The health of the commands since the last status."""
        refusals, self._refusals = self._refusals, {}
        unanswered = self._unanswered - self._reported_unanswered
        self._reported_unanswered = self._unanswered
        conflict = self.conflict()
        if conflict:
            self._node.get_logger().warning(conflict, throttle_duration_sec=5.0)
        # All of them: a refusal is often the cause of a timeout, and it is reported once.
        complaints = [
            *([(Level.ERROR, conflict)] if conflict else []),
            *([(Level.ERROR, self._timeout_message(self._timed_out))] if self._timed_out else []),
            *((one.level, f"{topic}: refused: {one.reason}") for topic, one in refusals.items()),
        ]
        worst = max((level for level, _ in complaints), default=Level.OK)
        if unanswered and worst < Level.ERROR:
            worst = Level.WARN
            complaints.append((worst, f"{unanswered} samples had no command in time; the angle setpoint stood still"))
        values = (("refused", str(self._inbox.refused)), ("unanswered_samples", str(self._unanswered)))
        text = "; ".join(message for _, message in complaints) or "every sample is answered"
        return Status(worst, "commands", text, values)

    def _timeout_message(self, topics: list[str]) -> str:
        """Which commands are missing, and what the rig does about it."""
        effects = []
        if TOP_DRIVE in topics:
            speed = self._top_drive_speed()
            stands = abs(speed) < STANDING_SPEED
            effects.append("the top drive stands" if stands else f"the top drive brakes, at {speed:.1f} rad/s")
        if BLOCK in topics:
            effects.append("the block is stopped")
        return (
            f"no command on {' and '.join(topics)} for {self._inbox.timeout:g} s (command_timeout): "
            f"{', '.join(effects)}, the pump goes on"
        )

    def _receiver(self, topic: Topic) -> Callable[[bytes], None]:
        decoder = TopicDecoder(topic)

        def receive(data: bytes) -> None:
            try:
                stamp_ns, (position, velocity, _) = decoder.decode_one(data)
            except InputError as error:
                self._report_refusal(topic.name, Refusal(Level.ERROR, str(error)))
                return
            refusal = self._inbox.put(topic.name, stamp_ns, position, velocity)
            if refusal is None:
                self._on_command()
            else:
                self._report_refusal(topic.name, refusal)

        return receive

    def _drives_receiver(self, topics: Sequence[Topic]) -> Callable[[bytes], None]:
        name = DRIVES_COMMAND.name
        decoders = {topic.name: TopicDecoder(Topic(name, topic.type, topic.joint)) for topic in topics}

        def receive(data: bytes) -> None:
            try:
                decoded = {topic: decoder.decode_one(data) for topic, decoder in decoders.items()}
            except InputError as error:
                joints = ", ".join(topic.joint for topic in topics)
                refusal = Refusal(Level.ERROR, f"{error}; a command holds {joints}")
                self._report_refusal(name, refusal)
                return
            stamp_ns = next(iter(decoded.values()))[0]
            commands = {topic: (numbers[0], numbers[1]) for topic, (_, numbers) in decoded.items()}
            refused = self._inbox.put_all(stamp_ns, commands)
            if refused is None:
                self._on_command()
            else:
                self._report_refusal(name, refused)

        return receive

    def _report_refusal(self, topic: str, refusal: Refusal) -> None:
        message = f"{topic}: refused: {refusal.reason}"
        self._refusals[topic] = refusal
        if refusal.level is Level.ERROR:
            self._node.get_logger().error(message, throttle_duration_sec=5.0)
        else:
            self._node.get_logger().warning(message, throttle_duration_sec=5.0)
