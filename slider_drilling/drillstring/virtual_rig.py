"""A whole virtual rig to test controllers on: drives with limits, the plant, and imperfect sensors."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from slider_drilling.control.interface import Measurements, MwdSample, RigCommand
from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import DepthProfile
from slider_drilling.drillstring.drives import DriveState, follow_command
from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.lane_block import PlantState
from slider_drilling.drillstring.recorded_channels import Commands, Response, require_finite
from slider_drilling.drillstring.sensors import MwdSensor, SurfaceSensor
from slider_drilling.drillstring.simulate import ELEMENTS, Plant
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class GroundTruth:
    """The true state, which only a simulation knows; fields and units are those of `Response`."""

    time: float
    surface_torque: float
    hook_load: float
    standpipe_pressure: float
    tool_face: float
    tool_face_rate: float
    bit_torque: float
    weight_on_bit: float
    differential_pressure: float
    bit_depth: float
    rate_of_penetration: float


@dataclass(frozen=True)
class VirtualRigState:
    """Everything that `VirtualRig.restore` needs."""

    plant: PlantState
    samples: int
    drives: DriveState
    truth: GroundTruth
    measurements: Measurements
    sensors: dict[str, SurfaceSensor]
    mwd: MwdSensor
    random: dict[str, Any]


class VirtualRig:
    """Steps one sensor period at a time; the same seed and commands give the same run bit for bit.

    Args:
        rig: The rig.
        seed: Of the sensors' noise.
        elements, start, modifiers, substeps: As in `Plant`.
        pump_speed: rad/s of the pump at the start; None for the speed of the reference flow.
        friction_of_angle: Factors (n,) of the elements' friction from their angles (n,) rad, taken once a sensor
            period.
        friction_of_speed: The same from their rotation speeds (n,) rad/s.
    """

    def __init__(
        self,
        rig: Rig,
        seed: int = 0,
        elements: int = ELEMENTS,
        start: InitialState = InitialState(),
        modifiers: Modifiers = Modifiers(),
        pump_speed: float | None = None,
        substeps: int | None = None,
        friction_of_angle: Callable[[Array], Array] | None = None,
        friction_of_speed: Callable[[Array], Array] | None = None,
    ) -> None:
        self.rig = rig
        self._friction_of_angle, self._friction_of_speed = friction_of_angle, friction_of_speed
        self.interval = 1.0 / rig.sensors.rate
        if pump_speed is None:
            pump_speed = rig.reference_pump_speed
        self._plant = self._make_plant(elements, start, modifiers, substeps)
        self._drives = DriveState(pump_speed=pump_speed)
        self._random = np.random.default_rng(seed)
        names = ("surface_torque", "hook_load", "standpipe_pressure")
        self._sensors = {name: SurfaceSensor(getattr(rig.sensors, name), self.interval) for name in names}
        self._mwd = MwdSensor(rig.sensors.mwd)
        self._samples = 0
        self.truth = self._advance()
        self.measurements = self._measure(())

    def step(self, command: RigCommand) -> Measurements:
        """Follow a command for one sensor period and measure at its end."""
        before = self.truth
        self._samples += 1
        self._drives = follow_command(self._drives, command, before.surface_torque, self.rig.top_drive, self.interval)
        self._scale_friction()
        self.truth = self._advance()
        now = (self.truth.time, self.truth.tool_face)
        self.measurements = self._measure(self._mwd.read((before.time, before.tool_face), now, self._random))
        return self.measurements

    def _scale_friction(self) -> None:
        """Friction by the angles and speeds of the elements, where the rig has such friction."""
        if self._friction_of_angle is None and self._friction_of_speed is None:
            return
        profile = self._plant.profile()
        factors = np.ones_like(profile.rotation)
        if self._friction_of_angle is not None:
            factors *= self._friction_of_angle(profile.rotation + 0.5 * self.interval * profile.rotation_speed)
        if self._friction_of_speed is not None:
            factors *= self._friction_of_speed(profile.rotation_speed)
        self._plant.scale_friction(factors)

    def profile(self) -> DepthProfile:
        """The string along its length, now."""
        return self._plant.profile()

    def save(self) -> VirtualRigState:
        """A copy of the whole rig, random numbers included."""
        sensors = {name: copy.copy(sensor) for name, sensor in self._sensors.items()}
        random = copy.deepcopy(dict(self._random.bit_generator.state))
        return VirtualRigState(
            self._plant.save(),
            self._samples,
            self._drives,
            self.truth,
            self.measurements,
            sensors,
            self._mwd.copy(),
            random,
        )

    def restore(self, saved: VirtualRigState) -> None:
        """Go back to a saved state; the same commands then give the same run again."""
        self._plant.restore(saved.plant)
        self._samples = saved.samples
        self._drives, self.truth, self.measurements = saved.drives, saved.truth, saved.measurements
        self._sensors = {name: copy.copy(sensor) for name, sensor in saved.sensors.items()}
        self._mwd = saved.mwd.copy()
        self._random.bit_generator.state = copy.deepcopy(saved.random)

    def _make_plant(self, elements: int, start: InitialState, modifiers: Modifiers, substeps: int | None) -> Any:
        """The plant, which a rig of another kind replaces."""
        return Plant(self.rig, elements, self.interval, start, modifiers, substeps)

    def _as_read(self, truth: GroundTruth) -> GroundTruth:
        """What the instruments make of the true channels, before lag, noise and resolution."""
        return truth

    def _driven(self) -> tuple[float, float]:
        """Angle rad and speed rad/s of the top drive, as its encoder shows them."""
        return self._drives.top_drive_angle, self._drives.top_drive_speed

    def _advance(self) -> GroundTruth:
        d = self._drives
        time = self._samples * self.interval
        row = (time, d.top_drive_angle, d.top_drive_speed, d.block_position, d.block_speed, d.pump_speed)
        return _true_state(self._plant.advance(Commands(*(np.array([value]) for value in row))))

    def _measure(self, mwd: tuple[MwdSample, ...]) -> Measurements:
        seen = self._as_read(self.truth)
        read = {name: sensor.read(getattr(seen, name), self._random) for name, sensor in self._sensors.items()}
        d, (angle, speed) = self._drives, self._driven()
        return Measurements(
            time=self.truth.time,
            top_drive_angle=angle,
            top_drive_speed=speed,
            block_position=d.block_position,
            block_speed=d.block_speed,
            pump_speed=d.pump_speed,
            mwd=mwd,
            **read,
        )


def _true_state(response: Response) -> GroundTruth:
    values = {name: float(getattr(response, name)[0]) for name in GroundTruth.__dataclass_fields__}
    if not math.isfinite(sum(values.values())):
        require_finite(response)
    return GroundTruth(**values)
