"""Ends a node with the launch that started it: `ros2 launch` leaves its nodes behind when it is terminated."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

END_WITH_PARENT = "SLIDER_DRILLING_END_WITH_PARENT"  # set by the launch files to the process id of the launch
_PR_SET_PDEATHSIG = 1


def end_with_parent() -> None:
    """Have the kernel interrupt this process when the one that the environment names, its parent, is gone.

    Linux only; elsewhere a node outlives a terminated launch.
    """
    parent = os.environ.pop(END_WITH_PARENT, "")
    if not parent or sys.platform != "linux":
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGINT))
    if os.getppid() != int(parent):
        os.kill(os.getpid(), signal.SIGINT)   # it went before the kernel was asked
