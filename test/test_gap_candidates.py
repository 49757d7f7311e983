"""Which candidates are fitted in full, where their search begins, and when two fits say the same."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.situation import tool_frequencies
from slider_drilling.gap.contender import Base, agree, judge, make_base
from slider_drilling.gap.fit import Fit, fit
from slider_drilling.gap.held_out import Bootstrap, make_folds
from slider_drilling.gap.model import Channel, Effect, Parameter, Run
from slider_drilling.gap.noise import NoiseFloor
from slider_drilling.gap.residuals import build_problem
from slider_drilling.gap.screen import screen
from slider_drilling.gap.survivors import SURVIVORS, survivors

TIME = np.arange(0.0, 400.0, 0.1)


def hook_load_run(line_hz, amplitude):
    noise = np.random.default_rng(1).normal(0.0, 4e3, TIME.size)
    measured = 1e6 + 1e4 * np.sin(2.0 * np.pi * TIME / 20.0) + amplitude * np.sin(2.0 * np.pi * line_hz * TIME) + noise
    return Run("run", TIME, np.sin(TIME), (Channel("hook_load", TIME, measured, "N"),))


@pytest.mark.parametrize("hertz", [7.3, 13.7178, 17.9, 28.4])
def test_a_tool_faster_than_the_log_is_among_its_aliases(hertz):
    found = tool_frequencies(hook_load_run(hertz, 2e4))
    assert min(abs(frequency - hertz) for frequency in found) < 2e-3
    tool = next(e for e in catalogue(4000.0, 400.0, tool_frequencies=found) if e.name == "axial_oscillation_tool")
    assert tool.marked
    assert {point[1] for point in tool.scan} == set(found)


def test_noise_has_no_line_and_without_a_hook_load_nobody_knows():
    silent = hook_load_run(13.7, 0.0)
    assert tool_frequencies(silent) == ()
    (channel,) = silent.channels
    assert tool_frequencies(replace(silent, channels=(replace(channel, name="surface_torque"),))) is None
    assert tool_frequencies(replace(silent, channels=())) is None
    tool = next(e for e in catalogue(4000.0, 400.0) if e.name == "axial_oscillation_tool")
    assert not tool.marked


def ending(amplitude, cost):
    return Fit({"wave.size": amplitude}, (), np.empty(0), np.empty((0, 0)), cost, True)


def test_a_wave_of_the_other_sign_is_the_same_answer_and_a_drift_of_the_other_sign_is_not():
    size = Parameter("wave.size", 0.0, -3.0, 3.0, 0.1)
    drift = Effect("wave", "draw_works", (size,), ((0.5,), (1.0,), (2.0,)))
    wave = replace(drift, either_sign=True)
    ends = [ending(1.0, 2.0), ending(-0.9, 2.1)]
    assert agree(wave, 10.0, ends)
    assert not agree(drift, 10.0, ends)
    assert not agree(wave, 10.0, [ending(1.0, 2.0), ending(-0.2, 2.1)])
    assert agree(drift, 10.0, [ending(1.0, 2.0), ending(-0.9, 6.0)])


@dataclass
class Ramps:
    """A channel to which every effect adds a straight line from its own time on."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (Parameter("level", 0.0, -50.0, 50.0, 0.5),)
    effects: tuple[Effect, ...] = ()

    def simulate(self, run, sets):
        time = self.runs[run].time
        rows = []
        for values in sets:
            row = np.full(time.size, values.get("level", 0.0))
            for place, effect in enumerate(self.effects):
                row += values.get(f"{effect.name}.slope", 0.0) * np.clip(time - 30.0 * place, 0.0, None)
            rows.append(row)
        return {"height": np.stack(rows)}


def ramp(name, marked=False, unit="-"):
    slope = Parameter(f"{name}.slope", 0.0, -5.0, 5.0, 0.01, unit)
    return Effect(name, "contact", (slope,), ((0.05,), (0.2,), (1.0,)), marked=marked)


def ramps(measured):
    """A base that explains no ramp, and its candidates."""
    names = ["early", "b", "c", "d", "e", "f", "late", "marked"]
    effects = tuple(ramp(name, name == "marked") for name in names)
    run = Run("ramps", RAMPING, np.sin(RAMPING), (Channel("height", RAMPING, measured),))
    problem = build_problem(Ramps((run,), effects=effects), [{"height": NoiseFloor(1.0, "declared")}])
    base = Base(problem, fit(problem, problem.free(problem.model.nuisance), {}), None)
    return base, screen(problem, base.fit, effects)


RAMPING = TIME[::10]
NOISE = np.random.default_rng(2).normal(0.0, 1.0, RAMPING.size)
LATE = 0.3 * np.clip(RAMPING - 180.0, 0.0, None)


def test_marked_promising_and_quickly_fitted_candidates_survive():
    chosen = survivors(*ramps(LATE + NOISE))
    names = [survivor.candidate.effect.name for survivor in chosen]
    assert len(names) == SURVIVORS + 1
    assert names[0] == "marked"
    # What shows late is in no short fit: the score test alone sees it.
    assert "late" in names[1:3]
    assert chosen[names.index("late")].thorough


def test_beside_an_accepted_effect_only_what_promises_or_foretells_is_fitted():
    assert "late" in [s.candidate.effect.name for s in survivors(*ramps(LATE + NOISE), further=True)]
    no_ramp = 2.0 * np.sin(3.0 * RAMPING)
    assert [s.candidate.effect.name for s in survivors(*ramps(no_ramp + NOISE), further=True)] == ["marked"]


@pytest.mark.parametrize(("unit", "size"), [("-", "0.01"), ("m/s", "0.01 m/s")])
def test_a_vanishing_size_is_refused_in_its_unit(unit, size):
    time = TIME[::10]
    effect = ramp("idle", unit=unit)
    measured = np.random.default_rng(2).normal(0.0, 1.0, time.size)
    run = Run("ramps", time, np.sin(time), (Channel("height", time, measured),))
    problem = build_problem(Ramps((run,), effects=(effect,)), [{"height": NoiseFloor(1.0, "declared")}])
    bootstrap = Bootstrap(problem, make_folds(problem), 0)
    nuisance = problem.free(problem.model.nuisance)
    base = make_base(problem, bootstrap, fit(problem, nuisance, {}))
    found = fit(problem, [*nuisance, *effect.parameters], {})
    contender = judge(problem, bootstrap, base, effect, found, starts_agree=True, candidates=1)
    assert f"vanishing size: less than half of {size}" in contender.reasons
