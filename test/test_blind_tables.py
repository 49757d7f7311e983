"""The figures of the page on sealed logs are those of the cases beside it."""

import json
import math

import pytest

from site_build.blind_tables import CASES, PAGE, cases_of, small, written
from slider_drilling.blind.score import Scored

CASE = Scored(
    "a.mcap", "two", ("heave", "stribeck"), 1.5, (1.43219, 1.6), "horizontal", "varied", "effect", ("heave",), (),
    "draw_works", "one of two", False, 0, True, 2.1, math.nan, (math.nan, math.nan), 0.912345, None, None,
    12.3456, 13.0,
)  # fmt: skip


def test_the_small_copy_holds_what_is_counted():
    row = {name: getattr(CASE, name) for name in Scored.__dataclass_fields__}
    row |= {"closed": None, "interval": [None, None], "truth": list(CASE.truth), "sizes": list(CASE.sizes)}
    head = {"schema": "s", "date": "d", "code": "c", "options": {}}
    (kept,) = cases_of(json.loads(small({**head, "cases": [row]})))
    assert kept.sizes == pytest.approx(CASE.sizes, rel=1e-3) and kept.oracle == pytest.approx(CASE.oracle, rel=1e-3)
    assert kept.truth == CASE.truth and kept.named == CASE.named and math.isnan(kept.closed)


def test_the_page_says_what_its_cases_count():
    page = PAGE.read_text(encoding="utf-8")
    assert written(page, json.loads(CASES.read_text(encoding="utf-8"))) == page
