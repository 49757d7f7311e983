"""The result of a diagnosis has the final model's values, and a share only of the gap that it closes."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.diagnosis import build_result
from slider_drilling.diagnosis.build_result import rank_effects, rms_by_channel, why_not_in_answer
from slider_drilling.diagnosis.ranking_table import candidate_status


def effect(name: str) -> SimpleNamespace:
    return SimpleNamespace(name=name, site="contact")


def candidate(
    effects: list[SimpleNamespace], closed: float, known: tuple[str, ...] = (), failures: tuple[str, ...] = ()
):
    """A candidate whose newest effect is the last of the effects."""
    return SimpleNamespace(
        effect=effects[-1], closed=closed, interval=(closed - 0.1, closed + 0.1), failures=failures,
        passed=not failures, closed_in_other_runs=None, beside=known,
        fitted=SimpleNamespace(effects=effects, names=tuple(effect.name for effect in effects), score=None),
    )  # fmt: skip


def engine_answer(
    effects: tuple[str, ...], candidates: tuple[SimpleNamespace, ...], accepted: SimpleNamespace, **changes
):
    state = SimpleNamespace(
        current="final", bootstrap=None, calibrated=SimpleNamespace(score=None),
        steps=(SimpleNamespace(accepted=accepted, predicted_gain={}),),
    )  # fmt: skip
    given = {"closed": 0.76, "closed_interval": (0.69, 0.81), "alternative": None, "indistinguishable": {},
             "verdict": "effect", "suspected": (), "withdrawn": ()}  # fmt: skip
    return SimpleNamespace(
        effects=effects,
        candidates=candidates,
        gap_calibrated=28.0,
        null_threshold=3.8,
        state=state,
        free_runs=SimpleNamespace(final="final"),
        **(given | changes),
    )


@pytest.fixture
def parameters(monkeypatch):
    """Fitted parameters stand for the model that they are from."""
    monkeypatch.setattr(build_result, "fitted_parameters", lambda model, prefix="": {f"{prefix}size": model})


def test_effect_in_the_answer_has_the_final_models_parameters(parameters):
    first = candidate([effect("static_aging")], 0.40)
    second = candidate([effect("static_aging"), effect("torque_at_motor")], 0.52, ("static_aging",))
    alone = candidate([effect("heave")], 0.03, failures=("no",))
    answer = engine_answer(("static_aging", "torque_at_motor"), (second, first, alone), second)
    rows = {row.effect: row for row in rank_effects(answer, [])}
    assert rows["torque_at_motor"].parameters == {"torque_at_motor.size": "final"}
    assert rows["heave"].parameters == {"heave.size": alone.fitted}
    assert [rows[name].in_answer for name in ("static_aging", "torque_at_motor", "heave")] == [True, True, False]
    assert (rows["torque_at_motor"].closed, rows["torque_at_motor"].known_before) == (0.52, ("static_aging",))
    assert rows["heave"].closed == 0.03


def test_effects_accepted_together_share_what_they_close(parameters):
    """Three were found together and one was removed: the other two are in the answer."""
    effects = [effect(name) for name in ("stribeck", "static_aging", "torque_at_motor")]
    three = candidate(effects, 0.80, ("heave",))
    answer = engine_answer(("static_aging", "torque_at_motor"), (three,), three)
    rows = {row.effect: row for row in rank_effects(answer, effects)}
    for name in answer.effects:
        assert rows[name].in_answer
        assert rows[name].closed == 0.76
        assert rows[name].known_before == ()
        assert rows[name].parameters == {f"{name}.size": "final"}
    assert rows["static_aging"].accepted_with == ("torque_at_motor",)
    assert rows["torque_at_motor"].accepted_with == ("static_aging",)
    assert candidate_status(rows["static_aging"]) == "in the answer, together with torque at motor"
    assert rows["stribeck"].accepted_with == ()
    assert not rows["stribeck"].in_answer


def test_indistinguishable_effect_is_not_called_worse():
    groups = {"stribeck": ("static_aging",), "heave": ()}
    answer = engine_answer(("stribeck", "heave"), (), None, indistinguishable=groups)
    twin, other = candidate([effect("static_aging")], 0.5), candidate([effect("tortuosity")], 0.5)
    assert why_not_in_answer(twin, answer) == "this log cannot distinguish it from stribeck"
    assert why_not_in_answer(other, answer) == "stribeck and heave explain the same part of the gap better"


def test_withdrawn_effect_says_that_free_runs_are_no_better():
    tried = candidate([effect("stribeck")], 0.5)
    answer = engine_answer((), (), tried, verdict="unknown", withdrawn=("stribeck",))
    assert "a free run is hardly better with it" in why_not_in_answer(tried, answer)


@pytest.mark.parametrize(
    ("verdict", "shorter", "expected"),
    [
        ("parameters", True, "what remains is within the noise"),
        ("unknown", False, "after calibration, the gap does not shrink significantly"),
        ("unknown", True, "a free-form alternative predicts held-out data significantly better"),
    ],
)
def test_reason_without_named_effects_follows_the_verdict(monkeypatch, verdict, shorter, expected):
    failed = () if shorter else ("the gap does not shrink significantly",)
    monkeypatch.setattr(build_result, "failures", lambda *given: failed)
    accepted, other = candidate([effect("stribeck")], 0.5), candidate([effect("static_aging")], 0.5)
    answer = engine_answer((), (), accepted, verdict=verdict)
    assert expected in why_not_in_answer(accepted, answer)
    if verdict == "unknown":
        assert why_not_in_answer(other, answer) == "stribeck fits better but was not confirmed"


def test_suspected_effect_says_so_in_the_ranking(parameters, monkeypatch):
    suspected = candidate([effect("stribeck")], 0.5)
    answer = engine_answer((), (suspected,), suspected, verdict="unknown", suspected=(suspected,))
    monkeypatch.setattr(build_result, "failures", lambda *given: ("leaves more of the gap than it closes",))
    (row,) = rank_effects(answer, ())
    assert row.suspected and candidate_status(row).startswith("suspected, not named")


def test_rms_of_a_channel_is_that_of_all_runs():
    pieces = tuple(
        SimpleNamespace(run=run, name="hook_load", rows=rows, noise=noise, channel=SimpleNamespace(time=time))
        for run, rows, noise, time in ((0, slice(0, 3), 2.0, np.arange(1.0, 4.0)), (1, slice(3, 4), 1.0, np.ones(1)))
    )

    def rms(*counts_from):
        model = SimpleNamespace(runs=[SimpleNamespace(counts_from=since) for since in counts_from])
        return rms_by_channel(SimpleNamespace(pieces=pieces, model=model), np.array([9.0, 1.0, 1.0, 6.0]))

    assert rms(-np.inf, -np.inf) == {"hook_load": pytest.approx(np.sqrt((4.0 * 83.0 + 36.0) / 4))}
    # Of the first run only what was measured from 2 s on, of the second nothing.
    assert rms(2.0, 5.0) == {"hook_load": pytest.approx(2.0)}
    assert rms(5.0, 5.0) == {}
