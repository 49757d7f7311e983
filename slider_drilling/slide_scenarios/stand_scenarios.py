"""Scenarios of `closed-loop --stands`: rotate, orient, slide, leave, rotate on; rigs that differ from their files."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.effects import effects_with
from slider_drilling.programmes import MakeConnection, Programme, Rotate, Slide, Step, StepLimits
from slider_drilling.programmes.find_programme import find_programme
from slider_drilling.slide_scenarios.scenario import WELLS, Scenario

_SHORT, _MIDDLE, _LONG = WELLS
_ROTARY_SPEED, _ROTATING_RATE = 8.4, 12.0 / 3600.0  # rad/s (80 rpm) and m/s
_ROTATED_BEFORE, _SLID, _ROTATED_AFTER = 1.0, 2.5, 0.5  # m: a slide in a stand, without the long way between
_WEIGHT_LIMIT = 150e3  # N
_TOLERANCE = math.radians(30.0)


@dataclass(frozen=True)
class StandScenario:
    """One stand. The controller does not know how the rig differs from its file.

    Attributes:
        rig: Well, and how it differs; its targets and duration are not used.
        programme: What is done.
    """

    rig: Scenario
    programme: Programme

    @property
    def name(self) -> str:
        """Unique."""
        return self.rig.name

    @property
    def about(self) -> str:
        """One line."""
        return self.rig.about


def stand_programme(tool_face_deg: float = 30.0) -> Programme:
    """Rotate, slide at a toolface (deg), rotate on, connection."""
    steps = (
        Rotate(_ROTARY_SPEED, length=_ROTATED_BEFORE, block_speed=_ROTATING_RATE),
        Slide(math.radians(tool_face_deg), length=_SLID),
        Rotate(_ROTARY_SPEED, length=_ROTATED_AFTER, block_speed=_ROTATING_RATE),
        MakeConnection(time=30.0),
    )
    limits = StepLimits(weight_on_bit=_WEIGHT_LIMIT, tool_face_tolerance=_TOLERANCE)
    return Programme(tuple(Step(action) for action in steps), name="stand", limits=limits)


def _stand(name: str, well: str, about: str, tool_face_deg: float = 30.0, **changes: object) -> StandScenario:
    return StandScenario(Scenario(name, well, about, **changes), stand_programme(tool_face_deg))  # type: ignore[arg-type]


STANDS: tuple[StandScenario, ...] = (
    *(_stand(f"stand, {well}", well, "rotate, slide at 30 degrees, rotate on, connection") for well in WELLS),
    _stand("toolface -120 deg", _MIDDLE, "slide to the lower left", -120.0),
    _stand("toolface 180 deg", _MIDDLE, "slide straight down", 180.0),
    _stand("friction +25 %", _MIDDLE, "a quarter more friction than in the rig file", friction_ratio=1.25),
    _stand("friction -25 %", _LONG, "a quarter less friction than in the rig file", friction_ratio=0.75),
    _stand("MWD 30 s, faulty", _MIDDLE, "every 30 s, a tenth lost, one in twenty wrong", mwd_period=30.0, mwd_lost=0.1,
           mwd_outliers=0.05),
    _stand("motor 25 % weak", _MIDDLE, "the motor gives a quarter less torque per pressure",
           effects=effects_with(motor_wear={"torque_loss": 0.25})),
    _stand("string 13 % softer", _MIDDLE, "the pipe twists 13 % more than its sections say",
           effects=effects_with(torsional_compliance={"extra": 0.13})),
    _stand("harder rock", _SHORT, "rock 60 % harder from 700 s on",
           effects=effects_with(formation_change={"factor": 1.6, "time": 700.0})),
    _stand("cuttings bed", _LONG, "friction 4.2 times higher over 450 m",
           effects=effects_with(cuttings_bed={"factor": 4.2, "top": 3600.0, "bottom": 4050.0})),
    StandScenario(Scenario("whole stand", _MIDDLE, "rotate 20 m, slide 9 m at 30 degrees, rotate 1 m, connection"),
                  find_programme("stand").programme),
)  # fmt: skip
