"""What the diagnoses of one change agree on: each has more data than the one before, and may contradict it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Began:
    """When a named change began.

    Attributes:
        since: s.
        interval: s, 95 % interval of that.
        kind: ``step`` or ``ramp``.
    """

    since: float
    interval: tuple[float, float]
    kind: str


@dataclass(frozen=True)
class DiagnosedChange:
    """What a diagnosis says of a change.

    Attributes:
        verdict: Of the diagnosis.
        effects: Named.
        group: What it cannot distinguish from the first of them.
        suspected: Without a name.
        site: Where it acts, None if unknown.
        began: When it began, as its size over time shows; None where that shows nothing.
    """

    verdict: str
    effects: tuple[str, ...] = ()
    group: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    site: str | None = None
    began: Began | None = None


def diagnosed_change(answer: Mapping[str, Any]) -> DiagnosedChange:
    """What an answer says, as diagnosis.json has it."""
    group = next((row["group"] for row in answer.get("ranking", ()) if row["in_answer"]), ())
    # A list of names, or of objects with a name.
    suspected = tuple(str(each.get("effect", each)) if isinstance(each, Mapping) else str(each)
                      for each in answer.get("suspected", ()))  # fmt: skip
    return DiagnosedChange(
        answer.get("verdict", ""), tuple(answer.get("effects", ())), tuple(group), suspected, answer.get("site"),
        _began(answer.get("change") or {}),
    )  # fmt: skip


def _began(change: Mapping[str, Any]) -> Began | None:
    if not change.get("dated"):
        return None
    low, high = change["since_interval"]
    return Began(change["since"], (low, high), "ramp" if change["growing"] or change["gradual"] else "step")


class DiagnosesOfChange:
    """The diagnoses of one change so far."""

    def __init__(self) -> None:
        self._earlier: list[DiagnosedChange] = []

    def take(self, answer: Mapping[str, Any]) -> DiagnosedChange:
        """Take one more answer, as diagnosis.json has it; what holds of it beside those before."""
        latest = diagnosed_change(answer)
        change = agreed(self._earlier, latest)
        self._earlier.append(latest)
        return change


def agreed(earlier: Sequence[DiagnosedChange], latest: DiagnosedChange) -> DiagnosedChange:
    """The latest; without its names where no more diagnoses of the change agree with them than name something else.

    Of what it cannot distinguish it names what most diagnoses name.

    Args:
        earlier: Diagnoses of the same change.
        latest: The last one.
    """
    naming = [each for each in (*earlier, latest) if each.effects]
    against = [each for each in naming if not _held(each) & _held(latest)]
    if not latest.effects:
        return latest
    if len(naming) > 2 * len(against):
        return _named_as_by_most(naming, latest)
    names = (*latest.effects, *(name for each in against for name in each.effects), *latest.suspected)
    site = latest.site if all(each.site == latest.site for each in against) else None
    return DiagnosedChange("unknown", suspected=tuple(dict.fromkeys(names)), site=site)


def _named_as_by_most(naming: Sequence[DiagnosedChange], latest: DiagnosedChange) -> DiagnosedChange:
    alike = (latest.effects[0], *latest.group)
    # The first of several as frequent ones: the latest's own.
    best = max(alike, key=lambda name: sum(each.effects[0] == name for each in naming))
    if best == latest.effects[0]:
        return latest
    site = next(each.site for each in naming if each.effects[0] == best)
    others = tuple(name for name in alike if name != best)
    suspected = tuple(dict.fromkeys((*others, *(name for name in latest.suspected if name != best))))
    return DiagnosedChange(latest.verdict, (best, *latest.effects[1:]), others, suspected, site)


def _held(answer: DiagnosedChange) -> set[str]:
    """Names that an answer holds possible as what it names."""
    return {*answer.effects, *answer.group}
