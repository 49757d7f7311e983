"""Load check: made-up rocking cycles in which one channel lies."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.load_evidence import LoadEvidence, LoadSample
from slider_drilling.control.estimation.torque_jump import TorqueJump
from slider_drilling.control.interlocks.drive_following import DriveFollowing
from slider_drilling.control.interlocks.load_check import LoadCheck, LoadConditions, LoadFault
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).resolve().parents[1] / "config" / "rig.example.yaml")
LEVER, STIFFNESS = RIG.bit.lever, RIG.string.axial_stiffness
WEIGHT, DRAG, CYCLE, RATE = 80e3, 20e3, 10.0, 0.0025
STEADY = LoadConditions(loaded=True, checked=True, error=0.05, lead_torque=0.0, turning_torque=0.0, full_drag=140e3)


def make_check():
    return LoadCheck(LoadEvidence(LEVER, STIFFNESS), WEIGHT, LEVER * WEIGHT, 1.4 * WEIGHT)


class Slide:
    """Cycles of a steady slide whose channels can be off by a weight (N) each."""

    def __init__(self, torque_scale=1.0):
        self.check, self.torque_scale = make_check(), torque_scale
        self.time = self.block = 0.0

    def run(self, seconds, pressure=0.0, torque=0.0, hook=0.0, weight=WEIGHT, conditions=STEADY):
        """Go on; each channel's error is a number, or a function of the time since the call."""
        start = self.time
        while self.time < start + seconds and self.check.trip is None:
            self.time += CYCLE
            since = self.time - start
            true = weight(since) if callable(weight) else weight
            lies = [error(since) if callable(error) else error for error in (pressure, torque, hook)]
            self.block += RATE * true / WEIGHT * CYCLE
            deficit = true + DRAG + lies[2]
            self.check.update_sample(true + lies[0], deficit, deficit, CYCLE)
            self.check.update_cycle(LoadSample(self.time, CYCLE, self.torque_scale * LEVER * (true + lies[1]),
                                               LEVER * (true + lies[0]), deficit, self.block,
                                               LEVER * true), conditions)
        return self.check.trip.fault if self.check.trip is not None else None


def grows(kilonewton_per_minute):
    return lambda since: kilonewton_per_minute * 1e3 * since / 60.0


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.15])
def test_scale_of_torque_is_learnt(scale):
    """A weak motor or a torque sensor with a wrong gain is no contradiction."""
    slide = Slide(scale)
    assert slide.run(600.0) is None
    assert slide.check.evidence.scale == pytest.approx(scale)
    highest = max(scale, 1.0) * WEIGHT   # more torque than pressure stands for may be weight
    assert slide.check.evidence.drag == pytest.approx(DRAG + WEIGHT - highest, rel=1e-3)
    assert slide.check.weight == pytest.approx(highest, rel=1e-3) and not slide.check.stops


def test_pressure_lost_slowly_is_a_washout():
    """The auto-driller holds the pressure, so the weight rises instead."""
    slide = Slide()
    slide.run(300.0)
    assert slide.run(900.0, pressure=grows(-4.0), weight=lambda since: WEIGHT + grows(4.0)(since)) is LoadFault.WASHOUT
    assert slide.check.stops and slide.check.evidence.pressure_change < 0.0


def test_pressure_that_drifts_up_is_the_transmitter():
    slide = Slide()
    slide.run(300.0)
    falls = {"pressure": grows(4.0), "weight": lambda since: WEIGHT - grows(4.0)(since)}
    assert slide.run(900.0, **falls) is LoadFault.TRANSMITTER


@pytest.mark.parametrize("drift", [4.0, -4.0])
def test_torque_that_drifts_alone_is_wrong(drift):
    slide = Slide()
    slide.run(300.0)
    assert slide.run(900.0, torque=grows(drift)) is LoadFault.TORQUE


@pytest.mark.parametrize("drift", [4.0, -4.0])
def test_twist_clears_pressure_where_hook_load_and_rate_are_hidden(drift):
    """Drag that slows the lowering hides hook load and rate; the twist of the string shows the true torque."""
    slide = Slide()
    slide.run(300.0)
    assert slide.run(900.0, torque=grows(drift), conditions=replace(STEADY, slowed=True)) is LoadFault.TORQUE


@pytest.mark.parametrize(("drift", "fault"), [(-4.0, LoadFault.WASHOUT), (4.0, LoadFault.TRANSMITTER)])
def test_twist_clears_torque_where_hook_load_and_rate_are_hidden(drift, fault):
    slide = Slide()
    slide.run(300.0)
    lies = {"pressure": grows(drift), "weight": lambda since: WEIGHT - grows(drift)(since)}
    assert slide.run(900.0, conditions=replace(STEADY, slowed=True), **lies) is fault


@pytest.mark.parametrize(("step", "fault"), [(-60e3, LoadFault.LOST_STROKES), (80e3, LoadFault.PLUGGED_NOZZLE)])
def test_sudden_change_holds_then_latches(step, fault):
    check = make_check()
    check.evidence.drag, check.evidence.known = DRAG, True
    for k in range(1000):
        check.update_sample(WEIGHT + (step if k >= 300 else 0.0), WEIGHT + DRAG, WEIGHT + DRAG, 0.1)
        assert check.stops == (k >= 300) or 300 <= k < 330
    assert check.trip.fault is fault


@pytest.mark.parametrize(("step", "stops"), [(-60e3, True), (-25e3, False), (60e3, False)])
def test_first_load_may_come_on_by_jumps(step, stops):
    """Before the reference only a large loss of pressure stops lowering."""
    check = make_check()
    for k in range(600):
        check.update_sample(WEIGHT + (step if k >= 300 else 0.0), WEIGHT + DRAG, WEIGHT + DRAG, 0.1)
    assert check.stops == stops


def test_weight_that_hook_load_confirms_is_believed():
    """A pick-up, a lock-up that lets go within its drag, and softer rock."""
    check = make_check()
    check.evidence.drag = DRAG
    for k in range(1500):
        weight = WEIGHT - (30e3 if k > 300 else 0.0) + (12e3 if k > 900 else 0.0)
        drag = DRAG - (12e3 if k > 900 else 0.0)
        check.update_sample(weight, weight + drag, weight + drag, 0.1)
        assert not check.stops


@pytest.mark.parametrize("step", [-80e3, -50e3, 60e3])
def test_hook_load_that_jumps_alone_is_wrong(step):
    slide = Slide()
    slide.run(300.0)
    assert slide.run(300.0, hook=step) is LoadFault.HOOK_LOAD


@pytest.mark.parametrize(("step", "fault"), [(-42e3, LoadFault.HOOK_LOAD), (42e3, LoadFault.HOOK_LOAD), (12e3, None)])
def test_jump_of_hook_load_is_found_although_its_average_and_drag_follow(step, fault):
    """The average over strokes shows a jump late; by then some of it has been learnt as drag."""
    slide = Slide()
    slide.run(300.0)
    check, smooth = slide.check, WEIGHT + DRAG
    for k in range(1, 1000):
        deficit = WEIGHT + DRAG + step
        smooth += (1.0 - math.exp(-0.1 / 15.0)) * (deficit - smooth)
        check.update_sample(WEIGHT, deficit, smooth, 0.1)
        if k % 40 == 0:
            time, block = slide.time + 0.1 * k, slide.block + RATE * 0.1 * k
            check.update_cycle(LoadSample(time, 4.0, LEVER * WEIGHT, LEVER * WEIGHT, smooth, block, LEVER * WEIGHT),
                               STEADY)
    assert (check.trip and check.trip.fault) is fault


def test_hook_load_bounds_weight_whatever_pressure_says():
    slide = Slide()
    slide.run(300.0)
    check = slide.check
    for weight, stops in ((1.2, False), (1.45, True), (1.35, True), (1.2, False)):
        check.update_sample(WEIGHT, math.nan, weight * WEIGHT + DRAG, 0.1)
        assert check.over_limit == stops, weight


@pytest.mark.parametrize(("side", "latches"), [(1.0, False), (-1.0, True)])
def test_winding_excuses_torque_to_its_side_only(side, latches):
    """A centre that leads right winds the string and adds torque; one that leads left takes it off."""
    slide = Slide()
    slide.run(300.0)
    winding = LoadConditions(True, True, 0.2, side * 800.0, 0.0, 140e3)
    fault = slide.run(200.0, torque=600.0 / LEVER, pressure=0.0, conditions=winding)
    assert (fault is not None) == latches


def test_strong_motor_does_not_hide_weight():
    """Torque beyond what pressure stands for may be weight: it counts in full."""
    slide = Slide(1.15)
    slide.run(300.0)
    assert slide.check._by_torque == pytest.approx(1.15 * WEIGHT)


def test_string_that_turns_is_not_compared():
    """Torque that turns the toolface or winds the string is no weight on bit."""
    slide = Slide()
    slide.run(300.0)
    turning = LoadConditions(True, True, math.radians(60.0), 800.0, 800.0, 140e3)
    assert slide.run(60.0, torque=30e3, conditions=turning) is None


def test_stuck_block_latches_and_real_motion_releases():
    drives, position = DriveFollowing(), 0.0
    for _ in range(600):
        position += 0.1 * 0.0025
        drives.update_block(position, 0.0025, 0.1)
    assert drives.block_follows
    for _ in range(900):
        drives.update_block(position, 0.0025, 0.1)
    assert not drives.block_follows
    for _ in range(600):
        drives.update_block(position, 0.0, 0.1)
    assert not drives.block_follows, "a block that rests proves nothing"
    for _ in range(300):
        position += 0.1 * 0.01
        drives.update_block(position, 0.0, 0.1)
    assert drives.block_follows


def test_pump_must_turn_as_commanded():
    drives = DriveFollowing()
    for speed, seconds, follows in ((12.2, 60.0, True), (11.7, 9.0, True), (11.7, 3.0, False), (12.3, 1.0, True)):
        for _ in range(round(10.0 * seconds)):
            drives.update_pump(speed, 12.3, 0.1)
        assert drives.pump_follows == follows


def test_held_bit_is_not_believed_for_ever():
    """Without a reference, torque beyond pressure is a held bit for some minutes, then perhaps a washout."""
    unsteady = replace(STEADY, error=0.4)   # no reference while the toolface is off its target
    slide = Slide()
    assert slide.run(120.0, torque=24e3, conditions=unsteady) is None
    assert slide.run(600.0, torque=24e3, conditions=unsteady) is LoadFault.WASHOUT
    assert slide.time < 500.0


@pytest.mark.parametrize(("torque", "stops"), [(15e3, True), (26e3, False)])
def test_contacts_that_hold_widen_the_tolerance(torque, stops):
    slides = [Slide(), Slide()]
    for slide, held in zip(slides, (False, True), strict=True):
        slide.run(300.0, conditions=replace(STEADY, held=held))
        assert slide.check.evidence.known
    free, holding = (slide.run(200.0, torque=torque) for slide in slides)
    assert free is not None and (holding is None) is stops


def test_drag_that_may_let_go_counts_as_weight():
    slide = Slide()
    slide.run(400.0)
    shown = slide.check.weight_after_release(WEIGHT, WEIGHT + 50e3)
    assert WEIGHT + 10e3 < shown < WEIGHT + 50e3
    assert slide.check.weight_after_release(WEIGHT, math.nan) == pytest.approx(WEIGHT, rel=0.01)


def test_drag_before_reference_is_no_jump():
    """Drag that builds up with the load is learnt more slowly than it comes on."""
    slide = Slide()
    assert slide.run(100.0, hook=45e3) is None and not slide.check.evidence.known


@pytest.mark.parametrize(
    ("torque", "turned", "reactive", "jump"),
    [(-2e3, 0.0, 0.0, -2e3), (6e3, 0.0, 0.0, 6e3), (-1e3, 0.0, 0.0, 0.0), (2.2e3, 6.0, 0.0, 0.0),
     (2.2e3, -6.0, 0.0, 2.8e3), (2e3, 0.0, 1e3, 0.0)],
)  # fmt: skip
def test_only_torque_sensor_jumps_alone(torque, turned, reactive, jump):
    """Averages over two strokes show half of a jump first; a drive that turns and a motor explain theirs."""
    compliance, target, found = 5e-3, 2.8e3, 0.0
    jumps = TorqueJump()
    for stroke in range(16):
        share = min(max(0.5 * (stroke - 8), 0.0), 1.0)
        cycle = CycleAverage(3.0 + share * turned, 2.8e3 + share * torque, 2.8e3 + share * reactive, 10.0)
        jumps.update(cycle, compliance, target)
        found = jumps.size or found
    assert found == pytest.approx(jump)
