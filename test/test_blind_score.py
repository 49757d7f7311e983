"""Scores of the blind check: which diagnoses count as correct."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from slider_drilling.blind.check import as_json, score_answers
from slider_drilling.blind.label import Label, read_label
from slider_drilling.blind.oracle import OracleResult
from slider_drilling.blind.reported_diagnosis import diagnosis_from_json, read_diagnosis
from slider_drilling.blind.score import score
from slider_drilling.blind.totals import count_totals, proportion
from slider_drilling.errors import InputError


def label(kind="single", effects=("stribeck",), sites=(("contact",),), interval=None, size=1.5):
    sizes = tuple(size for _ in effects)
    return Label("a.mcap", kind, effects, sites, size, sizes, "horizontal", "varied", 1, interval, {}, {})


def tree(
    verdict, effects=(), site=None, group=(), closed=0.9, interval=(0.8, 0.95), parameters=None, schema=1, tuned=2.0
):
    ranking = [{"effect": name, "closed": closed, "interval": list(interval), "group": list(group),
                "parameters": parameters or {}} for name in effects]  # fmt: skip
    return {"schema": f"slider_drilling/diagnosis/{schema}", "verdict": verdict, "site": site,
            "effects": list(effects), "gap": {"tuned": tuned, "closed": closed, "closed_interval": list(interval)},
            "ranking": ranking}  # fmt: skip


def scored(of, *arguments, oracle=None, named=None, **keywords):
    return score(of, diagnosis_from_json(tree(*arguments, **keywords), "answer"), OracleResult(oracle, named))


OUTSIDE = {"kind": "outside", "effects": ("washout",), "sites": (("hydraulics", "sensor"),)}
NOTHING = {"kind": "none", "effects": (), "sites": ()}
TWO = {"kind": "two", "effects": ("stribeck", "motor_wear"), "sites": (("contact",), ("motor",))}


@pytest.mark.parametrize(
    ("truth", "said", "outcome"),
    [
        ({}, ("effect", ["stribeck"], "contact"), "correct"),
        ({}, ("effect_and_unknown", ["stribeck"], "contact"), "correct"),
        ({}, ("effect", ["static_aging"], "contact", ["stribeck"]), "correct"),
        ({}, ("effect", ["static_aging"], "contact"), "wrong name"),
        ({}, ("effect", ["stribeck", "motor_wear"], "contact"), "extra name"),
        ({}, ("unknown", [], "contact"), "unknown"),
        ({}, ("parameters",), "missed"),
        ({}, ("inconclusive", ["stribeck"], "contact"), "inconclusive"),
        (NOTHING, ("none",), "correct"),
        (NOTHING, ("parameters",), "correct"),
        (NOTHING, ("unknown", [], "bit"), "false alarm"),
        (NOTHING, ("effect", ["heave"], "draw_works"), "false alarm"),
        (NOTHING, ("inconclusive",), "inconclusive"),
        (OUTSIDE, ("unknown", [], "sensor"), "correct"),
        (OUTSIDE, ("unknown", [], "contact"), "wrong site"),
        (OUTSIDE, ("unknown", [], None), "wrong site"),
        (OUTSIDE, ("effect_and_unknown", ["motor_wear"], "hydraulics"), "correct"),
        (OUTSIDE, ("effect_and_unknown", ["motor_wear"], "motor"), "wrong site"),
        (OUTSIDE, ("effect", ["motor_wear"], "hydraulics"), "false name"),
        (OUTSIDE, ("parameters",), "missed"),
        (TWO, ("effect", ["motor_wear", "stribeck"], "motor"), "correct"),
        (TWO, ("effect", ["stribeck"], "contact"), "one of two"),
        (TWO, ("effect", ["stribeck", "heave"], "contact"), "one of two, extra name"),
        (TWO, ("effect", ["stribeck", "motor_wear", "heave"], "contact"), "extra name"),
        (TWO, ("effect", ["heave"], "draw_works"), "wrong name"),
    ],
)
def test_outcome_follows_verdict_site_and_names(truth, said, outcome):
    verdict, effects, site, group = (*said, *(None,) * (4 - len(said)))
    result = scored(label(**truth), verdict, effects or (), site, group or ())
    assert result.outcome == outcome
    assert result.correct == (outcome == "correct")


def test_group_matches_one_true_effect_only():
    both = label("two", ("stribeck", "static_aging"), (("contact",), ("contact",)))
    assert scored(both, "effect", ["stribeck"], "contact", ["static_aging"]).extra_names == 0
    assert scored(both, "effect", ["stribeck"], "contact", ["static_aging"]).truth_named
    # Named in full: neither is extra, although each is in the other's group.
    assert (
        scored(both, "effect", ["static_aging", "stribeck"], "contact", ["stribeck", "static_aging"]).extra_names == 0
    )


def test_failed_diagnosis_is_never_correct():
    for truth in ({}, NOTHING, OUTSIDE, TWO):
        assert score(label(**truth), None).outcome == "failed"


def test_interval_coverage_needs_exact_names_and_an_oracle():
    assert scored(label(), "effect", ["stribeck"], oracle=0.9).interval_holds_oracle is True
    assert scored(label(), "effect", ["stribeck"], oracle=0.96).interval_holds_oracle is False
    assert scored(label(), "effect", ["stribeck", "heave"], oracle=0.9).interval_holds_oracle is None
    assert scored(label(), "effect", ["static_aging"], group=["stribeck"], oracle=0.9).interval_holds_oracle is True
    assert scored(label(), "effect", ["stribeck"]).interval_holds_oracle is None


@pytest.mark.parametrize("schema", [1, 2, 3])
def test_bed_ends_are_read_from_each_schema(schema):
    values = {"factor": 2.0, "top": 1500.0, "bottom": 1800.0}
    if schema > 1:
        values = {name: {"value": value, "unit": "m", "nominal": 0.0, "interval": None}
                  for name, value in values.items()}  # fmt: skip
    bed = label(effects=("cuttings_bed",), interval=(1520.0, 1790.0))
    found = scored(bed, "effect", ["cuttings_bed"], "contact", parameters=values, schema=schema)
    assert found.bed_end_errors == (-20.0, 10.0)
    assert scored(bed, "unknown", [], "contact", parameters=values, schema=schema).bed_end_errors is None


def test_other_files_are_refused_in_one_line(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    with pytest.raises(InputError, match=r"a\.json: not a diagnosis\.json"):
        read_diagnosis(tmp_path / "a.json")
    with pytest.raises(InputError, match="schema = 'other/1'"):
        diagnosis_from_json({**tree("none"), "schema": "other/1"}, "x")
    (tmp_path / "b.json").write_text('{"schema": "slider_drilling/blind_label/1"}')
    with pytest.raises(InputError, match=r"b\.json: not the label"):
        read_label(tmp_path / "b.json")


def test_proportions_have_exact_binomial_intervals():
    assert proportion([True] * 20).low == pytest.approx(0.8316, abs=1e-4)  # 0.025 ** (1 / 20)
    assert proportion([True] * 20).high == 1.0
    half = proportion([True, False] * 5)
    assert (half.count, half.total) == (5, 10)
    assert (half.low, half.high) == pytest.approx((0.1871, 0.8129), abs=1e-4)
    assert proportion([None, None]).low is None


def test_case_counts_at_the_size_it_reaches():
    asked = [scored(label(size=size), "effect", ["stribeck"], "contact") for size in (0.5, 1.5, 4.0)]
    short = scored(replace(label(size=4.0), sizes=(0.6,)), "parameters")
    found = count_totals([*asked, short])
    assert {size: (one.count, one.total) for size, one in found.by_size["stribeck"].items()} == {
        "0.5": (1, 2), "1.5": (1, 1), "4": (1, 1),
    }  # fmt: skip
    assert (found.named_from_size_1_5.count, found.named_from_size_1_5.total) == (2, 2)


def test_small_effects_do_not_count_as_clear():
    reached = [scored(replace(label(size=1.5), sizes=(size,)), "parameters") for size in (0.1, 1.38, 1.6)]
    pairs = [scored(replace(label(**TWO), sizes=sizes), "effect", ["stribeck"]) for sizes in ((4.0, 0.1), (4.0, 1.6))]
    found = count_totals([*reached, *pairs])
    assert (found.named.total, found.named_from_size_1_5.total, found.named_or_masked.total) == (3, 2, 2)
    assert (found.both_named.total, found.both_from_size_1_5.total) == (2, 1)


def test_totals_count_each_kind_of_case():
    cases = [
        scored(label(size=0.5), "parameters"),
        scored(label(size=1.5), "effect", ["stribeck"], "contact", oracle=0.85),
        scored(label(size=4.0), "effect", ["stribeck", "heave"], "contact"),
        scored(label(**NOTHING), "parameters"),
        scored(label(**NOTHING), "unknown", [], "bit"),
        scored(label(**OUTSIDE), "effect", ["motor_wear"], "motor"),
        scored(label(**OUTSIDE), "unknown", [], "hydraulics"),
        scored(label(**TWO), "effect", ["stribeck"], "contact"),
    ]
    found = count_totals(cases)
    assert (found.named.count, found.named.total) == (2, 3)
    assert (found.named_from_size_1_5.count, found.named_from_size_1_5.total) == (2, 2)
    assert (found.correct["single"].count, found.both_named.count) == (1, 0)
    assert (found.false_alarms.count, found.false_alarms.total) == (1, 2)
    assert (found.false_names.count, found.false_names.total) == (1, 2)
    assert (found.outside_site_correct.count, found.outside_site_correct.total) == (1, 2)
    assert (found.interval_coverage.count, found.interval_coverage.total) == (1, 1)
    assert found.closed_minus_oracle.median == pytest.approx(0.05)
    assert found.confusion["stribeck"] == {"parameters": 1, "stribeck": 1, "stribeck + heave": 1}
    assert found.detection_limits["stribeck"].size == pytest.approx(math.sqrt(0.5 * 1.5), rel=0.3)
    text = json.dumps(as_json(cases, {}), allow_nan=False)
    assert json.loads(text)["totals"]["false_alarms"]["count"] == 1


def test_answers_of_any_origin_are_scored(tmp_path):
    import dataclasses

    labels, answers = tmp_path / "labels", tmp_path / "answers"
    (answers / "two").mkdir(parents=True)
    labels.mkdir()
    for stem in ("one", "two", "three"):
        (labels / f"{stem}.json").write_text(json.dumps(dataclasses.asdict(label())))
    (answers / "one.json").write_text(json.dumps(tree("effect", ["stribeck"], "contact")))
    (answers / "two" / "diagnosis.json").write_text(json.dumps(tree("unknown", [], "contact", schema=2)))
    assert [case.outcome for case in score_answers(labels, answers)] == ["correct", "unknown"]
    with pytest.raises(InputError, match="holds no answer"):
        score_answers(labels, labels / "none")


def test_cases_without_remaining_gap_count_apart():
    cases = [scored(label(), "effect", ["stribeck"], "contact"), scored(label(), "unknown", tuned=1.5),
             scored(label(), "parameters", tuned=1.05)]  # fmt: skip
    found = count_totals(cases)
    assert (found.named_where_gap_remains.count, found.named_where_gap_remains.total) == (1, 2)
    assert (found.named.count, found.named.total) == (1, 3)


def test_identifiable_cases_are_those_the_oracle_names():
    cases = [scored(label(), "effect", ["stribeck"], named=1.0), scored(label(), "parameters", named=2 / 3),
             scored(label(), "parameters", named=1 / 3), scored(label(), "parameters"),
             scored(label(**TWO), "effect", ["stribeck"], named=0.0)]  # fmt: skip
    found = count_totals(cases)
    assert (found.named_where_identifiable.count, found.named_where_identifiable.total) == (1, 2)
    assert found.both_where_identifiable.total == 0 and cases[3].identifiable is None


def test_masked_effects_count_apart_from_named_ones():
    masked = {**tree("parameters", []), "masked_effects": ["stribeck", "heave"]}
    masked = score(label(), diagnosis_from_json(masked, "here"))
    found = count_totals([masked, scored(label(), "parameters")])
    assert masked.outcome == "missed" and masked.masked_effects == ("stribeck", "heave") and not masked.truth_named
    assert (found.named_or_masked.count, found.named_or_masked.total, found.named.count) == (1, 2, 0)
