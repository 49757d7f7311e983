"""The controller of programmes: follows the steps, keeps every limit on rigs of foreign structure, aborts safely."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from slider_drilling.blind.foreign.foreign_rig import ForeignRig
from slider_drilling.blind.foreign.structure import draw_structure
from slider_drilling.control.interface import Level, Measurements
from slider_drilling.drillstring import GroundTruth, VirtualRig
from slider_drilling.errors import InputError
from slider_drilling.programmes import (
    BlockSpeed,
    DrillOff,
    Flow,
    MakeConnection,
    PickUp,
    Programme,
    Rest,
    Rock,
    Rotate,
    SlackOff,
    Slide,
    Step,
    StepLimits,
    load_programme,
    open_loop_commands,
)
from slider_drilling.programmes.controller import ProgrammeController
from slider_drilling.programmes.limits import LimitError, check_on_rig, complete
from slider_drilling.programmes.progress import ProgrammeState
from slider_drilling.programmes.rig_check import nominal_times
from slider_drilling.rig import load_rig

CONFIG = Path(__file__).parents[1] / "config"
RIG = load_rig(CONFIG / "rig.example.yaml")
ELEMENTS = 30
AFTERWARDS = 15.0  # s, for which a run goes on after its end


@dataclass
class ProgrammeRun:
    """A run: what was measured, the truth, and the controller at its end."""

    controller: ProgrammeController
    measured: list[Measurements]
    truth: list[GroundTruth]

    def highest(self, name: str) -> float:
        return max(getattr(sample, name) for sample in self.truth)

    @property
    def reason(self) -> str:
        return self.controller.progress().reason


def run(programme: Programme, rig: VirtualRig, longest: float = 900.0, abort_at: float = math.inf) -> ProgrammeRun:
    controller = ProgrammeController(RIG, programme)
    result = ProgrammeRun(controller, [rig.measurements], [rig.truth])
    ended = math.inf
    while result.measured[-1].time < min(longest, ended + AFTERWARDS):
        result.measured.append(rig.step(controller.step(result.measured[-1])))
        result.truth.append(rig.truth)
        if result.measured[-1].time >= abort_at:
            controller.abort("asked for")
        if controller.ended:
            ended = min(ended, result.measured[-1].time)
    return result


def of(*actions: object, **limits: float) -> Programme:
    return Programme(tuple(Step(action) for action in actions), limits=StepLimits(**limits))  # type: ignore[arg-type]


def plant(**changes: object) -> VirtualRig:
    return VirtualRig(dataclasses.replace(RIG, **changes), elements=ELEMENTS)  # type: ignore[arg-type]


def test_commissioning_runs_to_its_end() -> None:
    programme = load_programme(CONFIG / "programmes" / "commissioning.yaml")
    result = run(programme, plant())
    progress = result.controller.progress()
    assert progress.state is ProgrammeState.DONE, progress
    assert [record.outcome for record in progress.records] == ["done"] * len(programme.steps)
    assert result.measured[-1].time - AFTERWARDS <= 240.0


def test_drives_follow_the_open_loop_commands() -> None:
    programme = of(BlockSpeed(0.003), Rock(10.0, 6.0, 3.0, rest=1.0, cycles=1), Flow(0.028), PickUp(0.5), Rest(3.0))
    commands = open_loop_commands(programme, RIG)
    measured = run(programme, plant()).measured[: commands.time.size]
    angle = np.array([sample.top_drive_angle for sample in measured])
    block = np.array([sample.block_position for sample in measured])
    pump = np.array([sample.pump_speed for sample in measured])
    late = 1  # sample: a command is followed at the next one
    assert np.abs(angle[late:] - commands.top_drive_angle[:-late]).max() < 0.3
    assert np.abs(block - commands.block_position[: block.size]).max() < 0.01
    assert pump[-1] == pytest.approx(commands.pump_speed[-1])


_ACTIONS = st.one_of(
    st.builds(Rotate, st.floats(2.0, 12.0), time=st.floats(10.0, 40.0), length=st.none(),
              block_speed=st.floats(0.0, 0.01)),
    st.builds(Rock, st.floats(0.0, 40.0), st.floats(0.5, 40.0), st.floats(0.5, 8.0), st.floats(0.0, 5.0),
              cycles=st.just(1), time=st.none(), block_speed=st.floats(0.0, 0.006)),
    st.builds(Rest, st.floats(2.0, 10.0)),
    st.builds(PickUp, st.floats(0.2, 4.0), st.floats(0.05, 0.3)),
    st.builds(SlackOff, st.floats(0.2, 2.0), st.floats(0.02, 0.3)),
    st.builds(Flow, st.floats(0.02, 0.033), st.floats(1.0, 10.0)),
    st.builds(BlockSpeed, st.floats(0.0, 0.01)),
    st.builds(DrillOff, st.floats(5.0, 20.0)),
)  # fmt: skip
_LIMITS = st.builds(StepLimits, right_torque=st.floats(4e3, 25e3), left_torque=st.floats(3e3, 15e3),
                    weight_on_bit=st.floats(30e3, 200e3), pressure=st.floats(205e5, 240e5))  # fmt: skip


def rig_of(seed: int, foreign: bool) -> VirtualRig:
    """The reference rig, or one of foreign structure."""
    structure = draw_structure(np.random.default_rng(seed))
    return ForeignRig(RIG, structure, seed, ELEMENTS) if foreign else VirtualRig(RIG, seed, ELEMENTS)


@settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.lists(_ACTIONS, min_size=3, max_size=7), _LIMITS, st.floats(1.0, 15.0), st.integers(0, 1000), st.booleans())
def test_no_limit_is_exceeded_by_random_programmes(
    actions: list[object], limits: StepLimits, acceleration: float, seed: int, foreign: bool
) -> None:
    programme = dataclasses.replace(of(*actions), limits=limits, drive_acceleration=acceleration)
    rig = rig_of(seed, foreign)
    try:
        result = run(programme, rig)
    except InputError:
        assume(False)
        return
    kept = complete(StepLimits(), limits, RIG)
    assert result.highest("surface_torque") <= kept.right_torque
    assert max(-sample.surface_torque for sample in result.truth) <= kept.left_torque
    assert result.highest("weight_on_bit") <= kept.weight_on_bit
    assert result.highest("standpipe_pressure") <= kept.pressure


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5])
def test_slide_keeps_its_limits_on_a_foreign_rig(seed: int) -> None:
    tolerance, target = math.radians(20.0), 0.7
    limits = StepLimits(15e3, 9e3, 120e3, 208e5, tolerance)
    result = run(dataclasses.replace(of(Slide(target, time=60.0)), limits=limits), rig_of(seed, foreign=True), 1500.0)
    (record,) = result.controller.progress().records
    assert record.outcome == "done" and record.tool_face_set is not None and record.tool_face_left is not None
    held = [truth for truth in result.truth if record.tool_face_set <= truth.time <= record.tool_face_left]
    assert max(abs(math.remainder(truth.tool_face - target, 2.0 * math.pi)) for truth in held) <= tolerance
    assert result.highest("surface_torque") <= 15e3
    assert max(-sample.surface_torque for sample in result.truth) <= 9e3
    assert result.highest("weight_on_bit") <= 120e3
    assert result.highest("standpipe_pressure") <= 208e5


def test_torque_limit_stops_the_drive() -> None:
    result = run(of(Rotate(8.0, time=60.0), right_torque=6e3), plant())
    assert "torque to the right would reach" in result.reason
    assert result.highest("surface_torque") <= 6e3
    assert result.measured[-1].top_drive_speed == pytest.approx(0.0, abs=1e-6)


def test_weight_limit_lifts_the_bit() -> None:
    result = run(of(Rotate(8.0, time=600.0, block_speed=0.02), weight_on_bit=60e3), plant())
    assert "weight on bit may reach" in result.reason
    assert 40e3 < result.highest("weight_on_bit") <= 60e3
    assert result.truth[-1].weight_on_bit == 0.0
    assert result.controller.status()[0].level is Level.ERROR


def test_reason_says_how_the_value_lies_beside_its_limit() -> None:
    """What a limit is kept clear by aborts at values below it; "would reach 5.2, the limit is 6.0" is no reason."""
    torque = run(of(Rotate(8.0, time=60.0), right_torque=6e3), plant()).reason
    weight = run(of(SlackOff(20.0)), plant()).reason
    for reason in (torque, weight):
        found = re.search(r"reach ([\d.]+) kN( m)?, (above|too near) the limit of ([\d.]+) kN", reason)
        assert found is not None, reason
        assert (found[3] == "above") == (float(found[1]) >= float(found[4]))
    assert "too near" in torque


def test_bit_must_be_surely_off_bottom() -> None:
    off = StepLimits(bit="off bottom")
    near = Programme((Step(PickUp(0.5)), Step(Rest(5.0), off)))
    far = Programme((Step(PickUp(6.0)), Step(Rock(12.0, 12.0, 4.0, cycles=1)), Step(Rest(5.0), off)))
    assert "the bit may touch bottom" in run(near, plant()).reason
    assert run(far, plant()).controller.progress().state is ProgrammeState.DONE


def test_lost_channel_aborts_a_moving_step() -> None:
    class Blind(VirtualRig):
        def _measure(self, mwd: tuple) -> Measurements:  # type: ignore[type-arg]
            seen = super()._measure(mwd)
            return dataclasses.replace(seen, hook_load=math.nan) if seen.time > 20.0 else seen

    result = run(of(Rotate(6.0, time=60.0)), Blind(RIG, elements=ELEMENTS))
    assert result.reason.startswith("hook_load: no valid sample for 1.")
    assert result.measured[-1].top_drive_speed == pytest.approx(0.0, abs=1e-6)


def test_crew_aborts_at_any_time() -> None:
    result = run(of(Rotate(6.0, time=60.0, block_speed=0.003)), plant(), abort_at=20.0)
    assert result.reason == "asked for"
    assert result.measured[-1].block_speed == result.measured[-1].top_drive_speed == 0.0
    assert "nothing to abort" in result.controller.abort()


def test_progress_counts_steps_and_time() -> None:
    controller = ProgrammeController(RIG, of(Rest(10.0), Rest(20.0)))
    rig = plant()
    sample = rig.measurements
    while sample.time < 8.0:
        sample = rig.step(controller.step(sample))
    progress = controller.progress()
    assert (progress.step, progress.steps, progress.action) == (1, 2, "rest")
    assert progress.time_left == pytest.approx(25.0, abs=0.3)


def test_loaded_bit_is_refused_at_the_start() -> None:
    loaded = dataclasses.replace(RIG.hydraulics, reference_pressure=1.1 * RIG.hydraulics.reference_pressure)
    refused = run(of(Rest(5.0)), plant(hydraulics=loaded))
    assert "is the bit loaded?" in refused.reason
    assert str(refused.controller.progress()).startswith("aborted before the first step: standpipe pressure is")


def test_connection_stops_and_starts_the_pump() -> None:
    result = run(of(MakeConnection(time=10.0)), plant())
    assert result.controller.progress().state is ProgrammeState.DONE
    assert min(sample.pump_speed for sample in result.measured) == 0.0
    assert result.measured[-1].pump_speed == pytest.approx(RIG.hydraulics.reference_flow / RIG.mud_pump.displacement)


@pytest.mark.parametrize(
    ("action", "limits", "message"),
    [
        (Rotate(20.0, time=9.0), {}, "the top drive has 12.6"),
        (PickUp(1.0, speed=1.5), {}, ""),
        (Flow(0.2), {}, "the pump has"),
        (Flow(0.034), {"pressure": 190e5}, "more than 95 % of the limit of 190 bar"),
        (Slide(0.5, length=1.0, rate_of_penetration=0.01), {"weight_on_bit": 60e3}, "m/h at most"),
    ],
)
def test_programme_that_the_rig_cannot_run_is_refused(action: object, limits: dict[str, float], message: str) -> None:
    if not message:
        ProgrammeController(RIG, of(action, **limits))
        return
    with pytest.raises(InputError, match=message):
        ProgrammeController(RIG, of(action, **limits))


def test_a_short_slide_without_flow_is_refused() -> None:
    """It ends with the bit lifted above where it began, but drills in between."""
    slide = Slide(0.5, time=60.0)
    nominal_times(of(slide), RIG)
    with pytest.raises(InputError, match=r"steps\[1\].slide: the block is lowered with less than 30 %"):
        nominal_times(of(Flow(0.0), slide), RIG)


@pytest.mark.parametrize("name", ["left_torque", "right_torque"])
@pytest.mark.parametrize("of_step", [False, True])
def test_a_torque_limit_above_the_make_up_torque_is_refused(name: str, of_step: bool) -> None:
    """Only where the rig file gives one; to the left it may open a connection."""
    limits = StepLimits(**{name: 12e3})
    step = Step(Rest(5.0), limits if of_step else StepLimits())
    programme = Programme((step,), "test", limits=StepLimits() if of_step else limits)
    nominal_times(programme, RIG)
    first, *others = RIG.string.sections
    sections = (dataclasses.replace(first, make_up_torque=11e3), *others)
    weaker = dataclasses.replace(RIG, string=dataclasses.replace(RIG.string, sections=sections))
    where = "steps[0].limits" if of_step else "limits"
    said = rf"programme: {re.escape(where)}\.{name} = 12\.0 kN m: .* made up with 11\.0 kN m; give less"
    with pytest.raises(InputError, match=said):
        nominal_times(programme, weaker)
    with pytest.raises(LimitError, match=name):
        check_on_rig(limits, weaker)


def test_a_torque_limit_above_the_top_drive_is_refused() -> None:
    most = RIG.top_drive.max_torque
    nominal_times(Programme((Step(Rest(5.0)),), "test", limits=StepLimits(right_torque=most)), RIG)
    with pytest.raises(InputError, match=r"limits\.right_torque = .* more than the top drive of the rig file gives"):
        nominal_times(Programme((Step(Rest(5.0)),), "test", limits=StepLimits(right_torque=1.1 * most)), RIG)
