"""Page, figures and tables of a diagnosis show what it found, and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_example import worn_motor

from slider_drilling.diagnosis.figures import intervals, traces, waterfall
from slider_drilling.diagnosis.page import report_page, whole_run_rows
from slider_drilling.diagnosis.ranking_table import (
    CLOSES,
    GAP_AFTER,
    OTHER_RUNS,
    candidate_status_by_number,
    share_cells,
    share_headers,
)
from slider_drilling.diagnosis.result import STAGE_NAMES, ChannelTrace, ClosedShare
from slider_drilling.diagnosis.sentences import technical_summary
from slider_drilling.gap import criteria_table
from slider_drilling.pages import page_html
from slider_drilling.units import FIELD, SI


def test_page_begins_with_the_summary_and_marks_only_the_answer():
    html = page_html(report_page(worn_motor()), SI)
    headline = html.index("The motor gives 24 % less torque")
    assert headline < html.index(technical_summary(worn_motor()).partition("(")[0])
    assert html.count('class="tag good"') == 1
    assert "passed" in html
    assert "own.yaml (given)" in html
    assert "118 deg" in html
    assert "heave: not fitted." in html
    assert "klbf" in page_html(report_page(worn_motor()), FIELD)


def test_no_line_joins_what_is_left_out():
    time = np.concatenate([np.arange(300.0), np.arange(900.0, 1200.0)])
    trace = ChannelTrace(0, "hook_load", "N", time, np.ones(600), {"nominal": np.zeros(600)})
    (chart,) = traces([trace], STAGE_NAMES)
    for line in (line for panel in chart.panels for line in panel.marks):
        assert list(np.flatnonzero(np.isnan(line.y))) == [300]


def test_page_ends_with_the_criteria_table():
    section = report_page(worn_motor()).sections[-1]
    assert section.title == "What an effect must pass before it is named" and section.collapsed
    (table,) = section.items
    assert table.rows == tuple(tuple(row) for row in criteria_table())


def test_interval_of_the_answer_lies_on_the_axis():
    diagnosis = worn_motor()
    best = replace(diagnosis.ranking[0], closed=0.9, interval=(-0.9, 1.3))
    chart = intervals((best, diagnosis.ranking[1]))
    assert chart is not None
    (bars,) = chart.panels[0].marks
    assert chart.x_limits is not None
    assert chart.x_limits[0] < -0.9 < 1.3 < chart.x_limits[1]
    assert bars.base[0] == pytest.approx(-0.9)
    assert "←" not in bars.text[0]
    assert bars.text[1] == "← 0.40 [-2.00, 0.50]"
    assert bars.base[1] == pytest.approx(-0.9)
    assert bars.colours == ("green", "grey")
    assert intervals(diagnosis.ranking[2:]) is None


def test_bar_below_the_null_threshold_is_explained():
    gap = worn_motor().gap
    assert gap.threshold is not None
    within = replace(gap, tuned=0.9 * gap.threshold)
    assert "E does not decide" in waterfall(within, named=True).caption
    assert "E does not decide" not in waterfall(within).caption
    assert "E does not decide" not in waterfall(replace(gap, tuned=1.1 * gap.threshold), named=True).caption
    assert waterfall(replace(gap, threshold=None)).caption == ""


def test_errors_of_fitted_and_unfitted_parts_are_separate():
    headers, rows = whole_run_rows(worn_motor())
    assert headers[:2] == ("part", "channel")
    assert rows[0][2:] == (0, 9, 11)
    assert [row[0] for row in rows[1:]] == [
        "first 50 %, fitted", "first 50 %, fitted", "the rest, not fitted", "the rest, not fitted",
        "whole log", "whole log",
    ]  # fmt: skip


def test_other_runs_have_a_column_with_several_runs():
    diagnosis = worn_motor()
    in_others = replace(diagnosis.ranking[0], other_runs=ClosedShare(0.71, (0.5, 0.83)))
    several = replace(diagnosis, ranking=(in_others, *diagnosis.ranking[1:]))
    headers = share_headers(several.ranking)
    assert headers == (CLOSES, OTHER_RUNS)
    assert [share_cells(ranked, headers) for ranked in several.ranking] == [
        ("0.92 [0.64, 0.97]", "0.71 [0.50, 0.83]"), ("0.40 [-2.00, 0.50]", "-"), ("-", "-"),
    ]  # fmt: skip
    assert f'data-head="{OTHER_RUNS}"' in page_html(report_page(several), SI)
    assert f'data-head="{OTHER_RUNS}"' not in page_html(report_page(diagnosis), SI)
    assert share_headers(diagnosis.ranking) == (CLOSES,)


def test_effect_found_second_names_the_gap_it_closes():
    diagnosis = worn_motor()
    second = replace(diagnosis.ranking[1], known_before=("motor_wear",))
    headers = share_headers((diagnosis.ranking[0], second))
    assert headers == (CLOSES, GAP_AFTER)
    assert share_cells(diagnosis.ranking[0], headers)[1] == "calibration"
    assert share_cells(second, headers)[1] == "motor wear"
    chart = intervals((diagnosis.ranking[0], second))
    assert chart is not None
    assert chart.panels[0].marks[0].x == ("motor wear", "formation change after motor wear")
    assert "gap that this effect leaves" in chart.caption
    assert "gap that this effect leaves" not in intervals(diagnosis.ranking).caption


def test_narrow_table_numbers_its_reasons():
    diagnosis = worn_motor()
    reasons = ["other", "not fitted"]
    assert candidate_status_by_number(diagnosis.ranking[0], reasons) == "in the answer"
    assert candidate_status_by_number(diagnosis.ranking[2], reasons) == "not (2)"
