"""report.html: the driller's sentence, then how large, where, which and why, and what to do next."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.diagnosis import sentences
from slider_drilling.diagnosis.diagnose import Diagnosis
from slider_drilling.diagnosis.effect_phrases import display_unit
from slider_drilling.diagnosis.figures import intervals, shape, traces, waterfall, where_charts
from slider_drilling.diagnosis.result import FittedParameter, Outcome
from slider_drilling.log.run_page import log_title as title_of
from slider_drilling.pages import BulletList, Chart, Headline, Page, Quantity, Section, Table, Tag
from slider_drilling.pages.page import Cell, Tone
from slider_drilling.pages.titles import well_name
from slider_drilling.units import SI

_TONES: dict[str, Tone] = {"none": "good", "parameters": "good", "effect": "plain"}
STAGES = {"nominal": "as given", "tuned": "re-tuned", "with_effect": "with what was found"}


def report_page(diagnosis: Diagnosis) -> Page:
    """The page as plain data, for `slider_drilling.pages` to write."""
    outcome = diagnosis.outcome
    sections = [
        *_how_large(outcome), *_where(outcome), *_which(outcome), *_traces(outcome), *_parameters(outcome),
        *_next(diagnosis),
    ]  # fmt: skip
    word = outcome.verdict.replace("_", " ") + (", partial" if outcome.partial else "")
    facts = [
        ("log", ", ".join(Path(log).name for log in diagnosis.logs)),
        ("rig file", f"{diagnosis.rig_source.name} ({diagnosis.rig_source.source})"),
    ]
    if outcome.site is not None:
        facts.append(("site", outcome.site.replace("_", " ")))
    if outcome.runtime:
        facts.append(("took", f"{outcome.runtime:.0f} s"))
    if outcome.counts:
        facts.append(("simulations", f"{outcome.counts['simulations']}"))
    return Page(
        "Where the log and the simulation part", _title(diagnosis),
        (Section("", (diagnosis.sentence,)), *sections), tuple(facts),
        Headline(diagnosis.driller, _TONES.get(outcome.verdict, "bad"), word), diagnosis.remarks,
    )  # fmt: skip


def _title(diagnosis: Diagnosis) -> str:
    logs = [look.log for look in diagnosis.log_checks]
    if not logs:
        return well_name(diagnosis.rig, SI)
    return title_of(logs[0], rig=diagnosis.rig) + (f", and {len(logs) - 1} more" if len(logs) > 1 else "")


def _how_large(outcome: Outcome) -> list[Section]:
    gap = outcome.gap
    if gap is None:
        return []
    about = (
        "E is the RMS difference of measured and simulated, in noise floors: 1 is a perfect model. Every stretch of "
        "the log is scored by parameters that were fitted without it."
    )
    shown: list[str | Chart | Table] = [about, waterfall(gap), _channels(outcome), *_simulated(outcome)]
    shown += sentences.prediction_horizon(outcome)
    return [Section("How large the gap is", tuple(shown))]


def _channels(outcome: Outcome) -> Table:
    gap = outcome.gap
    assert gap is not None
    header = ("channel", "noise by the log", "declared", *STAGES.values())
    rows: list[tuple[Cell, ...]] = []
    for name, errors in gap.rms.items():
        floor = gap.noise_floor.get(name)
        stages = [amount(getattr(errors, stage), errors.unit) for stage in STAGES]
        noise = (None, None) if floor is None else (amount(floor.value, floor.unit), amount(floor.declared, floor.unit))
        rows.append((sentences.plain_name(name), *noise, *stages))
    return Table(header, tuple(rows), "RMS difference by channel")


def _simulated(outcome: Outcome) -> list[Table]:
    heads, rows = simulated_rows(outcome)
    if not rows:
        return []
    seen = "; no fit has seen the rest" if outcome.simulated and outcome.simulated["rest"] else ""
    title = "RMS error of one simulation of the whole log with each stage's parameters, nothing fed back or held out"
    return [Table(heads, rows, title + seen)]


def simulated_rows(outcome: Outcome) -> tuple[tuple[str, ...], tuple[tuple[Cell, ...], ...]]:
    """Heads and rows: errors of one simulation by channel and part of the log, a column a stage."""
    found = outcome.simulated
    if not found:
        return (), ()
    parts = [("whole log", found["whole"])]
    if found["rest"]:
        share = f"{100.0 * found['share']:.0f} %"
        parts = [(f"first {share}, fitted", found["fitted"]), ("the rest, not fitted", found["rest"]), *parts]
    units = {trace.channel: trace.unit for trace in outcome.traces}
    stages = list(found["freed"])
    rows: list[tuple[Cell, ...]] = [("", "parameters fitted", *(found["freed"][stage] for stage in stages))]
    for title, errors in parts:
        for name, unit in units.items():
            rows.append(
                (title, sentences.plain_name(name), *(amount(errors[stage].get(name), unit) for stage in stages))
            )
    return ("part", "channel", *(STAGES[stage] for stage in stages)), tuple(rows)


def _where(outcome: Outcome) -> list[Section]:
    if outcome.where is None:
        return []
    about = "Shares of E² of the re-tuned model. Along the hole: orange asks for more friction there, blue for less."
    return [Section("Where it lies", (about, *where_charts(outcome.where)))]


def _which(outcome: Outcome) -> list[Section]:
    if not outcome.ranking and outcome.shape is None:
        return []
    rows: list[tuple[Cell, ...]] = []
    fitted_ones, others = sentences.fitted_and_others(outcome)
    closes = sentences.share_headers(fitted_ones)
    for one in fitted_ones:
        settings = "; ".join(
            f"{name.rpartition('.')[2].replace('_', ' ')} {_amount_text(fitted)}"
            for name, fitted in one.parameters.items()
        )
        standing = sentences.candidate_status(one)
        tag = Tag(standing, "good") if one.in_answer else Tag("passed", "plain") if one.passed else None
        judged: Cell = tag if one.in_answer else (tag, standing.removeprefix("passed, ")) if tag else standing
        apart = ", ".join(sentences.plain_name(name) for name in one.group)
        rows.append(
            (one.effect.replace("_", " "), one.site.replace("_", " "), *sentences.share_cells(one, closes), settings,
             apart, judged)
        )  # fmt: skip
    header = ("effect", "site", *closes, "fitted", "not told apart from", "standing")
    items: list[str | Table | Chart] = [Table(header, tuple(rows)), *([others] if others else [])]
    figure = intervals(outcome.ranking)
    if figure is not None:
        items.append(figure)
    if outcome.shape is not None:
        items.append(shape(outcome.shape))
    return [Section("Which effect, and why not its rivals", tuple(items))]


def _traces(outcome: Outcome) -> list[Section]:
    if not outcome.traces:
        return []
    about = (
        "One simulation of the whole log with each stage's parameters; below each channel, measured minus simulated."
    )
    return [Section("Measured against simulated", (about, *traces(outcome.traces, STAGES)))]


def _parameters(outcome: Outcome) -> list[Section]:
    rows: list[tuple[Cell, ...]] = []
    for name, fitted in outcome.tuned_parameters.items():
        span = "-" if fitted.interval is None else " to ".join(_text(end, fitted.unit) for end in fitted.interval)
        rows.append((name, amount(fitted.value, fitted.unit), amount(fitted.nominal, fitted.unit), span))
    if not rows:
        return []
    caption = "Where the nominal value is 1 and there is no unit, the value multiplies the rig file's."
    return [Section("Parameters", (Table(("parameter", "value", "nominal", "95 %"), tuple(rows), caption),))]


def _next(diagnosis: Diagnosis) -> list[Section]:
    found = diagnosis.outcome.next_manoeuvre
    items: list[str | BulletList] = []
    if found is not None:
        first, second = (sentences.plain_name(name) for name in found.separates)
        items.append(
            f"To tell {first} from {second}: {found.description}. The two would differ by {found.distance:.1f} noise "
            f"floors there; in this log they differ by {found.distance_now:.1f}."
        )
    if diagnosis.would_help:
        items += ["With more channels more could be told apart:", BulletList(diagnosis.would_help)]
    return [Section("What to do next", tuple(items))] if items else []


def amount(value: float | None, unit: str) -> Quantity:
    """A value of an SI unit as a cell in the unit that is read."""
    read, factor = display_unit(unit)
    return Quantity(None if value is None else value * factor, "" if read == "-" else read)


def _text(value: float, unit: str) -> str:
    told = amount(value, unit)
    assert told.value is not None
    return f"{told.value:.4g} {told.unit}".rstrip()


def _amount_text(fitted: FittedParameter) -> str:
    interval = "" if fitted.interval is None else f" [{', '.join(_text(end, fitted.unit) for end in fitted.interval)}]"
    return _text(fitted.value, fitted.unit) + interval
