"""Decides which commands reach the rig: recent ones, within their limits, and a stop when they end."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from slider_drilling.opcua.mapping import HOLD, KEEP, ZERO, Point


@dataclass(frozen=True)
class _Command:
    value: float
    received_at: float


class CommandGate:
    """Takes commands from the thread of the nodes and gives them to the thread of the server's connection.

    Args:
        points: What may be written, by name.
        timeout: Age beyond which a command is not written, s.
    """

    def __init__(self, points: Mapping[str, Point], timeout: float) -> None:
        self._points = points
        self._timeout = timeout
        self._lock = threading.Lock()
        self._waiting: dict[str, _Command] = {}
        self._written: dict[str, float] = {}  # when each was last commanded; the stop ends it
        self.refused = ""

    def put(self, values: Mapping[str, float], now: float) -> None:
        """Keep the values of one command, SI units, until they are taken; `refused` says why none of them was kept."""
        for name, value in values.items():
            if refusal := self._refusal(name, value):
                self.refused = refusal
                return
        with self._lock:
            self._waiting |= {name: _Command(value, now) for name, value in values.items()}

    def _refusal(self, name: str, value: float) -> str:
        """Why a value is refused; "" if it is not."""
        point = self._points[name]
        if not math.isfinite(value):
            return f"{name} = {value}: not finite"
        if not point.low <= value <= point.high:
            limits = f"{point.low / point.factor:g} to {point.high / point.factor:g}"
            return f"{name} = {value / point.factor:g}: outside {limits}, the mapping's limits"
        return ""

    def take(self, now: float) -> dict[str, float]:
        """Commands to write now, SI units."""
        with self._lock:
            waiting, self._waiting = self._waiting, {}
        fresh = {name: one for name, one in waiting.items() if now - one.received_at < self._timeout}
        self._written |= {name: one.received_at for name, one in fresh.items()}
        return {name: one.value for name, one in fresh.items()}

    def drop(self) -> None:
        """Forget what waits: it was meant for a rig that has died since."""
        with self._lock:
            self._waiting.clear()

    @property
    def commanding(self) -> list[str]:
        """Commands that the rig still follows."""
        return list(self._written)

    def silent(self, now: float) -> list[str]:
        """Commands that the rig still follows although none came for the timeout."""
        return [name for name, at in self._written.items() if now - at >= self._timeout]

    def stop_values(self, names: Iterable[str], measured: Mapping[str, float]) -> dict[str, float]:
        """What to write so that the rig stops following commands, SI units.

        Args:
            names: Of the commands that ended.
            measured: Present values of what is to be held; what is missing is not written.
        """
        stops: dict[str, float] = {}
        for name in names:
            if self._points[name].at_end == ZERO:
                stops[name] = 0.0
            elif self._points[name].at_end == HOLD and name in measured:
                stops[name] = measured[name]
        return stops

    def is_stopped(self, name: str, stops: Mapping[str, float]) -> bool:
        """Whether a command has ended once `stops` are written; one to be held waits for the measured value."""
        return name in stops or self._points[name].at_end == KEEP

    def end(self, names: Iterable[str]) -> None:
        """Note that the rig has stopped following these commands."""
        for name in list(names):
            del self._written[name]
