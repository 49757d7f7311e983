"""A lock that lets one simulator per ROS domain and namespace run on this machine."""

from __future__ import annotations

import os
import socket
import sys

from slider_drilling.errors import InputError


class SimulatorLock:
    """Held until `release`, or until the process ends, however it ends.

    Two rigs in one domain and namespace would end each other's runs and mix their logs. The lock is a Linux abstract
    socket. Like the loopback interface that DDS uses, it belongs to this machine (or container), and it vanishes with
    its process.

    Raises:
        InputError: Another simulator holds the lock.
    """

    def __init__(self, namespace: str) -> None:
        self._socket: socket.socket | None = None
        discovery = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
        if discovery == "OFF" or sys.platform != "linux":
            return  # no other process sees this rig; or abstract sockets do not exist
        domain = os.environ.get("ROS_DOMAIN_ID") or "0"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._socket.bind(f"\0slider_drilling/rig/{domain}/{namespace.strip('/')}")
        except OSError:
            self.release()
            where = f"ROS domain {domain}" + (f" and namespace {namespace}" if namespace.strip("/") else "")
            raise InputError(
                f"another rig is simulated in {where} of this machine; end it, or give this one another "
                "ROS_DOMAIN_ID or a namespace"
            ) from None

    def release(self) -> None:
        """Let another simulator run."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
