"""A log's commands as a controller that repeats them: what each sample of another rig is answered with."""

from __future__ import annotations

import bisect
from dataclasses import dataclass

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.played_log import PlayedLog

COMMANDS = (raw_topics.PUMP_COMMAND, TOPICS["draw_works_command"], TOPICS["top_drive_command"])
STANDS_STILL = {
    raw_topics.PUMP_COMMAND.name: "the pump goes on as it begins",
    TOPICS["draw_works_command"].name: "the block stands still",
}
LONGEST = 1.0  # s for which the top drive goes on at a command's speed until the next command


@dataclass(frozen=True)
class CommandSeries:
    """One topic's commands: s since the rig's first sample, ascending; position and velocity, NaN where not given."""

    times: list[float]
    values: list[tuple[float, float]]


class LoggedCommands:
    """What the log's controller commanded, by the time since the rig's first sample.

    Raises InputError for a log without commands for a top drive.
    """

    def __init__(self, played: PlayedLog, source: str) -> None:
        begin_ns = _first_sample(played)
        self._series: dict[str, CommandSeries] = {}
        for topic in COMMANDS:
            found = sorted(
                (_stamp(message.data, message.time_ns), *cdr.decode_joint_state(message.data, topic.joint)[1:3])
                for message in played.messages
                if message.topic == topic.name
            )
            if found:
                self._series[topic.name] = CommandSeries(
                    [(stamp - begin_ns) / 1e9 for stamp, _, _ in found],
                    [(position, velocity) for _, position, velocity in found],
                )
        if TOPICS["top_drive_command"].name not in self._series:
            raise InputError(f"{source}: has no {TOPICS['top_drive_command'].name}: no commands to drive a rig with")
        self.end = max(series.times[-1] for series in self._series.values())
        self.begin_ns = begin_ns
        self.missing = [
            f"no {topic} in the log: {what}" for topic, what in STANDS_STILL.items() if topic not in self._series
        ]

    @property
    def topics(self) -> list[str]:
        """Topics that the log has commands for, the top drive's last: who waits for it then knows the others."""
        return [topic.name for topic in COMMANDS if topic.name in self._series]

    def at(self, topic: str, time: float) -> tuple[float, float]:
        """Position and velocity commanded at a time, s; before the first command where that begins, standing."""
        series = self._series[topic]
        # A stamp has whole nanoseconds, and a sample of another clock's start may be off by one.
        index = bisect.bisect_right(series.times, time + 1e-6) - 1
        if index < 0:
            position, velocity = series.values[0]
            return position, velocity if topic == raw_topics.PUMP_COMMAND.name else 0.0
        position, velocity = series.values[index]
        return position + velocity * min(max(time - series.times[index], 0.0), LONGEST), velocity


def _first_sample(played: PlayedLog) -> int:
    """ns: the stamp of the log's first sample of the top drive, else of the first command for it."""
    for topic in (TOPICS["top_drive"], TOPICS["top_drive_command"]):
        stamps = [_stamp(message.data, message.time_ns) for message in played.messages if message.topic == topic.name]
        if stamps:
            return min(stamps)
    return played.begin_ns


def _stamp(data: bytes, time_ns: int) -> int:
    """A command typed without a stamp counts from when it came."""
    return cdr.header_stamp_ns(data) or time_ns
