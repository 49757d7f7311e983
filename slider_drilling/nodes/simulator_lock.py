"""The place of a rig in the graph, taken by one simulator at a time on this machine."""

from __future__ import annotations

import os
import socket
import sys

from slider_drilling.errors import InputError


class SimulatorLock:
    """Held from its making until `leave` or the end of the process, however that ends.

    Two rigs in one domain and namespace end each other's runs and spoil each other's logs. A socket of Linux's
    abstract kind belongs, like the loopback interface that DDS uses, to this machine (or container) and vanishes with
    its process. Raises InputError where the place is taken.
    """

    def __init__(self, namespace: str) -> None:
        self._socket: socket.socket | None = None
        discovery = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
        if discovery == "OFF" or sys.platform != "linux":
            return  # nobody else sees it; elsewhere there is no such socket
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
        """Make room for another one."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
