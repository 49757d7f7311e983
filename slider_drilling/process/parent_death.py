"""Ends a process with the one that started it: `ros2 launch` leaves its nodes behind when it is terminated."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PARENT_PID_VARIABLE = "SLIDER_DRILLING_END_WITH_PARENT"  # the process id of who starts it: a launch, the bench
_PR_SET_PDEATHSIG = 1


def interrupt_with_parent() -> None:
    """Have the kernel interrupt this process when the one that the environment names, its parent, is gone.

    Linux only; elsewhere it outlives a parent that was killed.
    """
    parent = os.environ.pop(PARENT_PID_VARIABLE, "")
    if not parent or sys.platform != "linux":
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGINT))
    if os.getppid() != int(parent):
        os.kill(os.getpid(), signal.SIGINT)  # it went before the kernel was asked
