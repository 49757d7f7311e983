"""The plant as a whole: equilibrium, wave mechanics, convergence, and the one door to it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.drillstring import Commands, InitialState, Observer, Plant, assemble, simulate, simulate_batch
from slider_drilling.effects import Effects, StaticAging, Stribeck
from slider_drilling.rig import FrictionInterval, Rig, load_rig

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
PUMP = RIG.hydraulics.reference_flow / RIG.mud_pump.displacement


def motion(duration: float, interval: float = 0.1, angle=lambda t: 0.0 * t, speed=lambda t: 0.0 * t, block_speed=0.0):
    time = np.arange(0.0, duration + 0.5 * interval, interval)
    return Commands(time, angle(time), speed(time), block_speed * time, 0 * time + block_speed, 0 * time + PUMP)


def rocking(duration: float, amplitude: float = 20.0, period: float = 24.0, block_speed: float = 0.0025):
    """Starts at rest, so that no shock of the start rings on; needs nothing that is tested elsewhere."""
    rate = 2.0 * math.pi / period
    return motion(
        duration,
        angle=lambda t: amplitude * (1.0 - np.cos(rate * t)),
        speed=lambda t: amplitude * rate * np.sin(rate * t),
        block_speed=block_speed,
    )


def without_friction(rig: Rig, damping: float = 0.0) -> Rig:
    well = dataclasses.replace(rig.well, friction_intervals=(FrictionInterval(rig.string.length, 0.0),))
    string = dataclasses.replace(rig.string, axial_damping=damping, torsional_damping=damping)
    return dataclasses.replace(rig, well=well, string=string)


def one_pipe(rig: Rig) -> Rig:
    pipe = dataclasses.replace(rig.string.sections[0], length=rig.string.length)
    return dataclasses.replace(rig, string=dataclasses.replace(rig.string, sections=(pipe,)))


def test_hanging_string_stays_in_equilibrium():
    response = simulate(RIG, motion(20.0))
    weight = 9.81 * 6650.0 * math.pi / 4 * (0.127**2 - 0.1086**2) * (1500.0 + 900.0 * 2.0 / math.pi)
    assert response.hook_load == pytest.approx(weight, rel=1e-4)
    assert np.max(np.abs(response.surface_torque)) < 1e-6
    assert np.ptp(response.bit_depth) < 1e-6
    assert response.standpipe_pressure == pytest.approx(180e5)


def test_torque_front_has_wave_speed_and_impedance():
    """A drive that turns at constant speed feels impedance x speed until the front comes back from the bit."""
    rig = one_pipe(without_friction(RIG))
    speed = 2.0
    # the top drive starts at rest; after half a second it turns steadily
    turning = motion(4.0, 0.05, angle=lambda t: speed * (t - 0.25 * (1 - np.exp(-4 * t))),
                     speed=lambda t: speed * (1 - np.exp(-4 * t)))  # fmt: skip
    response = simulate(rig, turning, elements=800)
    polar = math.pi / 32 * (0.127**4 - 0.1086**4)
    impedance = polar * math.sqrt(rig.string.density * rig.string.shear_modulus)
    wave_speed = math.sqrt(rig.string.shear_modulus / rig.string.density)
    before_echo = (response.time > 1.5) & (response.time < 2.0 * 4000.0 / wave_speed - 0.1)
    expected = impedance * speed * (1 - np.exp(-4 * response.time))
    assert response.surface_torque[before_echo] == pytest.approx(expected[before_echo], rel=2e-3)
    arrival = response.time[np.argmax(np.abs(response.tool_face) > 1e-2)]
    assert arrival == pytest.approx(4000.0 / wave_speed, abs=0.12)


def test_undamped_string_without_friction_keeps_its_energy():
    """Free torsion of a fixed-free pipe: the first mode swings at c / 4 L and does not die."""
    rig = one_pipe(without_friction(RIG))
    response = simulate(rig, motion(60.0), elements=100, start=InitialState(twist=1.0))
    period = 4.0 * 4000.0 / math.sqrt(rig.string.shear_modulus / rig.string.density)
    falling = np.flatnonzero((response.tool_face[:-1] > 0) & (response.tool_face[1:] <= 0))
    measured = np.diff(response.time[falling]).mean()
    assert measured == pytest.approx(period, rel=0.01)
    early, late = response.time <= 2 * period, response.time > 60.0 - 2 * period
    swing = np.sqrt(np.mean(response.tool_face[late] ** 2)) / np.sqrt(np.mean(response.tool_face[early] ** 2))
    assert swing == pytest.approx(1.0, rel=0.02)


def test_surface_torque_converges_with_the_mesh():
    """Doubling 200 elements changes surface torque by less than 1 % RMS, and less than doubling 100 did."""
    commands = rocking(120.0)
    torque = {n: simulate(RIG, commands, elements=n).surface_torque for n in (50, 100, 200, 400)}
    change = {n: np.sqrt(np.mean((torque[2 * n] - torque[n]) ** 2)) / np.std(torque[400]) for n in (50, 100, 200)}
    assert change[200] < 0.01
    assert change[200] < change[100] < change[50]


def test_step_error_falls_with_the_step():
    """Semi-implicit Euler is of first order in a driven, damped string with friction."""
    commands = rocking(30.0)
    torque = {n: simulate(RIG, commands, elements=50, substeps=n).surface_torque for n in (10, 20, 40, 320)}
    error = [np.sqrt(np.mean((torque[n] - torque[320]) ** 2)) for n in (10, 20, 40)]
    assert error[0] > 1.5 * error[1] > 1.5 * 1.5 * error[2]


def test_batch_equals_single_runs():
    commands = rocking(10.0)
    rigs = [
        dataclasses.replace(RIG, bit=dataclasses.replace(RIG.bit, aggressiveness=a)) for a in np.linspace(0.4, 0.6, 20)
    ]
    batch = simulate_batch(rigs, commands, elements=60, workers=2)
    for rig, lane in zip(rigs, batch, strict=True):
        alone = simulate(rig, commands, elements=60)
        assert np.array_equal(alone.surface_torque, lane.surface_torque)
        assert np.array_equal(alone.tool_face, lane.tool_face)
        assert np.array_equal(alone.standpipe_pressure, lane.standpipe_pressure)


def test_stiff_contact_leaves_other_runs_alone():
    """It needs more steps; the others are stepped as they are alone."""
    commands = rocking(10.0)
    rigid = dataclasses.replace(RIG.contact, stiffness=200.0 * RIG.contact.stiffness)
    rigs = [RIG, dataclasses.replace(RIG, contact=rigid), RIG]
    for rig, lane in zip(rigs, simulate_batch(rigs, commands, elements=32), strict=True):
        assert np.array_equal(simulate(rig, commands, elements=32).surface_torque, lane.surface_torque)


@pytest.mark.parametrize("workers", [1, 2, 5, None])
def test_batch_is_independent_of_workers(workers):
    """Lanes with other effects, and one whose stiffer string needs more steps than the others alone would take."""
    commands = rocking(10.0)
    stiffer = dataclasses.replace(RIG.string, youngs_modulus=1.4 * RIG.string.youngs_modulus)
    effects = [Effects(), Effects(stribeck=Stribeck(0.4)), Effects(static_aging=StaticAging(0.3))]
    rigs = [dataclasses.replace(RIG, effects=one) for one in effects] + [dataclasses.replace(RIG, string=stiffer)]
    together = simulate_batch(rigs, commands, elements=60)
    shared = simulate_batch(rigs, commands, elements=60, workers=workers)
    for one, other in zip(together, shared, strict=True):
        for name in ("surface_torque", "tool_face", "standpipe_pressure", "hook_load"):
            assert np.array_equal(getattr(one, name), getattr(other, name))


def test_batch_runs_in_caller_without_workers():
    commands = rocking(3.0)
    (asked,), (plain,) = (simulate_batch([RIG], commands, 20, workers=number) for number in (0, 1))
    assert np.array_equal(asked.surface_torque, plain.surface_torque)
    assert simulate_batch([], commands, 20) == []


def test_tool_face_offset_adds_no_twist():
    commands = rocking(10.0)
    plain = simulate(RIG, commands, elements=60)
    turned = simulate(RIG, commands, elements=60, start=InitialState(tool_face_offset=0.7))
    assert np.array_equal(turned.surface_torque, plain.surface_torque)
    assert turned.tool_face - plain.tool_face == pytest.approx(0.7)


def test_initial_twist_is_constant_torque():
    held = simulate(RIG, motion(1.0), elements=60, start=InitialState(twist=-0.5))
    stiffness = 7.92e10 * math.pi / 32.0 / (3940.0 / (0.127**4 - 0.1086**4) + 60.0 / (0.165**4 - 0.0714**4))
    assert held.surface_torque[0] == pytest.approx(0.5 * stiffness, rel=0.02)
    assert held.tool_face[0] == pytest.approx(-0.5)


def test_restored_plant_continues_bit_for_bit():
    commands = rocking(12.0)
    whole = simulate(RIG, commands, elements=60)

    def part(a: int, b: int) -> Commands:
        return Commands(*(getattr(commands, f.name)[a:b] for f in dataclasses.fields(commands)))

    plant = Plant(RIG, elements=60)
    plant.advance(part(0, 50))
    saved = plant.save()
    plant.advance(part(50, 90))
    plant.restore(saved)
    again = plant.advance(part(50, 121))
    assert np.array_equal(again.surface_torque, whole.surface_torque[50:])
    assert np.array_equal(again.tool_face, whole.tool_face[50:])


def test_uneven_samples_give_same_run():
    even = rocking(20.0)
    time = np.sort(np.concatenate([even.time[::3], even.time[1::3] + 0.013]))
    time = time[time <= 20.0]
    response = simulate(RIG, even.resampled(time), elements=60)
    reference = simulate(RIG, even, elements=60)
    error = response.surface_torque - np.interp(time, even.time, reference.surface_torque)
    assert np.sqrt(np.mean(error**2)) < 0.02 * np.std(reference.surface_torque)


@pytest.mark.parametrize(("flatter", "most"), [(1.0, 1.0), (1.2, 2.0)])
def test_friction_table_and_polynomial_agree(monkeypatch, flatter, most):
    """The two forms of the friction curve are one physics: torque differs by N m, with flat asperities too."""
    commands, made = rocking(20.0), RIG.contact.asperity
    asperity = dataclasses.replace(
        made, minor_axis=made.minor_axis / flatter, major_axis=made.major_axis * flatter
    )
    rig = dataclasses.replace(RIG, contact=dataclasses.replace(RIG.contact, asperity=asperity))
    polynomial = simulate(rig, commands, elements=60)
    monkeypatch.setattr(assemble, "POLYNOMIAL_TOLERANCE", 0.0)
    monkeypatch.setattr(assemble, "_friction_fit", assemble._friction_fit.__wrapped__)  # which remembers its results
    assert not assemble.friction_curve(rig.contact).polynomial.size
    table = simulate(rig, commands, elements=60)
    assert np.sqrt(np.mean((table.surface_torque - polynomial.surface_torque) ** 2)) < most


def test_dahl_exponent_one_is_limit_of_general():
    commands = rocking(20.0)
    near = dataclasses.replace(RIG, contact=dataclasses.replace(RIG.contact, dahl_exponent=1.0 + 1e-9))
    torque = [simulate(rig, commands, elements=60).surface_torque for rig in (near, RIG)]
    assert np.max(np.abs(torque[0] - torque[1])) < 0.1


def test_motor_restarts_when_picked_up():
    rig = dataclasses.replace(RIG, motor=dataclasses.replace(RIG.motor, max_pressure=6e5))
    rig = without_friction(rig, damping=0.15)
    lower, raise_ = motion(60.0, block_speed=0.01), motion(60.0, block_speed=-0.01)
    plant = Plant(rig, elements=60)
    stalled = plant.advance(lower)
    assert stalled.differential_pressure[-1] == pytest.approx(6e5)
    assert stalled.rate_of_penetration[-1] == pytest.approx(0.0, abs=1e-9)
    up = Commands(raise_.time + 60.1, raise_.top_drive_angle, raise_.top_drive_speed,
                  lower.block_position[-1] + raise_.block_position, raise_.block_speed, raise_.pump_speed)  # fmt: skip
    picked_up = plant.advance(up)
    assert picked_up.differential_pressure[-1] == 0.0
    assert picked_up.weight_on_bit[-1] == 0.0


def test_heave_begins_without_a_jump():
    """The string hangs from where the wave has the block: a hook load that rings at the start would be an artefact."""
    time = np.arange(0.0, 20.0, 0.1)
    still = np.zeros_like(time)
    commands = Commands(time, still, still, still, still, np.full_like(time, 12.3))
    rig = RIG
    heave = dataclasses.replace(rig.effects.heave, amplitude=0.05, period=12.0, phase=0.5 * np.pi)
    heaving = dataclasses.replace(rig, effects=dataclasses.replace(rig.effects, heave=heave))
    hook = simulate(heaving, commands, 40).hook_load
    assert abs(hook[1] - hook[0]) < 0.02 * hook[0]


def test_observer_brings_torque_nearer():
    time = np.arange(0.0, 40.0, 0.1)
    angle, speed = 8.0 * (1.0 - np.cos(0.5 * time)), 4.0 * np.sin(0.5 * time)
    still = np.zeros_like(time)
    commands = Commands(time, angle, speed, 0.002 * time, still + 0.002, np.full_like(time, 12.3))
    rig = RIG
    damped = dataclasses.replace(rig.string, torsional_damping=3.0 * rig.string.torsional_damping)
    other = dataclasses.replace(rig, string=damped)
    measured = simulate(other, commands, 40).surface_torque
    (free,) = simulate_batch([rig], commands, 40)
    (none,) = simulate_batch([rig], commands, 40, observer=Observer(time, measured, 0.0))
    (weak,) = simulate_batch([rig], commands, 40, observer=Observer(time, measured, 0.3))
    (strong,) = simulate_batch([rig], commands, 40, observer=Observer(time, measured, 1.0))
    assert np.array_equal(none.surface_torque, free.surface_torque)
    errors = [np.std(run.surface_torque - measured) for run in (free, weak, strong)]
    assert errors[0] > errors[1] > errors[2]


def test_observer_pauses_in_gaps():
    """A run's own torque leaves it as it is, also where two and a half seconds of it are missing."""
    commands = rocking(20.0)
    (free,) = simulate_batch([RIG], commands, 40)
    time, own = commands.time, free.surface_torque
    come = (time < 7.5) | (time > 10.0)
    straight = np.interp(time, time[come], own[come])
    assert np.abs(straight - own).max() > 1000.0
    seen, lost, drawn = (
        simulate_batch([RIG], commands, 40, observer=one)[0].surface_torque - own
        for one in (Observer(time, own), Observer(time[come], own[come]), Observer(time, straight))
    )
    assert np.abs(lost).max() < 1.1 * np.abs(seen).max()
    assert np.abs(drawn).max() > 5.0 * np.abs(lost).max()
    at = Observer(time[come], own[come]).measured_at(np.array([-1.0, 0.0, 7.35, 8.0, 10.05, 10.15, 99.0]))
    assert np.isnan(at).tolist() == [True, False, False, True, True, False, True]


@pytest.mark.parametrize("smoothing", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("gain", [0.1, 0.3, 1.0])
def test_the_observer_is_passive(gain, smoothing):
    """Fed with noise it adds no energy: the string stays bounded, and forgets when the noise ends."""
    time = np.arange(0.0, 120.0, 0.1)
    still = np.zeros_like(time)
    commands = Commands(time, still, still, still, still, np.full_like(time, 12.3))
    rig = RIG
    noise = np.where(time < 20.0, np.random.default_rng(1).normal(0.0, 2000.0, time.size), 0.0)
    (run,) = simulate_batch([rig], commands, 40, observer=Observer(time, noise, gain, smoothing=smoothing))
    assert np.isfinite(run.surface_torque).all()
    late = np.abs(run.surface_torque[time > 80.0]).max()
    assert late < 0.5 * np.abs(run.surface_torque[time < 20.0]).max()


def test_unstable_observer_gain_is_refused():
    with pytest.raises(ValueError, match="gain"):
        Observer(np.zeros(3), np.zeros(3), 1.5)


@pytest.mark.parametrize("exponent", [1.0, 0.8])
def test_constant_friction_factor_equals_rig_file_factor(exponent):
    rig = dataclasses.replace(RIG, contact=dataclasses.replace(RIG.contact, dahl_exponent=exponent))
    rubs = [dataclasses.replace(one, factor=1.3 * one.factor) for one in rig.well.friction_intervals]
    rougher = dataclasses.replace(rig, well=dataclasses.replace(rig.well, friction_intervals=tuple(rubs)))
    commands = rocking(60.0)
    (expected,) = simulate_batch([rougher], commands, 40)
    (found,) = simulate_batch([rig], commands, 40, friction_factor=np.full(commands.time.size, 1.3))
    np.testing.assert_allclose(found.surface_torque, expected.surface_torque, rtol=1e-9, atol=1e-6)


def test_constant_bit_torque_factor_equals_aggressiveness():
    blunt = dataclasses.replace(RIG, bit=dataclasses.replace(RIG.bit, aggressiveness=0.7 * RIG.bit.aggressiveness))
    commands = rocking(60.0)
    (expected,) = simulate_batch([blunt], commands, 40)
    (found,) = simulate_batch([RIG], commands, 40, bit_torque_factor=np.full(commands.time.size, 0.7))
    assert expected.bit_torque.max() > 0.0
    np.testing.assert_allclose(found.bit_torque, expected.bit_torque, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(found.standpipe_pressure, expected.standpipe_pressure, rtol=1e-9)


def test_friction_drift_equals_factor_over_time():
    rate = 2e-3
    drift = dataclasses.replace(RIG.effects.friction_drift, rate=rate)
    drifting = dataclasses.replace(RIG.effects, friction_drift=drift)
    commands = rocking(60.0)
    (expected,) = simulate_batch([dataclasses.replace(RIG, effects=drifting)], commands, 40)
    (found,) = simulate_batch([RIG], commands, 40, friction_factor=1.0 + rate * commands.time)
    plain = simulate(RIG, commands, 40)
    moved = np.abs(expected.surface_torque - plain.surface_torque).max()
    assert np.abs(found.surface_torque - expected.surface_torque).max() < 1e-3 * moved
