"""What a controller repeats of a twin's statuses: changes that its interlocks are there for. It changes no command.

Without a twin there is no status; a twin that falls silent is quoted with its age, and then no more.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from slider_drilling.messages.health import Level, Status

TWIN = "twin"
NOT_COMPARED = "not compared yet: the twin learns the rig"
"""What a twin says of every site before it could see a change."""
SITES = ("hydraulics", "motor", "bit")  # where washouts, plugged nozzles and stalls show
EFFECTS = ("washout", "plugged_nozzle", "motor_wear")
OLD_AFTER = 5.0  # s of wall time: five of the twin's periods
FORGOTTEN_AFTER = 120.0  # s of wall time


@dataclass(frozen=True)
class ReceivedStatus:
    """A status of the twin, and when it came, s of the wall's clock."""

    status: Status
    at: float


class TwinStatusRelay:
    """Keeps the twin's latest statuses of the sites that concern a controller.

    Args:
        now: Monotonic time, s.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._received: dict[str, ReceivedStatus] = {}

    def take(self, statuses: Iterable[Status]) -> None:
        """Take statuses of any node, named ``node: subject``; others than the twin's are left out."""
        for status in statuses:
            node, _, subject = status.name.partition(": ")
            if node.rpartition("/")[2] == TWIN and _concerns(subject, status):
                self._received[subject] = ReceivedStatus(status, self._now())
            elif node.rpartition("/")[2] == TWIN:
                self._received.pop(subject, None)

    def statuses(self) -> list[Status]:
        """One status that repeats the twin; none before its first, or long after the last."""
        now = self._now()
        self._received = {name: each for name, each in self._received.items() if now - each.at <= FORGOTTEN_AFTER}
        if not self._received:
            return []
        warnings = [each for each in self._received.values() if each.status.level > Level.OK]
        age = now - max(each.at for each in self._received.values())
        values = (("age_s", f"{age:.0f}"), *((each.status.name, each.status.message) for each in warnings))
        message = "; ".join(each.status.message for each in warnings) or self._nothing_wrong()
        old = f" ({age:.0f} s ago; silent since)" if age > OLD_AFTER else ""
        level = Level.WARN if warnings else Level.OK
        return [Status(level, TWIN, f"the twin {'says: ' if warnings else ''}{message}{old}", values)]

    def _nothing_wrong(self) -> str:
        """The message where no status is a warning."""
        if any(each.status.message == NOT_COMPARED for each in self._received.values()):
            return "learns the rig: it would see no fault yet"
        return "sees no washout, plugged nozzle or motor fault"


def _concerns(subject: str, status: Status) -> bool:
    if subject in SITES:
        return True
    named = dict(status.values)
    names = f"{named.get('effects', '')}, {named.get('suspected', '')}".split(", ")
    return any(name in EFFECTS for name in names)
