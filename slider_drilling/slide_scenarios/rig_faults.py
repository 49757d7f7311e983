"""Faults of a rig that no controller knows of: sensors that lie, and faults of pump, pipe and nozzles."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Protocol

from slider_drilling.control.interface import Measurements, MwdSample
from slider_drilling.rig import FLOW_EXPONENT, Rig


class RigFault(Protocol):
    """What the closed loop applies to a rig in every sample."""

    def flow_share(self, time: float) -> float:
        """Share of the pump's flow that reaches the motor at `time` (s)."""
        ...

    def reading(self, measurements: Measurements, rig: Rig) -> Measurements:
        """The measurements with the fault in them; called once per sample, in order."""
        ...


@dataclass
class SensorFault:
    """One sensor that lies from a time on: ``gain reading + bias + drift (t - start)``, or its value of that time.

    Attributes:
        channel: A field of `Measurements`; `mwd` for the toolface.
        gain: Factor on the reading.
        bias: SI unit of the channel.
        drift: SI unit of the channel per s.
        stuck: Whether the reading stays what it was at the start.
        start: s.
    """

    channel: str
    gain: float = 1.0
    bias: float = 0.0
    drift: float = 0.0
    stuck: bool = False
    start: float = 600.0

    def flow_share(self, time: float) -> float:
        """1: a sensor changes no flow."""
        return 1.0

    def reading(self, measurements: Measurements, rig: Rig) -> Measurements:
        """The measurements with this sensor's fault."""
        if self.channel == "mwd":
            samples = tuple(self._tool_face(sample) for sample in measurements.mwd)
            return dataclasses.replace(measurements, mwd=samples)
        value = self._read(getattr(measurements, self.channel), measurements.time)
        return dataclasses.replace(measurements, **{self.channel: value})  # type: ignore[arg-type]

    def _tool_face(self, sample: MwdSample) -> MwdSample:
        read = self._read(sample.tool_face, sample.measured_at)
        return dataclasses.replace(sample, tool_face=math.remainder(read, 2.0 * math.pi))

    def _read(self, true: float, time: float) -> float:
        if time < self.start:
            self._held = true
            return true
        if self.stuck:
            return self._held
        return self.gain * true + self.bias + self.drift * (time - self.start)

    def __post_init__(self) -> None:
        self._held = math.nan


@dataclass(frozen=True)
class LostFlow:
    """Flow that does not reach the motor: a washout that grows, or a pump that loses strokes.

    The pump's crank turns on and its counter shows no fault.

    Attributes:
        pressure_share: Share of the circulating pressure that is lost in the end.
        start: s.
        duration: From the first loss to the whole of it, s.
    """

    pressure_share: float
    start: float = 300.0
    duration: float = 1200.0

    def flow_share(self, time: float) -> float:
        """Share of the pump's flow that reaches the motor."""
        grown = min(max((time - self.start) / self.duration, 0.0), 1.0)
        return float((1.0 - self.pressure_share * grown) ** (1.0 / FLOW_EXPONENT))

    def reading(self, measurements: Measurements, rig: Rig) -> Measurements:
        """Measurements with the speed of the crank."""
        speed = measurements.pump_speed / self.flow_share(measurements.time)
        return dataclasses.replace(measurements, pump_speed=speed)


@dataclass(frozen=True)
class PluggedNozzle:
    """A nozzle that plugs: the circulating pressure rises, the flow stays.

    Attributes:
        pressure_share: Rise over the circulating pressure.
        start: s.
    """

    pressure_share: float
    start: float = 600.0

    def flow_share(self, time: float) -> float:
        """1: all of the flow still reaches the motor."""
        return 1.0

    def reading(self, measurements: Measurements, rig: Rig) -> Measurements:
        """Measurements with the higher standpipe pressure."""
        if measurements.time < self.start:
            return measurements
        flow = max(measurements.pump_speed, 0.0) * rig.mud_pump.displacement / rig.hydraulics.reference_flow
        rise = self.pressure_share * rig.circulating_pressure * flow**FLOW_EXPONENT
        return dataclasses.replace(measurements, standpipe_pressure=measurements.standpipe_pressure + rise)
