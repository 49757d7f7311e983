"""Counts the outcomes of many cases and keeps the first failures of each kind."""

from __future__ import annotations

import resource
import signal
import traceback
from collections import Counter
from collections.abc import Callable
from types import FrameType

from slider_drilling.errors import InputError

MAX_CPU_TIME = 10.0  # s, or ten times that of wall time, after which a case counts as a hang
MAX_SHOWN = 10  # failures of a kind
MAX_LINE_LENGTH = 1000
EXPECTED = ("refused", "ran", "ended by the signal", "done before it", "said that the disk is full")


class Hang(BaseException):
    """A case took too long. A BaseException, so that no code under test catches it."""


class Tally:
    """Counts of the outcomes."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.failures: dict[str, str] = {}

    def run(self, case: Callable[[], str], what: str) -> None:
        """Run one case, which returns its outcome; what: describes it, to reproduce it."""
        signal.signal(signal.SIGPROF, _raise_hang)
        signal.signal(signal.SIGALRM, _raise_hang)
        signal.setitimer(signal.ITIMER_PROF, MAX_CPU_TIME)
        signal.setitimer(signal.ITIMER_REAL, 10.0 * MAX_CPU_TIME)
        try:
            outcome = case()
        except InputError as error:
            said = str(error)
            outcome = (
                "refused" if said and "\n" not in said and len(said) <= MAX_LINE_LENGTH else "refused, not in one line"
            )
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
        if outcome not in (*EXPECTED, "traceback"):
            self.failures.setdefault(
                f"{outcome} {self.counts[outcome] if self.counts[outcome] < MAX_SHOWN else MAX_SHOWN}", what
            )

    def add(self, other: Tally) -> None:
        """Add the counts of another tally."""
        self.counts += other.counts
        for kind, what in other.failures.items():
            self.failures.setdefault(f"{kind} {what}", what)

    def report(self, name: str) -> int:
        """Print the counts and the peak memory of any process; returns 1 if a case failed."""
        peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        counts = ", ".join(f"{count} {kind}" for kind, count in self.counts.items())
        print(f"{name}: {counts}; {peak / 1e3:.0f} MB at most", flush=True)
        for what in self.failures.values():
            print(f"  {what}")
        return 1 if self.failures else 0


def _raise_hang(number: int, frame: FrameType | None) -> None:
    raise Hang
