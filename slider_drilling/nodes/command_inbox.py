"""Collects the commands that answer one sample from their topics."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from slider_drilling.control.interface import RigCommand
from slider_drilling.messages.health import Level
from slider_drilling.nodes.clock_check import describe_clock
from slider_drilling.rig import Rig

TOP_DRIVE, BLOCK, PUMP = "top_drive/command", "draw_works/command", "mud_pump/command"
MAX_AHEAD = 0.5  # s by which a command may be ahead of the rig's clock in real time: stamped between two samples
LATE_CONTROLLER = 60.0  # s behind the rig up to which a controller is late; beyond, it uses another clock
MAX_DIFFERENCE_TIME = 1.0  # s between two positions that give a speed
IMPOSSIBLE_FACTOR = 10.0  # of the top drive's speed
NEEDED = {
    TOP_DRIVE: "give a position, rad, and if known its velocity, rad/s; a velocity alone is no command of this drive",
    BLOCK: "give a velocity, m/s",
    PUMP: "give a velocity, rad/s",
}
REMEMBERED = 20  # answered stamps of a topic, to recognise a second controller


@dataclass(frozen=True)
class Refusal:
    """Why a command was not taken.

    Attributes:
        level: ERROR for a command that a controller must not send.
        reason: Part of a sentence for logs and statuses.
    """

    level: Level
    reason: str


@dataclass(frozen=True)
class CommandLimits:
    """The largest values of commands, from the rig file.

    Attributes:
        top_drive_speed: rad/s, either way.
        block_speed: m/s, either way.
        pump_speed: rad/s; not below 0.
    """

    top_drive_speed: float = math.inf
    block_speed: float = math.inf
    pump_speed: float = math.inf

    @classmethod
    def of(cls, rig: Rig) -> CommandLimits:
        """The limits of a rig. A top drive limits itself: only what no drive could mean is refused."""
        return cls(IMPOSSIBLE_FACTOR * rig.top_drive.max_speed, rig.max_block_speed, rig.max_pump_speed)

    def complaint(self, topic: str, velocity: float) -> str:
        """Why a command's velocity is beyond the limits; "" if it is not."""
        limit, unit, key = {
            TOP_DRIVE: (self.top_drive_speed, "rad/s", f"{IMPOSSIBLE_FACTOR:g} times top_drive.max_speed"),
            BLOCK: (self.block_speed, "m/s", "draw_works.max_speed"),
            PUMP: (self.pump_speed, "rad/s", "mud_pump.max_speed"),
        }[topic]
        if topic == PUMP and velocity < 0.0:
            return f"{velocity:g} rad/s: a pump does not turn backwards; command 0 or more"
        if abs(velocity) > limit:
            return f"{velocity:g} {unit} is beyond {limit:g} {unit}, {key} of the rig file"
        return ""


class CommandInbox:
    """The last command of each topic, and the stamp that it answers.

    In lockstep a command answers the present sample or none. In real time it may be up to `timeout` old and MAX_AHEAD
    ahead. In real time a topic times out after `timeout` without a command: the top drive then holds, the block stops
    and the pump goes on.

    Args:
        pump_speed: Crank speed until a command comes, rad/s.
        timeout: s of the rig's time.
        lockstep: Whether commands advance time.
        limits: Commands beyond them are refused.

    Attributes:
        now_ns: Stamp of the present sample.
        refused: Count of the commands that were not taken.
        conflict_ns: Stamp of the last sample that two controllers answered; None if there is none.
    """

    def __init__(
        self, pump_speed: float, timeout: float, lockstep: bool, limits: CommandLimits | None = None
    ) -> None:
        self.timeout = timeout
        self.lockstep = lockstep
        self._limits = limits or CommandLimits()
        self.now_ns = 0
        self.refused = 0
        self.conflict_ns: int | None = None
        self._start_pump_speed = pump_speed
        self.reset(0)

    def reset(self, now_ns: int) -> None:
        """Start anew at this stamp, as if no command had ever come."""
        self._start_ns = self.now_ns = now_ns
        self._stamp = {TOP_DRIVE: -1, BLOCK: -1, PUMP: -1}
        self._taken_ns = dict.fromkeys(self._stamp, -1)  # the rig's clock when the last command was taken
        self._answered: dict[str, deque[int]] = {topic: deque(maxlen=REMEMBERED) for topic in self._stamp}
        self._top_drive: tuple[float, float] | None = None
        self._block_speed = 0.0
        self._pump_speed = self._start_pump_speed
        self._resent: Counter[int] = Counter()
        self.conflict_ns = None

    def note_resent(self) -> None:
        """Note that the present sample has been sent again; one controller may answer it once more."""
        self._resent[self.now_ns] += 1

    def put(self, topic: str, stamp_ns: int, position: float, velocity: float) -> Refusal | None:
        """Keep a command, or return why it is not taken.

        Args:
            topic: Of the command.
            stamp_ns: Stamp of the sample that it answers, ns.
            position: rad; of the top drive's command only.
            velocity: rad/s or m/s. NaN for a top drive's command that gives its position alone: the speed is then that
                from the previous position.
        """
        return self.put_all(stamp_ns, {topic: (position, velocity)})

    def put_all(self, stamp_ns: int, commands: Mapping[str, tuple[float, float]]) -> Refusal | None:
        """Keep commands of several topics, (position, velocity) by topic, or none of them; see `put`."""
        if stamp_ns == 0 and self.now_ns != 0 and not self.lockstep:
            stamp_ns = self.now_ns  # typed by hand, without a stamp: for the present sample
        elif refusal := self._check_stamp(stamp_ns):
            return refusal
        complete = {topic: self._with_speed(topic, stamp_ns, *values) for topic, values in commands.items()}
        for topic, (position, velocity) in complete.items():
            if refusal := self._check(topic, stamp_ns, position, velocity):
                return refusal
        for topic, (position, velocity) in complete.items():
            self._take(topic, stamp_ns, position, velocity)
        return None

    def _check(self, topic: str, stamp_ns: int, position: float, velocity: float) -> Refusal | None:
        needed = {"position": position, "velocity": velocity} if topic == TOP_DRIVE else {"velocity": velocity}
        for name, value in needed.items():
            if not math.isfinite(value):
                return self._refuse(Level.WARN, f"{name} {value} is missing or not finite; {NEEDED[topic]}")
        if complaint := self._limits.complaint(topic, velocity):
            return self._refuse(Level.ERROR, complaint)
        if self._answered[topic].count(stamp_ns) > self._resent[stamp_ns]:
            self.conflict_ns = stamp_ns
        if stamp_ns < self._stamp[topic]:
            return self._refuse(Level.WARN, f"for {stamp_ns / 1e9:.3f} s: older than the previous command")
        return None

    def _take(self, topic: str, stamp_ns: int, position: float, velocity: float) -> None:
        self._stamp[topic] = min(stamp_ns, self.now_ns)
        self._taken_ns[topic] = self.now_ns
        self._answered[topic].append(stamp_ns)
        if topic == TOP_DRIVE:
            self._top_drive = (position, velocity)
        elif topic == BLOCK:
            self._block_speed = velocity
        else:
            self._pump_speed = velocity

    def _with_speed(self, topic: str, stamp_ns: int, position: float, velocity: float) -> tuple[float, float]:
        """Position and velocity; for a position of the top drive alone, the speed from the previous one."""
        is_alone = topic == TOP_DRIVE and math.isnan(velocity) and math.isfinite(position)
        return position, self._speed_to(position, stamp_ns) if is_alone else velocity

    def _speed_to(self, position: float, stamp_ns: int) -> float:
        """Speed from the previous commanded position, rad/s; 0 without one, or after a pause."""
        elapsed = (stamp_ns - self._stamp[TOP_DRIVE]) / 1e9
        if self._top_drive is None or not 0.0 < elapsed <= MAX_DIFFERENCE_TIME:
            return 0.0
        return (position - self._top_drive[0]) / elapsed

    def _check_stamp(self, stamp_ns: int) -> Refusal | None:
        ahead = (stamp_ns - self.now_ns) / 1e9
        if ahead > (0.0 if self.lockstep else MAX_AHEAD):
            return self._refuse(Level.ERROR, f"stamped {ahead:.3f} s ahead of the rig: {describe_clock(stamp_ns)}")
        if not self.lockstep and -ahead > self.timeout:
            cause = "that is too late" if -ahead < LATE_CONTROLLER else describe_clock(stamp_ns)
            return self._refuse(Level.ERROR, f"stamped {-ahead:.3f} s behind the rig: {cause}")
        return None

    def _refuse(self, level: Level, reason: str) -> Refusal:
        self.refused += 1
        return Refusal(level, reason)

    def unanswered(self, stamp_ns: int, awaited: Iterable[str]) -> list[str]:
        """Those of the awaited topics that have not answered the sample of this stamp."""
        return [topic for topic in awaited if self._stamp[topic] < stamp_ns]

    def silent_for(self, topic: str) -> float:
        """For how long no command of a topic was taken, s of the rig's clock."""
        return (self.now_ns - max(self._taken_ns[topic], self._start_ns)) / 1e9

    def timed_out(self) -> list[str]:
        """Which of top drive and block have timed out; a block that was never commanded has not."""
        if self.lockstep:
            return []
        return [
            topic
            for topic in (TOP_DRIVE, BLOCK)
            if self.silent_for(topic) > self.timeout and (self._taken_ns[topic] >= 0 or topic == TOP_DRIVE)
        ]

    def command(self, stamp_ns: int, angle: float) -> RigCommand:
        """The command that drives the rig from the sample of this stamp to the next.

        A late top drive command holds at its angle: its speed is valid only until the sample after the one it answers.

        Args:
            stamp_ns: Stamp of the present sample.
            angle: Present angle of the top drive, rad; held until a command comes.
        """
        block_speed = 0.0 if BLOCK in self.timed_out() else self._block_speed
        if self._top_drive is None:
            return RigCommand(angle, 0.0, block_speed, self._pump_speed)
        target, speed = self._top_drive
        is_fresh = self._stamp[TOP_DRIVE] >= stamp_ns
        return RigCommand(target, speed if is_fresh else 0.0, block_speed, self._pump_speed)
