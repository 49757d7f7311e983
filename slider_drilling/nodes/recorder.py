"""The node `recorder`: writes the rig's topics, and any others, to a rosbag2 bag of MCAP files as they come."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, cast

from rclpy.clock import Clock, ROSClock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError
from slider_drilling.log.bag import BagSettings, BagWriter
from slider_drilling.log.write import FLUSH_PERIOD
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher, Level, Status
from slider_drilling.nodes.lifecycle_node import AUTOSTART, Transitions
from slider_drilling.nodes.parameters import NodeParameter, declare, warn_of_unknown
from slider_drilling.nodes.rig_parameter import read_rig
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.topic_subscriptions import ReceivedMessage, TopicFilter, TopicSubscriptions

PARAMETERS = (
    NodeParameter(
        "directory", ".", "folder of the bag, made where it is missing; within it, where it is a bag already"
    ),
    NodeParameter("file", "", "name of the log; empty: slide_ and the time"),
    NodeParameter("rig", "", "path of the rig file to attach; empty: what comes on rig_description"),
    NodeParameter("notes", "", "free text for the log's metadata"),
    NodeParameter("topics", [""], "further topics to record beside the rig's own"),
    NodeParameter("regex", "", "record every topic whose whole name fits this expression, too"),
    NodeParameter("all", False, "record every topic there is"),
    NodeParameter("exclude", "", "leave out every topic whose whole name fits this expression"),
    NodeParameter("split_size", 0, "begin another file when one holds so much; 0: never", "byte", 0, 2**62),
    NodeParameter(
        "split_duration", 0.0, "begin another file after so long, by the log's clock; 0: never", "s", 0.0, 1e9
    ),
    NodeParameter("paused", False, "begin paused: nothing is recorded before the service resume is called"),
    AUTOSTART,
)
RECORDED = (*TOPICS.values(), DIAGNOSTICS, raw_topics.PUMP_COMMAND, raw_topics.RIG_DESCRIPTION, raw_topics.CLOCK)
BEAT = TOPICS["top_drive"]  # the topic by which a rig is seen to run
CONNECT = 0.02  # s of wall time between two looks for it
TOLD = 100  # looks at the most that it waits for the rig's description, once somebody has one
EARLY = 100  # messages that wait for the rig's first time at the most
QUIET = 5.0  # s of wall time without a message after which the log says so
LOOK_AROUND = 0.5  # s of wall time between two looks at who publishes what
# Metadata records beside the one that every log has.
LOSSES, PAUSES = "slider_drilling_losses", "slider_drilling_pause"


class Recorder(LifecycleNode):
    """Writes every message's bytes under the time of its arrival by this node's clock (simulated, with use_sim_time).

    messages: how many, not counting the clock, the rig's file and diagnostics. `close` finishes the bag; it must be
    called whatever ends the program. Raises InputError for a folder or a parameter that cannot be used.
    """

    def __init__(self, halt: ShutdownRequest, **node_options: Any) -> None:
        super().__init__("recorder", **node_options)
        self._halt = halt
        values = declare(self, PARAMETERS)
        warn_of_unknown(self)
        self._transitions = Transitions(self)
        self._active = self._is_open = False
        self.messages = 0
        if values["autostart"]:
            self._transitions.start()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin the bag and listen, without recording yet."""
        return self._transitions.run(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Record."""
        self._active = True
        return self._transitions.run(self._note_pause)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Record nothing; the log notes from when to when."""
        self._active = False
        return self._transitions.run(self._note_pause)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Finish the bag."""
        raw_topics.destroy(self, raw_topics.entities(self) - self._before)
        return self._transitions.run(self.close)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the program, which finishes the bag."""
        self._halt.stop()
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        self._before = raw_topics.entities(self)
        values = {one.name: self.get_parameter(one.name).value for one in PARAMETERS}
        wanted = TopicFilter(tuple(values["topics"]), values["regex"], values["all"], values["exclude"])
        rig_text = read_rig(values["rig"])[1] if values["rig"] else None
        settings = BagSettings(
            rig_text, "slider_drilling recorder", values["notes"], values["split_size"], values["split_duration"]
        )
        self._has_rig = rig_text is not None
        self._looks_for_rig = (
            0 if wanted.is_excluded(self.resolve_topic_name(raw_topics.RIG_DESCRIPTION.name)) else TOLD
        )
        self._paused = values["paused"]  # by who uses the services
        self._quiet_from: int | None = None  # ns, from when on nothing is recorded
        self._simulated_ns: int | None = None
        self._early: list[ReceivedMessage] = []  # the rig's file and health, heard before any time of the rig
        self._last_message = time.monotonic()
        self._bag = BagWriter(Path(values["directory"]), _file_name(values["file"]), settings)
        self._is_open = True
        if not self._bag.is_bag:
            self.get_logger().warning(
                f"{self._bag.folder} is the bag of another recording: {self.path.name} is not in its metadata.yaml"
            )
        self.get_logger().info(f"recording to {self.path}")
        self._listen(wanted)
        for name, serve in (("pause", self._on_pause), ("resume", self._on_resume), ("split", self._on_split)):
            self.create_service(Trigger, f"~/{name}", serve)

    def _listen(self, wanted: TopicFilter) -> None:
        self._health = DiagnosticsPublisher(self)
        self._beat = self.resolve_topic_name(BEAT.name)
        self._rig_topic = self.resolve_topic_name(raw_topics.RIG_DESCRIPTION.name)
        self._clock_topic = self.resolve_topic_name(raw_topics.CLOCK.name)
        self._about = {self._rig_topic, self._clock_topic, self.resolve_topic_name(DIAGNOSTICS.name)}
        self._listening = TopicSubscriptions(self, wanted, self._receive)
        for topic in RECORDED:
            if topic is not BEAT:
                self._listening.expect(
                    topic, raw_topics.LATCHED if topic is raw_topics.RIG_DESCRIPTION else raw_topics.RELIABLE
                )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._connecting = self.create_timer(CONNECT, self._connect, clock=steady)
        self.create_timer(FLUSH_PERIOD, self._on_flush, clock=steady)
        self.create_timer(LOOK_AROUND, self._listening.look_around, clock=steady)

    @property
    def path(self) -> Path:
        """The file that is being written."""
        return self._bag.path

    @property
    def lost(self) -> int:
        """Messages that were sent to this node and never came."""
        return self._listening.lost

    def is_connected(self, nodes: int) -> bool:
        """Whether every topic of a simulated rig's log has a publisher here, and `diagnostics` one of every node."""
        optional = (raw_topics.RIG_DESCRIPTION, raw_topics.CLOCK, TOPICS["bit_depth"])
        wanted = {topic.name: nodes if topic is DIAGNOSTICS else 1 for topic in RECORDED if topic not in optional}
        return all(
            self._listening.publishers_of(self.resolve_topic_name(name)) >= count for name, count in wanted.items()
        )

    def _connect(self) -> None:
        """Hear the beat once it is there: a simulator that counts its listeners begins when it sees this one.

        It is the last that a rig announces, so that all its other topics are connected by then. One that were not
        would be heard late, under times when others were heard that were sent long after; so would the rig's
        description, which was sent before and comes when its publisher is found.
        """
        if self.count_publishers(self._rig_topic) and self._looks_for_rig:
            self._looks_for_rig -= 1
        elif self.count_publishers(self._beat):
            self.destroy_timer(self._connecting)
            self._hear_the_beat()

    def _hear_the_beat(self) -> None:
        self._listening.expect(BEAT, raw_topics.RELIABLE)

    def _now(self) -> int:
        # ROS 2's own hearing of /clock is best-effort and in no order with other topics; this node's is. Until it has
        # heard something, and where it is not to, there is nothing but the other one.
        clock = cast(ROSClock, self.get_clock())
        if self._simulated_ns is None or not clock.ros_time_is_active:
            return int(clock.now().nanoseconds)
        return self._simulated_ns

    def _receive(self, heard: ReceivedMessage) -> None:
        """Write one message, at the time that it is."""
        try:
            if heard.topic == self._clock_topic:
                self._simulated_ns = max(0, cdr.decode_clock(heard.data))
            now = self._now()
            if heard.topic == self._rig_topic:
                self._looks_for_rig = 0
                if not self._has_rig:
                    self._bag.attach_rig(cdr.decode_string(heard.data))
                    self._has_rig = True
            if now == 0 and self._simulated_ns is None and heard.topic in self._about and len(self._early) < EARLY:
                self._early.append(heard)
                return
            self._write_early(now)
            self._write(heard, now)
        except InputError as error:
            self._halt.fail(error)
            return
        if heard.topic == self._beat:
            self._last_message = time.monotonic()
            if self._health.is_due(now):
                self._health.publish(now, [self._status()])

    def _write_early(self, now: int) -> None:
        """What came before there was any time is of the first time that there is."""
        early, self._early = self._early, []
        for one in early:
            self._write(one, now)

    def _write(self, heard: ReceivedMessage, now: int) -> None:
        if heard.described is not None:
            self._bag.declare(heard.described)
        if not self._is_quiet:
            self._bag.message(heard.topic, heard.data, now, heard.number)
            self.messages += heard.topic not in self._about

    def _status(self) -> Status:
        values = (("messages", str(self.messages)), ("lost", str(self.lost)))
        if self.lost:
            return Status(Level.ERROR, "log", f"{self.lost} messages are missing in the log", values)
        return Status(Level.OK, "log", "paused" if self._is_quiet else "recording", values)

    def _on_flush(self) -> None:
        """Write out what came in before all fell silent, and say so when it does."""
        try:
            self._bag.flush()
        except InputError as error:
            self._halt.fail(error)
            return
        if self.lost:
            self.get_logger().error(
                f"{self.lost} messages lost before they could be written", throttle_duration_sec=5.0
            )
        quiet = time.monotonic() - self._last_message
        if self._is_quiet or self._halt.requested:
            return
        if quiet > QUIET:
            what = f"nothing comes on {self._beat} for {quiet:.0f} s"
            self.get_logger().warning(what, throttle_duration_sec=30.0)
            now = self._now()
            if self._health.is_due(now):
                self._health.publish(now, [Status(Level.WARN, "log", what)])

    @property
    def _is_quiet(self) -> bool:
        return self._paused or not self._active

    def _note_pause(self) -> None:
        """Keep when recording stops; where it goes on, have the log say so. Raises InputError."""
        if self._is_quiet:
            self._quiet_from = self._now() if self._quiet_from is None else self._quiet_from
        elif self._quiet_from is not None:
            self._bag.add_metadata(PAUSES, {"from_ns": str(self._quiet_from), "to_ns": str(self._now())})
            self._quiet_from = None
            self._last_message = time.monotonic()

    def _on_pause(self, request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        return self._pause(True, "paused", "is paused already", answer)

    def _on_resume(self, request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        return self._pause(
            False, "recording" if self._active else "records once it is active", "is recording already", answer
        )

    def _pause(self, paused: bool, done: str, already: str, answer: Trigger.Response) -> Trigger.Response:
        answer.success = self._paused != paused
        answer.message = done if answer.success else already
        self._paused = paused
        try:
            self._note_pause()
        except InputError as error:
            answer.success, answer.message = False, str(error)
            self._halt.fail(error)
        return answer

    def _on_split(self, request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        try:
            self._bag.split()
            answer.success, answer.message = True, str(self.path)
        except InputError as error:
            answer.success, answer.message = False, str(error)
            self._halt.fail(error)
        return answer

    def close(self) -> None:
        """Finish the bag, where one is begun. Raises InputError where that fails; what is safe in it stays."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            self._write_early(self._now())
            if self.lost and self._halt.error is None:
                self._bag.add_metadata(LOSSES, {topic: str(count) for topic, count in self._listening.losses().items()})
        except InputError as error:
            self._halt.fail(error)
        self._bag.close()

    def discard(self) -> None:
        """Leave no log: what was to be recorded never began."""
        self._is_open = False
        self._bag.discard()


def _file_name(name: str) -> str:
    if name and (Path(name).name != name or not name.endswith(".mcap")):
        raise InputError(f"recorder: parameter file = {name!r}: must be a name ending in .mcap, without a folder")
    return name
