"""investigation.html: the probability of each explanation from run to run; and investigation.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from slider_drilling.diagnosis.page import VERDICT_TONES
from slider_drilling.diagnosis.to_json import explanation_json
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.investigation.loop import Investigation
from slider_drilling.investigation.round import Round
from slider_drilling.pages import Bars, Chart, Headline, Page, Panel, Section, Table, Tag
from slider_drilling.pages.page import Cell
from slider_drilling.pages.titles import well_name
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import Rig
from slider_drilling.units import Text, displayed, sentence

SCHEMA = "slider_drilling/investigation/1"
_SHOWN = 7  # explanations with a colour of their own; the eighth colour is for the others


def belief_page(investigation: Investigation, rig: Rig) -> Page:
    """The page as plain data."""
    rounds = investigation.rounds
    sections = []
    if rounds:
        sections = [
            Section("Round by round", (_rounds_table(rounds),)),
            Section("Probability of each explanation", (*_belief(rounds),)),
            Section("What could be hidden", (_hidden(rounds),)),
        ]
    last = rounds[-1].answer if rounds else None
    text = f"{investigation.ending[:1].upper()}{investigation.ending[1:]}."
    if last is not None:
        text = f"{last.summary} {text}"
    if investigation.sealed is not None:
        text = f"{text} {sealed_sentence(investigation.sealed)}"
    tone = VERDICT_TONES.get(last.verdict, "bad") if last is not None else "plain"
    label = "waits for a log" if investigation.waits_for is not None else "investigation"
    return Page("Investigation", well_name(rig), tuple(sections), (("logs", str(len(rounds))),),
                Headline(text, tone, label))  # fmt: skip


def sealed_sentence(sealed: Sequence[tuple[str, float]]) -> str:
    """What was hidden in a sealed rig, in one sentence."""
    hidden = " and ".join(f"{plain_name(name)} ({size:.1f} noise floors)" for name, size in sealed)
    return f"Hidden in the sealed rig, with its size in the first log: {hidden}."


def _rounds_table(rounds: tuple[Round, ...]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for each in rounds:
        answer = each.answer
        names = ", ".join(plain_name(name) for name in answer.effects) or "no name"
        took = "-" if each.test is None else f"{each.test.duration:.0f} s"
        rows.append((
            str(each.number), Tag(plain_name(answer.verdict), VERDICT_TONES.get(answer.verdict, "bad")), names,
            answer.still_open or "-", _left(each.open_before), _left(each.open_after), took,
        ))  # fmt: skip
    caption = (
        "Left to find out: 0 where every effect would show at the smallest size that anybody acts on, and no two "
        "explanations look alike."
    )
    header = ("logs", "verdict", "named", "open", "left to find out", "expected after the test", "test takes")
    return Table(header, tuple(rows), caption)


def _left(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _belief(rounds: tuple[Round, ...]) -> tuple[Text | Chart, ...]:
    """The weights of the explanations after each log."""
    beliefs = [{_name(each): each.weight for each in r.answer.explanations} for r in rounds]
    names = sorted(dict.fromkeys(name for own in beliefs for name in own),
                   key=lambda name: -max(own.get(name, 0.0) for own in beliefs))  # fmt: skip
    marks, base = [], np.zeros(len(rounds))
    places = tuple(f"after log {each.number}" for each in rounds)
    shown = {name: np.array([own.get(name, 0.0) for own in beliefs]) for name in names[:_SHOWN]}
    if len(names) > _SHOWN:
        shown["others"] = np.array([sum(own.get(name, 0.0) for name in names[_SHOWN:]) for own in beliefs])
    for name, weights in shown.items():
        marks.append(Bars(name, places, weights, base=base.copy()))
        base = base + weights
    text = "The probability of each explanation that was fitted, by how well it predicts held-out data."
    chart = Chart("Explanations", "", (Panel("probability", tuple(marks), limits=(0.0, 1.02)),))
    return (text, chart, *(why for each in rounds if (why := _why_unnamed(each))))


def _why_unnamed(done: Round) -> str:
    """Why the effects of the likeliest explanation were not all named, in one sentence; empty if they were."""
    answer = done.answer
    if not answer.explanations:
        return ""
    likeliest = max(answer.explanations, key=lambda each: each.weight)
    unnamed = [
        f"{plain_name(name)} ({'; '.join(answer.why_not[name])})"
        for name in likeliest.effects if name not in answer.effects and answer.why_not.get(name)
    ]  # fmt: skip
    return f"Likeliest after log {done.number}, and not named: {', '.join(unnamed)}." if unnamed else ""


def _name(explanation: Explanation) -> str:
    return " and ".join(plain_name(each) for each in explanation.effects) or "calibration alone"


def _hidden(rounds: tuple[Round, ...]) -> Table | Text:
    """By effect, the chance that a usual size would have been named, after each log."""
    planned = [each.number for each in rounds if each.test is not None]
    tests = [{row.name: row for row in each.test.effects} for each in rounds if each.test is not None]
    if not tests:
        return "No test was planned."
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(name for test in tests for name in test):
        own = [test.get(name) for test in tests]
        first = next(row for row in own if row is not None)
        cells = ["named" if row is None else f"{100.0 * row.power_without:.0f} %" for row in own]
        end = "named" if own[-1] is None else f"{100.0 * own[-1].power_with:.0f} %"
        usual = sentence(f"{plain_name(first.parameter)} ", displayed(first.usual, first.unit, 2))
        rows.append((plain_name(name), usual, *cells, end))
    heads = tuple(f"after log {number}" for number in planned)
    caption = (
        "Probability that an effect of a usual size is named: with the logs so far, and with the last test planned"
    )
    return Table(("effect", "usual size", *heads, "with the last test"), tuple(rows), caption)


def investigation_json(investigation: Investigation) -> dict[str, Any]:
    """The tree of investigation.json."""
    waits = investigation.waits_for
    return {
        "schema": SCHEMA,
        "ending": investigation.ending,
        "waits_for": None if waits is None else str(waits),
        "sealed": None if investigation.sealed is None else [
            {"effect": name, "size": size} for name, size in investigation.sealed
        ],
        "rounds": [
            {"number": each.number, "verdict": each.answer.verdict, "effects": list(each.answer.effects),
             "explanations": [explanation_json(one) for one in each.answer.explanations],
             "open_before": each.open_before, "open_after": each.open_after}
            for each in investigation.rounds
        ],
    }  # fmt: skip
