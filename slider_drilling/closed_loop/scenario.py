"""What a controller is put through: a well, what differs from its belief, and what goes wrong."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from slider_drilling.drillstring import Start
from slider_drilling.rig import Rig, load_rig
from slider_drilling.share import share_file

WELLS = {"2.6 km": "config/rig.short.yaml", "4.0 km": "config/rig.example.yaml", "5.6 km": "config/rig.long.yaml"}


@dataclass(frozen=True)
class Scenario:
    """One slide. Everything that differs from the rig file is unknown to the controller.

    well: a key of `WELLS`; targets: (s, deg) from which each tool-face is asked for, the first one at 0;
    which is as good as a start at any other angle; start_twist: rad, wound into the string;
    friction: truth over the rig file; formation: (s, factor on the rock's stiffness) or none; lost, outliers: share
    of MWD samples that never come, or come as any angle; slip: (s, m) by which the block drops through its brake, or
    none; stall_pressure: Pa, of a motor weaker than usual (known), 0: the rig file's; torque_lag, pressure_lag: s,
    of the sensors; circulation: true pressure off bottom over the rig file's; torque_bias: N m that the
    sensor shows too much; make_up_limit, back_off_limit: N m (known), 0: the controller's default.
    """

    name: str
    well: str
    about: str
    targets: tuple[tuple[float, float], ...] = ((0.0, -70.0),)
    duration: float = 900.0
    start_twist: float = 0.0
    friction: float = 1.0
    formation: tuple[float, float] | None = None
    mwd_period: float = 12.0
    lost: float = 0.0
    outliers: float = 0.0
    slip: tuple[float, float] | None = None
    stall_pressure: float = 0.0
    torque_lag: float = 0.0
    pressure_lag: float = 0.0
    circulation: float = 1.0
    torque_bias: float = 0.0
    make_up_limit: float = 0.0
    back_off_limit: float = 0.0

    @property
    def start(self) -> Start:
        return Start(twist=self.start_twist)

    def believed_rig(self) -> Rig:
        """What the controller is told. Raises InputError where the installation lacks the rig file."""
        rig = load_rig(share_file(WELLS[self.well]))
        mwd = dataclasses.replace(rig.sensors.mwd, period=self.mwd_period)
        pressure = self.stall_pressure or rig.motor.max_pressure
        return dataclasses.replace(rig, sensors=dataclasses.replace(rig.sensors, mwd=mwd),
                                   motor=dataclasses.replace(rig.motor, max_pressure=pressure))

    def true_rig(self) -> Rig:
        """What it meets."""
        rig = self.believed_rig()
        sensors, effects = rig.sensors, rig.effects
        intervals = tuple(dataclasses.replace(one, factor=one.factor * self.friction)
                          for one in rig.well.friction_intervals)
        torque = dataclasses.replace(sensors.surface_torque, lag=self.torque_lag)
        pressure = dataclasses.replace(sensors.standpipe_pressure, lag=self.pressure_lag)
        if self.formation is not None:
            time, factor = self.formation
            change = dataclasses.replace(effects.formation_change, time=time, factor=factor)
            effects = dataclasses.replace(effects, formation_change=change)
        effects = dataclasses.replace(
            effects, torque_sensor_bias=dataclasses.replace(effects.torque_sensor_bias, bias=self.torque_bias))
        circulating = self.circulation * rig.hydraulics.reference_pressure
        return dataclasses.replace(
            rig, effects=effects, hydraulics=dataclasses.replace(rig.hydraulics, reference_pressure=circulating),
            well=dataclasses.replace(rig.well, friction_intervals=intervals),
            sensors=dataclasses.replace(sensors, surface_torque=torque, standpipe_pressure=pressure))

    def target_at(self, time: float) -> float:
        """Target (deg) asked for at `time` (s)."""
        return [target for since, target in self.targets if since <= time][-1]


def _three(name: str, about: str, **what: float) -> tuple[Scenario, ...]:
    return tuple(Scenario(f"{name}, {well}", well, about, **what) for well in WELLS)  # type: ignore[arg-type]


SCENARIOS: tuple[Scenario, ...] = (
    *_three("hold", "tool-face set from an unknown start and held"),
    *_three("friction +25 %", "a quarter more friction than believed", friction=1.25),
    *_three("friction -25 %", "a quarter less friction than believed", friction=0.75),
    Scenario("connection", "4.0 km", "half a turn off and wound up after a connection", ((0.0, 170.0),),
             start_twist=-5.0),
    Scenario("target +45 deg", "4.0 km", "a new target 45 degrees to the right", ((0.0, -70.0), (450.0, -25.0))),
    Scenario("target +180 deg", "4.0 km", "a new target half a turn away", ((0.0, -70.0), (450.0, 110.0))),
    Scenario("formation change", "4.0 km", "rock 60 % harder", formation=(450.0, 1.6)),
    Scenario("motor stall", "4.0 km", "the block slips 0.6 m and a weak motor stalls", slip=(450.0, 0.6),
             stall_pressure=3.2e6),
    Scenario("MWD 12 s, faulty", "4.0 km", "a fifth of the samples lost, one in twenty wrong", lost=0.2, outliers=0.05),
    Scenario("MWD 30 s, faulty", "4.0 km", "every 30 s, a tenth lost, one in twenty wrong", mwd_period=30.0, lost=0.1,
             outliers=0.05),
    Scenario("sensor lag", "4.0 km", "torque 0.5 s late, pressure 3 s", torque_lag=0.5, pressure_lag=3.0),
    Scenario("circulation +2 %", "4.0 km", "off bottom 3.6 bar more than believed", circulation=1.02),
    Scenario("torque sensor bias", "4.0 km", "surface torque reads 0.5 kN m too high", torque_bias=500.0),
    Scenario("weak pipe", "4.0 km", "connections that bear little torque", make_up_limit=7.5e3, back_off_limit=5.0e3),
)
