"""A study as a page, and the page that lists several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from slider_drilling.pages import Chart, Headline, HeatMap, Line, Link, Page, Panel, Section, Table, Tag
from slider_drilling.pages.colours import ORDER
from slider_drilling.paper_studies.study import Claim, Study, display_name
from slider_drilling.paper_studies.study import StudyChart as StudyChart
from slider_drilling.units import SI, Units

# How keys of settings and measurements end that have a unit; the longest first.
_ENDINGS = {
    "_m_per_h": "m/h", "_kn_m": "kN m", "_n_m": "N m", "_kn": "kN", "_n": "N", "_mm": "mm", "_m": "m", "_rad": "rad",
    "_deg": "deg", "_rpm": "rpm", "_hz": "Hz", "_s": "s",
}  # fmt: skip


def drawn(figure: StudyChart | HeatMap) -> Chart | HeatMap:
    """A study's figure as a page's."""
    if isinstance(figure, HeatMap):
        return figure
    lines = tuple(
        Line(one.name, one.x, one.y, "dashed" if one.dashed else "line",
             ORDER[(place if one.colour is None else one.colour) % len(ORDER)])
        for place, one in enumerate(figure.lines)
    )  # fmt: skip
    panel = Panel(figure.y_label, lines, figure.level, figure.log_y, figure.depth_down)
    return Chart(figure.title, figure.x_label, (panel,), x_log=figure.log_x)


def study_page(study: Study, units: Units = SI) -> Page:
    """The page of a study: verdicts, tables and figures."""
    sections = []
    if study.claims:
        header = ("claim", "where", "measured", "verdict")
        rows = tuple((one.claim, one.paper, _measured(one.measured, units), _verdict(one)) for one in study.claims)
        sections.append(Section("What the paper says, and what the model does", (Table(header, rows),)))
    tables = [Table(table.header, table.rows, table.title) for table in study.tables]
    if tables:
        sections.append(Section("", tuple(tables)))
    sections.append(Section("Figures", tuple(drawn(figure) for figure in study.figures)))
    facts = tuple(_fact(name, value, units) for name, value in study.settings.items())
    return Page(study.about, study.title, tuple(sections), facts, _lead(study.claims), study.notes)


def _lead(claims: Sequence[Claim]) -> Headline | None:
    if not claims:
        return None
    failing = [one.claim for one in claims if not one.holds]
    if not failing:
        return Headline("Everything that the paper says of this holds for the model.", "good")
    return Headline(f"{len(claims) - len(failing)} of {len(claims)} claims hold. Not: {' '.join(failing)}", "bad")


def _verdict(claim: Claim) -> tuple[Tag | str, ...]:
    tag = Tag("holds", "good") if claim.holds else Tag("does not hold", "bad")
    return (tag, claim.reason) if claim.reason else (tag,)


def _measured(measured: dict[str, Any], units: Units) -> tuple[str, ...]:
    named = (_named(name, value, units) for name, value in measured.items())
    return tuple(f"{name}, {unit}: {value}" if unit else f"{name}: {value}" for name, unit, value in named)


def _fact(name: str, value: Any, units: Units) -> tuple[str, str]:
    bare, unit, words = _named(name, value, units)
    return bare, f"{words} {unit}".rstrip()


def _named(name: str, value: Any, units: Units) -> tuple[str, str, str]:
    """Name, unit and value, in words: ("axial friction", "kN", "1.20, 3.40")."""
    unit = next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "")
    bare = name if not unit else name[: -len(next(e for e, u in _ENDINGS.items() if u == unit and name.endswith(e)))]
    told = unit if isinstance(value, str) else units.display_unit(unit)
    return display_name(bare), told, _words(value, unit, units)


def _words(value: Any, unit: str, units: Units) -> str:
    if isinstance(value, dict):
        return "; ".join(f"{display_name(str(name))} {_words(one, unit, units)}" for name, one in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_words(one, unit, units) for one in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) and not unit:
        return str(value)
    if not isinstance(value, (int, float)):
        return display_name(str(value))
    told = units.convert(float(value), unit)
    return "0" if abs(told) < 1e-12 else f"{told:.4g}"


def index_page(studies: Sequence[Study]) -> Page:
    """The page that leads to every study's own, beside it."""
    rows = []
    for study in studies:
        holding = sum(one.holds for one in study.claims)
        tone = "good" if holding == len(study.claims) else "bad"
        verdict = Tag(f"{holding} of {len(study.claims)}", tone)  # type: ignore[arg-type]
        failing = tuple(one.claim for one in study.claims if not one.holds)
        rows.append((Link(study.title, f"{study.name}.html"), verdict, failing or ""))
    total = [one for study in studies for one in study.claims]
    holding = sum(one.holds for one in total)
    lead = Headline(f"{holding} of {len(total)} claims of the paper hold for the model.", "plain")
    table = Table(("study", "claims that hold", "claims that do not"), tuple(rows))
    return Page("Studies", "The paper's vibration tools", (Section("", (table,)),), headline=lead)
