"""The effects that a nominal simulation leaves out, as physics of the plant that is neutral until asked for.

Each effect is a block of the rig file (``effects:``) and a law in the one compiled plant. With every
parameter at its default the plant is, bit for bit, the plant without the effect.
"""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.schema.fields import quantity


@dataclass(frozen=True)
class Stribeck:
    """Friction falls with slip speed: ``mu (1 + drop exp(-v / speed))``."""

    drop: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of friction; -1 leaves none")
    speed: float = quantity("m/s", 0.05, at_least=1e-4, at_most=10.0, why="slip at which it fades: mm/s to m/s")


@dataclass(frozen=True)
class ViscousDrag:
    """Mud drag per metre of string, ``coefficient v``, axial and tangential."""

    coefficient: float = quantity("N s/m2", 0.0, at_least=0.0, at_most=1e4, why="a metre of string: water 1, mud 100")


@dataclass(frozen=True)
class StaticAging:
    """Friction grows while a contact rests: ``mu (1 + growth (1 - exp(-t_rest / time)))``.

    A contact rests while it moves slower than rest_speed (axial drilling creep is rest, rocking is not); once it
    moves, the rest time is forgotten over slip_distance of travel.
    """

    growth: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of friction; -1 leaves none")
    time: float = quantity("s", 5.0, at_least=1e-2, at_most=1e5, why="of rest: seconds to hours")
    rest_speed: float = quantity("m/s", 0.01, at_least=1e-5, at_most=1.0, why="below rocking, above drilling creep")
    slip_distance: float = quantity("m", 0.005, at_least=1e-5, at_most=100.0, why="asperities to turns of pipe")


@dataclass(frozen=True)
class BucklingContact:
    """Compressed pipe presses on the wall: ``w_n += factor r T^2 / (4 E I)`` for T < 0, r the radial clearance."""

    factor: float = quantity("-", 0.0, at_least=0.0, at_most=20.0, why="1 is a full helix")


@dataclass(frozen=True)
class CuttingsBed:
    """Friction is multiplied by factor between the measured depths top and bottom."""

    factor: float = quantity("-", 1.0, at_least=0.0, at_most=20.0, why="a multiple of the contact's own friction")
    top: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")
    bottom: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")


@dataclass(frozen=True)
class Tortuosity:
    """Extra local curvature in the open hole (the last friction interval) adds the side force ``|T| curvature``."""

    curvature: float = quantity("rad/m", 0.0, at_least=0.0, at_most=0.2, why="1 degree per 30 m is 6e-4")


@dataclass(frozen=True)
class FrictionDrift:
    """Friction changes steadily with time: ``mu (1 + rate t)``."""

    rate: float = quantity("1/s", 0.0, at_least=-0.1, at_most=0.1, why="by a share of friction each second: 1e-4")


@dataclass(frozen=True)
class TopDriveBacklash:
    """Dead zone of this full width between the drive and the string; the string starts in its middle."""

    angle: float = quantity("rad", 0.0, at_least=0.0, at_most=12.6, why="in rad; two turns")


@dataclass(frozen=True)
class TorsionalCompliance:
    """The string twists more than its section says: G J is divided by 1 + extra."""

    extra: float = quantity("-", 0.0, at_least=-0.9, at_most=20.0, why="-0.9 is ten times as stiff")


@dataclass(frozen=True)
class AxialOscillationTool:
    """An agitator pushes the string axially at one depth: ``force sin(2 pi frequency t)``."""

    force: float = quantity("N", 0.0, at_least=0.0, at_most=1e6, why="agitators give 1e+4 to 1e+5")
    frequency: float = quantity("Hz", 15.0, at_least=0.01, at_most=200.0, why="agitators run at 5 to 30")
    depth: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")


@dataclass(frozen=True)
class Heave:
    """The block moves with a wave that no command shows: ``amplitude sin(2 pi t / period + phase)``."""

    amplitude: float = quantity("m", 0.0, at_least=0.0, at_most=3.0, why="half of crest to trough")
    period: float = quantity("s", 10.0, at_least=1.0, at_most=600.0, why="waves 3 to 20, tides of a floater more")
    phase: float = quantity("rad", 0.0, at_least=-12.6, at_most=12.6, why="in rad; two turns")


@dataclass(frozen=True)
class MotorWear:
    """Torque per pressure is lower by the fraction torque_loss, the motor's leak higher by extra_leak."""

    torque_loss: float = quantity("-", 0.0, at_least=-1.0, below=1.0, why="a share; 1 leaves none")
    extra_leak: float = quantity("-", 0.0, at_least=-1.0, below=1.0, why="a share of the flow at max_pressure")


@dataclass(frozen=True)
class FormationChange:
    """From time on, the rock's depth-of-cut stiffness is multiplied by factor."""

    factor: float = quantity("-", 1.0, at_least=0.01, at_most=100.0, why="soft clay to hard stringers")
    time: float = quantity("s", 0.0, at_least=0.0, at_most=1e7, why="since the run began")


@dataclass(frozen=True)
class TorqueSensorGain:
    """The torque reading is off by a factor: ``torque (1 + gain)``."""

    gain: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of the torque; -1 shows none")


@dataclass(frozen=True)
class TorqueSensorLag:
    """The torque reading follows the torque with this first-order time constant."""

    lag: float = quantity("s", 0.0, at_least=0.0, at_most=60.0, why="first order: under a second to some")


@dataclass(frozen=True)
class TorqueSensorBias:
    """The torque reading is off by a constant."""

    bias: float = quantity("N m", 0.0, at_least=-1e5, at_most=1e5, why="in N m, not kN m")


@dataclass(frozen=True)
class TorqueAtMotor:
    """The torque reading is the top drive motor's (its current, say), not the quill's.

    It holds what accelerates the drive, ``inertia d(speed)/dt``, and what turns it in its bearings and gears,
    ``friction sign(speed)``. Both are seen at the quill's speed.
    """

    inertia: float = quantity("kg m2", 0.0, at_least=0.0, at_most=1e5, why="at the quill, gears included: 1e+3 to 5e+3")
    friction: float = quantity("N m", 0.0, at_least=0.0, at_most=1e5, why="in N m, not kN m; of bearings and gears")


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
