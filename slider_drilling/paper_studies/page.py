"""A study as a page, and the page that lists several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from slider_drilling.pages import Headline, Link, Page, Section, Table, Tag
from slider_drilling.paper_studies.study import Claim, Study, display_name
from slider_drilling.units import SI, Units, format_alike, format_number

# Endings of names of settings and measurements, and their units; longer endings first.
_UNIT_SUFFIXES = {
    "_m_per_h": "m/h", "_kn_m": "kN m", "_n_m": "N m", "_kn": "kN", "_n": "N", "_mm": "mm", "_m": "m", "_rad": "rad",
    "_deg": "deg", "_rpm": "rpm", "_hz": "Hz", "_s": "s",
}  # fmt: skip


def study_page(study: Study, units: Units = SI) -> Page:
    """The page of a study: verdicts, tables and figures."""
    sections = []
    if study.claims:
        header = ("claim", "where", "measured", "verdict")
        rows = tuple(
            (claim.claim, claim.paper, _measured(claim.measured, units), _verdict(claim, units))
            for claim in study.claims
        )
        sections.append(Section("Claims of the paper, and what the model shows", (Table(header, rows),)))
    if study.tables:
        sections.append(Section("", study.tables))
    sections.append(Section("Figures", study.figures))
    facts = tuple(_fact(name, value, units) for name, value in study.settings.items())
    return Page(study.about, study.title, tuple(sections), facts, _headline(study.claims), study.notes)


def _headline(claims: Sequence[Claim]) -> Headline | None:
    if not claims:
        return None
    failing = [claim.claim for claim in claims if not claim.holds]
    if not failing:
        return Headline("All claims of the paper hold for the model.", "good")
    holding = f"{len(claims) - len(failing)} of {len(claims)} claims hold."
    return Headline(f"{holding} These do not: {' '.join(failing)}", "bad")


def _verdict(claim: Claim, units: Units) -> tuple[Tag | str, ...]:
    tag = Tag("holds", "good") if claim.holds else Tag("does not hold", "bad")
    return (tag, units.convert_message(claim.reason)) if claim.reason else (tag,)


def _measured(measured: dict[str, Any], units: Units) -> tuple[str, ...]:
    lines = []
    for name, value in measured.items():
        bare, unit, text = _named(name, value, units)
        head = f"{bare}, {unit}" if unit else bare
        if isinstance(value, dict):  # one line a case
            _, si_unit = _unit_of(name)
            names = (units.convert_message(display_name(str(case))) for case in value)
            texts = (_as_text(item, si_unit, units) for item in value.values())
            lines += [f"{head}:", *(f"\u2003{case}: {text}" for case, text in zip(names, texts, strict=True))]
        else:
            lines.append(f"{head}: {text}")
    return tuple(lines)


def _fact(name: str, value: Any, units: Units) -> tuple[str, str]:
    bare, unit, text = _named(name, value, units)
    return bare, f"{text} {unit}".rstrip()


def _named(name: str, value: Any, units: Units) -> tuple[str, str, str]:
    """Name, unit and value as text: ("axial friction", "kN", "1.20, 3.40")."""
    bare, unit = _unit_of(name)
    shown_unit = unit if isinstance(value, str) else units.display_unit(unit)
    return display_name(bare), shown_unit, _as_text(value, unit, units)


def _unit_of(name: str) -> tuple[str, str]:
    """A name without its ending, and the unit that this stands for."""
    suffix = next((suffix for suffix in _UNIT_SUFFIXES if name.endswith(suffix)), "")
    return name.removesuffix(suffix), _UNIT_SUFFIXES.get(suffix, "")


def _as_text(value: Any, unit: str, units: Units) -> str:
    if isinstance(value, dict):
        return "; ".join(f"{display_name(str(name))} {_as_text(item, unit, units)}" for name, item in value.items())
    if isinstance(value, (list, tuple)):
        numbers = [item for item in value if isinstance(item, (int, float)) and not isinstance(item, bool)]
        if len(numbers) == len(value):
            return ", ".join(format_alike([units.convert(float(item), unit) for item in numbers]))
        return ", ".join(_as_text(item, unit, units) for item in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) and not unit:
        return str(value)
    if not isinstance(value, (int, float)):
        return display_name(str(value))
    return format_number(units.convert(float(value), unit))


def index_page(studies: Sequence[Study]) -> Page:
    """The page that links to every study's own, beside it."""
    rows = []
    for study in studies:
        holding = sum(claim.holds for claim in study.claims)
        tone = "good" if holding == len(study.claims) else "bad"
        verdict = Tag(f"{holding} of {len(study.claims)}", tone)  # type: ignore[arg-type]
        failing = tuple(claim.claim for claim in study.claims if not claim.holds)
        rows.append((Link(study.title, f"{study.name}.html"), verdict, failing or ""))
    claims = [claim for study in studies for claim in study.claims]
    holding = sum(claim.holds for claim in claims)
    headline = Headline(f"{holding} of {len(claims)} claims of the paper hold for the model.", "plain")
    table = Table(("study", "claims that hold", "claims that do not"), tuple(rows))
    return Page("Studies", "The paper's vibration tools", (Section("", (table,)),), headline=headline)
