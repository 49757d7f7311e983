"""report.html: the summary, then how large the gap is, where it lies, which effect causes it, and what to do next."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from slider_drilling.diagnosis.asked_run import asked_items
from slider_drilling.diagnosis.figures import held_share, intervals, shape, traces, waterfall, where_charts
from slider_drilling.diagnosis.ranking_table import candidate_status, share_cells, share_headers, split_by_fitted
from slider_drilling.diagnosis.result import STAGES, Diagnosis, FittedParameter, Gap, RankedEffect
from slider_drilling.diagnosis.sentences import (
    about_shares,
    counted,
    model_error_allowed,
    prediction_horizon,
    remarks_beside_checks,
    summary,
    technical_summary,
)
from slider_drilling.gap import criteria_table
from slider_drilling.log.run_page import log_title
from slider_drilling.pages import BulletList, Chart, Headline, Page, Section, Table, Tag
from slider_drilling.pages.page import Cell, Tone
from slider_drilling.pages.titles import well_name
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Text, displayed, sentence

_ABOUT_E = (
    "E is the RMS of measured minus simulated, relative to the noise: 1 is a perfect model. Every stretch of the log "
    "is scored with parameters that were fitted without it."
)
_ABOUT_E_OF_CHANGE = (
    "E is the RMS of measured minus simulated, relative to what the calibrated model left over the baseline: 1 is a "
    "log like the baseline."
)
VERDICT_TONES: dict[str, Tone] = {"none": "good", "parameters": "good", "effect": "plain"}


def report_page(diagnosis: Diagnosis) -> Page:
    """The page as plain data, for `slider_drilling.pages` to write."""
    sections = [
        *_log_checks(diagnosis), *_how_large(diagnosis), *_when(diagnosis), *_where(diagnosis), *_which(diagnosis),
        *_traces(diagnosis), *_parameters(diagnosis), *_next(diagnosis), *_criteria(diagnosis),
    ]  # fmt: skip
    verdict = plain_name(diagnosis.verdict) + (", interrupted" if diagnosis.interrupted else "")
    # Without a conclusion the headline has said why.
    technical = () if diagnosis.verdict == "inconclusive" else (Section("", (technical_summary(diagnosis),)),)
    headline = Headline(summary(diagnosis), VERDICT_TONES.get(diagnosis.verdict, "bad"), verdict)
    return Page(
        "Sim-to-real gap", _title(diagnosis), (*technical, *sections),
        _facts(diagnosis), headline, remarks_beside_checks(diagnosis),
    )  # fmt: skip


def _title(diagnosis: Diagnosis) -> Text:
    logs = [checked.log for checked in diagnosis.log_checks]
    if not logs:
        return well_name(diagnosis.rig)
    return sentence(log_title(logs[0], diagnosis.rig), f", and {len(logs) - 1} more" if len(logs) > 1 else "")


def _facts(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    facts = [
        ("log", ", ".join(Path(log).name for log in diagnosis.logs)),
        ("rig file", f"{diagnosis.rig_source.name} ({diagnosis.rig_source.source})"),
    ]
    if diagnosis.change is not None:
        earlier = ", ".join(Path(log).name for log in diagnosis.change.baseline)
        same = diagnosis.change.baseline == diagnosis.logs
        facts.insert(1, ("baseline", "the same log, before the change" if same else earlier))
    if diagnosis.site is not None:
        facts.append(("site", plain_name(diagnosis.site)))
    if diagnosis.runtime:
        facts.append(("run time", f"{diagnosis.runtime:.0f} s"))
    if diagnosis.simulations:
        facts.append(("simulations", f"{diagnosis.simulations}"))
    return tuple(facts)


def _log_checks(diagnosis: Diagnosis) -> list[Section]:
    """What was checked before any fit: a table for each log."""
    tables = [
        Table(
            ("check", "result", "found, and done or needed"),
            tuple((row.check, row.result, row.text) for row in checked.rows()),
            Path(checked.log.source).name,
        )
        for checked in diagnosis.log_checks
    ]
    return [Section("Log checks", tuple(tables))] if tables else []


def _how_large(diagnosis: Diagnosis) -> list[Section]:
    gap = diagnosis.gap
    if gap is None:
        return []
    about = _ABOUT_E if diagnosis.change is None else _ABOUT_E_OF_CHANGE
    stages = waterfall(gap, bool(diagnosis.effects), diagnosis.stage_names)
    stages = replace(stages, caption=counted(diagnosis, stages.caption))
    items: list[Text | Chart | Table] = [about, *_feedback(diagnosis), stages, _channels(diagnosis, gap)]
    allowed = model_error_allowed(diagnosis)
    if allowed is not None:
        items.append(allowed)
    items += _whole_runs(diagnosis)
    title = "How large the gap is" if diagnosis.change is None else "How large the difference is"
    return [Section(title, (*items, *prediction_horizon(diagnosis)))]


def _feedback(diagnosis: Diagnosis) -> list[Text]:
    """What is true only while a measured channel is fed back."""
    if diagnosis.fed_back is None:
        return []
    channel = plain_name(diagnosis.fed_back)
    return [
        f"E and the errors by channel are those of runs into which the measured {channel} is fed back weakly: "
        f"predictions from the {channel} measured so far. What a simulation does without it is in the table of free "
        "simulations; the tuned rig file has the parameters whose free simulation is best."
    ]


def _channels(diagnosis: Diagnosis, gap: Gap) -> Table:
    unit = "noise in the log" if diagnosis.change is None else "left over the baseline"
    header = ("channel", unit, "declared noise", *diagnosis.stage_names.values())
    rows: list[tuple[Cell, ...]] = []
    for name, errors in gap.rms.items():
        floor = gap.noise_floor.get(name)
        noise: tuple[Cell, Cell] = (None, None)
        if floor is not None:
            noise = (displayed(floor.value, floor.unit), displayed(floor.declared, floor.unit))
        stages = [displayed(getattr(errors, stage), errors.unit) for stage in STAGES]
        rows.append((plain_name(name), *noise, *stages))
    fed = "" if diagnosis.fed_back is None else f", predicted from the {plain_name(diagnosis.fed_back)} measured so far"
    return Table(header, tuple(rows), f"RMS of measured minus simulated, by channel{fed}")


def _whole_runs(diagnosis: Diagnosis) -> list[Table]:
    headers, rows = whole_run_rows(diagnosis)
    if not rows:
        return []
    unfitted = diagnosis.whole_run_errors is not None and bool(diagnosis.whole_run_errors.rest)
    caption = "RMS error of one free simulation of the whole log with each stage's parameters"
    return [Table(headers, rows, caption + ("; no fit has seen the rest" if unfitted else ""))]


def whole_run_rows(diagnosis: Diagnosis) -> tuple[tuple[str, ...], tuple[tuple[Cell, ...], ...]]:
    """Header and rows: errors of one free simulation by channel and part of the log, one column per stage."""
    errors = diagnosis.whole_run_errors
    if errors is None:
        return (), ()
    parts = [("whole log", errors.whole)]
    if errors.rest:
        share = f"{100.0 * errors.share:.0f} %"
        parts = [(f"first {share}, fitted", errors.fitted), ("the rest, not fitted", errors.rest), *parts]
    units = {trace.channel: trace.unit for trace in diagnosis.traces}
    stages = list(errors.freed)
    rows: list[tuple[Cell, ...]] = [("", "parameters fitted", *(errors.freed[stage] for stage in stages))]
    for title, rms in parts:
        for name, unit in units.items():
            rows.append((title, plain_name(name), *(displayed(rms[stage].get(name), unit) for stage in stages)))
    return ("part", "channel", *(diagnosis.stage_names[stage] for stage in stages)), tuple(rows)


def _when(diagnosis: Diagnosis) -> list[Section]:
    figure = None if diagnosis.change is None else held_share(diagnosis.change)
    return [] if figure is None else [Section("When it began", (figure,))]


def _where(diagnosis: Diagnosis) -> list[Section]:
    if diagnosis.breakdown is None:
        return []
    about = (
        "Shares of E² after calibration. Along the hole: orange stretches need more friction to explain the gap, blue "
        "ones less."
    )
    return [Section("Where the gap lies", (counted(diagnosis, about), *where_charts(diagnosis.breakdown)))]


def _which(diagnosis: Diagnosis) -> list[Section]:
    if not diagnosis.ranking and diagnosis.residual_shape is None:
        return []
    fitted, others = split_by_fitted(diagnosis.ranking)
    closes = share_headers(fitted)
    header = ("effect", "site", *closes, "fitted", "indistinguishable from", "status")
    rows = tuple(_effect_row(ranked, closes) for ranked in fitted)
    items: list[Text | Table | Chart] = [Table(header, rows, about_shares(diagnosis))]
    if others:
        items.append(others)
    changed = diagnosis.change is not None
    figure = intervals(diagnosis.ranking, "blocks of 20 s") if changed else intervals(diagnosis.ranking)
    if figure is not None:
        items.append(replace(figure, caption=counted(diagnosis, figure.caption)))
    if diagnosis.residual_shape is not None:
        items.append(shape(diagnosis.residual_shape))
    return [Section("What has changed" if changed else "Which effect causes it", tuple(items))]


def _effect_row(ranked: RankedEffect, closes: tuple[str, ...]) -> tuple[Cell, ...]:
    settings: list[Text] = []
    for name, fitted in ranked.parameters.items():
        short = plain_name(name.rpartition(".")[2])
        settings += ["; ", sentence(f"{short} ", displayed(fitted.value, fitted.unit, 4), _interval(fitted))]
    status: Cell = candidate_status(ranked)
    if ranked.in_answer:
        status = Tag(candidate_status(ranked), "good")
    elif ranked.passed:
        status = (Tag("passed"), candidate_status(ranked).removeprefix("passed, "))
    group = ", ".join(plain_name(name) for name in ranked.group)
    return (
        plain_name(ranked.effect), plain_name(ranked.site), *share_cells(ranked, closes), sentence(*settings[1:]),
        group, status,
    )  # fmt: skip


def _interval(fitted: FittedParameter) -> Text:
    """The interval of a value, in brackets behind it."""
    if fitted.interval is None:
        return ""
    low, high = (displayed(end, fitted.unit, 4) for end in fitted.interval)
    return sentence(" [", low, ", ", high, "]")


def _traces(diagnosis: Diagnosis) -> list[Section]:
    if not diagnosis.traces:
        return []
    log = "whole log" if diagnosis.change is None else "compared part of the log"
    about = (
        f"One free simulation of the {log} with each stage's parameters; below each channel, measured minus simulated."
    )
    return [Section("Measured and simulated", (about, *traces(diagnosis.traces, diagnosis.stage_names)))]


def _parameters(diagnosis: Diagnosis) -> list[Section]:
    rows: list[tuple[Cell, ...]] = []
    for name, fitted in diagnosis.tuned_parameters.items():
        span: Cell = "-"
        if fitted.interval is not None:
            low, high = (displayed(end, fitted.unit, 4) for end in fitted.interval)
            span = sentence(low, " to ", high)
        rows.append((name, displayed(fitted.value, fitted.unit), displayed(fitted.nominal, fitted.unit), span))
    if not rows:
        return []
    before, caption = "nominal", "A parameter without unit whose nominal value is 1 multiplies the rig file's value."
    if diagnosis.change is not None:
        before, caption = "before", "Before: calibrated to the baseline."
    return [Section("Parameters", (Table(("parameter", "value", before, "95 %"), tuple(rows), caption),))]


def _next(diagnosis: Diagnosis) -> list[Section]:
    items: list[Text | BulletList] = []
    if diagnosis.next_manoeuvre is not None:
        items += asked_items(diagnosis.next_manoeuvre, diagnosis.rig)
    if diagnosis.missing_channels:
        items += ["Channels that this log does not hold would help:", BulletList(diagnosis.missing_channels)]
    return [Section("What to do next", tuple(items))] if items else []


def _criteria(diagnosis: Diagnosis) -> list[Section]:
    """The rules that the engine applies to every effect; a change has others."""
    if not diagnosis.ranking or diagnosis.change is not None:
        return []
    header = ("criterion", "what is tested", "threshold", "message if it fails", "why the criterion exists")
    table = Table(header, tuple(tuple(row) for row in criteria_table()))
    return [Section("What an effect must pass before it is named", (table,), collapsed=True)]
