"""The effects that a nominal simulation leaves out, as physics of the plant that is neutral until asked for.

Each effect is a block of the rig file (``effects:``) and a law in the one compiled plant. With every
parameter at its default the plant is, bit for bit, the plant without the effect.
"""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.schema import quantity


@dataclass(frozen=True)
class Stribeck:
    """Friction falls with slip speed: ``mu (1 + drop exp(-v / speed))``."""

    drop: float = quantity("-", 0.0, above=-1.0)
    speed: float = quantity("m/s", 0.05, above=0.0)


@dataclass(frozen=True)
class ViscousDrag:
    """Mud drag per metre of string, ``coefficient v``, axial and tangential."""

    coefficient: float = quantity("N s/m2", 0.0, at_least=0.0)


@dataclass(frozen=True)
class StaticAging:
    """Friction grows while a contact rests: ``mu (1 + growth (1 - exp(-t_rest / time)))``.

    A contact rests while it moves slower than rest_speed (axial drilling creep is rest, rocking is not); once it
    moves, the rest time is forgotten over slip_distance of travel.
    """

    growth: float = quantity("-", 0.0, above=-1.0)
    time: float = quantity("s", 5.0, above=0.0)
    rest_speed: float = quantity("m/s", 0.01, above=0.0)
    slip_distance: float = quantity("m", 0.005, above=0.0)


@dataclass(frozen=True)
class BucklingContact:
    """Compressed pipe presses on the wall: ``w_n += factor r T^2 / (4 E I)`` for T < 0, r the radial clearance."""

    factor: float = quantity("-", 0.0, at_least=0.0)


@dataclass(frozen=True)
class CuttingsBed:
    """Friction is multiplied by factor between the measured depths top and bottom."""

    factor: float = quantity("-", 1.0, at_least=0.0)
    top: float = quantity("m", 0.0, at_least=0.0)
    bottom: float = quantity("m", 0.0, at_least=0.0)


@dataclass(frozen=True)
class Tortuosity:
    """Extra local curvature in the open hole (the last friction interval) adds the side force ``|T| curvature``."""

    curvature: float = quantity("rad/m", 0.0, at_least=0.0)


@dataclass(frozen=True)
class FrictionDrift:
    """Friction changes steadily with time: ``mu (1 + rate t)``."""

    rate: float = quantity("1/s", 0.0)


@dataclass(frozen=True)
class TopDriveBacklash:
    """Dead zone of this full width between the drive and the string; the string starts in its middle."""

    angle: float = quantity("rad", 0.0, at_least=0.0)


@dataclass(frozen=True)
class TorsionalCompliance:
    """The string twists more than its section says: G J is divided by 1 + extra."""

    extra: float = quantity("-", 0.0, above=-1.0)


@dataclass(frozen=True)
class AxialOscillationTool:
    """An agitator pushes the string axially at one depth: ``force sin(2 pi frequency t)``."""

    force: float = quantity("N", 0.0, at_least=0.0)
    frequency: float = quantity("Hz", 15.0, above=0.0)
    depth: float = quantity("m", 0.0, at_least=0.0)


@dataclass(frozen=True)
class Heave:
    """The block moves with a wave that no command shows: ``amplitude sin(2 pi t / period + phase)``."""

    amplitude: float = quantity("m", 0.0, at_least=0.0)
    period: float = quantity("s", 10.0, above=0.0)
    phase: float = quantity("rad", 0.0)


@dataclass(frozen=True)
class MotorWear:
    """Torque per pressure is lower by the fraction torque_loss, the motor's leak higher by extra_leak."""

    torque_loss: float = quantity("-", 0.0, below=1.0)
    extra_leak: float = quantity("-", 0.0, below=1.0)


@dataclass(frozen=True)
class FormationChange:
    """From time on, the rock's depth-of-cut stiffness is multiplied by factor."""

    factor: float = quantity("-", 1.0, above=0.0)
    time: float = quantity("s", 0.0, at_least=0.0)


@dataclass(frozen=True)
class TorqueSensorGain:
    """The torque reading is off by a factor: ``torque (1 + gain)``."""

    gain: float = quantity("-", 0.0, above=-1.0)


@dataclass(frozen=True)
class TorqueSensorLag:
    """The torque reading follows the torque with this first-order time constant."""

    lag: float = quantity("s", 0.0, at_least=0.0)


@dataclass(frozen=True)
class TorqueSensorBias:
    """The torque reading is off by a constant."""

    bias: float = quantity("N m", 0.0)


@dataclass(frozen=True)
class TorqueAtMotor:
    """The torque reading is the top drive motor's (its current, say), not the quill's.

    It holds what accelerates the drive, ``inertia d(speed)/dt``, and what turns it in its bearings and gears,
    ``friction sign(speed)``. Both are seen at the quill's speed.
    """

    inertia: float = quantity("kg m2", 0.0, at_least=0.0)
    friction: float = quantity("N m", 0.0, at_least=0.0)


@dataclass(frozen=True)
class Effects:
    """Every effect of the catalogue; the defaults are neutral.

    What is read of a torque passes `torque_at_motor`, then gain, bias and lag of its sensor, in this order.
    """

    stribeck: Stribeck = Stribeck()
    viscous_drag: ViscousDrag = ViscousDrag()
    static_aging: StaticAging = StaticAging()
    buckling_contact: BucklingContact = BucklingContact()
    cuttings_bed: CuttingsBed = CuttingsBed()
    tortuosity: Tortuosity = Tortuosity()
    friction_drift: FrictionDrift = FrictionDrift()
    top_drive_backlash: TopDriveBacklash = TopDriveBacklash()
    torsional_compliance: TorsionalCompliance = TorsionalCompliance()
    axial_oscillation_tool: AxialOscillationTool = AxialOscillationTool()
    heave: Heave = Heave()
    motor_wear: MotorWear = MotorWear()
    formation_change: FormationChange = FormationChange()
    torque_sensor_gain: TorqueSensorGain = TorqueSensorGain()
    torque_sensor_lag: TorqueSensorLag = TorqueSensorLag()
    torque_sensor_bias: TorqueSensorBias = TorqueSensorBias()
    torque_at_motor: TorqueAtMotor = TorqueAtMotor()
