"""The table of the page on accuracy is counted from the cases beside it."""

import json
from dataclasses import fields

from site_build.accuracy_table import CASES, COLUMNS, PAGE, fill, keep, table
from slider_drilling.blind.score import ScoredCase

CASE = {
    "log": "a.mcap", "kind": "two", "true_effects": ["heave", "stribeck"], "sizes": [1.43219, 1.6],
    "well": "horizontal", "manoeuvre": "varied", "verdict": "effect", "outcome": "one of two",
    "truth_named": False, "site_correct": True,
    "calibrated_gap": 2.1, "identifiable": True, "interval_holds_oracle": None,
}  # fmt: skip
HEAD = {"options": {}, "code": "c", "date": "d"}


def test_kept_cases_hold_what_is_counted() -> None:
    kept = json.loads(keep({**HEAD, "cases": [CASE]}, {"two effects: both named": [14, 24]}))
    assert kept["cases"][0][kept["columns"].index("sizes")] == [1.432, 1.6]
    assert "| two effects: both named | 0 of 1, 0 % [0, 98] | 14 of 24, 58 % [37, 78] |" in table(kept)


def test_page_table_matches_its_cases() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert fill(page, json.loads(CASES.read_text(encoding="utf-8"))) == page


def test_columns_are_keys_of_a_blind_check() -> None:
    assert {*COLUMNS} <= {field.name for field in fields(ScoredCase)}
