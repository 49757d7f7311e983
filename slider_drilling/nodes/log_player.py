"""The node `log_player`: a log's messages on their topics again, or its commands to a rig that is simulated."""

from __future__ import annotations

import time
from bisect import bisect_left
from pathlib import Path
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import InvalidTopicNameException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.publisher import Publisher
from std_msgs.msg import String

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.lifecycle_node import AUTOSTART, Transitions
from slider_drilling.nodes.logged_commands import COMMANDS, LoggedCommands
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import NodeParameter, declare, on_change, warn_of_unknown
from slider_drilling.nodes.played_log import LoggedMessage, load
from slider_drilling.nodes.services import stepping_services
from slider_drilling.nodes.shutdown import ShutdownRequest

PARAMETERS = (
    NodeParameter("log", "", "path of the MCAP log to play, or of a bag's folder"),
    NodeParameter("topics", [""], "topics to play, without the rig's namespace; all where none is given"),
    NodeParameter("rate", 1.0, "seconds of the log a second", "s/s", 0.001, 1000.0, live=True),
    NodeParameter(
        "position", 0.0, "where in the log to begin; set while it plays, it goes there", "s", 0.0, 1e9, live=True
    ),
    NodeParameter("loop", False, "begin again at the end; time goes on", live=True),
    NodeParameter("paused", False, "begin paused"),
    NodeParameter("delay", 1.0, "wall time before the first message, for subscribers to connect", "s", 0.0, 3600.0),
    NodeParameter(
        "minimum_subscribers",
        0,
        "subscriptions that every played topic must have before the first message",
        "-",
        0,
        100,
    ),
    NodeParameter("publish_clock", True, "publish the log's time on /clock"),
    NodeParameter(
        "commands_only", False, "answer a simulated rig's samples with the log's commands, on the rig's time"
    ),
    NodeParameter(
        "beside", "", "with commands_only: namespace for the log's other topics, on the rig's time; empty: none"
    ),
    AUTOSTART,
)


class LogPlayer(LifecycleNode):
    """Publishes a log's messages and /clock, in the order and at the pace of their log times.

    Topics come into this node's namespace; one that all the rig's topics have in the log is left off. Raises
    InputError for a log or a parameter that cannot be used.
    """

    def __init__(self, halt: ShutdownRequest, **node_options: Any) -> None:
        super().__init__("log_player", **node_options)
        self._halt = halt
        self._values = declare(self, PARAMETERS)
        self._transitions = Transitions(self)
        self._configured = self._active = False
        on_change(self, self._change)
        if self._values["autostart"]:
            self._transitions.start()
        warn_of_unknown(self)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the log, make its topics."""
        return self._transitions.run(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Play."""
        self._active = True
        self._resume(time.monotonic() + self._values["delay"])
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stand still."""
        self._active = False
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the log and its topics."""
        self._configured = False
        raw_topics.destroy(self, raw_topics.entities(self) - self._before)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the program."""
        self._halt.stop()
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        self._before = raw_topics.entities(self)
        values = self._values = {one.name: self.get_parameter(one.name).value for one in PARAMETERS}
        if not values["log"]:
            raise InputError("log_player: parameter log is empty; give the path of an MCAP log")
        self._log = load(Path(values["log"]), values["topics"])
        self._health = DiagnosticsPublisher(self)
        self._next = self._turns = 0
        self._shift_ns = 0  # by which the present turn of a loop is later than the log
        self._paused = values["paused"]
        self._rig_begin_ns: int | None = None  # with commands_only: stamp of the rig's first sample
        self._commands = LoggedCommands(self._log, values["log"]) if values["commands_only"] else None
        has_clock = values["publish_clock"] and self._commands is None
        self._clock_publisher = raw_topics.publisher(self, raw_topics.CLOCK) if has_clock else None
        self._make_publishers()
        self._tell_what_is_missing()
        self._seek(values["position"])
        stepping_services(self, self._pause, self._step)
        self._timer = self.create_timer(0.002, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._configured = True

    def _make_publishers(self) -> None:
        """Of the topics that are played; with commands_only of the commands, and of the rest beside the rig."""
        commands = [] if self._commands is None else self._commands.topics
        of_commands = {topic.name: topic for topic in COMMANDS}
        if self._commands is not None:
            beside = self._values["beside"].strip("/")
            played = {name: f"{beside}/{name}" for name in self._log.types if beside}
            raw_topics.subscription(self, TOPICS["top_drive"], self._on_sample)
        else:
            played = {name: name for name in self._log.types}
        made = {name: self._publisher(topic, self._log.types[name]) for name, topic in played.items()}
        self._publishers_of = {name: publisher for name, publisher in made.items() if publisher is not None}
        if not self._publishers_of and not commands:
            raise InputError(f"{self._values['log']}: no message that can be played")
        if self._log.rig_text is not None and self._commands is None:
            latched = self.create_publisher(String, raw_topics.RIG_DESCRIPTION.name, raw_topics.LATCHED)
            latched.publish(String(data=self._log.rig_text))
        # Last: a simulated rig starts when it sees them.
        self._command_publishers = {name: raw_topics.publisher(self, of_commands[name]) for name in commands}

    def _publisher(self, name: str, kind: str) -> Publisher | None:
        """A publisher for a topic of the log; None, with a warning, where it cannot be played."""
        try:
            return raw_topics.publisher(self, Topic(name, kind))
        except (ImportError, AttributeError) as error:
            self.get_logger().warning(f"{name}: not played: {kind}: {error}")
        except InvalidTopicNameException:
            self.get_logger().warning(f"{name!r}: not played: no name of a topic in ROS 2")
        return None

    def _tell_what_is_missing(self) -> None:
        missing = self._commands.missing if self._commands is not None else []
        for note in (*self._log.notes, *missing):
            self.get_logger().warning(note)

    def _change(self, changes: dict[str, Any]) -> None:
        self._values.update(changes)
        if not self._configured:
            return
        if "position" in changes:
            if self._commands is not None:
                raise InputError("position: with commands_only the rig's time says where the log is")
            self._seek(changes["position"])
        if "rate" in changes or "position" in changes:
            self._resume(time.monotonic())

    def _seek(self, position: float) -> None:
        """Go on with the first message at or after a position, s."""
        messages = self._log.messages
        at_ns = self._log.begin_ns + round(position * 1e9)
        if at_ns > messages[-1].time_ns:
            raise InputError(f"position = {position:g} s: the log is {self._log.length_ns / 1e9:g} s long")
        self._next = bisect_left(messages, at_ns, key=lambda one: one.time_ns)

    def _resume(self, wall: float) -> None:
        """Keep the pace from here on: the next message is due at this time of the wall's clock, s."""
        self._pace = Pace(self._values["rate"], self._elapsed(), wall)

    def _elapsed(self) -> float:
        """Seconds of playing up to the next message, earlier turns included."""
        next_one = self._log.messages[min(self._next, len(self._log.messages) - 1)]
        return (next_one.time_ns + self._shift_ns - self._log.begin_ns) / 1e9

    def _pause(self, paused: bool) -> str:
        if self._commands is not None:
            raise InputError("with commands_only the rig's time says where the log is; pause the simulator")
        self._paused = paused
        self._resume(time.monotonic())
        return f"{'paused' if paused else 'playing'} at {self._elapsed():.3f} s"

    def _step(self) -> str:
        if not self._paused:
            raise InputError("not paused; pause first")
        if self._next >= len(self._log.messages):
            raise InputError("the log is at its end")
        at_ns = self._log.messages[self._next].time_ns
        while self._next < len(self._log.messages) and self._log.messages[self._next].time_ns == at_ns:
            self._publish_next()
        return f"at {(at_ns - self._log.begin_ns) / 1e9:.3f} s"

    def _on_timer(self) -> None:
        """Publish what is due; at the end begin again or end."""
        if not self._active or self._commands is not None or self._waits_for_subscribers():
            return
        while self._next < len(self._log.messages) and not (self._halt.requested or self._paused):
            now = time.monotonic()
            if self._pace.due(self._elapsed()) > now:
                return
            self._publish_next()
            self._pace.note_sent(self._elapsed(), now)
        if self._halt.requested or self._paused:
            return
        if not self._values["loop"]:
            self._halt.stop()
            return
        self._begin_again()

    def _begin_again(self) -> None:
        """Another turn, later by the log's length and the pause between two of its messages: time goes on."""
        messages = self._log.messages
        times = sorted({one.time_ns for one in messages})
        between = (times[-1] - times[0]) // max(len(times) - 1, 1)
        self._shift_ns += self._log.length_ns + max(between, 1)
        self._next = 0
        self._turns += 1

    def _waits_for_subscribers(self) -> bool:
        """Whether somebody is missing still; the delay counts from when nobody is."""
        needed = self._values["minimum_subscribers"]
        missing = [one.topic_name for one in self._publishers_of.values() if one.get_subscription_count() < needed]
        if missing:
            self.get_logger().info(f"waiting for subscriptions to {', '.join(missing)}", throttle_duration_sec=5.0)
            return True
        if needed:
            self._values["minimum_subscribers"] = 0
            self._resume(time.monotonic() + self._values["delay"])
        return False

    def _publish_next(self) -> None:
        one = self._log.messages[self._next]
        now_ns = one.time_ns + self._shift_ns
        if self._next == 0 or self._log.messages[self._next - 1].time_ns != one.time_ns:
            if self._clock_publisher is not None:
                self._clock_publisher.publish(cdr.encode_clock(now_ns))
            if self._health.is_due(now_ns):
                self._health.publish(now_ns, [self._status()])
        self._publish(one)
        self._next += 1

    def _publish(self, one: LoggedMessage) -> None:
        publisher = self._publishers_of.get(one.topic)
        if publisher is None:
            return
        is_later = self._shift_ns and raw_topics.begins_with_a_header(self._log.types[one.topic])
        publisher.publish(cdr.shift_header_stamp(one.data, self._shift_ns) if is_later else one.data)

    def _on_sample(self, data: bytes) -> None:
        """With commands_only: answer a sample of the rig, and show what the log held at its time."""
        if not self._active or self._commands is None or self._halt.requested:
            return
        stamp_ns = cdr.decode_joint_state(data, TOPICS["top_drive"].joint)[0]
        if self._rig_begin_ns is None:
            self._rig_begin_ns = stamp_ns - round(self._values["position"] * 1e9)
        passed = (stamp_ns - self._rig_begin_ns) / 1e9
        self._publish_until(self._commands.begin_ns + stamp_ns - self._rig_begin_ns)
        if self._health.is_due(stamp_ns):
            self._health.publish(stamp_ns, [self._status()])
        for topic in COMMANDS:
            if topic.name in self._command_publishers:
                at = self._commands.at(topic.name, passed)
                position = at[0] if topic is TOPICS["top_drive_command"] else None
                data = cdr.encode_joint_state(stamp_ns, topic.joint, position, at[1])
                self._command_publishers[topic.name].publish(data)
        if passed > self._commands.end:
            self.get_logger().info("the log's commands are at their end")
            self._halt.stop()

    def _publish_until(self, time_ns: int) -> None:
        while self._next < len(self._log.messages) and self._log.messages[self._next].time_ns <= time_ns:
            self._publish(self._log.messages[self._next])
            self._next += 1

    def _status(self) -> Status:
        if self._commands is not None:
            missing = "; ".join(self._commands.missing)
            return Status(Level.WARN if missing else Level.OK, "commands", missing or "answers the rig's samples")
        behind = self._pace.take_worst_lag()
        values = (("rate", f"{self._values['rate']:g}"), ("turns", str(self._turns)), ("behind_s", f"{behind:.3f}"))
        if behind > 0.5:
            return Status(Level.WARN, "clock", f"the rate cannot be kept: {behind:.2f} s behind", values)
        return Status(Level.OK, "clock", "playing", values)
