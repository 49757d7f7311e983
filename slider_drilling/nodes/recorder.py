"""The node `recorder`: writes the rig's topics, and any others, to a rosbag2 bag of MCAP files as they arrive."""

from __future__ import annotations

import time
from pathlib import Path
from typing import cast

from rclpy.clock import ROSClock

from slider_drilling.errors import InputError
from slider_drilling.log.bag import BagSettings, BagWriter
from slider_drilling.log.write import FLUSH_PERIOD
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import (
    DIAGNOSTICS,
    DRIVES_COMMAND,
    GAP_DIAGNOSIS,
    TOPICS,
    TWIN_TOPICS,
    is_of_twin,
)
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.rig_parameter import read_rig
from slider_drilling.nodes.services import trigger_service
from slider_drilling.nodes.spin import steady_timer
from slider_drilling.nodes.topic_subscriptions import ReceivedMessage, TopicFilter, TopicSubscriptions
from slider_drilling.programmes.find_programme import programme_text

RECORDED = (*TOPICS.values(), *TWIN_TOPICS, DIAGNOSTICS, raw_topics.PUMP_COMMAND, DRIVES_COMMAND,
            raw_topics.RIG_DESCRIPTION, raw_topics.CLOCK)  # fmt: skip
LATCHED = {raw_topics.RIG_DESCRIPTION: raw_topics.LATCHED, GAP_DIAGNOSIS: raw_topics.LATCHED_WORDS}
# What a simulated rig's log may lack.
OPTIONAL = (raw_topics.RIG_DESCRIPTION, raw_topics.CLOCK, DRIVES_COMMAND, TOPICS["bit_depth"])
TOP_DRIVE = TOPICS["top_drive"]  # the topic whose messages show that a rig runs
CONNECT_PERIOD = 0.02  # s of wall time between two looks for its publisher
MAX_DESCRIPTION_CHECKS = 100  # looks for which the rig's description is awaited, once it has a publisher
MAX_EARLY_MESSAGES = 100  # that wait for the rig's first time
SILENCE_WARNING = 5.0  # s of wall time without a message after which the node warns
DISCOVERY_PERIOD = 0.5  # s of wall time between two looks for new topics
# Metadata records beside the one that every log has.
LOSSES, PAUSES = "slider_drilling_losses", "slider_drilling_pause"


class Recorder(ManagedNode):
    """Writes every message under its arrival time by this node's clock (simulated time, with use_sim_time).

    `close` finishes the bag; call it however the program ends.

    Attributes:
        messages: Count of the messages written, without the clock, the rig's description and diagnostics.
    """

    NAME = "recorder"
    PARAMETERS = (
        NodeParameter("directory", ".", "folder of the bag, made if it is missing; if it is a bag, the log goes in it"),
        NodeParameter("file", "", "name of the log; empty: slide_ and the time"),
        NodeParameter("rig", "", "path of the rig file to attach; empty: what arrives on rig_description"),
        NodeParameter("programme", "", "programme to attach, as for the controller; empty: none"),
        NodeParameter("notes", "", "free text for the log's metadata"),
        NodeParameter("topics", [""], "further topics to record beside the rig's own"),
        NodeParameter("regex", "", "also record every topic whose full name matches this regular expression"),
        NodeParameter("all", False, "record every topic"),
        NodeParameter("exclude", "", "leave out every topic whose full name matches this regular expression"),
        NodeParameter("split_size", 0, "start another file at this size; 0: never", "byte", 0, 2**62),
        NodeParameter("split_duration", 0.0, "start another file after this time, by the log's clock; 0: never", "s",
                      0.0, 1e9),
        NodeParameter("paused", False, "start paused: record nothing until the service resume is called"),
        AUTOSTART,
    )  # fmt: skip

    messages = 0
    _is_open = False

    def configure(self) -> None:
        """Open the bag and subscribe, without recording yet."""
        values = self.values
        topic_filter = TopicFilter(tuple(values["topics"]), values["regex"], values["all"], values["exclude"])
        rig_text = read_rig(values["rig"])[1] if values["rig"] else None
        programme = programme_text(values["programme"]) if values["programme"] else None
        settings = BagSettings(
            rig_text, "slider_drilling recorder", values["notes"], values["split_size"], values["split_duration"],
            programme,
        )  # fmt: skip
        self._has_rig = rig_text is not None
        self._is_paused = values["paused"]  # by the services
        self._paused_from_ns: int | None = None
        self._simulated_ns: int | None = None
        self._early: list[ReceivedMessage] = []  # received before any time of the rig
        self._last_message = time.monotonic()
        self._diagnostics = DiagnosticsPublisher(self)
        self._subscribe(topic_filter)
        for name, act in (("pause", self._pause), ("resume", self._resume), ("split", self._split)):
            trigger_service(self, name, act)
        self._bag = BagWriter(Path(values["directory"]), _file_name(values["file"]), settings)
        self._is_open = True
        if not self._bag.is_bag:
            self.get_logger().warning(
                f"{self._bag.folder} is the bag of another recording: {self.path.name} is not in its metadata.yaml"
            )
        self.get_logger().info(f"recording to {self.path}")

    def activate(self) -> None:
        """Record."""
        self._note_pause()

    def deactivate(self) -> None:
        """Record nothing; the log notes the pause."""
        self._note_pause()

    def cleanup(self) -> None:
        """Finish the bag."""
        self.close()

    def _subscribe(self, topic_filter: TopicFilter) -> None:
        resolve = self.resolve_topic_name
        self._top_drive_topic, self._clock_topic = resolve(TOP_DRIVE.name), resolve(raw_topics.CLOCK.name)
        self._rig_topic = resolve(raw_topics.RIG_DESCRIPTION.name)
        self._uncounted = {self._rig_topic, self._clock_topic, resolve(DIAGNOSTICS.name)}
        self._description_checks = 0 if topic_filter.is_excluded(self._rig_topic) else MAX_DESCRIPTION_CHECKS
        self._topic_subscriptions = TopicSubscriptions(self, topic_filter, self._receive)
        for topic in RECORDED:
            if topic is not TOP_DRIVE:
                self._topic_subscriptions.subscribe(topic, LATCHED.get(topic, raw_topics.RELIABLE))
        self._connecting = steady_timer(self, CONNECT_PERIOD, self._connect)
        steady_timer(self, FLUSH_PERIOD, self._on_flush)
        steady_timer(self, DISCOVERY_PERIOD, self._topic_subscriptions.discover)

    @property
    def path(self) -> Path:
        """The file that is being written."""
        return self._bag.path

    @property
    def lost(self) -> int:
        """Count of the messages that were sent to this node and never arrived."""
        return self._topic_subscriptions.lost

    def publisher_count(self, topic: str) -> int:
        """How many publishers of a topic (its full name) this node receives."""
        return self._topic_subscriptions.publisher_count(topic)

    def received(self, topic: str) -> int:
        """How many messages of a topic (its full name) came, lost ones included, recorded or not."""
        return self._topic_subscriptions.received(topic)

    def is_connected(self, nodes: int) -> bool:
        """Whether every topic of a simulated rig's log has a publisher here, and `diagnostics` one per node."""
        needed = {
            topic.name: nodes if topic is DIAGNOSTICS else 1
            for topic in RECORDED
            if topic not in OPTIONAL and not is_of_twin(topic.name)
        }
        return all(self.publisher_count(self.resolve_topic_name(name)) >= count for name, count in needed.items())

    def subscribe_to_top_drive(self) -> None:
        """Subscribe to the topic whose subscribers a simulator in lockstep waits for."""
        self._topic_subscriptions.subscribe(TOP_DRIVE, raw_topics.RELIABLE)

    def _connect(self) -> None:
        """Subscribe to the top drive once it has a publisher; a simulator then sees this node and starts.

        The top drive is the last topic that a rig announces, so all its others are connected by then. A topic connected
        later would be recorded under arrival times long after its messages were sent. The same holds for the rig's
        description, which was sent before and arrives when its publisher is found.
        """
        if self.count_publishers(self._rig_topic) and self._description_checks:
            self._description_checks -= 1
        elif self.count_publishers(self._top_drive_topic):
            self.destroy_timer(self._connecting)
            self.subscribe_to_top_drive()

    def _now(self) -> int:
        """Arrival time, ns."""
        # ROS 2's own subscription to /clock is best-effort and unordered with other topics; this node's is neither.
        # ROS 2's is used until this node has received a time, and without simulated time.
        clock = cast(ROSClock, self.get_clock())
        if self._simulated_ns is None or not clock.ros_time_is_active:
            return int(clock.now().nanoseconds)
        return self._simulated_ns

    def _receive(self, message: ReceivedMessage) -> None:
        """Write one message under the present time."""
        try:
            if message.topic == self._clock_topic:
                self._simulated_ns = max(0, cdr.decode_clock(message.data))
            now = self._now()
            if message.topic == self._rig_topic:
                self._attach_description(message.data)
            has_no_time = now == 0 and self._simulated_ns is None
            if has_no_time and message.topic in self._uncounted and len(self._early) < MAX_EARLY_MESSAGES:
                self._early.append(message)
                return
            self._write_early(now)
            self._write(message, now)
        except InputError as error:
            self._fail(error)
            return
        if message.topic == self._top_drive_topic:
            self._last_message = time.monotonic()
            if self._diagnostics.is_due(now):
                self._diagnostics.publish(now, [self._status()])

    def _attach_description(self, data: bytes) -> None:
        self._description_checks = 0
        if not self._has_rig:
            self._bag.attach_rig(cdr.decode_string(data))
            self._has_rig = True

    def _write_early(self, now: int) -> None:
        """Write what arrived before the first time of the rig, under that time."""
        early, self._early = self._early, []
        for message in early:
            self._write(message, now)

    def _write(self, message: ReceivedMessage, now: int) -> None:
        if message.topic_info is not None:
            self._bag.declare(message.topic_info)
        if self._is_recording:
            self._bag.message(message.topic, message.data, now, message.number)
            self.messages += message.topic not in self._uncounted

    def _status(self) -> Status:
        values = (("messages", str(self.messages)), ("lost", str(self.lost)))
        if self.lost:
            return Status(Level.ERROR, "log", f"{self.lost} messages are missing in the log", values)
        return Status(Level.OK, "log", "recording" if self._is_recording else "paused", values)

    def _fail(self, error: InputError) -> None:
        """End with an error; the last status says that nothing is recorded any more."""
        if self.shutdown_request.error is None:
            self._diagnostics.publish(self._now(), [Status(Level.ERROR, "log", f"not recording: {error}")])
        self.shutdown_request.fail(error)

    def _on_flush(self) -> None:
        """Write buffered messages to disk; warn about lost messages and about silence."""
        try:
            self._bag.flush()
        except InputError as error:
            self._fail(error)
            return
        if self.lost:
            self.get_logger().error(
                f"{self.lost} messages lost before they could be written", throttle_duration_sec=5.0
            )
        silence = time.monotonic() - self._last_message
        if silence > SILENCE_WARNING and self._is_recording and not self.shutdown_request.requested:
            warning = f"no message on {self._top_drive_topic} for {silence:.0f} s"
            self.get_logger().warning(warning, throttle_duration_sec=30.0)
            now = self._now()
            if self._diagnostics.is_due(now):
                self._diagnostics.publish(now, [Status(Level.WARN, "log", warning)])

    @property
    def _is_recording(self) -> bool:
        return self.is_active and not self._is_paused

    def _note_pause(self) -> None:
        """Keep the time when recording stops; write the pause to the log when it goes on. Raises InputError."""
        if not self._is_recording:
            self._paused_from_ns = self._now() if self._paused_from_ns is None else self._paused_from_ns
        elif self._paused_from_ns is not None:
            self._bag.add_metadata(PAUSES, {"from_ns": str(self._paused_from_ns), "to_ns": str(self._now())})
            self._paused_from_ns = None
            self._last_message = time.monotonic()

    def _pause(self) -> str:
        if self._is_paused:
            raise InputError("is paused already")
        self._set_paused(True)
        return "paused"

    def _resume(self) -> str:
        if not self._is_paused:
            raise InputError("is recording already")
        self._set_paused(False)
        return "recording" if self.is_active else "records once it is active"

    def _set_paused(self, paused: bool) -> None:
        self._is_paused = paused
        try:
            self._note_pause()
        except InputError as error:
            self._fail(error)
            raise

    def _split(self) -> str:
        try:
            self._bag.split()
        except InputError as error:
            self._fail(error)
            raise
        return str(self.path)

    def close(self) -> None:
        """Finish the bag, if one is open. Raises InputError if that fails; what was flushed before stays."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            self._write_early(self._now())
            if self.lost and self.shutdown_request.error is None:
                losses = {topic: str(count) for topic, count in self._topic_subscriptions.lost_by_topic().items()}
                self._bag.add_metadata(LOSSES, losses)
        except InputError as error:
            self.shutdown_request.fail(error)
        self._bag.close()

    def discard(self) -> None:
        """Delete the bag: the run that was to be recorded never started."""
        self._is_open = False
        self._bag.discard()


def _file_name(name: str) -> str:
    if name and (Path(name).name != name or not name.endswith(".mcap")):
        raise InputError(f"recorder: parameter file = {name!r}: must be a name ending in .mcap, without a folder")
    return name
