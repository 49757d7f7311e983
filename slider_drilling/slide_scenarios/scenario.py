"""A scenario: a well, how the rig differs from its file, and what goes wrong."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.drillstring import InitialState
from slider_drilling.effects import Effects
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, load_rig
from slider_drilling.slide_scenarios.rig_faults import RigFault

WELLS = {"2.6 km": "config/rig.short.yaml", "4.0 km": "config/rig.example.yaml", "5.6 km": "config/rig.long.yaml"}


@dataclass(frozen=True)
class Scenario:
    """One slide. The controller does not know how the rig differs from its file.

    Attributes:
        name: Unique.
        well: A key of `WELLS`.
        about: One line.
        targets: (s, deg): the toolface target from that time on; the first starts at 0 s.
        duration: s.
        start_twist: Twist in the string at the start, rad.
        friction_ratio: True friction over the rig file's.
        effects: Effects of the catalogue, as in a rig file.
        angle_friction: Share by which friction rises and falls once per turn of each pipe.
        right_friction: Share by which friction is larger while a pipe turns right than while it turns left.
        mwd_period: s; known to the controller.
        mwd_lost: Share of MWD samples that never arrive.
        mwd_outliers: Share of MWD samples that arrive as a random angle.
        block_slip: (s, m): when and how far the block drops through its brake, or None.
        stall_pressure: Pressure limit of the motor, known, Pa; 0: the rig file's.
        torque_lag: Of the torque sensor, s.
        pressure_lag: Of the pressure sensor, s.
        circulation_ratio: True off-bottom pressure over the rig file's.
        make_up_limit: Torque limit to the right, known, N m; 0: the controller's default.
        back_off_limit: Torque limit to the left, known, N m; 0: the controller's default.
        faults: Lying sensors, and faults of pump, pipe and nozzles.
        rigs: Rig file and true rig, in place of those made from the well's file, or None.
        structure: How plant and instruments differ from the model, or None for a plant of the model's own kind.
    """

    name: str
    well: str
    about: str
    targets: tuple[tuple[float, float], ...] = ((0.0, -70.0),)
    duration: float = 900.0
    start_twist: float = 0.0
    friction_ratio: float = 1.0
    effects: Effects = Effects()
    angle_friction: float = 0.0
    right_friction: float = 0.0
    mwd_period: float = 12.0
    mwd_lost: float = 0.0
    mwd_outliers: float = 0.0
    block_slip: tuple[float, float] | None = None
    stall_pressure: float = 0.0
    torque_lag: float = 0.0
    pressure_lag: float = 0.0
    circulation_ratio: float = 1.0
    make_up_limit: float = 0.0
    back_off_limit: float = 0.0
    faults: tuple[RigFault, ...] = ()
    rigs: tuple[Rig, Rig] | None = None
    structure: Structure | None = None

    @property
    def start(self) -> InitialState:
        return InitialState(twist=self.start_twist)

    def assumed_rig(self) -> Rig:
        """The rig as the controller knows it.

        Raises:
            InputError: The installation lacks the rig file.
        """
        if self.rigs is not None:
            return self.rigs[0]
        rig = load_rig(installed_file(WELLS[self.well]))
        mwd = dataclasses.replace(rig.sensors.mwd, period=self.mwd_period)
        pressure = self.stall_pressure or rig.motor.max_pressure
        return dataclasses.replace(rig, sensors=dataclasses.replace(rig.sensors, mwd=mwd),
                                   motor=dataclasses.replace(rig.motor, max_pressure=pressure))

    def true_rig(self) -> Rig:
        """The rig as it is."""
        if self.rigs is not None:
            return self.rigs[1]
        rig = self.assumed_rig()
        sensors = rig.sensors
        intervals = tuple(dataclasses.replace(interval, factor=interval.factor * self.friction_ratio)
                          for interval in rig.well.friction_intervals)
        torque = dataclasses.replace(sensors.surface_torque, lag=self.torque_lag)
        pressure = dataclasses.replace(sensors.standpipe_pressure, lag=self.pressure_lag)
        circulating = self.circulation_ratio * rig.hydraulics.reference_pressure
        return dataclasses.replace(
            rig, effects=self.effects, hydraulics=dataclasses.replace(rig.hydraulics, reference_pressure=circulating),
            well=dataclasses.replace(rig.well, friction_intervals=intervals),
            sensors=dataclasses.replace(sensors, surface_torque=torque, standpipe_pressure=pressure))

    def target_at(self, time: float) -> float:
        """Toolface target (deg) at `time` (s)."""
        return [target for since, target in self.targets if since <= time][-1]
