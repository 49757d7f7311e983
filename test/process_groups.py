"""Processes that a program started, and whether they ended with it."""

import os
import time


def ends(group: int, seconds: float) -> bool:
    """Whether nobody of a process group is there any more, after so many seconds at most."""
    last = time.monotonic() + seconds
    while time.monotonic() < last:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False
