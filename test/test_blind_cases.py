"""The cases of a blind check, and detection limits."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from slider_drilling.blind.cases import CasePlan, case_from_json, draw_cases
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.detection import detection_limit
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.errors import InputError


def test_longer_plan_starts_with_the_same_cases():
    few, many = draw_cases(CasePlan(), 20), draw_cases(CasePlan(), 300)
    assert many[:20] == few
    assert len({case.file_stem() for case in many}) == 300
    assert not {case.file_stem() for case in draw_cases(CasePlan(seed=2), 300)} & {case.file_stem() for case in many}


def test_twenty_cases_are_balanced():
    cases = draw_cases(CasePlan(seed=7), 20)
    assert Counter(case.kind for case in cases) == {"single": 12, "outside": 3, "none": 3, "two": 2}
    single = [case for case in cases if case.kind == "single"]
    assert len({case.effects for case in single}) == 12
    for what in ("well", "manoeuvre"):
        counts = Counter(getattr(case, what) for case in single)
        assert sorted(counts.values()) == [4, 4, 4]


def test_large_plan_has_every_effect_at_every_size():
    cases = draw_cases(CasePlan(), 510)
    counts = Counter((case.effects[0], case.size) for case in cases if case.kind == "single")
    assert {name for name, _ in counts} == set(CATALOGUE_LAWS)
    assert len(counts) == 3 * len(CATALOGUE_LAWS)
    assert max(counts.values()) - min(counts.values()) <= 1
    outside = Counter(case.effects[0] for case in cases if case.kind == "outside")
    assert set(outside) == set(OUTSIDE_LAWS) and max(outside.values()) - min(outside.values()) <= 1
    assert all(case.size >= 1.5 for case in cases if case.kind == "two")
    assert all(len(case.effects) == 2 for case in cases if case.kind == "two")


def test_at_least_eight_laws_are_outside_the_catalogue():
    assert len(OUTSIDE_LAWS) >= 8 and not set(OUTSIDE_LAWS) & set(CATALOGUE_LAWS)


def test_plan_holds_only_the_names_given():
    cases = draw_cases(CasePlan(effects=("heave", "none"), sizes=(2.0,), wells=("own",), manoeuvres=("steady",)), 9)
    assert {case.effects for case in cases} == {("heave",), ("none",)}
    assert {(case.well, case.manoeuvre) for case in cases} == {("own", "steady")}
    assert {case.size for case in cases} == {0.0, 2.0}


def test_file_name_does_not_reveal_the_case():
    for case in draw_cases(CasePlan(), 40):
        assert set(case.file_stem()) <= set("0123456789abcdef")
        assert case_from_json(case.to_json()) == case


@pytest.mark.parametrize(
    ("keywords", "complaint"),
    [
        ({"effects": ("stribek",)}, "--effects stribek: unknown; use"),
        ({"wells": ("vertical",)}, "--wells vertical: unknown; use horizontal"),
        ({"manoeuvres": ("none",)}, "--manoeuvres none"),
        ({"sizes": (0.0,)}, "--sizes 0.0: each must be 0.05 to 50"),
        ({"sizes": ()}, "--sizes"),
        ({"duration": 10.0}, "--duration 10: must be 60 to 3600 s"),
    ],
)
def test_impossible_plan_is_refused_in_one_line(keywords, complaint):
    with pytest.raises(InputError, match=complaint):
        CasePlan(**keywords)


@pytest.mark.slow
def test_detection_limit_interval_covers_in_95_percent():
    generator = np.random.default_rng(3)
    sizes = np.tile([0.25, 0.5, 1.0, 2.0, 4.0], 8)
    truth, inside = 0.8, 0
    for _ in range(200):
        named = generator.uniform(size=sizes.size) < 1.0 / (1.0 + (truth / sizes) ** 2.5)
        limit = detection_limit(sizes, named)
        low, high = limit.interval
        inside += (low is None or low <= truth) and (high is None or truth <= high)
    assert 183 <= inside <= 199  # 95 % of 200, within three standard deviations


def test_detection_limit_beyond_tried_sizes_is_none():
    always = detection_limit([0.5, 1.5, 4.0] * 3, [True] * 9)
    assert always.size is None and always.interval[0] is None and always.interval[1] < 1.0
    never = detection_limit([0.5, 1.5, 4.0] * 3, [False] * 9)
    assert never.size is None and never.interval[1] is None and never.interval[0] > 2.0
    apart = detection_limit([0.5, 1.5, 4.0] * 3, [False, True, True] * 3)
    assert 0.5 < apart.size < 1.5
    assert detection_limit([], []).size is None


def test_plants_are_foreign_unless_chosen():
    assert {case.plant for case in draw_cases(CasePlan(), 6)} == {"foreign"}
    assert {case.plant for case in draw_cases(CasePlan(plants=("foreign", "model")), 8)} == {"foreign", "model"}


def test_unknown_plant_is_refused():
    with pytest.raises(InputError, match="--plants own: unknown; use foreign, model"):
        CasePlan(plants=("own",))
