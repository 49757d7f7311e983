"""What came of many hostile cases: counts, and the first of each kind of failure to look at."""

from __future__ import annotations

import resource
import signal
import traceback
from collections import Counter
from collections.abc import Callable
from types import FrameType

from slider_drilling.errors import InputError

LONGEST = 10.0  # s of this process, or ten times that by the clock, before a case counts as a hang
SHOWN = 10  # failures of a kind to look at
LINE = 1000  # characters of an error that is still one line
FINE = ("refused", "ran", "ended by the signal", "done before it", "said that the disk is full")


class Hang(BaseException):
    """A case took too long; no Exception, so that nothing swallows it."""


class Tally:
    """Counts of refused, ran, traceback, hang and whatever else a case says of itself."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.failures: dict[str, str] = {}

    def run(self, case: Callable[[], str], what: str) -> None:
        """Run one case; it returns what came of it. what: how to find it again."""
        signal.signal(signal.SIGPROF, _ring)
        signal.signal(signal.SIGALRM, _ring)
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        signal.setitimer(signal.ITIMER_REAL, 10.0 * LONGEST)
        try:
            outcome = case()
        except InputError as error:
            said = str(error)
            outcome = "refused" if said and "\n" not in said and len(said) <= LINE else "refused, not in one line"
            what = f"{what}: {said[:200]!r}" if outcome != "refused" else what
        except Hang:
            outcome = "hang"
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            outcome = "traceback"
            what = f"{what}: {type(error).__name__}: {error} at {where.filename}:{where.lineno}"[:400]
            self.failures.setdefault(f"{where.filename}:{where.lineno}", what)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        self.counts["tried"] += 1
        self.counts[outcome] += 1
        if outcome not in (*FINE, "traceback"):
            self.failures.setdefault(
                f"{outcome} {self.counts[outcome] if self.counts[outcome] < SHOWN else SHOWN}", what
            )

    def add(self, other: Tally) -> None:
        """Count what another has counted, too."""
        self.counts += other.counts
        for kind, what in other.failures.items():
            self.failures.setdefault(f"{kind} {what}", what)

    def report(self, name: str) -> int:
        """Print the counts and the most memory that any process held; 1 where a case did not end as it should."""
        peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        counts = ", ".join(f"{count} {kind}" for kind, count in self.counts.items())
        print(f"{name}: {counts}; {peak / 1e3:.0f} MB at most", flush=True)
        for what in self.failures.values():
            print(f"  {what}")
        return 1 if self.failures else 0


def _ring(number: int, frame: FrameType | None) -> None:
    raise Hang
