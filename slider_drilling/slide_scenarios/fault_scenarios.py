"""Scenarios of `closed-loop --faults`: every sensor with every kind of fault, and faults of pump, pipe and nozzles.

Each is a slide of 40 minutes at 4.0 km. The controller knows of none. Where a fault can go either way and only one is
listed, it is the one that hides load. A wrong gain is there from the start, as after a wrong calibration.
"""

from __future__ import annotations

import math

from slider_drilling.slide_scenarios.rig_faults import LostFlow, PluggedNozzle, RigFault, SensorFault
from slider_drilling.slide_scenarios.scenario import Scenario

DURATION_S = 2400.0
_WELL = "4.0 km"
_DRIFT_START, _DRIFT_TIME = 300.0, 1200.0   # s; a drift goes on at this rate to the end

# Channel: title, sizes of biases and of drifts within 20 min (SI unit), gain, unit in the table and SI units in it.
_SENSORS = {
    "standpipe_pressure": ("standpipe pressure", (-15e5, 15e5), (-18e5, 18e5), 0.8, "bar", 1e5),
    "surface_torque": ("surface torque", (-2e3, 2e3), (-3e3, 3e3), 0.7, "kN m", 1e3),
    "hook_load": ("hook load", (-50e3, 50e3), (-80e3, 80e3), 0.8, "kN", 1e3),
    "pump_speed": ("pump speed", (1.0,), (1.0,), 1.2, "rad/s", 1.0),
    "block_position": ("block position", (-0.5,), (2.0,), 0.8, "m", 1.0),
    "top_drive_angle": ("top-drive angle", (1.0,), (6.0,), 0.9, "rad", 1.0),
    "mwd": ("MWD toolface", (math.radians(40.0),), (math.radians(60.0),), 0.8, "deg", math.radians(1.0)),
}


def _scenario(name: str, about: str, fault: RigFault) -> Scenario:
    return Scenario(name, _WELL, about, duration=DURATION_S, faults=(fault,))


def _sensor_scenarios(channel: str) -> list[Scenario]:
    title, biases, drifts, gain, unit, scale = _SENSORS[channel]
    scenarios = []
    for bias in biases:
        size = f"{bias / scale:+g} {unit}"
        fault = SensorFault(channel, bias=bias)
        scenarios.append(_scenario(f"{title}: bias {size}", f"off by {size} from 600 s on", fault))
    scenarios.append(_scenario(f"{title}: gain {gain:g}", f"reads {gain:g} times the true value from the start",
                               SensorFault(channel, gain=gain, start=0.0)))
    scenarios.append(_scenario(f"{title}: stuck", "reads the value of 600 s from then on",
                               SensorFault(channel, stuck=True)))
    for drift in drifts:
        size = f"{drift / scale:+g} {unit}"
        fault = SensorFault(channel, drift=drift / _DRIFT_TIME, start=_DRIFT_START)
        scenarios.append(_scenario(f"{title}: drift {size}", f"drifts by {size} in 20 min from 300 s on", fault))
    return scenarios


FAULTS: tuple[Scenario, ...] = (
    _scenario("no fault", "all sensors read what is", SensorFault("surface_torque")),
    _scenario("washout, -10 %", "circulating pressure and motor flow are lost within 20 min", LostFlow(0.10)),
    _scenario("plugged nozzle, +10 %", "circulating pressure rises at once", PluggedNozzle(0.10)),
    _scenario("lost strokes, -10 %", "a valve fails, the stroke counter does not show it", LostFlow(0.10, 600.0, 10.0)),
    _scenario("lost strokes, -30 %", "a valve fails, the stroke counter does not show it", LostFlow(0.30, 600.0, 10.0)),
    *(scenario for channel in _SENSORS for scenario in _sensor_scenarios(channel)),
)  # fmt: skip
