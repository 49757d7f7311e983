"""Replays a log's commands: what to answer to each sample of a simulated rig."""

from __future__ import annotations

import bisect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.joint_names import named
from slider_drilling.nodes.played_log import LoggedMessage, PlayedLog

COMMANDS = (raw_topics.PUMP_COMMAND, TOPICS["draw_works_command"], TOPICS["top_drive_command"])
WITHOUT_COMMANDS = {
    raw_topics.PUMP_COMMAND.name: "the pump keeps its initial speed",
    TOPICS["draw_works_command"].name: "the block stands still",
}
MAX_EXTRAPOLATION = 1.0  # s for which the top drive follows a command's speed until the next command


@dataclass(frozen=True)
class CommandSeries:
    """One topic's commands.

    Attributes:
        times: s since the rig's first sample, ascending.
        values: Position and velocity, NaN where not given.
    """

    times: list[float]
    values: list[tuple[float, float]]


class LoggedCommands:
    """What the log's controller commanded, by the time since the rig's first sample.

    Attributes:
        begin_ns: Stamp of the log's first sample.
        end: Time of the last command, s.
        missing: A note for each topic without commands.

    Args:
        played: The log.
        source: Its name, for messages.
        joints: Values of the parameters that name the joints.

    Raises:
        InputError: The log has no commands for the top drive.
    """

    def __init__(self, played: PlayedLog, source: str, joints: Mapping[str, Any]) -> None:
        self.begin_ns = _first_sample(played)
        self._series: dict[str, CommandSeries] = {}
        for topic in COMMANDS:
            own = named(topic, joints)
            rows = _commands(played, own, topic.name, source) or _commands(played, own, DRIVES_COMMAND.name, source)
            if rows:
                self._series[topic.name] = CommandSeries(
                    [(stamp - self.begin_ns) / 1e9 for stamp, _, _ in rows],
                    [(position, velocity) for _, position, velocity in rows],
                )
        if TOPICS["top_drive_command"].name not in self._series:
            raise InputError(f"{source}: has no {TOPICS['top_drive_command'].name}: no commands to drive a rig with")
        self.end = max(series.times[-1] for series in self._series.values())
        self.missing = [
            f"no {topic} in the log: {effect}"
            for topic, effect in WITHOUT_COMMANDS.items()
            if topic not in self._series
        ]

    @property
    def topics(self) -> list[str]:
        """Topics with commands, the top drive's last: a simulator that waits for it then knows the others."""
        return [topic.name for topic in COMMANDS if topic.name in self._series]

    def at(self, topic: str, time: float) -> tuple[float, float]:
        """Position and velocity commanded at a time, s. Before the first command: its position, at rest."""
        series = self._series[topic]
        # Stamps are whole nanoseconds; a sample relative to another clock's start may be off by one.
        index = bisect.bisect_right(series.times, time + 1e-6) - 1
        if index < 0:
            position, velocity = series.values[0]
            return position, velocity if topic == raw_topics.PUMP_COMMAND.name else 0.0
        position, velocity = series.values[index]
        return position + velocity * min(max(time - series.times[index], 0.0), MAX_EXTRAPOLATION), velocity


def _commands(played: PlayedLog, topic: Topic, name: str, source: str) -> list[tuple[int, float, float]]:
    """Stamp ns, position and velocity of the commands for a drive in the messages of a topic, in order."""
    return sorted(
        (_stamp(message.data, message.time_ns), *_command(message, topic.joint, source))
        for message in played.messages
        if message.topic == name
    )


def _command(message: LoggedMessage, joint: str, source: str) -> tuple[float, float]:
    """Position and velocity of a command. Raises InputError that names log and topic."""
    try:
        _, position, velocity, _ = cdr.decode_joint_state(message.data, joint)
    except InputError as error:
        hint = "give a log with one joint a topic, or name the joints with top_drive_joint, block_joint and pump_joint"
        raise InputError(f"{source}: {message.topic}: {error}; {hint}") from None
    return position, velocity


def _first_sample(played: PlayedLog) -> int:
    """Stamp, ns, of the log's first sample of the top drive, else of the first command for it."""
    for topic in (TOPICS["top_drive"], TOPICS["top_drive_command"]):
        stamps = [_stamp(message.data, message.time_ns) for message in played.messages if message.topic == topic.name]
        if stamps:
            return min(stamps)
    return played.begin_ns


def _stamp(data: bytes, time_ns: int) -> int:
    """A message's stamp, ns; its log time if it was sent without a stamp."""
    return cdr.header_stamp_ns(data) or time_ns
