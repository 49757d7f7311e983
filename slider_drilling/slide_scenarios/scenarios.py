"""The default scenarios: everyday slides, and slides on a rig that differs from its file."""

from __future__ import annotations

from slider_drilling.effects import effects_with
from slider_drilling.slide_scenarios.scenario import WELLS, Scenario

_SHORT, _MIDDLE, _LONG = WELLS


def _on_each_well(name: str, about: str, **changes: float) -> tuple[Scenario, ...]:
    return tuple(Scenario(f"{name}, {well}", well, about, **changes) for well in WELLS)  # type: ignore[arg-type]


DAILY: tuple[Scenario, ...] = (
    *_on_each_well("hold", "toolface set from an unknown start and held"),
    *_on_each_well("friction +25 %", "a quarter more friction than in the rig file", friction_ratio=1.25),
    *_on_each_well("friction -25 %", "a quarter less friction than in the rig file", friction_ratio=0.75),
    Scenario("connection", "4.0 km", "toolface half a turn off and string twisted after a connection", ((0.0, 170.0),),
             start_twist=-5.0),
    Scenario("target +45 deg", "4.0 km", "a new target 45 degrees to the right", ((0.0, -70.0), (450.0, -25.0))),
    Scenario("target +180 deg", "4.0 km", "a new target half a turn away", ((0.0, -70.0), (450.0, 110.0))),
    Scenario("formation change", "4.0 km", "rock 60 % harder",
             effects=effects_with(formation_change={"factor": 1.6, "time": 450.0})),
    Scenario("motor stall", "4.0 km", "the block slips 0.6 m and a weak motor stalls", block_slip=(450.0, 0.6),
             stall_pressure=3.2e6),
    Scenario("MWD 12 s, faulty", "4.0 km", "a fifth of the samples lost, one in twenty wrong", mwd_lost=0.2,
             mwd_outliers=0.05),
    Scenario("MWD 30 s, faulty", "4.0 km", "every 30 s, a tenth lost, one in twenty wrong", mwd_period=30.0,
             mwd_lost=0.1, mwd_outliers=0.05),
    Scenario("sensor lag", "4.0 km", "torque 0.5 s late, pressure 3 s", torque_lag=0.5, pressure_lag=3.0),
    Scenario("circulation +2 %", "4.0 km", "off bottom 3.6 bar more than in the rig file", circulation_ratio=1.02),
    Scenario("torque sensor bias", "4.0 km", "surface torque reads 0.5 kN m too high",
             effects=effects_with(torque_sensor_bias={"bias": 500.0})),
    Scenario("weak pipe", "4.0 km", "connections with low torque limits", make_up_limit=7.5e3, back_off_limit=5.0e3),
)

UNKNOWN: tuple[Scenario, ...] = (
    Scenario("string 13 % softer", _MIDDLE, "the pipe twists 13 % more than its sections say", duration=1200.0,
             effects=effects_with(torsional_compliance={"extra": 0.13})),
    Scenario("string 6 % softer", _LONG, "the pipe twists 6 % more than its sections say", duration=1200.0,
             effects=effects_with(torsional_compliance={"extra": 0.06})),
    Scenario("heave", _MIDDLE, "the block heaves by 0.2 m every 11 s", duration=1200.0,
             effects=effects_with(heave={"amplitude": 0.2, "period": 11.0})),
    Scenario("cuttings bed", _LONG, "friction 4.2 times higher over 450 m", duration=1200.0,
             effects=effects_with(cuttings_bed={"factor": 4.2, "top": 3600.0, "bottom": 4050.0})),
    Scenario("friction by angle", _MIDDLE, "friction of each pipe 60 % higher to one side than on average",
             duration=1200.0, angle_friction=0.6),
    Scenario("Stribeck", _LONG, "friction 60 % higher at rest than at speed", duration=1200.0,
             effects=effects_with(stribeck={"drop": 0.6})),
    Scenario("motor 25 % weak", _MIDDLE, "the motor gives a quarter less torque per pressure", duration=1200.0,
             effects=effects_with(motor_wear={"torque_loss": 0.25})),
    Scenario("torque sensor -500 N m", _LONG, "surface torque reads 0.5 kN m too low", duration=1200.0,
             effects=effects_with(torque_sensor_bias={"bias": -500.0})),
    Scenario("target +90 deg", _MIDDLE, "a new target 90 degrees to the right", ((0.0, -70.0), (600.0, 20.0)),
             duration=1200.0),
    Scenario("far targets", _LONG, "new targets 50 degrees and half a turn away",
             ((0.0, -70.0), (500.0, -120.0), (900.0, 60.0)), duration=1200.0),
    Scenario("friction right +30 %", _LONG, "friction 30 % larger turning right than turning left", duration=1200.0,
             right_friction=0.3),
    Scenario("buckling", _LONG, "buckled pipe presses on the wall with the square of its compression",
             duration=1200.0, effects=effects_with(buckling_contact={"factor": 1.0})),
)

SCENARIOS: tuple[Scenario, ...] = (*DAILY, *UNKNOWN)
