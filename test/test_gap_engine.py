"""The gap engine on the motor-driven slide of docs/examples: every verdict that it can give."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.gap import Channel, Effect, Parameter, Run, explain
from slider_drilling.gap.findings import gaps_before, start_findings
from slider_drilling.gap.held_out import make_folds
from slider_drilling.gap.noise import NoiseFloor, cycle_starts, difference_noise, noise_floor
from slider_drilling.gap.residuals import build_problem

_SOURCE = Path(__file__).parents[1] / "docs" / "examples" / "motor_slide.py"
_SPEC = importlib.util.spec_from_file_location("motor_slide", _SOURCE)
assert _SPEC is not None and _SPEC.loader is not None
slide = importlib.util.module_from_spec(_SPEC)
sys.modules["motor_slide"] = slide
_SPEC.loader.exec_module(slide)

MISTUNED = {"stiffness": 21500.0, "friction": 27.0, "damping": 220.0}
STRIBECK = {"stribeck_drop": 0.5, "stribeck_speed": 0.04}


@pytest.fixture(scope="module")
def stribeck_answer():
    return explain(slide.MotorSlide((slide.record(MISTUNED | STRIBECK),)))


def test_nominal_log_is_none():
    answer = explain(slide.MotorSlide((slide.record({}),)))
    assert answer.verdict == "none"
    assert answer.nominal == pytest.approx(1.0, abs=0.06)
    assert np.isnan(answer.closed)


def test_mistuned_log_is_parameters():
    answer = explain(slide.MotorSlide((slide.record(MISTUNED),)))
    assert answer.verdict == "parameters"
    assert answer.parameters["friction"] == pytest.approx(27.0, abs=0.3)
    assert answer.effects == ()


def test_withheld_effect_is_found(stribeck_answer):
    answer = stribeck_answer
    assert (answer.verdict, answer.effects, answer.site) == ("effect", ("stribeck",), "contact")
    assert answer.closed > 0.97
    assert answer.closed_interval[0] < answer.closed < answer.closed_interval[1]
    assert answer.ranking[0].parameters["stribeck_drop"] == pytest.approx(0.5, abs=0.05)
    assert answer.nominal > answer.tuned > answer.with_effect


def test_same_seed_same_answer(stribeck_answer):
    again = explain(slide.MotorSlide((slide.record(MISTUNED | STRIBECK),)))
    assert repr(again.ranking) == repr(stribeck_answer.ranking)
    assert again.closed_interval == stribeck_answer.closed_interval


def test_shares_add_up(stribeck_answer):
    where = stribeck_answer.where
    for shares in (where.channel, where.phase, where.band):
        assert sum(shares.values()) == pytest.approx(1.0, abs=1e-9)
    assert sum(row["share"] for row in where.time) == pytest.approx(1.0, abs=1e-9)


def test_effect_missing_from_the_catalogue_is_not_named_with_confidence():
    model = slide.MotorSlide((slide.record(MISTUNED | STRIBECK),))
    known = tuple(effect for effect in model.effects if effect.name != "stribeck")
    answer = explain(replace(model, effects=known))
    assert answer.verdict in ("unknown", "effect_and_unknown")
    assert not answer.ranking or not answer.ranking[0].closed > 0.9


def test_two_effects_are_added_one_at_a_time():
    model = slide.MotorSlide((slide.record(MISTUNED | STRIBECK | {"force_bias": 6.0}),))
    answer = explain(model)
    assert set(answer.effects) == {"stribeck", "force_bias"}
    assert answer.verdict == "effect"
    assert answer.parameters["force_bias"] == pytest.approx(6.0, abs=0.3)


def test_fit_with_the_wrong_sign_is_not_accepted_by_name():
    rising = {"stribeck_drop": -0.5, "stribeck_speed": 0.04}
    answer = explain(slide.MotorSlide((slide.record(MISTUNED | rising),)))
    assert "stribeck" not in answer.effects
    entry = next(entry for entry in answer.ranking if entry.effect == "stribeck")
    assert not entry.physical
    assert any("rises with speed" in reason for reason in entry.reasons)


def test_several_logs_share_the_rig_but_not_the_run():
    bias = Parameter("force_bias", 0.0, -30.0, 30.0, 1.0, "N", spread=10.0, per_run=True)
    first = slide.record({"friction": 27.0, "force_bias": 4.0}, seed=1)
    second = slide.record({"friction": 27.0, "force_bias": -3.0}, seed=2)
    model = slide.MotorSlide((first, second), nuisance=(*slide.NUISANCE, bias))
    answer = explain(model, effects=())
    assert answer.verdict == "parameters"
    assert answer.parameters["friction"] == pytest.approx(27.0, abs=0.3)
    assert answer.parameters["force_bias@0"] == pytest.approx(4.0, abs=0.2)
    assert answer.parameters["force_bias@1"] == pytest.approx(-3.0, abs=0.2)


def test_interrupt_keeps_the_best_answer_so_far():
    def stop_while_fitting(stage, share):
        if stage.startswith("fitting"):
            raise KeyboardInterrupt

    answer = explain(slide.MotorSlide((slide.record(MISTUNED | STRIBECK),)), progress=stop_while_fitting)
    assert answer.partial
    assert answer.tuned < answer.nominal
    assert answer.verdict == "inconclusive"


def test_noise_floor_from_repeats_and_from_differences():
    generator = np.random.default_rng(3)
    time = np.arange(0.0, 200.0, 0.1)
    swing = np.abs((time / 10.0) % 2.0 - 1.0)
    swing[1000:] *= 2.0
    signal = 50.0 * np.sin(2 * np.pi * time / 20.0)
    channel = Channel("force", time, signal + generator.normal(0.0, 2.0, time.size))
    run = Run("run", time, swing, (channel,))
    assert [len(group) - 1 for group in cycle_starts(time, swing)] == [3, 3]
    assert noise_floor(channel, run).sigma == pytest.approx(2.0, rel=0.1)
    assert difference_noise(channel.measured) == pytest.approx(2.0, rel=0.1)


def test_coloured_noise_is_seen_by_cycles():
    generator = np.random.default_rng(5)
    time = np.arange(0.0, 600.0, 0.1)
    swing = np.abs((time / 10.0) % 2.0 - 1.0)
    swing[3000:] *= 2.0
    coloured = np.zeros(time.size)
    for index in range(1, time.size):
        coloured[index] = 0.9 * coloured[index - 1] + np.sqrt(1 - 0.81) * generator.normal(0.0, 2.0)
    floor = noise_floor(Channel("force", time, coloured), Run("run", time, swing, ()))
    assert floor.method == "cycles"
    assert floor.sigma == pytest.approx(2.0, rel=0.15)
    assert floor.lag_correlation == pytest.approx(0.9, abs=0.07)


def test_wrapped_channel_takes_the_short_way_round():
    channel = Channel("angle", np.zeros(2), np.array([3.1, -3.1]), "rad", period=2 * np.pi)
    assert channel.residual(np.array([-3.1, 3.1])) == pytest.approx([-0.083185, 0.083185], abs=1e-5)


def test_scan_on_a_bound_or_at_neutral_is_refused():
    parameter = Parameter("size", 0.0, 0.0, 1.0, 0.1)
    with pytest.raises(ValueError, match="past a bound"):
        Effect("size", "site", (parameter,), scan=((0.0,), (0.1,), (0.2,)))
    with pytest.raises(ValueError, match="three"):
        Effect("size", "site", (parameter,), scan=((0.1,),))


def test_gap_is_the_mean_over_channels_of_the_mean_square():
    run = slide.record({}, duration=20.0)
    floors = [{"force": NoiseFloor(2.0, "declared"), "position": NoiseFloor(1e-3, "declared")}]
    problem = build_problem(slide.MotorSlide((run,)), floors)
    residual = np.where(problem.channel == 0, 3.0, 1.0)
    assert problem.gap_squared(residual) == pytest.approx(0.5 * (9.0 + 1.0))


def test_blocks_hold_two_cycles_and_bootstrap_has_twenty():
    run = slide.record({})
    problem = build_problem(slide.MotorSlide((run,)), [{c.name: noise_floor(c, run) for c in run.channels}])
    folds = make_folds(problem)
    assert np.bincount(folds.of).min() > 0
    assert folds.bin_run.size >= 20
    bins_per_second = folds.bin_run.size / run.duration
    assert folds.per_block[0] / bins_per_second >= 2 * 2.0 - 1e-9
    assert gaps_before(start_findings(problem, 0))[0] == pytest.approx(1.0, abs=0.1)
