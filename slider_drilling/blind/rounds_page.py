"""rounds.html: what asking the rig gained, on one page."""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.blind.round_totals import ArmTotals, arm_totals, compare_arms
from slider_drilling.blind.rounds import ArmResult
from slider_drilling.pages import Headline, Page, Section, Table, Tag
from slider_drilling.pages.page import Cell

HEADS = ("after", "cases", "one effect, named", "both of two", "with a wrong name", "false alarms", "correct",
         "over a limit", "largest use of a limit")  # fmt: skip


def arm_cells(arm: ArmTotals) -> tuple[str, ...]:
    """The row of an arm."""
    used = "-" if arm.largest_limit_use is None else f"{100.0 * arm.largest_limit_use:.0f} %"
    shares = (arm.single_named, arm.both_named, arm.extra_names, arm.false_alarms, arm.correct, arm.over_limit)
    return (arm.arm, str(arm.cases), *map(str, shares), used)


def rounds_page(results: Sequence[ArmResult], evidence_only: bool) -> Page:
    """The page.

    Args:
        results: Every case and arm.
        evidence_only: Whether the evidence for the true effects was measured in place of diagnoses.
    """
    arms = arm_totals(results)
    names = [arm.arm for arm in arms]
    first = next((name for name in names if name.startswith("planned")), None)
    others = [name for name in names if not name.startswith("planned")]
    pairs = [compare_arms(results, first, other) for other in others] if first is not None else []
    paired = Table(
        ("after", "missed", "after", "missed", "cases", "only the first", "only the second", "p"),
        tuple((p.first, p.first_missed, p.second, p.second_missed, p.cases, p.only_first_missed, p.only_second_missed,
               p.p_value) for p in pairs),
        "The same cases with effects, in pairs; p by the exact test of McNemar",
    )  # fmt: skip
    by_log: dict[str, dict[str, ArmResult]] = {}
    for each in results:
        by_log.setdefault(each.case.log, {})[each.arm] = each
    rows = tuple(
        (" + ".join(next(iter(own.values())).case.true_effects) or "none", *(_cell(own.get(name)) for name in names))
        for own in by_log.values()
    )
    notes = [
        "Every case is one sealed rig. Its routine log is diagnosed alone, then together with one more "
        "run: planned, a second routine log, a random programme, and the fixed commissioning programme, none of them "
        f"longer than a programme may be{_further(names)}.",
    ]  # fmt: skip
    if evidence_only:
        notes.append(
            "No diagnosis was made: an effect counts as named where the likelihood ratio of the true effects, fitted "
            "in the cheapest simulation, is what a name needs. That is what the logs hold at best; what a foreign "
            "structure does may count as evidence for an effect of the contact, too. The plans did not know the "
            "effects."
        )
    sections = (
        Section("After each run", (Table(HEADS, tuple(arm_cells(arm) for arm in arms),
                                         "Counts, shares and exact binomial 95 % intervals"),)),
        Section("Planned against the others", (paired,)),
        Section("Every case", (Table(("in the log", *names), rows),)),
    )  # fmt: skip
    return Page(
        "Blind check in rounds", f"{len(by_log)} sealed rigs", sections, headline=Headline(_headline(arms)),
        notes=tuple(notes),
    )  # fmt: skip


def _further(arms: Sequence[str]) -> str:
    """What was diagnosed after the first planned run, by the names of the arms."""
    numbers = [name.removeprefix("planned ") for name in arms if name.startswith("planned ")][1:]
    return f"; then with {' and '.join(numbers)} planned runs" if numbers else ""


def _headline(arms: Sequence[ArmTotals]) -> str:
    """After which runs most rigs were diagnosed rightly; all of those that share the first place."""
    if not arms:
        return "No case came to an end."
    shares = [arm.correct.count / max(arm.correct.total, 1) for arm in arms]
    best = [arm for arm, share in zip(arms, shares, strict=True) if share == max(shares)]
    names = [arm.arm for arm in best]
    if len(best) == len(arms) > 1:
        return f"As many correct after each run: {best[0].correct}."
    listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    return f"Most correct after {listed}: {best[0].correct}."


def _cell(result: ArmResult | None) -> Cell:
    if result is None:
        return "-"
    case = result.case
    return (Tag(case.outcome, "good" if case.correct else "bad"), " + ".join(case.named_effects) or case.verdict)
