"""Static torque and drag against closed forms, and against the moving plant."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, load_rig
from slider_drilling.wellbore.static_loads import static_loads

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
RADIUS = 0.127 / 2
WEIGHT = 9.81 * (RIG.string.density - RIG.mud.density) * math.pi / 4 * (0.127**2 - 0.1086**2)  # N/m


def in_well(*survey: tuple[float, float, float], mud_density: float = RIG.mud.density) -> Rig:
    """One pipe of 4 km in this well, without friction intervals."""
    pipe = dataclasses.replace(RIG.string.sections[0], length=4000.0, outer_diameter=0.127, inner_diameter=0.1086)
    return dataclasses.replace(
        RIG,
        well=dataclasses.replace(RIG.well, survey=survey, friction_intervals=()),
        string=dataclasses.replace(RIG.string, sections=(pipe,)),
        mud=dataclasses.replace(RIG.mud, density=mud_density),
    )


def test_vertical_string_has_no_drag():
    rig = in_well((0.0, 0.0, 0.0), (4000.0, 0.0, 0.0))
    for motion in ({}, {"axial_speed": 0.1}, {"axial_speed": -0.1}, {"rotation_speed": 2.0}):
        loads = static_loads(rig, **motion)
        assert loads.hook_load == pytest.approx(WEIGHT * 4000.0, rel=1e-9)
        assert loads.surface_torque == pytest.approx(0.0, abs=1e-6)
    assert static_loads(rig, weight_on_bit=50e3).hook_load == pytest.approx(WEIGHT * 4000.0 - 50e3)


def test_horizontal_drag_is_friction_times_weight():
    """Lowering is held back by mu w L, raising needs it, turning takes mu w L R and no tension."""
    rig = in_well((0.0, 90.0, 30.0), (4000.0, 90.0, 30.0))
    drag = 0.3 * WEIGHT * 4000.0
    assert static_loads(rig, axial_speed=0.1, friction_coefficient=0.3).hook_load == pytest.approx(-drag)
    assert static_loads(rig, axial_speed=-0.1, friction_coefficient=0.3).hook_load == pytest.approx(drag)
    turned = static_loads(rig, rotation_speed=2.0, bit_torque=500.0, friction_coefficient=0.3)
    assert turned.hook_load == pytest.approx(0.0, abs=1e-6)
    assert turned.surface_torque == pytest.approx(500.0 + drag * RADIUS)
    backwards = static_loads(rig, rotation_speed=-2.0, friction_coefficient=0.3)
    assert backwards.surface_torque == pytest.approx(-drag * RADIUS)
    # a helix shares the friction by the two speeds
    both = static_loads(rig, axial_speed=-0.3, rotation_speed=0.4 / RADIUS, friction_coefficient=0.3)
    assert both.hook_load == pytest.approx(0.6 * drag)
    assert both.surface_torque == pytest.approx(0.8 * drag * RADIUS)


@pytest.mark.parametrize("end", [(90.0, 0.0), (90.0, 90.0)])
@pytest.mark.parametrize(("speed", "sign"), [(-1.0, 1.0), (1.0, -1.0)])
def test_weightless_bend_follows_capstan_equation(end, speed, sign):
    """T = T0 exp(mu angle), in a plane of any orientation."""
    start = (0.0, 0.0) if end[1] == 0.0 else (90.0, 0.0)
    rig = in_well((0.0, *start), (4000.0, *end), mud_density=RIG.string.density)
    loads = static_loads(rig, axial_speed=speed, weight_on_bit=-1e5, friction_coefficient=0.3)
    assert loads.hook_load == pytest.approx(1e5 * math.exp(sign * 0.3 * math.pi / 2), rel=1e-5)
    # pulling or pushing, a bend presses with T per radius
    assert loads.side_force == pytest.approx(
        0.5 * (loads.tension[:-1] + loads.tension[1:]) * math.pi / 2 / 4000.0, rel=1e-4)  # fmt: skip


def test_raising_through_build_matches_closed_form():
    """Through a dropping-tension build (T / R > w sin t throughout) the string lies on the high side, and

    dT/dt = mu (T - w R sin t) - w R cos t going down; here integrated up with an integrating factor.
    """
    mu, angle, bend_radius = 0.3, math.pi / 2, 4000.0 / (math.pi / 2)
    rig = in_well((0.0, 0.0, 0.0), (4000.0, 90.0, 0.0))
    pull = 3e6  # enough to lie on the high side all the way
    loads = static_loads(rig, axial_speed=-0.1, weight_on_bit=-pull, friction_coefficient=mu, elements=400)
    w_r = WEIGHT * bend_radius
    # with s from the bit up, b = angle - t: dT/db = mu T + w R (cos t - mu sin t)
    b = np.linspace(0.0, angle, 200_001)
    source = w_r * (np.cos(angle - b) - mu * np.sin(angle - b)) * np.exp(-mu * b)
    integral = np.sum(0.5 * (source[:-1] + source[1:]) * np.diff(b))
    assert loads.hook_load == pytest.approx(math.exp(mu * angle) * (pull + integral), rel=1e-5)


def test_error_falls_with_square_of_element_length():
    rig = in_well((0.0, 0.0, 0.0), (4000.0, 90.0, 0.0), mud_density=RIG.string.density)
    exact = 1e5 * math.exp(0.5 * math.pi / 2)
    error = [
        abs(static_loads(rig, -1.0, weight_on_bit=-1e5, friction_coefficient=0.5, elements=n).hook_load - exact)
        for n in (10, 20, 40)
    ]
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.05)
    assert error[1] / error[2] == pytest.approx(4.0, rel=0.05)


def test_friction_depends_on_slip_direction():
    rig = in_well((0.0, 90.0, 0.0), (4000.0, 90.0, 0.0))
    along, across = friction_coefficient_of_direction(RIG.contact, np.array([0.0, math.pi / 2]))
    assert along > across
    assert static_loads(rig, axial_speed=-1.0).hook_load == pytest.approx(along * WEIGHT * 4000.0)
    assert static_loads(rig, rotation_speed=1.0).surface_torque == pytest.approx(across * WEIGHT * 4000.0 * RADIUS)


def test_contact_effects_enter_static_loads():
    """Weightless straight pipe under 100 kN: buckled it presses with r F^2 / (4 E I), in a bed it takes twice that."""
    rig = in_well((0.0, 90.0, 0.0), (4000.0, 90.0, 0.0), mud_density=RIG.string.density)
    turned = {"rotation_speed": 1.0, "weight_on_bit": 1e5, "friction_coefficient": 0.3}
    assert static_loads(rig, **turned).surface_torque == pytest.approx(0.0, abs=1e-6)
    buckled = dataclasses.replace(rig.effects, buckling_contact=dataclasses.replace(
        rig.effects.buckling_contact, factor=2.0))
    bending = 4.0 * rig.string.youngs_modulus * math.pi / 64.0 * (0.127**4 - 0.1086**4)
    pressed = 2.0 * 0.5 * (rig.well.hole_diameter - 0.127) / bending * 1e10
    alone = static_loads(dataclasses.replace(rig, effects=buckled), **turned)
    assert alone.side_force == pytest.approx(pressed, rel=1e-6)
    assert alone.surface_torque == pytest.approx(0.3 * pressed * 4000.0 * RADIUS, rel=1e-6)
    bed = dataclasses.replace(buckled, cuttings_bed=dataclasses.replace(
        rig.effects.cuttings_bed, factor=2.0, top=1000.0, bottom=3000.0))
    both = static_loads(dataclasses.replace(rig, effects=bed), **turned)
    assert both.surface_torque == pytest.approx(1.5 * alone.surface_torque, rel=1e-6)


def lowered(rig: Rig, speed: float) -> float:
    """Hook load of the moving plant after it has been lowered for two minutes."""
    pump = RIG.hydraulics.reference_flow / RIG.mud_pump.displacement
    time = np.arange(0.0, 120.05, 0.1)
    block_speed = speed * (1.0 - np.exp(-time / 2.0))
    commands = Commands(time, 0 * time, 0 * time, speed * time - 2.0 * block_speed, block_speed, 0 * time + pump)
    return float(simulate(rig, commands, elements=100).hook_load[-100:].mean())


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_moving_plant_settles_to_static_loads(direction):
    """The string's own damping, proportional to speed, distinguishes them: none is left at zero speed."""
    rig = dataclasses.replace(RIG, bit=dataclasses.replace(RIG.bit, depth_of_cut_stiffness=1e-9))
    at_rest = 2.0 * lowered(rig, 0.05 * direction) - lowered(rig, 0.1 * direction)
    assert at_rest == pytest.approx(static_loads(rig, axial_speed=direction, elements=100).hook_load, rel=2e-4)


@pytest.mark.parametrize(("name", "value"), [
    ("axial_speed", math.nan), ("weight_on_bit", math.inf), ("friction_coefficient", -0.1),
])  # fmt: skip
def test_invalid_arguments_are_named(name, value):
    with pytest.raises(InputError, match=name):
        static_loads(RIG, **{name: value})


@pytest.mark.parametrize("name", ["rig.short.yaml", "rig.example.yaml", "rig.long.yaml"])
@pytest.mark.parametrize("weight_on_bit", [0.0, 8e4])
def test_controller_torque_drag_matches_the_plant(name, weight_on_bit):
    """Control's belief is of a string that only turns."""
    rig = load_rig(Path(__file__).parents[1] / "config" / name)
    believed = TorqueAndDrag(rig, 0.235, weight_on_bit)
    loads = static_loads(rig, rotation_speed=1.0, weight_on_bit=weight_on_bit, friction_coefficient=0.235, elements=400)
    assert believed.breakover_torque(1e3, 1.0) == pytest.approx(loads.surface_torque, rel=0.01)
