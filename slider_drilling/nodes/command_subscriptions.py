"""Where commands come in: three topics into one inbox, and what is to be said of them."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox

COMMANDS = (TOP_DRIVE, BLOCK, PUMP)
RIVALRY = 2.0  # s of the rig's clock for which a second controller is remembered


class CommandSubscriptions:
    """Subscribes to the command topics and puts what comes into the inbox; `taken` is called after each one taken."""

    def __init__(self, node: Node, inbox: CommandInbox, taken: Callable[[], None]) -> None:
        self._node = node
        self._inbox = inbox
        self._taken = taken
        self._errors: dict[str, str] = {}  # topic -> reason of refusals that no status has told yet
        self._silent: list[str] = []
        self._unanswered = self._told_unanswered = 0
        topics = (TOPICS["top_drive_command"], TOPICS["draw_works_command"], raw_topics.PUMP_COMMAND)
        self._subscriptions = {
            topic.name: raw_topics.subscription(node, topic, self._receiver(topic.name, topic.joint))
            for topic in topics
        }

    def absent(self) -> list[str]:
        """Topics that nobody publishes."""
        return [topic for topic, one in self._subscriptions.items() if one.get_publisher_count() == 0]

    def controllers(self) -> set[bytes]:
        """Who publishes the top drive's commands: one identity a publisher."""
        topic = self._subscriptions[TOP_DRIVE].topic_name
        return {bytes(one.endpoint_gid) for one in self._node.get_publishers_info_by_topic(topic)}

    def last_refusal(self) -> str:
        """Why the last command was refused as an error; "" where none was since the last status."""
        return next(reversed(self._errors.values()), "")

    def note_sample(self) -> None:
        """A sample of real time is over: count it where it had no command, and say so when commands stop or return."""
        self._unanswered += bool(self._inbox.missing(self._inbox.now_ns, (TOP_DRIVE,)))
        silent = self._inbox.dead()
        if silent and not self._silent:
            self._node.get_logger().error(self._told_silent(silent))
        elif self._silent and not silent:
            self._node.get_logger().info("commands are back")
        self._silent = silent

    def _told_silent(self, topics: list[str]) -> str:
        return (
            f"no command on {' and '.join(topics)} for {self._inbox.timeout:g} s (command_timeout): the top drive "
            "stands, the block is stopped, the pump goes on"
        )

    def _receiver(self, topic: str, joint: str) -> Callable[[bytes], None]:
        def receive(data: bytes) -> None:
            log = self._node.get_logger()
            try:
                stamp_ns, position, velocity, _ = cdr.decode_joint_state(data, joint)
            except InputError as error:
                log.warning(f"{topic}: {error}", throttle_duration_sec=5.0)
                return
            refusal = self._inbox.put(topic, stamp_ns, position, velocity)
            if refusal is None:
                self._taken()
            elif refusal.level is Level.ERROR:
                self._errors[topic] = refusal.reason
                log.error(f"{topic}: refused: {refusal.reason}", throttle_duration_sec=5.0)
            else:
                log.warning(f"{topic}: refused: {refusal.reason}", throttle_duration_sec=5.0)

        return receive

    def rivals(self) -> str:
        """What to do about two controllers that both answer; "" where there is one.

        A publisher that has died or was started again is still listed for some seconds, so that being listed proves
        nothing: two are two when one sample is answered twice.
        """
        rival_ns = self._inbox.rival_ns
        if rival_ns is None or (self._inbox.now_ns - rival_ns) / 1e9 > RIVALRY:
            return ""
        several = [topic for topic, one in self._subscriptions.items() if one.get_publisher_count() > 1]
        if not several:
            return ""
        return f"several nodes publish {' and '.join(several)}; stop all but one, or set another ROS_DOMAIN_ID"

    def status(self) -> Status:
        """The health of the commands; tells each refusal once."""
        inbox = self._inbox
        values = (("refused", str(inbox.refused)), ("unanswered_samples", str(self._unanswered)))
        errors, self._errors = self._errors, {}
        unanswered = self._unanswered - self._told_unanswered
        self._told_unanswered = self._unanswered
        rivals = self.rivals()
        if rivals:
            self._node.get_logger().warning(rivals, throttle_duration_sec=5.0)
        # All of them: a refusal is often why a topic is silent, and it is told once.
        faults = [
            *([rivals] if rivals else []),
            *([self._told_silent(self._silent)] if self._silent else []),
            *(f"{topic}: refused: {reason}" for topic, reason in errors.items()),
        ]
        if faults:
            return Status(Level.ERROR, "commands", "; ".join(faults), values)
        if unanswered:
            what = f"{unanswered} samples had no command in time; the top drive held"
            return Status(Level.WARN, "commands", what, values)
        return Status(Level.OK, "commands", "every sample is answered", values)
