"""What a controller is put through: a well, what differs from its belief, and what goes wrong."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from slider_drilling.drillstring import InitialState
from slider_drilling.effects import Effects
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, load_rig

WELLS = {"2.6 km": "config/rig.short.yaml", "4.0 km": "config/rig.example.yaml", "5.6 km": "config/rig.long.yaml"}


@dataclass(frozen=True)
class Scenario:
    """One slide. Everything that differs from the rig file is unknown to the controller.

    well: a key of `WELLS`; targets: (s, deg) from which each toolface is asked for, the first one at 0;
    which is as good as a start at any other angle; start_twist: rad, wound into the string;
    friction: truth over the rig file; effects: of the catalogue, as in a rig file; angle_friction: share by which
    friction rises and falls once a turn of each pipe; lost, outliers: share of MWD samples that never come, or come as
    any angle; slip: (s, m) by which the block drops through its brake, or none; stall_pressure: Pa, of a motor weaker
    than usual (known), 0: the rig file's; torque_lag, pressure_lag: s, of the sensors; circulation: true pressure off
    bottom over the rig file's; make_up_limit, back_off_limit: N m (known), 0: the controller's default;
    rigs: what is believed and what is true, in place of all that would be made of the well's file, or none.
    """

    name: str
    well: str
    about: str
    targets: tuple[tuple[float, float], ...] = ((0.0, -70.0),)
    duration: float = 900.0
    start_twist: float = 0.0
    friction: float = 1.0
    effects: Effects = Effects()
    angle_friction: float = 0.0
    mwd_period: float = 12.0
    lost: float = 0.0
    outliers: float = 0.0
    slip: tuple[float, float] | None = None
    stall_pressure: float = 0.0
    torque_lag: float = 0.0
    pressure_lag: float = 0.0
    circulation: float = 1.0
    make_up_limit: float = 0.0
    back_off_limit: float = 0.0
    rigs: tuple[Rig, Rig] | None = None

    @property
    def start(self) -> InitialState:
        return InitialState(twist=self.start_twist)

    def believed_rig(self) -> Rig:
        """What the controller is told. Raises InputError where the installation lacks the rig file."""
        if self.rigs is not None:
            return self.rigs[0]
        rig = load_rig(installed_file(WELLS[self.well]))
        mwd = dataclasses.replace(rig.sensors.mwd, period=self.mwd_period)
        pressure = self.stall_pressure or rig.motor.max_pressure
        return dataclasses.replace(rig, sensors=dataclasses.replace(rig.sensors, mwd=mwd),
                                   motor=dataclasses.replace(rig.motor, max_pressure=pressure))

    def true_rig(self) -> Rig:
        """What it meets."""
        if self.rigs is not None:
            return self.rigs[1]
        rig = self.believed_rig()
        sensors = rig.sensors
        intervals = tuple(dataclasses.replace(one, factor=one.factor * self.friction)
                          for one in rig.well.friction_intervals)
        torque = dataclasses.replace(sensors.surface_torque, lag=self.torque_lag)
        pressure = dataclasses.replace(sensors.standpipe_pressure, lag=self.pressure_lag)
        circulating = self.circulation * rig.hydraulics.reference_pressure
        return dataclasses.replace(
            rig, effects=self.effects, hydraulics=dataclasses.replace(rig.hydraulics, reference_pressure=circulating),
            well=dataclasses.replace(rig.well, friction_intervals=intervals),
            sensors=dataclasses.replace(sensors, surface_torque=torque, standpipe_pressure=pressure))

    def target_at(self, time: float) -> float:
        """Target (deg) asked for at `time` (s)."""
        return [target for since, target in self.targets if since <= time][-1]
