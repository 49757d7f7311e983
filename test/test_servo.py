"""The servo of docs/examples: its physics against closed forms, its logs read whatever the order of their columns."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.benchmarks.real_machines import example_module
from slider_drilling.errors import InputError
from slider_drilling.gap import SimulationOptions, explain
from slider_drilling.gap.experiment_design.knowledge import before_any_log
from slider_drilling.gap.experiment_design.plan import plan_run
from slider_drilling.gap.model import HasProgrammes

servo = example_module("servo")
plant = example_module("servo_plant")
FREE = {"coulomb": 0.0, "viscous": 0.0}
INERTIA = 0.49 * 0.1**2 + 1.8e-3
WEIGHT = 0.49 * plant.GRAVITY * 0.1


def log(duration=3.0, start=0.0, enabled=0.0, goal=0.0, gain=100.0, interval=0.002):
    time = np.arange(0.0, duration, interval)
    aim = np.broadcast_to(goal, time.shape).astype(float)
    # Two equal samples, so that the arm starts at rest.
    return servo.Log("made", gain, time, aim, np.full_like(time, start), np.full_like(time, enabled))


def swing(made, **values):
    return made.swing([{name.replace("__", "."): value for name, value in values.items()}])[0]


def crossings(time, angle):
    """Times at which the angle passes zero downwards."""
    at = np.flatnonzero((angle[:-1] > 0.0) & (angle[1:] <= 0.0))
    return time[at] + (time[1] - time[0]) * angle[at] / (angle[at] - angle[at + 1])


@pytest.mark.parametrize("start", [0.05, 1.0, 2.0])
def test_free_arm_has_pendulum_period(start):
    made = log(8.0, start)
    period = float(np.mean(np.diff(crossings(made.time, swing(made, **FREE)))))
    # Complete elliptic integral by the arithmetic-geometric mean.
    a, b = 1.0, math.cos(0.5 * start)
    for _ in range(20):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(INERTIA / WEIGHT) / a, rel=1e-4)


def test_free_arm_conserves_energy():
    made = log(60.0, 1.2)
    angle = swing(made, **FREE)
    speed = np.gradient(angle, made.time)
    energy = 0.5 * INERTIA * speed**2 + WEIGHT * (1.0 - np.cos(angle))
    half = energy.size // 2
    assert np.mean(energy[half:]) == pytest.approx(np.mean(energy[:half]), rel=1e-4)
    assert np.max(angle[half:]) == pytest.approx(1.2, abs=1e-3)


def test_dry_friction_shortens_half_swings_equally():
    """Small swings under Coulomb friction lose 2 f / k a half swing, k the weight's stiffness."""
    made = log(5.0, 0.1)
    angle = swing(made, coulomb=0.002, viscous=0.0)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle))) != 0) + 1
    lost = 0.1 - np.abs(angle[turns][:6])
    assert lost == pytest.approx((2.0 * 0.002 / WEIGHT) * np.arange(1, 7), abs=2e-4)


def test_dry_friction_holds_up_to_its_limit():
    held, gone = (
        swing(log(2.0, math.asin(share * 0.05 / WEIGHT)), coulomb=0.05, viscous=0.0) for share in (0.98, 1.05)
    )
    assert np.ptp(held) < 1e-12
    assert np.ptp(gone) > 1e-3


def test_viscous_friction_matches_closed_form():
    made = log(4.0, 0.02)
    angle = swing(made, coulomb=0.0, viscous=0.004)
    rate = 0.5 * 0.004 / INERTIA
    own = math.sqrt(WEIGHT / INERTIA - rate**2)
    exact = 0.02 * np.exp(-rate * made.time) * (np.cos(own * made.time) + rate / own * np.sin(own * made.time))
    assert angle == pytest.approx(exact, abs=2e-5)


def test_disabled_motor_gives_no_torque():
    off = log(2.0, 0.3, enabled=0.0, goal=1.0)
    assert np.array_equal(swing(off, torque_constant=0.387), swing(off, torque_constant=0.2, resistance=2.0))


def test_firmware_holds_arm_where_torques_balance():
    """Stalled: gain x error turned into duty, k_t duty V / R against the weight; friction helps whoever holds."""
    made = log(6.0, goal=0.8, enabled=1.0, gain=200.0)
    end = swing(made, coulomb=0.0)[-1]
    duty = 200.0 * (0.8 - end) * (4096 / (2.0 * math.pi)) / (256 * 885)
    assert 0.387 * duty * 7.4 / 4.0 == pytest.approx(WEIGHT * math.sin(end), rel=1e-3)
    full = swing(log(6.0, goal=3.0, enabled=1.0, gain=1000.0), coulomb=0.0, supply=4.0)[-1]
    assert WEIGHT * math.sin(full) == pytest.approx(0.387 * 4.0 / 4.0, rel=1e-3)


def test_back_emf_acts_as_viscous_friction():
    powered = log(2.0, 0.05, enabled=1.0, gain=0.0)
    braked = swing(powered, coulomb=0.0, viscous=0.0)
    same = swing(log(2.0, 0.05), coulomb=0.0, viscous=0.387**2 / 4.0)
    assert braked == pytest.approx(same, abs=1e-12)


def test_load_friction_grows_with_load():
    """Lowered slowly against the motor the arm lags more by both shares; still, friction reaches what it says."""
    start = 0.9
    for name, share in (("load_friction_external__share", 0.2), ("quadratic_load__factor", 0.5)):
        load = share * WEIGHT * math.sin(start) if "share" in name else share * (WEIGHT * math.sin(start)) ** 2
        needed = WEIGHT * math.sin(start) - load
        held = swing(log(1.0, start), coulomb=1.01 * needed, **{name: share})
        gone = swing(log(1.0, start), coulomb=0.97 * needed, **{name: share})
        assert np.ptp(held) < 1e-12
        assert np.ptp(gone) > 1e-3
    motor = log(3.0, 0.0, enabled=1.0, goal=0.3, gain=100.0)
    assert swing(motor, load_friction_motor__share=0.4)[-1] < swing(motor)[-1] - 0.02


def test_stribeck_breakaway_exceeds_sliding():
    start = math.asin(0.05 / WEIGHT)
    held = swing(log(1.0, start), coulomb=0.03, stribeck__drop=0.021)
    gone = swing(log(1.0, start), coulomb=0.03, stribeck__drop=0.018)
    assert np.ptp(held) < 1e-12
    assert np.ptp(gone) > 0.03


def test_encoder_offset_shifts_measured_angle():
    shown = swing(log(2.0, 0.0), encoder_offset__angle=0.1, **FREE)
    plain = swing(log(2.0, 0.1), **FREE)
    assert shown == pytest.approx(plain - 0.1, abs=1e-12)


def test_delay_shifts_motor_command():
    made = log(1.0, goal=np.where(np.arange(500) * 0.002 < 0.1, 0.0, 0.5), enabled=1.0)
    begins = [made.time[np.argmax(np.abs(swing(made, delay__time=delay)) > 1e-5)] for delay in (0.0, 0.02, 0.05)]
    assert np.diff(begins) == pytest.approx([0.02, 0.03], abs=0.003)


def test_sagging_supply_and_hot_winding_weaken_motor():
    made = log(6.0, goal=1.2, enabled=1.0, gain=400.0)
    end = swing(made, coulomb=0.0, supply_sag__resistance=1.5)[-1]
    duty = min(400.0 * plant.DUTY_PER_RADIAN * (1.2 - end), 1.0)
    assert 0.387 * duty * 7.4 / (4.0 + 1.5 * duty**2) == pytest.approx(WEIGHT * math.sin(end), rel=1e-3)
    cold, hot = swing(made, coulomb=0.0), swing(made, coulomb=0.0, motor_heating__per_joule=0.02)
    assert hot[-1] < cold[-1] - 0.01


def test_arm_swings_inside_backlash():
    """Within the play the arm, without the motor's inertia, swings about the bottom as if it hung freely."""
    made = log(4.0, 0.05)
    inside = swing(made, backlash__angle=0.4, coulomb=0.1, viscous=0.0)
    period = float(np.mean(np.diff(crossings(made.time, inside))))
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(0.1 / plant.GRAVITY), rel=2e-3)
    assert np.max(np.abs(inside)) == pytest.approx(0.05, abs=1e-3)
    wide = swing(log(4.0, 0.5), backlash__angle=0.1, coulomb=0.1, viscous=0.0)
    assert np.all(np.abs(wide) <= 0.5 + 1e-9)


def test_zero_backlash_changes_nothing_collision_dissipates():
    made = log(3.0, 0.6)
    assert swing(made, **FREE) == pytest.approx(swing(made, backlash__angle=1e-9, **FREE), abs=1e-2)
    loose = swing(log(20.0, 0.6), backlash__angle=0.1, **FREE)
    swings = [float(np.max(np.abs(part))) for part in np.array_split(loose, 10)]
    assert all(after < before + 1e-3 for before, after in itertools.pairwise(swings))
    assert swings[-1] < 0.5


def test_smaller_step_changes_less_than_encoder_resolution():
    """Samples closer together make the step smaller."""
    goal = 0.8 * np.sin(3.0 * np.arange(0.0, 4.0, 0.004))
    coarse = replace(log(4.0, goal=goal, enabled=1.0, interval=0.004), gain=400.0)
    time = np.arange(0.0, 3.996, 0.00025)
    held = goal[np.minimum((time / 0.004 + 1e-9).astype(int), goal.size - 1)]
    fine = servo.Log("fine", 400.0, time, held, np.zeros_like(time), np.ones_like(time))
    for values in ({}, {"load_friction_motor.share": 0.2}, {"stribeck.drop": 0.02}):
        difference = coarse.swing([values])[0][:-1] - fine.swing([values])[0][::16]
        assert np.max(np.abs(difference)) < 2.0 * math.pi / servo.COUNTS


def test_batch_equals_single_runs():
    made = log(1.0, goal=0.5, enabled=1.0)
    sets = [{}, {"delay.time": 0.01}, {"backlash.angle": 0.02}, {"motor_heating.per_joule": 0.1}]
    together = made.swing(sets)
    for row, values in zip(together, sets, strict=True):
        assert np.array_equal(row, made.swing([values])[0])


def test_effects_are_neutral_at_nominal_only():
    model = servo.Servo((log(3.0, goal=np.where(np.arange(1500) < 700, 1.2, -0.4), enabled=1.0, gain=400.0),))
    plain = model.simulate(0, [{}], SimulationOptions())["position"][0]
    for effect in model.effects:
        neutral = {effect.parameters[0].name: effect.parameters[0].nominal}
        assert np.array_equal(model.simulate(0, [neutral], SimulationOptions())["position"][0], plain)
        assert {parameter.name for parameter in effect.parameters} <= set(plant.NOMINAL)
        for point in effect.scan:
            moved = model.simulate(0, [effect.values(point)], SimulationOptions())["position"][0]
            assert np.max(np.abs(moved - plain)) > 2e-4, (effect.name, point)
    for parameter in model.nuisance:
        assert plant.NOMINAL[parameter.name] == parameter.nominal


def test_logs_are_read_in_any_column_order(tmp_path):
    rows = [(0.01 * k, 0.2 * k, 0.1 * k, 1) for k in range(20)]
    first = tmp_path / "arm_kp250_a.csv"
    first.write_text("time_s,goal_rad,position_rad,torque_enabled\n" + "\n".join(",".join(map(str, r)) for r in rows))
    other = tmp_path / "other.csv"
    other.write_text(
        "position_rad, x, goal_rad, time_s\n" + "\n".join(f"{r[2]}, 7, {r[1]}, {r[0]}" for r in rows) + "\n"
    )
    one, two = servo.read_servo_log(first), servo.read_servo_log(other, 250.0)
    assert one.gain == two.gain == 250.0
    for name in ("time", "goal", "position", "enabled"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    for text, says in (("time_s,goal_rad\n" + "0,1\n" * 20, "no column position_rad"), ("", "0 rows"),
                       ("time_s,goal_rad,position_rad\n" + "0,1,1\n" * 20, "time_s does not ascend")):  # fmt: skip
        other.write_text(text)
        with pytest.raises(InputError, match=says):
            servo.read_servo_log(other, 100.0)
    other.write_text(first.read_text())
    with pytest.raises(InputError, match="--gain"):
        servo.read_servo_log(other)
    assert servo.main([str(tmp_path / "none.csv")]) == 2


def test_unseen_logs_measure_added_share():
    """What was found before is no merit of whoever is tried beside it."""
    made = log(2.0, goal=0.8, enabled=1.0, gain=200.0)
    unseen = replace(made, position=swing(made, load_friction_external__share=0.3, delay__time=0.01))

    def entry(name, beside, **values):
        found = {key.replace("__", "."): value for key, value in values.items()}
        names = (*beside, name)
        explained = SimpleNamespace(fit=SimpleNamespace(values=found), names=names)
        effect = next(one for one in servo.EFFECTS if one.name == name)
        return SimpleNamespace(effect=effect, fitted=explained, closed=0.5, interval=(0.4, 0.6), beside=beside,
                               closed_in_other_runs=None, failures=())  # fmt: skip

    first = entry("load_friction_external", (), load_friction_external__share=0.3)
    alternative = entry("quadratic_load", (), quadratic_load__factor=0.1)
    idle = entry("backlash", ("load_friction_external",), load_friction_external__share=0.3, backlash__angle=0.0)
    state = SimpleNamespace(
        calibrated=SimpleNamespace(fit=SimpleNamespace(values={}), names=()), steps=(SimpleNamespace(accepted=first),)
    )
    groups = {"load_friction_external": ("quadratic_load",)}
    diagnosis = SimpleNamespace(state=state, candidates=(first, alternative, idle), indistinguishable=groups)
    lines = servo.candidate_lines(diagnosis, [unseen])
    assert "load_friction_external closes 0.50 [0.40, 0.60], of logs that no fit has seen 0.9" in lines[0]
    assert "backlash closes 0.50 [0.40, 0.60] of what load_friction_external leaves" in lines[2]
    assert "of logs that no fit has seen 0.00" in lines[2]
    alike = "Of load_friction_external and quadratic_load, which the fitted logs cannot distinguish, "
    assert lines[3].startswith(f"{alike}load_friction_external closes most")
    assert servo.candidate_lines(SimpleNamespace(state=state, candidates=(first,), indistinguishable={}), []) == [
        "  load_friction_external closes 0.50 [0.40, 0.60]; load_friction_external.share 0.3: passed"
    ]


def test_real_logs_show_load_friction(shared_data):
    """What the servo reports as its duty is gain x error; and its weight alone does not explain where it stalls."""
    paths = sorted((shared_data / "servo").glob("*.csv"))
    assert len(paths) == 8
    for path in paths:
        table = np.genfromtxt(path, delimiter=",", names=True)
        made = servo.read_servo_log(path)
        duty = np.where(table["load_pwm"] > 32767, table["load_pwm"] - 65536, table["load_pwm"]) / 885.0
        law = np.clip(made.gain * plant.DUTY_PER_RADIAN * (made.goal - made.position), -1.0, 1.0)
        on = made.enabled > 0.5
        assert np.corrcoef(duty[on], law[on])[0, 1] > 0.999
        assert np.median(np.abs(duty[on] - law[on])) < 0.01
    lifted = [servo.read_servo_log(path) for path in paths if "lift_and_drop" in path.name]
    plain, loaded = servo.errors(lifted, {}), servo.errors(lifted, {"load_friction_motor.share": 0.2})
    assert all(after < before for before, after in zip(plain, loaded, strict=True))


def test_effect_may_widen_gap_of_another_log():
    # At rest for the tenth of a second that tells the speed at the start.
    late = np.arange(1500) > 60
    near, far = (log(3.0, goal=np.where(late, goal, 0.0), enabled=1.0) for goal in (0.3, 1.2))
    truth = {"load_friction_external.share": 0.3}
    measured = [replace(made, position=made.swing([truth])[0]) for made in (near, far)]
    assert servo.closed(measured, {}, truth) > 0.9
    assert servo.closed(measured, {"load_friction_external.share": 0.29}, {}) < -1.0
    assert 0.0 < servo.closed(measured[1:], {}, {"load_friction_external.share": 0.2}) < 1.0


def test_script_reports_mistakes_in_one_line(tmp_path):
    command = [sys.executable, servo.__file__, str(tmp_path / "kp1.csv")]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 2
    assert outcome.stderr.startswith("Error: ")
    assert len(outcome.stderr.splitlines()) == 1


def test_planned_swing_shows_more_than_routine():
    model = servo.Servo(())
    plan = plan_run(before_any_log(model), model.programmes(6.0), evaluations=14)
    planned, routine = plan.planned, plan.fixed["routine"]
    assert planned.prospect.loss < 0.5 * routine.prospect.loss
    shown = {each.name: each.size.amplitude for each in planned.prospect.effects}
    before = {each.name: each.size.amplitude for each in routine.prospect.effects}
    assert shown["supply_sag"] < 0.5 * before["supply_sag"]
    assert 0.0 < planned.limit_use < 1.0


def test_swing_beyond_speed_limit_is_refused():
    programmes = servo.Servo(()).programmes(6.0)
    wild = programmes.programme({"gain": 800.0, "amplitude_1": 1.6, "period_1": 0.4})
    assert isinstance(wild.model, HasProgrammes)
    assert programmes.limit_use(wild, [{}])[0] > 1.0
    assert programmes.limit_use(programmes.programme({}), [{}])[0] < 0.5


def test_arm_drops_with_motor_off():
    drop = servo.Servo(()).programmes(6.0).programme({"lift_share": 0.5, "lifted_to": 1.0, "gain": 400.0})
    run = drop.model.logs[0]
    off = run.enabled == 0.0
    angle = run.swing([{}])[0]
    assert run.time[off].size == pytest.approx(0.2 * run.time.size, abs=1)
    assert np.max(angle[off]) > 0.4
    assert np.min(angle[off]) < -0.1


def test_diagnosis_of_swing_asks_for_next():
    goal = np.sin(4.0 * np.arange(0.0, 3.0, 0.03))
    made = log(3.0, goal=goal, enabled=1.0, gain=200.0, interval=0.03)
    noise = np.random.default_rng(5).normal(0.0, 5e-4, goal.size)
    measured = replace(made, position=swing(made, load_friction_motor__share=0.3) + noise)
    effects = tuple(each for each in servo.EFFECTS if each.name in ("load_friction_motor", "supply_sag"))
    answer = explain(servo.Servo((measured,), effects=effects))
    lines = servo.asked_lines(answer, evaluations=14)
    assert answer.effects == ("load_friction_motor",)
    assert lines[0].startswith("Ask next: gain ")
    assert [line.split()[0] for line in lines[1:]] == ["supply_sag"]
