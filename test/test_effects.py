"""Each effect changes the plant as its law says; a neutral effect changes nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from steady import EXAMPLE, commands, with_effect

from slider_drilling.drillstring import Commands, Plant, simulate
from slider_drilling.drillstring.fast_arithmetic import fast_exp
from slider_drilling.effects import (
    AxialOscillationTool,
    BucklingContact,
    CuttingsBed,
    Effects,
    FormationChange,
    FrictionDrift,
    Heave,
    MotorWear,
    StaticAging,
    Stribeck,
    TopDriveBacklash,
    TorqueAtMotor,
    TorqueSensorBias,
    TorqueSensorGain,
    TorqueSensorLag,
    TorsionalCompliance,
    Tortuosity,
    ViscousDrag,
)
from slider_drilling.rig import FrictionInterval, Rig, StringSection


def horizontal(length: float = 200.0, friction: float = 1.0) -> Rig:
    """A short pipe that lies in a horizontal hole: its side force is its weight, whatever the tension."""
    well = dataclasses.replace(
        EXAMPLE.well,
        survey=((0.0, 90.0, 0.0), (length, 90.0, 0.0)),
        friction_intervals=(FrictionInterval(length, friction),),
    )
    pipe = dataclasses.replace(EXAMPLE.string.sections[0], length=length)
    return dataclasses.replace(EXAMPLE, well=well, string=dataclasses.replace(EXAMPLE.string, sections=(pipe,)))


def settled(response, name: str) -> float:
    values = getattr(response, name)
    return float(np.mean(values[len(values) * 3 // 4 :]))


def turning_torque(rig: Rig, speed: float, elements: int = 20) -> float:
    return settled(simulate(rig, commands(60.0, speed=speed), elements), "surface_torque")


def damping_torque(speed: float) -> float:
    """Of the horizontal pipe as a whole, turned steadily, N m."""
    return 0.15 * speed * 7850.0 * math.pi / 32 * (0.127**4 - 0.1086**4) * 200.0


@pytest.mark.parametrize(
    "neutral",
    [
        {"stribeck": Stribeck(0.0, 0.2)},
        {"viscous_drag": ViscousDrag(0.0)},
        {"static_aging": StaticAging(0.0, 1.0, 0.1, 0.1)},
        {"buckling_contact": BucklingContact(0.0)},
        {"cuttings_bed": CuttingsBed(1.0, 100.0, 3000.0)},
        {"tortuosity": Tortuosity(0.0)},
        {"friction_drift": FrictionDrift(0.0)},
        {"top_drive_backlash": TopDriveBacklash(0.0)},
        {"torsional_compliance": TorsionalCompliance(0.0)},
        {"axial_oscillation_tool": AxialOscillationTool(0.0, 12.0, 3000.0)},
        {"heave": Heave(0.0, 7.0, 1.0)},
        {"motor_wear": MotorWear(0.0, 0.0)},
        {"formation_change": FormationChange(1.0, 3.0)},
        {"torque_sensor_gain": TorqueSensorGain(0.0)},
        {"torque_sensor_lag": TorqueSensorLag(0.0)},
        {"torque_sensor_bias": TorqueSensorBias(0.0)},
        {"torque_at_motor": TorqueAtMotor(0.0, 0.0)},
    ],
    ids=lambda effect: next(iter(effect)),
)
def test_neutral_effect_changes_no_bit(neutral):
    run = commands(8.0, speed=1.5, block_speed=0.003)
    plain = simulate(EXAMPLE, run, elements=40)
    same = simulate(with_effect(EXAMPLE, **neutral), run, elements=40)
    for field in dataclasses.fields(plain):
        assert np.array_equal(getattr(plain, field.name), getattr(same, field.name)), field.name


def test_every_effect_is_tested_for_neutrality():
    marks = test_neutral_effect_changes_no_bit.pytestmark
    tested = {next(iter(effect)) for mark in marks for effect in mark.args[1]}
    assert tested == {field.name for field in dataclasses.fields(Effects)}


def test_fast_exponential_is_accurate():
    x = np.linspace(0.0, 60.0, 4001)
    assert max(abs(1.0 / fast_exp(value, np.float64) - math.exp(-value)) for value in x) < 5e-6


@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0])
def test_stribeck_scales_the_turning_torque(speed):
    """Damped enough that friction which falls with speed does not shake the pipe."""
    rig = horizontal()
    rig = dataclasses.replace(rig, string=dataclasses.replace(rig.string, torsional_damping=15.0))
    slip = speed * 0.0635
    with_and_without = (with_effect(rig, stribeck=Stribeck(0.5, 0.05)), rig)
    torque = [turning_torque(r, speed) - 100.0 * damping_torque(speed) for r in with_and_without]
    ratio = torque[0] / torque[1]
    assert ratio == pytest.approx(1.0 + 0.5 * math.exp(-slip / 0.05), rel=2e-3)


def test_viscous_drag_torque_is_proportional_to_speed():
    """Its torque on the whole pipe is c v R per metre; damping, in both runs alike, cancels."""
    rig, coefficient, speed = horizontal(), 20.0, 2.0
    more = turning_torque(with_effect(rig, viscous_drag=ViscousDrag(coefficient)), speed) - turning_torque(rig, speed)
    assert more == pytest.approx(coefficient * speed * 0.0635**2 * 200.0, rel=0.01)


def test_viscous_drag_holds_the_string_back_axially():
    rig, coefficient = horizontal(friction=0.0), 400.0
    still_pump = commands(60.0, block_speed=0.05, pump=0.0)
    up = dataclasses.replace(still_pump, block_position=-still_pump.block_position, block_speed=-still_pump.block_speed)
    pull = [
        settled(simulate(r, up, 20), "hook_load")
        for r in (rig, with_effect(rig, viscous_drag=ViscousDrag(coefficient)))
    ]
    assert pull[1] - pull[0] == pytest.approx(coefficient * 0.05 * 200.0, rel=0.01)


def test_static_aging_raises_breakaway_with_time_at_rest():
    """Rest, then turn slowly: breakaway over that of an ageless contact grows with 1 - exp(-t / time)."""

    def breakaway(rest: float, growth: float) -> float:
        rig = with_effect(horizontal(), static_aging=StaticAging(growth, 5.0, 0.01, 0.1))
        time = np.arange(0.0, rest + 20.0, 0.05)
        turning = np.clip(time - rest, 0.0, None)
        still = np.zeros_like(time)
        run = Commands(time, 0.5 * turning, 0.5 * (turning > 0), still, still, still)
        return float(np.max(simulate(rig, run, 20).surface_torque))

    ratio = [breakaway(rest, 0.4) / breakaway(rest, 0.0) for rest in (1.0, 5.0, 30.0)]
    assert 1.0 < ratio[0] < ratio[1] < ratio[2] <= 1.4
    assert ratio[2] > 1.2


@pytest.mark.parametrize(
    "alone", [{"static_aging": StaticAging(0.4, 5.0, 0.01, 0.1)}, {"friction_drift": FrictionDrift(1e-3)}]
)
def test_effects_in_one_pass_act_independently(alone):
    """A drop of friction too small to tell takes the same string through both passes of the step."""
    time = np.arange(0.0, 20.0, 0.05)
    still = np.zeros_like(time)
    run = Commands(time, 0.5 * np.clip(time - 10.0, 0.0, None), 0.5 * (time > 10.0), still, still, still)
    by_itself = simulate(with_effect(horizontal(), **alone), run, 20).surface_torque
    beside = simulate(with_effect(horizontal(), **alone, stribeck=Stribeck(1e-9, 0.1)), run, 20).surface_torque
    np.testing.assert_allclose(beside, by_itself, rtol=1e-4, atol=0.1)


def test_buckling_presses_compressed_pipe_on_the_wall():
    """Pushed by a stalled bit the pipe's side force grows by k r T^2 / (4 E I) where T < 0 and nowhere else."""
    rig = horizontal(friction=0.3)
    run = commands(40.0, block_speed=0.003)
    for effect in (BucklingContact(0.0), BucklingContact(1.0)):
        plant = Plant(with_effect(rig, buckling_contact=effect), 20)
        plant.advance(run)
        profile = plant.profile()
        weight = 9.81 * 6650.0 * math.pi / 4 * (0.127**2 - 0.1086**2)
        bending = 4.0 * rig.string.youngs_modulus * math.pi / 64 * (0.127**4 - 0.1086**4)
        clearance = 0.5 * (rig.well.hole_diameter - 0.127)
        extra = effect.factor * clearance * np.minimum(profile.tension, 0.0) ** 2 / bending
        assert np.min(profile.tension) < -1e4
        assert profile.normal_force == pytest.approx(weight + extra, rel=1e-9)


def test_buckling_raises_axial_drag():
    """Lowered without rocking, friction eats the weight: the bit gets less of the same slack-off with buckling."""
    rig = horizontal(400.0)
    run = commands(120.0, block_speed=0.004)
    rigs = [with_effect(rig, buckling_contact=BucklingContact(k)) for k in (0.0, 1.0)]
    weight = [settled(simulate(one, run, 40), "hook_load") for one in rigs]
    assert weight[1] < weight[0] - 500.0


def test_cuttings_bed_acts_within_its_interval_only():
    rig = horizontal()
    speed = 1.0
    base = turning_torque(rig, speed)
    bed = turning_torque(with_effect(rig, cuttings_bed=CuttingsBed(1.8, 63.0, 113.0)), speed)
    drag = damping_torque(speed)
    assert (bed - drag) / (base - drag) == pytest.approx(1.0 + 0.8 * 50.0 / 200.0, rel=2e-3)


def test_tortuosity_adds_side_force_where_there_is_tension():
    """Only the open hole is tortuous: the side force there grows by |T| curvature."""
    plants = [Plant(with_effect(EXAMPLE, tortuosity=Tortuosity(k)), 100) for k in (0.0, 2e-4)]
    for plant in plants:
        plant.advance(commands(10.0, speed=1.0))
    plain, tortuous = (plant.profile() for plant in plants)
    cased = tortuous.measured_depth < 2400.0 - 40.0
    open_hole = tortuous.measured_depth > 2400.0 + 40.0
    assert tortuous.normal_force[cased] == pytest.approx(plain.normal_force[cased], rel=0.02)
    mesh = plants[1].mesh
    weight = 9.81 * 6650.0 * mesh.area
    expected = weight + np.abs(tortuous.tension) * 2e-4
    assert tortuous.normal_force[open_hole] == pytest.approx(expected[open_hole], rel=1e-6)


def test_tortuosity_raises_the_turning_torque():
    """Once there is weight on bit: off bottom a horizontal string holds no axial force for curvature to turn."""
    run = commands(150.0, speed=2.0, block_speed=0.004)
    rigs = [with_effect(EXAMPLE, tortuosity=Tortuosity(k)) for k in (0.0, 5e-4)]
    torque = [settled(simulate(rig, run, 60), "surface_torque") for rig in rigs]
    assert torque[1] > torque[0] + 100.0


def test_friction_drifts_steadily():
    rig = with_effect(horizontal(), friction_drift=FrictionDrift(0.005))
    response = simulate(rig, commands(100.0, speed=1.0), 20)
    friction = response.surface_torque - damping_torque(1.0)
    at = {t: float(np.interp(t, response.time, friction)) for t in (30.0, 90.0)}
    assert at[90.0] / at[30.0] == pytest.approx(1.45 / 1.15, rel=2e-3)


def test_backlash_is_a_dead_zone_of_its_width():
    """Turned to and fro within the dead zone the string feels nothing; beyond it, what is left of the angle."""
    rig = with_effect(horizontal(), top_drive_backlash=TopDriveBacklash(0.3))
    time = np.arange(0.0, 20.0, 0.1)
    within = 0.14 * np.sin(time)
    still = np.zeros_like(time)
    run = Commands(time, within, 0.14 * np.cos(time), still, still, still)
    assert np.max(np.abs(simulate(rig, run, 20).surface_torque)) < 1e-9
    turn = commands(20.0, speed=0.05)
    free = simulate(horizontal(), dataclasses.replace(turn, top_drive_angle=turn.top_drive_angle - 0.15), 20)
    after = simulate(rig, turn, 20)
    assert after.surface_torque[-1] == pytest.approx(free.surface_torque[-1], rel=0.05)
    assert np.all(np.abs(after.surface_torque[turn.top_drive_angle < 0.15]) < 1e-9)


def test_backlash_releases_a_wound_string_first():
    """On its way back the drive crosses the dead zone where the torque is zero, not where it is largest."""
    rig = with_effect(horizontal(), top_drive_backlash=TopDriveBacklash(2.0))
    time = np.arange(0.0, 80.0, 0.1)
    omega = 2.0 * np.pi / 40.0
    still = np.zeros_like(time)
    run = Commands(time, 6.0 * np.sin(omega * time), 6.0 * omega * np.cos(omega * time), still, still, still)
    torque = simulate(rig, run, 20).surface_torque[400:]
    largest = np.max(np.abs(torque))
    idle = np.abs(torque) < 1e-3 * largest
    assert 0.1 * np.mean(idle) * 40.0 > 0.1
    just_after_turning = (time[400:] > 50.1) & (time[400:] < 50.5)
    held = simulate(horizontal(), run, 20).surface_torque[400:]
    slope = np.diff(torque[just_after_turning]).mean()
    assert slope == pytest.approx(np.diff(held[just_after_turning]).mean(), rel=0.5)
    assert slope < 0.0


def test_torsional_compliance_adds_twist():
    """The stuck end of a long string: torque per angle falls by 1 + extra."""
    length = 2000.0
    rig = horizontal(length)
    stuck = dataclasses.replace(rig, well=dataclasses.replace(rig.well, friction_intervals=(
        FrictionInterval(1000.0, 0.0), FrictionInterval(length, 50.0))))  # fmt: skip
    time = np.arange(0.0, 60.0, 0.1)
    ramp = 1.0 - np.exp(-time / 8.0)
    still = np.zeros_like(time)
    run = Commands(time, 2.0 * ramp, 0.25 * (1.0 - ramp), still, still, still)
    damped = dataclasses.replace(stuck, string=dataclasses.replace(stuck.string, torsional_damping=2.0))
    torque = [
        settled(simulate(with_effect(damped, torsional_compliance=TorsionalCompliance(c)), run, 100), "surface_torque")
        for c in (0.0, 0.25)
    ]
    assert torque[0] / torque[1] == pytest.approx(1.25, rel=0.02)


def test_agitator_acts_at_its_depth_and_frequency():
    rig = with_effect(horizontal(friction=0.0), axial_oscillation_tool=AxialOscillationTool(5000.0, 4.0, 150.0))
    plant = Plant(rig, 40, interval=0.02)
    time = np.arange(0.0, 10.0, 0.02)
    still = np.zeros_like(time)
    hook = plant.advance(Commands(time, still, still, still, still, still)).hook_load
    spectrum = np.abs(np.fft.rfft(hook - hook.mean()))
    assert np.fft.rfftfreq(len(hook), 0.02)[np.argmax(spectrum)] == pytest.approx(4.0, abs=0.11)
    assert np.ptp(hook) > 1000.0


def test_heave_moves_block_and_hook_load():
    """Slow heave of a free string hung off bottom: hook load follows in phase with no motion of the commands."""
    rig = with_effect(EXAMPLE, heave=Heave(0.05, 8.0, 0.3))
    response = simulate(rig, commands(40.0, pump=0.0), 40)
    late = response.time > 16.0
    wave = np.exp(-2j * math.pi * response.time[late] / 8.0)
    swing = 2.0 * np.abs(np.mean((response.hook_load[late] - response.hook_load[late].mean()) * wave))
    assert swing > 2000.0
    calm = simulate(EXAMPLE, commands(40.0, pump=0.0), 40)
    assert np.ptp(calm.hook_load) < 1.0


def test_worn_motor_needs_more_pressure():
    rig = horizontal(friction=0.0)
    run = commands(60.0, block_speed=0.004)
    new = simulate(rig, run, 20)
    worn = simulate(with_effect(rig, motor_wear=MotorWear(0.2, 0.0)), run, 20)
    assert worn.bit_torque[-1] == pytest.approx(new.bit_torque[-1], rel=0.02)
    assert worn.differential_pressure[-1] / worn.bit_torque[-1] == pytest.approx(1.0 / (0.8 * 1.6e-3))
    leaking = simulate(with_effect(rig, motor_wear=MotorWear(0.0, 0.5)), run, 20)
    assert leaking.weight_on_bit[-1] > new.weight_on_bit[-1]


def test_harder_formation_takes_more_weight():
    rig = horizontal(friction=0.0)
    run = commands(80.0, block_speed=0.002)
    plain = simulate(rig, run, 20)
    harder = simulate(with_effect(rig, formation_change=FormationChange(1.5, 40.0)), run, 20)
    before = plain.time < 39.9
    assert np.array_equal(plain.weight_on_bit[before], harder.weight_on_bit[before])
    at_same_speed = harder.weight_on_bit[-1] / harder.rate_of_penetration[-1]
    assert at_same_speed / (plain.weight_on_bit[-1] / plain.rate_of_penetration[-1]) == pytest.approx(1.5, rel=0.05)


def test_effects_act_on_each_section_alike():
    """A bottom-hole assembly in the open hole is part of what a cuttings bed lies on."""
    collar = StringSection("collar", 50.0, 0.165, 0.0714)
    rig = horizontal()
    pipe = dataclasses.replace(rig.string.sections[0], length=150.0)
    rig = dataclasses.replace(rig, string=dataclasses.replace(rig.string, sections=(pipe, collar)))
    bed = with_effect(rig, cuttings_bed=CuttingsBed(2.0, 150.0, 200.0))
    more = turning_torque(bed, 1.0, 40) - turning_torque(rig, 1.0, 40)
    weight = 9.81 * 6650.0 * math.pi / 4 * (0.165**2 - 0.0714**2) * 50.0
    slide = Plant(rig, 40)
    slide.advance(commands(60.0, speed=1.0))
    friction = slide.profile().friction_coefficient[-1]
    assert more == pytest.approx(friction * weight * 0.0825, rel=0.01)
