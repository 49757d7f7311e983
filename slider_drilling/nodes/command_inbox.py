"""Collects the commands for one sample from the topics they come on."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass

from slider_drilling.control.interface import RigCommand
from slider_drilling.messages.health import Level
from slider_drilling.nodes.clock_check import describe_clock

TOP_DRIVE, BLOCK, PUMP = "top_drive/command", "draw_works/command", "mud_pump/command"
AHEAD = 0.5  # s by which a command may be ahead of the rig's clock in real time: stamped between two samples
SLOW = 60.0  # s behind: a controller that is late, not one with another clock
REMEMBERED = 20  # answered stamps of a topic, by which a second controller gives itself away


@dataclass(frozen=True)
class Refusal:
    """Why a command was not taken. level: ERROR for one that a controller must not send."""

    level: Level
    reason: str


class CommandInbox:
    """The last command of each topic and the stamp that it answers.

    `now_ns` is the stamp of the present sample. In lockstep a command answers that sample or none; in real time it
    may be as old as `timeout` s and AHEAD s ahead. A topic that has been silent for `timeout` s of the rig's time is
    dead in real time: the top drive then stands, the block stops, the pump goes on.
    """

    def __init__(self, pump_speed: float, timeout: float, lockstep: bool) -> None:
        self.timeout = timeout
        self.lockstep = lockstep
        self.now_ns = 0
        self.refused = 0
        self.conflict_ns: int | None = None  # the sample that was last answered once too often
        self._start_pump_speed = pump_speed
        self.reset(0)

    def reset(self, now_ns: int) -> None:
        """Begin anew at this stamp, as if no command had ever come."""
        self._began_ns = self.now_ns = now_ns
        self._stamp = {TOP_DRIVE: -1, BLOCK: -1, PUMP: -1}
        self._heard = dict.fromkeys(self._stamp, -1)  # ns of the rig's clock when the last one was taken
        self._answered: dict[str, deque[int]] = {topic: deque(maxlen=REMEMBERED) for topic in self._stamp}
        self._top_drive: tuple[float, float] | None = None
        self._block_speed = 0.0
        self._pump_speed = self._start_pump_speed
        self._sent_again: Counter[int] = Counter()
        self.conflict_ns = None

    def note_resent(self) -> None:
        """The present sample has been sent once more: one controller may then answer it once more."""
        self._sent_again[self.now_ns] += 1

    def put(self, topic: str, stamp_ns: int, position: float, velocity: float) -> Refusal | None:
        """Keep a command; says why where it is not taken."""
        needed = (position, velocity) if topic == TOP_DRIVE else (velocity,)
        if not all(map(math.isfinite, needed)):
            return self._refuse(Level.WARN, f"position {position} and velocity {velocity}: not finite")
        if stamp_ns == 0 and self.now_ns != 0 and not self.lockstep:
            stamp_ns = self.now_ns  # typed by hand, without a stamp: for now
        elif refusal := self._of_another_time(stamp_ns):
            return refusal
        self._look_for_a_rival(topic, stamp_ns)
        if stamp_ns < self._stamp[topic]:
            return self._refuse(Level.WARN, f"for {stamp_ns / 1e9:.3f} s: older than the command before")
        self._stamp[topic] = min(stamp_ns, self.now_ns)
        self._heard[topic] = self.now_ns
        self._answered[topic].append(stamp_ns)
        if topic == TOP_DRIVE:
            self._top_drive = (position, velocity)
        elif topic == BLOCK:
            self._block_speed = velocity
        else:
            self._pump_speed = velocity
        return None

    def _of_another_time(self, stamp_ns: int) -> Refusal | None:
        ahead = (stamp_ns - self.now_ns) / 1e9
        if ahead > (0.0 if self.lockstep else AHEAD):
            return self._refuse(Level.ERROR, f"stamped {ahead:.3f} s ahead of the rig: {describe_clock(stamp_ns)}")
        if not self.lockstep and -ahead > self.timeout:
            why = "that is too late" if -ahead < SLOW else describe_clock(stamp_ns)
            return self._refuse(Level.ERROR, f"stamped {-ahead:.3f} s behind the rig: {why}")
        return None

    def _look_for_a_rival(self, topic: str, stamp_ns: int) -> None:
        if self._answered[topic].count(stamp_ns) > self._sent_again[stamp_ns]:
            self.conflict_ns = stamp_ns

    def _refuse(self, level: Level, reason: str) -> Refusal:
        self.refused += 1
        return Refusal(level, reason)

    def unanswered(self, stamp_ns: int, awaited: Iterable[str]) -> list[str]:
        """Those of the awaited topics that have not answered the sample of this stamp."""
        return [topic for topic in awaited if self._stamp[topic] < stamp_ns]

    def silent_for(self, topic: str) -> float:
        """For how long, s of the rig's clock, nothing could be taken from a topic."""
        return (self.now_ns - max(self._heard[topic], self._began_ns)) / 1e9

    def timed_out(self) -> list[str]:
        """Topics of top drive and block that have been silent for too long; one that never was is not missed."""
        if self.lockstep:
            return []
        return [
            topic
            for topic in (TOP_DRIVE, BLOCK)
            if self.silent_for(topic) > self.timeout and (self._heard[topic] >= 0 or topic == TOP_DRIVE)
        ]

    def command(self, stamp_ns: int, angle: float) -> RigCommand:
        """What the rig is to do next; angle: rad, where the top drive is, held until it is told otherwise.

        A top drive whose last command answered an earlier sample stands at that command's angle: a slope says
        nothing of what comes after its own interval.
        """
        block_speed = 0.0 if BLOCK in self.timed_out() else self._block_speed
        if self._top_drive is None:
            return RigCommand(angle, 0.0, block_speed, self._pump_speed)
        target, speed = self._top_drive
        fresh = self._stamp[TOP_DRIVE] >= stamp_ns
        return RigCommand(target, speed if fresh else 0.0, block_speed, self._pump_speed)
