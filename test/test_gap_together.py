"""Effects that only show together, and the end of a log that no fit has seen."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.situation import STICK_SLIP, prepare
from slider_drilling.errors import InputError
from slider_drilling.gap import Channel, Effect, Parameter, Run, explain, together
from slider_drilling.gap.beyond import look_beyond
from slider_drilling.gap.findings import Findings, start_findings
from slider_drilling.gap.noise import NoiseFloor
from slider_drilling.gap.residuals import build_problem
from slider_drilling.log import read_log

# What the search found in the field recordings (docs/blind/field.md), to four digits.
FOUND = {
    1733: {
        "friction_1": 0.5408, "torsional_damping": 0.1421, "start_twist": 3.182, "torsional_stiffness": 1.173,
        "stribeck.drop": 0.3542, "stribeck.speed": 0.7613, "static_aging.growth": 1.559, "static_aging.time": 5.339,
        "static_aging.slip_distance": 0.5527, "torque_at_motor.inertia": 2889.0, "torque_at_motor.friction": 3731.0,
    },
    2235: {
        "friction_1": 0.7738, "torsional_damping": 0.1001, "start_twist": 0.6783, "torsional_stiffness": 1.353,
        "stribeck.drop": 0.8117, "stribeck.speed": 0.004015, "static_aging.growth": 0.6789, "static_aging.time": 0.3,
        "static_aging.slip_distance": 0.4781, "torque_at_motor.inertia": 1736.0, "torque_at_motor.friction": 0.1,
    },
}  # fmt: skip
TIME = np.arange(0.0, 60.0, 0.1)


@dataclass(frozen=True)
class Product:
    """A wave that needs two effects at once: its amplitude is the product of theirs."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (Parameter("level", 1.0, 0.0, 5.0, 0.1, spread=0.5),)
    effects: tuple[Effect, ...] = (
        Effect("first", "here", (Parameter("first.size", 0.0, 0.0, 3.0, 0.1),), ((0.5,), (1.0,), (2.0,))),
        Effect("second", "here", (Parameter("second.size", 0.0, 0.0, 3.0, 0.1),), ((0.5,), (1.0,), (2.0,))),
        Effect("idle", "there", (Parameter("idle.size", 0.0, 0.0, 3.0, 0.1),), ((0.5,), (1.0,), (2.0,))),
    )
    together: tuple[str, ...] = ("first", "second", "idle")

    def simulate(self, run, sets):
        return {"signal": np.stack([wave(self.runs[run].time, **plain(values)) for values in sets])}

    def shortened(self, share):
        return replace(self, runs=tuple(run_of(run.channels[0].measured, share) for run in self.runs))


def plain(values):
    return {name.partition(".")[0]: value for name, value in values.items()}


def wave(time, level=1.0, first=0.0, second=0.0, idle=0.0):
    return level + first * second * np.sin(1.7 * time) + 1e-6 * idle


def run_of(measured, share=1.0):
    known = TIME[: measured.size]
    time = known[known <= share * known[-1]]
    return Run("run", time, np.sin(0.8 * time), (Channel("signal", time, measured[: time.size]),))


def recorded(**values):
    return wave(TIME, **values) + 0.05 * np.random.default_rng(3).standard_normal(TIME.size)


@pytest.fixture
def small_search(monkeypatch):
    monkeypatch.setattr(together, "POPULATION", 16)
    monkeypatch.setattr(together, "GENERATIONS", 12)


def answered(model, scatter=16):
    floors = [{"signal": NoiseFloor(0.05, "declared")} for _ in model.runs]
    return explain(model, floors=floors, scatter=scatter)


def test_effects_that_close_nothing_alone_are_found_together_and_the_idle_one_is_left_out(small_search):
    answer = answered(Product((run_of(recorded(level=1.2, first=1.5, second=0.8)),)))
    assert set(answer.effects) == {"first", "second"}
    assert answer.parameters["first.size"] * answer.parameters["second.size"] == pytest.approx(1.2, abs=0.02)
    assert "idle.size" not in answer.parameters
    assert answer.ranking[0].parameters == {"first.size": answer.parameters["first.size"]}
    assert answer.with_effect == pytest.approx(1.0, abs=0.1)
    idle = next(entry for entry in answer.ranking if entry.effect == "idle")
    assert not idle.accepted
    assert idle.reasons


def test_one_by_one_the_same_log_is_unknown():
    alone = replace(Product((run_of(recorded(level=1.2, first=1.5, second=0.8)),)), together=())
    assert answered(alone).verdict == "unknown"


def test_a_log_without_effects_is_not_searched(small_search, monkeypatch):
    monkeypatch.setattr(together, "evolve", lambda *_: pytest.fail("searched a log that tuning explains"))
    assert answered(Product((run_of(recorded(level=1.3)),))).verdict == "parameters"


def test_what_follows_the_fitted_part_is_measured_and_never_fitted():
    measured = recorded(level=1.5)
    moved = measured.copy()
    moved[TIME > 40.0] += 0.7
    found: list[Findings] = []
    for signal in (measured, moved):
        whole = Product((run_of(signal),), effects=())
        part = whole.shortened(2.0 / 3.0)
        findings = answered(part, scatter=0).findings
        found.append(findings)
        beyond = look_beyond(whole, findings, 2.0 / 3.0)
        assert beyond.fitted["tuned"]["signal"] == pytest.approx(0.05, rel=0.1)
        assert beyond.fitted["nominal"]["signal"] == pytest.approx(0.5, rel=0.02)
        expected = 0.05 if signal is measured else np.hypot(0.7, 0.05)
        assert beyond.rest["tuned"]["signal"] == pytest.approx(expected, rel=0.1)
        assert beyond.freed == {"nominal": 0, "tuned": 1}
        assert np.sqrt(np.mean(beyond.left["tuned"] ** 2)) == pytest.approx(beyond.whole["tuned"]["signal"])
    assert found[0].tuned.fit.values == found[1].tuned.fit.values


def test_all_of_the_log_fitted_leaves_no_rest():
    whole = Product((run_of(recorded(level=1.5)),), effects=())
    problem = build_problem(whole, [{"signal": NoiseFloor(0.05, "declared")}])
    beyond = look_beyond(whole, start_findings(problem, 0), 1.0)
    assert beyond.rest == {}
    assert beyond.whole == beyond.fitted


@pytest.mark.parametrize("until", [0.0, -0.5, 1.5])
def test_a_share_that_is_none_is_refused(until):
    with pytest.raises(InputError, match="--until"):
        diagnose([], None, until=until)


@pytest.mark.parametrize(("depth", "published"), [(1733, 4444.0), (2235, 4889.0)])
def test_a_field_start_up_is_simulated_better_than_by_the_published_model(shared_data, depth, published):
    """Torque alone: stick-slip's effects are freed together, and with what was found for them the phase holds."""
    log = read_log(shared_data / "field" / f"well_b_{depth}m.mcap")
    model = prepare([log], log.rig()).model
    assert model.together == STICK_SLIP
    assert set(STICK_SLIP) <= {effect.name for effect in model.effects}
    measured = model.runs[0].channels[0].measured
    torque = replace(model, coarse=model.fine).simulate(0, [FOUND[depth]])["surface_torque"][0]
    assert np.sqrt(np.mean((torque - measured) ** 2)) < published
