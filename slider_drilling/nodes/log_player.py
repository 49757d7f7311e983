"""The node `log_player`: publishes a log's messages again, or sends its commands to a simulated rig."""

from __future__ import annotations

import time
from bisect import bisect_left
from pathlib import Path
from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.publisher import Publisher
from std_msgs.msg import String

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.joint_names import JOINT_NAMES, named
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.logged_commands import COMMANDS, LoggedCommands
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.played_log import LoggedMessage, load
from slider_drilling.nodes.services import stepping_services
from slider_drilling.nodes.spin import steady_timer

PLAY_PERIOD = 0.002  # s of wall time between two looks for messages that are due
MAX_LAG = 0.5  # s of wall time behind the rate before the status is a warning
NO_POSITION = "with commands_only the rig's time gives the position in the log"


class LogPlayer(ManagedNode):
    """Publishes a log's messages and /clock, in the order and at the pace of their log times.

    Topics are published in this node's namespace; a namespace that all the rig's topics share in the log is removed.
    """

    NAME = "log_player"
    PARAMETERS = (
        NodeParameter("log", "", "path of the MCAP log to play, or of a bag's folder"),
        NodeParameter("topics", [""], "topics to play, without the rig's namespace; empty: all"),
        NodeParameter("twin_topics", True, "play what a twin said; false where a twin runs again"),
        NodeParameter("rate", 1.0, "seconds of the log per second", "s/s", 0.001, 1000.0, live=True),
        NodeParameter("position", 0.0, "where in the log to start; set while it plays, it jumps there", "s", 0.0, 1e9,
                      live=True),
        NodeParameter("loop", False, "start again at the end; time goes on", live=True),
        NodeParameter("paused", False, "start paused"),
        NodeParameter("delay", 1.0, "wall time before the first message, for subscribers to connect", "s", 0.0, 3600.0),
        NodeParameter("minimum_subscribers", 0, "subscriptions that every topic must have before the first message",
                      "-", 0, 100),
        NodeParameter("publish_clock", True, "publish the log's time on /clock"),
        NodeParameter("commands_only", False, "answer a simulated rig's samples with the log's commands, on its time"),
        NodeParameter("beside", "", "with commands_only: namespace in which the log's other topics are published, on "
                      "the rig's time; empty: none"),
        *JOINT_NAMES,
        AUTOSTART,
    )  # fmt: skip

    def configure(self) -> None:
        """Read the log and make its topics."""
        values = self.values
        if not values["log"]:
            raise InputError("log_player: parameter log is empty; give the path of an MCAP log")
        self._log = load(Path(values["log"]), values["topics"], values["twin_topics"])
        self._diagnostics = DiagnosticsPublisher(self)
        self._next = 0  # index of the next message
        self.turns = 0  # of the loop
        self._shift_ns = 0  # by which the present turn of the loop is later than the log
        self._paused = values["paused"]
        self._subscribers_wanted = values["minimum_subscribers"]
        self._rig_start_ns: int | None = None  # with commands_only: stamp of the rig's first sample
        self._commands = LoggedCommands(self._log, values["log"], values) if values["commands_only"] else None
        has_clock = values["publish_clock"] and self._commands is None
        self._clock_publisher = raw_topics.publisher(self, raw_topics.CLOCK) if has_clock else None
        self._make_publishers()
        for note in (*self._log.notes, *([] if self._commands is None else self._commands.missing)):
            self.get_logger().warning(note)
        self._seek(values["position"])
        stepping_services(self, self.set_paused, self.step)
        steady_timer(self, PLAY_PERIOD, self._on_timer)

    def activate(self) -> None:
        """Play."""
        self._restart_pace(time.monotonic() + self.values["delay"])

    def apply_changes(self, changes: dict[str, Any]) -> None:
        """Use a new rate or position."""
        if "position" in changes:
            if self._commands is not None:
                raise InputError(f"position: {NO_POSITION}")
            self._seek(changes["position"])
        if "rate" in changes or "position" in changes:
            self._restart_pace(time.monotonic())

    def _make_publishers(self) -> None:
        """Publishers of the played topics; with commands_only, of the commands and of the rest in `beside`."""
        commands = [] if self._commands is None else self._commands.topics
        if self._commands is None:
            played = {name: name for name in self._log.types}
        else:
            beside = self.values["beside"].strip("/")
            played = {name: f"{beside}/{name}" for name in self._log.types if beside}
            sample = named(TOPICS["top_drive"], self.values)
            on_sample = raw_topics.decoding(self, sample, lambda stamp_ns, *numbers: self._answer_sample(stamp_ns))
            raw_topics.subscription(self, sample, on_sample)
        made = {name: self._publisher(topic, self._log.types[name]) for name, topic in played.items()}
        self._publishers_by_topic = {name: publisher for name, publisher in made.items() if publisher is not None}
        if not self._publishers_by_topic and not commands:
            raise InputError(f"{self.values['log']}: no message that can be played")
        if self._log.rig_text is not None and self._commands is None:
            latched = self.create_publisher(String, raw_topics.RIG_DESCRIPTION.name, raw_topics.LATCHED)
            latched.publish(String(data=self._log.rig_text))
        # Last, because a simulated rig starts when it sees them.
        by_name = {topic.name: topic for topic in COMMANDS}
        self._command_publishers = {name: raw_topics.publisher(self, by_name[name]) for name in commands}

    def _publisher(self, name: str, kind: str) -> Publisher | None:
        """A publisher for a topic of the log; None, with a warning, if the topic cannot be played."""
        try:
            return raw_topics.publisher(self, Topic(name, kind))
        except (ImportError, AttributeError) as error:
            self.get_logger().warning(f"{name}: not played: {kind}: {error}")
        except rclpy_implementation.RCLError as error:
            # As of a command, which the policy of a secured rig lets no player send.
            self.get_logger().warning(f"{name}: not played: {str(error).splitlines()[0]}")
        except InvalidTopicNameException:
            self.get_logger().warning(f"{name!r}: not played: not a valid ROS 2 topic name")
        return None

    def _seek(self, position: float) -> None:
        """Go on with the first message at or after a position, s."""
        messages = self._log.messages
        at_ns = self._log.begin_ns + round(position * 1e9)
        if at_ns > messages[-1].time_ns:
            raise InputError(f"position = {position:g} s: the log is {self._log.length_ns / 1e9:g} s long")
        self._next = bisect_left(messages, at_ns, key=lambda message: message.time_ns)

    def _restart_pace(self, wall: float) -> None:
        """Keep the rate from here on; wall: s of the steady clock at which the next message is due."""
        self._pace = Pace(self.values["rate"], self._elapsed(), wall)

    def _elapsed(self) -> float:
        """Seconds played up to the next message, earlier turns of the loop included."""
        following = self._log.messages[min(self._next, len(self._log.messages) - 1)]
        return (following.time_ns + self._shift_ns - self._log.begin_ns) / 1e9

    def set_paused(self, paused: bool) -> str:
        """Pause or go on; returns what was done."""
        if self._commands is not None:
            raise InputError(f"{NO_POSITION}; pause the simulator")
        self._paused = paused
        self._restart_pace(time.monotonic())
        return f"{'paused' if paused else 'playing'} at {self._elapsed():.3f} s"

    def step(self) -> str:
        """While paused, publish the messages of the next log time; returns that time."""
        if not self._paused:
            raise InputError("not paused; pause first")
        if self._next >= len(self._log.messages):
            raise InputError("the log is at its end")
        at_ns = self._log.messages[self._next].time_ns
        while self._next < len(self._log.messages) and self._log.messages[self._next].time_ns == at_ns:
            self._publish_next()
        return f"at {(at_ns - self._log.begin_ns) / 1e9:.3f} s"

    def _on_timer(self) -> None:
        """Publish what is due; at the end start again or end."""
        if not self.is_active or self._commands is not None or self._is_waiting_for_subscribers():
            return
        while self._next < len(self._log.messages) and not (self.shutdown_request.requested or self._paused):
            now = time.monotonic()
            if self._pace.due(self._elapsed()) > now:
                return
            self._publish_next()
            self._pace.note_sent(self._elapsed(), now)
        if self.shutdown_request.requested or self._paused:
            return
        if self.values["loop"]:
            self._start_next_turn()
        else:
            self.shutdown_request.stop()

    def _start_next_turn(self) -> None:
        """Start the log again, later by its length and the mean interval of its messages: time goes on."""
        times = sorted({message.time_ns for message in self._log.messages})
        interval_ns = (times[-1] - times[0]) // max(len(times) - 1, 1)
        self._shift_ns += self._log.length_ns + max(interval_ns, 1)
        self._next = 0
        self.turns += 1

    def _is_waiting_for_subscribers(self) -> bool:
        """Whether subscribers are missing; the delay counts from when all are there."""
        wanted = self._subscribers_wanted
        publishers = self._publishers_by_topic.values()
        missing = [publisher.topic_name for publisher in publishers if publisher.get_subscription_count() < wanted]
        if missing:
            self.get_logger().info(f"waiting for subscriptions to {', '.join(missing)}", throttle_duration_sec=5.0)
            return True
        if wanted:
            self._subscribers_wanted = 0
            self._restart_pace(time.monotonic() + self.values["delay"])
        return False

    def _publish_next(self) -> None:
        message = self._log.messages[self._next]
        now_ns = message.time_ns + self._shift_ns
        if self._next == 0 or self._log.messages[self._next - 1].time_ns != message.time_ns:
            if self._clock_publisher is not None:
                self._clock_publisher.publish(cdr.encode_clock(now_ns))
            if self._diagnostics.is_due(now_ns):
                self._diagnostics.publish(now_ns, [self._status()])
        self._publish(message)
        self._next += 1

    def _publish(self, message: LoggedMessage) -> None:
        publisher = self._publishers_by_topic.get(message.topic)
        if publisher is None:
            return
        must_shift = self._shift_ns and raw_topics.has_header(self._log.types[message.topic])
        try:
            publisher.publish(cdr.shift_header_stamp(message.data, self._shift_ns) if must_shift else message.data)
        except InputError as error:
            self.get_logger().warning(f"{message.topic}: not played: {error}", throttle_duration_sec=5.0)

    def _answer_sample(self, stamp_ns: int) -> None:
        """With commands_only: answer a sample of the rig, and publish what the log held at its time."""
        if not self.is_active or self._commands is None or self.shutdown_request.requested:
            return
        if self._rig_start_ns is None:
            self._rig_start_ns = stamp_ns - round(self.values["position"] * 1e9)
        elapsed = (stamp_ns - self._rig_start_ns) / 1e9
        self._publish_until(self._commands.begin_ns + stamp_ns - self._rig_start_ns)
        if self._diagnostics.is_due(stamp_ns):
            self._diagnostics.publish(stamp_ns, [self._status()])
        for topic in COMMANDS:
            if topic.name in self._command_publishers:
                angle, velocity = self._commands.at(topic.name, elapsed)
                position = angle if topic is TOPICS["top_drive_command"] else None
                joint = named(topic, self.values).joint
                command = cdr.encode_joint_state(stamp_ns, joint, position, velocity)
                self._command_publishers[topic.name].publish(command)
        if elapsed > self._commands.end:
            self.get_logger().info("the log's commands are at their end")
            self.shutdown_request.stop()

    def _publish_until(self, time_ns: int) -> None:
        while self._next < len(self._log.messages) and self._log.messages[self._next].time_ns <= time_ns:
            self._publish(self._log.messages[self._next])
            self._next += 1

    def _status(self) -> Status:
        if self._commands is not None:
            missing = "; ".join(self._commands.missing)
            return Status(Level.WARN if missing else Level.OK, "commands", missing or "answers the rig's samples")
        lag = self._pace.take_worst_lag()
        values = (("rate", f"{self.values['rate']:g}"), ("turns", str(self.turns)), ("behind_s", f"{lag:.3f}"))
        if lag > MAX_LAG:
            return Status(Level.WARN, "clock", f"the rate cannot be kept: {lag:.2f} s behind", values)
        return Status(Level.OK, "clock", "playing", values)
