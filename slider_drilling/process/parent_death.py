"""Interrupts a process when its parent dies: `ros2 launch` leaves its nodes behind when it is terminated."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PARENT_PID_VARIABLE = "SLIDER_DRILLING_END_WITH_PARENT"  # environment variable with the parent's process id
_PR_SET_PDEATHSIG = 1


def interrupt_with_parent() -> None:
    """Have the kernel send SIGINT to this process when the parent that the environment names dies.

    Does nothing without the variable, or on another system than Linux.
    """
    parent = os.environ.pop(PARENT_PID_VARIABLE, "")
    if not parent or sys.platform != "linux":
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGINT))
    if os.getppid() != int(parent):
        os.kill(os.getpid(), signal.SIGINT)  # the parent died before the kernel was asked
