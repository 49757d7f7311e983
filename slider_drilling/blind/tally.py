"""What a blind check shows in all: counts with their binomial intervals, and what was confused with what."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from slider_drilling.blind.detection import Limit, detection_limit
from slider_drilling.blind.plan import NEAR
from slider_drilling.blind.score import QUIET, Scored

LEFT = 1.2
"""E from which re-tuning has left something to name: a little above what the diagnosis takes for negligible."""


@dataclass(frozen=True)
class Share:
    """count of all; low, high: the exact (Clopper and Pearson) 95 % interval of the chance, None where there is none
    to count."""

    count: int
    of: int
    low: float | None
    high: float | None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return "-"
        percent = 100.0 * self.count / self.of
        return f"{self.count} of {self.of}, {percent:.0f} % [{100.0 * self.low:.0f}, {100.0 * self.high:.0f}]"


def share(of: Iterable[bool | None]) -> Share:
    """How many are true, of those that are not None."""
    known = [bool(one) for one in of if one is not None]
    if not known:
        return Share(0, 0, None, None)
    interval = binomtest(sum(known), len(known)).proportion_ci(0.95, method="exact")
    return Share(sum(known), len(known), float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Spread:
    """Median, 5 % and 95 % of what is finite, None where nothing is."""

    median: float | None
    low: float | None
    high: float | None
    of: int


def spread(values: Iterable[float]) -> Spread:
    finite = [value for value in values if np.isfinite(value)]
    if not finite:
        return Spread(None, None, None, 0)
    low, median, high = (float(value) for value in np.quantile(finite, (0.05, 0.5, 0.95)))
    return Spread(median, low, high, len(finite))


@dataclass(frozen=True)
class Tally:
    """All figures of a blind check.

    right: by kind; named: of the catalogue's effects alone, named or in the top group; named_from_1_5: of those that
    reached 1.5 noise floors, as near as logs are sealed; named_of_left: of those of which re-tuning leaves E of `LEFT`
    and above; named_of_nameable, both_of_nameable: of those, one effect and two, that the oracle names in most repeats;
    told: of those that reached 1.5, named or told as what re-tuning may stand for; both_named,
    both_from_1_5: of two effects both, of all logs and of those where each reached 1.5; false_alarms: effect-free logs
    that were called anything but ``none`` or ``parameters``; bare_names: laws from outside that got a name and nothing
    else; sites: right where one was given; coverage: of the reported 95 % intervals over the oracle's share;
    against_oracle: share closed minus the oracle's; ends: absolute errors m of a bed's ends; by_size (the asked-for
    size nearest to the one reached), by_well, by_manoeuvre, by_lacking: named; alarms_by_lacking: of effect-free logs;
    limits: by effect; confusion: what was said, by truth.
    """

    right: dict[str, Share]
    named: Share
    named_from_1_5: Share
    named_of_left: Share
    named_of_nameable: Share
    told: Share
    both_named: Share
    both_from_1_5: Share
    both_of_nameable: Share
    false_alarms: Share
    bare_names: Share
    sites: Share
    outside_sites: Share
    coverage: Share
    against_oracle: Spread
    ends: Spread
    cpu: Spread
    wall: Spread
    by_size: dict[str, dict[str, Share]]
    by_well: dict[str, Share]
    by_manoeuvre: dict[str, Share]
    by_lacking: dict[str, Share]
    alarms_by_lacking: dict[str, Share]
    limits: dict[str, Limit]
    confusion: dict[str, dict[str, int]]
    outcomes: dict[str, dict[str, int]]


def tally(cases: Sequence[Scored]) -> Tally:
    """Count a blind check's cases."""
    single = [case for case in cases if case.kind == "single"]
    outside = [case for case in cases if case.kind == "outside"]
    free = [case for case in cases if case.kind == "none"]
    double = [case for case in cases if case.kind == "two"]
    effects = sorted({case.truth[0] for case in single})
    asked = sorted({case.size for case in single})
    alone = {name: [case for case in single if case.truth == (name,)] for name in effects}
    kinds = {"single": single, "none": free, "outside": outside, "two": double}
    exact = [case for case in cases if case.covered is not None]
    return Tally(
        right={kind: share(case.right for case in of) for kind, of in kinds.items() if of},
        named=share(case.named_truth for case in single),
        named_from_1_5=share(case.named_truth for case in single if _plain(case)),
        named_of_left=share(case.named_truth for case in single if case.tuned >= LEFT),
        named_of_nameable=share(case.named_truth for case in single if case.nameable),
        told=share(case.named_truth or case.truth[0] in case.instead for case in single if _plain(case)),
        both_named=share(case.named_truth for case in double),
        both_from_1_5=share(case.named_truth for case in double if _plain(case)),
        both_of_nameable=share(case.named_truth for case in double if case.nameable),
        false_alarms=share(case.verdict not in QUIET for case in free),
        bare_names=share(case.outcome == "bare name" for case in outside),
        sites=share(case.site_right for case in (*single, *double)),
        outside_sites=share(bool(case.site_right) for case in outside if case.verdict not in QUIET),
        coverage=share(case.covered for case in exact),
        against_oracle=spread(case.closed - case.oracle for case in exact),
        ends=spread(abs(end) for case in cases for end in case.ends or ()),
        cpu=spread(case.cpu for case in cases),
        wall=spread(case.wall for case in cases),
        by_size={name: _by(of, lambda case: f"{_size(case, asked):g}") for name, of in alone.items()},
        by_well=_by(single, lambda case: case.well),
        by_manoeuvre=_by(single, lambda case: case.manoeuvre),
        by_lacking=_by(single, lambda case: case.lacking),
        alarms_by_lacking={name: share(case.verdict not in QUIET for case in free if case.lacking == name)
                           for name in sorted({case.lacking for case in free})},
        limits={name: detection_limit([case.sizes[0] for case in of], [case.named_truth for case in of])
                for name, of in alone.items()},
        confusion=_counts(cases, lambda case: " + ".join(case.named) or case.verdict),
        outcomes=_counts(cases, lambda case: case.outcome),
    )  # fmt: skip


def _plain(case: Scored) -> bool:
    """Whether each effect in the log reached 1.5 noise floors: some move next to nothing however large they are."""
    return min(case.sizes) >= 1.5 / NEAR


def _size(case: Scored, asked: Sequence[float]) -> float:
    """The asked-for size that is nearest to what the log reached: no law can be made as large as one likes."""
    return min(asked, key=lambda size: abs(np.log(size / max(case.sizes[0], 1e-6))))


def sealed(case: Scored) -> str:
    """What is in a case's log, as `Tally.confusion` and `Tally.outcomes` call it."""
    return " + ".join(sorted(case.truth)) or "none"


def _by(cases: Sequence[Scored], what: Callable[[Scored], str]) -> dict[str, Share]:
    return {key: share(case.named_truth for case in cases if what(case) == key)
            for key in sorted({what(case) for case in cases})}  # fmt: skip


def _counts(cases: Sequence[Scored], what: Callable[[Scored], str]) -> dict[str, dict[str, int]]:
    found: dict[str, dict[str, int]] = {}
    for case in cases:
        row = found.setdefault(sealed(case), {})
        row[what(case)] = row.get(what(case), 0) + 1
    return {truth: dict(sorted(row.items())) for truth, row in sorted(found.items())}


def plain(tree: Any) -> Any:
    """A tree of dataclasses' dictionaries as JSON has it: a number that does not exist is null."""
    if isinstance(tree, dict):
        return {key: plain(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [plain(value) for value in tree]
    return None if isinstance(tree, float) and not np.isfinite(tree) else tree
