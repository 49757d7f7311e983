"""What the engine answers becomes what is told: the final model's values, and a share only of what closed it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.diagnosis import from_engine
from slider_drilling.diagnosis.sentences import candidate_status
from slider_drilling.gap.evidence.free_forms import FreeFormFit


def test_what_is_told_of_an_effect_in_the_answer_is_the_final_models(monkeypatch):
    """Found beside others only, it has no share of its own: alone it closes another."""
    monkeypatch.setattr(from_engine, "_fitted", lambda explained, prefix: {"of": explained, "named": prefix})
    both = SimpleNamespace(names=("static_aging", "torque_at_motor"))
    beside = SimpleNamespace(
        closed=0.52,
        interval=(0.43, 0.61),
        failures=(),
        passed=True,
        fitted=both,
        closed_in_other_runs=(0.4, (0.1, 0.5)),
        beside=("static_aging",),
    )
    alone = SimpleNamespace(
        closed=0.03,
        interval=(-0.06, 0.13),
        failures=("no",),
        passed=False,
        fitted="alone",
        closed_in_other_runs=None,
        beside=(),
    )
    answer = SimpleNamespace(
        effects=("static_aging", "torque_at_motor"), gap_calibrated=28.0, null_threshold=3.8, alternative=None,
        state=SimpleNamespace(current="final", steps=(SimpleNamespace(accepted=beside),)),
    )  # fmt: skip
    rows = [
        from_engine._candidate(one, SimpleNamespace(name=name, site="contact"), answer, {}, [name])
        for one, name in ((beside, "torque_at_motor"), (alone, "static_aging"), (alone, "heave"))
    ]
    assert [row.parameters["of"] for row in rows] == ["final", "final", "alone"]
    assert [row.closed for row in rows] == [0.52, None, 0.03]
    assert [row.in_answer for row in rows] == [True, True, False]
    assert all(row.together == () for row in rows)
    assert [row.beside for row in rows] == [("static_aging",), (), ()]


def test_what_stayed_of_effects_that_were_found_together_is_told_with_its_parameters(monkeypatch):
    """Three began at once and one proved needless: the other two are in the answer, and share what it closes."""
    monkeypatch.setattr(from_engine, "_fitted", lambda explained, prefix: {f"{prefix}size": 1.0})
    effects = [SimpleNamespace(name=name, site="contact") for name in ("stribeck", "static_aging", "torque_at_motor")]
    three = SimpleNamespace(
        effect=effects[2], closed=0.80, interval=(0.70, 0.85), failures=(), passed=True,
        closed_in_other_runs=(0.7, (0.5, 0.8)),
        beside=("heave",), fitted=SimpleNamespace(effects=effects, names=tuple(effect.name for effect in effects)),
    )  # fmt: skip
    answer = SimpleNamespace(
        effects=("static_aging", "torque_at_motor"), closed=0.76, closed_interval=(0.69, 0.81),
        gap_calibrated=28.0, null_threshold=3.8,
        alternative=None, candidates=(three,), indistinguishable={},
        state=SimpleNamespace(current="final", steps=(SimpleNamespace(accepted=three, predicted_gain={}),)),
    )  # fmt: skip
    rows = {row.effect: row for row in from_engine._ranking(answer, effects)}
    for name in answer.effects:
        assert rows[name].in_answer
        assert rows[name].closed == 0.76
        assert rows[name].beside == ()
        assert rows[name].parameters == {f"{name}.size": 1.0}
    assert rows["static_aging"].together == ("torque_at_motor",)
    assert rows["torque_at_motor"].together == ("static_aging",)
    assert candidate_status(rows["static_aging"]) == "in the answer, together with torque at motor"
    assert rows["stribeck"].together == ()
    assert not rows["stribeck"].in_answer


def test_what_is_not_told_apart_is_not_said_to_be_worse():
    groups = {"stribeck": ("static_aging",), "heave": ()}
    answer = SimpleNamespace(effects=("stribeck", "heave"), indistinguishable=groups, alternative=None)
    like, other = (SimpleNamespace(effect=SimpleNamespace(name=name)) for name in ("static_aging", "tortuosity"))
    assert from_engine._outdone(like, answer) == "this log does not tell it from stribeck"
    assert from_engine._outdone(other, answer) == "what it explains, stribeck and heave explain better"


@pytest.mark.parametrize(
    ("verdict", "shorter", "says"),
    [
        ("parameters", True, "what remains is no more than noise"),
        ("unknown", False, "the gap does not shrink for certain"),
        ("unknown", True, "no law describes foretells more"),
    ],
)
def test_why_what_passed_is_not_in_an_answer_without_names(monkeypatch, verdict, shorter, says):
    """Only where nothing is left is noise the reason."""
    monkeypatch.setattr(from_engine, "shrinks", lambda *scores: shorter)
    one = SimpleNamespace(effect=SimpleNamespace(name="stribeck"), fitted=SimpleNamespace(score=None))
    two = SimpleNamespace(effect=SimpleNamespace(name="static_aging"), fitted=SimpleNamespace(score=None))
    state = SimpleNamespace(
        calibrated=SimpleNamespace(score=None), bootstrap=None, steps=(SimpleNamespace(accepted=one),)
    )  # fmt: skip
    answer = SimpleNamespace(effects=(), alternative=None, verdict=verdict, state=state)
    assert says in from_engine._outdone(one, answer)
    if verdict == "unknown":
        assert from_engine._outdone(two, answer) == "stribeck explains more, and is no cause for certain either"


@pytest.mark.parametrize(
    ("words", "unit", "label"),
    [
        ("friction over depth", "-", "change of friction, share"), ("flow off over time", "-", "flow off, share"),
        ("block off over time", "m", "block off, m"),
        ("standpipe pressure off by an amount that drifts with time", "Pa", "standpipe pressure off, Pa"),
    ],
)  # fmt: skip
def test_a_curve_is_drawn_in_its_unit_and_a_share_is_called_one(words, unit, label):
    y = np.array([0.0, 0.026])
    rival = FreeFormFit("somewhere", words, (), np.array([0.0, 60.0]), "s", y, unit, SimpleNamespace())
    drawn = from_engine._drawn("rest", rival)
    assert drawn.y_label == label
    said = {"m": "rises by 0.026 m a minute", "-": "rises by 2.6 % a minute"}
    assert said.get(unit, "") in drawn.words
