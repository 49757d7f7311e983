"""The cells of the ranking of effects, for console and page."""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.diagnosis.result import ClosedShare, RankedEffect
from slider_drilling.plain_names import plain_name

# Headers of the columns of shares.
CLOSES, OTHER_RUNS, GAP_AFTER = "closes [95 %]", "in other runs", "of the gap after"


def split_by_fitted(ranking: Sequence[RankedEffect]) -> tuple[list[RankedEffect], str]:
    """The effects that were fitted, and one sentence for the others with the reason; "" without others."""
    fitted = [ranked for ranked in ranking if ranked.parameters]
    others: dict[str, list[str]] = {}
    for ranked in ranking:
        if not ranked.parameters:
            others.setdefault("; ".join(ranked.why_not), []).append(ranked.effect)
    return fitted, " ".join(f"{', '.join(names)}: {why}." for why, names in others.items())


def share_headers(ranking: Sequence[RankedEffect]) -> tuple[str, ...]:
    """Headers of the shares that a ranking has.

    With several runs that is also the share in runs that a fit has not seen; with several effects, what had left the
    gap that the share is of.
    """
    headers = [CLOSES]
    if any(ranked.other_runs is not None for ranked in ranking):
        headers.append(OTHER_RUNS)
    if any(ranked.known_before for ranked in ranking):
        headers.append(GAP_AFTER)
    return tuple(headers)


def share_cells(ranked: RankedEffect, headers: Sequence[str]) -> tuple[str, ...]:
    """The cells below these headers."""
    gap_after = ", ".join(plain_name(name) for name in ranked.known_before) or "calibration"
    cells = {CLOSES: format_share(ranked), OTHER_RUNS: format_share(ranked.other_runs), GAP_AFTER: gap_after}
    return tuple(cells[header] for header in headers)


def format_share(share: RankedEffect | ClosedShare | None) -> str:
    """A closed share with its interval, "-" if unknown."""
    if share is None or share.closed is None:
        return "-"
    interval = "" if share.interval is None else f" [{share.interval[0]:.2f}, {share.interval[1]:.2f}]"
    return f"{share.closed:.2f}{interval}"


def candidate_status(ranked: RankedEffect) -> str:
    """Whether an effect is in the answer, and why not."""
    if ranked.in_answer:
        return _in_the_answer(ranked)
    why = "; ".join(ranked.why_not)
    if ranked.suspected:
        return f"suspected, not named: {why}"
    return f"passed, not in the answer: {why}" if ranked.passed and why else "passed" if ranked.passed else why


def candidate_status_by_number(ranked: RankedEffect, reasons: Sequence[str]) -> str:
    """The same for narrow tables: the reasons by their number in a list."""
    if ranked.in_answer:
        return _in_the_answer(ranked)
    numbers = " ".join(f"({reasons.index(reason) + 1})" for reason in ranked.why_not)
    status = "suspected" if ranked.suspected else "passed" if ranked.passed else "not"
    return f"{status} {numbers}".rstrip()


def _in_the_answer(ranked: RankedEffect) -> str:
    others = " and ".join(plain_name(name) for name in ranked.accepted_with)
    return f"in the answer, together with {others}" if others else "in the answer"
